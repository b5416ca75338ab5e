//! What the robot looks like: boxes, cylinders, spheres and hulls of the meshes of its URDF; lines where it states none.
use super::meshes::mesh;
use bipedc_analysis::report::{FilmPart, Form};
use bipedc_analysis::robot::{Foot, Side};
use bipedc_compiler::robot::Robot;
use bipedc_compiler::tree::{Placement, Rotation, Tree};
use roxmltree::Node;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// What is not seen, as a part of the robot's size.
const SMALL: f64 = 0.01;
/// Corners of a drawn circle.
const ROUND: usize = 16;
/// Circles of latitude of a drawn sphere.
const LATITUDES: usize = 5;

/// All parts: solids from `<visual>` (else `<collision>`) elements, of meshes that are found their convex hull; a body without
/// any is drawn as lines to what it carries, as is a foot whose solids are apart from its joint.
pub fn parts(robot: &Robot, tree: &Tree, sides: &[Option<Side>]) -> Vec<FilmPart> {
    let side = |body: Option<usize>| body.and_then(|b| sides.get(b).copied().flatten());
    let size = size(tree);
    let mut parts: Vec<FilmPart> = Vec::new();
    let folder = robot.sources.urdf_path.parent().unwrap_or(Path::new(""));
    for (link, form, placement) in solids(&robot.sources.urdf_text, folder, ["visual", "collision"]) {
        let Some(frame) = tree.links.iter().find(|frame| frame.name == link) else { continue };
        let form = placed(form, &frame.placement.then(&placement));
        let [low, high] = bounds(form.corners().iter());
        // Contact points as spheres of a millimetre are nothing to see.
        if (0..3).any(|k| high[k] - low[k] > SMALL * size) {
            parts.push(FilmPart { body: frame.body, side: side(frame.body), form });
        }
    }
    let mut more = Vec::new();
    for body in (0..tree.bodies.len()).filter(|&body| !tree.bodies[body].is_virtual) {
        let own = || parts.iter().filter(|part| part.body == Some(body));
        let shapeless = own().next().is_none();
        let sole = if shapeless { sole(tree, body, size) } else { Vec::new() };
        let [low, high] = bounds(own().flat_map(|part| part.form.corners()));
        // A sole below an ankle, with nothing in between.
        let is_last = tree.bodies.iter().all(|child| child.parent != Some(body));
        let apart = is_last && (0..3).any(|k| low[k] > SMALL * size || high[k] < -SMALL * size);
        let lines = if shapeless || apart { lines(tree, body, size) } else { Vec::new() };
        let forms = lines.into_iter().chain(sole);
        more.extend(forms.map(|form| FilmPart { body: Some(body), side: sides[body], form }));
    }
    parts.extend(more);
    parts
}

/// Least and largest coordinates.
pub(super) fn bounds<'a>(corners: impl Iterator<Item = &'a [f64; 3]>) -> [[f64; 3]; 2] {
    corners.fold([[f64::MAX; 3], [f64::MIN; 3]], |[low, high], corner| {
        [[0, 1, 2].map(|k| low[k].min(corner[k])), [0, 1, 2].map(|k| high[k].max(corner[k]))]
    })
}

/// The leg of every body: that of the foot that it carries, if it carries one side alone.
pub fn side_of_bodies(tree: &Tree, feet: &[Foot]) -> Vec<Option<Side>> {
    let mut carried = vec![[false; 2]; tree.bodies.len()];
    for point in &tree.points {
        let foot = point.name.split('/').next().unwrap_or_default();
        let side = feet.iter().find(|other| other.name == foot).and_then(|foot| foot.side);
        if let (Some(side), Some(body)) = (side, point.body) {
            tree.path_to_root(body).for_each(|body| carried[body][usize::from(side == Side::Left)] = true);
        }
    }
    let side = |[right, left]: [bool; 2]| match (right, left) {
        (true, false) => Some(Side::Right),
        (false, true) => Some(Side::Left),
        _ => None,
    };
    carried.into_iter().map(side).collect()
}

