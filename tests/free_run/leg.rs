//! The TUlip leg in a smooth motion that is known exactly, and the log that ideal sensors make of it.
use crate::free_run::cli::scratch;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::{Argument, Model, State};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const FOLDER: &str = "robots/tulip_v1_leg";
/// s
const STEP: f64 = 0.002;
const SAMPLES: usize = 1501;
pub const JOINTS: [&str; 6] = [
    "right_hip_yaw",
    "right_hip_roll",
    "right_hip_pitch",
    "right_knee_pitch",
    "right_ankle_pitch",
    "right_ankle_roll",
];

/// A copy of the robot with another description.
pub fn robot(name: &str, change: impl Fn(String) -> String) -> PathBuf {
    let folder = scratch(name);
    std::fs::copy(Path::new(FOLDER).join("robot.urdf"), folder.join("robot.urdf")).unwrap();
    let description = std::fs::read_to_string(Path::new(FOLDER).join("biped.toml")).unwrap();
    std::fs::write(folder.join("biped.toml"), change(description)).unwrap();
    folder
}

/// Position, velocity and acceleration of a joint: two slow sines.
pub fn motion(joint: usize, t: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (k, amplitude) in [(1.0, 0.25), (2.0, 0.08)] {
        let w = (2.0 + 0.6 * joint as f64) * k;
        let (s, c) = (w * t + joint as f64 + k).sin_cos();
        sum = [sum[0] + amplitude * s, sum[1] + amplitude * w * c, sum[2] - amplitude * w * w * s];
    }
    sum
}

/// A function of a folder's robot at logged `q` (true one plus `offset`), v and a of this time, by joint.
pub struct Torques(ProgramModel);

impl Torques {
    pub fn new(folder: &Path, function: &str) -> Self {
        let request = FunctionRequest::of_robot(function);
        Self(ProgramModel::new(Robot::read(folder).unwrap().compile_only(&[request]).unwrap()))
    }
    pub fn at(&self, t: f64, offset: &[f64; 6]) -> [f64; 6] {
        let part = |order: usize| -> [f64; 6] { std::array::from_fn(|j| motion(j, t)[order]) };
        let q: [f64; 6] = std::array::from_fn(|j| motion(j, t)[0] + offset[j]);
        let (v, a) = (part(1), part(2));
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
        let mut tau = [0.0; 6];
        self.0.evaluate(0, &state, &mut tau).unwrap();
        tau
    }
}

/// Name of a column and its value at a sample and time.
pub type Column<'a> = (&'a str, &'a dyn Fn(usize, f64) -> f64);

/// A log with the columns `<joint>/<name>` of these functions of joint and time.
pub fn log(file: &Path, columns: &[Column<'_>]) {
    let mut text = String::from("time");
    for joint in JOINTS {
        columns.iter().for_each(|(name, _)| write!(text, ",{joint}/{name}").unwrap());
    }
    text.push('\n');
    for i in 0..SAMPLES {
        let t = STEP * i as f64;
        write!(text, "{t:.4}").unwrap();
        for joint in 0..JOINTS.len() {
            columns.iter().for_each(|(_, value)| write!(text, ",{:.13e}", value(joint, t)).unwrap());
        }
        text.push('\n');
    }
    std::fs::write(file, text).unwrap();
}
