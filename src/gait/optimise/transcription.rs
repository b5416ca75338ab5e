//! The nonlinear program of a gait: direct collocation by Hermite and Simpson with the equations of motion, forces and torques at every node.
use super::constraints::Rows;
use super::demands::Demands;
use super::guess::ease;
use super::layout::{Layout, PhaseLayout};
use super::similarity::{Measure, Similarity};
use bipedc_analysis::nonlinear::Program;
use bipedc_compiler::compile::Collocation;
use bipedc_compiler::program::LocalFunction;

/// The program; its variables are scaled, so that all are near 1.
pub(super) struct Transcription<'c> {
    pub of: &'c Collocation,
    pub layout: Layout,
    pub rows: Rows,
    pub scale: Vec<f64>,
    bounds: Vec<[f64; 2]>,
    weight: f64,
    similar: Similarity,
    coordinates: Vec<Measure>,
    /// Coordinates at ease.
    ease: Vec<f64>,
    jacobian: Vec<[usize; 2]>,
    hessian: Vec<[usize; 2]>,
}

/// Squared accelerations that count as much as a squared torque, over the squared mass, m⁴, of a robot of 0.7 m. Among motions of nearly the same torques the smooth
/// one is wanted; without it valleys are so flat that a search does not end.
const SMOOTH: f64 = 2.5e-4;

/// What a torque in the middle of an interval off the mean of its ends costs, of a squared torque. Where the ground holds more than it needs, torques have a
/// freedom that motion alone does not settle: without this they go up and down from node to node, and what is fed forward over φ as a smooth curve is another
/// torque than that of the motion.
const EVEN: f64 = 10.0;

/// Part of a phase over which a torque that goes through its own size costs as much as that torque. A phase that ends by a force of the ground asks torques
/// to have a value at its last instant: without a cost of their rates they take it in the last interval, however short that is.
const RATE: f64 = 0.12;

/// What a third difference of Bezier coefficients costs, per rad² (or m², of a robot 0.7 m high). Curves that turn within an interval are not seen by its nodes.
const CURVED: f64 = 0.1;

/// How far the base leans, rad. Torques alone are as small in motions that bow low and kick high as in walks, and searches end in those.
const LEAN: f64 = 0.4;

/// What a joint, or the lean of the base, off its place at ease costs, per rad² (or m², of a robot 0.7 m high).
const EASE: f64 = 1.0;

/// A function of the program with its variables and rows.
struct Part<'a> {
    function: &'a LocalFunction,
    variables: Vec<usize>,
    rows: &'a [Option<usize>],
}

impl<'c> Transcription<'c> {
    pub fn new(
        of: &'c Collocation,
        layout: Layout,
        (rows, similar): (Rows, Similarity),
        demands: &Demands,
        guess: &[f64],
    ) -> Self {
        let mut found = Self {
            of,
            scale: vec![1.0; layout.variables],
            bounds: vec![[-100.0, 100.0]; layout.variables],
            weight: (0.05 * of.mass * 9.81 * similar.length).powi(-2),
            similar,
            coordinates: Measure::of_coordinates(of),
            ease: ease(of),
            jacobian: Vec::new(),
            hessian: Vec::new(),
            layout,
            rows,
        };
        found.bound(demands, guess);
        found.jacobian = found.structure_of_jacobian();
        found.hessian = found.structure_of_hessian();
        found
    }

