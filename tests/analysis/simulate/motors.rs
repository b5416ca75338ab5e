//! Motors of their own: springs against an independent integrator, play against closed forms; servos inside drives.
use super::bodies::Pendulum;
use bipedc_analysis::simulate::{DriveServo, JointLaw, MotionState, MotorLaw, Stepper};

const ARM: Pendulum = Pendulum { inertia: 0.2, weight: 5.0 };
const WEIGHTLESS: Pendulum = Pendulum { inertia: 0.2, weight: 0.0 };
const MOTOR: MotorLaw = MotorLaw {
    joint: 0,
    inertia: 0.05,
    damping: 0.0,
    dry: [0.0; 2],
    stiffness: f64::INFINITY,
    spring_damping: 0.0,
    gap: 0.0,
};

fn at(q: f64, v: f64) -> MotionState {
    MotionState { time: 0.0, q: vec![q], v: vec![v] }
}

fn driven<'a>(arm: &'a Pendulum, motor: MotorLaw, motion: &MotionState) -> Stepper<'a> {
    arm.stepper(JointLaw::default()).with_motors(vec![motor], motion).unwrap()
}

/// Angle and speed of joint and motor after one second under 1 N m at the motor.
fn swung(step: f64) -> [f64; 4] {
    let motor = MotorLaw { damping: 0.4, stiffness: 80.0, spring_damping: 0.3, ..MOTOR };
    let mut motion = at(0.5, -0.3);
    let mut stepper = driven(&ARM, motor, &motion);
    for _ in 0..(1.0 / step).round() as usize {
        stepper.step(&mut motion, &[0.0, 1.0], step).unwrap();
    }
    let [angle, rate] = stepper.motor(0);
    [motion.q[0], motion.v[0], angle, rate]
}

/// SciPy 1.x, DOP853, relative tolerance 1e-13: 0.2 q̈ = F − 5 sin q, 0.05 θ̈ = 1 − 0.4 θ̇ − F, F = 80 (θ − q) + 0.3 (θ̇ − q̇).
const SWUNG: [f64; 4] = [0.16362836215238707, 0.5665788929869076, 0.17330168029213233, 0.5741720306621819];

#[test]
fn a_spring_is_of_second_order() {
    let errors: Vec<f64> = [2e-3, 1e-3, 5e-4]
        .map(|step| swung(step).iter().zip(SWUNG).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max))
        .to_vec();
    let orders: Vec<f64> = errors.windows(2).map(|e| f64::log2(e[0] / e[1])).collect();
    println!("errors {errors:?}, orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.1), "{orders:?}");
    assert!(errors[1] < 1e-4, "{errors:?}");
}

#[test]
fn springs_of_any_stiffness_are_stable_and_stiff_ones_are_rigid() {
    // The same arm with the rotor on its shaft.
    let rigid = {
        let mut stepper = ARM.stepper(JointLaw { rotor_inertia: 0.05, ..JointLaw::default() });
        let mut motion = at(0.5, 0.0);
        (0..1000).for_each(|_| {
            stepper.step(&mut motion, &[1.0], 1e-3).unwrap();
        });
        motion
    };
    for exponent in 2..=14 {
        let stiffness = 10f64.powi(exponent);
        let mut motion = at(0.5, 0.0);
        let mut stepper = driven(&ARM, MotorLaw { stiffness, ..MOTOR }, &motion);
        let mut most = 0.0_f64;
        for _ in 0..1000 {
            stepper.step(&mut motion, &[0.0, 1.0], 1e-3).unwrap();
            most = most.max(motion.v[0].abs());
        }
        let apart = (motion.q[0] - rigid.q[0]).abs();
        println!("1e{exponent} N m/rad: {apart:.2e} rad from the rigid arm, at most {most:.2} rad/s");
        assert!(most < 6.0);
        if exponent >= 6 {
            assert!(apart < 1e-5, "{apart}");
        }
    }
}

#[test]
fn energy_of_a_soft_spring_stays() {
    // 1 and 0.2 kg m² on 80 N m/rad for 20 s: 44 swings.
    let mut motion = at(0.0, 0.0);
    let mut stepper = driven(&WEIGHTLESS, MotorLaw { stiffness: 80.0, ..MOTOR }, &motion);
    stepper.step(&mut motion, &[0.0, 1000.0], 1e-3).unwrap();
    let energy = |motion: &MotionState, stepper: &Stepper<'_>| {
        let [angle, rate] = stepper.motor(0);
        0.1 * motion.v[0].powi(2) + 0.025 * rate.powi(2) + 40.0 * (angle - motion.q[0]).powi(2)
    };
    let before = energy(&motion, &stepper);
    for _ in 0..20_000 {
        stepper.step(&mut motion, &[0.0, 0.0], 1e-3).unwrap();
    }
    let after = energy(&motion, &stepper);
    println!("{before} J, after 20 s {after} J");
    assert!(after <= before * (1.0 + 1e-9) && after > 0.99 * before, "{before} {after}");
}

