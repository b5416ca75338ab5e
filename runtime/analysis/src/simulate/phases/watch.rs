//! Looks at every accepted step of the integration: guards, samples, assumptions.
use super::integrate::{Phased, Violation, Watcher};
use bipedc_effects::diagnostic::Diagnostic;
use ivp::dense::StepInterpolant;
use ivp::prelude::{ControlFlag, FirstOrderSystem};
use ivp::solout::SolOut;

/// A guard that began at zero (a foot that has just left the ground) counts once it was above this.
pub(super) const ARMED: f64 = 1e-9;
/// Places of a step at which the guard is looked at, at least.
pub(super) const LOOKS: usize = 4;
/// Steps so much shorter than guards are looked at are looked at once: those across kinks.
const SHORT: f64 = 0.01;
/// Instants are found to this, s.
pub(super) const INSTANT: f64 = 1e-13;
/// The first instant of a violation is found to this, s.
pub(super) const VERDICT: f64 = 1e-9;

/// How the integration of one phase ended.
pub(super) enum PhaseEnd {
    Nothing,
    Guard,
    Event,
    Kink,
    Violated(Violation),
    Stopped,
}

/// A phase as the integrator knows it.
pub(super) struct Derivative<'s> {
    pub system: &'s dyn Phased,
    pub phase: usize,
}

impl FirstOrderSystem for Derivative<'_> {
    fn derivative(&self, time: f64, x: &[f64], out: &mut [f64]) {
        self.system.derivative(self.phase, time, x, out);
    }
}

/// Looks at every accepted step.
pub(super) struct Watch<'s> {
    pub system: &'s dyn Phased,
    pub phase: usize,
    /// Whether the guard was positive in this phase.
    pub armed: bool,
    /// Whether an event within the phase is still to come.
    pub awaits: bool,
    pub largest_look: f64,
    pub shortest_look: f64,
    pub guards: usize,
    pub time: f64,
    pub x: Vec<f64>,
    pub work: Vec<f64>,
    pub found: Result<PhaseEnd, Diagnostic>,
    pub watcher: &'s mut dyn Watcher,
}

impl SolOut for Watch<'_> {
    fn solout(
        &mut self,
        from: f64,
        to: &mut f64,
        x: &mut [f64],
        interpolant: Option<&StepInterpolant<'_>>,
    ) -> ControlFlag {
        let Some(dense) = interpolant.filter(|_| *to > from) else { return ControlFlag::Continue };
        let short = *to - from < SHORT * self.largest_look;
        // A quotient by zero is more than any number of looks.
        let [most, least] =
            [self.shortest_look, self.largest_look].map(|look| ((*to - from) / look).ceil() as usize);
        let looks = if short { 1 } else { LOOKS.min(most).max(least) };
        let mut earlier = from;
        for look in 1..=looks {
            let last = look == looks;
            let later = if last { *to } else { from + (*to - from) * look as f64 / looks as f64 };
            if last {
                self.work.copy_from_slice(x);
            } else {
                dense.interpolate(later, &mut self.work);
            }
            self.guards += 1;
            let guard = self.system.guard(self.phase, later, &self.work);
            let ends = self.armed && guard <= 0.0;
            let end = ends.then(|| self.instant(dense, earlier, later, Self::guard_at));
            let event = self.event(dense, (earlier, later), x, last);
            match (end, event) {
                (end, Some(event)) if end.is_none_or(|[_, end]| event < end) => {
                    self.found = Ok(PhaseEnd::Event);
                    return self.arrive(dense, from, event);
                }
                (Some(end), _) => return self.arrive_at_guard(dense, from, end),
                (None, _) => {}
            }
            self.armed |= guard > ARMED;
            if !last && self.system.glimpse(self.phase, later, &self.work).is_some() {
                return self.arrive(dense, from, later);
            }
            earlier = later;
        }
        self.arrive_at_end(dense, from, *to, x)
    }
}

