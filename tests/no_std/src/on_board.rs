//! The committed crate of TUlip's controller: walks on the spot by sensors that say that it stands, corrupted now and then.
use core::hint::black_box;
use tulip_controller::walking::{Controller, JOINTS, ROBOT, Sensors, TORQUE_CHANGE, Velocity};

/// Half of the weight, N.
const LOAD: f64 = 93.2;

/// So many calls, what is learned included; whether torques were always finite, within limits and near those before, and nonsense was named.
pub fn walks(calls: u32) -> bool {
    let mut controller = Controller::default();
    controller.learn_payload(true);
    let (mut last, mut right) = ([0.0; JOINTS], true);
    for k in 0..calls {
        let asked = controller.step(black_box(&sensors(k)), velocity(k));
        for ((torque, last), limit) in asked.torque.iter().zip(&mut last).zip(ROBOT.torque) {
            let change = if torque > last { torque - *last } else { *last - torque };
            right &= *torque <= limit && -torque <= limit && change <= TORQUE_CHANGE * limit * (1.0 + 1e-12);
            *last = *torque;
        }
        right &= k % 50 != 7 || asked.estimated.fault.is_some();
    }
    right & (controller.payload().mass < 5.0)
}

/// Alternately ahead, to the side and turning.
fn velocity(k: u32) -> Velocity<f64> {
    let zero = Velocity { forward: 0.0, left: 0.0, turning: 0.0 };
    match k / 1000 % 4 {
        0 => zero,
        1 => Velocity { forward: 0.3, ..zero },
        2 => Velocity { left: 0.1, ..zero },
        _ => Velocity { turning: f64::NAN, ..zero },
    }
}

/// A robot that stands and trembles; a joint or the clock says nonsense in one of fifty calls, everything for a while.
fn sensors(k: u32) -> Sensors {
    let tremble = f64::from(k % 7) * 1e-5;
    let mut joint_position = [0.0; JOINTS];
    for (joint, posture) in joint_position.iter_mut().zip(ROBOT.posture) {
        *joint = posture + tremble;
    }
    let mut sensors = Sensors {
        time: f64::from(k) * 1e-3,
        joint_position,
        joint_velocity: [tremble; JOINTS],
        angular_velocity: [tremble; 3],
        specific_force: [0.0, tremble, 9.81],
        load: [LOAD + tremble, LOAD],
        center: [[0.03, 0.0]; 2],
        motor_position: [f64::NAN; JOINTS],
    };
    // A foot that swings carries nothing.
    if k / 600 % 2 == 1 {
        sensors.load = [2.0 * LOAD, tremble];
    }
    if k % 50 == 7 {
        sensors.joint_position[(k / 50 % 12) as usize % JOINTS] = f64::NAN;
        sensors.time = if k % 100 == 7 { f64::INFINITY } else { sensors.time };
    }
    if k % 4000 > 3900 {
        (sensors.joint_position, sensors.load) = ([f64::NAN; JOINTS], [f64::NAN; 2]);
    }
    sensors
}
