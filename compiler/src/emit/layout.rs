//! What a reader looks for first: what the robot is, where its coordinates stand, which functions there are.
use super::text::{Text, quoted};
use crate::compile::{CompiledModel, Function, distinct, identifier};
use crate::tree::BaseKind;

/// Lengths, names and places of the coordinates.
pub fn constants(compiled: &CompiledModel, text: &mut Text) {
    let tree = &compiled.tree;
    for (name, what, value) in
        [("NQ", "configuration `q`", tree.nq), ("NV", "velocity `v`, and of `a` and `tau`", tree.nv)]
    {
        text.doc("///", &format!("Length of the {what}."));
        text.line(&format!("pub const {name}: usize = {value};"));
    }
    text.doc(
        "///",
        "Elements of the configuration `q`: m, rad; a floating base's quaternion is qx, qy, qz, qw.",
    );
    text.list("pub const Q_NAMES: [&str; NQ] = [", &strings(&tree.coordinate_names()), "];");
    text.doc("///", "Elements of `v`, `a` and `tau`; a floating base's are in its own axes.");
    text.list("pub const V_NAMES: [&str; NV] = [", &strings(&tree.row_names()), "];");
    let joints: Vec<String> = tree.joints.iter().map(|joint| joint.name.clone()).collect();
    text.doc("///", "Joints, in their order in `q` and `v` after the base.");
    text.list(&format!("pub const JOINTS: [&str; {}] = [", joints.len()), &strings(&joints), "];");
    let base_nq = tree.nq - joints.len();
    let names = distinct(joints.iter().map(|joint| identifier(joint).to_uppercase()));
    text.doc("///", "Where each joint stands in `q` and in `v`.");
    text.open("pub mod joint {");
    for (k, (joint, name)) in tree.joints.iter().zip(names).enumerate() {
        text.doc("///", &format!("Index of joint `{}` in (`q`, `v`).", joint.name));
        let name = super::function::ident(&name);
        text.line(&format!("pub const {name}: (usize, usize) = ({}, {});", base_nq + k, joint.v_index));
    }
    text.close("}");
}

fn strings(names: &[String]) -> Vec<String> {
    names.iter().map(|name| quoted(name)).collect()
}

/// Documentation of the crate or module.
pub fn documentation(compiled: &CompiledModel, text: &mut Text) {
    let mut paragraph = |words: &str| {
        text.doc("//!", words);
        text.doc("//!", "");
    };
    paragraph(&format!("Equations of motion of `{}` as allocation-free Rust.", compiled.name));
    paragraph(&robot(compiled));
    paragraph("# Layout");
    let tree = &compiled.tree;
    let base = match tree.base {
        BaseKind::Floating => {
            "The base's position is in world axes, its quaternion x y z w; its velocity is in its own axes, and `a` holds the \
             time derivatives of the elements of `v`. "
        }
        BaseKind::Planar => "The base's x, z and pitch, and their rates, are in world axes. ",
        BaseKind::Fixed | BaseKind::Pivot => "",
    };
    paragraph(&format!("{base}SI units: m, rad, N, N m."));
    paragraph(&format!("`q`, length [`NQ`]: {}.", numbered(&tree.coordinate_names())));
    paragraph(&format!("`v`, `a` and `tau`, length [`NV`]: {}.", numbered(&tree.row_names())));
    if !tree.points.is_empty() {
        let points: Vec<String> = tree.points.iter().map(|point| format!("`{}`", point.name)).collect();
        paragraph(&format!("`forces`: x, y and z, in world axes, at {}.", points.join(", ")));
    }
    paragraph("# Functions");
    paragraph(
        "Each has a twin with `_into` behind its name, which writes its result in place. Comments in the code name the \
         body and the quantity that an expression was derived for first; others may use it too.",
    );
    for family in compiled.functions.chunk_by(|f, g| f.family == g.family) {
        text.doc("//!", &in_the_list(family));
    }
}

fn robot(compiled: &CompiledModel) -> String {
    let tree = &compiled.tree;
    let root = tree.bodies.iter().find(|body| !body.is_virtual).map_or("", |body| body.name.as_str());
    let base = match tree.base {
        BaseKind::Floating => format!("Floating base `{root}`"),
        BaseKind::Planar => format!("Planar base `{root}`"),
        BaseKind::Fixed => "Fixed base".to_owned(),
        BaseKind::Pivot => format!("`{root}` on a pivot"),
    };
    let bodies = tree.bodies.iter().filter(|body| !body.is_virtual).count();
    let mass = (tree.total_mass() * 1e3).round() / 1e3;
    format!(
        "{base}; {bodies} moving bodies, {mass} kg, {} joints, {} contact points.",
        tree.joints.len(),
        tree.points.len()
    )
}

fn numbered(names: &[String]) -> String {
    let one = |(k, name): (usize, &String)| format!("{k}\u{a0}`{name}`");
    if names.is_empty() {
        return "nothing".to_owned();
    }
    names.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
}

/// The functions of a family, as an item of a list.
pub fn in_the_list(family: &[Function]) -> String {
    let links: Vec<String> = family.iter().map(|f| format!("[`{}()`]", f.name)).collect();
    let operations = family.iter().map(|f| f.operations.total());
    let (least, most) = (operations.clone().min().unwrap_or(0), operations.max().unwrap_or(0));
    let operations = if least == most { least.to_string() } else { format!("{least} to {most}") };
    let shape = |f: &Function| (f.rows.len(), f.columns.len());
    let shape = match family.iter().map(shape).collect::<std::collections::BTreeSet<_>>().len() {
        1 => format!("{} × {}, ", family[0].rows.len(), family[0].columns.len()),
        _ => String::new(),
    };
    format!("- {}: {shape}{operations} operations. {}", links.join(", "), family[0].summary)
}
