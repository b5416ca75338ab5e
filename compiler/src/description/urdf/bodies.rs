//! Physical sense of masses and inertias, link by link and of the bodies that fixed joints make of them.
use super::joints::odd_angle;
use super::{Shape, Tree, UrdfRobot};
use crate::description::geometry::{
    Frame, Matrix, Moments, Vector, eigenvalues, inertia_matrix, norm, scale,
};
use crate::description::model::Inertial;
use crate::description::source::{Messages, Place, list_names, short};
use std::fmt::Write as _;

/// An eigenvalue this far below zero, relative to the largest, is more than rounding: CAD programs export
/// inertias with as few as five digits, and thin plates and rods have principal moments near zero.
const INDEFINITE: f64 = 1e-4;
/// How far the triangle inequality may be violated by rounding, relative to the largest moment.
const TRIANGLE: f64 = 1e-4;
/// A distance no walking robot has, m.
const FAR: f64 = 10.0;
/// A body this many times heavier than all others together is suspect.
const HEAVY: f64 = 10.0;
/// A radius of gyration this many times larger than the body is suspect.
const WIDE: f64 = 10.0;
/// The size of a body of which nothing is known, m.
const SMALLEST_SIZE: f64 = 0.02;

/// Links that fixed joints hold together.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// The link whose joint moves the body (or the root), then those fixed to it.
    pub(crate) links: Vec<usize>,
    /// The joint that moves it; `None` for the root's.
    pub(crate) joint: Option<usize>,
    /// Sum of all links, in the frame of the first.
    pub(crate) moments: Moments,
    /// Whether other bodies hang on it.
    pub(crate) has_children: bool,
    /// Largest known distance of anything on it from its origin, m; infinite when the shapes are not known.
    pub(crate) size: f64,
}

/// Lumps fixed joints; the root's body is the first.
pub(crate) fn bodies(robot: &UrdfRobot, tree: &Tree) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    let mut body_of = vec![0; robot.links.len()];
    let mut frames = vec![Frame::IDENTITY; robot.links.len()];
    for &link in &tree.order {
        let above = tree.above[link];
        match above.filter(|&(joint, _)| !robot.joints[joint].kind.moves()) {
            Some((joint, parent)) => {
                body_of[link] = body_of[parent];
                frames[link] = frames[parent].compose(&Frame::of(&robot.joints[joint].origin));
                bodies[body_of[link]].links.push(link);
            }
            None => {
                body_of[link] = bodies.len();
                let joint = above.map(|(joint, _)| joint);
                if let Some((joint, parent)) = above {
                    let parent_body = &mut bodies[body_of[parent]];
                    parent_body.has_children = true;
                    let at = frames[parent].point(robot.joints[joint].origin.xyz);
                    parent_body.size = parent_body.size.max(norm(at));
                }
                let moments = Moments::ZERO;
                bodies.push(Body { links: vec![link], joint, moments, has_children: false, size: 0.0 });
            }
        }
        let body = &mut bodies[body_of[link]];
        if let Some(inertial) = &robot.links[link].inertial {
            body.moments = body.moments.add(&Moments::of(inertial, &frames[link]));
            body.size = body.size.max(norm(frames[link].point(inertial.origin.xyz)));
        }
        if robot.shapes_unknown {
            body.size = f64::INFINITY;
        }
        for shape in &robot.shapes[link] {
            body.size = body.size.max(norm(frames[link].point(shape.origin.xyz)) + shape.radius());
        }
    }
    bodies
}

impl Shape {
    /// Half extents of the box around the shape in its own axes.
    pub(crate) fn half_extents(&self) -> Vector {
        use urdf_rs::Geometry::{Box, Capsule, Cylinder, Mesh, Sphere};
        match self.geometry {
            Box { size } => scale(size.0, 0.5),
            Cylinder { radius, length } => [radius, radius, 0.5 * length],
            Capsule { radius, length } => [radius, radius, 0.5 * length + radius],
            Sphere { radius } => [radius; 3],
            Mesh { .. } => [0.0; 3],
        }
    }

    fn radius(&self) -> f64 {
        norm(self.half_extents())
    }
}

