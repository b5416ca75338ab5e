//! Essential parameters: the fewest that predict as well on data that did not teach.
use super::accumulate::Sums;
use super::design::Design;
use super::estimate::{Estimate, HeldOutError, by_channel, compared, errors, joined, normalised};
use super::triangle::Triangle;

/// A set of parameters that suffices; all others are zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Essential {
    /// Unknowns, ascending.
    pub unknowns: Vec<usize>,
    /// Error on data that did not teach, of all seen unknowns and of these, over all channels.
    pub held_out: [HeldOutError; 2],
}

/// Drops the least certain parameter again and again, and keeps the smallest set that is no worse than the best by more
/// than one standard error of their difference.
pub fn essential(estimate: &Estimate, design: &Design<'_>, sums: &Sums, folds: &[usize]) -> Essential {
    let zeros = Estimate { held: estimate.held.map(|_| 0.0), ..estimate.clone() };
    let parts = parts(&zeros, design, sums, folds);
    let mut free = estimate.seen.clone();
    let (mut sets, mut errors_of, mut held) = (Vec::new(), Vec::new(), Vec::new());
    while !free.is_empty() {
        let judged: Vec<Vec<HeldOutError>> =
            parts.iter().map(|(data, own)| errors(own, design, &zeros.solve(data, &free))).collect();
        errors_of.push(judged.iter().map(|e| normalised(e, &estimate.noise)).collect::<Vec<f64>>());
        held.push(judged.iter().flatten().fold(HeldOutError::default(), |sum, e| sum.plus(e)));
        sets.push(free.clone());
        let theta = zeros.solve(&zeros.total, &free);
        let spread = zeros.inverse(&free);
        let certainty = |k: usize| theta[free[k]].powi(2) / spread[(k, k)];
        let Some(least) = (0..free.len()).min_by(|&a, &b| certainty(a).total_cmp(&certainty(b))) else {
            break;
        };
        free.remove(least);
    }
    let excess = compared(&errors_of);
    let last = (0..sets.len()).rev().find(|&k| excess[k][0] <= excess[k][1]).unwrap_or(0);
    Essential { unknowns: sets[last].clone(), held_out: [held[0], held[last]] }
}

/// Per fold the weighted regression of all other cells, and the channels of its own.
fn parts(
    estimate: &Estimate,
    design: &Design<'_>,
    sums: &Sums,
    folds: &[usize],
) -> Vec<(Triangle, Vec<Triangle>)> {
    let count = folds.iter().copied().max().unwrap_or(0) + 1;
    let part = |fold: usize| {
        let others: Vec<Triangle> =
            estimate.cells.iter().zip(folds).filter(|(_, of)| **of != fold).map(|(c, _)| c.clone()).collect();
        let own = by_channel(sums, design, &|cell| folds[cell] == fold);
        (joined(estimate.total.columns(), &others), own)
    };
    (0..count).map(part).filter(|(data, own)| data.rows() > 0 && own.iter().any(|t| t.rows() > 0)).collect()
}
