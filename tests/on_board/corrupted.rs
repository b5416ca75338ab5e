//! Whatever sensors say, torques are finite, within the drives' limits and change by little; what is wrong is said.
use super::corruption::{Wrong, below, nonsense};
use super::recorded::{Call, walk};
use bipedc_effects::random::Random;
use bipedc_runtime::control::JointCommand;
use bipedc_runtime::walking::OnBoardWalker;
use bipedc_runtime::walking::estimator::Sensed;
use tulip_controller::TulipController;
use tulip_controller::walking::{
    Actuators, BLIND_CALLS, Controller, GAINS, JOINTS, ROBOT, SEEING_CALLS, SETTINGS, TORQUE_CHANGE,
};

/// Calls until a joint that is elsewhere is believed, and more than a stalled clock takes.
const SETTLED: usize = 30;

/// Finite, within limits, near the last ones; the largest change in parts of the limit.
fn checked(asked: &Actuators, last: &[f64; JOINTS]) -> f64 {
    let change = |(joint, torque): (usize, &f64)| {
        let limit = ROBOT.torque[joint];
        assert!(torque.is_finite() && torque.abs() <= limit, "{asked:?}");
        (torque - last[joint]).abs() / limit
    };
    asked.torque.iter().enumerate().map(change).fold(0.0, f64::max)
}

/// How many calls were braked, the largest change of a torque in parts of its limit.
fn corrupted(calls: &[Call], count: usize, seed: u64) -> (usize, f64) {
    let mut random = Random::new(seed);
    let (mut braked, mut largest, mut done) = (0, 0.0_f64, 0);
    while done < count {
        let mut controller = Controller::default();
        controller.learn_payload(below(&mut random, 2) == 0);
        let (mut last, mut wrong, mut until, mut since) = ([0.0; JOINTS], Wrong::Nothing, 0, 0);
        let (mut before, mut blind) = (calls[0].sensors, 0_usize);
        for (place, call) in calls.iter().enumerate().take(count - done) {
            if place == until {
                (before, since) = (call.sensors, place);
                let longest = [3, 40, 400, 2000][below(&mut random, 4)];
                until = place + 1 + below(&mut random, longest);
                wrong = if below(&mut random, 2) == 0 { Wrong::Nothing } else { Wrong::random(&mut random) };
            }
            let (mut sensors, mut wanted) = (call.sensors, call.wanted);
            wrong.corrupt(&mut random, &before, &mut sensors, &mut wanted);
            let asked = controller.step(&sensors, wanted);
            largest = largest.max(checked(&asked, &last));
            last = asked.torque;
            braked += usize::from(asked.braked);
            let lost = !sensors.joint_position.iter().all(|x| x.is_finite())
                || !sensors.time.is_finite()
                || sensors.load.iter().all(|load| !load.is_finite());
            blind = if lost { blind + 1 } else { 0 };
            assert!(!lost || asked.estimated.fault.is_some(), "{wrong:?} {sensors:?}");
            assert!(blind < usize::from(BLIND_CALLS) || asked.braked, "{wrong:?} {asked:?}");
            let seen = if wrong == Wrong::Nothing { place - since } else { 0 };
            assert!(seen < usize::from(SEEING_CALLS) + 2 * SETTLED || !asked.braked, "{seen} {asked:?}");
        }
        done += calls.len().min(count - done);
    }
    assert!(largest <= TORQUE_CHANGE * (1.0 + 1e-12), "{largest}");
    (braked, largest)
}

#[test]
fn corrupted_sensors_give_finite_torques_without_jumps() {
    let calls = walk("corrupted", 4.0, "");
    let (braked, _) = corrupted(&calls, 20_000, 1);
    assert!(braked > 1000, "{braked}");
}

/// The same of motors before springs, in all joints, whose encoders say anything in one of five calls, and nearly the truth otherwise.
#[test]
fn corrupted_motors_give_finite_torques_without_jumps() {
    let calls = walk("motors", 4.0, "");
    let mut robot = ROBOT;
    robot.stiffness[..JOINTS].fill(100.0);
    robot.motor_inertia[..JOINTS].fill(0.025);
    let mut walker = OnBoardWalker::new(TulipController, robot, GAINS, SETTINGS);
    let (mut random, mut last, mut driven) = (Random::new(3), [0.0; JOINTS], 0);
    for call in &calls {
        let motors: [f64; JOINTS] = std::array::from_fn(|joint| match below(&mut random, 5) {
            0 => nonsense(&mut random),
            _ => call.sensors.joint_position[joint] + call.torque[joint] / 100.0 + 1e-4 * random.normal(),
        });
        let sensed = Sensed {
            time: call.sensors.time,
            joint_position: &call.sensors.joint_position,
            joint_velocity: Some(&call.sensors.joint_velocity),
            angular_velocity: call.sensors.angular_velocity,
            specific_force: call.sensors.specific_force,
            load: call.sensors.load,
            center: call.sensors.center,
            motor_position: &motors,
        };
        walker.walk(call.wanted);
        let mut commands = [JointCommand::Off; JOINTS];
        assert!(!walker.step(&sensed, &mut commands).braked);
        for (joint, command) in commands.iter().enumerate() {
            let (torque, limit) = (command.torque(0.0, 0.0), ROBOT.torque[joint]);
            assert!(torque.is_finite() && torque.abs() <= limit, "{torque} N m of {limit}");
            assert!((torque - last[joint]).abs() <= TORQUE_CHANGE * limit * (1.0 + 1e-12));
            driven += usize::from((torque - call.torque[joint]).abs() > 0.01 * limit);
            last[joint] = torque;
        }
    }
    // Springs are heard.
    assert!(driven > calls.len(), "{driven}");
}

#[test]
#[ignore = "takes long"]
fn a_million_calls_with_corrupted_sensors_give_finite_torques_without_jumps() {
    let calls = walk("million", 16.0, "");
    let (braked, largest) = corrupted(&calls, 1_000_000, 2);
    println!("{braked} calls braked; largest change of a torque {largest} of its limit");
}
