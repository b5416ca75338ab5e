//! What the rows of the program ask for: which quantity has to lie where.
use super::demands::Demands;
use super::guess::shortness;
use super::layout::Layout;
use super::rows::Rows;
use super::similarity::{Measure, Similarity};
use super::{gravity, slides, weight};
use bipedc_compiler::compile::{Collocation, CollocationChange, CollocationPhase, NodeRow};
use bipedc_runtime::control::StandingFoot;

const EQUAL: [f64; 2] = [0.0, 0.0];
/// A phase that ends where a force vanishes or a foot tips ends clearly: over this last part of it the force (of the weight) and the distance of the centre of
/// pressure from the end of the sole (of its length) are no smaller than these, times what is left of the phase. Where they fall to nothing more slowly, the
/// robot under its controller comes to the end of the phase much earlier or later.
const CLEAR_END: f64 = 0.35;
const LETTING_GO: f64 = 0.3;
const TIPPING: f64 = 0.15;

/// How far outputs may be from their curves where an interval ends, of a robot 0.7 m high: rad or m, and their rates over that, 1/s. Accelerations hold outputs on
/// their curves at the nodes alone. What is gained by leaving the curves between them is lost under the controller, which does not leave them.
const DRIFT: f64 = 3e-3;
const DRIFT_RATE: f64 = 16.0;

/// Part of its bend in the guess that a leg on the ground keeps where outputs are none of its joints: beyond a straight leg no posture lies on the curves, and near
/// one a small error of an output is a large one of the posture.
const REGULAR: f64 = 0.3;

/// How high feet go, over the height of the base.
const HIGHEST: f64 = 0.3;

/// What is left of the upward speed of a foot that is let go where legs slide: no blow goes along a joint that slides, and the foot comes off by what drives it
/// alone.
const SLIDES: f64 = 0.02;

const ABOVE: [f64; 2] = [0.0, f64::INFINITY];

pub(super) struct Builder<'a> {
    pub of: &'a Collocation,
    pub layout: &'a Layout,
    pub demands: &'a Demands,
    /// Whether virtual constraints are asked for.
    pub outputs: bool,
    /// Smallest rate of each phase variable.
    pub rates: &'a [f64],
    /// By phase and foot the determinant of a leg in the guess; none where that is no question.
    pub regular: &'a [Vec<Option<f64>>],
    /// Parts of the step that the phases take in the guess.
    pub parts: &'a [f64],
    /// Height of the base at ease, m.
    pub height: f64,
    /// Size of the robot.
    pub similar: Similarity,
    pub coordinates: &'a [Measure],
}

