//! Collision shapes: only boxes, spheres, cylinders and capsules matter here, to guess where a foot touches.
use super::attributes::{check_numbers, check_sizes, find};
use super::elements::write_origin;
use crate::description::source::{Messages, short};
use roxmltree::Node;
use std::fmt::Write as _;

/// The shapes with measures, and those measures with the count of numbers.
const SHAPES: &[(&str, &[(&str, usize)])] = &[
    ("box", &[("size", 3)]),
    ("sphere", &[("radius", 1)]),
    ("cylinder", &[("radius", 1), ("length", 1)]),
    ("capsule", &[("radius", 1), ("length", 1)]),
];

/// Copies the understood `<collision>` elements among `children`; others are ignored, bad numbers with a
/// warning, because dynamics does not depend on shapes.
pub(super) fn write_collisions(
    children: &[Node<'_, '_>],
    owner: &str,
    out: &mut String,
    messages: &mut Messages<'_>,
) {
    for node in children.iter().filter(|node| node.tag_name().name() == "collision") {
        let parts: Vec<Node<'_, '_>> = node.children().filter(Node::is_element).collect();
        let Some(shape) = find(&parts, "geometry").and_then(|geometry| geometry.first_element_child()) else {
            continue;
        };
        let Some((name, measures)) = SHAPES.iter().find(|(name, _)| *name == shape.tag_name().name()) else {
            continue;
        };
        let problem = measures.iter().find_map(|&(measure, count)| {
            let text = shape.attribute(measure).unwrap_or_default();
            check_numbers(text, count)
                .and_then(|()| check_sizes(text))
                .err()
                .map(|(text, _)| format!("{measure} {text}"))
        });
        if let Some(problem) = problem {
            messages.warning(
                Some(shape.range().start),
                format!("{owner}: collision <{name}> is ignored, its {}", short(&problem)),
                "correct it; it only serves to guess contact points",
            );
            continue;
        }
        out.push_str("<collision>");
        write_origin(find(&parts, "origin"), owner, out, messages);
        let _ = write!(out, "<geometry><{name}");
        for (measure, _) in *measures {
            let _ = write!(out, " {measure}=\"{}\"", shape.attribute(*measure).unwrap_or_default().trim());
        }
        out.push_str("/></geometry></collision>");
    }
}
