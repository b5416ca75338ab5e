//! One physical state seen by models with different roots: energies, momentum and link poses agree, and
//! generalised forces carry over by virtual power.
use super::generator::Random;
use super::subject::*;
use bipedc_compiler::compile::identifier;
use bipedc_compiler::description::model::ContactPart;
use bipedc_compiler::tree::BaseKind;
use bipedc_runtime::Argument::{A, Q, Tau, V};

const KINEMATICS: [&str; 4] = ["position", "rotation", "jacobian", "jacobian_rate_times_velocity"];

/// The unit quaternion x y z w of a rotation given by columns.
fn quaternion(axes: &[f64]) -> [f64; 4] {
    let r = |row: usize, column: usize| axes[3 * column + row];
    let trace = r(0, 0) + r(1, 1) + r(2, 2);
    // The largest component first: it divides the others.
    let diagonal = [r(0, 0), r(1, 1), r(2, 2), trace];
    let largest = (0..4).max_by(|&i, &j| diagonal[i].total_cmp(&diagonal[j])).unwrap();
    let mut q = [0.0; 4];
    if largest == 3 {
        q = [r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1), 1.0 + trace];
    } else {
        let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
        q[i] = 1.0 + r(i, i) - r(j, j) - r(k, k);
        q[j] = r(j, i) + r(i, j);
        q[k] = r(k, i) + r(i, k);
        q[3] = r(k, j) - r(j, k);
    }
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / norm)
}

/// A state of a model whose base floats at `link`.
struct Carried {
    values: Values<f64>,
    /// Velocities of the floating model by those of the other, column after column.
    map: Vec<f64>,
}

/// Takes a state of `robot` (on any base, with [`KINEMATICS`]) to `link` as floating root.
fn carried(robot: &Subject, values: &Values<f64>, link: &str) -> Carried {
    let [position, axes, jacobian, rate] =
        KINEMATICS.map(|family| robot.call(&format!("{family}_of_{}", identifier(link)), values));
    let (nv, base) = (robot.nv(), robot.tree().base_nv());
    let in_link =
        |x: &[f64]| transposed_times(&axes, &x[..3]).into_iter().chain(transposed_times(&axes, &x[3..]));
    let map = (0..nv).flat_map(|k| {
        let joints = (base..nv).map(move |j| f64::from(u8::from(j == k)));
        in_link(&jacobian[6 * k..6 * k + 6]).chain(joints).collect::<Vec<_>>()
    });
    let map: Vec<f64> = map.collect();
    let v = times(&map, values.of(V));
    // The components of the twist change with the turning axes too: d/dt (Rᵀ ṗ) = Rᵀ p̈ − ω × Rᵀ ṗ.
    let world = plus(&times(&jacobian, values.of(A)), &rate);
    let mut a: Vec<f64> = in_link(&world).chain(values.of(A)[base..].iter().copied()).collect();
    let turning = cross(three(&v[3..]), three(&v));
    (0..3).for_each(|k| a[k] -= turning[k]);
    let joints = &values.of(Q)[robot.tree().nq - robot.tree().joints.len()..];
    let q = [&position[..], &quaternion(&axes), joints].concat();
    Carried { values: values.with(Q, q).with(V, v).with(A, a), map }
}

/// The same robot, floating at `link`.
fn floating_at(robot: &Subject, link: &str, families: &[&str]) -> Subject {
    let other = robot.robot.clone().with_base("floating", Some(link)).unwrap();
    Subject::new(format!("{}, floating at {link}", robot.name), other, families)
}

const WHOLE: [&str; 6] =
    ["kinetic_energy", "potential_energy", "center_of_mass", "momentum", "momentum_rate", "inverse_dynamics"];

fn compare(robot: &Subject, values: &Values<f64>, other: &Subject, link: &str) {
    let carried = carried(robot, values, link);
    let fixed = robot.tree().base == BaseKind::Fixed;
    for function in &WHOLE[..5] {
        // A fixed base's own mass does not count among what moves.
        if !fixed || !matches!(*function, "potential_energy" | "center_of_mass") {
            other.close(
                function,
                &other.call(function, &carried.values),
                &robot.call(function, values),
                1e-10,
            );
        }
    }
    let power = transposed_times(&carried.map, &other.call("inverse_dynamics", &carried.values));
    other.close("virtual power", &power, &robot.call("inverse_dynamics", values), 1e-10);
    for seen in &robot.tree().links {
        let name = format!("position_of_{}", identifier(&seen.name));
        other.close(&name, &other.call(&name, &carried.values), &robot.call(&name, values), 1e-11);
    }
    let names = |robot: &Subject| robot.tree().joints.iter().map(|j| j.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(robot), names(other), "{}", other.name);
}

