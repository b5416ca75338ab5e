//! Feet that stand: how they share the ground's force, and what they tell of where the robot is.
use bipedc_runtime::Scalar;
use bipedc_runtime::walking::estimator::{Estimator, Fault, LegKinematics, Sensed, Settings};
use bipedc_runtime::walking::ground_forces::{Limits, Shared, StandingFoot, share};
use bipedc_runtime::walking::payload_observer::{PayloadObserver, Seen};
use bipedc_runtime::walking::space::{Pose, identity};
use core::hint::black_box;

/// A weight between two soles: half of it each; too much to the front: what the ground can give; nothing that makes sense: refused.
pub fn shares<R: Scalar + Into<f64>>(tolerance: f64) -> bool {
    let x = R::constant;
    let jacobian = [[x(0.0), x(0.0), x(0.3), x(0.0), x(0.0), x(0.0)]];
    let foot = |y: f64, joints| StandingFoot {
        sole: Pose { position: [x(0.0), x(y), x(0.0)], turn: identity() },
        extent: [x(-0.1), x(0.1), x(-0.05), x(0.05)],
        joints,
        jacobian: &jacobian,
        share: x(0.5),
    };
    let feet = black_box([foot(-0.1, &[0]), foot(0.1, &[1])]);
    let torque = black_box([x(25.0), x(20.0)]);
    let limits = Limits { friction: x(0.6), turning: x(0.05), least_load: x(1.0), torque: &torque };
    let shared = |feet: &[StandingFoot<'_, R>], front: f64| {
        let (mut torques, mut wrenches) = ([x(0.0); 2], [[x(0.0); 6]; 2]);
        let required = [x(0.0), x(0.0), x(150.0), x(0.0), x(-150.0 * front), x(0.0)];
        let found = share(feet, black_box(required), &limits, &mut torques, &mut wrenches);
        (found, torques[1], wrenches[1][2])
    };
    let (met, torque, load) = shared(&feet, 0.0);
    let near = |a: R, b: f64| (a - x(b)).abs().into() <= tolerance;
    let (beyond, ..) = shared(&feet, 0.3);
    let (alone, ..) = shared(&feet[..1], 0.0);
    let (refused, ..) = shared(&[], 0.0);
    met == Shared::Met
        && near(load, 66.666_666_666_666_67)
        && near(torque, -20.0)
        && matches!(beyond, Shared::GroundGaveWay { .. } | Shared::Clamped { .. })
        && alone != Shared::Met
        && refused == Shared::Refused
}

/// Legs of one sliding joint each.
struct Stilts;

impl<R: Scalar> LegKinematics<R> for Stilts {
    fn joints(&self) -> usize {
        2
    }

    fn sole(&self, foot: usize, joint_position: &[R], jacobian: &mut [[R; 6]]) -> Option<Pose<R>> {
        let x = R::constant;
        let (length, column) = (joint_position.get(foot)?, jacobian.get_mut(foot)?);
        *column = [x(0.0), x(0.0), x(-1.0), x(0.0), x(0.0), x(0.0)];
        let y = if foot == 0 { x(-0.1) } else { x(0.1) };
        Some(Pose { position: [x(0.0), y, -*length], turn: identity() })
    }
}

/// Stands for a second, then reads nonsense: the height is that of the legs, and stays finite.
pub fn stands<R: Scalar + Into<f64>>(tolerance: f64) -> bool {
    let x = R::constant;
    let mut estimator = Estimator::new(Settings::of_weight(x(150.0)), None);
    let mut right = true;
    for k in 0..200 {
        let nonsense = if k > 100 { x(f64::NAN) } else { x(1e-3) };
        let sensed = Sensed {
            time: x(0.005 * f64::from(k)),
            joint_position: &black_box([x(0.5), x(0.5)]),
            joint_velocity: None,
            angular_velocity: [nonsense, x(1e-4) * x(f64::from(k % 7)), x(0.0)],
            specific_force: [x(0.0), nonsense, x(9.81)],
            load: [x(75.0), x(75.0)],
            center: [[x(f64::NAN); 2]; 2],
            motor_position: &[],
        };
        let found = estimator.update(&sensed, black_box(&Stilts));
        right &= found.standing == [true; 2] && (k < 102 || found.fault == Some(Fault::Gyroscope));
    }
    let height = estimator.q().get(2).map_or(x(0.0), |z| *z);
    right && (height - x(0.5)).abs().into() <= tolerance && estimator.v().iter().all(|v| v.is_finite())
}

/// A robot at rest presses with a kilogram more than its model weighs.
pub fn weighs<R: Scalar + Into<f64>>(tolerance: f64) -> bool {
    let x = R::constant;
    let mut observer = PayloadObserver::new(x(196.2), x(0.3), x(9.81));
    let zero = [x(0.0); 3];
    for k in 0..4000 {
        let nonsense = if k == 1000 { x(f64::NAN) } else { x(103.005) };
        let seen = Seen {
            base: Pose { position: zero, turn: identity() },
            v: &black_box([x(0.0); 6]),
            momentum: [zero; 2],
            mass: x(20.0),
            center: zero,
            gravity: x(9.81),
            pressed: black_box([(zero, nonsense), (zero, x(103.005))]),
        };
        if k == 1001 {
            observer.pause();
        }
        observer.update(&seen, x(1e-3));
    }
    (observer.payload().mass - x(1.0)).abs().into() <= tolerance
}