impl Watch<'_> {
    fn guard_at(&mut self, dense: &StepInterpolant<'_>, time: f64) -> f64 {
        dense.interpolate(time, &mut self.work);
        self.guards += 1;
        self.system.guard(self.phase, time, &self.work)
    }

    fn before_event_at(&mut self, dense: &StepInterpolant<'_>, time: f64) -> f64 {
        dense.interpolate(time, &mut self.work);
        self.system.before_event(self.phase, time, &self.work).unwrap_or(f64::NAN)
    }

    /// When what is awaited happens between two times, at the later of which the state is `x` where it is the last.
    fn event(
        &mut self,
        dense: &StepInterpolant<'_>,
        (earlier, later): (f64, f64),
        x: &[f64],
        last: bool,
    ) -> Option<f64> {
        if !self.awaits {
            return None;
        }
        if !last {
            dense.interpolate(later, &mut self.work);
        }
        let state = if last { x } else { &self.work };
        let falls = self.system.before_event(self.phase, later, state).is_some_and(|before| before <= 0.0);
        falls.then(|| self.instant(dense, earlier, later, Self::before_event_at)[1])
    }

    /// Where a function falls through zero between two times: regula falsi with halved weights (Illinois), then halving.
    fn instant(
        &mut self,
        dense: &StepInterpolant<'_>,
        mut positive: f64,
        mut negative: f64,
        of: fn(&mut Self, &StepInterpolant<'_>, f64) -> f64,
    ) -> [f64; 2] {
        let (mut above, mut below) = (of(self, dense, positive), of(self, dense, negative));
        // Which end stayed in the last round: its weight is halved.
        let mut stayed = 0;
        for round in 0..200 {
            if negative - positive <= INSTANT {
                break;
            }
            let middle = 0.5 * (positive + negative);
            let secant = positive + (negative - positive) * above / (above - below);
            let inside = secant > positive && secant < negative;
            let time = if inside && round < 40 { secant } else { middle };
            if time <= positive || time >= negative {
                break;
            }
            let guard = of(self, dense, time);
            if guard > 0.0 {
                (positive, above) = (time, guard);
                if stayed == 1 {
                    below *= 0.5;
                }
                stayed = 1;
            } else {
                (negative, below) = (time, guard);
                if stayed == -1 {
                    above *= 0.5;
                }
                stayed = -1;
                if guard == 0.0 {
                    break;
                }
            }
        }
        [positive, negative]
    }

    /// To a time within the step.
    fn arrive(&mut self, dense: &StepInterpolant<'_>, from: f64, time: f64) -> ControlFlag {
        let mut x = vec![0.0; self.x.len()];
        dense.interpolate(time, &mut x);
        self.arrive_at_end(dense, from, time, &x)
    }

    /// To the end of the phase between two times. Forces may jump there, where torques do: what has to hold in the phase holds until just before.
    fn arrive_at_guard(
        &mut self,
        dense: &StepInterpolant<'_>,
        from: f64,
        [before, time]: [f64; 2],
    ) -> ControlFlag {
        self.found = Ok(PhaseEnd::Guard);
        let flag = self.arrive(dense, from, before);
        if matches!(self.found, Ok(PhaseEnd::Guard)) {
            self.time = time;
            dense.interpolate(time, &mut self.x);
        }
        flag
    }

    /// Takes the samples, shows the state and checks the assumptions there; if one is violated, goes back to where that began.
    fn arrive_at_end(
        &mut self,
        dense: &StepInterpolant<'_>,
        from: f64,
        mut time: f64,
        x: &[f64],
    ) -> ControlFlag {
        self.x.copy_from_slice(x);
        if let Some(violation) = self.system.violation(self.phase, time, x) {
            let (violation, first) = self.first(dense, from, time, violation);
            if first < time {
                dense.interpolate(first, &mut self.x);
            }
            time = first;
            self.found = Ok(PhaseEnd::Violated(violation));
        }
        self.time = time;
        while self.watcher.next_sample() <= time {
            let at = self.watcher.next_sample();
            dense.interpolate(at, &mut self.work);
            if let Err(error) = self.watcher.sample(at, self.phase, &self.work) {
                self.found = Err(error);
                return ControlFlag::Interrupt;
            }
        }
        if !self.watcher.step(time, self.phase, &self.x) && matches!(self.found, Ok(PhaseEnd::Nothing)) {
            self.found = Ok(PhaseEnd::Stopped);
        }
        if matches!(self.found, Ok(PhaseEnd::Nothing)) {
            // A guard that has counted is to count on.
            if self.system.has_kink_behind() && self.system.guard(self.phase, time, &self.x) > ARMED {
                self.found = Ok(PhaseEnd::Kink);
                return ControlFlag::Interrupt;
            }
            ControlFlag::Continue
        } else {
            ControlFlag::Interrupt
        }
    }

    /// The first instant at which an assumption does not hold, within a step at whose end one does not.
    fn first(
        &mut self,
        dense: &StepInterpolant<'_>,
        mut holds: f64,
        mut broken: f64,
        mut violation: Violation,
    ) -> (Violation, f64) {
        while broken - holds > VERDICT {
            let middle = 0.5 * (holds + broken);
            dense.interpolate(middle, &mut self.work);
            match self.system.violation(self.phase, middle, &self.work) {
                Some(found) => (broken, violation) = (middle, found),
                None => holds = middle,
            }
        }
        (violation, broken)
    }
}
