//! The end of a step: the phase at which it ends, the impact, and the angular momentum that it leaves (4.20–4.22, 6.15).
use super::functions::GaitModel;
use super::search::zero;
use super::step::Refusal;
use super::surface::SurfacePoint;
use super::wide::LANES;
use bipedc_runtime::model::{Argument, State};

/// Places at which a guard's sign is asked for.
const SAMPLES: usize = 64;
/// How far from the ground a foot may be that lands, m.
const LEVEL: f64 = 1e-6;
/// Places at which the sign of α is asked for.
const SIGNS: usize = 9;
/// Rounds after which φ₊ must have settled.
const ROUNDS: usize = 20;

/// The end of a step and the beginning of the next, at unit speed φ̇₋ = 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Landing {
    /// Those of the step that ends.
    pub parameters: Vec<f64>,
    /// φ₋.
    pub end: f64,
    /// The configuration just before.
    pub before: SurfacePoint,
    /// Angular momentum about the foot that stood, per φ̇₋: α(φ₋), kg m².
    pub momentum_before: f64,
    /// q₊, legs relabelled.
    pub q: Vec<f64>,
    /// q̇₊ per φ̇₋, legs relabelled.
    pub v: Vec<f64>,
    /// φ₊ of the next step.
    pub start: f64,
    /// η = φ̇₊/φ̇₋ (6.15).
    pub eta: f64,
    /// Angular momentum about the foot that stands now, per φ̇₋.
    pub momentum_after: f64,
    /// δ = (σ₊/σ₋)² (6.15, corrected: η² (α₊/α₋)²).
    pub delta: f64,
    /// Tangential and normal impulse on the foot that lands, per φ̇₋, N s.
    pub impulse: [f64; 2],
    /// Vertical velocity of the foot that is let go, per φ̇₋, m/s.
    pub lift_off: f64,
}

