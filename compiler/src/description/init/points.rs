//! Where a foot touches the ground: the lowest points of its collision shapes at zero posture.
use crate::description::geometry::{Frame, Vector, add, dot, norm, scale, subtract};
use crate::description::urdf::{Shape, UrdfRobot};

/// Points this little above the lowest one touch the ground as well, m.
const LEVEL: f64 = 0.005;
/// Coordinates are rounded to this, m.
const ROUNDING: f64 = 1e-6;

/// The contact points of a foot in the frame of its link, named; shapes of all links fixed to it count. Where all `pitch`, a sole has no width: its
/// corners are heel and toe.
pub(super) fn contact_points(
    robot: &UrdfRobot,
    frames: &[Frame],
    (link, fixed_to_it): (usize, &[usize]),
    pitch: bool,
) -> Vec<(&'static str, Vector)> {
    let mut points: Vec<Vector> = Vec::new();
    for &other in fixed_to_it {
        for shape in &robot.shapes[other] {
            points.extend(lowest_of(shape, &frames[other]));
        }
    }
    let finite = |point: &Vector| point.iter().all(|x| x.is_finite());
    points.retain(finite);
    if points.is_empty() {
        // A frame called sole lies on the ground; else the lowest frame is better than nothing.
        let sole = robot.links[link].name.to_ascii_lowercase().contains("sole");
        points.push(if sole { frames[link].position } else { lowest_frame(frames, fixed_to_it) });
    }
    let lowest = points.iter().map(|point| point[2]).fold(f64::INFINITY, f64::min);
    points.retain(|point| point[2] <= lowest + LEVEL);
    if pitch {
        let middle = points.iter().map(|point| point[1]).sum::<f64>() / points.len() as f64;
        points.iter_mut().for_each(|point| point[1] = middle);
    }
    let back = frames[link].inverse();
    name(&corners(points)).into_iter().map(|(name, point)| (name, round(back.point(point)))).collect()
}

/// The lowest origin of the links, in the root's frame.
fn lowest_frame(frames: &[Frame], links: &[usize]) -> Vector {
    let origins = links.iter().map(|&link| frames[link].position);
    origins.min_by(|a, b| a[2].total_cmp(&b[2])).unwrap_or([0.0; 3])
}

/// Candidates for the lowest points of a shape, in the root's frame.
fn lowest_of(shape: &Shape, link: &Frame) -> Vec<Vector> {
    use urdf_rs::Geometry::{Box, Capsule, Cylinder, Mesh, Sphere};
    let frame = link.compose(&Frame::of(&shape.origin));
    let down = [0.0, 0.0, -1.0];
    match shape.geometry {
        Box { .. } => {
            let half = shape.half_extents();
            let corner = |i: usize| {
                std::array::from_fn(|axis| if i >> axis & 1 == 0 { half[axis] } else { -half[axis] })
            };
            (0..8).map(|i| frame.point(corner(i))).collect()
        }
        Sphere { radius } => vec![add(frame.position, scale(down, radius))],
        Capsule { radius, length } => ends(&frame, length).map(|end| add(end, scale(down, radius))).to_vec(),
        Cylinder { radius, length } => {
            let axis = frame.direction([0.0, 0.0, 1.0]);
            let sideways = subtract(down, scale(axis, dot(down, axis)));
            if norm(sideways) > 1e-3 {
                let rim = scale(sideways, radius / norm(sideways));
                ends(&frame, length).map(|end| add(end, rim)).to_vec()
            } else {
                let rim = [[radius, 0.0, 0.0], [-radius, 0.0, 0.0], [0.0, radius, 0.0], [0.0, -radius, 0.0]];
                ends(&frame, length).iter().flat_map(|&end| rim.map(|rim| add(end, rim))).collect()
            }
        }
        Mesh { .. } => Vec::new(),
    }
}

fn ends(frame: &Frame, length: f64) -> [Vector; 2] {
    [0.5, -0.5].map(|half| frame.point([0.0, 0.0, half * length]))
}

/// At most four points: the outermost ones towards front left, front right, rear left, rear right.
fn corners(points: Vec<Vector>) -> Vec<Vector> {
    let mut result: Vec<Vector> = Vec::new();
    for [x, y] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let outward = |point: &Vector| x * point[0] + y * point[1];
        let outermost = points.iter().max_by(|a, b| outward(a).total_cmp(&outward(b)));
        if let Some(point) = outermost
            && result.iter().all(|other| norm(subtract(*other, *point)) > 10.0 * ROUNDING)
        {
            result.push(*point);
        }
    }
    result
}

/// Names that say where the points are.
fn name(points: &[Vector]) -> Vec<(&'static str, Vector)> {
    match *points {
        [a] => vec![("point_foot", a)],
        [a, b] if (a[0] - b[0]).abs() >= (a[1] - b[1]).abs() => {
            let (toe, heel) = if a[0] > b[0] { (a, b) } else { (b, a) };
            vec![("heel", heel), ("toe", toe)]
        }
        [a, b] => {
            let (left, right) = if a[1] > b[1] { (a, b) } else { (b, a) };
            vec![("left", left), ("right", right)]
        }
        [a, b, c, d] => vec![("front_left", a), ("front_right", b), ("rear_left", c), ("rear_right", d)],
        _ => ["point_1", "point_2", "point_3"].into_iter().zip(points.iter().copied()).collect(),
    }
}

/// Rounded, and with −0 turned into 0.
fn round(point: Vector) -> Vector {
    point.map(|x| (x / ROUNDING).round() / (1.0 / ROUNDING) + 0.0)
}
