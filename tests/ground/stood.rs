//! TUlip on its right foot, with the described parameters or others.
use crate::ground::support::read_robot;
use bipedc::identification::standing::{Root, StandingRobot};
use bipedc_analysis::identify::BaseSet;
use bipedc_analysis::identify::excite::postures::StanceModel;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::{Argument, Model, State};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Numbers that look random and are always the same.
pub struct Noise(pub u64);

impl Noise {
    /// Even between -1 and 1.
    pub fn even(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Other masses, centres and inertias.
pub fn other(robot: &Robot) -> Robot {
    let (mut noise, mut other) = (Noise(77), robot.clone());
    for inertial in other.description.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
        inertial.mass *= 1.0 + 0.15 * noise.even();
        inertial.origin.xyz.iter_mut().for_each(|x| *x += 0.012 * noise.even());
        inertial.inertia.iter_mut().for_each(|x| *x *= 1.2);
    }
    other
}

pub fn tulip() -> Robot {
    read_robot("tulip")
}

pub fn rooted(robot: &Robot, root: Root) -> StandingRobot {
    StandingRobot::new(robot, Some("right_foot"), root).unwrap()
}

pub fn model(rooted: &StandingRobot, families: &[&str]) -> ProgramModel {
    let requests: Vec<FunctionRequest> = families.iter().map(|f| FunctionRequest::of_robot(*f)).collect();
    ProgramModel::new(rooted.robot.compile_only(&requests).unwrap())
}

pub fn standing<'m>(rooted: &StandingRobot, model: &'m ProgramModel, base: &BaseSet) -> StanceModel<'m> {
    StanceModel::new(rooted.parts(model, base, &mut Vec::new()).unwrap()).unwrap()
}

/// A function of the configuration, joints after a base at rest.
pub fn call(model: &ProgramModel, name: &str, joints: &[f64]) -> Vec<f64> {
    let model: &dyn Model<f64> = model;
    let function = model.function(name).unwrap();
    let signature = model.signature(function).unwrap();
    let mut q = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    q.extend(joints);
    let mut out = vec![0.0; signature.rows * signature.columns];
    model.evaluate(function, &State::new().with(Argument::Q, &q), &mut out).unwrap();
    out
}

/// A table of postures with columns of a user.
pub fn write_postures(
    folder: &Path,
    name: &str,
    joints: &[String],
    rows: &[(Vec<f64>, [f64; 2])],
) -> PathBuf {
    let mut text = String::from("posture");
    for joint in joints {
        let _ = write!(text, ",{joint}/position");
    }
    text.push_str(",cop/x,cop/y\n");
    for (number, (q, [x, y])) in rows.iter().enumerate() {
        let _ = write!(text, "{number}");
        for q in q {
            let _ = write!(text, ",{q}");
        }
        let _ = writeln!(text, ",{x},{y}");
    }
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}
