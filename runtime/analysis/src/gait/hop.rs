//! From mid-stance to mid-stance with other parameters from the first mid-stance on.
//!
//! At mid-stance of a step the robot takes the parameters of the next one: h_p takes up what the new constraints leave of the old ones
//! there, as after an impact, so that the foot already lands where the next step wants it. After the impact the step is one after
//! its own kind. What it leaves is therefore its parameters and K at its dead centre, and K[k+1] is affine in K[k].
use super::course::{Beginning, Course};
use super::functions::GaitModel;
use super::kept::{ANY, Between, COARSE, Kept, NEVER, Part};
use super::landing::Landing;
use super::step::Refusal;

/// A step after its own kind, up to its dead centre.
#[derive(Debug, Clone)]
pub(super) struct Half {
    pub parameters: Vec<f64>,
    /// How steps of this kind end.
    pub landing: Landing,
    /// P at the dead centre.
    pub p_max: f64,
    /// α there.
    pub alpha_m: f64,
    /// φ there.
    pub phase: f64,
    /// q and q̇ per φ̇ there.
    pub state: [Vec<f64>; 2],
    /// E with which everything is kept, the impact before it included; `None`: with none.
    pub kept: Option<Between>,
}

/// K = σ²/2 at the dead centre of the next step, for any K at that of the present one (6.15, 6.19).
#[derive(Debug, Clone, Copy)]
pub(super) struct Hop {
    /// δ of the impact in between.
    pub delta: f64,
    /// K that is lost after the impact's part: K[k+1] = δ K[k] − loss.
    pub loss: f64,
    /// K[k] above which the present step comes to its end.
    pub needs: f64,
    /// K[k] with which everything is kept.
    pub kept: Between,
    /// α at the next dead centre.
    pub alpha_m: f64,
}

impl Hop {
    /// K at the next dead centre; negative: what it lacks to get there.
    pub fn next(&self, k: f64) -> Option<f64> {
        (k > self.needs).then_some(self.delta * k - self.loss)
    }

    /// Whether everything is kept.
    pub fn keeps(&self, k: f64) -> bool {
        let [low, high] = self.kept;
        k > self.needs && (low..=high).contains(&k)
    }

    /// K at the next dead centre with this φ̇.
    pub fn of_speed(&self, speed: f64) -> f64 {
        0.5 * (self.alpha_m * speed).powi(2)
    }

    /// φ̇ at the next dead centre; negative where the step falls back.
    pub fn speed(&self, k: f64) -> f64 {
        (2.0 * k.abs()).sqrt().copysign(k) / self.alpha_m
    }
}

/// A state at mid-stance.
#[derive(Debug, Clone, Copy)]
pub(super) struct MidStance<'q> {
    pub q: &'q [f64],
    /// q̇ in the unit in which `rate` is φ̇.
    pub v: &'q [f64],
    pub phase: f64,
    pub rate: f64,
}

impl Half {
    pub fn mid_stance(&self) -> MidStance<'_> {
        MidStance { q: &self.state[0], v: &self.state[1], phase: self.phase, rate: 1.0 }
    }
}

fn forward(course: &Course<'_, '_>) -> Result<(), Refusal> {
    let Landing { eta, momentum_after, .. } = course.landing;
    match course.singular() {
        Some(phase) => Err(Refusal::Singular(phase)),
        None if !(eta > 0.0 && momentum_after > 0.0) => Err(Refusal::TurnsBack(eta)),
        None => Ok(()),
    }
}

impl GaitModel<'_> {
    /// The first half of a step after its own kind.
    ///
    /// # Errors
    /// There is no such step.
    pub(super) fn half(&self, parameters: &[f64], kept: &Kept) -> Result<Half, Refusal> {
        let course = self.steady_course(parameters)?;
        forward(&course)?;
        let point = course.surface(course.dead_centre)?;
        let part =
            Part { ends: [course.start, course.dead_centre], lifts: true, lands: false, parts: COARSE };
        let lands = self.impact_keeps(&course.landing, kept);
        // A dead centre where the step begins leaves no way to it.
        let kept = match lands {
            true if part.ends[0] < part.ends[1] => self.between(&course, part, kept)?,
            true => Some(ANY),
            false => None,
        };
        Ok(Half {
            parameters: parameters.to_vec(),
            p_max: course.p_max,
            alpha_m: course.alpha_m,
            phase: course.dead_centre,
            state: [point.q, point.slope],
            kept,
            landing: course.landing,
        })
    }

    /// The way from a mid-stance on with the parameters of another step to mid-stance of that one.
    ///
    /// # Errors
    /// There is no such way.
    pub(super) fn hop(&self, from: MidStance<'_>, to: &Half, kept: &Kept) -> Result<Hop, Refusal> {
        let MidStance { q, v, phase, rate } = from;
        let course =
            self.course_to(&to.parameters, Beginning { q, v, start: phase, rate }, to.landing.clone())?;
        forward(&course)?;
        let delta = to.landing.delta;
        let part = Part { ends: course.ends(), lifts: false, lands: true, parts: COARSE };
        let kept = match to.kept {
            None => NEVER,
            Some([low, high]) => {
                let rest = self.between(&course, part, kept)?.unwrap_or(NEVER);
                // E of the next step is δ (K − P₋).
                let next = [low, high].map(|energy| energy / delta + course.p_minus);
                [rest[0].max(next[0]), rest[1].min(next[1])]
            }
        };
        Ok(Hop {
            delta,
            loss: delta * course.p_minus + to.p_max,
            needs: course.p_max,
            kept,
            alpha_m: to.alpha_m,
        })
    }
}