/// Checks every link and joint for itself, then, if the tree is sound, the bodies.
pub(super) fn check_links(robot: &UrdfRobot, messages: &mut Messages<'_>) {
    let mut refused = Vec::new();
    let lumped = lumped_links(robot);
    for (index, (link, places)) in robot.links.iter().zip(&robot.link_places).enumerate() {
        let errors = messages.errors();
        if let Some(inertial) = &link.inertial {
            let owner = format!("link `{}`", short(&link.name));
            check_inertial(&owner, inertial, lumped[index], places, messages);
            if let Some((problem, help)) = odd_angle(inertial.origin.rpy) {
                messages.warning(places.inertial, format!("{owner}: {problem}"), help);
            }
        }
        refused.push(places.faulty || messages.errors() > errors);
    }
    for (joint, places) in robot.joints.iter().zip(&robot.joint_places) {
        let owner = format!("joint `{}`", short(&joint.name));
        check_distance(&format!("{owner}: its origin"), joint.origin.xyz, places.origin, messages);
    }
    check_joint_angles(robot, messages);
    if let Some(tree) = &robot.tree {
        check_bodies(robot, &bodies(robot, tree), &refused, messages);
    }
}

/// Frames without mass and joints (sensors, skins) do not change the dynamics and come by the hundred: they get
/// one message together.
fn check_joint_angles(robot: &UrdfRobot, messages: &mut Messages<'_>) {
    let carries = carries_mass(robot);
    let mut idle = Vec::new();
    for (index, (joint, places)) in robot.joints.iter().zip(&robot.joint_places).enumerate() {
        let Some((problem, help)) = odd_angle(joint.origin.rpy) else { continue };
        let message = format!("joint `{}`: {problem}", short(&joint.name));
        if carries[index] {
            messages.warning(places.origin, message, help);
        } else {
            idle.push((places.origin, message, help));
        }
    }
    let others = idle.len().saturating_sub(1);
    if let Some((place, mut message, help)) = idle.into_iter().next() {
        if others > 0 {
            let _ = write!(message, ", and so are those of {others} more frames without mass");
        }
        messages.warning(place, message, help);
    }
}

/// Whether each joint moves, or has mass or a moving joint below it; all of them without a sound tree.
fn carries_mass(robot: &UrdfRobot) -> Vec<bool> {
    let mut carries = vec![true; robot.joints.len()];
    let Some(tree) = &robot.tree else { return carries };
    for &link in tree.order.iter().rev() {
        if let Some((joint, _)) = tree.above[link] {
            let mass = robot.links[link].inertial.is_some_and(|inertial| inertial.mass > 0.0);
            let below = tree.below[link].iter().any(|&(joint, _)| carries[joint]);
            carries[joint] = mass || below || robot.joints[joint].kind.moves();
        }
    }
    carries
}

/// Whether each link is fixed to another: what counts then is the inertia of all of them together.
fn lumped_links(robot: &UrdfRobot) -> Vec<bool> {
    let mut lumped = vec![false; robot.links.len()];
    for body in robot.tree.iter().flat_map(|tree| bodies(robot, tree)).filter(|body| body.links.len() > 1) {
        body.links.iter().for_each(|&link| lumped[link] = true);
    }
    lumped
}

fn check_inertial(
    owner: &str,
    inertial: &Inertial,
    lumped: bool,
    places: &super::LinkPlaces,
    messages: &mut Messages<'_>,
) {
    if inertial.mass < 0.0 {
        messages.error(
            places.mass,
            format!("{owner}: the mass {} kg is negative", inertial.mass),
            "write a mass of zero or more",
        );
    }
    if let Some(message) = indefinite(owner, &inertia_matrix(inertial.inertia), inertial.mass) {
        if lumped {
            messages.warning(places.inertia, message, INDEFINITE_HELP);
        } else {
            messages.error(places.inertia, message, INDEFINITE_HELP);
        }
    }
    check_distance(&format!("{owner}: its centre of mass"), inertial.origin.xyz, places.inertial, messages);
}

fn check_distance(what: &str, xyz: Vector, place: Place, messages: &mut Messages<'_>) {
    if norm(xyz) > FAR {
        messages.warning(
            place,
            format!("{what} is {} m away", norm(xyz)),
            "lengths are in metres; were millimetres written?",
        );
    }
}

const INDEFINITE_HELP: &str = "a rotating body needs principal moments of zero or more: check signs and the order ixx ixy ixz iyy iyz izz";

