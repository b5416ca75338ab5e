//! Joints whose motor pulls at a spring: how it is driven so that the spring gives the joint what is wished.
use super::robot::{MOST_VELOCITIES, WalkingRobot};
use super::steps::clamp;
use crate::control::slices::{get, set};
use crate::real::Scalar;

/// Natural frequency with which a spring's torque follows what is wished, rad/s.
const FREQUENCY: f64 = 200.0;
/// The same, times the time between two calls, at most.
const PER_CALL: f64 = 0.2;
/// Time constant of the stretch's rate, s.
const FILTER: f64 = 1e-3;
/// Times the drive's limit: more than that a spring does not carry, its motor's reading is not believed.
const CARRIED: f64 = 3.0;

/// How far springs are stretched, and how fast.
///
/// A motor of inertia J that pulls at a spring k (4.29) turns by J δ̈ = τ − k δ − J q̈, δ its stretch. With
/// τ = τ\_w + a (τ\_w − k δ) − 2 J ω δ̇ and (1 + a) k = J ω² the spring's torque k δ follows the wished one τ\_w as
/// δ̈ + 2 ω δ̇ + ω² δ = ω² τ\_w/k − q̈: critically damped where a > 0. Springs that are faster than ω are damped alone (a = 0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Springs<R> {
    /// rad; not a number: not known.
    stretch: [R; MOST_VELOCITIES],
    /// rad/s
    rate: [R; MOST_VELOCITIES],
}

impl<R: Scalar> Springs<R> {
    /// Nothing is known of them.
    pub fn new() -> Self {
        Self { stretch: [R::constant(f64::NAN); MOST_VELOCITIES], rate: [R::constant(0.0); MOST_VELOCITIES] }
    }

    /// Makes torques of joints those of their motors, `step` s after the last call. `joints`, `motors`: angles, rad; a joint of which one is no number, or
    /// whose spring would carry more than it can, keeps its torque.
    pub fn drive(
        &mut self,
        robot: &WalkingRobot<R>,
        (joints, motors): (&[R], &[R]),
        step: R,
        torques: &mut [R],
    ) {
        let o = R::constant(0.0);
        for (joint, ((q, motor), torque)) in joints.iter().zip(motors).zip(torques).enumerate() {
            let (stiffness, inertia) = (get(&robot.stiffness, joint), get(&robot.motor_inertia, joint));
            if !stiffness.is_finite() {
                continue;
            }
            let (limit, stretch) = (get(&robot.torque, joint), *motor - *q);
            let before = get(&self.stretch, joint);
            let carried = stiffness * stretch;
            if !stretch.is_finite() || carried.abs() > R::constant(CARRIED) * limit {
                set(&mut self.stretch, joint, R::constant(f64::NAN));
                continue;
            }
            let known = before.is_finite() && step > o;
            let rate = if known {
                let last = get(&self.rate, joint);
                last + ((stretch - before) / step - last) * step / (R::constant(FILTER) + step)
            } else {
                o
            };
            set(&mut self.stretch, joint, stretch);
            set(&mut self.rate, joint, rate);
            let most = R::constant(FREQUENCY);
            let frequency =
                if step * most > R::constant(PER_CALL) { R::constant(PER_CALL) / step } else { most };
            let gain = (inertia * frequency * frequency / stiffness - R::constant(1.0)).larger(o);
            let correction = gain * (*torque - carried) - R::constant(2.0) * inertia * frequency * rate;
            *torque = clamp(*torque + clamp(correction, -limit, limit), -limit, limit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walking::robot::Leg;
    use crate::walking::space::{Pose, identity, zero};

    const INERTIA: f64 = 0.025;
    const STIFFNESS: f64 = 100.0;

    fn robot(limit: f64) -> WalkingRobot<f64> {
        let leg = Leg {
            position: 0,
            rotation: 0,
            jacobian: 0,
            jacobian_rate: 0,
            joints: [0; 6],
            sole: Pose { position: zero(), turn: identity() },
            extent: [0.0; 4],
            foot: 0,
            knee: 0,
            bends: 1.0,
        };
        let mut stiffness = [f64::INFINITY; MOST_VELOCITIES];
        stiffness[1] = STIFFNESS;
        WalkingRobot {
            legs: [leg, leg],
            mass_matrix: 0,
            bias: 0,
            center_of_mass: 0,
            center_of_mass_velocity: 0,
            heading: identity(),
            lengths: [8, 7],
            gravity: 9.81,
            torque: [limit; MOST_VELOCITIES],
            posture: [0.0; MOST_VELOCITIES],
            stiffness,
            motor_inertia: [INERTIA; MOST_VELOCITIES],
            load_gain: [1.0; 2],
            load_bias: [0.0; 2],
        }
    }

    /// Torque of the spring, millisecond by millisecond, of a joint that stands still: by the law, or by the wished torque alone.
    fn pulled(wished: f64, driven: bool) -> [f64; 300] {
        let (robot, mut springs) = (robot(1e3), Springs::new());
        let (mut angle, mut speed) = (0.0, 0.0);
        core::array::from_fn(|call| {
            let mut torques = [0.0, wished];
            if driven {
                springs.drive(
                    &robot,
                    (&[0.0; 2], &[f64::NAN, angle]),
                    f64::from(u8::from(call > 0)) * 1e-3,
                    &mut torques,
                );
            }
            for _ in 0..100 {
                speed += 1e-5 * (torques[1] - STIFFNESS * angle) / INERTIA;
                angle += 1e-5 * speed;
            }
            STIFFNESS * angle
        })
    }

    /// Within 40 ms to 2 % and without swinging, where the torque alone makes the spring swing between nothing and twice what is wished.
    #[test]
    fn the_spring_gives_what_is_wished() {
        let given = pulled(10.0, true);
        assert!(given[40..].iter().all(|torque| (torque - 10.0).abs() < 0.2), "{given:?}");
        assert!(given.iter().all(|torque| *torque < 10.1), "{given:?}");
        let alone = pulled(10.0, false);
        assert!(alone.iter().any(|torque| *torque > 19.0) && alone[250..].iter().any(|torque| *torque < 1.0));
    }

    /// Joints without springs, angles that nobody measures or that cannot be: torques stay. Limits hold.
    #[test]
    fn what_is_not_known_stays() {
        let driven = |limit: f64, joints: &[f64], motors: &[f64]| {
            let mut torques = [3.0, 5.0];
            Springs::new().drive(&robot(limit), (joints, motors), 1e-3, &mut torques);
            torques
        };
        assert_eq!(driven(20.0, &[0.0; 2], &[]), [3.0, 5.0]);
        assert_eq!(driven(20.0, &[0.0; 2], &[0.1, f64::NAN]), [3.0, 5.0]);
        assert_eq!(driven(20.0, &[0.0; 2], &[0.1, 0.7]), [3.0, 5.0], "70 N m behind a drive of 20 N m");
        assert_eq!(driven(20.0, &[0.0; 2], &[0.1, 0.0]), [3.0, 20.0]);
        // 5 + 9 (5 − 6)
        assert!((driven(20.0, &[0.0; 2], &[0.1, 0.06])[1] + 4.0).abs() < 1e-12);
    }
}
