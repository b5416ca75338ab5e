//! Where the whole robot passes the dead centres of a gait of several phases.
use crate::gait::{Chain, Refused};
use bipedc_runtime::control::Observation;

/// Waits for the dead centre of each step's first phase, and notices a phase that turns back.
pub(super) struct Stance<'c> {
    chain: &'c Chain<'c>,
    first: usize,
    /// φ_m of the present step, while it is still to come.
    centre: Option<f64>,
}

/// What has happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// The dead centre is passed at this φ̇, per s.
    Passed(f64),
    /// φ̇ has vanished, so far before the dead centre, if that is still to come.
    Rests(Option<f64>),
}

impl<'c> Stance<'c> {
    pub fn new(chain: &'c Chain<'c>) -> Result<Self, Refused> {
        Ok(Self { chain, first: chain.first()?, centre: None })
    }

    /// Whether a phase is the first one of a step.
    pub fn begins_step(&self, phase: usize) -> bool {
        phase == self.first
    }

    /// A step with these parameters begins; φ̇ where its mid-stance is there and then, because it begins on its way down.
    pub fn begin(&mut self, values: &[f64], observed: &Observation<'_, f64>) -> Result<Option<f64>, Refused> {
        let (q, v) = (observed.q, observed.v);
        let centre = self.chain.dead_centre_from(values, q, v)?;
        let [phase, rate] = self.chain.phase_at(self.first, q, v)?;
        let later = centre > phase;
        self.centre = later.then_some(centre);
        Ok((!later).then_some(rate))
    }

    /// Positive until something happens.
    pub fn before(&self, observed: &Observation<'_, f64>) -> Option<f64> {
        let [phase, rate] = self.chain.phase_at(observed.phase, observed.q, observed.v).ok()?;
        let left = self.awaited(observed.phase).map_or(f64::INFINITY, |centre| centre - phase);
        Some(rate.min(left))
    }

    /// What it was.
    pub fn event(&mut self, observed: &Observation<'_, f64>) -> Option<Event> {
        let [phase, rate] = self.chain.phase_at(observed.phase, observed.q, observed.v).ok()?;
        let missing = self.awaited(observed.phase).map(|centre| centre - phase);
        self.centre = None;
        // Of the two that may have fallen through zero it is the one that is nearer to it.
        Some(match missing {
            Some(missing) if missing.abs() <= rate.abs() => Event::Passed(rate),
            missing => Event::Rests(missing),
        })
    }

    fn awaited(&self, phase: usize) -> Option<f64> {
        self.centre.filter(|_| self.begins_step(phase))
    }
}
