//! The least that any explanation of a row can leave: what a smooth function of the signals leaves, or noise.
use super::regression::BLOCKS;
use super::smoother::{self, Signals, reach};
use crate::experiments::Experiment;

/// A row counts as at least so many independent samples.
const INDEPENDENT: f64 = 300.0;

/// What varies within a few samples: a residual less its running mean.
fn quick_part(residual: &[f64]) -> Vec<f64> {
    const HALF: usize = 15;
    if residual.len() < 10 * HALF {
        // Postures and impacts are independent of each other.
        return Vec::new();
    }
    let mean = |i: usize| {
        let window = &residual[i.saturating_sub(HALF)..(i + HALF + 1).min(residual.len())];
        window.iter().sum::<f64>() / window.len() as f64
    };
    (0..residual.len()).map(|i| residual[i] - mean(i)).collect()
}

/// Variance and correlation length that any explanation can hope for.
pub(crate) fn noise_floor(
    train: &dyn Experiment,
    judge: &dyn Experiment,
    own_blocks: bool,
    (row, resolution): (usize, f64),
) -> (f64, f64) {
    let a: Signals = smoother::signals(train, row);
    let others = (!own_blocks).then(|| smoother::signals(judge, row));
    let b = others.as_ref().unwrap_or(&a);
    let noise = resolution.powi(2);
    let (r, s) = (train.residual(row), judge.residual(row));
    let (n, m) = (r.len(), s.len());
    let in_block = |i: usize, count: usize, wanted: usize| (i * BLOCKS / count.max(1)) % 3 == wanted;
    let moves = |experiment: &dyn Experiment, i: usize| !experiment.sticks(row).get(i).is_some_and(|s| *s);
    let for_training = |i: usize| moves(train, i) && (!own_blocks || !in_block(i, n, 1));
    let for_judging = |i: usize| moves(judge, i) && (!own_blocks || in_block(i, m, 1));
    match reach((&a, r, &for_training), (b, s, &for_judging)) {
        Some(reach) => {
            // However long a residual remembers, a log is worth a few hundred samples of those that count.
            let count = (0..m).filter(|&i| moves(judge, i)).count();
            let longest = (count as f64 / INDEPENDENT).max(1.0);
            (reach.after.min(reach.before).max(noise), reach.correlation.min(longest))
        }
        None => {
            let mean = s.iter().map(|x| x * x).sum::<f64>() / m.max(1) as f64;
            (noise.max(1e-6 * mean), smoother::correlation_length(&quick_part(s)))
        }
    }
}
