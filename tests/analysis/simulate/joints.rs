//! Dry friction, stops, damping and rotors of joints.
use super::bodies::Pendulum;
use bipedc_analysis::simulate::{JointLaw, MotionState};

const ARM: Pendulum = Pendulum { inertia: 0.2, weight: 5.0 };

fn swing(law: JointLaw, start: f64, time: f64, torque: f64) -> (MotionState, f64) {
    let mut stepper = ARM.stepper(law);
    let mut motion = MotionState { time: 0.0, q: vec![start], v: vec![0.0] };
    for _ in 0..(time * 1000.0) as usize {
        stepper.step(&mut motion, &[torque], 1e-3).unwrap();
    }
    (motion, stepper.joint_impulse(0) / 1e-3)
}

#[test]
fn dry_friction_holds_up_to_its_limit() {
    let law = JointLaw { dry: [1.0, 0.5], ..JointLaw::default() };
    // Gravity pulls a joint at +0.1 rad back with 0.499 N m: friction against negative motion holds 0.5.
    let angle = 0.998 * (0.1_f64).asin();
    let (held, friction) = swing(law, angle, 2.0, 0.0);
    assert!((held.q[0] - angle).abs() < 1e-14 && held.v[0].abs() < 1e-14, "{held:?}");
    assert!((friction - ARM.weight * angle.sin()).abs() < 1e-9, "{friction}");
    // Beyond, it moves; and it comes to rest where gravity is held again.
    let (moved, _) = swing(law, 1.2, 20.0, 0.0);
    assert!(moved.v[0].abs() < 1e-14 && moved.q[0] < 1.19, "{moved:?}");
    let pull = ARM.weight * moved.q[0].sin();
    assert!((-1.0..=0.5).contains(&pull), "{pull}");
}

#[test]
fn a_sliding_joint_loses_what_friction_takes() {
    // Constant torque against constant friction without gravity: a = (τ − f)/I, at rotor inertia too.
    let weightless = Pendulum { inertia: 0.2, weight: 0.0 };
    let law = JointLaw { dry: [1.0, 1.0], rotor_inertia: 0.3, ..JointLaw::default() };
    let mut stepper = weightless.stepper(law);
    let mut motion = MotionState { time: 0.0, q: vec![0.0], v: vec![0.0] };
    for _ in 0..1000 {
        stepper.step(&mut motion, &[3.0], 1e-3).unwrap();
    }
    assert!((motion.v[0] - 4.0).abs() < 1e-9 && (motion.q[0] - 2.0).abs() < 1e-9, "{motion:?}");
}

#[test]
fn stops_hold() {
    let law = JointLaw { limits: Some([-0.4, 0.9]), ..JointLaw::default() };
    let (low, force) = swing(law, 0.6, 5.0, -10.0);
    assert!((low.q[0] + 0.4).abs() < 1e-9 && low.v[0].abs() < 1e-9, "{low:?}");
    assert!((force - (10.0 + ARM.weight * low.q[0].sin())).abs() < 1e-6, "{force}");
    let (high, force) = swing(law, 0.6, 5.0, 10.0);
    assert!((high.q[0] - 0.9).abs() < 1e-9 && force < 0.0, "{high:?} {force}");
    assert!(law.check().is_ok() && JointLaw { limits: Some([1.0, 1.0]), ..law }.check().is_err());
}

#[test]
fn stops_are_not_overrun() {
    // Struck at 7 rad/s and more, with steps of 1 ms: 20 mrad beyond if it were seen only from behind.
    for (torque, speed) in [(10.0, 20.0), (-10.0, -20.0), (3.0, 0.0), (0.0, 5.0), (-40.0, 3.0)] {
        for step in [1e-3, 3.3e-4] {
            let law = JointLaw { limits: Some([-0.4, 0.9]), ..JointLaw::default() };
            let mut stepper = ARM.stepper(law).accounted();
            let mut motion = MotionState { time: 0.0, q: vec![0.2], v: vec![speed] };
            let (mut most, mut struck) = (f64::NEG_INFINITY, 0);
            while motion.time < 3.0 {
                let before = motion.v[0];
                stepper.step(&mut motion, &[torque], step).unwrap();
                most = most.max(motion.q[0] - 0.9).max(-0.4 - motion.q[0]);
                // It strikes without rebound: what it has then is from the torque alone.
                assert!(before * motion.v[0] >= -0.1, "{before} {motion:?}");
                struck += usize::from(stepper.joint_impulse(0) != 0.0);
            }
            println!("{torque} N m, {speed} rad/s, step {step} s: overrun {most:.1e} rad");
            assert!(most < 1e-9 && struck > 0, "{most} {struck}");
            assert!(stepper.account().unwrap().stops >= 0.0);
        }
    }
}

#[test]
fn damping_is_right_and_never_unstable() {
    let weightless = Pendulum { inertia: 0.2, weight: 0.0 };
    for (damping, time) in [(0.2, 1.0), (1e5, 1.0)] {
        let mut stepper = weightless.stepper(JointLaw { damping, ..JointLaw::default() });
        let mut motion = MotionState { time: 0.0, q: vec![0.0], v: vec![1.0] };
        for _ in 0..1000 {
            stepper.step(&mut motion, &[0.0], 1e-3).unwrap();
        }
        let exact = f64::exp(-damping * time / 0.2);
        if damping < 1.0 {
            assert!((motion.v[0] - exact).abs() < 1e-6, "{motion:?} {exact}");
        }
        assert!(motion.v[0].abs() <= 1.0, "{motion:?}");
    }
}
