//! How far a step of several phases stays from its limits, from mid-stance to mid-stance.
use super::hop::{Hop, MidStance};
use super::surface::SurfacePoint;
use super::{Chain, ChainPhase, Refused};
use crate::gait::map::no_velocity_limits;
use bipedc_analysis::gait::{Assumptions, Margins, Reason, spare_joint, spare_velocity};
use bipedc_analysis::simulate::phases::{Assumptions as Allowed, Row, RowKind};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::PhasedGait;

/// A foot that carries less than this part of the weight, of an impact's impulses, needs no friction that anybody would measure: what simulations let pass.
pub(crate) fn light() -> f64 {
    Allowed::default().light
}

/// Force (N) or impulse (N s) along the ground that a foot needs friction for, as simulations judge it: on one that carries little, what exceeds a part of the
/// weight.
fn asked([along, push]: [f64; 2], weight: f64) -> f64 {
    (along.abs() - Allowed::default().unasked(push, weight)).max(0.0)
}

/// Part of a phase at each end over which feet in the air may be near the ground.
const NEAR: f64 = 0.1;
/// What the controller holds to a limit is beyond it by rounding.
const ROUNDING: f64 = 1e-6;

impl Hop {
    /// The first assumption that a step breaks.
    pub(in crate::gait) fn violated(assume: Assumptions, margins: &Margins) -> Option<Reason> {
        let bad = |margin: Option<f64>| margin.is_some_and(|margin| margin < -ROUNDING);
        let cases = [
            (assume.pull, bad(margins.pull) || bad(margins.impact_pull), Reason::Pulls),
            (assume.friction, bad(margins.friction) || bad(margins.impact_friction), Reason::Slips),
            (assume.clearance, bad(margins.clearance), Reason::Scuffs),
            (assume.torque, bad(margins.torque), Reason::Torque),
            (assume.joints, bad(margins.joint), Reason::Stop),
            (assume.velocity, bad(margins.velocity), Reason::Velocity),
        ];
        cases.into_iter().find(|(asked, broken, _)| *asked && *broken).map(|(.., reason)| reason)
    }
}

