//! Virtual constraints: under the controller's torques every output obeys ÿ = v, in the plane and in space.
use super::described;
use bipedc::simulation::{plant, true_walker};
use bipedc_analysis::simulate::control::{Feedback, VirtualConstraints};
use bipedc_analysis::simulate::{Frame, Mechanics, Scenario};
use bipedc_runtime::control::{Controller, JointCommand, Observation};
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

/// Numbers in ±1 from a seed.
fn random(seed: &mut u64) -> f64 {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Largest `|ÿ − v|` over the outputs and some random states, relative to the larger of `|v|` and 1; by central differences of
/// `ẏ` along the motion of the constrained robot.
fn largest_miss(folder: &str, phase: &str, formulas: &[&str]) -> f64 {
    let robot = described(folder);
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let mut text = "method = \"event_driven\"\nduration = 1.0\n[control]\neffort_limits = false\n".to_owned();
    for formula in formulas {
        text += &format!("[[control.output]]\nphase = \"{phase}\"\nformula = \"{formula}\"\n");
    }
    let scenario = Scenario::parse(Path::new("s.toml"), &text, &plant).unwrap_or_else(|e| panic!("{e}"));
    let walker = true_walker(&robot, &[], true).unwrap();
    let (model, outputs) = (&walker.model, scenario.outputs.as_ref().unwrap());
    let names: Vec<&str> = walker.phases.iter().map(|phase| phase.dynamics.as_str()).collect();
    let mut controller = VirtualConstraints::new(model, plant.layout.base, outputs, &names).unwrap();
    let mechanics = Mechanics::new(model, plant.layout.base).unwrap();
    let number = plant.phases.iter().position(|name| name == phase).unwrap();
    let dynamics = Model::<f64>::function(model, names[number]).unwrap();
    let mut commands = vec![JointCommand::Off; Model::<f64>::joints(model)];
    let size = Model::<f64>::signature(model, dynamics).map_or(0, |s| s.rows);
    let (mut seed, mut worst) = (0x9e37_79b9_7f4a_7c15_u64, 0.0_f64);
    for _ in 0..20 {
        let mut q: Vec<f64> = (0..mechanics.nq()).map(|_| 0.5 * random(&mut seed)).collect();
        if mechanics.nq() > mechanics.nv() {
            let length = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
            q[3..7].iter_mut().for_each(|x| *x /= length);
        }
        let v: Vec<f64> = (0..mechanics.nv()).map(|_| random(&mut seed)).collect();
        let (mut tau, mut a) = (vec![0.0; v.len()], vec![0.0; size]);
        controller.command(&Observation::new(0.0, number, &q, &v), &mut commands).unwrap();
        let first = tau.len() - commands.len();
        for (tau, command) in tau[first..].iter_mut().zip(&commands) {
            *tau = command.torque(0.0, 0.0);
        }
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::Tau, &tau);
        model.evaluate(dynamics, &state, &mut a).unwrap();
        let mut rates = |h: f64| {
            // To second order: half of the way in the axes of the start, half in those of the end.
            let middle: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + 0.5 * h * a).collect();
            let later: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + h * a).collect();
            let mut q = q.clone();
            mechanics.advance(&mut q, &middle, 0.5 * h, Frame::Start);
            mechanics.advance(&mut q, &middle, 0.5 * h, Frame::End);
            controller.outputs(number, &q, &later)
        };
        // Near postures in which outputs are hard to drive accelerations are large.
        let h = 1e-4 / (1.0 + a.iter().fold(0.0, |m: f64, a| m.max(a.abs())));
        let (before, now, after) = (rates(-h), rates(0.0), rates(h));
        for i in 0..now.len() {
            let wanted = Feedback::default().at(now[i][0], now[i][1]);
            let found = (after[i][1] - before[i][1]) / (2.0 * h);
            let rate = (after[i][0] - before[i][0]) / (2.0 * h);
            let scale = wanted.abs().max(1.0);
            worst = worst.max((found - wanted).abs() / scale).max((rate - now[i][1]).abs() / scale);
        }
    }
    println!("{folder}, {phase}: ÿ and ẏ within {worst:.1e}");
    worst
}

#[test]
fn outputs_obey_their_feedback() {
    let five = [
        "base_pitch - 0.1 * sin(base_x)",
        "right_knee_pitch * left_knee_pitch + base_z^2",
        "left_foot_point_foot_x - exp(0.3 * left_foot_point_foot_z)",
        "left_hip_pitch / (2 + base_pitch) + tanh(right_hip_pitch)",
    ];
    assert!(largest_miss("robots/five_link", "single_support", &five) < 1e-6);
    // Fewer outputs than actuators, in phases with three and with four rows.
    let seven = ["base_z", "base_pitch - right_foot_toe_x", "left_foot_heel_z * 2"];
    assert!(largest_miss("robots/seven_link", "single_support", &seven) < 1e-6);
    assert!(largest_miss("robots/seven_link", "touch_down", &["base_z", "base_pitch"]) < 1e-6);
    let space = [
        "base_roll + 0.3 * base_pitch * base_yaw",
        "base_pitch - 0.2 * base_x",
        "base_yaw + base_y * base_z",
        "left_foot_front_left_x * left_foot_front_left_y",
        "left_foot_rear_right_z + right_knee_pitch^2",
    ];
    assert!(largest_miss("robots/biped_3d", "single_support", &space) < 1e-6);
}
