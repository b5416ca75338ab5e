//! How often a gait survives what its model does not know: many seeded walks, each with and without choosing parameters anew.
mod figure;
mod sampled;
mod text;
mod trial;

pub use trial::{Disturbance, DisturbanceKind};

use super::{Scene, walker_for};
use crate::progress::Run;
use bipedc_analysis::gait::{Watch, in_parallel};
use bipedc_compiler::description::gait::hip_height;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use serde::Serialize;
use std::collections::BTreeMap;
use trial::{Ended, Trial};

/// Quantile of the normal distribution for 95 % in the middle.
const TWO_SIDED: f64 = 1.959_963_984_540_054;
/// Most trials of a disturbance.
pub const MOST_TRIALS: usize = 100_000;

/// What is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustOptions {
    /// Walks of each disturbance at each size.
    pub trials: usize,
    /// Of all random numbers.
    pub seed: u64,
    /// What disturbs the walks.
    pub disturbances: Vec<Disturbance>,
}

/// Walks that came to their end, of all.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survival {
    /// Walks that took all their steps with every assumption kept.
    pub successes: usize,
    /// All walks.
    pub trials: usize,
    /// Their quotient.
    pub rate: f64,
    /// 95 % interval (Wilson, 1927).
    pub interval: [f64; 2],
    /// Why the others ended, each with how many.
    pub failures: BTreeMap<String, usize>,
}

/// Walks under one disturbance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tried {
    /// Which one.
    pub disturbance: Disturbance,
    /// Parameters stay what they are.
    pub fixed: Survival,
    /// Parameters are chosen anew at each mid-stance.
    pub chosen: Survival,
    /// The same trial came to its end with fixed parameters alone.
    pub only_fixed: usize,
    /// With chosen ones alone.
    pub only_chosen: usize,
}

/// What became of all walks. As text and as JSON it is what `bipedc gait robust` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Robust {
    /// Of the robot.
    pub robot: String,
    /// Of the scenario.
    pub scenario: String,
    /// Of each walk.
    pub steps: usize,
    /// Of all random numbers.
    pub seed: u64,
    /// No trial is missing.
    pub complete: bool,
    /// One for each disturbance.
    pub tried: Vec<Tried>,
}

impl Survival {
    fn of<'e>(ended: impl Iterator<Item = &'e Ended>) -> Self {
        let (mut successes, mut trials, mut failures) = (0, 0, BTreeMap::new());
        for end in ended {
            trials += 1;
            match end {
                Ok(()) => successes += 1,
                Err(why) => *failures.entry(why.clone()).or_insert(0) += 1,
            }
        }
        let rate = if trials > 0 { successes as f64 / trials as f64 } else { f64::NAN };
        Self { successes, trials, rate, interval: wilson(successes, trials), failures }
    }
}

/// The interval in which a probability lies, 95 % sure (Wilson, 1927).
pub fn wilson(successes: usize, trials: usize) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let (n, z2) = (trials as f64, TWO_SIDED * TWO_SIDED);
    let p = successes as f64 / n;
    let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = TWO_SIDED / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    [(middle - half).max(0.0), (middle + half).min(1.0)]
}

impl Scene {
    /// Each disturbance that means something here, with its usual size.
    pub fn disturbances(&self) -> Vec<Disturbance> {
        let guarded = self.gait.as_ref().is_some_and(|gait| gait.ends_by_guard());
        let kinds = DisturbanceKind::ALL.into_iter();
        let kinds = kinds.filter(|kind| !(guarded && *kind == DisturbanceKind::Height));
        kinds.map(|kind| self.disturbance(kind, None)).collect()
    }

    /// A disturbance of this size, or of the usual one for the robot.
    pub fn disturbance(&self, kind: DisturbanceKind, size: Option<f64>) -> Disturbance {
        let of = &self.robot.description;
        let mass =
            of.links.iter().filter_map(|link| link.inertial.as_ref()).map(|inertial| inertial.mass).sum();
        let gravity = of.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let usual = || kind.usual([mass, hip_height(of), gravity]);
        Disturbance { kind, size: size.unwrap_or_else(usual) }
    }

