//! Chains for work on all processors: what a chain says does not depend on what it was asked before, so any of them will do.
use super::{Chain, Hop, MidStance, Refused};
use crate::gait::PhasedBench;
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::Diagnostic;
use std::sync::{Mutex, PoisonError};

/// Chains of a gait that nobody needs at the moment.
pub(in crate::gait) struct Chains<'b> {
    bench: &'b PhasedBench,
    specs: &'b [PhaseSpec],
    idle: Mutex<Vec<Chain<'b>>>,
}

impl<'b> Chains<'b> {
    pub fn new(bench: &'b PhasedBench, specs: &'b [PhaseSpec]) -> Self {
        Self { bench, specs, idle: Mutex::new(Vec::new()) }
    }

    /// Something that a chain is asked.
    pub fn ask<T>(&self, question: impl FnOnce(&Chain<'b>) -> Result<T, Refused>) -> Result<T, Refused> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let chain = match idle {
            Some(chain) => chain,
            None => self.made()?,
        };
        let answer = question(&chain);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(chain);
        answer
    }

    fn made(&self) -> Result<Chain<'b>, Diagnostic> {
        let controller = self.bench.controller(None, &[]).map_err(|found| {
            let none = || Diagnostic::error("the gait has no controller");
            found.0.into_iter().next().unwrap_or_else(none)
        })?;
        Chain::new(self.bench, self.specs, controller)
    }

    /// The step with parameters `to` from the mid-stance of one with parameters `from`.
    pub fn hop(&self, from: &[f64], to: &[f64], speed: f64) -> Result<Hop, Refused> {
        self.ask(|chain| Ok(chain.hop(&chain.mid_stance(from, speed)?, to)))
    }

    /// φ̇_m of the next step for each of several speeds.
    pub fn speeds(&self, from: &[f64], to: &[f64], speeds: &[f64]) -> Vec<Result<f64, Refused>> {
        let all = self.ask(|chain| {
            let start = chain.mid_stance(from, 1.0)?;
            let next = |&speed: &f64| chain.hop(&start.at(speed), to).next.map(|next| next.speed);
            Ok(speeds.iter().map(next).collect::<Vec<_>>())
        });
        all.unwrap_or_else(|why| speeds.iter().map(|_| Err(why.clone())).collect())
    }

    /// The step with these parameters from a mid-stance.
    pub fn onward(&self, from: &MidStance, to: &[f64]) -> Result<Hop, Refused> {
        self.ask(|chain| Ok(chain.hop(from, to)))
    }
}
