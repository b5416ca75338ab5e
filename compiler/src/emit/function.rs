//! One function: its public faces on nalgebra's matrices, by value and in place.
use super::packed::Packed;
use super::program::{Head, Way, program};
use super::sizes::Size;
use super::text::Text;
use crate::compile::{CompiledModel, Function};
use crate::program::{Paired, schedule_pairs};
use crate::tree::Twins;
use proc_macro2::{Ident, Span};
use quote::format_ident;
use std::collections::BTreeSet;

pub fn ident(name: &str) -> Ident {
    // Names of functions and arguments come from link names: a keyword gets an underscore.
    if syn::parse_str::<Ident>(name).is_ok() {
        Ident::new(name, Span::call_site())
    } else {
        format_ident!("{name}_")
    }
}

/// Functions whose rows are the inertial parameters, which others have as columns.
const PARAMETERS: [&str; 2] = ["inertial_parameters", "base_parameters"];

/// What its rows or columns are: `what` is the word for them.
fn elements(model: &CompiledModel, f: &Function, (what, size): (&str, Size), names: &[String]) -> String {
    let of_v = "all the elements of [`v`](super::V_NAMES)";
    let (first, last) = (names[0].as_str(), names[names.len() - 1].as_str());
    match size {
        Size::Nq => format!("{what}: all the elements of [`q`](super::Q_NAMES), `{first}` to `{last}`"),
        Size::Nv(1) => format!("{what}: {of_v}, `{first}` to `{last}`"),
        Size::Nv(n) => {
            let block = |k: usize| names[k * names.len() / n].split('/').next().unwrap_or_default();
            let blocks: Vec<String> = (0..n).map(|k| format!("`{}/`", block(k))).collect();
            format!("{what}: {}, each before {of_v}", blocks.join(", "))
        }
        Size::Number(_) => {
            let same = |g: &&Function| PARAMETERS.contains(&g.family) && g.name != f.name && g.rows == names;
            if let Some(list) = model.functions.iter().find(same) {
                return format!("{what}: the rows of [`{0}`](fn@super::{0})", list.name);
            }
            let (v, nv) = (model.tree.row_names(), model.tree.nv);
            match names.strip_prefix(v.as_slice()) {
                Some(rest) if nv > 0 => format!("{what}: {of_v}, then {}", listed(rest)),
                _ => format!("{what}: {}", listed(names)),
            }
        }
    }
}

fn listed(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Units of the rows: in their order while that is short.
fn units(f: &Function) -> String {
    let mut units: Vec<&str> = f.row_units.iter().map(String::as_str).collect();
    units.dedup();
    if units.len() <= 6 {
        return units.join(", then ");
    }
    let mut seen = BTreeSet::new();
    units.retain(|unit| seen.insert(*unit));
    units.join(", ")
}

/// `at_once`: pairs of operations that are computed at once.
fn documentation(model: &CompiledModel, f: &Function, at_once: usize, text: &mut Text) {
    text.doc("///", f.summary);
    if let Some(subject) = &f.subject {
        text.doc("///", "");
        text.doc("///", &format!("Of `{subject}`."));
    }
    let (rows, columns) = Size::of_result(model, f);
    text.doc("///", "");
    text.doc("///", &format!("{}; {}.", elements(model, f, ("Rows", rows), &f.rows), units(f)));
    if f.columns.len() > 1 {
        text.doc("///", &format!("{}.", elements(model, f, ("Columns", columns), &f.columns)));
    }
    text.doc("///", &format!("Source: {}.", f.source));
    let pairs = match at_once {
        0 => String::new(),
        count => format!(" For two limbs at once: {count} pairs of them."),
    };
    text.doc("///", &format!("{}.{pairs}", f.operations));
    for note in &f.notes {
        text.doc("///", "");
        text.doc("///", note);
    }
}

/// Of each function, how many pairs of its operations are computed at once, for two limbs of the same make.
pub fn pairs_at_once(compiled: &CompiledModel) -> Vec<usize> {
    let twins = Twins::of(&compiled.tree);
    let pairs = |f: &Function| Paired::new(&f.program, &twins).pairs.iter().flatten().count();
    compiled.functions.iter().map(pairs).collect()
}

/// Instructions from which on an order by pairs gains: fewer of them find registers in any order. Nor does it where a program is cut
/// into parts, which hand on what is alive.
const MANY: usize = 300;

/// The program and its public functions on nalgebra's static matrices.
pub fn function(model: &CompiledModel, way: &Way<'_>, f: &Function, text: &mut Text) {
    let mut paired = Paired::new(&f.program, way.twins);
    let worth_it = (MANY..=way.limit).contains(&paired.program.instructions.len());
    if f.by_pairs && worth_it && paired.pairs.iter().any(Option::is_some) {
        schedule_pairs(&mut paired);
    }
    let Paired { program: ordered, pairs } = paired;
    let f = &Function { program: ordered, ..f.clone() };
    let at_once = pairs.iter().flatten().count();
    documentation(model, f, at_once, text);
    let Some(packed) = Packed::of(f) else {
        public(model, f, str::to_owned, text);
        return program(model, way, f, &pairs, text);
    };
    let entries = &packed.entries;
    text.doc("///", "");
    text.doc(
        "///",
        &format!("Most entries are always zero: [`{}`] computes the others alone.", entries.name),
    );
    public(model, f, str::to_owned, text);
    packed.documentation(f, text);
    public(
        model,
        entries,
        |out| {
            let entries = out.replacen("&mut ", "", 1);
            // A place that is not there would be a fault of the compiler; code on a robot has no branch that panics.
            format!("|k, x| if let Some(entry) = {entries}[0].get_mut(k) {{ *entry = x }}")
        },
        text,
    );
    packed.sparsity(model, f, text);
    packed.dense(model, f, text);
    program(model, way, entries, &pairs, text);
}

/// By value, and in place; `stored`: how the program is told to write into such an `&mut …`.
fn public(model: &CompiledModel, f: &Function, stored: impl Fn(&str) -> String, text: &mut Text) {
    let (rows, columns) = Size::of_result(model, f);
    let matrix = format!("SMatrix<R, {}, {}>", rows.generic(), columns.generic());
    let mut parameters: Vec<String> = f
        .program
        .arguments()
        .map(|a| format!("{}: &SVector<R, {}>", a.name(), Size::of(model, a).generic()))
        .collect();
    let passed = |out: &str| -> Vec<String> {
        let arguments = f.program.arguments().map(|a| format!("&{}.data.0[0]", a.name()));
        arguments.chain([stored(out)]).collect()
    };
    let call = format!("{}_program(", f.name);
    let (name, into) = (&f.name, format!("{}_into", f.name));
    let result = format!(" -> {matrix}");
    text.line("#[inline]");
    Head { visibility: "pub ", name, parameters: parameters.clone(), result: &result }.open(text);
    text.line(&format!("let mut out = [[R::constant(0.0); {rows}]; {columns}];"));
    text.list(&call, &passed("&mut out"), ");");
    text.line("SMatrix::from_array_storage(ArrayStorage(out))");
    text.close("}");
    text.line("");
    text.doc("///", &format!("[`{name}`] in place: large results are costly to move."));
    text.line("#[inline]");
    parameters.push(format!("out: &mut {matrix}"));
    Head { visibility: "pub ", name: &into, parameters, result: "" }.open(text);
    text.list(&call, &passed("&mut out.data.0"), ");");
    text.close("}");
    text.line("");
}