    /// Walks the scenario's gait under disturbances, again and again; every trial once with the parameters of the scenario and once
    /// with those that are chosen for its speeds.
    ///
    /// # Errors
    /// The scenario is not one of a gait with wished speeds; the undisturbed walk itself does not come to its end.
    pub fn robust(&self, options: &RobustOptions, run: &Run<'_>) -> Result<Robust, Diagnostics> {
        let Some(gait) = self.gait.as_ref().filter(|gait| gait.wishes.is_some()) else {
            let message = "the scenario has no wished speeds to choose parameters for";
            let help = "name a gait in [control] and give it speeds, such as speeds = [1.5, 1.5, 1.5]";
            return Err(Diagnostic::error(message).in_file(&self.file).help(help).into());
        };
        if !(1..=MOST_TRIALS).contains(&options.trials) {
            let help = format!("ask for 1 to {MOST_TRIALS}");
            let message = format!("{} trials are not possible", options.trials);
            return Err(Diagnostic::error(message).help(help).into());
        }
        let heights = options.disturbances.iter().any(|one| one.kind == DisturbanceKind::Height);
        if heights && self.gait.as_ref().is_some_and(|gait| gait.ends_by_guard()) {
            let message = "steps of this scenario end where the gait's guard vanishes, whatever the height of the ground";
            let help = "leave --disturb height out, or take a gait that lifts its foot, without step_length = \"gait\"";
            return Err(Diagnostic::error(message).in_file(&self.file).help(help).into());
        }
        self.with_choosers(gait, run, |choosers| {
            let walker = &walker_for(&self.robot, &self.scenario, false)?;
            let trial = Trial { scene: self, walker, gait, choosers, seed: options.seed };
            trial.undisturbed()?;
            Ok(self.tried(&trial, options, run))
        })
    }

    /// All trials.
    fn tried(&self, trial: &Trial<'_, '_>, options: &RobustOptions, run: &Run<'_>) -> Robust {
        let count = options.trials * options.disturbances.len();
        let mut ended = run.progress.counted("walking", |advance| {
            in_parallel(count, &Watch { advance, stop: run.stop }, |job| {
                trial.both(&options.disturbances[job / options.trials], job % options.trials)
            })
        });
        ended.sort_by_key(|(job, _)| *job);
        let complete = ended.len() == count && !(run.stop)();
        let of = |index: usize, disturbance: &Disturbance| {
            let own =
                || ended.iter().filter(move |(job, _)| job / options.trials == index).map(|(_, end)| end);
            let only = |a: usize| own().filter(|end| end[a].is_ok() && end[1 - a].is_err()).count();
            Tried {
                disturbance: *disturbance,
                fixed: Survival::of(own().map(|[fixed, _]| fixed)),
                chosen: Survival::of(own().map(|[_, chosen]| chosen)),
                only_fixed: only(0),
                only_chosen: only(1),
            }
        };
        let events = self.scenario.events.as_ref();
        Robust {
            robot: self.robot.description.name.clone(),
            scenario: self.file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            steps: events.and_then(|events| events.steps).unwrap_or(0),
            seed: options.seed,
            complete,
            tried: options.disturbances.iter().enumerate().map(|(index, d)| of(index, d)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brown, Cai and DasGupta (2001) and the closed forms at the ends: n/(n + z²) and z²/(n + z²).
    #[test]
    fn intervals_are_wilsons() {
        let z2 = TWO_SIDED * TWO_SIDED;
        let [low, high] = wilson(100, 100);
        assert!((low - 100.0 / (100.0 + z2)).abs() < 1e-15 && high == 1.0);
        let [low, high] = wilson(0, 50);
        assert!(low.abs() < 1e-15 && (high - z2 / (50.0 + z2)).abs() < 1e-15);
        // Both ends solve (p − p̂)² = z² p (1 − p)/n.
        for end in wilson(37, 80) {
            let residual = (end - 37.0 / 80.0).powi(2) - z2 * end * (1.0 - end) / 80.0;
            assert!(residual.abs() < 1e-15, "{residual:e}");
        }
    }
}
