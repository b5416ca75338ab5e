//! The cost of a motion: its torques, and what keeps it smooth and near rest.
use super::demands::{Demands, Objective};
use super::guess::ease;
use super::layout::{Layout, PhaseLayout};
use super::similarity::{Measure, Similarity};
use bipedc_compiler::compile::Collocation;

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

/// What a joint, or the lean of the base, off its place at ease costs, per rad² (or m², of a robot 0.7 m high).
const EASE: f64 = 1.0;

/// What a cost of transport of 1 costs.
const TRANSPORT: f64 = 5.0;

/// Power at which a joint's \|τ q̇\| is rounded off, over weight and speed shared among the joints: \|p\| is taken as √(p² + w²) − w, at most w less.
const WIDTH: f64 = 0.02;

/// What squared torques cost beside the cost of transport, of what they cost alone: where joints stand still, power does not settle torques.
const BESIDE: f64 = 0.05;

/// Power of the joints as a cost.
#[derive(Debug, Clone, Copy)]
struct Power {
    /// What a W costs, as a squared torque does, (N m)²/W.
    factor: f64,
    /// W
    width: f64,
}

impl Power {
    /// √(p² + w²) − w with its first and second derivative.
    fn smooth(self, p: f64) -> [f64; 3] {
        let root = p.hypot(self.width);
        [root - self.width, p / root, (self.width / root).powi(2) / root]
    }
}

/// The cost with its first and second derivatives, by variables in their units.
pub(super) struct Cost<'c> {
    of: &'c Collocation,
    /// What a squared torque costs, 1/(N m)².
    weight: f64,
    /// What squared torques count beside other costs.
    torques: f64,
    power: Option<Power>,
    similar: Similarity,
    coordinates: Vec<Measure>,
    /// Coordinates at ease.
    ease: Vec<f64>,
}

impl<'c> Cost<'c> {
    pub fn new(of: &'c Collocation, similar: Similarity, demands: &Demands) -> Self {
        let weight = (0.05 * of.mass * super::gravity(of) * similar.length).powi(-2);
        let transport = demands.objective == Objective::Transport;
        // Weight and speed are the power that a cost of transport of 1 takes.
        let whole = super::gravity(of) * of.mass * demands.speed;
        let width = WIDTH * whole / of.tree.joints.len() as f64;
        Self {
            of,
            weight,
            torques: if transport { BESIDE } else { 1.0 },
            power: transport.then_some(Power { factor: TRANSPORT / (whole * weight), width }),
            similar,
            coordinates: Measure::of_coordinates(of),
            ease: ease(of),
        }
    }

    pub fn value(&self, layout: &Layout, x: &[f64]) -> f64 {
        let (total, squares) = self.squares(layout, x);
        let all = integral(layout, x, &squares);
        let mut bends = 0.0;
        self.each_bend(layout, |terms, weight| bends += weight * bend(x, terms).powi(2));
        self.each_ease(layout, |k, ease, weight| bends += weight * (x[k] - ease).powi(2));
        self.weight * all / total + bends
    }

    pub fn gradient(&self, layout: &Layout, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        let (total, squares) = self.squares(layout, x);
        let all = integral(layout, x, &squares);
        for (p, phase) in layout.phases.iter().enumerate() {
            let own = phase.duration;
            gradient[own] = self.weight * (squares[p] / total - all / (total * total));
            self.each_torque(layout, p, |k, weight| {
                gradient[k] += self.weight * 2.0 * weight * x[k] * x[own] / total
            });
            self.each_power(layout, p, |[torque, speed], weight, power| {
                let [_, slope, _] = power.smooth(x[torque] * x[speed]);
                let slope = self.weight * weight * slope * x[own] / total;
                gradient[torque] += slope * x[speed];
                gradient[speed] += slope * x[torque];
            });
        }
        self.each_bend(layout, |terms, weight| {
            let off = bend(x, terms);
            terms.iter().for_each(|&(k, factor)| gradient[k] += 2.0 * weight * off * factor);
        });
        self.each_ease(layout, |k, ease, weight| gradient[k] += 2.0 * weight * (x[k] - ease));
    }

    /// Second derivatives of the cost.
    pub fn each_second(&self, layout: &Layout, x: &[f64], mut tell: impl FnMut([usize; 2], f64)) {
        let (total, squares) = self.squares(layout, x);
        let durations: Vec<usize> = layout.phases.iter().map(|phase| phase.duration).collect();
        let all = integral(layout, x, &squares);
        for (p, &own) in durations.iter().enumerate() {
            self.each_torque(layout, p, |k, weight| {
                tell([k, k], self.weight * 2.0 * weight * x[own] / total);
                for (other, &duration) in durations.iter().enumerate() {
                    let direct = if other == p { 1.0 / total } else { 0.0 };
                    let slope = 2.0 * weight * x[k] * (direct - x[own] / (total * total));
                    tell([k, duration], self.weight * slope);
                }
            });
            self.each_power(layout, p, |[torque, speed], weight, power| {
                let [_, slope, bent] = power.smooth(x[torque] * x[speed]).map(|f| self.weight * weight * f);
                let part = x[own] / total;
                tell([torque, torque], part * bent * x[speed] * x[speed]);
                tell([speed, speed], part * bent * x[torque] * x[torque]);
                tell([torque, speed], part * (bent * x[torque] * x[speed] + slope));
                for (other, &duration) in durations.iter().enumerate() {
                    let direct = if other == p { 1.0 / total } else { 0.0 };
                    let by = slope * (direct - x[own] / (total * total));
                    tell([torque, duration], by * x[speed]);
                    tell([speed, duration], by * x[torque]);
                }
            });
            for other in 0..=p {
                let mixed = -(squares[p] + squares[other]) / (total * total) + 2.0 * all / total.powi(3);
                tell([own, durations[other]], self.weight * mixed);
            }
        }
        self.each_ease(layout, |k, _, weight| tell([k, k], 2.0 * weight));
        self.each_bend(layout, |terms, weight| {
            for (i, &(first, a)) in terms.iter().enumerate() {
                for &(second, b) in &terms[..=i] {
                    tell([first, second], 2.0 * weight * a * b);
                }
            }
        });
    }