impl Builder<'_> {
    pub fn rows(&self) -> Rows {
        let mut rows = Rows::default();
        for phase in 0..self.of.phases.len() {
            let nodes = (0..self.layout.phases[phase].nodes()).map(|node| self.node(&mut rows, phase, node));
            let nodes = nodes.collect();
            rows.nodes.push(nodes);
            self.between(&mut rows, phase);
            for node in 0..self.layout.phases[phase].nodes() {
                self.forces(&mut rows, phase, node);
            }
            self.change(&mut rows, phase);
            let [first, last] = self.layout.phases[phase].ends();
            if self.outputs {
                let unit = self.similar.position(self.variable(phase));
                let short = shortness(self.demands.speed, self.height, gravity(self.of));
                let growth = vec![(last, 1.0), (first, -1.0)];
                rows.sum(
                    ("φ does not grow", phase, None),
                    unit,
                    ([0.02 * short * unit, f64::INFINITY], growth),
                );
            }
        }
        self.speed(&mut rows);
        rows
    }

    fn node(&self, rows: &mut Rows, phase: usize, node: usize) -> Vec<Option<usize>> {
        let of = &self.of.phases[phase];
        let mut places = vec![None; of.node.rows()];
        for &(kind, first, count) in &of.rows {
            for k in 0..count {
                if let Some((limits, what)) = self.asked(kind, k, phase, node) {
                    let unit = self.unit(kind, k, phase);
                    places[first + k] = Some(rows.add((&what, phase, Some(node)), unit, limits));
                }
            }
        }
        places
    }

    fn variable(&self, phase: usize) -> Measure {
        Measure::of_unit(&self.of.phases[phase].unit)
    }

    /// What is much of a row of a node.
    fn unit(&self, kind: NodeRow, k: usize, phase: usize) -> f64 {
        let (of, similar) = (&self.of.phases[phase], &self.similar);
        let output = |k: usize| Measure::of_unit(&of.output_units[k]);
        match kind {
            NodeRow::Dynamics => similar.load(self.coordinates[k]),
            NodeRow::Contact => similar.acceleration(Measure::of_forces(of)[k]),
            NodeRow::OutputAcceleration => similar.acceleration(output(k)),
            NodeRow::Output => similar.position(output(k)),
            NodeRow::OutputRate => similar.velocity(output(k)),
            NodeRow::Phase => similar.position(self.variable(phase)),
            NodeRow::PhaseRate => similar.velocity(self.variable(phase)),
            NodeRow::Height | NodeRow::Place => similar.length,
            NodeRow::Regularity => self.regular[phase][k].map_or(1.0, f64::abs),
            NodeRow::HeightRate => similar.velocity(Measure::Length),
        }
    }

    fn point(&self, index: usize) -> &str {
        &self.of.tree.points[index].name
    }

    /// What is asked of a row of a node, if anything.
    fn asked(&self, kind: NodeRow, k: usize, phase: usize, node: usize) -> Option<([f64; 2], String)> {
        let of = &self.of.phases[phase];
        let (first, last) = (node == 0, node + 1 == self.layout.phases[phase].nodes());
        let equal = |what: String| Some((EQUAL, what));
        match kind {
            NodeRow::Dynamics => equal("equations of motion".to_owned()),
            NodeRow::Contact => equal(format!("acceleration of what stands, {}", of.forces[k])),
            NodeRow::OutputAcceleration if self.outputs => {
                equal(format!("virtual constraint {}", of.outputs[k]))
            }
            NodeRow::Output | NodeRow::OutputRate if self.outputs && first => {
                equal(format!("beginning of virtual constraint {}", of.outputs[k]))
            }
            NodeRow::Output | NodeRow::OutputRate if self.outputs && node.is_multiple_of(2) => {
                let free = if kind == NodeRow::Output { DRIFT } else { DRIFT * DRIFT_RATE };
                let most = free * self.unit(kind, k, phase);
                Some(([-most, most], format!("distance from virtual constraint {}", of.outputs[k])))
            }
            NodeRow::Phase if self.outputs && (k == 1 && first || k == 2 && last) => {
                equal("ends of the phase variable".to_owned())
            }
            NodeRow::PhaseRate => {
                Some(([self.rates[phase], f64::INFINITY], "rate of the phase variable".to_owned()))
            }
            NodeRow::Height => self.height(k, phase, node),
            NodeRow::HeightRate if last && self.of.changes[phase].landing.contains(&k) => {
                let [slow, fast] = self.demands.landing;
                Some(([-fast, -slow], format!("landing speed of {}", self.point(k))))
            }
            NodeRow::Place if phase == 0 && first && of.standing.first() == Some(&k) => {
                equal(format!("place of {}", self.point(k)))
            }
            NodeRow::Regularity if self.outputs => {
                let usual = self.regular[phase][k].filter(|_| self.stands(phase, k))?;
                let least = REGULAR * usual;
                let limits = if usual > 0.0 { [least, f64::INFINITY] } else { [f64::NEG_INFINITY, least] };
                Some((limits, format!("leg of {} is bent", self.of.description.feet[k].name)))
            }
            _ => None,
        }
    }

    /// Whether a foot, by index, is on the ground.
    fn stands(&self, phase: usize, foot: usize) -> bool {
        let name = &self.of.description.feet[foot].name;
        self.of.phases[phase].standing.iter().any(|&point| self.foot(point) == name)
    }

    fn foot(&self, point: usize) -> &str {
        self.point(point).split('/').next().unwrap_or("")
    }

    /// How high a contact point has to be.
    fn height(&self, point: usize, phase: usize, node: usize) -> Option<([f64; 2], String)> {
        let of = &self.of.phases[phase];
        let last = node + 1 == self.layout.phases[phase].nodes();
        let lands = self.of.changes[phase].landing.contains(&point);
        if of.standing.contains(&point) {
            return None;
        }
        if last && lands {
            return Some((EQUAL, format!("{} on the ground", self.point(point))));
        }
        let part = self.layout.phases[phase].part(node);
        let left = self.stood_before(phase, point);
        // A tenth of the step, or of the phase that is all of a foot's way.
        let ramp = if left && lands { 0.1 } else { (0.1 / self.parts[phase]).min(1.0) };
        let [rise, fall] = [(left, part), (lands, 1.0 - part)]
            .map(|(near, part)| if near { (part / ramp).min(1.0) } else { 1.0 });
        let rolls = of.standing.iter().any(|&other| self.foot(other) == self.foot(point));
        if left && node == 0 {
            return None;
        }
        let height = if rolls { 0.0 } else { self.demands.clearance * rise.min(fall) };
        let highest = HIGHEST * self.height;
        Some(([height, highest], format!("clearance of {}", self.point(point))))
    }

    /// Whether a point stood in the phase before.
    fn stood_before(&self, phase: usize, point: usize) -> bool {
        let count = self.of.phases.len();
        let before = (phase + count - 1) % count;
        let point = if self.of.changes[before].relabel { self.mirrored(point) } else { point };
        self.of.phases[before].standing.contains(&point)
    }

    /// The point of the other foot that takes the place of this one when the legs swap.
    fn mirrored(&self, point: usize) -> usize {
        let name = self.point(point);
        let (foot, part) = name.split_once('/').unwrap_or((name, ""));
        let other = self
            .of
            .description
            .feet
            .iter()
            .find(|other| other.name != foot && other.points.iter().any(|p| p.name == part));
        let wanted = other.map(|other| format!("{}/{part}", other.name));
        let points = &self.of.tree.points;
        wanted.and_then(|wanted| points.iter().position(|p| p.name == wanted)).unwrap_or(point)
    }

    fn between(&self, rows: &mut Rows, phase: usize) {
        rows.between.push(rows.limits.len());
        for interval in 0..self.layout.phases[phase].intervals {
            for k in 0..4 * self.layout.nv {
                let of = self.coordinates[k % self.layout.nv];
                let unit = if k < 2 * self.layout.nv {
                    self.similar.position(of)
                } else {
                    self.similar.velocity(of)
                };
                rows.add(("motion between nodes", phase, Some(2 * interval)), unit, EQUAL);
            }
        }
    }

    /// Friction and centres of pressure: sums of forces.
    fn forces(&self, rows: &mut Rows, phase: usize, node: usize) {
        let of: &CollocationPhase = &self.of.phases[phase];
        let first = self.layout.forces(phase, node);
        let last = node + 1 == self.layout.phases[phase].nodes();
        let [force, moment_unit] = [Measure::Length, Measure::Angle].map(|of| self.similar.load(of));
        for foot in of.feet.iter().flatten() {
            let name = of.forces[foot.force[0]].split('/').next().unwrap_or("");
            let [x, z] = foot.force.map(|k| first + k);
            let left = 1.0 - self.layout.phases[phase].part(node);
            if last && !foot.holds {
                let what = format!("{name} lets go");
                let nothing = [-0.5 * force, 0.5 * force];
                rows.sum((&what, phase, Some(node)), force, (EQUAL, vec![(z, 1.0)]));
                rows.sum((&what, phase, Some(node)), force, (nothing, vec![(x, 1.0)]));
            } else {
                let name = format!("friction of {name}");
                self.friction(rows, (&name, phase, Some(node)), (force, self.demands.friction), [x, z]);
                if !foot.holds && left < CLEAR_END {
                    let least = LETTING_GO * left * weight(self.of);
                    let what = format!("{name} lets go by and by");
                    rows.sum((&what, phase, Some(node)), force, ([least, f64::INFINITY], vec![(z, 1.0)]));
                }
            }
            if let Some(moment) = foot.moment {
                for side in 0..2 {
                    let sign = [-1.0, 1.0][side];
                    let tips =
                        if left < CLEAR_END { TIPPING * left * (foot.sole[1] - foot.sole[0]) } else { 0.0 };
                    let margin = if foot.level[side] { self.demands.zmp } else { tips };
                    let limits = if last && !foot.level[side] { EQUAL } else { ABOVE };
                    let sum = vec![(z, sign * foot.sole[side] - margin), (first + moment, sign)];
                    let what = format!("centre of pressure of {name}");
                    rows.sum((&what, phase, Some(node)), moment_unit, (limits, sum));
                }
            }
        }
    }

    fn friction(
        &self,
        rows: &mut Rows,
        name: (&str, usize, Option<usize>),
        (unit, coefficient): (f64, f64),
        [x, z]: [usize; 2],
    ) {
        for sign in [-1.0, 1.0] {
            rows.sum(name, unit, (ABOVE, vec![(z, coefficient), (x, sign)]));
        }
    }

    fn change(&self, rows: &mut Rows, phase: usize) {
        let of: &CollocationChange = &self.of.changes[phase];
        let nv = self.layout.nv;
        let wraps = phase + 1 == self.of.phases.len();
        let mut places = vec![None; of.function.rows()];
        for (k, &measure) in self.coordinates.iter().enumerate() {
            let posture = self.similar.position(measure);
            if !(wraps && k == 0) {
                places[k] = Some(rows.add(("posture at the change of phases", phase, None), posture, EQUAL));
            }
            let velocity = match of.impulses.is_empty() {
                true => self.similar.velocity(measure),
                false => self.similar.impulse(measure),
            };
            places[nv + k] =
                Some(rows.add(("velocity at the change of phases", phase, None), velocity, EQUAL));
        }
        let moments: Vec<usize> = of.feet.iter().flatten().filter_map(|foot| foot.moment).collect();
        for (k, name) in of.impulses.iter().enumerate() {
            let what = format!("impact holds {name}");
            let of = if moments.contains(&k) { Measure::Angle } else { Measure::Length };
            places[2 * nv + k] = Some(rows.add((&what, phase, None), self.similar.velocity(of), EQUAL));
        }
        if !of.impulses.is_empty() {
            for &point in &of.leaving {
                let what = format!("lift-off of {}", self.point(point));
                let slides = slides(self.of);
                let limits = [self.demands.lift_off * if slides { SLIDES } else { 1.0 }, f64::INFINITY];
                let unit = self.similar.velocity(Measure::Length);
                places[2 * nv + of.impulses.len() + point] =
                    Some(rows.add((&what, phase, None), unit, limits));
            }
        }
        rows.changes.push(places);
        let first = self.layout.phases[phase].impulses.start;
        for foot in of.feet.iter().flatten() {
            self.impulses(rows, phase, foot, first);
        }
    }

    fn impulses(&self, rows: &mut Rows, phase: usize, foot: &StandingFoot, first: usize) {
        let [x, z] = foot.force.map(|k| first + k);
        let name = self.of.changes[phase].impulses[foot.force[0]].split('/').next().unwrap_or("");
        let [impulse, angular] = [Measure::Length, Measure::Angle].map(|of| self.similar.impulse(of));
        let what = format!("friction of the impulse on {name}");
        self.friction(rows, (&what, phase, None), (impulse, self.demands.impact_friction), [x, z]);
        let Some(moment) = foot.moment else { return };
        for side in 0..2 {
            let sign = [-1.0, 1.0][side];
            let sum = vec![(z, sign * foot.sole[side]), (first + moment, sign)];
            let what = format!("centre of the impulse on {name}");
            rows.sum((&what, phase, None), angular, (ABOVE, sum));
        }
    }

    fn speed(&self, rows: &mut Rows) {
        let count = self.of.phases.len();
        let last = self.layout.motion(count - 1, self.layout.phases[count - 1].nodes() - 1, 0);
        let mut sum = vec![(last, 1.0), (self.layout.motion(0, 0, 0), -1.0)];
        let longest = self.demands.longest_step * self.height;
        let length = self.similar.length;
        let shortest = 0.02 * shortness(self.demands.speed, self.height, gravity(self.of)) * length;
        rows.sum(("length of the step", 0, None), length, ([shortest, longest], sum.clone()));
        sum.extend(self.layout.phases.iter().map(|phase| (phase.duration, -self.demands.speed)));
        rows.sum(("walking speed", 0, None), length, (EQUAL, sum));
    }
}
