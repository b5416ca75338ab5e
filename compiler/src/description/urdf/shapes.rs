//! Collision shapes: only boxes, spheres, cylinders and capsules matter here, to guess where a foot touches.
use super::attributes::{find, numbers, of_possible_size};
use super::elements::read_origin;
use crate::description::source::{Messages, short};
use roxmltree::Node;
use urdf_rs::{Collision, Geometry, Vec3};

/// The understood `<collision>` elements among `children`; others are ignored, bad numbers with a warning, because
/// dynamics does not depend on shapes.
pub(super) fn read_collisions(
    children: &[Node<'_, '_>],
    owner: &str,
    messages: &mut Messages<'_>,
) -> Vec<Collision> {
    let mut collisions = Vec::new();
    for node in children.iter().filter(|node| node.tag_name().name() == "collision") {
        let parts: Vec<Node<'_, '_>> = node.children().filter(Node::is_element).collect();
        let Some(shape) = find(&parts, "geometry").and_then(|geometry| geometry.first_element_child()) else {
            continue;
        };
        match read_geometry(shape) {
            Ok(Some(geometry)) => {
                let origin = read_origin(find(&parts, "origin"), owner, messages);
                collisions.push(Collision { name: None, origin, geometry });
            }
            Ok(None) => {}
            Err(problem) => messages.warning(
                Some(shape.range().start),
                format!(
                    "{owner}: collision <{}> is ignored, its {}",
                    shape.tag_name().name(),
                    short(&problem)
                ),
                "correct it; it only serves to guess contact points",
            ),
        }
    }
    collisions
}

/// A shape with measures; `None` for meshes and what is unknown, a measure that cannot be read in words.
fn read_geometry(shape: Node<'_, '_>) -> Result<Option<Geometry>, String> {
    Ok(Some(match shape.tag_name().name() {
        "box" => Geometry::Box { size: Vec3(measures(shape, "size")?) },
        "sphere" => Geometry::Sphere { radius: measure(shape, "radius")? },
        "cylinder" => {
            Geometry::Cylinder { radius: measure(shape, "radius")?, length: measure(shape, "length")? }
        }
        "capsule" => {
            Geometry::Capsule { radius: measure(shape, "radius")?, length: measure(shape, "length")? }
        }
        _ => return Ok(None),
    }))
}

fn measure(shape: Node<'_, '_>, name: &str) -> Result<f64, String> {
    measures::<1>(shape, name).map(|[value]| value)
}

fn measures<const N: usize>(shape: Node<'_, '_>, name: &str) -> Result<[f64; N], String> {
    let text = shape.attribute(name).unwrap_or_default();
    let read = numbers(text).and_then(|values| of_possible_size(values, text));
    read.map_err(|(problem, _)| format!("{name} {problem}"))
}
