//! How sure estimates are: standard deviations of parameters, from what residuals scatter and what the prior pulls.
use super::refinement::{BLOCKS, Data, T};
use crate::diagnose::engine::equations::block_equations::BlockEquations;
use crate::experiments::Channel;
use crate::robot::inertial_parameters::parameter_index;
use nalgebra::{DMatrix, DVector};

/// Standard deviations of the unknowns from the scores of blocks of time (which residuals may be correlated
/// within), at least those of white residuals; and of the corrections. Where a few impacts tell an unknown, as those in which a foot
/// slides tell its friction, their scores scatter less than they would if the estimate did not follow them, and say little of how much: they
/// count for more, so that [`T`] of these standard deviations is half of a 95 % interval (Bell and McCaffrey, Survey Methodology 28, 2002, for
/// one unknown at a time). Logs have many samples in every block.
pub(crate) fn uncertainty(
    equations: &[BlockEquations],
    data: Data<'_>,
    unknowns: usize,
    corrections: &[f64],
) -> (Vec<f64>, DMatrix<f64>) {
    let Data { experiment, weights, .. } = data;
    let of_impacts = experiment.rows().iter().all(|row| row.channel == Channel::PostImpactVelocity);
    let p = corrections.len();
    let n = p + unknowns;
    let mut sums = Sums::new((n, p), of_impacts);
    for (row, of_row) in equations.iter().enumerate() {
        sums.add(of_row, corrections, (weights[row], experiment.rows()[row].noise));
    }
    let Sums { mut information, scores, white, white_of_blocks } = sums;
    // What changes no row stays unknown, without making the rest unknown too.
    let unseen: Vec<usize> = (0..n).filter(|&i| information[(i, i)] <= 0.0).collect();
    unseen.iter().for_each(|&i| information[(i, i)] = 1.0);
    let Some(inverse) = scaled_inverse(&information) else {
        return (vec![f64::INFINITY; unknowns], DMatrix::identity(p, p));
    };
    let sigma = |index: usize| {
        if unseen.contains(&index) {
            return f64::INFINITY;
        }
        let row = inverse.row(index);
        let least = (row * &white * row.transpose())[0];
        let scores = scores.iter().map(|s| (row * s)[0]);
        let robust = if of_impacts {
            let part = |white: &DMatrix<f64>| (row * white * row.transpose())[0] / least;
            let parts: Vec<f64> = white_of_blocks.iter().map(part).collect();
            few_blocks(&parts) * scattered(scores, &parts)
        } else {
            scores.map(|score| score * score).sum()
        };
        // What the prior pulls estimates by: true corrections are as far from its middle as it says.
        let pulled: f64 = row.iter().take(p).map(|x| x * x).sum();
        (robust.max(least) + pulled).sqrt()
    };
    ((p..n).map(sigma).collect(), inverse.view((0, 0), (p, p)).into_owned())
}

/// Sums over all rows, by corrections and unknowns.
struct Sums {
    information: DMatrix<f64>,
    /// One of each block.
    scores: Vec<DVector<f64>>,
    /// Variance of the scores if residuals were white.
    white: DMatrix<f64>,
    /// The same of each block; none where nobody asks.
    white_of_blocks: Vec<DMatrix<f64>>,
}

impl Sums {
    /// Of n corrections and unknowns, the first p of which have a prior of one.
    fn new((n, p): (usize, usize), by_block: bool) -> Self {
        let zeros = DMatrix::<f64>::zeros(n, n);
        let mut information = zeros.clone();
        (0..p).for_each(|i| information[(i, i)] = 1.0);
        let white_of_blocks = vec![zeros.clone(); if by_block { BLOCKS } else { 0 }];
        Self { information, scores: vec![DVector::zeros(n); BLOCKS], white: zeros, white_of_blocks }
    }

