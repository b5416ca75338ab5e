//! From the mid-stance speed of a step to that of the next (6.15–6.20).
use super::course::Course;
use super::functions::GaitModel;
use super::margins::Margins;
use super::pair::StepPair;
use super::reason::Reason;
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
                write!(f, "the step would begin at the phase {start:.6} and end at {end:.6}: none is left")?;
                // As in what `gait new` writes.
                let hint = " (a form has no curves yet; `bipedc gait optimise` finds them)";
                f.write_str(if start == end { hint } else { "" })
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
    /// The same in one word, as in maps.
    pub reason_code: Option<Reason>,
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
    /// Smallest K = σ²/2 at the dead centre with which the next step passes it and keeps what is usually assumed (feet push, do not slip where the
    /// gait has a coefficient, torques stay within the efforts), (kg m²/s)²; none: with no K.
    pub k_min: Option<f64>,
    /// The largest one; none also where nothing limits it.
    pub k_max: Option<f64>,
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
        self.pair(None, from, to).step(speed)
    }
}

impl StepPair<'_, '_> {
    /// Everything that comes of the second step where the first one passes its dead centre with `speed`, per s.
    pub fn step(&self, speed: f64) -> Step {
        let mut step = Step::default();
        if let Some(now) = &self.now {
            let [p_minus, p_max, phi_m] = [now.p_minus, now.p_max, now.dead_centre].map(finite);
            step.this_step = ThisStep { p_minus, p_max, phi_m };
            step.energy = finite(now.energy(speed));
        }
        if let Some(landing) = &self.landing {
            (step.delta, step.eta) = (finite(landing.delta), finite(landing.eta));
        }
        if let Some(next) = self.next() {
            step.describe(next);
        }
        if let (Some(next), Some(landing)) = (self.next(), &self.landing)
            && let Some([low, high]) = self.gait.kinetic_range(next, landing)
        {
            (step.k_min, step.k_max) = (finite(low), finite(high));
        }
        let passes = self.next_speed(speed);
        step.next_energy = self.next_energy(speed).and_then(finite);
        step.limit_speed = self.limit();
        step.margins = self.margins(speed);
        step.feasible = passes.is_ok();
        step.reason = passes.as_ref().err().map(ToString::to_string);
        step.reason_code = passes.as_ref().err().map(Reason::from);
        step.next_speed = passes.ok();
        step
    }

    /// φ̇_m after many steps with the parameters of the second: E∞ = P₋ δ/(δ − 1) (6.17).
    fn limit(&self) -> Option<f64> {
        if self.is_steady() {
            return self.now.as_ref()?.steady_speed();
        }
        self.gait.steady_course(&self.to).ok()?.steady_speed()
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
