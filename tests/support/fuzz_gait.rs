//! The body of the fuzz target `gait`: any text as a gait of a robot that is fine, then a step.
use bipedc::Robot;
use bipedc::gait::{GaitBench, StepOptions};
use bipedc::progress::Silent;
use bipedc_compiler::description::SourceFiles;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const URDF: &str = include_str!("../../robots/three_link/robot.urdf");
const TOML: &str = include_str!("../../robots/three_link/biped.toml");

fn robot() -> &'static Robot {
    static ROBOT: OnceLock<Robot> = OnceLock::new();
    ROBOT.get_or_init(|| {
        let sources = SourceFiles {
            urdf_path: PathBuf::from("robot.urdf"),
            urdf_text: URDF.to_owned(),
            toml_path: PathBuf::from("biped.toml"),
            toml_text: TOML.to_owned(),
        };
        let (description, warnings) = sources.parse().expect("the robot is fine");
        Robot { description, warnings, sources }
    })
}

/// Reads, derives, steps; what is accepted has numbers that can be printed, and a reason where it is not possible.
pub fn run(text: &str) {
    match GaitBench::parse(robot(), Path::new("gait.toml"), text, &Silent) {
        Ok(bench) => {
            let stepped = bench.step(&StepOptions { speed: 1.5, ..StepOptions::default() });
            let stepped = stepped.expect("the gait's own parameters are possible");
            assert!(!stepped.to_string().contains("NaN"), "{stepped}");
            assert_eq!(stepped.step.feasible, stepped.step.reason.is_none());
            assert_eq!(stepped.step.feasible, stepped.step.next_speed.is_some());
        }
        Err(errors) => {
            assert!(!errors.0.is_empty());
            assert!(errors.0.iter().all(|error| error.file.is_some()), "{errors}");
        }
    }
}
