//! Block normal equations: products of everything that may explain a residual, by row and block of time.
//!
//! Once they are formed, every fit and every held-out error is a small dense problem, whatever the length of the log.
use super::fit::RowGram;
use crate::experiments::Experiment;
use crate::experiments::form::Column;
use crate::gram::{add_lower, mirror};
use crate::robot::inertial_parameters::{InertialParameters, body_of, element_of, parameter_index};
use nalgebra::DMatrix;
use std::ops::Range;

/// Samples that are multiplied at a time.
const CHUNK: usize = 512;

/// How CAD errors spread: per body a matrix whose columns span one standard deviation. Unknowns of the fits are
/// multiples of these columns, so that their prior is the unit matrix.
pub(crate) struct Spread {
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
pub(crate) struct BlockEquations {
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
pub(crate) fn block_limits(samples: usize, blocks: usize) -> Vec<usize> {
    (0..=blocks).map(|b| b * samples / blocks).collect()
}

/// Samples of a range that count at all.
fn counted(emphasis: Option<&[f64]>, range: Range<usize>) -> usize {
    emphasis.map_or(range.len(), |emphasis| emphasis[range].iter().filter(|e| **e > 0.0).count())
}

/// Forms all products of one row. `columns` have ids; those that do not touch the row are passed over. `emphasis`
/// multiplies each sample.
pub(crate) fn block_equations(
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
    let uncertain = Uncertain::new(inertial, bodies, spread);
    let limits = block_limits(residual.len(), blocks);
    let others: Vec<&[f64]> =
        touching.iter().map(|(_, values)| values.as_slice()).chain([residual]).collect();
    let gram = |block: &[usize]| uncertain.spread_out(&uncertain.gram(block[0]..block[1], &others, emphasis));
    BlockEquations {
        ids: touching.iter().map(|(id, _)| *id).collect(),
        grams: limits.windows(2).map(gram).collect(),
        counts: limits.windows(2).map(|w| counted(emphasis, w[0]..w[1])).collect(),
        bodies: uncertain.bodies,
    }
}

/// The inertial columns of a row whose bodies are uncertain.
struct Uncertain<'a> {
    inertial: Option<&'a crate::experiments::Inertial>,
    bodies: Vec<usize>,
    /// Of each column its place among the row's, and what spreads it: where its body's ten unknowns begin and the row of the factor.
    columns: Vec<(usize, usize, Vec<f64>)>,
}

impl<'a> Uncertain<'a> {
    fn new(inertial: Option<&'a crate::experiments::Inertial>, bodies: Vec<usize>, spread: &Spread) -> Self {
        let all = inertial.map_or(&[][..], |inertial| &inertial.columns);
        let place = |(at, column): (usize, &usize)| {
            let place = bodies.iter().position(|b| *b == body_of(*column))?;
            let (factor, element) = (&spread.factors[bodies[place]], element_of(*column));
            let row = (0..=element).map(|k| factor[(element, k)]).collect();
            Some((at, parameter_index(place, 0), row))
        };
        let columns = all.iter().enumerate().filter_map(place).collect();
        Self { inertial, bodies, columns }
    }

    /// Products of the columns as they are, and of others behind them, over some samples.
    fn gram(&self, samples: Range<usize>, others: &[&[f64]], emphasis: Option<&[f64]>) -> DMatrix<f64> {
        let own = self.columns.len();
        let mut gram = DMatrix::zeros(own + others.len(), own + others.len());
        for first in samples.clone().step_by(CHUNK) {
            let chunk = first..(first + CHUNK).min(samples.end);
            let mut x = DMatrix::zeros(chunk.len(), own + others.len());
            if let Some(inertial) = self.inertial {
                let width = inertial.columns.len();
                let rows = &inertial.values[chunk.start * width..chunk.end * width];
                for (mut x, (at, ..)) in x.column_iter_mut().zip(&self.columns) {
                    x.iter_mut().zip(rows[*at..].iter().step_by(width)).for_each(|(x, value)| *x = *value);
                }
            }
            for (k, values) in others.iter().enumerate() {
                x.column_mut(own + k).copy_from_slice(&values[chunk.clone()]);
            }
            if let Some(emphasis) = emphasis {
                for (mut sample, factor) in x.row_iter_mut().zip(&emphasis[chunk]) {
                    sample *= *factor;
                }
            }
            add_lower(&x, &mut gram);
        }
        mirror(&mut gram);
        gram
    }

    /// The same of multiples of what is uncertain, ten for each body, in the place of the columns.
    fn spread_out(&self, gram: &DMatrix<f64>) -> DMatrix<f64> {
        let (own, all) = (self.columns.len(), gram.ncols());
        let p = parameter_index(self.bodies.len(), 0);
        let spread = |gram: &DMatrix<f64>| {
            let mut out = DMatrix::zeros(gram.nrows(), p + all - own);
            for (column, (_, first, row)) in gram.column_iter().zip(&self.columns) {
                for (k, factor) in row.iter().enumerate() {
                    out.column_mut(first + k).axpy(*factor, &column, 1.0);
                }
            }
            out.columns_mut(p, all - own).copy_from(&gram.columns(own, all - own));
            out
        };
        // Once for its columns and once for its rows.
        let mut both = spread(&spread(gram).transpose());
        mirror(&mut both);
        both
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::Inertial;

    /// Products of columns, spread afterwards, are those of spread columns.
    #[test]
    fn products_spread_as_columns_do() {
        let wave = |i: usize, k: usize| (0.7 * (i + 1) as f64 * (k + 2) as f64).sin();
        let factor = |body: usize| {
            DMatrix::from_fn(10, 10, |r, c| if c <= r { 1.5 + wave(r + 3 * body, c) } else { 0.0 })
        };
        let spread = Spread { factors: vec![factor(0), DMatrix::zeros(10, 10), factor(2)], corrects: true };
        // Some columns of a body without uncertainty between those of two that have some.
        let columns = vec![0, 1, 5, 12, 13, 20, 23, 29];
        let samples = 1300;
        let values = (0..samples).flat_map(|i| (0..8).map(move |k| wave(i, k))).collect();
        let inertial = Inertial { columns: columns.clone(), values };
        let others: Vec<Vec<f64>> = (8..11).map(|k| (0..samples).map(|i| wave(i, k)).collect()).collect();
        let others: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
        let emphasis: Vec<f64> = (0..samples).map(|i| f64::from(u8::from(i % 7 != 3))).collect();
        let uncertain = Uncertain::new(Some(&inertial), vec![0, 2], &spread);
        let found = uncertain.spread_out(&uncertain.gram(100..samples, &others, Some(&emphasis)));
        let direct = DMatrix::from_fn(samples - 100, 23, |row, c| {
            let i = row + 100;
            let own = |body: usize, k: usize| -> f64 {
                let here = columns.iter().enumerate().filter(|(_, column)| body_of(**column) == body);
                here.map(|(at, column)| spread.factors[body][(element_of(*column), k)] * wave(i, at)).sum()
            };
            emphasis[i]
                * match c {
                    0..10 => own(0, c),
                    10..20 => own(2, c - 10),
                    _ => others[c - 20][i],
                }
        });
        let wanted = direct.transpose() * &direct;
        assert!((&found - &wanted).amax() < 1e-12 * wanted.amax());
        assert_eq!(found, found.transpose());
    }
}
