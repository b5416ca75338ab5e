//! Energies at which a part of a step keeps what is assumed of it.
//!
//! Along a step forces and torques are affine in φ̇² = 2 (E − P(φ))/α² (6.6, 6.12): each limit at each phase bounds E from one side.
use super::course::Course;
use super::functions::GaitModel;
use super::landing::Landing;
use super::reason::{Assumptions, beyond};
use super::step::Refusal;
use bipedc_runtime::model::{Argument, State};

/// Intervals of the phase at whose ends limits are asked for, where many steps are tried while walking.
pub(super) const COARSE: usize = 16;
/// The same where one step is described, or a plan is made.
const FINE: usize = 48;
/// And near both ends, in parts of that: what an impact or h_p leaves of torques and forces may last for milliseconds.
const NEAR_ENDS: [f64; 4] = [0.0625, 0.125, 0.25, 0.5];
/// Part of the phase after a beginning and before an end in which the foot in the air may be near the ground.
const NEAR: f64 = 0.1;

/// What is to be kept, and how far from its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kept {
    /// Which limits.
    pub assumptions: Assumptions,
    /// Coulomb's coefficient; without one there is no limit of friction.
    pub friction: Option<f64>,
    /// Part of each limit that is left over: of the coefficient of friction, of the efforts, of the weight as a force that pushes, of the speeds.
    pub reserve: f64,
    /// Part of half the way between its stops that a joint stays off both.
    pub off_stops: f64,
}

/// Energies between which everything is kept.
pub(super) type Between = [f64; 2];

/// Any energy.
pub(super) const ANY: Between = [f64::NEG_INFINITY, f64::INFINITY];

/// The ends of a part of a step, and whether it begins and ends in the air's way: with a foot on the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// φ at both ends.
    pub ends: [f64; 2],
    /// A foot leaves the ground at the beginning.
    pub lifts: bool,
    /// A foot lands at the end.
    pub lands: bool,
    /// Intervals at whose ends limits are asked for.
    pub parts: usize,
}

impl Kept {
    /// Whether an energy is one with which everything is kept.
    pub(super) fn allows([low, high]: Between, energy: f64) -> bool {
        (low..=high).contains(&energy)
    }
}

/// No energy.
pub(super) const NEVER: Between = [f64::INFINITY, f64::NEG_INFINITY];