/// Link, shape and its place in the link's frame; of the first of these elements that a link has.
pub(super) fn solids(urdf: &str, folder: &Path, tags: [&str; 2]) -> Vec<(String, Form, Placement)> {
    // What cannot be read here was read by the front end's more tolerant reader; such robots are drawn as lines.
    let Ok(document) = roxmltree::Document::parse(urdf) else { return Vec::new() };
    let named = |node: &Node<'_, '_>, tag: &str| node.tag_name().name() == tag;
    let mut found = Vec::new();
    for link in document.root_element().children().filter(|node| named(node, "link")) {
        let Some(name) = link.attribute("name") else { continue };
        for tag in tags {
            let before = found.len();
            for shape in link.children().filter(|node| named(node, tag)) {
                let part = |tag: &str| shape.children().find(|node| named(node, tag));
                let geometry = part("geometry").and_then(|g| g.first_element_child());
                if let Some(form) = geometry.and_then(|shape| form(shape, folder)) {
                    found.push((name.to_owned(), form, part("origin").map_or(Placement::default(), origin)));
                }
            }
            if found.len() > before {
                break;
            }
        }
    }
    found
}

fn numbers<const N: usize>(node: Node<'_, '_>, attribute: &str) -> Option<[f64; N]> {
    let words = node.attribute(attribute)?.split_whitespace();
    let values: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>().ok()?;
    values.try_into().ok().filter(|values: &[f64; N]| values.iter().all(|x| x.is_finite()))
}

fn origin(node: Node<'_, '_>) -> Placement {
    Placement {
        rotation: Rotation::from_rpy(numbers(node, "rpy").unwrap_or_default()),
        translation: numbers(node, "xyz").unwrap_or_default(),
    }
}

fn form(shape: Node<'_, '_>, folder: &Path) -> Option<Form> {
    let positive = |name: &str| numbers::<1>(shape, name).map(|[x]| x).filter(|x| *x > 0.0);
    match shape.tag_name().name() {
        "box" => numbers(shape, "size").map(cuboid),
        "sphere" => positive("radius").map(sphere),
        "cylinder" => Some(cylinder(positive("radius")?, positive("length")?)),
        "capsule" => {
            let radius = positive("radius")?;
            Some(cylinder(radius, positive("length")? + 2.0 * radius))
        }
        "mesh" => mesh(folder, shape.attribute("filename")?, numbers(shape, "scale").unwrap_or([1.0; 3])),
        _ => None,
    }
}

fn cuboid(size: [f64; 3]) -> Form {
    let sign = |bit: usize, k: usize| if bit >> k & 1 == 1 { 0.5 } else { -0.5 };
    let corners = (0..8).map(|bit| [0, 1, 2].map(|k| sign(bit, k) * size[k])).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Form::Solid { corners, faces: faces.map(|face| face.to_vec()).to_vec() }
}

fn circle(radius: f64, height: f64) -> impl Iterator<Item = [f64; 3]> {
    (0..ROUND).map(move |i| {
        let (sine, cosine) = (TAU * i as f64 / ROUND as f64).sin_cos();
        [radius * cosine, radius * sine, height]
    })
}

/// Faces between circles of [`ROUND`] corners, the lowest first, and both ends.
fn lathe(circles: usize) -> Vec<Vec<usize>> {
    let mut faces = vec![(0..ROUND).rev().collect::<Vec<usize>>()];
    for ring in 0..circles - 1 {
        let corner = |row: usize, i: usize| (ring + row) * ROUND + i % ROUND;
        faces
            .extend((0..ROUND).map(|i| vec![corner(0, i), corner(0, i + 1), corner(1, i + 1), corner(1, i)]));
    }
    faces.push(((circles - 1) * ROUND..circles * ROUND).collect());
    faces
}

fn cylinder(radius: f64, length: f64) -> Form {
    let corners = circle(radius, -0.5 * length).chain(circle(radius, 0.5 * length)).collect();
    Form::Solid { corners, faces: lathe(2) }
}

fn sphere(radius: f64) -> Form {
    let ring = |k: usize| {
        let (sine, cosine) = (PI * (k as f64 + 0.5) / LATITUDES as f64).sin_cos();
        circle(radius * sine, -radius * cosine)
    };
    Form::Solid { corners: (0..LATITUDES).flat_map(ring).collect(), faces: lathe(LATITUDES) }
}

fn placed(form: Form, placement: &Placement) -> Form {
    let at = |point: [f64; 3]| placement.then(&Placement::shift(point)).translation;
    match form {
        Form::Solid { corners, faces } => {
            Form::Solid { corners: corners.into_iter().map(at).collect(), faces }
        }
        Form::Bone { ends, width } => Form::Bone { ends: ends.map(at), width },
    }
}

/// How far the bodies are apart at most, along a chain, m.
fn size(tree: &Tree) -> f64 {
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let reach =
        |body: usize| tree.path_to_root(body).map(|b| length(tree.bodies[b].placement.translation)).sum();
    (0..tree.bodies.len()).map(reach).fold(0.1, f64::max)
}