    /// Bounds and scales of all variables.
    fn bound(&mut self, demands: &Demands, guess: &[f64]) {
        let weight = self.of.mass * 9.81;
        let (similar, layout) = (self.similar, self.layout.clone());
        let [turning, moment] =
            [similar.velocity(Measure::Angle), similar.load(Measure::Angle) / similar.mass];
        for (p, phase) in layout.phases.iter().enumerate() {
            self.bounds[phase.duration] = [0.5, 1.6].map(|part| part * guess[phase.duration]);
            self.scale[phase.duration] = guess[phase.duration];
            self.curves(p, &layout);
            for node in 0..phase.nodes() {
                let [q, v, a] = [0, 1, 2].map(|order| layout.motion(p, node, order));
                for (k, &of) in self.coordinates.iter().enumerate() {
                    let units = [similar.position(of), similar.velocity(of), similar.acceleration(of)];
                    let scales = [units[0], units[1], 10.0 * units[2]];
                    let most = [10.0 * units[0], 20.0 * units[1], 3000.0 * units[2]];
                    for (order, first) in [q, v, a].into_iter().enumerate() {
                        self.bounds[first + k] = [-most[order], most[order]];
                        self.scale[first + k] = scales[order];
                    }
                }
                let lean = LEAN;
                self.bounds[q + 2] = [-lean, lean];
                for (k, joint) in self.of.tree.joints.iter().enumerate() {
                    let named = self.of.description.joints.iter().find(|other| other.name == joint.name);
                    let limits = named.and_then(|joint| joint.position_limits);
                    let (low, high) = limits.unwrap_or((-3.2, 3.2));
                    let margin = demands.joint.min(0.2 * (high - low));
                    self.bounds[q + joint.v_index] = [low + margin, high - margin];
                    let fastest = named.and_then(|joint| joint.velocity_limit).unwrap_or(30.0 * turning);
                    self.bounds[v + joint.v_index] = [-fastest, fastest];
                    let effort = named
                        .and_then(|joint| joint.effort_limit)
                        .map_or(25.0 * self.of.mass * moment, |x| x * demands.effort);
                    self.bounds[layout.torques(p, node) + k] = [-effort, effort];
                    self.scale[layout.torques(p, node) + k] = 0.05 * weight * moment;
                }
                let forces = layout.forces(p, node);
                for (k, of) in Measure::of_forces(&self.of.phases[p]).into_iter().enumerate() {
                    let unit = weight * if of == Measure::Angle { moment } else { 1.0 };
                    self.bounds[forces + k] = [-20.0 * unit, 20.0 * unit];
                    self.scale[forces + k] = 0.5 * unit;
                }
                for foot in self.of.phases[p].feet.iter().flatten() {
                    let low = match (foot.holds, node + 1 == phase.nodes()) {
                        (true, _) => demands.push,
                        (false, true) => -similar.mass,
                        (false, false) => 0.0,
                    };
                    self.bounds[forces + foot.force[1]] = [low, 20.0 * weight];
                }
            }
            let impulses = phase.impulses.clone();
            let blow = weight * similar.time();
            self.bounds[impulses.clone()].fill([-2.0 * blow, 2.0 * blow]);
            self.scale[impulses.clone()].fill(0.1 * blow);
            for foot in self.of.changes[p].feet.iter().flatten() {
                self.bounds[impulses.start + foot.force[1]] = [demands.impulse, 2.0 * blow];
                if let Some(turn) = foot.moment.map(|k| impulses.start + k) {
                    self.bounds[turn] = self.bounds[turn].map(|x| x * moment);
                    self.scale[turn] *= moment;
                }
            }
        }
    }

    /// φ at the ends of a phase and the coefficients of its outputs.
    fn curves(&mut self, p: usize, layout: &Layout) {
        let (phase, of) = (&layout.phases[p], &self.of.phases[p]);
        let outputs = of.output_units.iter().enumerate().flat_map(|(k, unit)| {
            let first = phase.coefficients.start + k * of.coefficients;
            (first..first + of.coefficients).map(move |place| (place, unit))
        });
        for (place, unit) in phase.ends().map(|place| (place, &of.unit)).into_iter().chain(outputs) {
            let unit = self.similar.position(Measure::of_unit(unit));
            self.bounds[place] = [-100.0 * unit, 100.0 * unit];
            self.scale[place] = unit;
        }
    }