    /// Adds a row of this weight and noise (standard deviation).
    fn add(&mut self, of_row: &BlockEquations, corrections: &[f64], (weight, noise): (f64, f64)) {
        let p = corrections.len();
        let places = places(of_row, p);
        let last = of_row.residual();
        let mut u = DVector::zeros(last + 1);
        u[last] = 1.0;
        for (local, global) in places.iter().filter(|(_, global)| *global < p) {
            u[*local] = -corrections[*global];
        }
        let all: Vec<usize> = (0..BLOCKS).collect();
        let total = of_row.sum(&all);
        let squares = (&total * &u).dot(&u).max(0.0);
        // No row is known better than its noise, however small the residual of a fit.
        let variance = (squares / of_row.count(&all).max(1) as f64).max(noise.powi(2));
        let spread = |to: &mut DMatrix<f64>, factor: f64, of: &DMatrix<f64>| {
            for (a, ga) in &places {
                for (b, gb) in &places {
                    to[(*ga, *gb)] += factor * of[(*a, *b)];
                }
            }
        };
        spread(&mut self.information, weight, &total);
        spread(&mut self.white, weight.powi(2) * variance, &total);
        for (white, gram) in self.white_of_blocks.iter_mut().zip(&of_row.grams) {
            spread(white, weight.powi(2) * variance, gram);
        }
        for (score, gram) in self.scores.iter_mut().zip(&of_row.grams) {
            let product = gram * &u;
            for (local, global) in &places {
                score[*global] += weight * product[*local];
            }
        }
    }
}

/// The least part of its own residual that a block may keep from an estimate that follows it.
const KEPT: f64 = 1e-3;

/// The variance that scores of blocks show, each as much larger as the estimate follows it. `parts`: of the information, by block.
fn scattered(scores: impl Iterator<Item = f64>, parts: &[f64]) -> f64 {
    scores.zip(parts).map(|(score, part)| score.powi(2) / (1.0 - part).max(KEPT)).sum()
}

/// 97.5 % points of Student's t by degrees of freedom.
const STUDENT: [(f64, f64); 8] = [
    (1.0, 12.706),
    (2.0, 4.303),
    (3.0, 3.182),
    (4.0, 2.776),
    (6.0, 2.447),
    (10.0, 2.228),
    (16.0, 2.120),
    (BLOCKS as f64 - 1.0, T),
];

/// How much larger a variance counts that so unevenly filled blocks show.
fn few_blocks(parts: &[f64]) -> f64 {
    let all: f64 = parts.iter().sum();
    let freedom = all.powi(2) / parts.iter().map(|part| part * part).sum::<f64>() - 1.0;
    // Linear between the logarithms, over the reciprocals.
    let at = |[(a, low), (b, high)]: [(f64, f64); 2]| {
        let part = (a.recip() - freedom.recip()) / (a.recip() - b.recip());
        (low.ln() + part.clamp(0.0, 1.0) * (high.ln() - low.ln())).exp()
    };
    let pair = STUDENT.windows(2).find(|pair| freedom <= pair[1].0);
    (pair.map_or(T, |pair| at([pair[0], pair[1]])) / T).powi(2)
}

/// (local, global) indices of a row's columns among corrections and unknowns.
fn places(of_row: &BlockEquations, p: usize) -> Vec<(usize, usize)> {
    let mut places = Vec::new();
    if p > 0 {
        for (place, body) in of_row.bodies.iter().enumerate() {
            places.extend((0..10).map(|k| (parameter_index(place, k), parameter_index(*body, k))));
        }
    }
    places.extend(of_row.ids.iter().enumerate().map(|(k, id)| (of_row.inertial() + k, p + id)));
    places
}

fn scaled_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale: Vec<f64> = (0..matrix.nrows()).map(|i| matrix[(i, i)].sqrt().recip()).collect();
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    let scaled =
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |r, c| matrix[(r, c)] * scale[r] * scale[c]);
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |r, c| inverse[(r, c)] * scale[r] * scale[c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Even blocks count as they are; two that tell all have one degree of freedom; one that tells all says nothing by itself.
    #[test]
    fn few_blocks_say_little_of_their_scatter() {
        let even = [1.0 / BLOCKS as f64; BLOCKS];
        assert!((few_blocks(&even) - 1.0).abs() < 1e-9);
        let mut two = [0.0; BLOCKS];
        (two[3], two[7]) = (0.5, 0.5);
        assert!((few_blocks(&two).sqrt() - 12.706 / T).abs() < 1e-9);
        let five: Vec<f64> = (0..BLOCKS).map(|k| if k < 5 { 0.2 } else { 0.0 }).collect();
        assert!((few_blocks(&five).sqrt() - 2.776 / T).abs() < 1e-9);
        assert_eq!(scattered([3.0, 3.0].into_iter(), &[0.5, 0.5]), 36.0);
        assert_eq!(scattered([0.0].into_iter(), &[1.0]), 0.0);
    }
}
