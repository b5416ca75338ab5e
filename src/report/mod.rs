//! Reports: what comparisons, diagnoses, identifications and histories fill them with.
pub mod drawing;
mod words;

use crate::amendment::comments;
use crate::amendment::history::{Action, Change, History, Stair, Step};
use crate::measurements::{Content, Loaded, Measured};
use bipedc_analysis::diagnose::{Diagnosis, ErrorFall};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::identify::Identification;
use bipedc_analysis::identify::elastic::DriveSummary;
use bipedc_analysis::number::worst_first;
use bipedc_analysis::report::{
    Abscissa, ChangeLine, Drawing, Estimated, Fact, HistoryStep, Report, Row, rows_of,
};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::Diagnostic;
use drawing::drawing;
use std::collections::BTreeMap;
use std::path::Path;
use words::grouped;

/// Measurements against the model, with a diagnosis if there is one. `loaded` are those that judged.
///
/// # Errors
/// A robot without a tree.
pub fn of_measurements(
    robot: &Robot,
    measured: &Measured,
    loaded: &Loaded<'_>,
    diagnosis: Option<&Diagnosis>,
) -> Result<Report, Diagnostic> {
    let name = robot.description.name.clone();
    let file = Path::new(&loaded.source.file).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let what = if diagnosis.is_some() { "diagnosis, judged on" } else { "compared with" };
    let rows = rows_of(&*loaded.experiment, diagnosis);
    let abscissa = loaded.content.abscissa();
    let unit = if abscissa == "time" { "s" } else { "" };
    Ok(Report {
        title: format!("{name}: {what} {file}"),
        // A diagnosis has words of its own.
        summary: if diagnosis.is_some() { String::new() } else { grouped(&rows) },
        log: file,
        drawing: Some(shape(robot, measured, &*loaded.experiment)?),
        robot: name,
        abscissa: Abscissa { name: abscissa.to_owned(), unit: unit.to_owned() },
        rows,
        diagnosis: diagnosis.cloned(),
        warnings: loaded.warnings.iter().map(Diagnostic::advised).collect(),
        assumptions: loaded.assumptions.clone(),
        facts: facts(loaded),
        ..Report::default()
    })
}

/// What was identified: torques over time by description and estimate, and every parameter with its error.
///
/// # Errors
/// A robot without a tree.
pub fn of_identification(
    robot: &Robot,
    found: &Identification,
    drives: Option<&DriveSummary>,
    mut rows: Vec<Row>,
) -> Result<Report, Diagnostic> {
    worst_first(&mut rows, |row| row.unit.clone(), |row| row.rms_before);
    let tree = robot.tree()?;
    let posture = vec![0.0; tree.joints.len()];
    let logs = found.logs.iter().map(|log| {
        let how = format!("{} samples, every {:.4} s, cut-off {} Hz", log.samples, log.step, log.cutoff_hz);
        Fact::new(&log.file, how)
    });
    let name = robot.description.name.clone();
    Ok(Report {
        title: format!("{name}: identification"),
        robot: name,
        summary: identified(found),
        drawing: Some(drawing(&robot.description, &tree, &posture)),
        rows,
        estimates: estimates(found, drives),
        warnings: found.warnings.clone(),
        assumptions: found.assumptions.clone(),
        facts: logs.collect(),
        ..Report::default()
    })
}

fn identified(found: &Identification) -> String {
    let well = found.parameters.iter().filter(|p| p.well_identified).count();
    let mut words = format!(
        "{} parameters from {} rows of {} logs; {well} have a standard error below 15 %. Least squares misses {:.2} % of held-out stretches.",
        found.parameters.len(),
        found.rows,
        found.logs.len(),
        100.0 * found.essential.held_out_of_all
    );
    if let Some(validation) = &found.validation {
        let [described, fitted] =
            [validation.total.description, validation.total.least_squares].map(|x| 100.0 * x);
        words += &format!(
            "\n\nOn a log that did not teach the description misses {described:.2} % of the torque, least squares {fitted:.2} %."
        );
    }
    words
}

