//! What no machine can be, however well it fits.
use crate::diagnose::engine::equations::fit::{NormalEquations, sizes};
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::experiments::form::{Form, Search};
use crate::physical::is_possible;
use crate::robot::inertial_parameters::InertialParameters;

/// What an effect makes is at most so many times all that there is to explain, as sums of squares.
pub(crate) const MOST: f64 = 4.0;
/// Or so many times what is left more of the data that judge without it.
const MOST_OF_TOLD: f64 = 25.0;

impl Regression<'_> {
    /// Why a fit is physically impossible, if it is.
    pub fn impossible(&self, active: &[usize], scored: &ScoredFit) -> Option<(usize, String)> {
        (0..active.len()).filter(|&k| !self.standing.contains(&active[k])).find_map(|k| {
            let (form, coefficients) =
                (&self.candidates[active[k]].form, self.coefficients(active, scored, k));
            let why = form
                .impossible(coefficients)
                .or_else(|| self.massless(form, coefficients))
                .or_else(|| self.cancelled((active, k), scored).filter(|_| active.len() > 1))?;
            Some((active[k], why))
        })
    }

    /// Whether an effect makes far more than there is to explain, so that another one must take it back, and far more than is left without
    /// it: a pair that the data cannot tell apart. A spring that carries a load makes as much as the load, and data tell one from the other.
    fn cancelled(&self, (active, k): (&[usize], usize), scored: &ScoredFit) -> Option<String> {
        let candidate = &self.candidates[active[k]];
        let weighted = |of: &dyn Fn(usize) -> f64| -> f64 {
            candidate.rows.iter().map(|&r| of(r) * self.weights[r]).sum()
        };
        let made = |sums: &NormalEquations| {
            let of_rows = sizes(sums, &candidate.terms, self.coefficients(active, scored, k));
            weighted(&|r| of_rows[r])
        };
        if made(&self.train_sums) <= MOST * weighted(&|r| self.train_sums.rows[r].squares()) {
            return None;
        }
        let others: Vec<usize> = active.iter().copied().filter(|c| *c != active[k]).collect();
        let told = self
            .scored_fit(&others, !scored.fit.corrections.is_empty())
            .map_or(0.0, |without| weighted(&|r| without.errors[r] - scored.errors[r]));
        (made(&self.judge_sums) > MOST_OF_TOLD * told).then(|| {
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
