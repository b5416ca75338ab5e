//! How errors weigh in a search: by what a smooth function of the signals could reach, and by the noise that is heard.
use super::fit::Corrections;
use super::noise_floor::noise_floor;
use super::regression::{Regression, ScoredFit};
use crate::diagnose::engine::refine::amended::Amended;
use crate::experiments::Experiment;
use crate::experiments::noise::heard;
use crate::parallel::parallel;
use bipedc_effects::effect::{Effect, Law};
use std::sync::OnceLock;

/// Squared errors below so many times the noise's variance are noise, whatever lowers them: estimates of noise are no better. Of n
/// samples, [`NOISE_SCATTER`] / √n more, two standard deviations of the mean of two logs' estimates.
const NOISE_SQUARES: f64 = 1.05;
const NOISE_SCATTER: f64 = 4.0;

/// A noise floor, times the samples in a row that tell the same, that effects lower further than to this part of it was none.
const LOWER: f64 = 0.6;
/// Noise that is so many times larger than it was taken is worth another search.
const LOUDER: f64 = 1.1;

impl Regression<'_> {
    /// Weights from what a smooth function of the signals could reach, or the noise where there are no signals.
    pub fn weigh(&mut self) {
        let rows = self.train.rows();
        self.noise_floors = parallel(rows.len(), |row| {
            noise_floor(self.train, self.judge, self.own_blocks, (row, self.resolutions[row]))
        });
        self.floor_deviance = self
            .judge_sums
            .rows
            .iter()
            .zip(&self.noise_floors)
            .map(|(row, (_, c))| row.count as f64 / c)
            .collect();
        let rows = self.judge_sums.rows.iter().enumerate();
        self.noise_squares = rows.map(|(row, sums)| self.noise_squares_of(row, sums.count)).collect();
        self.weigh_by_noise_floors();
    }

    /// Sum of squares of so many samples of a row below which errors are the measurement's noise.
    pub fn noise_squares_of(&self, row: usize, count: usize) -> f64 {
        // Tables of postures and impacts know no more than a bound of their noise.
        if self.is_table {
            return 0.0;
        }
        let count = count as f64;
        (NOISE_SQUARES + NOISE_SCATTER / count.max(1.0).sqrt()) * self.resolutions[row].powi(2) * count
    }

    /// Whether so much is what the noise of measurement and motion leave of so many judging samples of a row. What the encoders' noise makes of the
    /// model's own torque goes with all that is computed from the same motion.
    pub fn is_noise(&self, row: usize, squares: f64, count: usize) -> bool {
        let of_motion = self.judge.motion_noise(row).powi(2) * count as f64;
        squares <= self.noise_squares_of(row, count) + of_motion
    }

    fn weigh_by_noise_floors(&mut self) {
        self.weights =
            self.noise_floors.iter().map(|(variance, correlation)| 1.0 / (variance * correlation)).collect();
        let wanted = self.train.inertial_count() > 0 && self.spread.corrects;
        self.corrections =
            wanted.then(|| Corrections::new(&self.train_sums, &self.weights, self.spread.len()));
        self.products = self.candidates.iter().map(|_| OnceLock::new()).collect();
    }

    /// Lowers the noise floor where these effects, as a search scored them, leave less than a smooth function of the signals could reach, which
    /// follows no jump: what such a function reaches beside them, and for how long that is alike. Tells whether that changed anything worth
    /// another search.
    pub fn reweigh(&mut self, effects: &[Effect], scored: &ScoredFit) -> bool {
        let beside = |experiment| {
            let mut left = Amended::new(experiment, effects);
            if !scored.fit.corrections.is_empty() {
                left.correct(&self.spread.change(&scored.fit.corrections));
            }
            left
        };
        let (train, judge) = (beside(self.train), beside(self.judge));
        // A row that is left as it was has the floor that it had.
        let touched = |row: &usize| !(is_left(self.train, &train, *row) && is_left(self.judge, &judge, *row));
        let rows: Vec<usize> = (0..self.noise_floors.len()).filter(touched).collect();
        let floors = parallel(rows.len(), |k| {
            noise_floor(&train, &judge, self.own_blocks, (rows[k], self.resolutions[rows[k]]))
        });
        let mut changed = false;
        for (row, found) in rows.into_iter().zip(floors) {
            let known = &mut self.noise_floors[row];
            if found.0 * found.1 < LOWER * known.0 * known.1 {
                *known = found;
                changed = true;
            }
        }
        if changed {
            self.weigh_by_noise_floors();
        }
        changed
    }

    /// Takes noise for as large as what is left by these effects, as a search scored them, shows it to be: beside what they explain noise
    /// that is correlated in time could not be told. Tells whether that changed anything worth another search.
    pub fn hear(&mut self, effects: &[Effect], scored: &ScoredFit) -> bool {
        // Limits trim what is left, and with it the noise that they may be mistaken for.
        let kept = effects.iter().filter(|effect| !matches!(effect.kind.law, Law::TrueTorque(_)));
        let kept: Vec<Effect> = kept.cloned().collect();
        let mut left = Amended::new(self.train, &kept);
        if !scored.fit.corrections.is_empty() {
            left.correct(&self.spread.change(&scored.fit.corrections));
        }
        let mut changed = false;
        for (row, resolution) in self.resolutions.iter_mut().enumerate() {
            let noise = heard(self.train, row, left.residual(row));
            if noise > LOUDER * *resolution {
                *resolution = noise;
                changed = true;
            }
        }
        if changed {
            self.weigh();
        }
        changed
    }
}

/// Whether effects leave a row of an experiment as it is, and where its joint sticks.
fn is_left(experiment: &dyn Experiment, beside: &Amended<'_>, row: usize) -> bool {
    experiment.residual(row) == beside.residual(row) && experiment.sticks(row) == beside.sticks(row)
}