/// Drives first, then bodies.
fn estimates(found: &Identification, drives: Option<&DriveSummary>) -> Vec<Estimated> {
    let of_drives = drives.iter().flat_map(|d| &d.joints).flat_map(|joint| {
        joint.parameters.iter().map(|p| Estimated {
            name: format!("drive of {}: {}", joint.joint, p.name),
            unit: p.unit.to_owned(),
            value: p.value,
            standard_error: p.standard_error,
            interval: p.interval,
            described: p.nominal,
        })
    });
    let of_bodies = found.parameters.iter().map(|p| Estimated {
        name: p.name.clone(),
        unit: p.unit.to_owned(),
        value: p.value,
        standard_error: p.standard_error,
        interval: p.interval,
        described: p.nominal,
    });
    of_drives.chain(of_bodies).collect()
}

/// Where the data come from, and what was done with them.
fn facts(loaded: &Loaded<'_>) -> Vec<Fact> {
    let source = &loaded.source;
    let mut facts = vec![
        Fact::new("file", format!("{}, FNV-1a {}", source.file, source.hash)),
        Fact::new("samples", source.samples.to_string()),
    ];
    if loaded.cutoff_hz > 0.0 {
        let filtered = match loaded.content {
            Content::Contacts => "zero-phase 4th-order Butterworth; motion, forces and efforts alike",
            _ => "zero-phase 4th-order Butterworth; efforts are not filtered",
        };
        facts.push(Fact::new("filter", filtered));
        facts.push(Fact::new("cut-off", format!("{} Hz", loaded.cutoff_hz)));
    }
    facts
}

/// The robot in the mean posture of the measurements.
fn shape(robot: &Robot, measured: &Measured, experiment: &dyn Experiment) -> Result<Drawing, Diagnostic> {
    // Rows of joints have the positions of all other joints and their own; rows of the base have all.
    let mut means: BTreeMap<String, f64> = BTreeMap::new();
    for (index, row) in experiment.rows().iter().enumerate().take(2) {
        for (name, values) in experiment.signals(index) {
            let joint = match (name.strip_suffix("/position"), &row.joint) {
                (Some(joint), _) => joint.to_owned(),
                (None, Some(joint)) if name == "position" => joint.clone(),
                _ => continue,
            };
            means.insert(joint, values.iter().sum::<f64>() / values.len().max(1) as f64);
        }
    }
    let joints = measured.layout.joints.iter();
    let posture: Vec<f64> = joints.map(|joint| means.get(&joint.name).copied().unwrap_or(0.0)).collect();
    Ok(drawing(&robot.description, &robot.tree()?, &posture))
}

/// The standing steps of a description's history.
pub fn steps(history: &History) -> Vec<HistoryStep> {
    let step = |stair: Stair| {
        let fall = ErrorFall {
            unit: stair.unit,
            before: stair.before,
            after: stair.after,
            noise: stair.noise,
            ..ErrorFall::default()
        };
        let (held_out, training) = if stair.held_out { (Some(fall), None) } else { (None, Some(fall)) };
        HistoryStep { label: stair.label, date: stair.date, training, held_out }
    };
    history.stairs().into_iter().map(step).collect()
}

/// Everything that was done to a description, with all numbers.
pub fn changes(history: &History) -> Vec<ChangeLine> {
    let of = |step: &Step| -> Vec<ChangeLine> {
        let line = |change: &Change| {
            let action = match change.action {
                Action::Added => "added",
                Action::Replaced => "replaced",
                Action::Removed => "removed",
            };
            let taken_back = if step.stands() { "" } else { ", taken back" };
            ChangeLine {
                step: step.step,
                date: comments::day(&step.date).to_owned(),
                action: format!("{action}{taken_back}"),
                effect: comments::title(&change.effect),
                parameters: values(change),
            }
        };
        step.changes.iter().map(line).collect()
    };
    history.steps.iter().flat_map(of).collect()
}

/// Such as `torque 0.4002 N m (95 %: 0.3982 to 0.4022)`.
fn values(change: &Change) -> Vec<String> {
    let effect = &change.effect;
    let formula = effect.torque.iter().map(|torque| format!("torque = {torque}"));
    let value = |(name, value): (&String, &f64)| {
        let words = format!("{name} {}", comments::quantity(*value, effect.unit(name)));
        match change.ci95.get(name) {
            Some([low, high]) => format!("{words} ({})", comments::sure(*low, *high)),
            None => words,
        }
    };
    formula.chain(effect.parameters.iter().map(value)).collect()
}

/// The same for a robot's folder or `biped.toml`; none where nothing was ever amended or the history is damaged:
/// that is for `bipedc history` to say.
pub fn steps_of(path: &Path) -> Vec<HistoryStep> {
    crate::amendment::open(path).map(|(_, _, history)| steps(&history)).unwrap_or_default()
}
