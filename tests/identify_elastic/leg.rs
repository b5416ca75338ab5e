//! Logs of a leg whose joints follow a given motion exactly: what motors, springs and encoders would show.
use crate::identify_elastic::cli::{Run, bipedc, text};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::JointDrive;
use bipedc_effects::drive::{Drive, Transmission};
use bipedc_runtime::{Argument, Model, State};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Samples by which torques are differenced.
const REACH: usize = 4;
/// Eighth order: weights of the samples before and after.
const FIRST: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
const SECOND: [f64; 5] = [-205.0 / 72.0, 8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0];

/// Numbers that look random and are always the same.
pub struct Noise(pub u64);

impl Noise {
    /// Even between 0 and 1.
    pub fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Normal, variance 1.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.even().max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }
}

/// Sensors.
#[derive(Clone, Copy, Default)]
pub struct Sensors {
    /// Encoder counts per turn of motor and joint; exact without.
    pub counts: Option<[f64; 2]>,
    /// Standard deviation of the current, A.
    pub current: f64,
}

/// A leg with these drives.
pub struct Leg {
    pub joints: Vec<String>,
    /// What drives it in truth.
    pub drives: Vec<JointDrive>,
    model: ProgramModel,
}

/// How long, how often, which motion.
#[derive(Clone, Copy)]
pub struct Recorded {
    pub seconds: f64,
    pub rate: f64,
    pub seed: u64,
    /// Frequencies of the sines, Hz.
    pub slowest: f64,
    pub fastest: f64,
}

impl Leg {
    pub fn read(folder: &Path) -> Self {
        let robot = Robot::read(folder).unwrap().without_effects();
        let tree = robot.tree().unwrap();
        let request = FunctionRequest::of_robot("inverse_dynamics");
        Self {
            joints: tree.joints.iter().map(|joint| joint.name.clone()).collect(),
            drives: robot.description.drives.clone(),
            model: ProgramModel::new(robot.compile_only(&[request]).unwrap()),
        }
    }

    /// The drives of the leg as described, with friction and stiffness off by these factors.
    pub fn with(mut self, factors: &mut dyn FnMut() -> f64) -> Self {
        for JointDrive { drive, .. } in &mut self.drives {
            drive.viscous_friction *= factors();
            drive.coulomb_friction *= factors();
            if let Transmission::SeriesElastic { spring_stiffness, .. } = &mut drive.transmission {
                *spring_stiffness *= factors();
            }
        }
        self
    }

    fn torques(&self, motion: &[[f64; 3]]) -> Vec<f64> {
        let part = |order: usize| -> Vec<f64> { motion.iter().map(|m| m[order]).collect() };
        let (q, v, a) = (part(0), part(1), part(2));
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
        let mut tau = vec![0.0; self.joints.len()];
        Model::<f64>::evaluate(&self.model, 0, &state, &mut tau).unwrap();
        tau
    }

    /// Writes a log; joints without a motor are held at zero and not logged.
    pub fn record(&self, file: &Path, recorded: Recorded, sensors: Sensors) {
        let mut noise = Noise(recorded.seed);
        let waves: Vec<Vec<[f64; 3]>> =
            self.joints.iter().map(|joint| waves(joint, recorded, &mut noise)).collect();
        let held = |joint: &str| self.drive(joint).is_none_or(|drive| !drive.has_motor());
        let count = (recorded.seconds * recorded.rate) as usize + 1;
        let margin = 4 * REACH;
        let motions: Vec<Vec<[f64; 3]>> = (0..count + 2 * margin)
            .map(|i| {
                let t = (i as f64 - margin as f64) / recorded.rate;
                let at = |(waves, joint): (&Vec<[f64; 3]>, &String)| {
                    if held(joint) { [0.0; 3] } else { sum(waves, t) }
                };
                waves.iter().zip(&self.joints).map(at).collect()
            })
            .collect();
        let torques: Vec<Vec<f64>> = motions.iter().map(|motion| self.torques(motion)).collect();
        let mut out = String::from("time");
        let driven: Vec<usize> = (0..self.joints.len()).filter(|&j| !held(&self.joints[j])).collect();
        for &j in &driven {
            let _ = write!(out, ",{0}/position,{0}/motor_position,{0}/motor_current", self.joints[j]);
        }
        for (i, motion) in motions.iter().enumerate().skip(margin).take(count) {
            let _ = write!(out, "\n{}", (i - margin) as f64 / recorded.rate);
            for &j in &driven {
                let drive = self.drive(&self.joints[j]).unwrap();
                let torque = differentiated(&torques, i, j, recorded.rate);
                let (motor, current) = motor(drive, motion[j], torque);
                let [angle, shaft] = match sensors.counts {
                    Some([of_motor, of_joint]) => [rounded(motion[j][0], of_joint), rounded(motor, of_motor)],
                    None => [motion[j][0], motor],
                };
                let _ = write!(out, ",{angle},{shaft},{}", current + sensors.current * noise.normal());
            }
        }
        std::fs::write(file, out + "\n").unwrap();
    }

