//! The loop by itself: diagnose, write one effect after the other into the description, look again.
use crate::amendment::diagnosis::{Selection, propose};
use crate::amendment::{amend, description_path, words};
use crate::arguments::RobotArguments;
use crate::diagnosing::{Request, diagnose_files, estimate_files};
use crate::failure::{Failure, Outcome};
use crate::output;
use bipedc_analysis::diagnose::Diagnosis;
use bipedc_effects::effect::Effect;
use std::fmt::Write;
use std::process::ExitCode;

/// Most searches: what stands changes what is left, but not for ever.
const ROUNDS: usize = 4;

/// Amends the description step by step until a diagnosis of what it then says finds nothing more.
///
/// The last step of a search has the parameters of that search, so that the description becomes what one diagnosis
/// and one amendment would have made; the steps before it have those that were best without the later effects.
pub fn until_explained(arguments: &RobotArguments, request: &Request) -> Outcome {
    // Better now than after the search.
    description_path(&arguments.path)?;
    for round in 0..ROUNDS {
        let robot = if round == 0 { arguments.read()? } else { arguments.read_quietly()? };
        let (answer, warnings) = diagnose_files(&robot, request, &|_, _, _| Ok(()))?;
        if round == 0 {
            output::diagnostics(&warnings);
        }
        if answer.effects.is_empty() {
            output::print(&format!("{}\n", end(&answer, round)))?;
            return Ok(ExitCode::SUCCESS);
        }
        let order: Vec<Effect> = answer.steps.iter().map(|step| step.effect.clone()).collect();
        for count in 1..order.len() {
            let (partial, _) = estimate_files(&robot, &order[..count], request)?;
            take(arguments, &partial)?;
        }
        take(arguments, &answer)?;
    }
    output::print("something more was found in every search: look at the report before going on\n")?;
    Ok(ExitCode::SUCCESS)
}

fn end(answer: &Diagnosis, round: usize) -> String {
    let head = if round == 0 { "nothing was added" } else { "nothing more earns its place" };
    format!("{head}\n{}", answer.summary)
}

/// One step of the history.
fn take(arguments: &RobotArguments, answer: &Diagnosis) -> Result<(), Failure> {
    let proposal = propose(answer, &Selection::default(), "diagnose --until-explained")?;
    let amended = amend(&arguments.path, &proposal, false)?;
    output::diagnostics(&amended.warnings);
    let mut text = format!("step {}\n", amended.step.step);
    for change in &amended.step.changes {
        let values = change
            .effect
            .parameters
            .iter()
            .map(|(name, value)| format!("{name} {}", words::quantity(*value, change.effect.unit(name))));
        let values: Vec<String> = values.collect();
        let _ = writeln!(text, "  {}: {}", words::title(&change.effect), values.join(", "));
    }
    if let Some(error) = amended.step.errors.first() {
        let _ = writeln!(text, "  error: {}", words::error(error));
    }
    output::print(&text)?;
    Ok(())
}
