//! A URDF with other inertias and joint friction: everything outside the changed elements stays byte for byte.
use super::xml;
use crate::description::model::Inertial;
use crate::description::source::{Messages, short};
use bipedc_effects::diagnostic::Diagnostic;
use roxmltree::Node;
use std::ops::Range;
use std::path::Path;

/// What a joint's `<dynamics>` says; what is `None` stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointDynamics {
    /// N m s/rad, of joints that slide N s/m.
    pub damping: Option<f64>,
    /// N m, of joints that slide N.
    pub friction: Option<f64>,
}

/// A replacement of some bytes.
type Change = (Range<usize>, String);

/// The text of a URDF in which links and joints have these `<inertial>` and `<dynamics>` elements, new ones where there were
/// none.
///
/// # Errors
/// A text that is no URDF, or a link or joint that it does not have.
pub fn rewritten(
    text: &str,
    file: &Path,
    inertials: &[(String, Inertial)],
    dynamics: &[(String, JointDynamics)],
) -> Result<String, Diagnostic> {
    let broken = || Diagnostic::error("the URDF cannot be read any more").in_file(file);
    // Blanked and renamed parts keep their length: positions in this text are positions in the file.
    let prepared = xml::prepare(text, &mut Messages::new(text, file)).ok_or_else(broken)?;
    let document = xml::parse_xml(&prepared).map_err(|_| broken())?;
    let root = document.root_element();
    let named = |tag: &str, name: &str| {
        let is = |node: &Node<'_, '_>| node.has_tag_name(tag) && node.attribute("name") == Some(name);
        root.children().find(is).ok_or_else(|| {
            Diagnostic::error(format!("the URDF has no {tag} `{}`", short(name))).in_file(file)
        })
    };
    let mut changes: Vec<Change> = Vec::new();
    for (name, inertial) in inertials {
        let link = named("link", name)?;
        changes.push(element(text, link, "inertial", |_, indent| written(inertial, indent)));
    }
    for (name, values) in dynamics {
        let joint = named("joint", name)?;
        changes.push(element(text, joint, "dynamics", |old, _| {
            let kept = |key: &str, value: Option<f64>| {
                let old = old.and_then(|node| node.attribute(key)).map(str::to_owned);
                value.map(|value| value.to_string()).or(old).unwrap_or_else(|| "0".to_owned())
            };
            let (damping, friction) = (kept("damping", values.damping), kept("friction", values.friction));
            format!("<dynamics damping=\"{damping}\" friction=\"{friction}\"/>")
        }));
    }
    Ok(changed(text, changes))
}

/// Only inertias, see [`rewritten`].
///
/// # Errors
/// As [`rewritten`].
pub fn with_inertials(
    text: &str,
    file: &Path,
    inertials: &[(String, Inertial)],
) -> Result<String, Diagnostic> {
    rewritten(text, file, inertials, &[])
}

/// The change that gives a node this child element, in the place of the one that it has or as its last.
fn element(
    text: &str,
    node: Node<'_, '_>,
    tag: &str,
    content: impl Fn(Option<Node<'_, '_>>, &str) -> String,
) -> Change {
    let range = node.range();
    if let Some(old) = node.children().find(|child| child.has_tag_name(tag)) {
        return (old.range(), content(Some(old), &indent(text, old.range().start)));
    }
    let outer = indent(text, range.start);
    let inner = format!("{outer}  ");
    let new = content(None, &inner);
    let whole = &text[range.clone()];
    match whole.rfind("</").filter(|_| !whole.ends_with("/>")) {
        // Before the end tag, on a line of its own.
        Some(at) => {
            let at = range.start + at;
            let before = text[..at].trim_end_matches([' ', '\t']).len();
            let gap = if text[..before].ends_with('\n') { "" } else { "\n" };
            (before..at, format!("{gap}{inner}{new}\n{outer}"))
        }
        None => {
            let tag = node.tag_name().name();
            (range.end - 2..range.end, format!(">\n{inner}{new}\n{outer}</{tag}>"))
        }
    }
}

fn changed(text: &str, mut changes: Vec<Change>) -> String {
    changes.sort_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(text.len() + 64 * changes.len());
    let mut from = 0;
    for (range, new) in changes {
        out.push_str(&text[from..range.start]);
        out.push_str(&new);
        from = range.end;
    }
    out.push_str(&text[from..]);
    out
}

/// White space before the element on its line.
fn indent(text: &str, at: usize) -> String {
    let line = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    text[line..at].chars().take_while(|c| *c == ' ' || *c == '\t').collect()
}

fn written(inertial: &Inertial, indent: &str) -> String {
    let [x, y, z] = inertial.origin.xyz;
    let [roll, pitch, yaw] = inertial.origin.rpy;
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    format!(
        "<inertial>\n{indent}  <origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>\n{indent}  <mass value=\"{}\"/>\n{indent}  <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n{indent}</inertial>",
        inertial.mass
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::model::Pose;

    const URDF: &str = "<?xml version=\"1.0\"?>\n<robot name=\"r\"> <!-- a -- b -->\n  <link name=\"a\">\n\t<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>\n    <visual><geometry><mesh filename=\"ä.stl\"/></geometry></visual>\n  </link>\n  <link name='b'/>\n  <joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n</robot>\n";

    fn new() -> Inertial {
        let origin = Pose { xyz: [0.1, -1e-7, 0.0], rpy: [0.0; 3] };
        Inertial { mass: 2.5, origin, inertia: [0.2, 0.0, -0.05, 0.3, 0.0, 0.4] }
    }

    #[test]
    fn only_the_element_changes() {
        let out = with_inertials(URDF, Path::new("r.urdf"), &[("a".to_owned(), new())]).unwrap();
        let (start, end) = (URDF.find("<inertial>").unwrap(), URDF.find("</inertial>").unwrap());
        assert!(out.starts_with(&URDF[..start]) && out.ends_with(&URDF[end + 11..]));
        assert!(out.contains("<mass value=\"2.5\"/>") && out.contains("xyz=\"0.1 -0.0000001 0\""), "{out}");
        let (read, _) = crate::description::parse(&out, Path::new("r.urdf"), "", Path::new("")).unwrap();
        assert_eq!(read.links[0].inertial, Some(new()));
    }

    #[test]
    fn what_is_missing_is_added_and_what_does_not_exist_is_named() {
        let sliding = JointDynamics { damping: Some(0.25), friction: None };
        let out =
            rewritten(URDF, Path::new("r.urdf"), &[("b".to_owned(), new())], &[("j".to_owned(), sliding)])
                .unwrap();
        assert!(
            out.contains("<link name='b'>\n    <inertial>") && out.contains("    </inertial>\n  </link>"),
            "{out}"
        );
        assert!(out.contains("<dynamics damping=\"0.25\" friction=\"0\"/>\n  </joint>"), "{out}");
        let (read, _) = crate::description::parse(&out, Path::new("r.urdf"), "", Path::new("")).unwrap();
        assert_eq!(read.links[1].inertial, Some(new()));
        // Again: what is there now is replaced, and the other number stays.
        let dry = JointDynamics { damping: None, friction: Some(1.5) };
        let again = rewritten(&out, Path::new("r.urdf"), &[], &[("j".to_owned(), dry)]).unwrap();
        assert!(again.contains("<dynamics damping=\"0.25\" friction=\"1.5\"/>"), "{again}");
        assert_eq!(again.replace("friction=\"1.5\"", "friction=\"0\""), out);
        let error = with_inertials(URDF, Path::new("r.urdf"), &[("c".to_owned(), new())]).unwrap_err();
        assert!(error.message.contains("no link `c`"));
    }
}
