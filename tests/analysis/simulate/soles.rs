//! Flat soles that turn on the spot: against the closed form of a spinning brick.
use super::bodies::Body;
use bipedc_analysis::simulate::{Cone, Ground, MotionState};

/// A brick that lies on its sole, sliding at `speed` along x and turning at `rate`, after `time`.
fn turned(friction: f64, turning: f64, speed: f64, rate: f64, time: f64, cone: Cone) -> (MotionState, f64) {
    let brick = Body::brick(false, 0.0);
    let ground = Ground { friction, cone, ..Ground::default() };
    let sole = 0..4;
    let mut stepper = brick.stepper(ground).with_soles(vec![sole], turning).unwrap();
    let mut motion = brick.at(0.0);
    (motion.v[0], motion.v[5]) = (speed, rate);
    let mut worst = 0.0_f64;
    let step = 1e-3;
    for _ in 0..(time / step).round() as usize {
        let stepped = stepper.step(&mut motion, &[0.0; 6], step).unwrap();
        worst = worst.max(stepped.solved.residual);
    }
    (motion, worst)
}

#[test]
fn a_turning_sole_is_braked_by_its_radius() {
    let brick = Body::brick(false, 0.0);
    // I dω/dt = −r μ m g: 0.02 m at μ = 1.
    let brake = 0.02 * brick.mass * 9.81 / brick.inertia[2];
    let time = 0.5 * 2.0 / brake;
    let (motion, worst) = turned(1.0, 0.02, 0.0, 2.0, time, Cone::Round);
    let steps = (time / 1e-3).round() * 1e-3;
    assert!((motion.v[5] - (2.0 - brake * steps)).abs() < 1e-6, "{motion:?}");
    assert!(worst < 1e-8, "{worst}");
    // Then it stays where it is.
    let (motion, _) = turned(1.0, 0.02, 0.0, 2.0, 3.0 * time, Cone::Round);
    assert!(motion.v[5].abs() < 1e-9, "{motion:?}");
}

#[test]
fn sliding_and_turning_do_not_share_their_friction() {
    let brick = Body::brick(false, 0.0);
    for cone in [Cone::Round, Cone::Pyramid] {
        let (motion, worst) = turned(0.3, 0.01, 1.0, 1.0, 0.1, cone);
        let angle = 2.0 * motion.q[5].atan2(motion.q[6]);
        let speed = (motion.v[0].powi(2) + motion.v[1].powi(2)).sqrt();
        assert!((speed - (1.0 - 0.3 * 9.81 * 0.1)).abs() < 1e-4, "{cone:?} {speed}");
        let brake = 0.01 * brick.mass * 9.81 / brick.inertia[2];
        assert!((motion.v[5] - (1.0 - brake * 0.1)).abs() < 1e-4, "{cone:?} {motion:?}");
        assert!(angle > 0.05 && worst < 1e-8, "{cone:?} {angle} {worst}");
    }
}

#[test]
fn a_sole_that_may_not_turn_sticks() {
    let (motion, worst) = turned(0.8, 0.5, 0.0, 0.01, 0.05, Cone::Round);
    assert!(motion.v.iter().all(|v| v.abs() < 1e-9) && worst < 1e-8, "{motion:?} {worst}");
}
