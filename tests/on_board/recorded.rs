//! Calls of a simulated walk, as the simulation's controller got and answered them.
use bipedc::Workbench;
use bipedc::simulation::Options;
use std::fs;
use std::path::PathBuf;
use tulip_controller::walking::{JOINT_NAMES, JOINTS, Sensors, Velocity};

/// A call, and what the simulation's controller answered.
#[derive(Debug, Clone, Copy)]
pub struct Call {
    pub sensors: Sensors,
    pub wanted: Velocity<f64>,
    /// N m
    pub torque: [f64; JOINTS],
}

/// The walk of `walk.toml`, so many seconds of it, with more in the scenario.
pub fn walk(name: &str, seconds: f64, more: &str) -> Vec<Call> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("on_board");
    fs::create_dir_all(&folder).unwrap();
    let [scenario, log, told] = ["toml", "csv", "told.csv"].map(|end| folder.join(format!("{name}.{end}")));
    let text = fs::read_to_string("robots/tulip/scenarios/walk.toml").unwrap();
    let text = text.replace("duration = 16.0", &format!("duration = {seconds}"));
    fs::write(&scenario, text + more).unwrap();
    let bench = Workbench::open("robots/tulip").unwrap();
    let scene = bench.scene(&scenario).unwrap();
    let run =
        bench.simulate(&scene, &log, &Options { told: Some(told.clone()), ..Options::default() }).unwrap();
    assert_eq!(run.walk.unwrap().fell, None);
    read(&fs::read_to_string(told).unwrap())
}

/// A file of `bipedc simulate --told`.
pub fn read(text: &str) -> Vec<Call> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place =
        |name: String| names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name}"));
    let of_joints = |quantity: &str| JOINT_NAMES.map(|joint| place(format!("{joint}/{quantity}")));
    let [positions, velocities, efforts] = ["position", "velocity", "effort"].map(of_joints);
    let axes = |of: &str| ["x", "y", "z"].map(|axis| place(format!("{of}/{axis}")));
    let (forces, turns) = (axes("imu/linear_acceleration"), axes("imu/angular_velocity"));
    let feet = ["right_foot", "left_foot"];
    let loads = feet.map(|foot| place(format!("{foot}/force/z")));
    let centers = feet.map(|foot| ["x", "y"].map(|axis| place(format!("{foot}/cop/{axis}"))));
    let ways = ["forward", "left", "turning"].map(|way| place(format!("walking/{way}")));
    let call = |line: &str| {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        let [forward, left, turning] = ways.map(|k| row[k]);
        let sensors = Sensors {
            time: row[0],
            joint_position: positions.map(|k| row[k]),
            joint_velocity: velocities.map(|k| row[k]),
            angular_velocity: turns.map(|k| row[k]),
            specific_force: forces.map(|k| row[k]),
            load: loads.map(|k| row[k]),
            center: centers.map(|center| center.map(|k| row[k])),
            motor_position: [f64::NAN; JOINTS],
        };
        Call { sensors, wanted: Velocity { forward, left, turning }, torque: efforts.map(|k| row[k]) }
    };
    lines.map(call).collect()
}
