//! A model rooted at its stance foot moves as the floating one does under constraints, with the same forces.
use super::support::*;
use bipedc_compiler::derive::Motions;
use bipedc_compiler::derive::articulated::factored;
use bipedc_compiler::derive::constrained::constrained_dynamics;
use bipedc_compiler::derive::constraint::Constraints;
use bipedc_compiler::derive::frames::{frame_pose, jacobian, world_poses};
use bipedc_compiler::derive::impact::impact_map;
use bipedc_compiler::derive::momentum::ground_wrench;
use bipedc_compiler::derive::newton_euler::generalised_forces;
use bipedc_compiler::description::model::{Base, RobotDescription};
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_runtime::Argument::{A, Q, Tau, V};

/// Pose (rows of R, position) of the URDF's root, and its Jacobian's rows, linear first.
fn root_function(rooted: &Tree, root: &str) -> Function {
    Function::derive(rooted, |model| {
        let poses = world_poses(model);
        let frame = model.tree.frame(root).unwrap();
        let pose = frame_pose(model, &poses, frame);
        let columns = jacobian(model, &poses, frame.body, pose.position);
        let row = |r: usize| columns.iter().map(move |c| if r < 3 { c.0[r] } else { c.1[r - 3] });
        vec![
            pose.rotation.0.iter().flatten().copied().collect(),
            pose.position.0.to_vec(),
            (0..6).flat_map(row).collect(),
        ]
    })
}

/// Unit quaternion x y z w of a rotation, stable for every angle.
fn quaternion(r: &[Vec<f64>]) -> Vec<f64> {
    let squares = [
        1.0 + r[0][0] - r[1][1] - r[2][2],
        1.0 - r[0][0] + r[1][1] - r[2][2],
        1.0 - r[0][0] - r[1][1] + r[2][2],
        1.0 + r[0][0] + r[1][1] + r[2][2],
    ];
    let largest = (0..4).max_by(|&a, &b| squares[a].total_cmp(&squares[b])).unwrap();
    let (sum, difference) = (|i: usize, j: usize| r[i][j] + r[j][i], |i: usize, j: usize| r[i][j] - r[j][i]);
    let mut x = match largest {
        0 => vec![squares[0], sum(0, 1), sum(0, 2), difference(2, 1)],
        1 => vec![sum(0, 1), squares[1], sum(1, 2), difference(0, 2)],
        2 => vec![sum(0, 2), sum(1, 2), squares[2], difference(1, 0)],
        _ => vec![difference(2, 1), difference(0, 2), difference(1, 0), squares[3]],
    };
    let norm = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    x.iter_mut().for_each(|x| *x /= norm);
    x
}

/// The free model's state that goes with a rooted one's.
fn free_state(free: &Tree, rooted: &Tree, root: &Function, q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let out = root.call(&[(Q, q)]);
    let (rotation, p) = (rows(&out[0], 3), &out[1]);
    let twist = times(&rows(&out[2], rooted.nv), v);
    let (joints_q, joints_v) = (&q[q.len() - free.joints.len()..], &v[v.len() - free.joints.len()..]);
    let (mut base_q, mut base_v) = (p.clone(), Vec::new());
    if free.base == BaseKind::Planar {
        base_q = vec![p[0], p[2], rotation[0][2].atan2(rotation[0][0])];
        base_v.extend([twist[0], twist[2], twist[4]]);
    } else {
        base_q.extend(quaternion(&rotation));
        base_v.extend(transposed_times(&rotation, &twist[..3], 3));
        base_v.extend(transposed_times(&rotation, &twist[3..], 3));
    }
    base_q.extend(joints_q);
    base_v.extend(joints_v);
    (base_q, base_v)
}

struct Pair {
    name: &'static str,
    /// Root of the second model.
    base: Base,
    /// Contacts of both.
    contacts: Vec<&'static str>,
}

