//! Minimal and absolute coordinates are two ways to one motion.
use bipedc::simulation::absolute::{free_bodies, free_coordinates, joint_order};
use bipedc::simulation::true_model;
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::{
    FreeBodies, FreeStepper, Ground, JointLaw, Mechanics, MotionState, Stepper, Tolerance,
};
use bipedc_compiler::Robot;
use bipedc_runtime::nalgebra::DVector;
use std::path::Path;

/// Springs of the joints, N m/rad, and the posture they hold, rad.
const STIFFNESS: f64 = 300.0;

/// How far apart the links are in the end, m and rad, of the two ways; and the way of the first one, m.
fn apart(folder: &str, ground: Ground, clearance: f64, steps: &[f64], time: f64) -> Vec<f64> {
    let robot =
        Robot::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap_or_else(|e| panic!("{e}"));
    let robot = robot.with_base("planar", None).unwrap().without_effects();
    let tree = robot.tree().unwrap();
    let model = true_model(&robot, &[]).unwrap();
    let bodies = free_bodies(&tree).unwrap();
    let mechanics = Mechanics::new(&model, BaseKind::Planar).unwrap();
    let (nq, joints) = (mechanics.nq(), mechanics.joints());
    let mut start = vec![0.0; nq];
    start[2] = 0.04;
    (0..joints).for_each(|j| start[3 + j] = 0.1 * (1.3 * j as f64).sin());
    // A planar base's velocities are derivatives of its coordinates.
    let speed: Vec<f64> = (0..nq).map(|i| if i < 3 { 0.1 } else { (2.1 * i as f64).sin() }).collect();
    let mut gaps = vec![0.0; mechanics.points()];
    mechanics.distances(&start, &mut gaps);
    start[1] = clearance - gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let order = joint_order(&tree);
    steps
        .iter()
        .map(|&step| {
            let laws = vec![JointLaw::default(); joints];
            let mut stepper = Stepper::new(mechanics, ground, laws, Tolerance::default()).unwrap();
            let mut motion = MotionState { time: 0.0, q: start.clone(), v: speed.clone() };
            let mut other = FreeStepper::new(&bodies, ground, Tolerance::default()).unwrap();
            let mut q = DVector::from_vec(free_coordinates(&tree, &start));
            // Velocities of the free bodies, by central differences.
            let moved = |way: f64| {
                let there: Vec<f64> = start.iter().zip(&speed).map(|(q, v)| q + way * v).collect();
                DVector::from_vec(free_coordinates(&tree, &there))
            };
            let mut v = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            for _ in 0..(time / step).round() as usize {
                let mut force = vec![0.0; nq];
                (3..nq).for_each(|j| force[j] = STIFFNESS * (start[j] - motion.q[j]));
                stepper.step(&mut motion, &force, step).unwrap();
                let torques = springs(&bodies, &q, &start, &order);
                other.step(&mut q, &mut v, &torques, step).unwrap();
            }
            let found = free_coordinates(&tree, &motion.q);
            found.iter().zip(q.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        })
        .collect()
}

fn springs(bodies: &FreeBodies, q: &DVector<f64>, start: &[f64], order: &[usize]) -> Vec<f64> {
    let angle = |k: usize| {
        let [first, second] = bodies.pins[k].links;
        q[3 * second + 2] - q[3 * first + 2]
    };
    (0..order.len()).map(|k| STIFFNESS * (start[order[k]] - angle(k))).collect()
}

#[test]
fn absolute_coordinates_give_the_same_motion() {
    let hard = Ground { friction: 0.6, ..Ground::default() };
    let bouncing = Ground { normal_restitution: 0.3, ..hard };
    let steps = [8e-4, 4e-4, 2e-4, 1e-4];
    for (name, folder, ground, clearance, least) in [
        ("seven-link in the air", "robots/seven_link", hard, 1.0, 1.8),
        ("seven-link landing", "robots/seven_link", hard, 0.01, 0.8),
        ("seven-link bouncing", "robots/seven_link", bouncing, 0.01, 0.6),
        ("five-link landing", "robots/five_link", hard, 0.01, 0.8),
    ] {
        let found = apart(folder, ground, clearance, &steps, 0.16);
        // Where in a step an impact falls is chance: of two neighbouring steps the larger error counts.
        let order = f64::log2(found[0].max(found[1]) / found[2].max(found[3])) / 2.0;
        println!("{name}: {found:?} m apart at steps {steps:?} s, order {order:.2}");
        assert!(order > least && found[3] < 1e-3, "{name}: {found:?}");
    }
}

#[test]
fn robots_that_are_not_planar_are_refused() {
    let robot = Robot::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip")).unwrap();
    assert!(free_bodies(&robot.tree().unwrap()).is_err());
}