/// The message about an inertia with a negative principal moment.
fn indefinite(owner: &str, inertia: &Matrix, mass: f64) -> Option<String> {
    let largest = inertia.iter().flatten().fold(0.0f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 {
        return None;
    }
    let [smallest, _, _] = eigenvalues(&inertia.map(|row| row.map(|x| x / largest)));
    // A radius of gyration below a micrometre is rounding of whoever exported the file.
    let dust = 1e-12 * mass.abs();
    (smallest < -INDEFINITE && smallest * largest < -dust).then(|| {
        format!(
            "{owner}: the inertia is indefinite: its smallest principal moment is {:.3e} kg m²",
            smallest * largest
        )
    })
}

/// What is wrong with the bodies.
fn check_bodies(robot: &UrdfRobot, bodies: &[Body], refused: &[bool], messages: &mut Messages<'_>) {
    let total: f64 = bodies.iter().map(|body| body.moments.mass).sum();
    for body in bodies {
        let place = body_place(robot, body);
        let owner = body_name(robot, body);
        // Of a body with a refused link nothing more can be said.
        if body.links.iter().any(|&link| refused[link]) {
            continue;
        }
        if body.moments.mass == 0.0 {
            check_massless(robot, body, &owner, place, messages);
            continue;
        }
        if body.links.len() > 1
            && let Some(message) = indefinite(&owner, &body.moments.central(), body.moments.mass)
        {
            messages.error(place, message, INDEFINITE_HELP);
            continue;
        }
        for (message, help) in oddities(body, &owner, total) {
            messages.warning(place, message, help);
        }
    }
}

fn check_massless(robot: &UrdfRobot, body: &Body, owner: &str, place: Place, messages: &mut Messages<'_>) {
    let Some(joint) = body.joint else { return };
    let joint_name = short(&robot.joints[joint].name);
    if body.has_children && body.moments.second.iter().flatten().any(|moment| *moment != 0.0) {
        messages.warning(
            place,
            format!("{owner} has an inertia but no mass: there is no such body"),
            "give it a mass; for a virtual link between two joints leave out <inertial>",
        );
    } else if body.has_children {
        messages.warning(
            place,
            format!("{owner} has no mass and no inertia; it only carries joints"),
            "fine for a virtual link between two joints; else add <inertial>",
        );
    } else {
        messages.error(
            place,
            format!("{owner} moves with joint `{joint_name}` but has no mass: the equations of motion have no solution"),
            "add <inertial> with a mass, or make the joint fixed",
        );
    }
}

/// What is physically odd about a body with mass: message and advice.
pub(crate) fn oddities(body: &Body, owner: &str, total: f64) -> Vec<(String, &'static str)> {
    let mut found = Vec::new();
    let mass = body.moments.mass;
    let [a, b, c] = eigenvalues(&body.moments.central());
    if c <= 0.0 {
        if body.joint.is_some() {
            found.push((
                format!("{owner} has {mass} kg but no rotational inertia"),
                "add <inertia …/>; a point mass on its joint axis cannot be accelerated sensibly",
            ));
        }
    } else if a + b < c * (1.0 - TRIANGLE) {
        found.push((
            format!(
                "{owner}: the principal moments {a:.4e}, {b:.4e}, {c:.4e} kg m² violate the triangle inequality"
            ),
            "no rigid body has them: the largest may not exceed the sum of the other two",
        ));
    }
    let (gyration, size) = ((c.max(0.0) / mass).sqrt(), body.size.max(SMALLEST_SIZE));
    if gyration > WIDE * size {
        found.push((
            format!("{owner}: a radius of gyration of {gyration:.3} m is impossible for a body of about {size:.3} m"),
            "inertia is in kg m²; were kg mm² or g mm² written, or the mass in g?",
        ));
    }
    if total > mass && mass > HEAVY * (total - mass) {
        found.push((
            format!("{owner}: {mass} kg is more than {HEAVY} times the {:.3} kg of all others", total - mass),
            "masses are in kilograms; were grams written?",
        ));
    }
    found
}

fn body_place(robot: &UrdfRobot, body: &Body) -> Place {
    let heaviest = body.links.iter().find(|&&link| robot.links[link].inertial.is_some());
    let link = heaviest.copied().unwrap_or(body.links[0]);
    robot.link_places[link].inertial.or(robot.link_places[link].at)
}

/// The body's first link and those fixed to it.
pub(crate) fn body_name(robot: &UrdfRobot, body: &Body) -> String {
    let name = |link: &usize| robot.links[*link].name.as_str();
    let owner = format!("link `{}`", short(name(&body.links[0])));
    if body.links.len() > 1 {
        format!("{owner} (with {} fixed to it)", list_names(body.links[1..].iter().map(name)))
    } else {
        owner
    }
}
