//! From the mid-stance speed of a step to that of the next (6.15–6.20).
use super::course::Course;
use super::functions::GaitModel;
use super::landing::Landing;
use super::margins::Margins;
use super::surface::SurfaceFailure;
use serde::Serialize;
use std::fmt;

/// Why a step is not made, or has no numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// The guard vanishes nowhere between these phases.
    GuardNotReached([f64; 2]),
    /// At a phase there is no posture on the constraints.
    NoPosture(f64, SurfaceFailure),
    /// At a phase the zero dynamics are no numbers.
    NotFinite(f64),
    /// The foot that lands is so high above the ground, m.
    NotOnTheGround(f64),
    /// φ₊ of a step after its own kind does not settle.
    NoSteadyStart,
    /// φ₊ does not lie before φ₋.
    NoPhaseLeft([f64; 2]),
    /// Without h_p the outputs differ from what is wanted by so much after the impact, rad or m.
    OutputsJump(f64),
    /// The phase variable turns back at the impact: η.
    TurnsBack(f64),
    /// α is not above 0 at this phase: the phase variable does not grow with the angular momentum.
    Singular(f64),
    /// The energy does not reach that of the dead centre (6.13), both in (kg m²/s)².
    FallsBack {
        /// E of the step.
        energy: f64,
        /// The largest P.
        needed: f64,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GuardNotReached([low, high]) => {
                write!(f, "the guard is reached at no phase from {low} to {high}: the step cannot end")
            }
            Self::NoPosture(phase, why) => write!(f, "at the phase {phase:.6}: {why}"),
            Self::NotFinite(phase) => write!(f, "at the phase {phase:.6} the zero dynamics have no value"),
            Self::NotOnTheGround(height) => {
                write!(f, "where the guard is reached the foot that lands is {height:.6} m above the ground")
            }
            Self::NoSteadyStart => f.write_str("the phase at which steps begin does not settle"),
            Self::NoPhaseLeft([start, end]) => {
                write!(f, "the step would begin at the phase {start:.6} and end at {end:.6}: none is left")
            }
            Self::OutputsJump(jump) => {
                write!(
                    f,
                    "after the impact the outputs miss what is wanted by {jump:.6}; impact_matching = true takes it up"
                )
            }
            Self::TurnsBack(eta) => {
                write!(f, "at the impact the phase variable turns back: its speed is multiplied by {eta:.6}")
            }
            Self::Singular(phase) => {
                write!(
                    f,
                    "at the phase {phase:.6} the phase variable does not grow with the angular momentum"
                )
            }
            Self::FallsBack { energy, needed } => write!(
                f,
                "the robot falls back before its dead centre: its energy is {energy:.6} (kg m²/s)², the dead centre needs {needed:.6}"
            ),
        }
    }
}

/// What comes of a step; what does not exist is `None`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Step {
    /// φ̇_m of the next step, per s.
    pub next_speed: Option<f64>,
    /// δ of the impact between the steps (6.15, corrected).
    pub delta: Option<f64>,
    /// P₋ of the next step, (kg m²/s)².
    pub p_minus: Option<f64>,
    /// The largest P of the next step.
    pub p_max: Option<f64>,
    /// Where it is largest.
    pub phi_m: Option<f64>,
    /// φ̇_m after many steps with the parameters of the next (6.17).
    pub limit_speed: Option<f64>,
    /// The next step passes its dead centre (6.13).
    pub feasible: bool,
    /// Why it does not.
    pub reason: Option<String>,
    /// Of the next step and the impact before it.
    pub margins: Margins,
    /// φ₊ of the next step.
    pub phi_start: Option<f64>,
    /// φ₋ of the next step.
    pub phi_end: Option<f64>,
    /// η of the impact (6.15).
    pub eta: Option<f64>,
    /// The step before: that with the speed that was given.
    pub this_step: ThisStep,
    /// E of the step before.
    pub energy: Option<f64>,
    /// E of the next step (6.15).
    pub next_energy: Option<f64>,
    /// Bound of the error of the next step's P, by the quadrature.
    pub p_error: Option<f64>,
}

