//! Cycles: walking that repeats itself, and what it costs (6.17).
use super::course::Course;
use super::functions::GaitModel;
use super::integral::Integral;
use super::landing::Landing;
use super::step::Refusal;
use super::surface::SurfacePoint;
use super::workers::{Watch, in_parallel};
use bipedc_runtime::model::{Argument, State};
use serde::Serialize;
use std::fmt;

/// Error of integrals over a cycle, as a part of them: power has kinks where a joint changes from driving to braking.
const RELATIVE: f64 = 1e-8;

/// Walking with the same parameters in every step, on the zero dynamics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cycle {
    /// φ̇_m of every step, per s.
    pub speed: f64,
    /// δ: what is left of a small deviation of the speed after a step.
    pub multiplier: f64,
    /// Of a step, s.
    pub duration: f64,
    /// Distance of the feet, m.
    pub step_length: f64,
    /// Mean speed forward, m/s.
    pub walking_speed: f64,
    /// Mechanical work of all joints in a step, driving and braking both counted as positive, J.
    pub work: f64,
    /// Driving less braking, J: what the impact takes.
    pub net_work: f64,
    /// `work` over weight and distance, 1.
    pub cost_of_transport: f64,
    /// E of every step: E∞ of one phase (6.17), (kg m²/s)²; φ̇₊²/2 of several, (unit of φ/s)².
    pub energy: f64,
    /// Smallest K at mid-stance with which a step of this kind is made and keeps what is assumed (feet push and do not slip, torques stay
    /// within the efforts): σ²/2 of one phase, φ̇²/2 of several, units as of `energy`; none: with no K.
    pub k_min: Option<f64>,
    /// The largest one; none also where no limit was found.
    pub k_max: Option<f64>,
    /// Slowest and fastest mid-stance from which steps come back to the cycle and keep all of that, per s; none: not even the cycle keeps it,
    /// or there is no limit to the fastest.
    pub basin: [Option<f64>; 2],
}

/// Why there is no cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoCycle {
    /// A step is not made at any speed.
    NoStep(Refusal),
    /// δ is not below 1: every step gains more than it had.
    Diverges(f64),
    /// Steps become slower until one falls back.
    Falls,
}

impl fmt::Display for NoCycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStep(why) => write!(f, "{why}"),
            Self::Diverges(delta) => write!(f, "deviations grow: the multiplier is {delta:.6}"),
            Self::Falls => f.write_str("each step is slower than the one before, until one falls back"),
        }
    }
}

impl GaitModel<'_> {
    /// The cycle of these parameters.
    ///
    /// # Errors
    /// Why there is none.
    pub fn cycle(&self, parameters: &[f64]) -> Result<Cycle, NoCycle> {
        let course = self.steady_course(parameters).map_err(NoCycle::NoStep)?;
        if let Some(phase) = course.singular() {
            return Err(NoCycle::NoStep(Refusal::Singular(phase)));
        }
        let Landing { delta, eta, momentum_after, .. } = course.landing;
        if !(eta > 0.0 && momentum_after > 0.0) {
            return Err(NoCycle::NoStep(Refusal::TurnsBack(eta)));
        }
        if delta.is_nan() || delta >= 1.0 {
            return Err(NoCycle::Diverges(delta));
        }
        let energy = course.steady_energy();
        let speed = course.speed(energy).ok_or(NoCycle::Falls)?;
        self.described(&course, energy, speed).map_err(NoCycle::NoStep)
    }

    /// Cycles of many parameters, in their order, on all processors; as many as were done when `watch` asked for an end.
    pub fn cycles(&self, all: &[Vec<f64>], watch: &Watch<'_>) -> Vec<Result<Cycle, NoCycle>> {
        let mut found = in_parallel(all.len(), watch, |job| self.cycle(&all[job]));
        found.sort_by_key(|(job, _)| *job);
        // What was done behind a gap has no place.
        found
            .into_iter()
            .enumerate()
            .take_while(|(k, (job, _))| k == job)
            .map(|(_, (_, cycle))| cycle)
            .collect()
    }

    fn described(&self, course: &Course<'_, '_>, energy: f64, speed: f64) -> Result<Cycle, Refusal> {
        let duration = Integral::within(course.ends(), RELATIVE, |places| {
            let mut values = *places;
            for value in &mut values {
                *value = 1.0 / course.rates(*value, energy)?[0];
            }
            Ok::<_, Refusal>(values)
        })?;
        // dt = dφ/φ̇ and joint velocities are T′ φ̇: power over time is τ T′ over φ.
        let power = |phase: f64, count: fn(f64) -> f64| -> Result<f64, Refusal> {
            let point = course.surface(phase)?;
            let efforts = self.efforts(course, phase, energy).ok_or(Refusal::NotFinite(phase))?;
            Ok(efforts.iter().zip(&point.slope).skip(3).map(|(torque, slope)| count(torque * slope)).sum())
        };
        let over = |count: fn(f64) -> f64| {
            Integral::within(course.ends(), RELATIVE, |places| {
                let mut values = *places;
                for value in &mut values {
                    *value = power(*value, count)?;
                }
                Ok::<_, Refusal>(values)
            })
        };
        let range = self.kinetic_range(course, &course.landing);
        let start = course.surface(course.start)?;
        let step_length = course.landing.before.q[0] - start.q[0];
        let (duration, work) = (duration.whole(), over(f64::abs)?.whole());
        Ok(Cycle {
            speed,
            multiplier: course.landing.delta,
            duration,
            step_length,
            walking_speed: step_length / duration,
            work,
            net_work: over(|power| power)?.whole(),
            cost_of_transport: work / (self.weight(&start) * step_length),
            energy,
            k_min: range.map(|[low, _]| low),
            k_max: range.map(|[_, high]| high).filter(|high| high.is_finite()),
            basin: range.map_or([None; 2], |range| basin(range, energy - course.p_max, course.alpha_m)),
        })
    }

    /// M g, N: what holds the robot at rest.
    pub(super) fn weight(&self, point: &SurfacePoint) -> f64 {
        let rest = vec![0.0; self.size()];
        let state =
            State::new().with(Argument::Q, &point.q).with(Argument::V, &rest).with(Argument::A, &rest);
        self.call(self.functions.inverse_dynamics, &state).get(1).copied().unwrap_or(f64::NAN)
    }
}

/// Speeds at mid-stance from which steps come back to one with K at mid-stance, all of them within a range. E[k+1] = δ (E[k] − P₋) with δ < 1 goes to E∞
/// from either side without passing it, so that all further energies lie between the first one and E∞.
fn basin([low, high]: [f64; 2], cycle: f64, alpha_m: f64) -> [Option<f64>; 2] {
    if !(low..=high).contains(&cycle) {
        return [None; 2];
    }
    [low, high].map(|k| Some((2.0 * k).sqrt() / alpha_m).filter(|speed| speed.is_finite()))
}