impl GaitModel<'_> {
    /// The end of a step that begins at φ₊ = `start`.
    pub(super) fn landing(&self, parameters: &[f64], start: f64) -> Result<Landing, Refusal> {
        let end = self.end(parameters, start)?;
        let before = self.at_end(parameters, start, end).map_err(|why| Refusal::NoPosture(end, why))?;
        let height = self.heights(&before.q).get(self.settings.points[1]).copied().unwrap_or(f64::NAN);
        // What is no number is no height.
        if !height.is_finite() || height.abs() > LEVEL {
            return Err(Refusal::NotOnTheGround(height));
        }
        let momentum_before = self.zero_dynamics(&before.q, &before.slope, &before.curvature)[0];
        let state = State::new().with(Argument::Q, &before.q).with(Argument::V, &before.slope);
        let after = self.call(self.functions.impact_map, &state);
        let (velocity, impulse) = after.split_at(self.size().min(after.len()));
        let q =
            self.call(self.functions.relabelled_configuration, &State::new().with(Argument::Q, &before.q));
        let v = self.call(self.functions.relabelled_velocity, &State::new().with(Argument::V, velocity));
        let [start, eta] = self.controlled(&q, &v).first().copied().unwrap_or([f64::NAN; 2]);
        let momentum_after = self.zero_dynamics(&q, &v, &v)[0];
        let directions = self.call(self.functions.normals, &State::new().with(Argument::Q, &before.q));
        let first = self.settings.points[0] * self.size();
        let lift_off = directions.iter().skip(first).zip(velocity).map(|(w, v)| w * v).sum();
        Ok(Landing {
            parameters: parameters.to_vec(),
            end,
            momentum_before,
            start,
            eta,
            momentum_after,
            delta: (momentum_after / momentum_before).powi(2),
            impulse: [impulse.first(), impulse.last()].map(|x| x.copied().unwrap_or(f64::NAN)),
            lift_off,
            before,
            q,
            v,
        })
    }

    /// The landing of a step that follows one with the same parameters.
    pub(super) fn steady_landing(&self, parameters: &[f64]) -> Result<Landing, Refusal> {
        // Formulas may speak of φ₊, which is where this landing leads to: below any end at first.
        let [low, high] = self.settings.between;
        let mut start = 2.0 * low - high;
        for _ in 0..ROUNDS {
            let landing = self.landing(parameters, start)?;
            if !self.settings.depends_on_start
                || (landing.start - start).abs()
                    <= 4.0 * f64::EPSILON * landing.start.abs().max(landing.end.abs())
            {
                return Ok(landing);
            }
            start = landing.start;
        }
        Err(Refusal::NoSteadyStart)
    }

    /// φ and α (kg m² per unit of φ) where steps may end, if α is negative wherever there is a posture: φ falls while the robot goes forward.
    pub fn falling_phase(&self, parameters: &[f64]) -> Option<[f64; 2]> {
        let [low, high] = self.settings.between;
        let places = (0..SIGNS).map(|k| low + (high - low) * k as f64 / (SIGNS - 1) as f64);
        let momentum = |phase: f64| {
            let point = self.at_end(parameters, 2.0 * low - high, phase).ok()?;
            let [alpha, ..] = self.zero_dynamics(&point.q, &point.slope, &point.curvature);
            alpha.is_finite().then_some([phase, alpha])
        };
        let found: Vec<[f64; 2]> = places.filter_map(momentum).collect();
        found.iter().all(|[_, alpha]| *alpha < 0.0).then(|| found.first().copied()).flatten()
    }

    /// φ₋: the first place where the guard vanishes; h_p does there too.
    fn end(&self, parameters: &[f64], start: f64) -> Result<f64, Refusal> {
        let guard = |phase: f64| self.guard(parameters, start, phase);
        let arguments = self.arguments(parameters, [start, start]);
        let [low, high] = self.settings.between;
        let place = |k: usize| low + (high - low) * k.min(SAMPLES) as f64 / SAMPLES as f64;
        let mut last: Option<(f64, f64)> = None;
        for first in (0..=SAMPLES).step_by(LANES) {
            let phases: [f64; LANES] = std::array::from_fn(|k| place(first + k));
            let wide = self.wide_guard(&arguments, phases);
            for k in 0..LANES.min(SAMPLES + 1 - first) {
                let phase = phases[k];
                let value = wide.map_or_else(|| guard(phase), |wide| Some(wide[k]).filter(|x| x.is_finite()));
                let Some(value) = value else {
                    last = None;
                    continue;
                };
                if value == 0.0 {
                    return Ok(phase);
                }
                if let Some(before) = last.filter(|before| (before.1 < 0.0) != (value < 0.0)) {
                    return Ok(zero(|x| guard(x).unwrap_or(f64::NAN), before, (phase, value)));
                }
                last = Some((phase, value));
            }
        }
        Err(Refusal::GuardNotReached(self.settings.between))
    }

    /// The guard of a step that ends at this phase; `None`: there is no posture, or no number.
    fn guard(&self, parameters: &[f64], start: f64, phase: f64) -> Option<f64> {
        let point = self.at_end(parameters, start, phase).ok()?;
        let arguments = self.arguments(parameters, [start, phase]);
        let state = State::new().with(Argument::Q, &point.q).with(Argument::Parameters, &arguments);
        self.call(self.functions.guard, &state).first().copied().filter(|x| x.is_finite())
    }

    /// The surface at the end of a step that ends at this phase.
    fn at_end(
        &self,
        parameters: &[f64],
        start: f64,
        end: f64,
    ) -> Result<SurfacePoint, super::surface::SurfaceFailure> {
        let mut arguments = self.arguments(parameters, [start, end]);
        arguments[0] = end;
        self.surface(&arguments, &self.settings.posture)
    }

    /// Heights of all contact points, m.
    pub(super) fn heights(&self, q: &[f64]) -> Vec<f64> {
        self.call(self.functions.heights, &State::new().with(Argument::Q, q))
    }
}
