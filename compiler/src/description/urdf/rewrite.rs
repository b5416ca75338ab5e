//! A URDF with other inertias: everything outside the changed `<inertial>` elements stays byte for byte.
use super::xml;
use crate::description::model::Inertial;
use crate::description::source::{Messages, short};
use bipedc_effects::diagnostic::Diagnostic;
use roxmltree::Node;
use std::ops::Range;
use std::path::Path;

/// The text of a URDF in which the `<inertial>` elements of these links are replaced.
///
/// # Errors
/// A text that is no URDF, or a link without an `<inertial>` element.
pub fn with_inertials(
    text: &str,
    file: &Path,
    inertials: &[(String, Inertial)],
) -> Result<String, Diagnostic> {
    let broken = || Diagnostic::error("the URDF cannot be read any more").in_file(file);
    // Blanked and renamed parts keep their length: positions in this text are positions in the file.
    let prepared = xml::prepare(text, &mut Messages::new(text, file)).ok_or_else(broken)?;
    let document = xml::parse_xml(&prepared).map_err(|_| broken())?;
    let mut changes: Vec<(Range<usize>, String)> = Vec::new();
    for (name, inertial) in inertials {
        let is_link = |node: &Node<'_, '_>| node.has_tag_name("link") && node.attribute("name") == Some(name);
        let link = document.root_element().children().find(is_link);
        let element = link.and_then(|link| link.children().find(|node| node.has_tag_name("inertial")));
        let Some(element) = element else {
            return Err(Diagnostic::error(format!(
                "link `{}` has no <inertial> element to change",
                short(name)
            ))
            .in_file(file));
        };
        changes.push((element.range(), written(inertial, &indent(text, element.range().start))));
    }
    changes.sort_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(text.len() + 64 * changes.len());
    let mut from = 0;
    for (range, new) in changes {
        out.push_str(&text[from..range.start]);
        out.push_str(&new);
        from = range.end;
    }
    out.push_str(&text[from..]);
    Ok(out)
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
    fn a_link_without_inertia_is_named() {
        let error = with_inertials(URDF, Path::new("r.urdf"), &[("b".to_owned(), new())]).unwrap_err();
        assert!(error.message.contains("`b`"));
    }
}