/// From a body's joint to the joints that it carries; else to its contact points or its centre of mass. The base: from its
/// centre of mass.
fn lines(tree: &Tree, index: usize, size: f64) -> Vec<Form> {
    let body = &tree.bodies[index];
    let heaviest = tree.bodies.iter().map(|body| body.inertia.mass).fold(1e-9, f64::max);
    let width = size * (0.015 + 0.03 * (body.inertia.mass.max(0.0) / heaviest).cbrt());
    let mass = body.inertia.mass;
    let center = (mass > 0.0).then(|| body.inertia.first_moment.map(|x| x / mass));
    let is_base = tree.joints.iter().all(|joint| joint.name != body.joint);
    let from = if is_base { center.unwrap_or_default() } else { [0.0; 3] };
    let carried = tree.bodies.iter().filter(|child| child.parent == Some(index));
    let mut ends: Vec<[f64; 3]> = carried.map(|child| child.placement.translation).collect();
    if ends.is_empty() {
        ends.extend(middle(&points(tree, index)).or(center));
    }
    let distinct = ends.into_iter().filter(|end| *end != from);
    distinct.map(|end| Form::Bone { ends: [from, end], width }).collect()
}

fn points(tree: &Tree, body: usize) -> Vec<[f64; 3]> {
    let own = tree.points.iter().filter(|point| point.body == Some(body));
    own.map(|point| point.placement.translation).collect()
}

fn middle(points: &[[f64; 3]]) -> Option<[f64; 3]> {
    let count = points.len() as f64;
    (!points.is_empty()).then(|| [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count))
}

/// The lines around a body's contact points.
fn sole(tree: &Tree, body: usize, size: f64) -> Vec<Form> {
    let mut points = points(tree, body);
    let Some(center) = middle(&points).filter(|_| points.len() > 1) else { return Vec::new() };
    let angle = |p: &[f64; 3]| (p[1] - center[1]).atan2(p[0] - center[0]);
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let edges = if points.len() == 2 { 1 } else { points.len() };
    let edge =
        |i: usize| Form::Bone { ends: [points[i], points[(i + 1) % points.len()]], width: 0.012 * size };
    (0..edges).map(edge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every face of every solid looks outwards: its middle lies further from the solid's middle along its normal.
    #[test]
    fn faces_look_outwards() {
        for form in [cuboid([0.1, 0.2, 0.3]), cylinder(0.1, 0.5), sphere(0.2)] {
            let Form::Solid { corners, faces } = form else { panic!("no solid") };
            for face in &faces {
                let [a, b, c] = [face[0], face[1], face[2]].map(|i| corners[i]);
                let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - b[k]));
                let normal =
                    [0, 1, 2].map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
                let out: f64 = (0..3).map(|k| normal[k] * a[k]).sum();
                assert!(out > 1e-9, "{face:?}");
            }
            // Each edge belongs to two faces, once in each direction: the solid is closed.
            let edge = |face: &Vec<usize>, i: usize| (face[i], face[(i + 1) % face.len()]);
            let edges: Vec<_> = faces.iter().flat_map(|f| (0..f.len()).map(move |i| edge(f, i))).collect();
            assert!(edges.iter().all(|&(a, b)| edges.iter().filter(|e| **e == (b, a)).count() == 1));
        }
    }

    #[test]
    fn shapes_are_read_and_bad_ones_left_out() {
        let urdf = r#"<robot name="r"><link name="a">
            <visual><origin xyz="1 2 3" rpy="0 0 0"/><geometry><box size="1 1 1"/></geometry></visual>
            <visual><geometry><mesh filename="a.stl"/></geometry></visual>
            <visual><geometry><box size="1 nan 1"/></geometry></visual>
            <visual><geometry><cylinder radius="-1" length="2"/></geometry></visual>
            <collision><geometry><sphere radius="1"/></geometry></collision></link>
            <link name="b"><visual><geometry><mesh filename="b.stl"/></geometry></visual>
            <collision><geometry><sphere radius="0.5"/></geometry></collision></link></robot>"#;
        let solids = |urdf, folder| solids(urdf, folder, ["visual", "collision"]);
        let found = solids(urdf, Path::new("/no/such/folder"));
        let names: Vec<&str> = found.iter().map(|(link, ..)| link.as_str()).collect();
        assert_eq!(names, ["a", "b"]);
        assert_eq!(found[0].2.translation, [1.0, 2.0, 3.0]);
        let [low, high] = bounds(found[1].1.corners().iter());
        assert!((high[0] - low[0] - 1.0).abs() < 1e-12, "{low:?} {high:?}");
        assert!(solids("<robot", Path::new("")).is_empty());
    }
}
