//! The model on its own under the logged efforts.
use crate::measurements::{Content, Log};
use crate::progress::Progress;
use crate::robot::joint_layout;
use crate::table::table;
use bipedc_analysis::compare::{FreeRun, free_run};
use bipedc_analysis::measure::{Options, Recording};
use bipedc_analysis::robot::JointLayout;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::tree::BaseKind;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::fmt::Write;

/// What cannot be predicted freely, before anything is computed.
pub(super) fn refuse(robot: &Robot, content: Content, log: &Log) -> Result<(), Diagnostic> {
    let refused = |what: &str, help: &str| {
        Err(Diagnostic::error(format!("--free-run: {what}")).in_file(log.path()).help(help))
    };
    let is_held = robot.tree()?.base == BaseKind::Fixed;
    if !matches!(content, Content::Efforts | Content::Contacts) {
        let what = format!("a table by `{}` has no course in time", content.abscissa());
        return refused(&what, "give a log whose first column is `time`");
    }
    if !is_held && log.columns().any(|column| column.starts_with("base/")) {
        let what = "the base moves, and what the ground does to it is not part of the prediction";
        return refused(
            what,
            "give a log with the base held; if it was, drop the base/... columns or add --base fixed",
        );
    }
    let layout = joint_layout(&robot.tree()?)?;
    let lacking: Vec<String> = (layout.joints.iter())
        .flat_map(|joint| ["position", "effort"].map(|what| format!("{}/{what}", joint.name)))
        .filter(|column| !log.has(column))
        .map(|column| format!("`{column}`"))
        .collect();
    if !lacking.is_empty() {
        let what = format!("the log has no {}", lacking.join(", "));
        let help = "position and effort of every joint are needed: log them, name other columns with --mapping, or make joints \
                    that did not move `fixed` in the URDF";
        return refused(&what, help);
    }
    Ok(())
}

/// Predicts windows of `seconds` at the cut-off in `options`; the base is held.
pub(super) fn predict(
    robot: &Robot,
    log: &Log,
    options: &Options,
    seconds: f64,
    progress: &dyn Progress,
) -> Result<FreeRun, Diagnostics> {
    let robot = match robot.tree()?.base {
        BaseKind::Fixed => robot.clone(),
        _ => robot.clone().with_base("fixed", None)?,
    };
    let layout: JointLayout = joint_layout(&robot.tree()?)?;
    let request = FunctionRequest::of_robot("forward_dynamics");
    let compiled = progress.stage("deriving", || robot.compile_only(&[request]))?;
    let model = ProgramModel::new(compiled);
    let read = || Recording::read(log, &layout, options);
    let recording = progress.stage("reading", read)?;
    let effects = &robot.description.effects;
    let found = progress
        .counted("predicting", |progress| free_run(&model, &layout, &recording, effects, seconds, progress));
    Ok(found.map_err(|error| error.in_file(log.path()))?)
}

/// A table, then what it rests on.
pub fn text(run: &FreeRun) -> String {
    let number = |value: Option<f64>, unit: &str| match value {
        Some(x) if x != 0.0 && x.abs() < 0.01 => format!("{x:.2e} {unit}"),
        Some(x) => format!("{x:.4} {unit}"),
        None => "-".to_owned(),
    };
    let rows = run.channels.iter().map(|channel| {
        let relative = channel.relative.map_or_else(|| "-".to_owned(), |r| format!("{:.2} %", 100.0 * r));
        vec![
            channel.name.clone(),
            number(channel.rms, channel.unit),
            number(channel.rms_end, channel.unit),
            relative,
        ]
    });
    let mut rows: Vec<Vec<String>> = rows.collect();
    rows.push(vec!["total".to_owned(), number(run.rms, run.unit), String::new(), String::new()]);
    let mut out = String::from("\n");
    out.push_str(&table(&["free run", "rms", "at the end", "of the motion"], rows, 1));
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "\nfree run: {} windows of {} s, each from its measured state; {} diverged and {} were too stiff (both left out)",
        run.windows, run.window, run.diverged, run.capped
    );
    for assumption in &run.assumptions {
        let _ = writeln!(out, "assumed: {assumption}");
    }
    out
}