    /// In their units.
    pub fn unscaled(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.scale).map(|(x, scale)| x * scale).collect()
    }
    pub fn scaled(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(&self.scale).map(|(x, scale)| x / scale).collect()
    }

    /// All functions, in a fixed order.
    fn parts(&self) -> Vec<Part<'_>> {
        let mut found = Vec::new();
        for (p, nodes) in self.rows.nodes.iter().enumerate() {
            found.extend(nodes.iter().enumerate().map(|(node, rows)| Part {
                function: &self.of.phases[p].node,
                variables: self.layout.node(p, node),
                rows,
            }));
            found.push(Part {
                function: &self.of.changes[p].function,
                variables: self.layout.change(p),
                rows: &self.rows.changes[p],
            });
        }
        found
    }

    /// Equations between nodes: for each the row, then variable and factor of the linear part, and variable with factor of duration × it.
    fn each_between(&self, mut tell: impl FnMut(usize, usize, [(usize, f64); 3], [(usize, f64); 3])) {
        let nv = self.layout.nv;
        for (p, phase) in self.layout.phases.iter().enumerate() {
            for interval in 0..phase.intervals {
                let part = phase.width(interval);
                let first = self.rows.between[p] + 4 * nv * interval;
                for order in 0..2 {
                    let at = [0, 1, 2].map(|k| self.layout.motion(p, 2 * interval + k, order));
                    let slope = at.map(|x| x + nv);
                    for k in 0..nv {
                        let [a, m, b] = at.map(|x| x + k);
                        let [fa, fm, fb] = slope.map(|x| x + k);
                        let row = first + 2 * order * nv + k;
                        let whole = [(fa, -part / 6.0), (fm, -4.0 * part / 6.0), (fb, -part / 6.0)];
                        tell(row, phase.duration, [(b, 1.0), (a, -1.0), (m, 0.0)], whole);
                        let half = [(fa, -part / 8.0), (fb, part / 8.0), (fm, 0.0)];
                        tell(row + nv, phase.duration, [(m, 1.0), (a, -0.5), (b, -0.5)], half);
                    }
                }
            }
        }
    }

    fn structure_of_jacobian(&self) -> Vec<[usize; 2]> {
        let mut found = Vec::new();
        for part in self.parts() {
            for &[row, variable] in part.function.jacobian_structure() {
                if let Some(row) = part.rows[row] {
                    found.push([row, part.variables[variable]]);
                }
            }
        }
        self.each_between(|row, duration, linear, slopes| {
            found.extend(linear.iter().chain(&slopes).map(|&(variable, _)| [row, variable]));
            found.push([row, duration]);
        });
        for (row, terms) in &self.rows.sums {
            found.extend(terms.iter().map(|&(variable, _)| [*row, variable]));
        }
        found
    }

    fn structure_of_hessian(&self) -> Vec<[usize; 2]> {
        let mut found = Vec::new();
        for part in self.parts() {
            let pairs = part.function.hessian_structure().iter();
            found.extend(pairs.map(|&[i, j]| [part.variables[i], part.variables[j]]));
        }
        self.each_between(|_, duration, _, slopes| {
            found.extend(slopes.map(|(variable, _)| [variable, duration]))
        });
        self.each_cost(&vec![1.0; self.layout.variables], |place, _| found.push(place));
        found
    }

    /// Durations, and ∫ τ² dt by phase over its duration.
    fn squares(&self, x: &[f64]) -> (f64, Vec<f64>) {
        let total = self.layout.phases.iter().map(|phase| x[phase.duration]).sum();
        let of = |p: usize| {
            let mut sum = 0.0;
            self.each_torque(p, |k, weight| sum += weight * x[k] * x[k]);
            sum
        };
        (total, (0..self.layout.phases.len()).map(of).collect())
    }

    /// Torques of a phase with their weights (Simpson), and accelerations with theirs.
    fn each_torque(&self, p: usize, mut tell: impl FnMut(usize, f64)) {
        let phase = &self.layout.phases[p];
        let smooth = SMOOTH * self.of.mass * self.of.mass;
        for node in 0..phase.nodes() {
            let weight = simpson(phase, node);
            let torques = self.layout.torques(p, node);
            (torques..torques + self.layout.joints).for_each(|k| tell(k, weight));
            let accelerations = self.layout.motion(p, node, 2);
            for (k, &of) in self.coordinates.iter().enumerate() {
                // A torque over an acceleration, over the mass.
                let unit = self.similar.length / self.similar.acceleration(of);
                tell(accelerations + k, smooth * unit * unit * weight);
            }
        }
    }

    /// Sums whose squares cost something, with their weights: of torques in each interval what is off a straight line, and their rates; of coefficients the third
    /// differences.
    fn each_bend(&self, mut tell: impl FnMut([(usize, f64); 4], f64)) {
        let share = self.weight / self.layout.phases.len() as f64;
        for (p, phase) in self.layout.phases.iter().enumerate() {
            for interval in 0..phase.intervals {
                let width = phase.width(interval);
                let (even, rate) = (share * EVEN * width, share * RATE.powi(2) * 2.0 / width);
                let [a, m, b] = [0, 1, 2].map(|k| self.layout.torques(p, 2 * interval + k));
                for k in 0..self.layout.joints {
                    let [a, m, b] = [a + k, m + k, b + k];
                    tell([(a, -0.5), (m, 1.0), (b, -0.5), (b, 0.0)], even);
                    tell([(a, -1.0), (m, 1.0), (b, 0.0), (b, 0.0)], rate);
                    tell([(a, 0.0), (m, -1.0), (b, 1.0), (b, 0.0)], rate);
                }
            }
            let of = &self.of.phases[p];
            for (k, unit) in of.output_units.iter().enumerate() {
                let first = phase.coefficients.start + k * of.coefficients;
                let unit = self.similar.position(Measure::of_unit(unit));
                for c in first..(first + of.coefficients).saturating_sub(3) {
                    let weight = CURVED / (unit * unit);
                    tell([(c, -1.0), (c + 1, 3.0), (c + 2, -3.0), (c + 3, 1.0)], weight);
                }
            }
        }
    }

    /// Lean of the base and joints with their places at ease, and what a squared distance from there costs.
    fn each_ease(&self, mut tell: impl FnMut(usize, f64, f64)) {
        let cost = EASE / self.layout.phases.len() as f64;
        for (p, phase) in self.layout.phases.iter().enumerate() {
            for node in 0..phase.nodes() {
                let weight = cost * simpson(phase, node);
                let q = self.layout.motion(p, node, 0);
                for (k, &of) in self.coordinates.iter().enumerate().skip(2) {
                    tell(q + k, self.ease[k], weight / self.similar.position(of).powi(2));
                }
            }
        }
    }

    /// Second derivatives of the cost.
    fn each_cost(&self, x: &[f64], mut tell: impl FnMut([usize; 2], f64)) {
        let (total, squares) = self.squares(x);
        let durations: Vec<usize> = self.layout.phases.iter().map(|phase| phase.duration).collect();
        let all: f64 = durations.iter().zip(&squares).map(|(&d, s)| x[d] * s).sum();
        for (p, &own) in durations.iter().enumerate() {
            self.each_torque(p, |k, weight| {
                tell([k, k], self.weight * 2.0 * weight * x[own] / total);
                for (other, &duration) in durations.iter().enumerate() {
                    let direct = if other == p { 1.0 / total } else { 0.0 };
                    let slope = 2.0 * weight * x[k] * (direct - x[own] / (total * total));
                    tell([k, duration], self.weight * slope);
                }
            });
            for other in 0..=p {
                let mixed = -(squares[p] + squares[other]) / (total * total) + 2.0 * all / total.powi(3);
                tell([own, durations[other]], self.weight * mixed);
            }
        }
        self.each_ease(|k, _, weight| tell([k, k], 2.0 * weight));
        self.each_bend(|terms, weight| {
            for (i, &(first, a)) in terms.iter().enumerate() {
                for &(second, b) in &terms[..=i] {
                    tell([first, second], 2.0 * weight * a * b);
                }
            }
        });
    }
}