impl Chain<'_> {
    /// The step that takes these parameters at mid-stance, and the smallest of its margins at all accepted steps of the integration, and at so many
    /// places `between` each two of them.
    pub(in crate::gait) fn hop_with_margins(
        &self,
        from: &MidStance,
        values: &[f64],
        between: usize,
    ) -> (Hop, Margins) {
        let weight = self.weight(&from.q).unwrap_or(f64::NAN);
        let swinging = (0..self.phases.len()).map(|phase| self.swinging(phase)).collect();
        let margins = Margins::default();
        let (air, refused) = (vec![Vec::new()], None);
        let mut seen = Seen { chain: self, weight, margins, swinging, air, refused, between, last: None };
        self.present.borrow_mut().impulses.clear();
        let mut hop =
            self.hop_watched(from, values, &mut |phase, time, x, begins| seen.look(phase, time, x, begins));
        seen.clearance(hop.next.is_ok());
        let Seen { mut margins, refused, .. } = seen;
        let friction = self.bench.gait.limits.friction;
        for [along, push] in self.present.borrow().impulses.iter().copied() {
            smaller(&mut margins.impact_pull, push);
            if let Some(friction) = friction.filter(|_| along.is_finite() && push > 0.0) {
                smaller(&mut margins.impact_friction, friction - along.abs() / push);
            }
        }
        if let (Some(why), true) = (refused, hop.next.is_ok()) {
            hop.next = Err(why);
        }
        (hop, margins)
    }

    /// What an impact did to its feet: along the ground and upward, N s.
    pub(super) fn note_impulses(&self, rows: &[Row], impulses: &[f64]) {
        let feet = rows.iter().map(|row| row.foot).max().map_or(0, |last| last + 1);
        let of = |foot: usize, kind: RowKind| -> Option<f64> {
            let mut own = rows.iter().zip(impulses);
            own.find(|(row, _)| row.foot == foot && row.kind == kind).map(|(_, x)| *x)
        };
        let found: Vec<[f64; 2]> = (0..feet)
            .filter_map(|foot| Some([of(foot, RowKind::ForceX)?, of(foot, RowKind::ForceZ)?]))
            .collect();
        let whole: f64 = found.iter().map(|[_, push]| push).sum();
        // A light foot has a push, and no quotient.
        let light = light();
        let judged = |[along, push]: [f64; 2]| {
            [if push < light * whole { f64::NAN } else { asked([along, push], whole) }, push]
        };
        let found = found.into_iter().map(judged);
        self.present.borrow_mut().impulses.extend(found);
    }

    /// Points of the feet in the air whose height counts in a phase: none of a foot that stands on one of its points, and none of a foot that lands after it
    /// was in the air for a phase before.
    fn swinging(&self, phase: usize) -> Vec<usize> {
        let Some(Some(of)) = self.phases.get(phase) else { return Vec::new() };
        let before = self.phases.iter().flatten().find(|before| before.spec.next == phase).unwrap_or(of);
        let feet = self.feet();
        let stands = |standing: &[usize], foot: &[usize]| foot.iter().any(|point| standing.contains(point));
        let counts = |index: usize| {
            let other = if before.spec.relabel && feet.len() == 2 { 1 - index } else { index };
            let lands = of.spec.impact.as_ref().is_some_and(|impact| stands(&impact.standing, &feet[index]));
            let flew = !stands(&before.spec.standing, &feet[other]);
            !(stands(&of.spec.standing, &feet[index]) || lands && flew)
        };
        (0..feet.len()).filter(|&index| counts(index)).flat_map(|index| feet[index].clone()).collect()
    }

    /// Contact points, foot by foot.
    fn feet(&self) -> Vec<Vec<usize>> {
        let points = &self.bench.compiled.model.tree.points;
        let foot = |point: usize| points[point].name.split('/').next();
        let mut feet: Vec<Vec<usize>> = Vec::new();
        for point in 0..points.len() {
            match feet.last_mut().filter(|known| foot(known[0]) == foot(point)) {
                Some(known) => known.push(point),
                None => feet.push(vec![point]),
            }
        }
        feet
    }

    /// Refuses assumptions that nothing is known about.
    ///
    /// # Errors
    /// The gait has no coefficient of friction; no joint has a limit.
    pub(in crate::gait) fn known(&self, assume: Assumptions) -> Result<(), Diagnostic> {
        let gait = &self.bench.gait;
        if assume.friction && gait.limits.friction.is_none() {
            let message = format!("the gait `{}` has no coefficient of friction", gait.name);
            let help = "write `friction` into its [limits], or leave out --assume friction";
            return Err(Diagnostic::error(message).help(help));
        }
        let limited = self.bench.compiled.description.joints.iter().any(|joint| joint.effort_limit.is_some());
        if assume.torque && !limited {
            let help = "write `effort` into the URDF's limits, or leave out --assume torque";
            return Err(Diagnostic::error("no joint of the robot has a limit of its torque").help(help));
        }
        let stops =
            self.bench.compiled.description.joints.iter().any(|joint| joint.position_limits.is_some());
        if assume.joints && !stops {
            let help = "write `lower` and `upper` into the URDF's limits, or leave out --assume joints";
            return Err(Diagnostic::error("no joint of the robot has stops").help(help));
        }
        if assume.velocity && self.velocity_limits.iter().all(Option::is_none) {
            return Err(no_velocity_limits());
        }
        Ok(())
    }
}

/// The smallest margins so far.
struct Seen<'c, 'b> {
    chain: &'c Chain<'b>,
    /// N
    weight: f64,
    margins: Margins,
    /// Of each phase the points of feet in the air whose height counts.
    swinging: Vec<Vec<usize>>,
    /// Phase by phase: time (s) and lowest point of a foot in the air (m).
    air: Vec<Vec<(f64, f64)>>,
    refused: Option<Refused>,
    /// Places that are looked at between two steps of the integration.
    between: usize,
    /// The last of them: time (s), φ, φ̇ and φ̈.
    last: Option<[f64; 4]>,
}

/// Hermite's cubic through values with slopes at 0 and 1.
fn cubic([a, da]: [f64; 2], [b, db]: [f64; 2], s: f64) -> f64 {
    let r = 1.0 - s;
    r * r * ((1.0 + 2.0 * s) * a + s * da) + s * s * ((1.0 + 2.0 * r) * b - r * db)
}

fn smaller(margin: &mut Option<f64>, x: f64) {
    *margin = Some(margin.map_or(x, |known| known.min(x)));
}

impl Seen<'_, '_> {
    fn look(&mut self, phase: usize, time: f64, x: [f64; 2], begins: bool) {
        if begins && self.air.last().is_some_and(|phase| !phase.is_empty()) {
            self.air.push(Vec::new());
        }
        self.last = self.last.filter(|_| !begins);
        if let Err(why) = self.measure_up_to(phase, time, x) {
            self.refused.get_or_insert(why);
        }
    }