#[test]
fn two_masses_with_play_between_them_strike_and_stay_together() {
    for step in [1e-3, 7e-4, 1.3e-4] {
        let mut motion = at(0.0, 0.0);
        let mut stepper = driven(&WEIGHTLESS, MotorLaw { gap: 0.0202, ..MOTOR }, &motion);
        // A push of 0.05 N m s: the motor turns at 1 rad/s, and reaches the stop after 10.1 ms.
        stepper.step(&mut motion, &[0.0, 0.05 / step], step).unwrap();
        assert!((stepper.motor(0)[1] - 1.0).abs() < 1e-12 && motion.v[0].abs() < 1e-12);
        let mut most = 0.0_f64;
        while motion.time < 0.1 {
            stepper.step(&mut motion, &[0.0, 0.0], step).unwrap();
            most = most.max(stepper.motor(0)[0] - motion.q[0]);
        }
        let [angle, rate] = stepper.motor(0);
        // Plastic: 0.05 · 1 = (0.05 + 0.2) · 0.2.
        assert!((rate - 0.2).abs() < 1e-12 && (motion.v[0] - 0.2).abs() < 1e-12, "{rate} {motion:?}");
        assert!((angle - motion.q[0] - 0.0101).abs() < 1e-12 && most < 0.0101 + 1e-12, "{angle} {most}");
        // The motor began half a step late; the instant is known to a step.
        let exact = 0.2 * (motion.time - 0.5 * step - 0.0101);
        assert!((motion.q[0] - exact).abs() < 0.2 * 1.5 * step, "{step}: {} {exact}", motion.q[0]);
    }
}

#[test]
fn play_rests_on_the_side_to_which_the_torque_pushes() {
    // A servo holds the motor, gravity pulls the arm back from 0.4 rad: lower stop of the arm, upper of the motor.
    let mut motion = at(0.4, 0.0);
    let mut stepper = driven(&ARM, MotorLaw { gap: 0.03, ..MOTOR }, &motion);
    let servo = DriveServo {
        axis: 1,
        stiffness: 400.0,
        damping: 8.0,
        wanted: [0.4, 0.0],
        bias: 0.0,
        limits: [-50.0, 50.0],
    };
    stepper.set_servos([servo].into_iter());
    for _ in 0..3000 {
        stepper.step(&mut motion, &[0.0, 0.0], 1e-3).unwrap();
    }
    let [angle, _] = stepper.motor(0);
    assert!((angle - motion.q[0] - 0.015).abs() < 1e-9, "{angle} {motion:?}");
    let pull = ARM.weight * motion.q[0].sin();
    let torques = [stepper.spring_torque(0), stepper.servo_torque(1, 1e-3), 400.0 * (0.4 - angle)];
    assert!(torques.iter().all(|torque| (torque - pull).abs() < 1e-6), "{torques:?} {pull}");
    // With a spring behind the play the arm sinks by its torque over the stiffness besides.
    let mut motion = at(0.4, 0.0);
    let motor = MotorLaw { gap: 0.03, stiffness: 900.0, spring_damping: 2.0, ..MOTOR };
    let mut stepper = driven(&ARM, motor, &motion);
    stepper.set_servos([servo].into_iter());
    for _ in 0..5000 {
        stepper.step(&mut motion, &[0.0, 0.0], 1e-3).unwrap();
    }
    let stretch = stepper.motor(0)[0] - motion.q[0];
    let pull = ARM.weight * motion.q[0].sin();
    assert!((stretch - 0.015 - pull / 900.0).abs() < 1e-7, "{stretch} {pull}");
}

fn followed(step: f64, gain: f64, limit: f64) -> (MotionState, f64) {
    let mut motion = at(0.5, -0.3);
    let mut stepper = ARM.stepper(JointLaw::default());
    let mut torque = 0.0;
    for i in 0..(1.0 / step).round() as usize {
        let t = (i as f64 + 0.5) * step;
        stepper.set_servos(
            [DriveServo {
                axis: 0,
                stiffness: 120.0 * gain,
                damping: 6.0 * gain,
                wanted: [0.4 * (3.0 * t).sin(), 1.2 * (3.0 * t).cos()],
                bias: 0.0,
                limits: [-limit, limit],
            }]
            .into_iter(),
        );
        stepper.step(&mut motion, &[0.0], step).unwrap();
        torque = stepper.servo_torque(0, step);
    }
    (motion, torque)
}

