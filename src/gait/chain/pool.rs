//! Chains for work on all processors: what a chain says does not depend on what it was asked before, so any of them will do.
use super::known::Known;
use super::{Chain, Hop, MidStance, Refused, hop};
use crate::gait::PhasedBench;
use bipedc_analysis::gait::{Assumptions, Reason};
use bipedc_analysis::simulate::phases::{PhaseSpec, Precision};
use bipedc_effects::diagnostic::Diagnostic;
use std::sync::{Arc, Mutex, PoisonError};

/// What a map has in a cell.
pub(in crate::gait) type SpeedAndReason = Result<(f64, Option<Reason>), Refused>;

/// Chains of a gait that nobody needs at the moment.
pub(in crate::gait) struct Chains<'b> {
    bench: &'b PhasedBench,
    specs: &'b [PhaseSpec],
    assume: Assumptions,
    precision: Precision,
    known: Arc<Known>,
    idle: Mutex<Vec<Chain<'b>>>,
}

impl<'b> Chains<'b> {
    /// With one chain, so that what is wrong with the gait is heard before anything is asked.
    ///
    /// # Errors
    /// As [`Chain::new`].
    pub fn new(bench: &'b PhasedBench, specs: &'b [PhaseSpec]) -> Result<Self, Diagnostic> {
        let (assume, precision, known) = (Assumptions::default(), hop::PRECISION, Arc::default());
        let found = Self { bench, specs, assume, precision, known, idle: Mutex::new(Vec::new()) };
        let first = found.made()?;
        Ok(Self { idle: Mutex::new(vec![first]), ..found })
    }

    /// The same where steps have to keep these margins.
    ///
    /// # Errors
    /// Nothing is known of a margin.
    pub fn assuming(self, assume: Assumptions) -> Result<Self, Diagnostic> {
        self.made()?.known(assume)?;
        Ok(Self { assume, ..self })
    }

    /// The same for steps that need not be known as closely as others: before any is asked for.
    pub fn roughly(mut self) -> Self {
        self.precision = hop::ROUGH;
        self.idle.get_mut().unwrap_or_else(PoisonError::into_inner).clear();
        self
    }

    /// A step, and the first assumption that it breaks.
    fn stepped(&self, chain: &Chain<'b>, from: &MidStance, to: &[f64]) -> (Hop, Option<Reason>) {
        if !self.assume.any() {
            return (chain.hop(from, to), None);
        }
        let (hop, margins) = chain.hop_with_margins(from, to, 0);
        let broken = Hop::violated(self.assume, &margins).filter(|_| hop.next.is_ok());
        (hop, broken)
    }

    /// A step; none that breaks an assumption.
    fn kept(&self, chain: &Chain<'b>, from: &MidStance, to: &[f64]) -> Hop {
        let (mut hop, broken) = self.stepped(chain, from, to);
        if let Some(reason) = broken {
            hop.next = Err(Refused::new(reason, reason.words()));
        }
        hop
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
        let chain = Chain::new(self.bench, self.specs, controller)?;
        Ok(Chain { precision: self.precision, known: self.known.clone(), ..chain })
    }

    /// The step with parameters `to` from the mid-stance of one with parameters `from`.
    pub fn hop(&self, from: &[f64], to: &[f64], speed: f64) -> Result<Hop, Refused> {
        self.ask(|chain| Ok(self.kept(chain, &chain.mid_stance(from, speed)?, to)))
    }

    /// φ̇_m of the next step, and the first assumption that it breaks.
    pub fn speed(&self, from: &[f64], to: &[f64], speed: f64) -> SpeedAndReason {
        self.ask(|chain| {
            let (hop, broken) = self.stepped(chain, &chain.mid_stance(from, speed)?, to);
            hop.next.map(|next| (next.speed, broken))
        })
    }

    /// How many phases do something else where this gait parameter is another.
    pub fn phases_that_read(&self, parameter: usize) -> usize {
        let count = |chain: &Chain<'b>| {
            let read = chain.phases.iter().flatten().filter(|of| of.read.all.contains(&parameter));
            Ok(read.count())
        };
        self.ask(count).unwrap_or(0)
    }

    /// The step with these parameters from a mid-stance.
    pub fn onward(&self, from: &MidStance, to: &[f64]) -> Result<Hop, Refused> {
        self.ask(|chain| Ok(self.kept(chain, from, to)))
    }
}