    /// Between the last place and this one φ and φ̇ are cubics of time.
    fn measure_up_to(&mut self, phase: usize, time: f64, x: [f64; 2]) -> Result<(), Refused> {
        let acceleration = self.chain.motion(phase, x)?.acceleration;
        if let Some([begun, phi, rate, was]) = self.last.filter(|_| self.between > 0) {
            let h = time - begun;
            for k in 1..=self.between {
                let s = k as f64 / (self.between + 1) as f64;
                let x = [
                    cubic([phi, rate * h], [x[0], x[1] * h], s),
                    cubic([rate, was * h], [x[1], acceleration * h], s),
                ];
                self.measure(phase, begun + s * h, x)?;
            }
        }
        self.last = Some([time, x[0], x[1], acceleration]);
        self.measure(phase, time, x)
    }

    fn measure(&mut self, phase: usize, time: f64, x: [f64; 2]) -> Result<(), Refused> {
        let (chain, of) = (self.chain, self.chain.phase(phase)?);
        let motion = chain.motion(phase, x)?;
        self.feet(of, &motion.forces);
        {
            let present = chain.present.borrow();
            for (joint, torque) in motion.torques.iter().enumerate() {
                if let Some(limit) = PhasedGait::<f64>::effort_limit(present.controller.gait(), joint) {
                    smaller(&mut self.margins.torque, limit - torque.abs());
                }
            }
        }
        let point = chain.point(phase, x[0])?;
        self.joints(&point, x[1]);
        let heights = chain.heights(&point.q);
        let lowest = self.swinging[phase].iter().map(|&point| heights[point]).fold(f64::INFINITY, f64::min);
        if let Some(phase) = self.air.last_mut() {
            phase.push((time, lowest));
        }
        Ok(())
    }

    /// Stops and velocities of the joints at φ̇.
    fn joints(&mut self, point: &SurfacePoint, rate: f64) {
        let v: Vec<f64> = point.slope.iter().map(|slope| slope * rate).collect();
        let joint = spare_joint(&self.chain.stops, &point.q);
        let velocity = spare_velocity(&self.chain.velocity_limits, &v);
        for (margin, spare) in [(&mut self.margins.joint, joint), (&mut self.margins.velocity, velocity)] {
            if spare.is_finite() {
                smaller(margin, spare);
            }
        }
    }

    /// Friction, push and centre of pressure of what stands.
    fn feet(&mut self, of: &ChainPhase, forces: &[f64]) {
        let friction = self.chain.bench.gait.limits.friction;
        for foot in of.feet.iter().flatten() {
            let [along, push] = foot.force.map(|force| forces[force]);
            if foot.holds {
                smaller(&mut self.margins.pull, push);
            }
            if push < light() * self.weight {
                continue;
            }
            if let Some(friction) = friction {
                let along = asked([along, push], self.weight);
                smaller(&mut self.margins.friction, friction - along / push);
            }
            let Some(moment) = foot.moment else { continue };
            let pressure = -forces[moment] / push;
            for (level, inside) in
                foot.level.into_iter().zip([pressure - foot.sole[0], foot.sole[1] - pressure])
            {
                if level {
                    smaller(&mut self.margins.zmp, inside);
                }
            }
        }
    }

    /// Feet in the air count over the middle of each phase. The first one is seen from its mid-stance on, and the same phase of the next step, where it is
    /// `complete`, up to its own: both are taken for parts of one phase.
    fn clearance(&mut self, complete: bool) {
        let air = std::mem::take(&mut self.air);
        let length = |phase: &[(f64, f64)]| phase.last().zip(phase.first()).map_or(0.0, |(l, f)| l.0 - f.0);
        let after = length(air.first().map_or(&[], Vec::as_slice));
        let cut = complete && air.len() > 1;
        let before = if cut { length(&air[air.len() - 1]) } else { after };
        for (place, phase) in air.iter().enumerate() {
            let (Some(first), Some(last)) = (phase.first(), phase.last()) else { continue };
            let begins = place > 0;
            let ends = place + 1 < air.len() || !cut;
            let whole = if begins && ends { last.0 - first.0 } else { before + after };
            let from = first.0 + if begins { NEAR * whole } else { 0.0 };
            let to = last.0 - if ends { NEAR * whole } else { 0.0 };
            for (_, height) in
                phase.iter().filter(|(time, height)| (from..=to).contains(time) && height.is_finite())
            {
                smaller(&mut self.margins.clearance, *height);
            }
        }
    }
}
