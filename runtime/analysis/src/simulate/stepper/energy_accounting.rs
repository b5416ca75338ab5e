//! The work of everything in a step, for whoever asks for it.
use super::{MotionState, RowSource, Stepper};
use crate::simulate::account::{Account, Done};
use crate::simulate::dense;

/// Work so far, with the room to sum it.
#[derive(Debug, Clone, Default)]
pub(super) struct EnergyAccounting {
    account: Account,
    /// γ⁺ of the closed rows.
    after: Vec<f64>,
    /// Height at the midpoint of every row that is the normal of a point.
    heights: Vec<f64>,
    /// By block: whether it is a servo's.
    driven: Vec<bool>,
}

impl Stepper<'_> {
    /// The same, and the work of everything is summed from now on: [`Self::account`].
    #[must_use]
    pub fn accounted(mut self) -> Self {
        let room = || Vec::with_capacity(self.before.capacity());
        let driven = Vec::with_capacity(self.before.capacity());
        self.energy_accounting =
            Some(EnergyAccounting { account: Account::default(), after: room(), heights: room(), driven });
        self
    }

    /// What acts and is not part of [`Self::account`].
    pub(in crate::simulate) fn beyond_account(&self) -> Option<&'static str> {
        if !self.motors.laws.is_empty() {
            return Some("motors behind springs or play");
        }
        if !self.coupled.is_empty() {
            return Some("joints coupled by an inertia");
        }
        (!self.soles.points.is_empty()).then_some("soles that turn")
    }

    /// Work so far; `None` unless [`Self::accounted`].
    pub fn account(&self) -> Option<&Account> {
        self.energy_accounting.as_ref().map(|accounting| &accounting.account)
    }

    /// γ⁺ of the closed rows, for the accounting; before `drive` leaves the coordinates `L⁻ᵀ`.
    pub(super) fn velocities_after(&mut self, rows: usize) {
        let Some(accounting) = &mut self.energy_accounting else { return };
        accounting.after.clear();
        accounting.heights.clear();
        if rows == 0 {
            return;
        }
        accounting.after.extend_from_slice(&self.before);
        dense::add_rows(&self.directions, &self.drive, &mut accounting.after);
        accounting.heights.resize(rows, 0.0);
        accounting.driven.clear();
        accounting.driven.extend(self.sources.iter().map(|source| matches!(source, RowSource::Servo(_))));
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            if let RowSource::Point(point) = *source {
                accounting.heights[block.first] = self.gaps[point];
            }
        }
    }

    /// Adds the step to the accounting; `drive` is the change of the velocities.
    pub(super) fn book(&mut self, motion: &MotionState, force: &[f64], time: f64) {
        let Some(accounting) = &mut self.energy_accounting else { return };
        accounting.account.add(&Done {
            time,
            velocity: &motion.v,
            change: &self.drive,
            force,
            joints: &self.joints,
            blocks: &self.problem.blocks,
            impulse: &self.problem.impulse,
            before: &self.before,
            after: &accounting.after,
            heights: &accounting.heights,
            driven: &accounting.driven,
            soft: self.ground.compliance,
        });
    }

    /// `½ Λ · (γ⁻ + γ⁺)` of the points on hard ground, from ξ = γ⁺ + e γ⁻.
    pub(super) fn made(&self) -> f64 {
        if self.ground.compliance.is_some() || self.problem.rows() == 0 {
            return 0.0;
        }
        let [normal, tangential] = [self.ground.normal_restitution, self.ground.tangential_restitution];
        let mut sum = 0.0;
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            let slides = match source {
                RowSource::Point(_) | RowSource::Normal(_) => block.first + 1,
                RowSource::Sole(_) => block.first,
                _ => continue,
            };
            for row in block.first..block.first + block.size() {
                let restitution = if row < slides { normal } else { tangential };
                let mean = 0.5 * (self.problem.velocity[row] + (1.0 - restitution) * self.before[row]);
                sum += self.problem.impulse[row] * mean;
            }
        }
        sum
    }
}