    pub fn drive(&self, joint: &str) -> Option<&Drive> {
        self.drives.iter().find(|driven| driven.joint == joint).map(|driven| &driven.drive)
    }

    /// True value of a parameter of the answer.
    pub fn truth(&self, joint: &str, parameter: &str) -> f64 {
        let drive = self.drive(joint).unwrap();
        let Transmission::SeriesElastic { spring_stiffness, load_pulley_radius, .. } = drive.transmission
        else {
            return if parameter == "viscous_friction" {
                drive.viscous_friction
            } else {
                drive.coulomb_friction
            };
        };
        match parameter {
            "viscous_friction" => drive.viscous_friction,
            "coulomb_friction" => drive.coulomb_friction,
            "spring_stiffness" => spring_stiffness,
            "joint_stiffness" => spring_stiffness * load_pulley_radius.powi(2),
            other => panic!("{other}"),
        }
    }
}

/// Sines of a joint: amplitude, angular frequency, phase.
fn waves(joint: &str, recorded: Recorded, noise: &mut Noise) -> Vec<[f64; 3]> {
    let size = if joint.contains("roll") || joint.contains("yaw") { 0.12 } else { 0.25 };
    let band = recorded.fastest - recorded.slowest;
    (0..4)
        .map(|_| {
            let frequency = recorded.slowest + band * noise.even();
            let turn = std::f64::consts::TAU;
            [size * (0.4 + 0.6 * noise.even()), turn * frequency, turn * noise.even()]
        })
        .collect()
}

fn sum(waves: &[[f64; 3]], t: f64) -> [f64; 3] {
    waves.iter().fold([0.0; 3], |[q, v, a], [size, w, phase]| {
        let (sin, cos) = (w * t + phase).sin_cos();
        [q + size * sin, v + size * w * cos, a - size * w * w * sin]
    })
}

/// A torque with two derivatives.
fn differentiated(torques: &[Vec<f64>], i: usize, j: usize, rate: f64) -> [f64; 3] {
    let at = |steps: isize| torques[(i as isize + steps * REACH as isize) as usize][j];
    let step = REACH as f64 / rate;
    let first: f64 = (0..4).map(|k| FIRST[k] * (at(k as isize + 1) - at(-(k as isize) - 1))).sum();
    let second: f64 = (1..5).map(|k| SECOND[k] * (at(k as isize) + at(-(k as isize)))).sum();
    [at(0), first / step, (SECOND[0] * at(0) + second) / (step * step)]
}

/// Angle and current of a motor that makes this torque at its joint.
fn motor(drive: &Drive, motion: [f64; 3], torque: [f64; 3]) -> (f64, f64) {
    let n = drive.gear_ratio;
    let shaft: [f64; 3] = match drive.transmission {
        Transmission::SeriesElastic { motor_pulley_radius, load_pulley_radius, spring_stiffness } => {
            let give = 1.0 / (spring_stiffness * load_pulley_radius);
            std::array::from_fn(|k| {
                n / motor_pulley_radius * (load_pulley_radius * motion[k] + give * torque[k])
            })
        }
        _ => motion.map(|x| n * x),
    };
    let behind_gear = match drive.transmission {
        Transmission::SeriesElastic { motor_pulley_radius, load_pulley_radius, .. } => {
            torque[0] * motor_pulley_radius / load_pulley_radius
        }
        _ => torque[0],
    };
    let friction = drive.viscous_friction * shaft[1] + drive.coulomb_friction * shaft[1].signum();
    let total = drive.rotor_inertia * shaft[2] + friction + behind_gear / n;
    (shaft[0], total / drive.torque_constant.unwrap())
}

fn rounded(angle: f64, counts: f64) -> f64 {
    let step = std::f64::consts::TAU / counts;
    (angle / step).round() * step
}

/// The answer for these logs; the description counts as much as it is told, so that folds need not be tried.
pub fn identify(robot: &str, log: &Path, more: &[&str]) -> Run {
    let arguments = ["identify", robot, text(log), "--method", "elastic", "--json", "--weight", "1"];
    bipedc(&[arguments.as_slice(), more].concat())
}

/// A parameter of a drive.
pub fn parameter<'a>(answer: &'a Value, joint: &str, name: &str) -> &'a Value {
    let drives = answer["drives"]["joints"].as_array().unwrap();
    let drive = drives.iter().find(|d| d["joint"] == joint).unwrap_or_else(|| panic!("no drive {joint}"));
    let parameters = drive["parameters"].as_array().unwrap();
    parameters.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("no {name} of {joint}: {drive}"))
}

/// The example of `tests/data`.
pub fn example(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/examples/elastic_leg").join(file)
}
