//! Data without noise give back the parameters they were made of.
use crate::identify::simulated::{Simulated, friction};
use crate::identify::support::{Order, read_json};
use bipedc_analysis::identify::{Estimate, Extra, Law, Method, Summand};
use bipedc_analysis::measure::Recording;
use bipedc_analysis::robot::Trajectory;
use bipedc_analysis::robot::{BaseKind, JointLayout};
use bipedc_runtime::nalgebra::DVector;
use bipedc_runtime::{CallError, Model, Signature, State};

/// Largest error over all unknowns, relative to the unknown or (for small ones) to a thousandth of the largest.
fn worst(found: &DVector<f64>, truth: &DVector<f64>) -> f64 {
    let floor = 1e-3 * truth.amax();
    found.iter().zip(truth.iter()).map(|(a, b)| (a - b).abs() / b.abs().max(floor)).fold(0.0, f64::max)
}

fn recovered(name: &str, base: &str) {
    let robot = Simulated::new(name, base);
    let joints = if robot.layout.base == BaseKind::Fixed { robot.layout.joints.len() } else { 0 };
    // The rows of a free base are equations without a measurement: their right-hand side is zero. States here are
    // arbitrary, so those of free robots are checked by the joints alone.
    let extras = friction(joints);
    let mut rows = robot.rows.clone();
    rows.retain(|row| *row >= robot.layout.base.nv());
    let robot = Simulated { rows, ..robot };
    let design = robot.design(extras.iter().map(|(extra, _)| *extra).collect());
    let mut motion = robot.motion(40.0, 7, 1.0);
    robot.measure(&mut motion, &extras, &mut |_| 0.0);
    let sums = robot.sums(&design, &motion);
    let truth = robot.truth(&design, &extras);
    let estimate = Estimate::weighted(&design, &sums, truth.map(|_| 0.0), Method::Ordinary);
    // Base parameters of all rows: those that only base rows see are unseen here.
    let fit = estimate.fit(&design, &sums);
    let seen = DVector::from_iterator(estimate.seen.len(), estimate.seen.iter().map(|&k| fit.theta[k]));
    let own = DVector::from_iterator(estimate.seen.len(), estimate.seen.iter().map(|&k| truth[k]));
    if robot.layout.base == BaseKind::Fixed {
        assert_eq!(estimate.seen.len(), design.unknowns.len(), "{name}: unseen parameters");
    }
    let error = worst(&seen, &own);
    println!(
        "{name} on a {base} base: {} of {} parameters, worst {error:.1e}",
        estimate.seen.len(),
        truth.len()
    );
    assert!(error < 1e-9, "{name} on a {base} base: {error:e}");
    assert!(fit.residual.iter().all(|r| *r < 1e-10), "{:?}", fit.residual);
}

#[test]
fn arms_give_back_all_base_parameters_and_friction() {
    for name in ["tulip", "tulip_v1_leg", "biped_3d", "three_link"] {
        recovered(name, "fixed");
    }
}

#[test]
fn joint_torques_of_a_free_robot_give_back_its_base_parameters() {
    recovered("tulip_v1_leg", "floating");
    recovered("five_link", "planar");
}

/// Pinocchio's torques at random states, fitted: its parameters are those of the description.
#[test]
fn pinocchio_s_torques_give_back_the_description() {
    for (name, base) in [("tulip", "floating"), ("biped_3d", "floating"), ("seven_link", "floating")] {
        let robot = Simulated::new(name, base);
        let json = read_json(&format!("oracle/{name}.json.gz"));
        let order = Order::new(&Names(&robot.layout), &json["joints"]);
        let trajectory = Trajectory::new(&robot.layout);
        let mut motion = Recording { step: 0.01, trajectory, ..Recording::default() };
        let mut forces = Vec::new();
        for case in json["cases"].as_array().unwrap() {
            motion.time.push(0.01 * motion.time.len() as f64);
            motion.trajectory.q.extend(order.q(&case["q"]));
            motion.trajectory.v.extend(order.v(&case["v"]));
            motion.trajectory.a.extend(order.v(&case["a"]));
            forces.push(order.v(&case["inverse_dynamics"]));
        }
        let count = motion.time.len();
        motion.segments = std::iter::once(0..count).collect();
        let nb = robot.layout.base.nv();
        motion.effort = (0..robot.layout.joints.len())
            .map(|j| Some(forces.iter().map(|tau| tau[nb + j]).collect()))
            .collect();
        let rows: Vec<usize> = (nb..nb + robot.layout.joints.len()).collect();
        let robot = Simulated { rows, ..robot };
        let design = robot.design(Vec::new());
        let sums = robot.sums(&design, &motion);
        let truth = robot.truth(&design, &[]);
        let estimate = Estimate::weighted(&design, &sums, truth.clone(), Method::Ordinary);
        let theta = estimate.solve(&estimate.total, &estimate.seen);
        let error = worst(&theta, &truth);
        println!(
            "{name}: {count} states, {} of {} parameters, worst {error:.1e}",
            estimate.seen.len(),
            truth.len()
        );
        assert!(estimate.seen.len() > truth.len() / 2, "{name}: too few states to tell anything");
        assert!(error < 1e-7, "{name}: {error:e}");
    }
}

/// A rotor on the first axis of an arm acts as an inertia of its link: both are one unknown.
#[test]
fn rotors_that_act_as_inertias_are_grouped() {
    let robot = Simulated::new("tulip_v1_leg", "fixed");
    let joints = robot.layout.joints.len();
    let rotor = |joint| Extra { law: Law::ROTOR, joint, other: joint };
    let extras: Vec<(Extra, f64)> = (0..joints).map(|j| (rotor(j), 0.01 * (j + 1) as f64)).collect();
    let design = robot.design(extras.iter().map(|(e, _)| *e).collect());
    let grouped: Vec<&str> = design
        .unknowns
        .iter()
        .filter(|u| {
            matches!(u.sum[0].0, Summand::Inertial(_))
                && u.sum.iter().any(|(p, _)| matches!(p, Summand::Extra(_)))
        })
        .map(|u| u.name.as_str())
        .collect();
    println!("{grouped:?}");
    assert!(!grouped.is_empty() && grouped[0].contains("rotor_inertia"));
    let mut motion = robot.motion(30.0, 3, 1.0);
    robot.measure(&mut motion, &extras, &mut |_| 0.0);
    let sums = robot.sums(&design, &motion);
    let truth = robot.truth(&design, &extras);
    let estimate = Estimate::weighted(&design, &sums, truth.map(|_| 0.0), Method::Ordinary);
    assert_eq!(estimate.seen.len(), truth.len());
    assert!(worst(&estimate.solve(&estimate.total, &estimate.seen), &truth) < 1e-9);
}

/// Joint names, for the order of the oracle's coordinates.
struct Names<'a>(&'a JointLayout);

impl Model<f64> for Names<'_> {
    fn nq(&self) -> usize {
        self.0.base.nq() + self.0.joints.len()
    }
    fn nv(&self) -> usize {
        self.0.base.nv() + self.0.joints.len()
    }
    fn joint_name(&self, index: usize) -> Option<&str> {
        self.0.joints.get(index).map(|joint| joint.name.as_str())
    }
    fn joints(&self) -> usize {
        self.0.joints.len()
    }
    fn signature(&self, _: usize) -> Option<Signature<'_>> {
        None
    }
    fn argument_length(&self, _: bipedc_runtime::Argument) -> usize {
        0
    }
    fn evaluate(&self, _: usize, _: &State<'_, f64>, _: &mut [f64]) -> Result<(), CallError> {
        Err(CallError::UnknownFunction)
    }
}
