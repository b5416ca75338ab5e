//! Bounds and scales of the variables of the program.
use super::demands::Demands;
use super::layout::Layout;
use super::mirrored::between;
use super::similarity::{Measure, Similarity};
use super::weight;
use bipedc_compiler::compile::Collocation;

/// How far the base leans, rad. Torques alone are as small in motions that bow low and kick high as in walks, and searches end in those.
pub(super) const LEAN: f64 = 0.4;

/// Of each variable the bounds and what it is divided by, in its unit.
pub(super) struct Variables {
    pub bounds: Vec<[f64; 2]>,
    pub scale: Vec<f64>,
}

/// What bounds follow from.
struct Bounds<'a> {
    of: &'a Collocation,
    layout: &'a Layout,
    demands: &'a Demands,
    similar: Similarity,
    coordinates: Vec<Measure>,
    found: Variables,
}

impl Variables {
    /// Of a program whose first guess has these durations.
    pub fn new(
        of: &Collocation,
        layout: &Layout,
        similar: Similarity,
        demands: &Demands,
        guess: &[f64],
    ) -> Self {
        let found =
            Self { bounds: vec![[-100.0, 100.0]; layout.variables], scale: vec![1.0; layout.variables] };
        let coordinates = Measure::of_coordinates(of);
        let mut all = Bounds { of, layout, demands, similar, coordinates, found };
        for (p, phase) in layout.phases.iter().enumerate() {
            let duration = guess[phase.duration];
            all.set(phase.duration, [0.5 * duration, 1.6 * duration], duration);
            all.curves(p);
            for node in 0..phase.nodes() {
                all.motion(p, node);
                all.joints(p, node);
                all.forces(p, node);
            }
            all.impulses(p);
        }
        all.found
    }
}

impl Bounds<'_> {
    fn set(&mut self, place: usize, bounds: [f64; 2], scale: f64) {
        (self.found.bounds[place], self.found.scale[place]) = (bounds, scale);
    }

    /// Weight of the robot, N.
    fn weight(&self) -> f64 {
        weight(self.of)
    }

    /// A torque over a force, m.
    fn moment(&self) -> f64 {
        self.similar.load(Measure::Angle) / (self.similar.mass * self.similar.gravity)
    }

    /// φ at the ends of a phase and the coefficients of its outputs.
    fn curves(&mut self, p: usize) {
        let (phase, of) = (&self.layout.phases[p], &self.of.phases[p]);
        let outputs = of.output_units.iter().enumerate().flat_map(|(k, unit)| {
            let first = phase.coefficients.start + k * of.coefficients;
            (first..first + of.coefficients).map(move |place| (place, unit))
        });
        for (place, unit) in phase.ends().map(|place| (place, &of.unit)).into_iter().chain(outputs) {
            let unit = self.similar.position(Measure::of_unit(unit));
            self.set(place, [-100.0 * unit, 100.0 * unit], unit);
        }
    }

    /// q, v and v̇ of a node, before joints have their limits.
    fn motion(&mut self, p: usize, node: usize) {
        let similar = self.similar;
        for k in 0..self.coordinates.len() {
            let of = self.coordinates[k];
            let units = [similar.position(of), similar.velocity(of), similar.acceleration(of)];
            let scales = [units[0], units[1], 10.0 * units[2]];
            let most = [10.0 * units[0], 20.0 * units[1], 3000.0 * units[2]];
            for order in 0..3 {
                let place = self.layout.motion(p, node, order) + k;
                self.set(place, [-most[order], most[order]], scales[order]);
            }
        }
        self.found.bounds[self.layout.motion(p, node, 0) + 2] = [-LEAN, LEAN];
        let exchanged = self.of.changes[p].relabel && node + 1 == self.layout.phases[p].nodes();
        if exchanged && self.demands.sinking > 0.0 {
            self.found.bounds[self.layout.motion(p, node, 1) + 1][1] = -self.demands.sinking;
        }
    }

    /// Limits of the joints: positions, velocities, torques.
    fn joints(&mut self, p: usize, node: usize) {
        let [q, v] = [0, 1].map(|order| self.layout.motion(p, node, order));
        let turning = self.similar.velocity(Measure::Angle);
        let of = self.of;
        for (k, joint) in of.tree.joints.iter().enumerate() {
            let named = of.description.joints.iter().find(|other| other.name == joint.name);
            let limits = named.and_then(|joint| joint.position_limits);
            let (low, high) = limits.unwrap_or((-3.2, 3.2));
            self.found.bounds[q + joint.v_index] = between([low, high], self.demands.joint);
            let fastest = named
                .and_then(|joint| joint.velocity_limit)
                .map_or(30.0 * turning, |x| x * self.demands.velocity);
            self.found.bounds[v + joint.v_index] = [-fastest, fastest];
            let moment = if self.coordinates[joint.v_index] == Measure::Length { 1.0 } else { self.moment() };
            let effort = named
                .and_then(|joint| joint.effort_limit)
                .map_or(25.0 * of.mass * self.similar.gravity * moment, |x| x * self.demands.effort);
            let torque = self.layout.torques(p, node) + k;
            self.set(torque, [-effort, effort], 0.05 * self.weight() * moment);
        }
    }

    /// Forces of the ground; feet push.
    fn forces(&mut self, p: usize, node: usize) {
        let (of, weight, forces) = (&self.of.phases[p], self.weight(), self.layout.forces(p, node));
        for (k, measure) in Measure::of_forces(of).into_iter().enumerate() {
            let unit = weight * if measure == Measure::Angle { self.moment() } else { 1.0 };
            self.set(forces + k, [-20.0 * unit, 20.0 * unit], 0.5 * unit);
        }
        let last = node + 1 == self.layout.phases[p].nodes();
        for foot in of.feet.iter().flatten() {
            let low = match (foot.holds, last) {
                (true, _) => self.demands.push,
                (false, true) => -self.similar.mass * self.similar.gravity,
                (false, false) => 0.0,
            };
            self.found.bounds[forces + foot.force[1]] = [low, 20.0 * weight];
        }
    }

    /// Impulses of the change behind a phase.
    fn impulses(&mut self, p: usize) {
        let impulses = self.layout.phases[p].impulses.clone();
        let blow = self.weight() * self.similar.time();
        for place in impulses.clone() {
            self.set(place, [-2.0 * blow, 2.0 * blow], 0.1 * blow);
        }
        for foot in self.of.changes[p].feet.iter().flatten() {
            self.found.bounds[impulses.start + foot.force[1]] = [self.demands.impulse, 2.0 * blow];
            if let Some(turn) = foot.moment.map(|k| impulses.start + k) {
                let most = 2.0 * blow * self.moment();
                self.set(turn, [-most, most], 0.1 * blow * self.moment());
            }
        }
    }
}
