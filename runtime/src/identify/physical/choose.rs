//! How much CAD counts: chosen on the training logs alone.
use super::program::Problem;
use crate::diagnostic::Diagnostic;
use crate::identify::estimate::{by_channel, errors, joined};
use crate::identify::{Design, Estimate, Held, Sums, Triangle};
use serde::Serialize;

/// Weights that are tried.
pub const WEIGHTS: [f64; 13] = [1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0];

/// One weight that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// Weight of CAD.
    pub weight: f64,
    /// Mean squared error on data that did not teach, each channel in units of its noise.
    pub error: f64,
    /// Standard error of that, from the folds.
    pub spread: f64,
    /// |error| / |measured| over all channels, on data that did not teach.
    pub relative: f64,
}

/// What was chosen, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The weight.
    pub weight: f64,
    /// All that were tried.
    pub trials: Vec<Trial>,
}

/// Tries all weights by folds.
///
/// # Errors
/// As [`Problem::solve`].
pub fn choose(
    problem: &Problem<'_>,
    design: &Design<'_>,
    sums: &Sums,
    estimate: &Estimate,
    folds: &[usize],
    progress: &dyn Fn(f64),
) -> Result<Choice, Diagnostic> {
    let last = folds.iter().copied().max().unwrap_or(0);
    let count = last + 1;
    let mut trials: Vec<(Vec<f64>, Held)> = vec![(Vec::new(), Held::default()); WEIGHTS.len()];
    for fold in 0..count {
        let others: Vec<Triangle> = estimate.cells.iter().zip(folds).filter(|(_, of)| **of != fold).map(|(c, _)| c.clone()).collect();
        let data = joined(estimate.total.columns(), &others);
        let own = by_channel(sums, design, &|cell| folds[cell] == fold);
        for (k, weight) in WEIGHTS.iter().enumerate() {
            let found = problem.solve(&data, *weight)?;
            let errors = errors(&own, design, &found.theta);
            let squares: f64 = errors.iter().zip(&estimate.noise).map(|(e, noise)| e.squares / (noise * noise)).sum();
            let rows: usize = errors.iter().map(|e| e.rows).sum();
            trials[k].0.push(squares / rows.max(1) as f64);
            trials[k].1 = errors.iter().fold(trials[k].1, |sum, e| sum.plus(e));
            progress((fold * WEIGHTS.len() + k + 1) as f64 / (count * WEIGHTS.len()) as f64);
        }
    }
    let trials: Vec<Trial> = trials.iter().zip(WEIGHTS).map(|((errors, held), weight)| trial(weight, errors, held)).collect();
    Ok(Choice { weight: strongest(&trials), trials })
}

fn trial(weight: f64, errors: &[f64], held: &Held) -> Trial {
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let variance = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    Trial { weight, error: mean, spread: (variance / n).sqrt(), relative: held.relative() }
}

/// The strongest prior that is no worse than the best by more than one standard error: folds of one motion are more
/// alike than motions are, so they flatter weak priors.
fn strongest(trials: &[Trial]) -> f64 {
    let best = trials.iter().min_by(|a, b| a.error.total_cmp(&b.error));
    let limit = best.map_or(f64::INFINITY, |best| best.error + best.spread);
    trials.iter().filter(|trial| trial.error <= limit).map(|trial| trial.weight).fold(0.0, f64::max)
}