#[test]
fn a_servo_inside_the_drive_is_of_second_order_and_stable_for_any_gains() {
    // SciPy, DOP853: 0.2 q̈ = 120 (0.4 sin 3t − q) + 6 (1.2 cos 3t − q̇) − 5 sin q.
    let exact = [0.053546333307961526, -1.1586824267261988];
    let errors: Vec<f64> = [2e-3, 1e-3, 5e-4]
        .iter()
        .map(|step| {
            let (motion, _) = followed(*step, 1.0, f64::INFINITY);
            (motion.q[0] - exact[0]).abs().max((motion.v[0] - exact[1]).abs())
        })
        .collect();
    let orders: Vec<f64> = errors.windows(2).map(|e| f64::log2(e[0] / e[1])).collect();
    println!("errors {errors:?}, orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15) && errors[1] < 1e-4, "{errors:?}");
    for gain in [1e2, 1e4, 1e8] {
        let (motion, torque) = followed(1e-3, gain, f64::INFINITY);
        let wanted = [0.4 * 3f64.sin(), 1.2 * 3f64.cos()];
        println!("gain {gain:e}: {:?} for {wanted:?}, {torque} N m", [motion.q[0], motion.v[0]]);
        // What is left: the wanted speed is that in the middle of a step, half a step late.
        assert!((motion.q[0] - wanted[0]).abs() < 2e-3 / gain + 5e-5, "{motion:?}");
    }
    // Clipped torques are at their limit exactly, and the arm cannot be lifted.
    let (motion, torque) = followed(1e-3, 1e4, 0.5);
    assert!(torque.abs() <= 0.5 * (1.0 + 1e-9) && motion.q[0].abs() < 0.6, "{torque} {motion:?}");
}

/// A servo that follows a swing for half a second, with a row of its own in every step (`rows`) or as the stepper chooses: angle, speed and
/// torque after each step.
fn followed_by_rows(rows: bool, limit: f64) -> Vec<[f64; 3]> {
    let mut motion = at(0.5, -0.3);
    let mut stepper = ARM.stepper(JointLaw { dry: [0.2; 2], ..JointLaw::default() });
    if rows {
        // What sums works has them all in rows.
        stepper = stepper.accounted();
    }
    let step = |i: usize| {
        let t = (i as f64 + 0.5) * 1e-3;
        let servo = DriveServo {
            axis: 0,
            stiffness: 120.0,
            damping: 6.0,
            wanted: [0.4 * (9.0 * t).sin(), 3.6 * (9.0 * t).cos()],
            bias: 0.1,
            limits: [-limit, limit],
        };
        stepper.set_servos([servo].into_iter());
        stepper.step(&mut motion, &[0.0], 1e-3).unwrap();
        [motion.q[0], motion.v[0], stepper.servo_torque(0, 1e-3)]
    };
    (0..500).map(step).collect()
}

#[test]
fn servos_give_the_same_within_the_mass_matrix_and_in_rows() {
    for limit in [f64::INFINITY, 4.0] {
        let (found, by_rows) = (followed_by_rows(false, limit), followed_by_rows(true, limit));
        let most = by_rows.iter().fold(0.0, |most: f64, row| most.max(row[2].abs()));
        // With the limit it is at work for a while, and lets go again.
        assert!(if limit.is_finite() { (most - limit).abs() < 1e-9 } else { most > 5.0 }, "{most}");
        for (found, by_rows) in found.iter().zip(&by_rows) {
            let apart: [f64; 3] = std::array::from_fn(|i| (found[i] - by_rows[i]).abs());
            assert!(apart[0] < 1e-8 && apart[1] < 1e-7 && apart[2] < 1e-5, "{found:?} {by_rows:?}");
        }
    }
}

#[test]
fn impossible_motors_are_refused() {
    let motion = at(0.0, 0.0);
    let refused = |laws: Vec<MotorLaw>| {
        let stepper = ARM.stepper(JointLaw::default()).with_motors(laws, &motion);
        stepper.err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert!(refused(vec![MOTOR]).contains("stiffness"));
    assert!(refused(vec![MotorLaw { gap: f64::NAN, ..MOTOR }]).contains("gap"));
    assert!(refused(vec![MotorLaw { inertia: 0.0, gap: 0.1, ..MOTOR }]).contains("rotor inertia"));
    assert!(refused(vec![MotorLaw { gap: 0.1, ..MOTOR }; 2]).contains("motor 1 does not stand"));
    assert!(refused(vec![MotorLaw { gap: 0.1, joint: 1, ..MOTOR }]).contains("motor 0 does not stand"));
}
