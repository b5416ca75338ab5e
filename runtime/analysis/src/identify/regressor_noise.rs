//! What the noise of accelerations makes of an estimate: least squares takes its regressors as exact.
//!
//! Rows `W + δ` with the noise δ of the encoders in them give `(G)⁻¹ (G − D) θ` instead of θ, with `G = (W + δ)ᵀ (W + δ)` and
//! `D = E[δᵀ δ]`: always to the same side, in every stretch of motion alike, so that no leaving out of stretches shows it. Regressors
//! are linear in accelerations, so D follows from the noise of each joint's and the regressor at the log's own postures.
use super::accumulate::{Settings, Sums};
use super::design::{Design, Work};
use super::estimate::Estimate;
use super::run::RobotAndLogs;
use crate::robot::Batch;
use nalgebra::{DMatrix, DVector};

/// Postures of each log at which the regressor is looked at.
const POSTURES: usize = 200;
/// Of a direction, the largest part of what is seen that is taken for noise: beyond it nothing is known but that.
const MOST: f64 = 0.95;

/// An unknown whose estimate rests on noise by more than this part is not told.
const UNTOLD: f64 = 0.3;

/// What noise does to an estimate.
pub(super) struct NoiseEffect {
    /// By how much it moves each unknown.
    pub moved: DVector<f64>,
    /// Unknowns whose estimates rest on noise.
    pub untold: Vec<usize>,
}

/// What noise of accelerations does to the estimate `theta`.
pub(super) fn noise_effect(
    parts: &RobotAndLogs<'_>,
    (design, sums, settings): (&Design<'_>, &Sums, &Settings),
    estimate: &Estimate,
    theta: &DVector<f64>,
) -> NoiseEffect {
    let mut effect = NoiseEffect { moved: DVector::zeros(theta.len()), untold: Vec::new() };
    let free = &estimate.seen;
    let noise = squares_of_noise(parts, design, sums, settings, &estimate.noise);
    let lengths = estimate.total.lengths();
    let scale = DVector::from_iterator(free.len(), free.iter().map(|&k| lengths[k].max(f64::MIN_POSITIVE)));
    let mut columns = estimate.total.matrix().select_columns(free);
    columns.column_iter_mut().zip(scale.iter()).for_each(|(mut c, s)| c /= *s);
    let r = columns.qr().r();
    let Some(inverse) = r.solve_upper_triangular(&DMatrix::identity(free.len(), free.len())) else {
        return effect;
    };
    let own =
        DMatrix::from_fn(free.len(), free.len(), |i, j| noise[(free[i], free[j])] / (scale[i] * scale[j]));
    let parts = (inverse.transpose() * own * &inverse).symmetric_eigen();
    let scaled = DVector::from_iterator(free.len(), free.iter().map(|&k| theta[k])).component_mul(&scale);
    let mut along = parts.eigenvectors.tr_mul(&(&r * scaled));
    for (x, part) in along.iter_mut().zip(parts.eigenvalues.iter()) {
        let part = part.clamp(0.0, MOST);
        *x *= part / (1.0 - part);
    }
    let ways = &inverse * &parts.eigenvectors;
    effect.untold = free
        .iter()
        .zip(ways.row_iter())
        .filter(|(_, way)| {
            let noise: f64 = way.iter().zip(parts.eigenvalues.iter()).map(|(x, part)| x * x * part).sum();
            noise > UNTOLD * way.norm_squared()
        })
        .map(|(&k, _)| k)
        .collect();
    let found = (ways * along).component_div(&scale);
    free.iter().zip(found.iter()).for_each(|(&k, x)| effect.moved[k] = *x);
    effect
}

/// `E[δᵀ δ]` of all rows, each divided by its channel's noise.
fn squares_of_noise(
    parts: &RobotAndLogs<'_>,
    design: &Design<'_>,
    sums: &Sums,
    settings: &Settings,
    weights: &[f64],
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(design.unknowns.len(), design.unknowns.len());
    let samples: usize = parts.surveys.iter().map(|survey| survey.samples).sum();
    for survey in parts.surveys {
        let filter = settings.row_filter(survey.step);
        let noise = survey.accelerations.noise_behind(survey, filter.as_ref());
        let count = survey.motion.time.len().min(POSTURES);
        let share = survey.samples as f64 / (samples.max(1) * count.max(1)) as f64;
        let postures = Postures::of(design, &survey.motion.positions, count);
        for (joint, variance) in noise.iter().enumerate().filter(|(_, variance)| **variance > 0.0) {
            let along = postures.along(design, joint);
            for (index, channel) in design.channels.iter().enumerate() {
                let weight = variance * share * sums.rows(index) as f64 / weights[index].powi(2);
                let own = along[index].tr_mul(&along[index]) * weight;
                for (i, &a) in channel.places.iter().enumerate() {
                    channel.places.iter().enumerate().for_each(|(j, &b)| all[(a, b)] += own[(i, j)]);
                }
            }
        }
    }
    all
}

/// Postures that a log shows, and the regression there at rest.
struct Postures {
    count: usize,
    q: Vec<f64>,
    nv: usize,
    rest: Vec<DMatrix<f64>>,
}

impl Postures {
    fn of(design: &Design<'_>, positions: &[Vec<f64>], count: usize) -> Self {
        let base = design.layout.base;
        let mut q = Vec::new();
        for i in 0..count {
            q.extend_from_slice(base.rest());
            q.extend(positions.iter().map(|signal| signal[i * signal.len() / count]));
        }
        let mut new = Self { count, q, nv: base.nv() + design.layout.joints.len(), rest: Vec::new() };
        new.rest = new.columns(design, &vec![0.0; count * new.nv]);
        new
    }

    /// What an acceleration of one joint by 1 adds to the columns of every channel.
    fn along(&self, design: &Design<'_>, joint: usize) -> Vec<DMatrix<f64>> {
        let mut a = vec![0.0; self.count * self.nv];
        let place = design.layout.base.nv() + joint;
        a.iter_mut().skip(place).step_by(self.nv).for_each(|a| *a = 1.0);
        let moved = self.columns(design, &a);
        moved.into_iter().zip(&self.rest).map(|(moved, rest)| moved - rest).collect()
    }

    fn columns(&self, design: &Design<'_>, a: &[f64]) -> Vec<DMatrix<f64>> {
        let batch = Batch { count: self.count, q: &self.q, v: &vec![0.0; a.len()], a };
        let mut work = Work::default();
        design.evaluate(&batch, &mut work);
        let of = |(index, channel): (usize, &super::design::Channel)| {
            let mut columns = Vec::new();
            design.rows(index, &batch, None, &work, &mut columns);
            DMatrix::from_vec(self.count, channel.places.len(), columns)
        };
        design.channels.iter().enumerate().map(of).collect()
    }
}
