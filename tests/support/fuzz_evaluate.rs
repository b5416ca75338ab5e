//! The body of the fuzz target `evaluate`: any text as states of robots that are fine, then every function there.
use bipedc_compiler::Robot;
use bipedc_compiler::compile::CompiledModel;
use bipedc_compiler::description::SourceFiles;
use bipedc_compiler::program::Evaluator;
use bipedc_compiler::states::read_states;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// States beyond these would only be more of the same.
const MOST_STATES: usize = 4;
const URDF: &str = include_str!("../../robots/three_link/robot.urdf");
const TOML: &str = include_str!("../../robots/three_link/biped.toml");

/// A planar robot, and the same on a floating and on a fixed base.
fn robots() -> &'static [CompiledModel] {
    static ROBOTS: OnceLock<Vec<CompiledModel>> = OnceLock::new();
    ROBOTS.get_or_init(|| {
        let sources = SourceFiles {
            urdf_path: PathBuf::from("robot.urdf"),
            urdf_text: URDF.to_owned(),
            toml_path: PathBuf::from("biped.toml"),
            toml_text: TOML.to_owned(),
        };
        let (description, warnings) = sources.parse().expect("the robot is fine");
        let robot = Robot { description, warnings, sources };
        let on = |kind: &str| robot.clone().with_base(kind, None).and_then(|robot| robot.compile());
        ["planar", "floating", "fixed"].map(|kind| on(kind).expect("the robot is fine")).into()
    })
}

/// Reads and evaluates; what is accepted has finite numbers.
pub fn run(text: &str) {
    for robot in robots() {
        match read_states(text, Path::new("states.json"), &robot.tree) {
            Ok(states) => {
                for state in states.iter().take(MOST_STATES) {
                    assert!(state.arguments.iter().flatten().all(|x| x.is_finite()));
                    for function in &robot.functions {
                        let evaluator = Evaluator::new(&function.program);
                        let mut output = vec![0.0; evaluator.outputs()];
                        evaluator.run(&state.state(), &mut evaluator.workspace(), &mut output);
                    }
                }
            }
            Err(errors) => {
                assert!(errors.0.iter().all(|error| error.file.is_some() && error.position.is_some()));
            }
        }
    }
}
