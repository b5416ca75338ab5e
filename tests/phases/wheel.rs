//! The rimless wheel: a closed form for the gait, by events and by time stepping.
use super::{described, passive, phased, ready};
use bipedc::simulation::true_model;
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::phases::{Assumptions, End, Precision, Start, walk};
use bipedc_analysis::simulate::{Ground, Mechanics, MotionState, Stepper, Tolerance};
use std::f64::consts::PI;

const FOLDER: &str = "tests/data/simulate/rimless_wheel";
const HALF: f64 = PI / 8.0;
const SLOPE: f64 = 0.08;
/// 1 kg at 1 m, and the hub's own inertia, kg m².
const INERTIA: [f64; 2] = [1.0, 0.3];

/// Speeds just after and before an impact in the gait (Coleman; with the hub's inertia), rad/s, and the multiplier.
fn gait() -> [f64; 3] {
    let [point, own] = INERTIA;
    let keeps = (own + point * (2.0 * HALF).cos()) / (own + point);
    // Energy gained per spoke: 2 g l sin α · 2 sin γ / (I + m l²).
    let gained = 4.0 * 9.81 * HALF.sin() * SLOPE.sin() * point / (own + point);
    let before = (gained / (1.0 - keeps * keeps)).sqrt();
    [keeps * before, before, keeps * keeps]
}

/// Just after an impact, spoke 0 ahead on the ground at the origin.
fn landed(speed: f64) -> Vec<f64> {
    let (s, c) = (-HALF).sin_cos();
    vec![s, c, -HALF, speed * c, -speed * s, speed]
}

#[test]
fn the_closed_form_holds_to_1e_10() {
    let walker = ready(FOLDER);
    let assumptions = Assumptions { scuffing: f64::INFINITY, ..Assumptions::default() };
    let robot = phased(&walker, assumptions, passive);
    let [after, before, multiplier] = gait();
    let start = |speed: f64| Start { time: 0.0, phase: 0, x: landed(speed) };
    let run = |speed: f64, spokes: usize| {
        let done = walk(&robot, start(speed), 1e3, spokes, &Precision::default(), &mut |_, _, _| ()).unwrap();
        assert_eq!(done.end, End::Changes);
        done
    };
    let once = run(after, 1);
    let miss = [once.changes[0].before[5] - before, once.changes[0].after[5] - after].map(f64::abs);
    println!(
        "after {:.12}, before {:.12}: {miss:?} from the closed form",
        once.last.x[5], once.changes[0].before[5]
    );
    assert!(miss.iter().all(|miss| *miss < 1e-10), "{miss:?}");
    let derivative = (run(after + 1e-4, 1).last.x[5] - run(after - 1e-4, 1).last.x[5]) / 2e-4;
    println!("multiplier {derivative:.9} (closed form {multiplier:.9})");
    assert!((derivative - multiplier).abs() < 1e-7, "{derivative}");
    // From another speed it rolls into the gait, around and around.
    let far = run(after + 0.3, 40);
    assert!((far.last.x[5] - after).abs() < 1e-8, "{}", far.last.x[5]);
}

#[test]
fn a_violated_assumption_ends_the_walk_and_is_named() {
    let walker = ready(FOLDER);
    let assumptions = Assumptions { scuffing: f64::INFINITY, friction: 0.2, ..Assumptions::default() };
    let robot = phased(&walker, assumptions, passive);
    let start = Start { time: 0.0, phase: 0, x: landed(gait()[0]) };
    let done = walk(&robot, start, 10.0, 10, &Precision::default(), &mut |_, _, _| ()).unwrap();
    let End::Violated(violation) = done.end else { panic!("{:?}", done.end) };
    println!("{violation:?}");
    assert_eq!((violation.phase.as_str(), violation.unit), ("spoke_0", "N"));
    assert!(violation.quantity.contains("wheel") && violation.value > violation.limit);
    // Too fast: the foot would have to pull.
    let start = Start { time: 0.0, phase: 0, x: landed(4.0) };
    let robot = phased(&walker, Assumptions { friction: f64::INFINITY, ..assumptions }, passive);
    let done = walk(&robot, start, 10.0, 10, &Precision::default(), &mut |_, _, _| ()).unwrap();
    let End::Violated(violation) = done.end else { panic!("{:?}", done.end) };
    assert!(violation.meaning.contains("pull") && violation.value < 0.0, "{violation:?}");
}

/// Speed just before the wheel's fifth impact and when that happens, by time stepping.
fn rolled(step: f64) -> (f64, f64) {
    let robot = described(FOLDER);
    let model = true_model(&robot, &[]).unwrap();
    let mechanics = Mechanics::new(&model, BaseKind::Planar).unwrap();
    let ground = Ground { friction: 50.0, ..Ground::default() };
    let mut stepper = Stepper::new(mechanics, ground, Vec::new(), Tolerance::default()).unwrap();
    let x = landed(gait()[0] + 0.2);
    let mut motion = MotionState { time: 0.0, q: x[..3].to_vec(), v: x[3..].to_vec() };
    let mut impacts = 0;
    loop {
        let before = motion.v[2];
        stepper.step(&mut motion, &[0.0; 3], step).unwrap();
        if motion.v[2] < before - 0.1 {
            impacts += 1;
            if impacts == 5 {
                return (before, motion.time);
            }
        }
        assert!(motion.time < 20.0, "{motion:?}");
    }
}

#[test]
fn time_stepping_and_events_agree_as_the_step_shrinks() {
    let walker = ready(FOLDER);
    let assumptions = Assumptions { scuffing: f64::INFINITY, ..Assumptions::default() };
    let robot = phased(&walker, assumptions, passive);
    let start = Start { time: 0.0, phase: 0, x: landed(gait()[0] + 0.2) };
    let exact = walk(&robot, start, 1e2, 5, &Precision::default(), &mut |_, _, _| ()).unwrap();
    let (speed, time) = (exact.changes[4].before[5], exact.changes[4].time);
    for step in [2e-3, 5e-4, 1.25e-4, 3e-5] {
        let found = rolled(step);
        let errors = [(found.0 - speed).abs(), (found.1 - time).abs()];
        println!(
            "step {step} s: speed before the fifth impact {:.1e} rad/s off, its time {:.1e} s",
            errors[0], errors[1]
        );
        // First order: every impact is late by up to half a step, and the next ones carry that on.
        assert!(errors[0] < 5.0 * step && errors[1] < 20.0 * step, "{step}: {errors:?}");
    }
}
