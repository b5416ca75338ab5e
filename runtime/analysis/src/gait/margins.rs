//! How far a step is from what its assumptions allow.
use super::course::Course;
use super::functions::{GaitModel, spare_velocity};
use super::landing::Landing;
use super::search::least;
use super::surface::SurfacePoint;
use bipedc_runtime::model::{Argument, State};
use serde::Serialize;

/// Samples of a step before the worst of them is refined.
const SAMPLES: usize = 200;
/// Part of the phase at each end in which the foot in the air may be near the ground: it leaves it and comes back.
const NEAR: f64 = 0.1;

/// Margins of a step; negative: the assumption does not hold. `None`: there is no such number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Margins {
    /// Coefficient of friction less what the foot that stands needs, 1.
    pub friction: Option<f64>,
    /// Smallest normal force on the foot that stands, N.
    pub pull: Option<f64>,
    /// Distance of the zero-moment point from the edge of the foot, m; a point has none.
    pub zmp: Option<f64>,
    /// Lowest height of the points in the air, over the middle four fifths of the phase, m.
    pub clearance: Option<f64>,
    /// Smallest distance of a torque from its limit, N m.
    pub torque: Option<f64>,
    /// Smallest distance of a joint from its stops, rad or m; negative: beyond one.
    pub joint: Option<f64>,
    /// Smallest distance of a joint's speed from its limit, rad/s or m/s.
    pub velocity: Option<f64>,
    /// Coefficient of friction less what the impact at the beginning needs, 1.
    pub impact_friction: Option<f64>,
    /// Normal impulse of that impact, N s.
    pub impact_pull: Option<f64>,
    /// Upward velocity of the foot that it lets go, m/s.
    pub lift_off: Option<f64>,
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

impl GaitModel<'_> {
    /// Margins of a step with this energy after an impact; `None` for the energy: those that ask for no speed.
    pub(super) fn margins(&self, course: &Course<'_, '_>, energy: Option<f64>) -> Margins {
        let [start, end] = course.ends();
        let near = NEAR * (end - start);
        let height = |phase| course.surface(phase).map_or(f64::NAN, |point| self.lowest(&point));
        let joint =
            |phase| course.surface(phase).map_or(f64::NAN, |point| self.settings.spare_joint(&point.q));
        let mut margins = Margins {
            clearance: finite(least(height, [start + near, end - near], SAMPLES).1),
            joint: finite(least(joint, [start, end], SAMPLES).1),
            ..Margins::default()
        };
        let Some(energy) = energy else { return margins };
        let smallest = |of: fn(&Self, &[f64]) -> f64| {
            finite(
                least(
                    |phase| self.efforts(course, phase, energy).map_or(f64::NAN, |e| of(self, &e)),
                    [start, end],
                    SAMPLES,
                )
                .1,
            )
        };
        margins.pull = smallest(|_, efforts| efforts[1]);
        // Where the foot would have to pull, no coefficient is enough.
        let pushes = margins.pull.is_some_and(|force| force > 0.0);
        margins.friction =
            self.settings.friction.filter(|_| pushes).and_then(|_| smallest(Self::spare_friction));
        margins.torque = smallest(Self::spare_torque);
        if self.settings.velocity_limits.iter().any(Option::is_some) {
            let velocity = |phase| self.spare_velocity(course, phase, energy).unwrap_or(f64::NAN);
            margins.velocity = finite(least(velocity, [start, end], SAMPLES).1);
        }
        margins
    }

    /// Those of an impact at the phase velocity φ̇₋.
    pub(super) fn impact_margins(&self, landing: &Landing, speed: f64, margins: &mut Margins) {
        let [tangential, normal] = landing.impulse.map(|x| x * speed);
        margins.impact_pull = finite(normal);
        margins.impact_friction = self
            .settings
            .friction
            .filter(|_| normal > 0.0)
            .and_then(|friction| finite(friction - tangential.abs() / normal));
        margins.lift_off = finite(landing.lift_off * speed);
    }

    /// Height of the lowest point in the air, m.
    pub(super) fn lowest(&self, point: &SurfacePoint) -> f64 {
        let heights = self.heights(&point.q);
        let air = heights.iter().enumerate().filter(|(index, _)| *index != self.settings.points[0]);
        air.map(|(_, &height)| height).fold(f64::INFINITY, f64::min)
    }

    /// What the motion on the zero dynamics needs: x and z of the force on the foot that stands (N), its moment about the origin of the
    /// base (N m), then the torques of the joints. `None`: the step does not get to this phase.
    pub fn efforts(&self, course: &Course<'_, '_>, phase: f64, energy: f64) -> Option<Vec<f64>> {
        let point = course.surface(phase).ok()?;
        let [rate, acceleration] = course.rates(phase, energy).ok()?;
        let v: Vec<f64> = point.slope.iter().map(|x| x * rate).collect();
        let bent = point.curvature.iter().map(|x| x * rate * rate);
        let a: Vec<f64> = bent.zip(&point.slope).map(|(x, slope)| x + slope * acceleration).collect();
        let state = State::new().with(Argument::Q, &point.q).with(Argument::V, &v).with(Argument::A, &a);
        let mut found = self.call(self.functions.inverse_dynamics, &state);
        if found.len() != self.size() || found.len() < 3 {
            return None;
        }
        // The force acts on the foot, not on the base: what it does to the joints in between is not theirs to give.
        let arguments = course.arguments(phase);
        let jacobian = self.call(self.functions.jacobian, &state.with(Argument::Parameters, &arguments));
        let (x, z) = (found[0], found[1]);
        for (torque, foot) in found.iter_mut().zip(jacobian.chunks(self.size())).skip(3) {
            *torque -= foot[0] * x + foot[1] * z;
        }
        Some(found)
    }

    /// Smallest distance of a joint's speed from its limit, rad/s or m/s; infinite without limits.
    fn spare_velocity(&self, course: &Course<'_, '_>, phase: f64, energy: f64) -> Option<f64> {
        let [rate, _] = course.rates(phase, energy).ok()?;
        let v: Vec<f64> = course.surface(phase).ok()?.slope.iter().map(|slope| slope * rate).collect();
        Some(spare_velocity(&self.settings.velocity_limits, &v))
    }

    fn spare_friction(&self, efforts: &[f64]) -> f64 {
        self.settings.friction.unwrap_or(f64::NAN) - efforts[0].abs() / efforts[1]
    }

    fn spare_torque(&self, efforts: &[f64]) -> f64 {
        let limited = self.settings.effort_limits.iter().zip(&efforts[3..]);
        let spare = limited.filter_map(|(limit, torque)| limit.map(|limit| limit - torque.abs()));
        spare.fold(f64::INFINITY, f64::min)
    }
}
