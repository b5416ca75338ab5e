//! Block normal equations: products of everything that may explain a residual, by row and block of time.
//!
//! Once they are formed, every fit and every held-out error is a small dense problem, whatever the length of the log.
use super::fit::RowGram;
use crate::experiments::Experiment;
use crate::experiments::form::Column;
use crate::robot::inertial_parameters::{InertialParameters, body_of, element_of, parameter_index};
use nalgebra::DMatrix;
use std::ops::Range;

/// Samples that are multiplied at a time.
const CHUNK: usize = 512;

/// How CAD errors spread: per body a matrix whose columns span one standard deviation. Unknowns of the fits are
/// multiples of these columns, so that their prior is the unit matrix.
pub(super) struct Spread {
    /// Lower triangular 10 × 10, one per body; zero where nothing is uncertain.
    pub factors: Vec<DMatrix<f64>>,
    /// Whether anything may be corrected. If not, the columns only serve effects on links as coordinates.
    pub corrects: bool,
}

impl Spread {
    pub fn new(
        experiment: &dyn Experiment,
        error: &crate::robot::link_inertias::CadError,
        widening: f64,
    ) -> Self {
        let bodies = experiment.inertial_count() / InertialParameters::PER_BODY;
        let nothing = crate::robot::link_inertias::CadError { mass: 0.0, center: 0.0, inertia: 0.0 };
        let corrects = *error != nothing;
        let usual = crate::robot::link_inertias::CadError::default();
        let error = if corrects { error } else { &usual };
        let mut covariances = vec![DMatrix::<f64>::zeros(10, 10); bodies];
        for (body, direction) in experiment.cad_directions(error) {
            let d = nalgebra::DVector::from_row_slice(&direction);
            covariances[body] += &d * d.transpose();
        }
        let factor = |covariance: DMatrix<f64>| {
            // Scaled to a unit diagonal first: kilograms and kg m² differ by many orders.
            let scale: Vec<f64> = (0..10).map(|i| covariance[(i, i)].sqrt()).collect();
            if scale.contains(&0.0) {
                return DMatrix::zeros(10, 10);
            }
            let scaled = DMatrix::from_fn(10, 10, |r, c| {
                covariance[(r, c)] / (scale[r] * scale[c]) + if r == c { 1e-9 } else { 0.0 }
            });
            match scaled.cholesky() {
                Some(cholesky) => DMatrix::from_fn(10, 10, |r, c| widening * scale[r] * cholesky.l()[(r, c)]),
                None => DMatrix::zeros(10, 10),
            }
        };
        Self { factors: covariances.into_iter().map(factor).collect(), corrects }
    }

    /// Nothing may be corrected.
    pub fn none() -> Self {
        Self { factors: Vec::new(), corrects: false }
    }

    /// The same with uncertainty in some bodies only.
    pub fn only(&self, bodies: &[usize]) -> Self {
        let factors = self.factors.iter().enumerate();
        let kept = |(body, factor): (usize, &DMatrix<f64>)| match bodies.contains(&body) {
            true => factor.clone(),
            false => DMatrix::zeros(10, 10),
        };
        Self { factors: factors.map(kept).collect(), corrects: self.corrects }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        10 * self.factors.len()
    }

    /// A change of inertial parameters as multiples of the columns; 0 for bodies without uncertainty.
    pub fn coordinates(&self, change: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(change.len());
        for (factor, change) in self.factors.iter().zip(change.chunks_exact(InertialParameters::PER_BODY)) {
            let right = nalgebra::DVector::from_row_slice(change);
            match factor.solve_lower_triangular(&right) {
                Some(x) if x.iter().all(|v| v.is_finite()) => out.extend(x.iter()),
                _ => out.extend([0.0; 10]),
            }
        }
        out
    }

    /// The change of inertial parameters that these multiples make.
    pub fn change(&self, coordinates: &[f64]) -> Vec<f64> {
        self.factors
            .iter()
            .zip(coordinates.chunks_exact(InertialParameters::PER_BODY))
            .flat_map(|(f, x)| (f * nalgebra::DVector::from_row_slice(x)).iter().copied().collect::<Vec<_>>())
            .collect()
    }
}

/// One row of one experiment.
pub(super) struct BlockEquations {
    /// Bodies whose inertial parameters matter to the row.
    pub bodies: Vec<usize>,
    /// Ids of the columns that touch it, ascending: their local order.
    pub ids: Vec<usize>,
    /// Per block: products of inertial columns, other columns and the residual (last).
    pub grams: Vec<DMatrix<f64>>,
    /// Samples per block.
    pub counts: Vec<usize>,
}