fn pairs() -> Vec<Pair> {
    let fixed = |link: &str| Base::Fixed { link: link.to_owned() };
    let pivot = |about: &str| Base::Pivot { about: about.to_owned() };
    let pair = |name, base, contacts: &[&'static str]| Pair { name, base, contacts: contacts.to_vec() };
    vec![
        pair("three_link", pivot("right_foot/point_foot"), &["right_foot"]),
        pair("five_link", pivot("right_foot/point_foot"), &["right_foot"]),
        pair("five_link", pivot("left_foot/point_foot"), &["left_foot", "right_foot"]),
        pair("seven_link", fixed("right_foot"), &["right_foot"]),
        pair("seven_link", fixed("right_foot"), &["right_foot", "left_foot/toe"]),
        pair("seven_link", pivot("right_foot/toe"), &["right_foot/toe"]),
        pair("seven_link", pivot("right_foot/toe"), &["right_foot/toe", "left_foot/heel"]),
        pair("seven_link", pivot("right_foot/toe"), &["right_foot"]),
        pair("biped_3d", fixed("right_foot"), &["right_foot"]),
        pair("biped_3d", fixed("right_foot"), &["right_foot", "left_foot/front"]),
        pair("biped_3d", pivot("right_foot/front"), &["right_foot/front"]),
        pair("biped_3d", pivot("right_foot/front"), &["right_foot/front", "left_foot/rear"]),
        pair("tulip", fixed("left_foot"), &["left_foot"]),
        pair("tulip", fixed("right_foot"), &["right_foot", "left_foot"]),
        pair("tulip", pivot("left_foot/rear"), &["left_foot/rear"]),
        pair("tulip_v1_leg", fixed("right_foot"), &["right_foot"]),
    ]
}

fn dynamics(tree: &Tree, description: &RobotDescription, contacts: &[&str]) -> Function {
    let contacts: Vec<_> = contacts.iter().map(|text| contact(&description.feet, text)).collect();
    Function::derive(tree, |model| {
        let c = Constraints::new(model, &description.feet, &contacts).unwrap();
        let solution = constrained_dynamics(model, &c);
        vec![solution.acceleration, solution.forces, c.jacobian.into_iter().flatten().collect()]
    })
}

fn wrench(tree: &Tree) -> Function {
    Function::derive(tree, |model| {
        let w = ground_wrench(model);
        vec![w.linear.0.to_vec(), w.angular.0.to_vec()]
    })
}

/// Weight of the links that stand in the world, and its moment about the origin: a fixed root's model does
/// not carry them.
fn fixed_weight(tree: &Tree, description: &RobotDescription) -> [f64; 6] {
    let mut out = [0.0; 6];
    for frame in tree.links.iter().filter(|frame| frame.body.is_none()) {
        let link = description.links.iter().find(|link| link.name == frame.name).unwrap();
        let Some(inertial) = &link.inertial else { continue };
        let weight = description.gravity.map(|g| inertial.mass * g);
        let moment = cross(inertial.origin.xyz, weight);
        (0..3).for_each(|i| {
            out[i] -= weight[i];
            out[3 + i] -= moment[i];
        });
    }
    out
}

#[test]
fn rooted_models_agree_with_free_ones() {
    let mut worst = Worst::default();
    let mut random = Random::new(SEED + 4);
    for pair in pairs() {
        let description = robot(pair.name);
        let free = tree(&description, if PLANAR.contains(&pair.name) { "planar" } else { "floating" });
        let rooted = Tree::new(&description, &pair.base).unwrap();
        let root = root_function(&rooted, &description.root_link);
        let (free_dynamics, rooted_dynamics) =
            (dynamics(&free, &description, &pair.contacts), dynamics(&rooted, &description, &pair.contacts));
        let (free_wrench, rooted_wrench) = (wrench(&free), wrench(&rooted));
        let weight = fixed_weight(&rooted, &description);
        for _ in 0..10 {
            let q = random.configuration(&rooted);
            let mut v = random.vector(rooted.nv, 2.0);
            let tau = random.vector(rooted.joints.len(), 10.0);
            // The velocity must satisfy the other contacts, or the rows' choice would count.
            v = settled(&rooted, &description, &pair, &q, &v);
            let (free_q, free_v) = free_state(&free, &rooted, &root, &q, &v);
            let pad = |n: usize| [vec![0.0; n - tau.len()], tau.clone()].concat();
            let here = free_dynamics.call(&[(Q, &free_q), (V, &free_v), (Tau, &pad(free.nv))]);
            let there = rooted_dynamics.call(&[(Q, &q), (V, &v), (Tau, &pad(rooted.nv))]);
            let joints = |a: &[f64]| a[a.len() - tau.len()..].to_vec();
            let what = format!("{} on {:?}: joint accelerations", pair.name, pair.base);
            worst.note(&what, &joints(&there[0]), &joints(&here[0]));
            let ours = free_wrench.call(&[(Q, &free_q), (V, &free_v), (A, &here[0])]).concat();
            let mut theirs = rooted_wrench.call(&[(Q, &q), (V, &v), (A, &there[0])]).concat();
            theirs.iter_mut().zip(weight).for_each(|(x, w)| *x += w);
            worst.note("ground wrench", &theirs, &ours);
            // Forces stand first in each contact's rows.
            if pair.contacts.len() == 1 {
                let force: Vec<f64> =
                    if free.base == BaseKind::Planar { vec![ours[0], ours[2]] } else { ours[..3].to_vec() };
                worst.note("lambda is the ground's force", &here[1][..force.len()], &force);
            }
        }
    }
    worst.check(1e-10);
}

/// The velocity just after the contacts' impact on the rooted model.
fn settled(rooted: &Tree, description: &RobotDescription, pair: &Pair, q: &[f64], v: &[f64]) -> Vec<f64> {
    let contacts: Vec<_> = pair.contacts.iter().map(|text| contact(&description.feet, text)).collect();
    let function = Function::derive(rooted, |model| {
        let c = Constraints::new(model, &description.feet, &contacts).unwrap();
        vec![impact_map(model, &c).velocity]
    });
    function.call(&[(Q, q), (V, v)]).remove(0)
}

#[test]
fn no_contacts_is_forward_dynamics() {
    let description = robot("five_link");
    let tree = tree(&description, "planar");
    let free = Function::derive(&tree, |model| {
        let c = Constraints::new(model, &description.feet, &[]).unwrap();
        let tau: Vec<_> = (0..model.tree.nv).map(|k| model.input(Tau, k)).collect();
        vec![constrained_dynamics(model, &c).acceleration, factored(model, &tau)]
    });
    let mut random = Random::new(SEED + 5);
    let (q, v, tau) = (random.configuration(&tree), random.vector(tree.nv, 2.0), random.vector(tree.nv, 5.0));
    let out = free.call(&[(Q, &q), (V, &v), (Tau, &tau)]);
    assert!(error(&out[0], &out[1]) < 1e-11);
}

/// Counts of a robot with one flat foot: accelerations and forces, impact.
fn flat_foot(folder: &str, foot: &str) -> [usize; 2] {
    let (description, _) = bipedc_compiler::description::read(&project().join(folder)).unwrap();
    let tree = tree(&description, "floating");
    let flat = [contact(&description.feet, foot)];
    let dynamics = Function::derive(&tree, |model| {
        let c = Constraints::new(model, &description.feet, &flat).unwrap();
        let solution = constrained_dynamics(model, &c);
        vec![solution.acceleration, solution.forces]
    });
    let impact = Function::derive(&tree, |model| {
        let c = Constraints::new(model, &description.feet, &flat).unwrap();
        let i = impact_map(model, &c);
        vec![i.velocity, i.impulse]
    });
    let parts =
        Function::derive(&tree, |model| vec![generalised_forces(model, Motions::NO_ACCELERATION, false)]);
    println!("{folder}: accelerations and forces: {}", dynamics.operations());
    println!("{folder}: impact: {}", impact.operations());
    println!("{folder}: bias alone: {}", parts.operations());
    [dynamics.operations().total(), impact.operations().total()]
}

#[test]
fn a_flat_foot_eliminates_the_base() {
    // With the base's rows kept and six rows of the foot beside them: 5475 and 4066.
    let [dynamics, impact] = flat_foot("robots/tulip", "right_foot");
    assert!(dynamics <= 4200 && impact <= 3000, "{dynamics}, {impact}");
    let [dynamics, impact] = flat_foot("benches/robots/lower12", "right_foot");
    assert!(dynamics <= 4400 && impact <= 3200, "{dynamics}, {impact}");
}