/// Simpson's weight of a node; all of a phase add up to 1.
fn simpson(phase: &PhaseLayout, node: usize) -> f64 {
    match node {
        node if node % 2 == 1 => 4.0 / 6.0 * phase.width(node / 2),
        node => {
            let before = if node == 0 { 0.0 } else { phase.width(node / 2 - 1) };
            let after = if node + 1 == phase.nodes() { 0.0 } else { phase.width(node / 2) };
            (before + after) / 6.0
        }
    }
}

fn bend(x: &[f64], terms: [(usize, f64); 4]) -> f64 {
    terms.iter().map(|&(k, factor)| x[k] * factor).sum()
}

impl Program for Transcription<'_> {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.bounds.iter().zip(&self.scale).map(|(b, scale)| b.map(|x| x / scale)).collect()
    }

    fn limits(&self) -> Vec<[f64; 2]> {
        self.rows
            .limits
            .iter()
            .zip(&self.rows.scale)
            .map(|(limits, scale)| limits.map(|x| x / scale))
            .collect()
    }

    fn objective(&self, x: &[f64]) -> f64 {
        let x = self.unscaled(x);
        let (total, squares) = self.squares(&x);
        let all: f64 = self.layout.phases.iter().zip(&squares).map(|(phase, s)| x[phase.duration] * s).sum();
        let mut bends = 0.0;
        self.each_bend(|terms, weight| bends += weight * bend(&x, terms).powi(2));
        self.each_ease(|k, ease, weight| bends += weight * (x[k] - ease).powi(2));
        self.weight * all / total + bends
    }

    fn gradient(&self, x: &[f64], gradient: &mut [f64]) {
        let x = self.unscaled(x);
        gradient.fill(0.0);
        let (total, squares) = self.squares(&x);
        let all: f64 = self.layout.phases.iter().zip(&squares).map(|(phase, s)| x[phase.duration] * s).sum();
        for (p, phase) in self.layout.phases.iter().enumerate() {
            let own = phase.duration;
            gradient[own] = self.weight * (squares[p] / total - all / (total * total));
            self.each_torque(p, |k, weight| {
                gradient[k] += self.weight * 2.0 * weight * x[k] * x[own] / total
            });
        }
        self.each_bend(|terms, weight| {
            let off = bend(&x, terms);
            terms.iter().for_each(|&(k, factor)| gradient[k] += 2.0 * weight * off * factor);
        });
        self.each_ease(|k, ease, weight| gradient[k] += 2.0 * weight * (x[k] - ease));
        gradient.iter_mut().zip(&self.scale).for_each(|(g, scale)| *g *= scale);
    }

    fn constraints(&self, x: &[f64], values: &mut [f64]) {
        let x = self.unscaled(x);
        for part in self.parts() {
            let local: Vec<f64> = part.variables.iter().map(|&k| x[k]).collect();
            let mut found = vec![0.0; part.function.rows()];
            part.function.values(&local, &mut found);
            for (row, value) in part.rows.iter().zip(found) {
                if let Some(row) = *row {
                    values[row] = value;
                }
            }
        }
        self.each_between(|row, duration, linear, slopes| {
            let sum = |terms: [(usize, f64); 3]| terms.iter().map(|&(k, factor)| x[k] * factor).sum::<f64>();
            values[row] = sum(linear) + x[duration] * sum(slopes);
        });
        for (row, terms) in &self.rows.sums {
            values[*row] = terms.iter().map(|&(k, factor)| x[k] * factor).sum();
        }
        values.iter_mut().zip(&self.rows.scale).for_each(|(value, scale)| *value /= scale);
    }

    fn jacobian_structure(&self) -> Vec<[usize; 2]> {
        self.jacobian.clone()
    }

    fn jacobian(&self, x: &[f64], values: &mut [f64]) {
        let x = self.unscaled(x);
        let mut next = 0;
        let mut put = |value: f64| {
            values[next] = value;
            next += 1;
        };
        for part in self.parts() {
            let local: Vec<f64> = part.variables.iter().map(|&k| x[k]).collect();
            let structure = part.function.jacobian_structure();
            let mut found = vec![0.0; structure.len()];
            part.function.jacobian(&local, &mut found);
            let asked = structure.iter().zip(found).filter(|([row, _], _)| part.rows[*row].is_some());
            asked.for_each(|(_, value)| put(value));
        }
        self.each_between(|_, duration, linear, slopes| {
            linear.iter().for_each(|&(_, factor)| put(factor));
            slopes.iter().for_each(|&(_, factor)| put(factor * x[duration]));
            put(slopes.iter().map(|&(k, factor)| x[k] * factor).sum());
        });
        self.rows.sums.iter().flat_map(|(_, terms)| terms).for_each(|&(_, factor)| put(factor));
        for (value, &[row, variable]) in values.iter_mut().zip(&self.jacobian) {
            *value *= self.scale[variable] / self.rows.scale[row];
        }
    }

    fn hessian_structure(&self) -> Vec<[usize; 2]> {
        self.hessian.clone()
    }

    fn hessian(&self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let x = self.unscaled(x);
        let multipliers: Vec<f64> =
            multipliers.iter().zip(&self.rows.scale).map(|(y, scale)| y / scale).collect();
        let mut next = 0;
        let mut put = |value: f64| {
            values[next] = value;
            next += 1;
        };
        for part in self.parts() {
            let local: Vec<f64> = part.variables.iter().map(|&k| x[k]).collect();
            let own: Vec<f64> = part.rows.iter().map(|row| row.map_or(0.0, |row| multipliers[row])).collect();
            let mut found = vec![0.0; part.function.hessian_structure().len()];
            part.function.hessian(&local, &own, &mut found);
            found.into_iter().for_each(&mut put);
        }
        self.each_between(|row, _, _, slopes| {
            slopes.iter().for_each(|&(_, factor)| put(factor * multipliers[row]));
        });
        self.each_cost(&x, |_, value| put(weight * value));
        for (value, &[i, j]) in values.iter_mut().zip(&self.hessian) {
            *value *= self.scale[i] * self.scale[j];
        }
    }
}