    /// Durations, and ∫ τ² dt by phase over its duration, with what power costs.
    fn squares(&self, layout: &Layout, x: &[f64]) -> (f64, Vec<f64>) {
        let total = layout.phases.iter().map(|phase| x[phase.duration]).sum();
        let of = |p: usize| {
            let mut sum = 0.0;
            self.each_torque(layout, p, |k, weight| sum += weight * x[k] * x[k]);
            self.each_power(layout, p, |[torque, speed], weight, power| {
                sum += weight * power.smooth(x[torque] * x[speed])[0];
            });
            sum
        };
        (total, (0..layout.phases.len()).map(of).collect())
    }

    /// Torques of a phase with their weights (Simpson), and accelerations with theirs.
    fn each_torque(&self, layout: &Layout, p: usize, mut tell: impl FnMut(usize, f64)) {
        let phase = &layout.phases[p];
        let smooth = SMOOTH * self.of.mass * self.of.mass;
        for node in 0..phase.nodes() {
            let weight = simpson(phase, node);
            let torques = layout.torques(p, node);
            (torques..torques + layout.joints).for_each(|k| tell(k, self.torques * weight));
            let accelerations = layout.motion(p, node, 2);
            for (k, &of) in self.coordinates.iter().enumerate() {
                // A torque over an acceleration, over the mass.
                let unit = self.similar.length * self.similar.gravity / self.similar.acceleration(of);
                tell(accelerations + k, smooth * unit * unit * weight);
            }
        }
    }

    /// Torque and velocity of each joint at each node of a phase, with the weight of their power.
    fn each_power(&self, layout: &Layout, p: usize, mut tell: impl FnMut([usize; 2], f64, Power)) {
        let Some(power) = self.power else { return };
        let phase = &layout.phases[p];
        for node in 0..phase.nodes() {
            let (torques, velocities) = (layout.torques(p, node), layout.motion(p, node, 1));
            for (k, joint) in self.of.tree.joints.iter().enumerate() {
                let weight = power.factor * simpson(phase, node);
                tell([torques + k, velocities + joint.v_index], weight, power);
            }
        }
    }

    /// Sums whose squares cost something, with their weights: of torques in each interval what is off a straight line, and their rates; of coefficients the third
    /// differences.
    fn each_bend(&self, layout: &Layout, mut tell: impl FnMut([(usize, f64); 4], f64)) {
        let share = self.weight / layout.phases.len() as f64;
        for (p, phase) in layout.phases.iter().enumerate() {
            for interval in 0..phase.intervals {
                let width = phase.width(interval);
                let (even, rate) = (share * EVEN * width, share * RATE.powi(2) * 2.0 / width);
                let [a, m, b] = [0, 1, 2].map(|k| layout.torques(p, 2 * interval + k));
                for k in 0..layout.joints {
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
    fn each_ease(&self, layout: &Layout, mut tell: impl FnMut(usize, f64, f64)) {
        let cost = EASE / layout.phases.len() as f64;
        for (p, phase) in layout.phases.iter().enumerate() {
            for node in 0..phase.nodes() {
                let weight = cost * simpson(phase, node);
                let q = layout.motion(p, node, 0);
                for (k, &of) in self.coordinates.iter().enumerate().skip(2) {
                    tell(q + k, self.ease[k], weight / self.similar.position(of).powi(2));
                }
            }
        }
    }
}

/// ∫ Σ \|τ q̇\| dt over the step, J.
pub(super) fn work(of: &Collocation, layout: &Layout, x: &[f64]) -> f64 {
    let at = |p: usize, node: usize| -> f64 {
        let (torques, velocities) = (layout.torques(p, node), layout.motion(p, node, 1));
        let power = |(k, v_index): (usize, usize)| (x[torques + k] * x[velocities + v_index]).abs();
        of.tree.joints.iter().map(|joint| joint.v_index).enumerate().map(power).sum()
    };
    let mean = |(p, phase): (usize, &PhaseLayout)| -> f64 {
        let nodes = (0..phase.nodes()).map(|node| simpson(phase, node) * at(p, node));
        x[phase.duration] * nodes.sum::<f64>()
    };
    layout.phases.iter().enumerate().map(mean).sum()
}

/// ∫ τ² dt over the step, from its mean over each phase.
fn integral(layout: &Layout, x: &[f64], squares: &[f64]) -> f64 {
    layout.phases.iter().zip(squares).map(|(phase, s)| x[phase.duration] * s).sum()
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