#[test]
#[ignore = "takes long"]
fn every_link_can_be_the_root() {
    let families = [&WHOLE[..], &KINEMATICS].concat();
    let mut random = Random(SEED);
    for robot in subjects(&families) {
        let values = robot.state(&mut random);
        for link in robot.tree().links.iter().map(|l| l.name.clone()).collect::<Vec<_>>() {
            let other = floating_at(&robot, &link, &[&WHOLE[..], &["position"]].concat());
            compare(&robot, &values, &other, &link);
        }
    }
}

/// Feet, toes and edges as roots of the six robots on pivots, fixed and planar bases.
#[test]
fn stance_feet_and_toes_can_be_the_root() {
    let families = [&WHOLE[..], &KINEMATICS].concat();
    let bases = [
        ("three_link", "pivot", "right_foot/point_foot"),
        ("five_link", "pivot", "left_foot/point_foot"),
        ("seven_link", "pivot", "right_foot/toe"),
        ("seven_link", "pivot", "right_foot/heel"),
        ("seven_link", "fixed", "right_foot"),
        ("seven_link", "planar", "left_foot/toe"),
        ("biped_3d", "pivot", "right_foot/front"),
        ("biped_3d", "fixed", "left_foot"),
        ("tulip", "pivot", "right_foot/rear"),
        ("tulip", "fixed", "right_foot"),
        ("tulip", "floating", "left_foot/rear_right"),
    ];
    let mut random = Random(SEED);
    let robots = six_robots(&[]);
    for (name, kind, root) in bases {
        let plain = robots.iter().find(|robot| robot.name == name).unwrap();
        let standing = plain.robot.clone().with_base(kind, Some(root)).unwrap();
        let standing = Subject::new(format!("{name}, {kind} at {root}"), standing, &families);
        let link = plain.robot.description.root_link.clone();
        let floating = floating_at(&standing, &link, &[&WHOLE[..], &["position"]].concat());
        for _ in 0..STATES {
            let values = standing.state(&mut random);
            compare(&standing, &values, &floating, &link);
        }
    }
}

/// Standing on contact constraints is standing on a fixed or pivoting base: the same accelerations.
#[test]
fn constraints_hold_a_free_robot_as_a_base_does() {
    let cases = [
        ("seven_link", "fixed", "right_foot"),
        ("seven_link", "pivot", "right_foot/toe"),
        ("five_link", "pivot", "right_foot/point_foot"),
        ("biped_3d", "fixed", "right_foot"),
        ("biped_3d", "pivot", "right_foot/front"),
        ("tulip", "fixed", "right_foot"),
        ("tulip", "pivot", "right_foot/rear"),
    ];
    let mut random = Random(SEED);
    for (name, kind, root) in cases {
        let plain = six_robots(&[]).into_iter().find(|robot| robot.name == name).unwrap();
        let families = [&KINEMATICS[..], &["forward_dynamics"]].concat();
        let held = plain.robot.clone().with_base(kind, Some(root)).unwrap();
        let held = Subject::new(format!("{name}, {kind} at {root}"), held, &families);
        let free = standing_phase(&plain, root);
        for _ in 0..STATES {
            let mut values = held.state(&mut random);
            let base = held.tree().base_nv();
            values.0[Tau as usize][..base].fill(0.0);
            let a = held.call("forward_dynamics", &values);
            let link = plain.robot.description.root_link.clone();
            let state = carried(&held, &values.with(A, a), &link);
            let tau = [&[0.0; 6], &values.of(Tau)[base..]].concat();
            let answer = free.call("constrained_dynamics_of_standing", &state.values.with(Tau, tau));
            held.close("accelerations", &answer[..free.nv()], state.values.of(A), 1e-8);
        }
    }
}

/// A floating model with one phase, in which the foot, point or edge `root` stands.
fn standing_phase(plain: &Subject, root: &str) -> Subject {
    let link = plain.robot.description.root_link.clone();
    let mut robot = plain.robot.clone().with_base("floating", Some(&link)).unwrap();
    let foot_of = |name: &str| robot.description.feet.iter().find(|foot| foot.name == name).unwrap();
    let (foot, part) = match root.split_once('/') {
        None => (root, ContactPart::Flat),
        Some((foot, part)) if foot_of(foot).edges.iter().any(|edge| edge.name == part) => {
            (foot, ContactPart::Edge(part.to_owned()))
        }
        Some((foot, part)) => (foot, ContactPart::Point(part.to_owned())),
    };
    let mut phase = robot.description.phases[0].clone();
    phase.name = "standing".to_owned();
    phase.contacts = vec![bipedc_compiler::description::model::Contact { foot: foot.to_owned(), part }];
    robot.description.phases = vec![phase];
    Subject::new(format!("{} standing on {root}", plain.name), robot, &["constrained_dynamics"])
}
