//! Ground that gives way.
use super::bodies::Body;
use bipedc_analysis::simulate::{Compliance, Ground};

#[test]
fn a_brick_sinks_by_weight_over_stiffness() {
    let brick = Body::brick(false, 0.0);
    for stiffness in [2e3, 1e5, 1e9] {
        let soft = Compliance { stiffness, damping: 50.0 };
        let mut stepper = brick.stepper(Ground { compliance: Some(soft), ..Ground::default() });
        let mut motion = brick.at(0.05);
        for _ in 0..4000 {
            stepper.step(&mut motion, &[0.0; 6], 1e-3).unwrap();
        }
        let sunk = 2.0 * 9.81 / (4.0 * stiffness);
        assert!((0.05 - motion.q[2] - sunk).abs() < 1e-3 * sunk + 1e-9, "{stiffness}: {:?} {sunk}", motion.q);
    }
}

#[test]
fn a_ball_on_a_spring_swings_with_its_frequency() {
    // Contact of half a period π √(m/k) with the speed turned around, without damping: first order in the step.
    let ball = Body::ball();
    let stiffness = 1000.0;
    let (mut times, mut speeds) = (Vec::new(), Vec::new());
    let half = std::f64::consts::PI * (ball.mass / stiffness).sqrt();
    for step in [2e-4, 1e-4, 5e-5] {
        let soft = Compliance { stiffness, damping: 0.0 };
        let mut body = ball.clone();
        body.gravity = [0.0; 3];
        let mut stepper = body.stepper(Ground { compliance: Some(soft), ..Ground::default() });
        let mut motion = body.at(0.0);
        motion.v[1] = -1.0;
        stepper.step(&mut motion, &[0.0; 3], step).unwrap();
        while motion.q[1] < 0.0 {
            stepper.step(&mut motion, &[0.0; 3], step).unwrap();
        }
        times.push((motion.time / half - 1.0).abs());
        speeds.push((motion.v[1] - 1.0).abs());
    }
    println!("errors of time {times:?} and speed {speeds:?}");
    assert!(times[2] < 2e-3 && speeds[2] < 0.6 * speeds[1] && speeds[1] < 0.6 * speeds[0], "{speeds:?}");
}

#[test]
fn impossible_grounds_are_refused() {
    let fine = Ground::default();
    let soft = |stiffness, damping| Ground { compliance: Some(Compliance { stiffness, damping }), ..fine };
    for wrong in [
        Ground { friction: -0.1, ..fine },
        Ground { friction: f64::NAN, ..fine },
        Ground { normal_restitution: 1.1, ..fine },
        Ground { tangential_restitution: -2.0, ..fine },
        Ground { recovery: f64::INFINITY, ..fine },
        soft(0.0, 1.0),
        soft(1e4, -1.0),
    ] {
        assert!(wrong.check().is_err(), "{wrong:?}");
    }
    assert!(fine.check().is_ok() && soft(1e4, 0.0).check().is_ok());
}