/// The energy of the step before.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ThisStep {
    /// P₋, (kg m²/s)².
    pub p_minus: Option<f64>,
    /// The largest P.
    pub p_max: Option<f64>,
    /// Where it is largest.
    pub phi_m: Option<f64>,
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

impl GaitModel<'_> {
    /// The step with parameters `to` after one with parameters `from` that passed its dead centre with `speed`, per s.
    ///
    /// The step before is one among its own kind: h_p is that of `from` after `from`.
    pub fn step(&self, from: &[f64], to: &[f64], speed: f64) -> Step {
        let mut step = Step::default();
        let mut refusals = Vec::new();
        let now = noted(self.steady_course(from), &mut refusals);
        if let Some(now) = &now {
            let [p_minus, p_max, phi_m] = [now.p_minus, now.p_max, now.dead_centre].map(finite);
            step.this_step = ThisStep { p_minus, p_max, phi_m };
            refusals.extend(now.singular().map(Refusal::Singular));
        }
        let landing = match &now {
            Some(now) => Some(now.landing.clone()),
            None => self.steady_landing(from).ok(),
        };
        step.energy = now.as_ref().and_then(|now| finite(now.energy(speed)));
        let next = landing.as_ref().and_then(|landing| {
            (step.delta, step.eta) = (finite(landing.delta), finite(landing.eta));
            if !(landing.eta > 0.0 && landing.momentum_after > 0.0) {
                refusals.push(Refusal::TurnsBack(landing.eta));
            }
            noted(self.course(to, landing), &mut refusals)
        });
        if let Some(next) = &next {
            step.describe(next);
            refusals.extend(next.singular().map(Refusal::Singular));
        }
        if let (Some(now), Some(landing)) = (&now, &landing) {
            self.pass(&mut step, (now, landing), next.as_ref(), &mut refusals);
        }
        step.limit_speed = self.limit(to);
        step.feasible = refusals.is_empty();
        if !step.feasible {
            step.next_speed = None;
        }
        step.reason = refusals.first().map(ToString::to_string);
        step
    }

    /// E[k+1] = δ (E[k] − P₋[k]) and what the next step makes of it.
    fn pass(
        &self,
        step: &mut Step,
        (now, landing): (&Course<'_, '_>, &Landing),
        next: Option<&Course<'_, '_>>,
        refusals: &mut Vec<Refusal>,
    ) {
        let Some(energy) = step.energy else { return };
        let kinetic = energy - now.p_minus;
        let next_energy = landing.delta * kinetic;
        step.next_energy = finite(next_energy);
        let Some(next) = next else { return };
        step.next_speed = next.speed(next_energy);
        let passes = step.next_speed.is_some();
        if !passes {
            refusals.push(Refusal::FallsBack { energy: next_energy, needed: next.p_max });
        }
        step.margins = self.margins(next, passes.then_some(next_energy));
        let impact_speed = (2.0 * kinetic).sqrt() / landing.momentum_before;
        self.impact_margins(landing, impact_speed, &mut step.margins);
    }

    /// φ̇_m after many steps with these parameters: E∞ = P₋ δ/(δ − 1) (6.17).
    fn limit(&self, parameters: &[f64]) -> Option<f64> {
        let course = self.steady_course(parameters).ok()?;
        let Landing { delta, eta, momentum_after, .. } = course.landing;
        if !(delta < 1.0 && eta > 0.0 && momentum_after > 0.0) || course.singular().is_some() {
            return None;
        }
        course.speed(course.p_minus * delta / (delta - 1.0))
    }
}

impl Step {
    fn describe(&mut self, next: &Course<'_, '_>) {
        let [start, end] = next.ends();
        self.p_minus = finite(next.p_minus);
        self.p_max = finite(next.p_max);
        self.phi_m = finite(next.dead_centre);
        (self.phi_start, self.phi_end) = (finite(start), finite(end));
        self.p_error = finite(next.potential_error());
    }
}

fn noted<T>(found: Result<T, Refusal>, refusals: &mut Vec<Refusal>) -> Option<T> {
    found.map_err(|why| refusals.push(why)).ok()
}
