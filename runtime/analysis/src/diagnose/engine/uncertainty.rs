//! How sure estimates are: standard deviations of parameters, from what residuals scatter and what the prior pulls.
use super::block_equations::BlockEquations;
use super::refinement::{BLOCKS, Data};
use crate::robot::inertial_parameters::parameter_index;
use nalgebra::{DMatrix, DVector};

/// Standard deviations of the unknowns from the scores of blocks of time (which residuals may be correlated
/// within), at least those of white residuals; and of the corrections.
pub(super) fn uncertainty(
    equations: &[BlockEquations],
    data: Data<'_>,
    unknowns: usize,
    corrections: &[f64],
) -> (Vec<f64>, DMatrix<f64>) {
    let Data { experiment, weights, .. } = data;
    let p = corrections.len();
    let n = p + unknowns;
    let mut information = DMatrix::<f64>::zeros(n, n);
    (0..p).for_each(|i| information[(i, i)] = 1.0);
    let mut scores = vec![DVector::<f64>::zeros(n); BLOCKS];
    // Variance of the scores if residuals were white.
    let mut white = DMatrix::<f64>::zeros(n, n);
    for (row, of_row) in equations.iter().enumerate() {
        let places = places(of_row, p);
        let last = of_row.residual();
        let mut u = DVector::zeros(last + 1);
        u[last] = 1.0;
        for (local, global) in &places {
            if *global < p {
                u[*local] = -corrections[*global];
            }
        }
        let total = of_row.sum(&(0..BLOCKS).collect::<Vec<_>>());
        let squares = (&total * &u).dot(&u).max(0.0);
        let count = of_row.count(&(0..BLOCKS).collect::<Vec<_>>()).max(1) as f64;
        // No row is known better than its noise, however small the residual of a fit.
        let variance = (squares / count).max(experiment.rows()[row].noise.powi(2));
        for (a, ga) in &places {
            for (b, gb) in &places {
                information[(*ga, *gb)] += weights[row] * total[(*a, *b)];
                white[(*ga, *gb)] += weights[row].powi(2) * variance * total[(*a, *b)];
            }
        }
        for (block, score) in scores.iter_mut().enumerate() {
            let product = &of_row.grams[block] * &u;
            for (local, global) in &places {
                score[*global] += weights[row] * product[*local];
            }
        }
    }
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
        let robust: f64 = scores.iter().map(|s| (row * s)[0].powi(2)).sum();
        let least = (row * &white * row.transpose())[0];
        // What the prior pulls estimates by: true corrections are as far from its middle as it says.
        let pulled: f64 = row.iter().take(p).map(|x| x * x).sum();
        (robust.max(least) + pulled).sqrt()
    };
    ((p..n).map(sigma).collect(), inverse.view((0, 0), (p, p)).into_owned())
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
