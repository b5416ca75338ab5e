//! The assumptions under which phases in a fixed order hold, and the verdict when one does not.
use super::integrate::Violation;
use super::robot::{PhasedRobot, Work};
use super::spec::PhaseSpec;
use super::support::{Load, Row, RowKind, inside};
use crate::robot::BaseKind;
use bipedc_runtime::model::{Argument, State};

/// Which assumptions are checked, and with which numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumptions {
    /// Coulomb's coefficient; infinite: feet never slip.
    pub friction: f64,
    /// Depth to which points in the air may pass through the ground, m; infinite: scuffing is allowed (walkers without
    /// knees do it).
    pub scuffing: f64,
    /// Feet may not pull.
    pub pushing: bool,
    /// A foot lands only where it is at least this far ahead (along x) of what stands, m; minus infinity: anywhere. With it
    /// a walker without knees passes its swing foot through the ground beside the other.
    pub shortest_step: f64,
    /// The step ends where the landing foot is this far ahead (along x) of what stands, m, whatever its height was until
    /// then: walkers without knees whose foot comes to the ground from below.
    pub step_length: Option<f64>,
    /// Nothing strikes again just after an impact: what was let go leaves the ground, a flat foot does not rock.
    pub second_impact: bool,
    /// How far from the ground a point may be that lands, m: a foot that lands flat is level.
    pub level: f64,
    /// Forces that nobody asks for friction of, as a part of the weight (impulses: of all feet's): on a foot that carries less than ten times
    /// it the force along the ground may exceed friction by so much. A foot that is about to be let go carries less and less: its quotient of forces
    /// means nothing, and what it would slip by moves nothing.
    pub light: f64,
    /// Where contacts are not those of the order of phases, the walk goes on in the phase that has them; `None`: not said.
    pub follows: Option<bool>,
}

impl Default for Assumptions {
    fn default() -> Self {
        Self {
            friction: f64::INFINITY,
            scuffing: 1e-6,
            pushing: true,
            shortest_step: f64::NEG_INFINITY,
            step_length: None,
            second_impact: true,
            level: 1e-3,
            light: 0.01,
            follows: None,
        }
    }
}

impl Assumptions {
    /// By how much the force along the ground may exceed friction on a foot that carries `push`, N: a part of the `weight` on one that carries little, else
    /// nothing. Impulses likewise, N s, with the sum of all feet's as weight.
    pub fn unasked(&self, push: f64, weight: f64) -> f64 {
        let light = self.light * weight;
        if push < LITTLE * light { light } else { 0.0 }
    }
}

/// Forces (N) and impulses (N s) that are rounding: at the instant at which a foot lets go its force is zero.
const ROUNDING: [f64; 2] = [1e-6, 1e-9];
/// Distances that are rounding, m.
const CLOSE: f64 = 1e-9;
/// Speeds that are rounding, m/s.
const STILL: f64 = 1e-9;
/// A foot that carries less than so many times what is light carries little.
const LITTLE: f64 = 10.0;

/// What is known about a violation before it has a phase and a time.
struct Breach {
    quantity: String,
    value: f64,
    limit: f64,
    unit: &'static str,
    meaning: &'static str,
}

impl Breach {
    fn at(self, spec: &PhaseSpec, time: f64) -> Violation {
        let Self { quantity, value, limit, unit, meaning } = self;
        Violation { phase: spec.name.clone(), time, quantity, value, limit, unit, meaning }
    }
}

