//! The body of the fuzz target `inspect`: any text as URDF and description, then everything that can be derived.
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, Scope, catalogue};
use bipedc_compiler::description::SourceFiles;
use bipedc_compiler::exact::{Model, Question};
use bipedc_compiler::program::Evaluator;
use bipedc_compiler::tree::Tree;
use bipedc_runtime::{Argument, State};
use std::path::PathBuf;

/// Robots with more than this take their time, as they should.
const MOST_JOINTS: usize = 3;
const MOST_LINKS: usize = 12;
const MOST_POINTS: usize = 6;
const MOST_PHASES: usize = 2;

/// The URDF up to a zero byte, what follows is the description.
pub fn run(text: &str) {
    let (urdf_text, toml_text) = text.split_once('\0').unwrap_or((text, ""));
    let sources = SourceFiles {
        urdf_path: PathBuf::from("robot.urdf"),
        urdf_text: urdf_text.to_owned(),
        toml_path: PathBuf::from("biped.toml"),
        toml_text: toml_text.to_owned(),
    };
    let Ok((description, warnings)) = sources.parse() else { return };
    let robot = Robot { description, warnings, sources };
    let Ok(tree) = robot.tree() else { return };
    if !is_small(&robot, &tree) {
        return;
    }
    let _ = robot.without_inertia();
    if let Ok(package) = robot.package("robot", "path = \"../runtime/core\"") {
        assert!(
            package.files["Cargo.toml"].contains("name = \"") && package.files.contains_key("src/lib.rs")
        );
    }
    every_function(&robot, &tree);
    for of in [Model::CenterOfMass, Model::ZeroMomentPoint, Model::Dynamics, Model::Energy] {
        let _ = Question::new(of).answer(&robot.description);
    }
}

fn is_small(robot: &Robot, tree: &Tree) -> bool {
    let description = &robot.description;
    tree.joints.len() <= MOST_JOINTS
        && tree.links.len() <= MOST_LINKS
        && tree.points.len() <= MOST_POINTS
        && description.phases.len() <= MOST_PHASES
        && description.effects.len() <= 4
}

/// Each function for itself: one that is refused must not hide the others.
fn every_function(robot: &Robot, tree: &Tree) {
    for entry in catalogue() {
        let subject = match entry.scope {
            Scope::Frame => tree.links.last().map(|link| link.name.clone()),
            Scope::Phase | Scope::Impact => robot.description.phases.last().map(|phase| phase.name.clone()),
            _ => None,
        };
        let request = FunctionRequest { family: entry.name.to_owned(), subject };
        let Ok(compiled) = robot.compile_only(&[request]) else { continue };
        let evaluator = Evaluator::new(&compiled.functions[0].program);
        let values: Vec<Vec<f64>> =
            Argument::ALL.iter().map(|&a| vec![0.3; compiled.argument_length(a)]).collect();
        let state = Argument::ALL.iter().zip(&values).fold(State::new(), |s, (&a, v)| s.with(a, v));
        let mut output = vec![0.0; evaluator.outputs()];
        evaluator.run(&state, &mut evaluator.workspace(), &mut output);
    }
}
