//! Payloads, whose second moments do not enter linearly: their forms are taken at their estimates, again and again.
use super::fit::{Candidate, TermProducts, fit};
use super::regression::Regression;
use crate::experiments::form::{Form, Search};
use crate::parallel::parallel;
use bipedc_effects::effect::Law;
use std::sync::OnceLock;

/// Steps in which a payload's second moments are taken at its estimate; more where its mass is not told at first and doubles at most.
const STEPS: usize = 6;
const STEPS_FROM_AFAR: usize = 12;

impl Regression<'_> {
    /// Takes nonlinear forms at their estimates beside the active candidates.
    pub fn linearise(&mut self, active: &[usize], corrected: bool) {
        let is_payload = |c: &usize| self.candidates[*c].form.kind.law == Law::Payload;
        let payloads: Vec<usize> = (0..self.candidates.len()).filter(is_payload).collect();
        if active.iter().any(|c| payloads.contains(c)) {
            for c in payloads {
                let found = self.linearised(c, &self.beside(c, active), corrected, None);
                self.replace(c, found);
            }
            return;
        }
        // None of them has anything to do with another.
        let found = parallel(payloads.len(), |k| {
            let c = payloads[k];
            self.linearised(c, &self.beside(c, active), corrected, None)
        });
        payloads.into_iter().zip(found).for_each(|(c, found)| self.replace(c, found));
    }

    /// What stands beside a payload: all that is active, or, where it would enter in its place, all but what else makes its link another body; beside that no
    /// data would tell it.
    fn beside(&self, payload: usize, active: &[usize]) -> Vec<usize> {
        if active.contains(&payload) {
            return active.to_vec();
        }
        let form = |c: usize| &self.candidates[c].form;
        let is_other = |c: usize| {
            form(c).location == form(payload).location
                && matches!(form(c).search, Search::Inertial(_))
                && !self.stands(c)
        };
        active.iter().copied().filter(|&c| !is_other(c)).collect()
    }

    /// Gives a candidate another form, with the products of its terms.
    pub fn replace(&mut self, c: usize, found: Option<(Candidate, Vec<TermProducts>)>) {
        if let Some((candidate, products)) = found {
            (self.candidates[c], self.products[c]) = (candidate, OnceLock::from(products));
        }
    }

    /// A candidate with its form taken at its estimate beside active ones, from a form on, and the products of its terms; `None`: it stays as it is.
    pub fn linearised(
        &self,
        c: usize,
        active: &[usize],
        corrected: bool,
        from: Option<Form>,
    ) -> Option<(Candidate, Vec<TermProducts>)> {
        let corrections = self.corrections.as_ref().filter(|_| corrected);
        let place = active.iter().position(|a| *a == c).unwrap_or(active.len());
        let others = |some: &[usize]| some.iter().flat_map(|&a| self.products_of(a)).collect::<Vec<_>>();
        let (before, after) = (others(&active[..place]), others(active.get(place + 1..).unwrap_or_default()));
        let of = |form: Form| {
            let rows = self.candidates[c].rows.clone();
            let candidate = Candidate::new(form, &[], rows, &self.spread, 0);
            let products = self.products_with(&candidate);
            (candidate, products)
        };
        let (mut step, mut steps) = (0, if from.is_some() { STEPS_FROM_AFAR } else { STEPS });
        let mut found: Option<(Candidate, Vec<TermProducts>)> = from.map(of);
        while step < steps {
            let (candidate, own) = found
                .as_ref()
                .map_or((&self.candidates[c], self.products_of(c)), |(c, own)| (c, own.as_slice()));
            let products: Vec<&TermProducts> =
                before.iter().copied().chain(own).chain(after.iter().copied()).collect();
            let Some(fit) = fit(corrections, &products) else { break };
            let mut coefficients = fit.coefficients[before.len()..before.len() + own.len()].to_vec();
            if step == 0 && found.is_none() && is_untold(own) {
                coefficients[0] = 0.0;
            }
            if step == 0 && coefficients.first() == Some(&0.0) {
                steps = STEPS_FROM_AFAR;
            }
            let Some(form) = candidate.form.linearised(self.train, &coefficients) else { break };
            found = Some(of(form));
            step += 1;
        }
        found
    }
}

/// Whether a mass does next to nothing beside what it does a metre away: in the origin of a link that turns about a fixed axis, but for rounding; or where an
/// estimate beside other effects ran away, so large that its place is the origin.
fn is_untold(own: &[TermProducts]) -> bool {
    /// Of squares: a length of a millimetre.
    const NOTHING: f64 = 1e-6;
    let squares: Vec<f64> = own.iter().map(|term| term.with(term)).collect();
    squares.split_first().is_some_and(|(here, moments)| moments.iter().any(|moment| *here < NOTHING * moment))
}