impl PhasedRobot<'_> {
    /// The first assumption that does not hold in a state with its forces in `work`.
    pub(super) fn broken(&self, number: usize, time: f64, x: &[f64], work: &mut Work) -> Option<Violation> {
        let spec = &self.phases[number].0;
        let (q, v) = self.split(x);
        self.dynamics(number, time, x, work);
        let forces = work.out[v.len()..].to_vec();
        let found = self
            .pull_or_slip(&spec.rows, &forces, false)
            .or_else(|| self.tips(spec, q, &forces, work))
            .or_else(|| self.tips_along_an_edge(spec, q, v, work))
            .or_else(|| self.scuffs(spec, (q, v), work))
            .or_else(|| self.stops(q));
        found.map(|found| found.at(spec, time))
    }

    /// The assumptions that the configuration alone tells.
    pub(super) fn broken_in_the_air(&self, number: usize, time: f64, x: &[f64]) -> Option<Violation> {
        if !self.assumptions.scuffing.is_finite() {
            return None;
        }
        let spec = &self.phases[number].0;
        self.scuffs(spec, self.split(x), &mut self.work.borrow_mut()).map(|found| found.at(spec, time))
    }

    /// Just after the impact that ends a phase: `q`, `v⁺` and the impulses of the rows.
    pub(super) fn broken_by_impact(
        &self,
        number: usize,
        time: f64,
        (q, after): (&[f64], &[f64]),
        (rows, impulses): (&[Row], &[f64]),
    ) -> Option<Violation> {
        let spec = &self.phases[number].0;
        let mut found = self.pull_or_slip(rows, impulses, true);
        if self.assumptions.second_impact {
            found = self.lands_askew(spec, q).or(found);
            found = found.or_else(|| self.rocks(spec, q, rows, impulses));
            found = found.or_else(|| self.strikes_again(spec, q, after));
        }
        found.map(|found| found.at(spec, time))
    }

    /// Whether impulses are more along the ground than friction holds.
    pub(super) fn slips(
        &self,
        spec: &PhaseSpec,
        time: f64,
        rows: &[Row],
        impulses: &[f64],
    ) -> Option<Violation> {
        self.pull_or_slip(rows, impulses, true).map(|found| found.at(spec, time))
    }

    /// Forces or impulses of the rows against the laws of contact.
    fn pull_or_slip(&self, rows: &[Row], forces: &[f64], impact: bool) -> Option<Breach> {
        let (unit, kind) = if impact { ("N s", "impulse") } else { ("N", "force") };
        let rounding = ROUNDING[usize::from(impact)];
        let loads = (0..self.feet.len()).map(|foot| Load::of(foot, rows, forces).force[2]);
        let weight = if impact { loads.sum() } else { self.weight };
        for (index, foot) in self.feet.iter().enumerate() {
            if !rows.iter().any(|row| row.foot == index) {
                continue;
            }
            let load = Load::of(index, rows, forces);
            let found = |quantity: &str, value, limit, meaning| {
                let quantity = format!("{quantity} {kind} on {}", foot.name);
                Some(Breach { quantity, value, limit, unit, meaning })
            };
            if self.assumptions.pushing && load.force[2] < -rounding {
                return found("normal", load.force[2], 0.0, "the ground would have to pull the foot");
            }
            let tangential = load.force[0].hypot(load.force[1]);
            let limit = self.assumptions.friction * load.force[2].max(0.0);
            let slack = self.assumptions.unasked(load.force[2], weight);
            if self.assumptions.friction.is_finite() && tangential > limit + slack + rounding {
                return found("tangential", tangential, limit, "the foot slips");
            }
        }
        None
    }

    /// Centres of pressure of flat feet.
    fn tips(&self, spec: &PhaseSpec, q: &[f64], forces: &[f64], work: &mut Work) -> Option<Breach> {
        for (index, foot) in self.feet.iter().enumerate() {
            let load = Load::of(index, &spec.rows, forces);
            if !load.flat {
                continue;
            }
            let sole = self.sole(index, &spec.standing);
            let (place, points, _) = self.pressure(q, &load, &sole, work);
            let value = inside(place, &points, self.base == BaseKind::Planar);
            // Without load there is no centre: what counts is the moment that misses.
            if value < -CLOSE && value * load.force[2] < -ROUNDING[0] * CLOSE {
                let quantity = format!("distance of the centre of pressure from the edge of {}", foot.name);
                return Some(Breach { quantity, value, limit: 0.0, unit: "m", meaning: "the foot tips" });
            }
        }
        None
    }

    /// Feet that stand on an edge (in space) may not tip over its ends.
    fn tips_along_an_edge(&self, spec: &PhaseSpec, q: &[f64], v: &[f64], work: &mut Work) -> Option<Breach> {
        if !spec.rows.iter().any(|row| row.kind == RowKind::MomentAcross) {
            return None;
        }
        let forces = self.point_forces_of(spec, q, v, work);
        for (index, foot) in self.feet.iter().enumerate() {
            if !spec.rows.iter().any(|row| row.foot == index && row.kind == RowKind::MomentAcross) {
                continue;
            }
            let points = self.sole(index, &spec.standing);
            let places = self.places(q, &points, work);
            let (Some(first), Some(last)) = (places.first(), places.last()) else { continue };
            let width = (first[0] - last[0]).hypot(first[1] - last[1]);
            let load: f64 = points.iter().map(|&point| forces[point][2]).sum();
            let least = points.iter().map(|&point| forces[point][2]).fold(f64::INFINITY, f64::min);
            if least < -ROUNDING[0] && load > ROUNDING[0] {
                let quantity =
                    format!("distance of the centre of pressure from the end of the edge of {}", foot.name);
                let value = width * least / load;
                return Some(Breach { quantity, value, limit: 0.0, unit: "m", meaning: "the foot tips" });
            }
        }
        None
    }

    /// Heights of the points in the air.
    fn scuffs(&self, spec: &PhaseSpec, (q, v): (&[f64], &[f64]), work: &mut Work) -> Option<Breach> {
        if !self.assumptions.scuffing.is_finite() {
            return None;
        }
        let below = |(_, height): &(usize, f64)| *height < -self.assumptions.scuffing;
        let mut sunk: Vec<(usize, f64)> = self.in_the_air(spec, q, work).into_iter().filter(below).collect();
        if self.follows() && !sunk.is_empty() {
            // What was let go just below the ground, where it had landed, rises.
            let speeds = self.normal_speeds(q, v);
            sunk.retain(|(point, _)| speeds[*point] < 0.0);
        }
        let (point, value) = sunk.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Breach {
            quantity: format!("height of {}", self.point_name(point)),
            value,
            limit: -self.assumptions.scuffing,
            unit: "m",
            meaning: "the swing foot scuffs",
        })
    }

    /// Points in the air with their heights above the ground below them, m.
    pub(super) fn in_the_air(&self, spec: &PhaseSpec, q: &[f64], work: &mut Work) -> Vec<(usize, f64)> {
        self.call(self.distances, &State::new().with(Argument::Q, q), &mut work.points);
        let air = work.points.iter().enumerate().filter(|(point, _)| !spec.standing.contains(point));
        let air: Vec<(usize, f64)> = air.map(|(point, &height)| (point, height)).collect();
        let above = |(point, height)| (point, height - self.ground_below(spec, q, point, work));
        air.into_iter().map(above).collect()
    }

    /// Vertical velocities of the contact points, m/s.
    pub(super) fn normal_speeds(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut directions = Vec::new();
        self.call(self.normals, &State::new().with(Argument::Q, q), &mut directions);
        directions.chunks_exact(v.len()).map(|row| row.iter().zip(v).map(|(w, v)| w * v).sum()).collect()
    }

    /// Height of the ground below a point, m.
    fn ground_below(&self, spec: &PhaseSpec, q: &[f64], point: usize, work: &mut Work) -> f64 {
        let ground = self.ground();
        if ground == [0.0, 0.0] {
            return 0.0;
        }
        let own = self.stands_already(&spec.standing, &[point]);
        let mine = |other: &usize| self.stands_already(&[*other], &[point]);
        let others: Vec<usize> = spec.standing.iter().copied().filter(|other| !mine(other)).collect();
        let in_front = others.is_empty() || self.ahead(q, &[point], &others, work) > 0.0;
        match (own, in_front) {
            // The foot of the point stands on the foothold that was reached last, or behind it.
            (true, true) => 0.0,
            (false, true) => ground[1],
            (_, false) => ground[0],
        }
    }

    /// Joints between their stops.
    fn stops(&self, q: &[f64]) -> Option<Breach> {
        let first = q.len() - self.model.joints();
        for (joint, limits) in self.stops.iter().enumerate() {
            let (Some([low, high]), value) = (limits, q[first + joint]) else { continue };
            let limit = if value < low - CLOSE {
                *low
            } else if value > high + CLOSE {
                *high
            } else {
                continue;
            };
            let name = self.model.joint_name(joint).unwrap_or("a joint");
            let quantity = format!("position of {name}");
            return Some(Breach { quantity, value, limit, unit: "rad", meaning: "the joint meets its stop" });
        }
        None
    }

    /// What lands is on the ground: a foot that lands flat is level.
    fn lands_askew(&self, spec: &PhaseSpec, q: &[f64]) -> Option<Breach> {
        let landing = &spec.impact.as_ref()?.standing;
        let heights = self.heights(q);
        let point = landing.iter().copied().max_by(|&a, &b| heights[a].abs().total_cmp(&heights[b].abs()))?;
        (heights[point].abs() > self.assumptions.level).then(|| Breach {
            quantity: format!("height of {} at the landing", self.point_name(point)),
            value: heights[point],
            limit: self.assumptions.level,
            unit: "m",
            meaning: "the foot does not land as the phases say: this point is not on the ground",
        })
    }

    /// A foot that lands flat takes the impulse inside its sole.
    fn rocks(&self, spec: &PhaseSpec, q: &[f64], rows: &[Row], impulses: &[f64]) -> Option<Breach> {
        let after: &[usize] = spec.impact.as_ref().map_or(&[], |landing| &landing.standing);
        let work = &mut self.work.borrow_mut();
        for (index, foot) in self.feet.iter().enumerate() {
            let load = Load::of(index, rows, impulses);
            if !load.flat {
                continue;
            }
            let sole = self.sole(index, after);
            let (place, points, _) = self.pressure(q, &load, &sole, work);
            let value = inside(place, &points, self.base == BaseKind::Planar);
            if value < -CLOSE && value * load.force[2] < -ROUNDING[1] {
                let quantity =
                    format!("distance of the impulse's centre of pressure from the edge of {}", foot.name);
                let meaning = "the foot rocks on the ground: a second impact";
                return Some(Breach { quantity, value, limit: 0.0, unit: "m", meaning });
            }
        }
        None
    }

    /// What the impact does not hold leaves the ground: points that stood before, and others that are on the ground.
    fn strikes_again(&self, spec: &PhaseSpec, q: &[f64], after: &[f64]) -> Option<Breach> {
        let kept: &[usize] = spec.impact.as_ref().map_or(&[], |landing| &landing.standing);
        let work = &mut self.work.borrow_mut();
        self.call(self.distances, &State::new().with(Argument::Q, q), &mut work.points);
        let speeds = self.normal_speeds(q, after);
        for (point, &height) in work.points.iter().enumerate().filter(|(point, _)| !kept.contains(point)) {
            let stood = spec.standing.contains(&point);
            let near = self.assumptions.scuffing.is_finite() && height < self.assumptions.scuffing;
            let speed = speeds[point];
            if (stood || near) && speed < -STILL {
                return Some(Breach {
                    quantity: format!("vertical velocity of {} after the impact", self.point_name(point)),
                    value: speed,
                    limit: 0.0,
                    unit: "m/s",
                    meaning: "it strikes the ground again: a second impact",
                });
            }
        }
        None
    }

    /// `foot/point`.
    fn point_name(&self, point: usize) -> String {
        let all = self.feet.iter().flat_map(|foot| foot.corners.iter().map(move |corner| (foot, corner)));
        let named = all.map(|(foot, corner)| format!("{}/{}", foot.name, corner.name)).nth(point);
        named.unwrap_or_else(|| format!("contact point {point}"))
    }
}
