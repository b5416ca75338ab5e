//! What several tests of logs and comparisons share.
#![allow(dead_code, reason = "every test binary uses another part")]
pub mod rnea;

use bipedc_analysis::log::{Mapping, Reader};
use bipedc_analysis::robot::{BaseKind, Joint, JointLayout};
use bipedc_effects::diagnostic::Diagnostics;
use rnea::Robot;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// A file of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// TUlip with its torso fixed.
pub fn tulip() -> Robot {
    let text = std::fs::read_to_string(repository("robots/tulip/robot.urdf")).unwrap();
    Robot::parse(&text, BaseKind::Fixed)
}

/// Its joints.
pub fn layout(robot: &Robot) -> JointLayout {
    let joints = robot.joint_names().map(Joint::revolute).collect();
    JointLayout { joints, base: robot.base() }
}

/// A reader of a log held in memory.
pub fn reader(bytes: impl Into<Vec<u8>>) -> Result<Reader, Diagnostics> {
    Reader::from_source(Path::new("log.csv"), Box::new(Cursor::new(bytes.into())), &Mapping::default())
}
