//! How much CAD counts: chosen on the training logs alone.
use crate::identify::estimate::{by_channel, compared, errors, joined, mean, normalised};
use crate::identify::{Design, Estimate, HeldOutError, Sums, Triangle};
use crate::physical::Problem;
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;

/// Weights that are tried.
pub const WEIGHTS: [f64; 14] =
    [1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

/// One weight that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TriedWeight {
    /// Weight of CAD.
    pub weight: f64,
    /// Mean squared error on data that did not teach, each channel in units of its noise.
    pub error: f64,
    /// By how much that is more than the best weight's, with its standard error over the folds.
    pub excess: [f64; 2],
    /// |error| / |measured| over all channels, on data that did not teach.
    pub relative: f64,
}

/// What was chosen, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The weight.
    pub weight: f64,
    /// All that were tried; none if the weight was given.
    pub trials: Vec<TriedWeight>,
}

/// Tries all weights by folds and takes the middle (geometric mean) of the best one and of the strongest that is no worse
/// by more than one standard error of their difference. Folds of one motion are more alike than motions are, so the best
/// is flattered by them; the strongest stands at the edge of what the data allow.
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
    let count = folds.iter().copied().max().unwrap_or(0) + 1;
    let mut errors_of = vec![Vec::new(); WEIGHTS.len()];
    let mut held = vec![HeldOutError::default(); WEIGHTS.len()];
    let mut failed: [Option<Diagnostic>; WEIGHTS.len()] = std::array::from_fn(|_| None);
    for fold in 0..count {
        let others: Vec<Triangle> =
            estimate.cells.iter().zip(folds).filter(|(_, of)| **of != fold).map(|(c, _)| c.clone()).collect();
        let data = joined(estimate.total.columns(), &others);
        let own = by_channel(sums, design, &|cell| folds[cell] == fold);
        if own.iter().all(|triangle| triangle.rows() == 0) || data.rows() == 0 {
            continue;
        }
        let data = data.least_squares();
        for (k, weight) in WEIGHTS.iter().enumerate() {
            match problem.solve(&data, *weight) {
                Ok(physical) => {
                    let errors = errors(&own, design, &physical.theta);
                    errors_of[k].push(normalised(&errors, &estimate.noise));
                    held[k] = errors.iter().fold(held[k], |sum, e| sum.plus(e));
                }
                Err(error) => failed[k] = Some(error),
            }
            progress((fold * WEIGHTS.len() + k + 1) as f64 / (count * WEIGHTS.len()) as f64);
        }
    }
    // A weight with which the program cannot be solved is none to choose.
    let solved: Vec<usize> = (0..WEIGHTS.len()).filter(|&k| failed[k].is_none()).collect();
    if let (true, Some(error)) = (solved.is_empty(), failed.into_iter().flatten().next()) {
        return Err(error);
    }
    let errors_of: Vec<Vec<f64>> = solved.iter().map(|&k| std::mem::take(&mut errors_of[k])).collect();
    let trials: Vec<TriedWeight> = solved
        .iter()
        .zip(&errors_of)
        .zip(compared(&errors_of))
        .map(|((&k, errors), excess)| TriedWeight {
            weight: WEIGHTS[k],
            error: mean(errors),
            excess,
            relative: held[k].relative(),
        })
        .collect();
    let good = trials.iter().filter(|trial| trial.excess[0] <= trial.excess[1]);
    let strongest = good.map(|trial| trial.weight).fold(f64::MIN_POSITIVE, f64::max);
    let best =
        trials.iter().min_by(|a, b| a.error.total_cmp(&b.error)).map_or(strongest, |trial| trial.weight);
    Ok(Choice { weight: (best * strongest).sqrt(), trials })
}
