//! `bipedc check`: everything wrong or odd with a robot.
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::output::{self, Message};
use bipedc_compiler::Robot;
use bipedc_compiler::description::{CheckReport, check_report};
use bipedc_compiler::tree::as_built;
use bipedc_effects::diagnostic::{Diagnostic, Severity, list};
use bipedc_effects::effect::{Effect, Kind, kinds};
use clap::Args;
use serde::Serialize;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc check robots/tulip
  bipedc check somewhere/robot.urdf          a URDF without a description
  bipedc check robots/tulip --json

Prints the tree with masses (kg), the total mass, the centre of mass (m) and what is physically \
inconsistent, all with the effects on links. All errors are printed at once; the exit code is then 1.
JSON: {\"errors\", \"warnings\": [{\"message\", \"file\", \"line\", \"column\", \"help\"}], and of a robot that reads \"robot\", \"base\", \"moving_joints\", \
\"links\": [{\"name\", \"depth\", \"joint\", \"motion\", \"mass\" (kg)}], \"total_mass\" (kg), \"center_of_mass\" (m), \"center_of_mass_height\" (m), \"height_above\", \"inconsistencies\"}.";

/// Report every problem of a robot at once, its tree and its masses
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Check {
    #[command(flatten)]
    robot: RobotArguments,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Json {
    errors: Vec<Message>,
    warnings: Vec<Message>,
    #[serde(flatten)]
    report: Option<CheckReport>,
}

impl Check {
    /// Reads and reports.
    pub fn run(self) -> Outcome {
        match self.robot.open_quietly().and_then(|bench| compilable(bench.into_robot())) {
            Ok(robot) => self.succeed(&robot),
            Err(failure) if self.json => {
                output::print_json(&json(&failure.0, None))?;
                Err(failure)
            }
            Err(failure) => Err(failure),
        }
    }

    fn succeed(&self, robot: &Robot) -> Outcome {
        let report = check_report(&as_built(&robot.description));
        output::diagnostics(&robot.warnings);
        if self.json {
            output::print_json(&json(&robot.warnings, Some(report)))?;
        } else {
            let warnings = match robot.warnings.len() {
                0 => String::new(),
                1 => "1 warning on the error stream\n".to_owned(),
                n => format!("{n} warnings on the error stream\n"),
            };
            output::print(&format!("{report}{warnings}"))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Joints whose URDF states damping or friction that no effect of the description is.
fn left_out(robot: &Robot) -> Option<Diagnostic> {
    let effects = &robot.description.effects;
    let has = |joint: &str, kind: &'static Kind| {
        let same = |effect: &&Effect| effect.location.joint.as_deref() == Some(joint);
        effects.iter().filter(same).any(|effect| effect.kind == kind || effect.kind.contains(kind))
    };
    let mut found: Vec<(String, &Kind, f64, (usize, usize))> = Vec::new();
    for (joint, stated, place) in robot.sources.stated_dynamics() {
        let values =
            [(&kinds::VISCOUS_FRICTION, stated.damping), (&kinds::COULOMB_FRICTION, stated.friction)];
        for (kind, value) in values {
            if let Some(value) = value.filter(|_| !has(&joint, kind)) {
                found.push((joint.clone(), kind, value, place));
            }
        }
    }
    let (joint, kind, value, (line, column)) = found.first()?;
    // The first parameter of both kinds is the one that a URDF states.
    let (kind, parameter) = (kind.name, kind.parameters[0].name);
    let mut joints: Vec<&str> = found.iter().map(|(joint, ..)| joint.as_str()).collect();
    joints.dedup();
    let message =
        format!("the URDF states damping or friction that the description leaves out: {}", list(joints, 12));
    let help = format!(
        "if it was measured: bipedc amend ROBOT --effect {kind} --joint {joint} --set {parameter}={value}, and so on; else diagnose finds it"
    );
    Some(Diagnostic::warning(message).in_file(&robot.sources.urdf_path).at(*line, *column).help(help))
}

/// The description knows neither function names nor what they need: the catalogue does.
fn compilable(mut robot: Robot) -> Result<Robot, Failure> {
    robot.requests(&robot.tree()?)?;
    let mut more = robot.without_inertia()?;
    robot.warnings.append(&mut more);
    robot.warnings.extend(left_out(&robot));
    Ok(robot)
}

fn json(messages: &[Diagnostic], report: Option<CheckReport>) -> Json {
    Json {
        errors: Message::all(messages, Severity::Error),
        warnings: Message::all(messages, Severity::Warning),
        report,
    }
}