impl BlockEquations {
    /// Number of inertial columns.
    pub fn inertial(&self) -> usize {
        parameter_index(self.bodies.len(), 0)
    }
    /// Local index of the residual.
    pub fn residual(&self) -> usize {
        self.inertial() + self.ids.len()
    }
    /// One block.
    pub fn block(&self, block: usize) -> RowGram<'_> {
        RowGram { bodies: &self.bodies, ids: &self.ids, gram: &self.grams[block] }
    }
    /// The sum over some blocks.
    pub fn sum(&self, blocks: &[usize]) -> DMatrix<f64> {
        let size = self.residual() + 1;
        blocks.iter().fold(DMatrix::zeros(size, size), |sum, &b| sum + &self.grams[b])
    }
    /// Samples in some blocks.
    pub fn count(&self, blocks: &[usize]) -> usize {
        blocks.iter().map(|&b| self.counts[b]).sum()
    }
}

/// Limits of equal blocks of samples.
pub(super) fn block_limits(samples: usize, blocks: usize) -> Vec<usize> {
    (0..=blocks).map(|b| b * samples / blocks).collect()
}

/// Samples of a range that count at all.
fn counted(emphasis: Option<&[f64]>, range: Range<usize>) -> usize {
    emphasis.map_or(range.len(), |emphasis| emphasis[range].iter().filter(|e| **e > 0.0).count())
}

/// Forms all products of one row. `columns` have ids; those that do not touch the row are passed over. `emphasis`
/// multiplies each sample.
pub(super) fn block_equations(
    experiment: &dyn Experiment,
    row: usize,
    spread: &Spread,
    columns: &[(usize, &Column)],
    blocks: usize,
    emphasis: Option<&[f64]>,
) -> BlockEquations {
    let residual = experiment.residual(row);
    let inertial = experiment.inertial(row);
    let mut bodies: Vec<usize> =
        inertial.map_or(Vec::new(), |i| i.columns.iter().map(|c| body_of(*c)).collect());
    bodies.dedup();
    bodies.retain(|&b| spread.factors.get(b).is_some_and(|f| f[(0, 0)] != 0.0));
    let touching: Vec<(usize, &Vec<f64>)> = columns
        .iter()
        .filter_map(|(id, column)| column.iter().find(|(r, _)| *r == row).map(|(_, v)| (*id, v)))
        .collect();
    let p = 10 * bodies.len();
    let size = p + touching.len() + 1;
    let limits = block_limits(residual.len(), blocks);
    let mut of_row = BlockEquations {
        bodies,
        ids: touching.iter().map(|(id, _)| *id).collect(),
        grams: Vec::with_capacity(blocks),
        counts: limits.windows(2).map(|w| counted(emphasis, w[0]..w[1])).collect(),
    };
    for block in limits.windows(2) {
        let mut gram = DMatrix::zeros(size, size);
        let mut first = block[0];
        while first < block[1] {
            let last = (first + CHUNK).min(block[1]);
            let mut x = DMatrix::zeros(last - first, size);
            if let Some(inertial) = inertial {
                fill_inertial(&mut x, inertial, spread, &of_row.bodies, first);
            }
            for (k, (_, values)) in touching.iter().enumerate() {
                x.column_mut(p + k).copy_from_slice(&values[first..last]);
            }
            x.column_mut(size - 1).copy_from_slice(&residual[first..last]);
            if let Some(emphasis) = emphasis {
                for (mut sample, factor) in x.row_iter_mut().zip(&emphasis[first..last]) {
                    sample *= *factor;
                }
            }
            // Not `gemm_tr`, which has no kernel for blocks.
            gram.gemm(1.0, &x.transpose(), &x, 1.0);
            first = last;
        }
        of_row.grams.push(gram);
    }
    of_row
}

fn fill_inertial(
    x: &mut DMatrix<f64>,
    inertial: &crate::experiments::Inertial,
    spread: &Spread,
    bodies: &[usize],
    first: usize,
) {
    let width = inertial.columns.len();
    // Where each column of the row goes: its body's place, and the row of that body's factor.
    let places: Vec<Option<(usize, usize)>> = inertial
        .columns
        .iter()
        .map(|c| bodies.iter().position(|b| *b == body_of(*c)).map(|place| (place, element_of(*c))))
        .collect();
    let samples = first * width..(first + x.nrows()) * width;
    let y = DMatrix::from_row_slice(x.nrows(), width, &inertial.values[samples]);
    for (value, place) in y.column_iter().zip(&places) {
        let Some((place, element)) = *place else { continue };
        let factor = &spread.factors[bodies[place]];
        for k in 0..=element {
            x.column_mut(parameter_index(place, k)).axpy(factor[(element, k)], &value, 1.0);
        }
    }
}
