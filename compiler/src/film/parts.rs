//! What the robot looks like: boxes, cylinders and spheres of its URDF; lines where it states none of these.
use crate::robot::Robot;
use crate::tree::{Placement, Rotation, Tree};
use bipedc_runtime::diagnose::Foot;
use bipedc_runtime::report::{FilmPart, Form, Side};
use roxmltree::Node;
use std::f64::consts::{PI, TAU};

/// Corners of a drawn circle.
const ROUND: usize = 16;
/// Circles of latitude of a drawn sphere.
const LATITUDES: usize = 5;

/// All parts: solids from `<visual>` (else `<collision>`) elements, meshes excepted; a body without any is drawn as lines
/// to what it carries.
pub fn parts(robot: &Robot, tree: &Tree, sides: &[Side]) -> Vec<FilmPart> {
    let side = |body: Option<usize>| body.and_then(|b| sides.get(b)).copied().unwrap_or_default();
    let mut parts: Vec<FilmPart> = Vec::new();
    for (link, form, placement) in solids(&robot.sources.urdf_text) {
        let Some(frame) = tree.links.iter().find(|frame| frame.name == link) else { continue };
        let form = placed(form, &frame.placement.then(&placement));
        parts.push(FilmPart { body: frame.body, side: side(frame.body), form });
    }
    let shapeless =
        |body: usize| !tree.bodies[body].is_virtual && parts.iter().all(|part| part.body != Some(body));
    let size = size(tree);
    let mut more = Vec::new();
    for body in (0..tree.bodies.len()).filter(|&body| shapeless(body)) {
        let lines = lines(tree, body, size).into_iter().chain(sole(tree, body, size));
        more.extend(lines.map(|form| FilmPart { body: Some(body), side: sides[body], form }));
    }
    parts.extend(more);
    parts
}

/// The leg of every body: that of the foot that it carries, if it carries one side alone.
pub fn side_of_bodies(tree: &Tree, feet: &[Foot]) -> Vec<Side> {
    let mut carried = vec![[false; 2]; tree.bodies.len()];
    for point in &tree.points {
        let foot = point.name.split('/').next().unwrap_or_default();
        let left = feet.iter().find(|other| other.name == foot).and_then(|foot| foot.left);
        if let (Some(left), Some(body)) = (left, point.body) {
            tree.path_to_root(body).for_each(|body| carried[body][usize::from(left)] = true);
        }
    }
    let side = |[right, left]: [bool; 2]| match (right, left) {
        (true, false) => Side::Right,
        (false, true) => Side::Left,
        _ => Side::Middle,
    };
    carried.into_iter().map(side).collect()
}

/// Link, shape and its place in the link's frame.
fn solids(urdf: &str) -> Vec<(String, Form, Placement)> {
    // What cannot be read here was read by the front end's more tolerant reader; such robots are drawn as lines.
    let Ok(document) = roxmltree::Document::parse(urdf) else { return Vec::new() };
    let named = |node: &Node<'_, '_>, tag: &str| node.tag_name().name() == tag;
    let mut found = Vec::new();
    for link in document.root_element().children().filter(|node| named(node, "link")) {
        let Some(name) = link.attribute("name") else { continue };
        for tag in ["visual", "collision"] {
            let before = found.len();
            for shape in link.children().filter(|node| named(node, tag)) {
                let part = |tag: &str| shape.children().find(|node| named(node, tag));
                let geometry = part("geometry").and_then(|g| g.first_element_child());
                if let Some(form) = geometry.and_then(form) {
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

fn form(shape: Node<'_, '_>) -> Option<Form> {
    let positive = |name: &str| numbers::<1>(shape, name).map(|[x]| x).filter(|x| *x > 0.0);
    match shape.tag_name().name() {
        "box" => numbers(shape, "size").map(cuboid),
        "sphere" => positive("radius").map(sphere),
        "cylinder" => Some(cylinder(positive("radius")?, positive("length")?)),
        "capsule" => {
            let radius = positive("radius")?;
            Some(cylinder(radius, positive("length")? + 2.0 * radius))
        }
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
