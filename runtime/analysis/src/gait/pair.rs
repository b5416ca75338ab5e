//! Two steps in a row, for any speed: the speed enters through the energy alone (6.15).
use super::course::Course;
use super::functions::GaitModel;
use super::landing::Landing;
use super::margins::Margins;
use super::step::Refusal;

/// A step and the next one, whose speeds are still open.
#[derive(Clone)]
pub struct StepPair<'a, 'm> {
    pub(super) gait: &'m GaitModel<'a>,
    /// Parameters of the second step.
    pub(super) to: Vec<f64>,
    /// The first step; `None`: there is no such step.
    pub now: Option<Course<'a, 'm>>,
    /// The impact between them.
    pub landing: Option<Landing>,
    /// The second step, where it is another one.
    other: Option<Course<'a, 'm>>,
    /// The second step is the first one again, number by number.
    repeats: bool,
    /// The first step is one of many with the parameters of the second.
    steady: bool,
    /// Why the second step is not made, at whatever speed.
    refusals: Vec<Refusal>,
}

impl<'a> GaitModel<'a> {
    /// Two steps with parameters `from` and `to`. The first one follows a step with parameters `before`; `None`: with its own.
    ///
    /// What is not possible is among the answers of the pair.
    pub fn pair(&self, before: Option<&[f64]>, from: &[f64], to: &[f64]) -> StepPair<'a, '_> {
        let mut refusals = Vec::new();
        let first = self.steady_landing(before.unwrap_or(from));
        let now = first.as_ref().map_err(|why| *why).and_then(|landing| self.course(from, landing));
        let now = noted(now, &mut refusals);
        refusals.extend(now.as_ref().and_then(Course::singular).map(Refusal::Singular));
        let landing = match &now {
            Some(now) => Some(now.landing.clone()),
            None => self.steady_landing(from).ok(),
        };
        let alone = before.is_none_or(|before| before == from);
        // A course is a function of its parameters and of the landing before it.
        let repeats = alone && from == to && now.is_some() && landing.as_ref() == first.as_ref().ok();
        if let Some(landing) = &landing
            && !(landing.eta > 0.0 && landing.momentum_after > 0.0)
        {
            refusals.push(Refusal::TurnsBack(landing.eta));
        }
        let next = |landing| noted(self.course(to, landing), &mut refusals);
        let other = landing.as_ref().filter(|_| !repeats).and_then(next);
        refusals.extend(other.as_ref().and_then(Course::singular).map(Refusal::Singular));
        let steady = alone && from == to;
        StepPair { gait: self, to: to.to_vec(), now, landing, other, repeats, steady, refusals }
    }
}

impl<'a, 'm> StepPair<'a, 'm> {
    /// The second step; `None`: there is no such step.
    pub fn next(&self) -> Option<&Course<'a, 'm>> {
        if self.repeats { self.now.as_ref() } else { self.other.as_ref() }
    }

    /// Whether the first step is one of many with the parameters of the second.
    pub(super) fn is_steady(&self) -> bool {
        self.steady
    }

    /// E of the second step where the first one passes its dead centre with `speed`, per s: `E[k+1] = δ (E[k] − P₋[k])` (6.15).
    pub fn next_energy(&self, speed: f64) -> Option<f64> {
        let (now, landing) = (self.now.as_ref()?, self.landing.as_ref()?);
        Some(landing.delta * (now.energy(speed) - now.p_minus))
    }

    /// φ̇_m of the second step where the first one passes its dead centre with `speed`, both per s.
    ///
    /// # Errors
    /// Why it does not get there.
    pub fn next_speed(&self, speed: f64) -> Result<f64, Refusal> {
        if let Some(why) = self.refusals.first() {
            return Err(*why);
        }
        // Without a refusal both are there.
        let (Some(next), Some(energy)) = (self.next(), self.next_energy(speed)) else {
            return Err(Refusal::NoSteadyStart);
        };
        next.speed(energy).ok_or(Refusal::FallsBack { energy, needed: next.p_max })
    }

    /// Margins of the second step and of the impact before it where the first one passes its dead centre with `speed`, per s.
    pub fn margins(&self, speed: f64) -> Margins {
        let (Some(now), Some(landing), Some(next)) = (&self.now, &self.landing, self.next()) else {
            return Margins::default();
        };
        let kinetic = now.energy(speed) - now.p_minus;
        let energy = landing.delta * kinetic;
        let mut margins = self.gait.margins(next, next.speed(energy).map(|_| energy));
        let impact_speed = (2.0 * kinetic).sqrt() / landing.momentum_before;
        self.gait.impact_margins(landing, impact_speed, &mut margins);
        margins
    }
}

impl Course<'_, '_> {
    /// φ̇_m of a step that is one of many of its kind, E∞ = P₋ δ/(δ − 1) (6.17), per s; `None`: such steps end in a fall.
    pub fn steady_speed(&self) -> Option<f64> {
        let Landing { delta, eta, momentum_after, .. } = self.landing;
        if !(delta < 1.0 && eta > 0.0 && momentum_after > 0.0) || self.singular().is_some() {
            return None;
        }
        self.speed(self.steady_energy())
    }

    /// E∞ = P₋ δ/(δ − 1) (6.17): E of one of many steps of this kind.
    pub(super) fn steady_energy(&self) -> f64 {
        let delta = self.landing.delta;
        self.p_minus * delta / (delta - 1.0)
    }
}

fn noted<T>(found: Result<T, Refusal>, refusals: &mut Vec<Refusal>) -> Option<T> {
    found.map_err(|why| refusals.push(why)).ok()
}
