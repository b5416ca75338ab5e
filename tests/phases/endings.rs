//! How the phases of the robots end, and feet that tip.
use super::{phased, ready};
use bipedc_analysis::simulate::phases::{Assumptions, End, Ending, Precision, Start, walk};
use bipedc_runtime::control::{JointCommand, Observation, Servo};

#[test]
fn phases_end_as_the_thesis_says() {
    // Table 4.1: heel unloaded, swing heel lands, swing toe lands, rear toe lets go.
    let seven = ready("robots/seven_link");
    let endings: Vec<&Ending> = seven.phases.iter().map(|phase| &phase.ending).collect();
    // Points: right heel, right toe, left heel, left toe.
    let expected =
        [Ending::Tip(0, vec![1]), Ending::Touch(vec![2]), Ending::Touch(vec![3]), Ending::Release(1)];
    assert_eq!(endings, expected.iter().collect::<Vec<_>>());
    assert_eq!(seven.phases.iter().map(|phase| phase.next).collect::<Vec<_>>(), [1, 2, 3, 0]);
    let tulip = ready("robots/tulip");
    assert_eq!(tulip.phases[0].ending, Ending::Touch(vec![4, 5, 6, 7]));
    assert_eq!(tulip.phases[1].ending, Ending::Release(0));
    assert_eq!(tulip.phases[0].rows.len(), 6);
}

/// The seven-link walker upright on its right foot, the left one lifted, leaning by so much.
fn leaning(lean: f64, speed: f64) -> (Vec<f64>, usize) {
    let (nq, joints) = (9, 6);
    let mut x = vec![0.0; 2 * nq];
    // Right ankle keeps the foot flat; left knee bent.
    (x[2], x[3 + 2]) = (lean, -lean);
    (x[3 + 3], x[3 + 4], x[3 + 5]) = (-0.4, 0.8, -0.4);
    // Turning about the ankle, 0.092 m above the ground.
    (x[nq + 2], x[nq + 3 + 2]) = (speed, -speed);
    (x, joints)
}

#[test]
fn a_foot_tips_when_its_centre_of_pressure_reaches_the_toe() {
    let walker = ready("robots/seven_link");
    let (x, joints) = leaning(0.05, 0.6);
    let start_posture = x.clone();
    // Stiff everywhere: the ankle holds until the foot gives way.
    let hold = move |_: &Observation<'_, f64>, commands: &mut [JointCommand<f64>]| {
        assert_eq!(commands.len(), joints);
        for (command, &position) in commands.iter_mut().zip(&start_posture[3..]) {
            let (stiffness, damping, limit) = (400.0, 20.0, f64::INFINITY);
            let servo = Servo { position, velocity: 0.0, stiffness, damping, torque: 0.0, limit };
            *command = JointCommand::Servo(servo);
        }
        Ok(())
    };
    let assumptions = Assumptions { scuffing: f64::INFINITY, ..Assumptions::default() };
    let robot = phased(&walker, assumptions, hold);
    // The base so that the right foot stands at rest on the ground.
    let mut x = x;
    let heights = robot.heights(&x[..9]);
    x[1] -= heights[0];
    let ankle = 0.092;
    let hip = x[1] - ankle;
    (x[9], x[10]) = (0.6 * hip * 0.05_f64.cos(), -0.6 * hip * 0.05_f64.sin());
    let start = Start { time: 0.0, phase: 0, x };
    let precision = Precision { relative: 1e-10, absolute: 1e-10, ..Precision::default() };
    let mut forces = Vec::new();
    let done = walk(&robot, start, 1.0, 1, &precision, &mut |time, phase, x| {
        forces.push((time, robot.forces(phase, time, x)));
    })
    .unwrap();
    assert_eq!(done.end, End::Changes, "{:?}", done.end);
    let change = &done.changes[0];
    assert_eq!((change.from, change.passage.to), (0, 1));
    // Velocities do not jump where a foot only begins to tip.
    assert_eq!(change.before, change.after);
    let (time, last) = forces.last().unwrap();
    let pressure = -last[2] / last[1];
    println!("tips after {time:.4} s with the pressure {pressure:.9} m before the middle of the sole");
    assert!((pressure - 0.12).abs() < 1e-9, "{pressure}");
}
