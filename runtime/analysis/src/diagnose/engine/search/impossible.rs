//! What no machine can be, however well it fits.
use crate::diagnose::engine::equations::fit::{Candidate, sizes};
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::experiments::form::{Form, Search};
use crate::physical::is_possible;
use crate::robot::inertial_parameters::InertialParameters;

/// What an effect makes is at most so many times all that there is to explain, as sums of squares.
pub(crate) const MOST: f64 = 4.0;

impl Regression<'_> {
    /// Why a fit is physically impossible, if it is.
    pub fn impossible(&self, active: &[usize], scored: &ScoredFit) -> Option<(usize, String)> {
        (0..active.len()).filter(|&k| !self.standing.contains(&active[k])).find_map(|k| {
            let (form, coefficients) =
                (&self.candidates[active[k]].form, self.coefficients(active, scored, k));
            let why = form.impossible(coefficients).or_else(|| self.massless(form, coefficients)).or_else(
                || self.cancelled(&self.candidates[active[k]], coefficients).filter(|_| active.len() > 1),
            )?;
            Some((active[k], why))
        })
    }

    /// Whether an effect makes far more than there is to explain, so that another one must take it back: a pair that
    /// the data cannot tell apart.
    fn cancelled(&self, candidate: &Candidate, coefficients: &[f64]) -> Option<String> {
        let made = sizes(&self.train_sums, &candidate.terms, coefficients);
        let weighted = |of: &dyn Fn(usize) -> f64| -> f64 {
            candidate.rows.iter().map(|&r| of(r) * self.weights[r]).sum()
        };
        let wanted = weighted(&|r| self.train_sums.rows[r].squares());
        (weighted(&|r| made[r]) > MOST * wanted).then(|| {
            "it and another effect would cancel each other: this data cannot tell them apart".to_owned()
        })
    }

    /// Whether an effect on a link leaves no body that can exist: its pseudo-inertia must be positive definite.
    fn massless(&self, form: &Form, coefficients: &[f64]) -> Option<String> {
        let Search::Inertial(_) = form.search else { return None };
        let nominal = self.train.inertial_parameters();
        let change = self.train.inertial_change(&form.effect(coefficients));
        let possible = nominal
            .chunks_exact(InertialParameters::PER_BODY)
            .zip(change.chunks_exact(InertialParameters::PER_BODY))
            .all(|(body, change)| {
                let p: [f64; 10] = std::array::from_fn(|k| body[k] + change[k]);
                change.iter().all(|c| *c == 0.0) || is_possible(&p)
            });
        (!possible).then(|| "no body has such an inertia".to_owned())
    }
}