impl GaitModel<'_> {
    /// Limits without a reserve, with the gait's coefficient of friction.
    pub fn keeping(&self, assumptions: Assumptions) -> Kept {
        Kept { assumptions, friction: self.settings.friction, reserve: 0.0, off_stops: 0.0 }
    }

    /// What is assumed of a walk that does not say it: feet push and, where a coefficient is known, do not slip; torques stay within the
    /// efforts of the URDF, joints off their stops. Feet may scuff, as those of the thesis' robots do.
    pub(super) fn usually_kept(&self) -> Kept {
        self.keeping(Assumptions {
            friction: self.settings.friction.is_some(),
            pull: true,
            clearance: false,
            torque: true,
            joints: true,
            velocity: false,
        })
    }

    /// Energies E of a whole step after a landing with which everything is kept, the impact included; infinite where there is no limit, none where
    /// nothing is kept.
    pub(super) fn keeps(&self, course: &Course<'_, '_>, after: &Landing, kept: &Kept) -> Between {
        if !kept.assumptions.any() {
            return ANY;
        }
        if !self.impact_keeps(after, kept) {
            return NEVER;
        }
        let part = Part { ends: course.ends(), lifts: true, lands: true, parts: FINE };
        self.between(course, part, kept).ok().flatten().unwrap_or(NEVER)
    }

    /// K = σ²/2 at the dead centre between which a step after a landing passes it and keeps what is usually assumed, (kg m²/s)²; the upper one is
    /// infinite where there is no limit, `None`: with none.
    pub(super) fn kinetic_range(&self, course: &Course<'_, '_>, after: &Landing) -> Option<[f64; 2]> {
        let [low, high] = self.keeps(course, after, &self.usually_kept());
        let range = [(low - course.p_max).max(0.0), high - course.p_max];
        (range[0] < range[1]).then_some(range)
    }

    /// Energies E of a course with which a part of it keeps everything; `None`: with none.
    ///
    /// # Errors
    /// There is no posture at a phase.
    pub(super) fn between(
        &self,
        course: &Course<'_, '_>,
        part: Part,
        kept: &Kept,
    ) -> Result<Option<Between>, Refusal> {
        let Assumptions { clearance, joints, .. } = kept.assumptions;
        if !kept.assumptions.any() {
            return Ok(Some(ANY));
        }
        let [start, end] = part.ends;
        let parts = part.parts;
        let width = (end - start) / parts as f64;
        let mut phases: Vec<f64> =
            (0..=parts).map(|k| start + (end - start) * k as f64 / parts as f64).collect();
        if parts == FINE {
            phases.extend(NEAR_ENDS.iter().flat_map(|part| [start + part * width, end - part * width]));
        }
        let dynamics = course.zero_dynamics_at(&phases)?;
        let mut potential = accumulated(course.potential(start)?, &dynamics[..=parts], width);
        for (place, part) in NEAR_ENDS.iter().enumerate().filter(|_| parts == FINE) {
            // P′ = α γ, by the trapezoidal rule from the end nearby.
            let rate = |k: usize| dynamics[k][0] * dynamics[k][2];
            let [first, last] = [0, 1].map(|side| parts + 1 + 2 * place + side);
            potential.push(potential[0] + 0.5 * part * width * (rate(0) + rate(first)));
            potential.push(potential[parts] - 0.5 * part * width * (rate(parts) + rate(last)));
        }
        let weight = self.weight(&course.surface(start)?);
        let mut between = ANY;
        for ((&phase, zero), potential) in phases.iter().zip(&dynamics).zip(potential) {
            let forces = self.forces(course, phase, *zero)?;
            // φ̇² = 2 (E − P)/α².
            let per_energy = 2.0 / (zero[0] * zero[0]);
            let speeds =
                if kept.assumptions.velocity { self.spare_speeds(course, phase, kept)? } else { Vec::new() };
            for [constant, slope] in self.spare(&forces, weight, kept).into_iter().chain(speeds) {
                bound(&mut between, constant - slope * per_energy * potential, slope * per_energy);
            }
        }
        if (clearance && self.scuffs(course, part)?) || (joints && self.stops(course, &phases, kept)?) {
            return Ok(None);
        }
        Ok(Some(between).filter(|[low, high]| low < high))
    }

    /// Force on the foot that stands and torques of the joints, at φ̇² = 0 and their slope along φ̇².
    fn forces(
        &self,
        course: &Course<'_, '_>,
        phase: f64,
        [alpha, beta, gamma]: [f64; 3],
    ) -> Result<[Vec<f64>; 2], Refusal> {
        let point = course.surface(phase)?;
        let arguments = course.arguments(phase);
        let state = State::new().with(Argument::Q, &point.q);
        let jacobian = self.call(self.functions.jacobian, &state.with(Argument::Parameters, &arguments));
        let at = |squared: f64| {
            // (6.6)
            let acceleration = -(beta * squared + gamma) / alpha;
            let v: Vec<f64> = point.slope.iter().map(|x| x * squared.sqrt()).collect();
            let bent = point.curvature.iter().map(|x| x * squared);
            let a: Vec<f64> = bent.zip(&point.slope).map(|(x, slope)| x + slope * acceleration).collect();
            let state = State::new().with(Argument::Q, &point.q).with(Argument::V, &v).with(Argument::A, &a);
            let mut found = self.call(self.functions.inverse_dynamics, &state);
            let (x, z) = (found[0], found[1]);
            // The force acts on the foot: what it does to the joints in between is not theirs to give.
            for (torque, foot) in found.iter_mut().zip(jacobian.chunks(self.size())).skip(3) {
                *torque -= foot[0] * x + foot[1] * z;
            }
            found
        };
        let rest = at(0.0);
        let slope = at(1.0).iter().zip(&rest).map(|(moving, rest)| moving - rest).collect();
        Ok([rest, slope])
    }

    /// What is left of each limit, as a constant and a slope along φ̇²: not below zero where it is kept.
    fn spare(&self, [rest, slope]: &[Vec<f64>; 2], weight: f64, kept: &Kept) -> Vec<[f64; 2]> {
        let part = 1.0 - kept.reserve;
        let mut found = Vec::new();
        if kept.assumptions.pull {
            found.push([rest[1] - kept.reserve * weight, slope[1]]);
        }
        if let Some(friction) = kept.friction.filter(|_| kept.assumptions.friction) {
            let most = friction * part;
            found.extend([1.0, -1.0].map(|sign| [rest, slope].map(|of| most * of[1] + sign * of[0])));
        }
        if kept.assumptions.torque {
            for (joint, limit) in self.settings.effort_limits.iter().enumerate() {
                let Some(limit) = limit else { continue };
                let [rest, slope] = [rest[3 + joint], slope[3 + joint]];
                found.extend([1.0, -1.0].map(|sign| [limit * part + sign * rest, sign * slope]));
            }
        }
        found
    }

    /// The same of the squared velocities of the joints.
    fn spare_speeds(
        &self,
        course: &Course<'_, '_>,
        phase: f64,
        kept: &Kept,
    ) -> Result<Vec<[f64; 2]>, Refusal> {
        let slopes = course.surface(phase)?.slope;
        let limits = &self.settings.velocity_limits;
        let joints = slopes.into_iter().skip(3).zip(limits);
        let spare = |(slope, limit): (f64, &Option<f64>)| {
            limit.map(|limit| [(limit * (1.0 - kept.reserve)).powi(2), -slope * slope])
        };
        Ok(joints.filter_map(spare).collect())
    }

    /// Whether a point in the air is below the ground where it should be clear of it.
    fn scuffs(&self, course: &Course<'_, '_>, part: Part) -> Result<bool, Refusal> {
        let [start, end] = part.ends;
        let low = if part.lifts { start + NEAR * (end - start) } else { start };
        let high = if part.lands { end - NEAR * (end - start) } else { end };
        for k in 0..=part.parts {
            let point = course.surface(low + (high - low) * k as f64 / part.parts as f64)?;
            if self.lowest(&point) < 0.0 {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a joint gets to its stop, or nearer than it may.
    fn stops(&self, course: &Course<'_, '_>, phases: &[f64], kept: &Kept) -> Result<bool, Refusal> {
        for &phase in phases {
            let q = course.surface(phase)?.q;
            if beyond(self.settings.spare_joint(&q)) || beyond(self.settings.spare_part(&q) - kept.off_stops)
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// How far joints may be asked to stay off their stops, at most `reserve`: nine tenths of what steps after their own kind leave with these parameters. Where
    /// the ground is lower than it should be, steps go on beyond their end, towards a stop.
    pub(super) fn off_stops(&self, parameters: &[f64], reserve: f64) -> f64 {
        let Ok(course) = self.steady_course(parameters) else { return 0.0 };
        let [start, end] = course.ends();
        let at = |k: usize| course.surface(start + (end - start) * k as f64 / FINE as f64);
        let spare = |k: usize| at(k).map_or(0.0, |point| self.settings.spare_part(&point.q));
        reserve.min(0.9 * (0..=FINE).map(spare).fold(f64::INFINITY, f64::min)).max(0.0)
    }

    /// Whether an impact keeps what is assumed, at whatever speed: its impulses grow with φ̇₋.
    pub(super) fn impact_keeps(&self, landing: &Landing, kept: &Kept) -> bool {
        let Assumptions { friction, pull, .. } = kept.assumptions;
        let [tangential, normal] = landing.impulse;
        let pushes = normal > 0.0;
        let comes_off = landing.lift_off > 0.0;
        let most = kept.friction.map(|friction| friction * (1.0 - kept.reserve));
        let holds = most.is_none_or(|most| pushes && tangential.abs() <= most * normal);
        (!pull || (pushes && comes_off)) && (!friction || holds)
    }
}

/// E for which `constant + slope E` is not below zero.
fn bound([low, high]: &mut Between, constant: f64, slope: f64) {
    let place = -constant / slope;
    match () {
        () if slope > 0.0 => *low = low.max(place),
        () if slope < 0.0 => *high = high.min(place),
        // Neither: kept always or never. What is no number is never kept.
        () if constant >= 0.0 => {}
        () => (*low, *high) = (f64::INFINITY, f64::NEG_INFINITY),
    }
}

/// P at equally distant phases from α γ there: cubics through four places.
fn accumulated(start: f64, dynamics: &[[f64; 3]], step: f64) -> Vec<f64> {
    let slope: Vec<f64> = dynamics.iter().map(|[alpha, _, gamma]| alpha * gamma).collect();
    let last = slope.len() - 1;
    let mut found = vec![start];
    for k in 0..last {
        let of = |weights: [f64; 4], first: usize| -> f64 {
            weights.iter().zip(&slope[first..first + 4]).map(|(w, f)| w * f).sum()
        };
        let sum = match k {
            0 => of([9.0, 19.0, -5.0, 1.0], 0),
            _ if k + 1 == last => of([1.0, -5.0, 19.0, 9.0], last - 3),
            _ => of([-1.0, 13.0, 13.0, -1.0], k - 1),
        };
        found.push(found[k] + step / 24.0 * sum);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_potential_is_accumulated_exactly_for_cubics() {
        let at = |k: usize| 0.3 + 0.1 * k as f64;
        let dynamics: Vec<[f64; 3]> = (0..9).map(|k| [1.0, 0.0, at(k).powi(3) - 2.0 * at(k)]).collect();
        let primitive = |x: f64| 0.25 * x.powi(4) - x * x;
        let found = accumulated(primitive(at(0)), &dynamics, 0.1);
        assert!(found.iter().enumerate().all(|(k, p)| (p - primitive(at(k))).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn limits_bound_the_energy_from_both_sides() {
        let mut between = ANY;
        bound(&mut between, -2.0, 1.0);
        bound(&mut between, 6.0, -2.0);
        bound(&mut between, 0.5, 0.0);
        assert_eq!(between, [2.0, 3.0]);
        bound(&mut between, f64::NAN, 0.0);
        assert!(between[0] > between[1]);
    }
}
