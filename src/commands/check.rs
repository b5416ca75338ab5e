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

/// What the URDF states of a joint's friction, and the effects of the description that are of that kind there.
struct Stated<'r> {
    joint: String,
    kind: &'static Kind,
    value: f64,
    at: (usize, usize),
    /// Of this kind, or with it as a part.
    described: Vec<&'r Effect>,
}

impl Stated<'_> {
    /// The parameter that a URDF states: the first of either kind.
    fn parameter(&self) -> &'static str {
        self.kind.parameters[0].name
    }

    /// Another value of the same parameter that the description has instead.
    fn other(&self) -> Option<f64> {
        let own = self.described.iter().find(|effect| effect.kind == self.kind)?;
        let value = own.value(self.parameter());
        ((value - self.value).abs() > 1e-9 * self.value).then_some(value)
    }
}

/// Damping and friction that the URDF states.
fn stated(robot: &Robot) -> Vec<Stated<'_>> {
    let effects = &robot.description.effects;
    let described = |joint: &str, kind: &'static Kind| {
        let at = effects.iter().filter(|effect| effect.location.joint.as_deref() == Some(joint));
        at.filter(|effect| effect.kind == kind || effect.kind.contains(kind)).collect()
    };
    let mut found = Vec::new();
    for (joint, stated, at) in robot.sources.stated_dynamics() {
        let values =
            [(&kinds::VISCOUS_FRICTION, stated.damping), (&kinds::COULOMB_FRICTION, stated.friction)];
        for (kind, value) in values {
            if let Some(value) = value {
                found.push(Stated {
                    described: described(&joint, kind),
                    joint: joint.clone(),
                    kind,
                    value,
                    at,
                });
            }
        }
    }
    found
}

/// Joints whose URDF states damping or friction that no effect of the description is.
fn left_out(robot: &Robot) -> Option<Diagnostic> {
    let mut found = stated(robot);
    found.retain(|stated| stated.described.is_empty());
    let first = found.first()?;
    let (kind, parameter, joint, value) = (first.kind.name, first.parameter(), &first.joint, first.value);
    let mut joints: Vec<&str> = found.iter().map(|stated| stated.joint.as_str()).collect();
    joints.dedup();
    let message =
        format!("the URDF states damping or friction that the description leaves out: {}", list(joints, 12));
    let help = format!(
        "if it was measured: bipedc amend ROBOT --effect {kind} --joint {joint} --set {parameter}={value}, and so on; else diagnose finds it"
    );
    Some(at(robot, first.at, message).help(help))
}

/// Joints whose URDF states another damping or friction than the description has: the description counts.
fn differing(robot: &Robot) -> Option<Diagnostic> {
    let found = stated(robot);
    let told = found.iter().filter_map(|stated| {
        let (parameter, unit) = (stated.parameter(), stated.described.first()?.unit(stated.parameter()));
        let other = stated.other()?;
        Some(format!("`{}` {parameter} {} instead of {} {unit}", stated.joint, other, stated.value))
    });
    let told: Vec<String> = told.collect();
    let first = found.iter().find(|stated| stated.other().is_some())?;
    let more = told
        .len()
        .checked_sub(12)
        .filter(|more| *more > 0)
        .map_or_else(String::new, |more| format!(" and {more} more"));
    let message = format!(
        "the description has another damping or friction than the URDF states, and counts: {}{more}",
        told[..told.len().min(12)].join("; ")
    );
    let help =
        "bipedc export ROBOT --urdf OUT.urdf writes what the description has, for tools that read URDF alone";
    Some(at(robot, first.at, message).help(help))
}

/// A warning at a place in the URDF.
fn at(robot: &Robot, (line, column): (usize, usize), message: String) -> Diagnostic {
    Diagnostic::warning(message).in_file(&robot.sources.urdf_path).at(line, column)
}

/// The description knows neither function names nor what they need: the catalogue does.
fn compilable(mut robot: Robot) -> Result<Robot, Failure> {
    robot.requests(&robot.tree()?)?;
    let mut more = robot.without_inertia()?;
    robot.warnings.append(&mut more);
    let told: Vec<Diagnostic> = [left_out(&robot), differing(&robot)].into_iter().flatten().collect();
    robot.warnings.extend(told);
    Ok(robot)
}

fn json(messages: &[Diagnostic], report: Option<CheckReport>) -> Json {
    Json {
        errors: Message::all(messages, Severity::Error),
        warnings: Message::all(messages, Severity::Warning),
        report,
    }
}
