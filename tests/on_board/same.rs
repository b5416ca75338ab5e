//! Emitted for the robot, the controller asks for what it asked for in the simulation.
use super::recorded::walk;
use tulip_controller::walking::{Controller, STATE};

/// To the last bit: both are compiled for the same target here, the crate without `dispatch`.
#[test]
fn the_crate_asks_for_the_torques_of_the_simulated_controller() {
    let calls = walk("same", 3.0, "");
    assert_eq!(calls.len(), 3000);
    let mut controller = Controller::default();
    for call in &calls {
        let asked = controller.step(&call.sensors, call.wanted);
        let [found, simulated] = [asked.torque, call.torque].map(|torque| torque.map(f64::to_bits));
        assert_eq!(found, simulated, "{} s", call.sensors.time);
    }
}

#[test]
fn a_controller_fits_into_forty_one_kilobytes() {
    println!("{STATE} bytes");
    const { assert!(STATE < 41_000) };
}
