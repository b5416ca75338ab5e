//! Generated cases: simulate, ask, judge.
use super::amended::errors_on_feet;
use super::answer::{Answer, ask};
use super::judge::{Scored, judge};
use super::{Context, logs};
use crate::generator::model::{Rigid, read, with_effects};
use crate::generator::{Experiment, Failure, Plan, Truth, drawn, failure, oracle};
use bipedc_effects::effect::Effect;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Scores all cases, several at a time, in their order.
///
/// # Errors
/// A case that cannot be simulated. A diagnosis that fails is a score.
pub fn cases(context: &Context, plans: &[Plan], jobs: usize) -> Result<Vec<Scored>, Failure> {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {elapsed} {msg}");
    let bar = ProgressBar::new(plans.len() as u64).with_style(style.map_err(|e| failure(e.to_string()))?);
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Result<Scored, Failure>)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..jobs.max(1) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(plan) = plans.get(index) else { break };
                    bar.set_message(plan.name.clone());
                    let score = case(context, plan);
                    bar.inc(1);
                    // A thread that panicked while it held the list left it whole.
                    done.lock().unwrap_or_else(|e| e.into_inner()).push((index, score));
                }
            });
        }
    });
    bar.finish_and_clear();
    let mut done = done.into_inner().unwrap_or_else(|e| e.into_inner());
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, score)| score).collect()
}

fn case(context: &Context, plan: &Plan) -> Result<Scored, Failure> {
    // The truth lies elsewhere than the logs that the diagnosis sees.
    let folder = context.folder.join(&plan.name);
    let (plan, truth) = &drawn(plan, &context.root, &folder)?;
    let logs = folder.join("logs");
    std::fs::create_dir_all(&logs).map_err(|e| failure(e.to_string()))?;
    let moved = ["train.csv", "validation.csv"].map(|name| {
        let path = logs.join(name);
        std::fs::rename(folder.join(name), &path).map(|()| path).map_err(|e| failure(e.to_string()))
    });
    let [train, validation] = moved;
    let (train, validation) = (train?, validation?);
    let robot = robot(context, plan, &logs)?;
    let score = match ask(context, &robot, [&train, &validation], &logs) {
        Ok((answer, seconds)) => {
            let mut score = judge(truth, &answer);
            if truth.experiment == Experiment::Swaying {
                let asked = (&answer, &truth.effects[..], truth.metric.as_str());
                let [found, hidden] = errors_on_feet(context, (&robot, &validation), &logs, asked)?;
                (score.after, score.oracle) = (Some(found), hidden);
            } else {
                score.after = after(plan, (&robot, &validation), truth, &answer);
            }
            Scored { seconds, ..score }
        }
        Err(error) => {
            let mut score = judge(truth, &Answer::default());
            (score.right, score.kinds, score.places) = (false, false, false);
            Scored { failed: Some(error.to_string()), ..score }
        }
    };
    // Hundreds of megabytes else; failing to tidy up is no reason to stop.
    let _ = std::fs::remove_dir_all(&folder);
    Ok(score)
}

/// The robot's folder; a drive train of its own would be an effect that the simulation does not have.
fn robot(context: &Context, plan: &Plan, folder: &Path) -> Result<PathBuf, Failure> {
    let path = plan.folder(&context.root);
    if plan.robot != "tulip_v1_leg" {
        return Ok(path);
    }
    let bare = folder.join("robot");
    let made = std::fs::create_dir_all(&bare)
        .and_then(|()| std::fs::copy(path.join("robot.urdf"), bare.join("robot.urdf")))
        .and_then(|_| {
            std::fs::write(bare.join("biped.toml"), "[base]\nkind = \"fixed\"\nlink = \"torso\"\n")
        });
    made.map(|()| bare).map_err(|e| failure(e.to_string()))
}

/// Held-out error with what was found: for hanging robots with encoders on their links by our own formulas, else as the diagnosis
/// says.
fn after(plan: &Plan, (robot, validation): (&Path, &Path), truth: &Truth, answer: &Answer) -> Option<f64> {
    if truth.experiment == Experiment::Hanging && !plan.motor_side {
        return explained(robot, validation, answer, truth.metric == "transmission").ok();
    }
    answer.rms.get(&truth.metric).map(|fall| fall.after)
}

/// Error of a hanging robot's log under the found effects and corrections.
pub fn explained(robot: &Path, log: &Path, answer: &Answer, transmission: bool) -> Result<f64, Failure> {
    // Corrections first: they are those of the URDF's links.
    let effects = [&answer.inertial_corrections[..], &answer.effects].concat();
    error_with(robot, log, &effects, transmission)
}

/// Error of a hanging robot's log under these effects.
pub fn error_with(robot: &Path, log: &Path, effects: &[Effect], transmission: bool) -> Result<f64, Failure> {
    let nominal = read(robot, true)?;
    let changed = with_effects(&nominal, effects)?;
    let joints = Rigid::new(&nominal, &[])?.joints;
    oracle::error(&changed, &logs::read(log, &joints)?, effects, transmission)
}
