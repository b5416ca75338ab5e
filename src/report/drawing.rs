//! The robot's shape as reports draw it: joints, links as lines, soles.
use bipedc_analysis::report::{Bone, Drawing, DrawnJoint, Hull};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::tree::{Body, JointMotion, Placement, Rotation, Tree, matrix_vector};

/// The shape at these joint positions (rad, m; order of [`Tree::joints`], missing ones are zero), the base upright at
/// the origin.
///
/// A link is drawn from its joint to the joints that it carries; one that carries none to the middle of its contact
/// points, else to its centre of mass. The base is drawn from its centre of mass, and as the solid between that and
/// its joints.
pub fn drawing(description: &RobotDescription, tree: &Tree, positions: &[f64]) -> Drawing {
    let placed = place(tree, positions);
    let real = |body: usize| tree.joints.iter().position(|joint| joint.name == tree.bodies[body].joint);
    let joints = tree.joints.iter().filter_map(|joint| {
        let index = tree.bodies.iter().position(|body| body.joint == joint.name)?;
        let body = &tree.bodies[index];
        let (JointMotion::Revolute { axis, reversed } | JointMotion::Prismatic { axis, reversed }) =
            body.motion
        else {
            return None;
        };
        let mut direction = [0.0; 3];
        direction[axis] = if reversed { -1.0 } else { 1.0 };
        Some(DrawnJoint {
            name: joint.name.clone(),
            position: placed[index].translation,
            axis: matrix_vector(&placed[index].rotation.matrix(), direction),
            prismatic: joint.prismatic,
            parent: tree.path_to_root(index).skip(1).find_map(real),
        })
    });
    let (mut bones, trunk) = base(description, tree, &placed);
    bones.extend(self::bones(tree, &placed));
    let hulls = trunk.into_iter().chain(hulls(tree, &placed)).collect();
    Drawing { joints: joints.collect(), bones, hulls }
}

/// Every body's frame in the world.
fn place(tree: &Tree, positions: &[f64]) -> Vec<Placement> {
    let mut placed: Vec<Placement> = Vec::with_capacity(tree.bodies.len());
    for body in &tree.bodies {
        let joint = tree.joints.iter().position(|joint| joint.name == body.joint);
        let position = joint.and_then(|j| positions.get(j)).copied().filter(|q| q.is_finite()).unwrap_or(0.0);
        let frame = body.placement.then(&moved(body, position));
        placed.push(match body.parent {
            Some(parent) => placed[parent].then(&frame),
            None => frame,
        });
    }
    placed
}

/// What the joint's position does in the body's frame.
fn moved(body: &Body, position: f64) -> Placement {
    let signed = |reversed: bool| if reversed { -position } else { position };
    match body.motion {
        JointMotion::Free => Placement::default(),
        JointMotion::Revolute { axis, reversed } => {
            Placement { rotation: Rotation(vec![(axis, signed(reversed))]), translation: [0.0; 3] }
        }
        JointMotion::Prismatic { axis, reversed } => {
            let mut translation = [0.0; 3];
            translation[axis] = signed(reversed);
            Placement::shift(translation)
        }
    }
}

/// A point of a body's frame in the world.
fn at(placement: &Placement, point: [f64; 3]) -> [f64; 3] {
    placement.then(&Placement::shift(point)).translation
}

/// Lines of everything that hangs on a joint.
fn bones(tree: &Tree, placed: &[Placement]) -> Vec<Bone> {
    let mut bones = Vec::new();
    for (index, body) in tree.bodies.iter().enumerate().filter(|(_, body)| !is_base(tree, body)) {
        let (from, mass) = (placed[index].translation, body.inertia.mass);
        let carried: Vec<usize> =
            (0..tree.bodies.len()).filter(|&child| tree.bodies[child].parent == Some(index)).collect();
        bones.extend(carried.iter().map(|&child| Bone { from, to: placed[child].translation, mass }));
        if carried.is_empty() {
            let center =
                (mass > 0.0).then(|| at(&placed[index], body.inertia.first_moment.map(|x| x / mass)));
            let to = middle(&points_of(tree, placed, Some(index))).or(center).unwrap_or(from);
            bones.push(Bone { from, to, mass });
        }
    }
    bones
}

/// Moved by no joint of the robot.
fn is_base(tree: &Tree, body: &Body) -> bool {
    tree.joints.iter().all(|joint| joint.name != body.joint)
}

/// The base: lines from its centre of mass to the joints that it carries, and the solid between these points.
fn base(description: &RobotDescription, tree: &Tree, placed: &[Placement]) -> (Vec<Bone>, Option<Hull>) {
    let carried = (0..placed.len()).filter(|&index| {
        let body = &tree.bodies[index];
        !is_base(tree, body) && body.parent.is_none_or(|parent| is_base(tree, &tree.bodies[parent]))
    });
    let ends: Vec<[f64; 3]> = carried.map(|body| placed[body].translation).collect();
    let (from, mass) = base_mass(description, tree, placed);
    let bones = ends.iter().map(|&to| Bone { from, to, mass }).collect();
    let solid = || Hull { name: "base".to_owned(), points: ends.iter().copied().chain([from]).collect() };
    (bones, (ends.len() > 1).then(solid))
}

/// Centre of mass and mass of the base. A fixed base is no body of the tree: its links know.
fn base_mass(description: &RobotDescription, tree: &Tree, placed: &[Placement]) -> ([f64; 3], f64) {
    let (mut mass, mut moment) = (0.0, [0.0; 3]);
    let mut add = |m: f64, center: [f64; 3]| {
        mass += m;
        moment = [0, 1, 2].map(|k| moment[k] + m * center[k]);
    };
    for (index, body) in tree.bodies.iter().enumerate().filter(|(_, body)| is_base(tree, body)) {
        let m = body.inertia.mass;
        if m > 0.0 {
            add(m, at(&placed[index], body.inertia.first_moment.map(|x| x / m)));
        }
    }
    for frame in tree.links.iter().filter(|frame| frame.body.is_none()) {
        let link = description.links.iter().find(|link| link.name == frame.name);
        if let Some(inertial) = link.and_then(|link| link.inertial.as_ref()) {
            add(inertial.mass, at(&frame.placement, inertial.origin.xyz));
        }
    }
    if mass > 0.0 { (moment.map(|x| x / mass), mass) } else { ([0.0; 3], 0.0) }
}

fn points_of(tree: &Tree, placed: &[Placement], body: Option<usize>) -> Vec<[f64; 3]> {
    let points = tree.points.iter().filter(|point| point.body == body);
    points
        .map(|p| p.body.map_or(p.placement.translation, |b| at(&placed[b], p.placement.translation)))
        .collect()
}

fn middle(points: &[[f64; 3]]) -> Option<[f64; 3]> {
    let count = points.len() as f64;
    (!points.is_empty()).then(|| [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count))
}

/// Soles: the contact points of each foot.
fn hulls(tree: &Tree, placed: &[Placement]) -> Vec<Hull> {
    let mut hulls: Vec<Hull> = Vec::new();
    for point in &tree.points {
        let foot = point.name.split('/').next().unwrap_or_default();
        let place =
            point.body.map_or(point.placement.translation, |b| at(&placed[b], point.placement.translation));
        match hulls.iter_mut().find(|hull| hull.name == foot) {
            Some(hull) => hull.points.push(place),
            None => hulls.push(Hull { name: foot.to_owned(), points: vec![place] }),
        }
    }
    hulls
}
