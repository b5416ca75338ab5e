//! What the user wrote: the URDF and `biped.toml`, read and checked.
//!
//! [`read`] takes a folder, [`parse`] the two texts. Both find everything that is wrong at once.
mod check;
pub mod gait;
pub(crate) mod geometry;
mod init;
mod mesh_files;
pub mod model;
mod settings;
pub(crate) mod source;
pub(crate) mod urdf;

pub use check::{CheckReport, LinkReport, check_report};
pub use init::{BACKWARD, NO_SHAPE, init, init_text};
pub use mesh_files::mesh_file;
pub use source::suggest;
pub use urdf::{JointDynamics, rewritten, with_inertials};

use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::input;
use model::RobotDescription;
use settings::{DEFAULT_URDF, describe, urdf_name};
use source::{Messages, finish};
use std::path::{Path, PathBuf};
use urdf::{Follower, UrdfRobot, read_urdf, refuse_followers};

/// The name of the description in a robot's folder.
pub const DESCRIPTION_FILE: &str = "biped.toml";

/// The texts that describe a robot, as read: everything that the result depends on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceFiles {
    /// Path of the URDF.
    pub urdf_path: PathBuf,
    /// Text of the URDF.
    pub urdf_text: String,
    /// Path of `biped.toml`; of the URDF when that alone was given.
    pub toml_path: PathBuf,
    /// Text of `biped.toml`; empty when the URDF alone was given.
    pub toml_text: String,
}

impl SourceFiles {
    /// Reads the files of a robot: `path` is its folder, its `biped.toml`, or a URDF without a description.
    ///
    /// # Errors
    /// Files that are missing, unreadable, not UTF-8 or larger than 64 MB.
    pub fn load(path: &Path) -> Result<Self, Diagnostics> {
        let toml_path = if path.is_dir() { path.join(DESCRIPTION_FILE) } else { path.to_path_buf() };
        let text = load_text(&toml_path)?;
        // A pipe has no extension: no TOML begins like XML.
        if path.extension().is_some_and(|extension| extension == "urdf") || text.starts_with('<') {
            return Ok(Self {
                urdf_path: toml_path.clone(),
                urdf_text: text,
                toml_path,
                toml_text: String::new(),
            });
        }
        let toml_text = text;
        let folder = toml_path.parent().unwrap_or(Path::new(""));
        let urdf_path = folder.join(urdf_name(&toml_text).as_deref().unwrap_or(DEFAULT_URDF));
        Ok(Self { urdf_text: load_text(&urdf_path)?, urdf_path, toml_path, toml_text })
    }

    /// The description and its warnings.
    ///
    /// # Errors
    /// Everything that has no meaning, all at once, together with the warnings.
    pub fn parse(&self) -> Result<(RobotDescription, Vec<Diagnostic>), Diagnostics> {
        parse(&self.urdf_text, &self.urdf_path, &self.toml_text, &self.toml_path)
    }

    /// What the URDF's `<dynamics>` state of joints that move, with line and column. The equations of motion leave it out: damping
    /// and friction are effects of the description.
    pub fn stated_dynamics(&self) -> Vec<(String, JointDynamics, (usize, usize))> {
        let mut messages = Messages::new(&self.urdf_text, &self.urdf_path);
        let Some(robot) = read_urdf(&self.urdf_text, &mut messages) else { return Vec::new() };
        let joints = robot.joints.iter().zip(&robot.joint_places).filter(|(joint, _)| joint.kind.moves());
        let stated = joints.filter(|(_, place)| place.dynamics != JointDynamics::default());
        let at = |place: &urdf::JointPlaces| messages.source.line_and_column(place.dynamics_at.unwrap_or(0));
        stated.map(|(_, place)| (place.name.clone(), place.dynamics, at(place))).collect()
    }

    /// Line and column of a joint in the URDF, for messages of later stages.
    pub fn joint_place(&self, name: &str) -> Option<(usize, usize)> {
        let mut messages = Messages::new(&self.urdf_text, &self.urdf_path);
        let robot = read_urdf(&self.urdf_text, &mut messages)?;
        let place = robot.joint_places.iter().find(|place| place.name == name)?;
        place.at.map(|offset| messages.source.line_and_column(offset))
    }
}

fn load_text(path: &Path) -> Result<String, Diagnostics> {
    let problem = |message: String, help: &str| {
        Err(Diagnostics(vec![Diagnostic::error(message).in_file(path).help(help)]))
    };
    match std::fs::metadata(path) {
        Ok(metadata) if metadata.len() > input::LARGEST_TEXT => {
            return problem(
                format!("the file has {} MB, expected less than 64", metadata.len() >> 20),
                "is this the right file?",
            );
        }
        _ => {}
    }
    match input::read(path).map(String::from_utf8) {
        Ok(Ok(text)) => Ok(text),
        Ok(Err(error)) => {
            let valid = error.utf8_error().valid_up_to();
            problem(format!("the file is not UTF-8 text (byte {valid})"), "save it as UTF-8")
        }
        Err(error) => problem(
            format!("cannot read the file: {error}"),
            "give a robot's folder with `robot.urdf` and `biped.toml`; `bipedc init some.urdf` writes the latter",
        ),
    }
}

/// Reads a robot: its folder with `robot.urdf` and `biped.toml`, or one of these files.
///
/// Returns the description and the warnings.
///
/// # Errors
/// Everything that has no meaning, all at once, together with the warnings.
pub fn read(path: &Path) -> Result<(RobotDescription, Vec<Diagnostic>), Diagnostics> {
    SourceFiles::load(path)?.parse()
}

/// Reads a robot from the texts of its URDF and its description (which may be empty); the names only serve
/// messages.
///
/// Returns the description and the warnings.
///
/// # Errors
/// Everything that has no meaning, all at once, together with the warnings.
pub fn parse(
    urdf_text: &str,
    urdf_name: &Path,
    toml_text: &str,
    toml_name: &Path,
) -> Result<(RobotDescription, Vec<Diagnostic>), Diagnostics> {
    let mut urdf_messages = Messages::new(urdf_text, urdf_name);
    let robot = read_urdf(urdf_text, &mut urdf_messages);
    let followers = robot.as_ref().map(UrdfRobot::followers).unwrap_or_default();
    let mut toml_messages = Messages::new(toml_text, toml_name);
    let description = describe(toml_text, robot, &mut toml_messages);
    if let Some(description) = &description {
        let moves = |(name, _): &&Follower| {
            description.joints.iter().any(|joint| joint.name == *name && joint.kind.moves())
        };
        refuse_followers(followers.iter().filter(moves), &mut urdf_messages);
    }
    let mut list = urdf_messages.into_list();
    list.extend(toml_messages.into_list());
    let warnings = finish(list)?;
    match description {
        Some(description) => Ok((description, warnings)),
        // Unreachable: a description is only missing after an error; said rather than panicked on.
        None => Err(Diagnostics(vec![Diagnostic::error("the robot could not be read").in_file(urdf_name)])),
    }
}
