//! Where a search begins that knows nothing: feet on straight lines, the trunk upright above them, no torques.
use super::landing::{LandingPosture, relabelled};
use super::layout::Layout;
use super::similarity::{Measure, Similarity};
use super::{gravity, weight};
use bipedc_compiler::compile::{Collocation, NodeRow};
use bipedc_compiler::description::gait::knees;
use nalgebra::{DMatrix, DVector};

/// A first guess of all variables, in their units.
pub(super) struct Guess {
    pub x: Vec<f64>,
    /// Parts of the step that the phases take.
    pub parts: Vec<f64>,
    /// Mean rate of each phase variable.
    pub rates: Vec<f64>,
    /// Height of the base at ease, m.
    pub height: f64,
}

/// Part of the base's height that a step has.
const STEP: f64 = 0.45;
/// The same where a search has several beginnings, in this order: robots with feet have many minima, and which one is found depends mostly on the first step.
const STEPS: [f64; MOST_BEGINNINGS] = [STEP, 0.35, 0.25, 0.6, 0.75, 0.3];
/// Beginnings at most.
pub const MOST_BEGINNINGS: usize = 6;
/// The longest that a step takes, over the time √(h/g) of a pendulum as high as the base.
const LONGEST: f64 = 4.0;
/// How far joints begin from their limits and knees from being straight, rad.
const BENT: f64 = 0.3;

struct Postures<'a> {
    of: &'a Collocation,
    layout: &'a Layout,
    /// Joints at ease.
    ease: Vec<f64>,
}

/// Feet by index: x of their middle, and height.
type Feet = Vec<[f64; 2]>;

/// Without any knowledge but the robot's; `beginning` counts the lengths of steps that are tried.
pub(super) fn naive(of: &Collocation, layout: &Layout, speed: f64, beginning: usize) -> Guess {
    around(of, layout, (speed, first_step(of, speed, beginning)), None)
}

/// Length of the steps of a beginning, m.
pub(super) fn first_step(of: &Collocation, speed: f64, beginning: usize) -> f64 {
    let height = height(of);
    STEPS[beginning % STEPS.len()] * shortness(speed, height, gravity(of)) * height
}

/// With steps of this length, m, or with this posture where it belongs, and steps as long as its.
pub(super) fn around(
    of: &Collocation,
    layout: &Layout,
    (speed, step): (f64, f64),
    landing: Option<&LandingPosture>,
) -> Guess {
    let postures = Postures { of, layout, ease: ease(of) };
    let count = of.phases.len();
    let parts = parts(count);
    let short = shortness(speed, postures.height(), gravity(of));
    let step = landing.map_or(step, |landing| landing.step);
    let similar = Similarity::new(of, postures.height());
    let duration = step / speed;
    let mut x = vec![0.0; layout.variables];
    let mut rates = Vec::new();
    let (mut time, mut feet) = (0.0, postures.first_feet(step));
    let mut landed: Option<Vec<f64>> = None;
    for (p, &part) in parts.iter().enumerate() {
        let phase = &layout.phases[p];
        x[phase.duration] = duration * part;
        let end = postures.moved(&feet, p, step);
        let usual = postures.posture(p, &feet, (time - 0.5) * step);
        let from = landed.take().unwrap_or(usual);
        let mut to = postures.posture(p, &end, (time + part - 0.5) * step);
        if let Some(landing) = landing.filter(|landing| landing.phase == p) {
            to = postures.placed(p, &landing.q, &end);
            landed = Some(relabelled(of, p, &to));
        }
        postures.line(&mut x, p, [&from, &to]);
        let ends = [0, 2 * phase.intervals].map(|node| postures.row(p, &x, node, NodeRow::Phase));
        let least = 0.02 * short * similar.position(Measure::of_unit(&of.phases[p].unit));
        let apart = if (ends[1] - ends[0]).abs() < least { least } else { ends[1] - ends[0] };
        [x[phase.ends()[0]], x[phase.ends()[1]]] = [ends[0], ends[0] + apart];
        rates.push(apart / x[phase.duration]);
        postures.coefficients(&mut x, p);
        time += part;
        feet = end;
        if of.changes[p].relabel {
            feet.swap(0, 1);
        }
    }
    Guess { x, parts, rates, height: postures.height() }
}

/// Height of the base above the ground with the joints at ease, m.
pub(super) fn height(of: &Collocation) -> f64 {
    let layout = Layout::new(of, &vec![1; of.phases.len()]);
    Postures { of, layout: &layout, ease: ease(of) }.height()
}

/// How much shorter steps of slow walks are than others, 1 at usual speeds: who walks slowly takes short steps, for a step that lasts much longer than it takes to
/// fall over is none. Searches that began with long steps took ten times as long and found nothing.
pub(super) fn shortness(speed: f64, height: f64, gravity: f64) -> f64 {
    (speed * LONGEST * (height / gravity).sqrt() / (STEP * height)).min(1.0)
}

/// Parts of a step that its phases take: the first as much as three others.
pub(super) fn parts(count: usize) -> Vec<f64> {
    match count {
        1 => vec![1.0],
        _ => (0..count).map(|p| if p == 0 { 3.0 } else { 1.0 } / (count as f64 + 2.0)).collect(),
    }
}

/// Positions of the joints away from their limits.
pub(super) fn ease(of: &Collocation) -> Vec<f64> {
    let mut q = vec![0.0; of.tree.nq];
    for joint in &of.tree.joints {
        let named = of.description.joints.iter().find(|other| other.name == joint.name);
        if let Some((low, high)) = named.and_then(|joint| joint.position_limits) {
            let away = BENT.min(0.4 * (high - low));
            q[joint.v_index] = 0.0f64.clamp(low + away, high - away);
        }
    }
    // Straight legs bend either way, two of them not always the same one, and no walk goes on from there.
    for (name, way) in knees(&of.description) {
        let Some(joint) = of.tree.joints.iter().find(|joint| joint.name == name) else { continue };
        let named = of.description.joints.iter().find(|other| other.name == name);
        if q[joint.v_index] == 0.0 {
            let (low, high) = named.and_then(|joint| joint.position_limits).unwrap_or((-3.2, 3.2));
            let away = BENT.min(0.4 * (high - low));
            q[joint.v_index] = (way * BENT).clamp(low + away, high - away);
        }
    }
    q
}

impl Postures<'_> {
    fn foot_points(&self, foot: usize) -> Vec<usize> {
        let name = &self.of.description.feet[foot].name;
        let own = |point: &bipedc_compiler::tree::Frame| point.name.split('/').next() == Some(name);
        (0..self.of.tree.points.len()).filter(|&k| own(&self.of.tree.points[k])).collect()
    }

    fn stands(&self, p: usize, foot: usize) -> bool {
        self.foot_points(foot).iter().any(|point| self.of.phases[p].standing.contains(point))
    }

    /// Rows of a kind at a posture, with their slopes by q.
    fn rows(&self, p: usize, q: &[f64], kind: NodeRow) -> (DVector<f64>, DMatrix<f64>) {
        let of = &self.of.phases[p];
        let mut x = vec![0.0; of.node.variables()];
        x[..q.len()].copy_from_slice(q);
        x[3 * self.layout.nv + 1] = 1.0;
        let mut values = vec![0.0; of.node.rows()];
        of.node.values(&x, &mut values);
        let mut slopes = vec![0.0; of.node.jacobian_structure().len()];
        of.node.jacobian(&x, &mut slopes);
        let (first, count) =
            of.rows.iter().find(|row| row.0 == kind).map_or((0, 0), |&(_, first, count)| (first, count));
        let mut jacobian = DMatrix::zeros(count, q.len());
        for (&[row, variable], slope) in of.node.jacobian_structure().iter().zip(slopes) {
            if (first..first + count).contains(&row) && variable < q.len() {
                jacobian[(row - first, variable)] = slope;
            }
        }
        (DVector::from_column_slice(&values[first..first + count]), jacobian)
    }

    /// The first row of a kind at a node.
    fn row(&self, p: usize, x: &[f64], node: usize, kind: NodeRow) -> f64 {
        let q = self.layout.motion(p, node, 0);
        self.rows(p, &x[q..q + self.layout.nv], kind).0[0]
    }

    /// Height of the base above the ground.
    fn height(&self) -> f64 {
        let heights = self.rows(0, &self.ease, NodeRow::Height).0;
        -heights.min()
    }

    fn first_feet(&self, step: f64) -> Feet {
        (0..self.of.description.feet.len())
            .map(|foot| if self.stands(0, foot) { [0.0, 0.0] } else { [-step, 0.0] })
            .collect()
    }

    /// Where feet are at the end of a phase: those in the air go their part of the way.
    fn moved(&self, feet: &Feet, p: usize, step: f64) -> Feet {
        let count = self.of.phases.len();
        let flights: Vec<usize> =
            (0..count).filter(|&p| (0..feet.len()).any(|foot| !self.stands(p, foot))).collect();
        let rest = flights.iter().filter(|&&other| other >= p).count().max(1);
        let standing = (0..feet.len()).find(|&foot| self.stands(p, foot)).map_or(0.0, |foot| feet[foot][0]);
        let moved = |foot: usize| match self.stands(p, foot) {
            true => feet[foot],
            false => {
                let goal = standing + step;
                let part = if p == 0 && rest > 1 { 0.75 } else { 1.0 / rest as f64 };
                [feet[foot][0] + (goal - feet[foot][0]) * part, 0.0]
            }
        };
        (0..feet.len()).map(moved).collect()
    }

    /// A posture with the feet flat at these places and the base here, near that at ease. Lengths count as parts of the robot's height.
    fn posture(&self, p: usize, feet: &Feet, base: f64) -> Vec<f64> {
        let mut q = self.ease.clone();
        let large = 1.0 / Similarity::new(self.of, self.height()).length;
        (q[0], q[1]) = (base, self.height() * 0.97);
        for _ in 0..30 {
            let (heights, of_heights) = self.rows(p, &q, NodeRow::Height);
            let (places, of_places) = self.rows(p, &q, NodeRow::Place);
            let mut rows: Vec<(f64, Vec<f64>)> = Vec::new();
            let mut ask = |weight: f64, wrong: f64, slope: Vec<f64>| {
                rows.push((weight * wrong, slope.into_iter().map(|x| weight * x).collect()));
            };
            for (foot, at) in feet.iter().enumerate() {
                let points = self.foot_points(foot);
                let share = 1.0 / points.len().max(1) as f64;
                let mut middle = (0.0, vec![0.0; q.len()]);
                for &point in &points {
                    let row = |m: &DMatrix<f64>| m.row(point).iter().copied().collect::<Vec<f64>>();
                    ask(large, at[1] - heights[point], row(&of_heights));
                    middle.0 += share * places[point];
                    middle.1.iter_mut().zip(row(&of_places)).for_each(|(sum, x)| *sum += share * x);
                }
                ask(large, at[0] - middle.0, middle.1);
            }
            let unit = |k: usize| (0..q.len()).map(|j| if j == k { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
            ask(large, base - q[0], unit(0));
            ask(1.0, -q[2], unit(2));
            // Ways back to ease count little.
            for (k, (ease, q)) in self.ease.iter().zip(&q).enumerate().skip(3) {
                ask(0.03, ease - q, unit(k));
            }
            ask(0.1 * large, self.height() * 0.97 - q[1], unit(1));
            let matrix = DMatrix::from_fn(rows.len(), q.len(), |i, j| rows[i].1[j]);
            let wrong = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.0));
            let normal = matrix.transpose() * &matrix + DMatrix::identity(q.len(), q.len()) * 1e-6;
            let Some(step) = normal.lu().solve(&(matrix.transpose() * wrong)) else { break };
            let length = step.amax();
            let part = if length > 0.3 { 0.3 / length } else { 1.0 };
            q.iter_mut().zip(step.iter()).for_each(|(q, d)| *q += part * d);
            if length < 1e-6 {
                break;
            }
        }
        q
    }

    /// A posture moved along the ground until the middle of the feet is where it is to be.
    fn placed(&self, p: usize, q: &[f64], feet: &Feet) -> Vec<f64> {
        let places = self.rows(p, q, NodeRow::Place).0;
        let points: Vec<usize> = (0..feet.len()).flat_map(|foot| self.foot_points(foot)).collect();
        let now = points.iter().map(|&point| places[point]).sum::<f64>() / points.len().max(1) as f64;
        let wanted = feet.iter().map(|foot| foot[0]).sum::<f64>() / feet.len().max(1) as f64;
        let mut moved = q.to_vec();
        moved[0] += wanted - now;
        moved
    }

    /// A straight line between two postures.
    fn line(&self, x: &mut [f64], p: usize, [from, to]: [&[f64]; 2]) {
        let phase = &self.layout.phases[p];
        for node in 0..phase.nodes() {
            let part = phase.part(node);
            let [q, v] = [0, 1].map(|order| self.layout.motion(p, node, order));
            for k in 0..self.layout.nv {
                x[q + k] = from[k] + part * (to[k] - from[k]);
                x[v + k] = (to[k] - from[k]) / x[phase.duration];
            }
        }
        weights(self.of, self.layout, x, p);
    }

    /// Coefficients that fit the outputs along the nodes best.
    pub fn coefficients(&self, x: &mut [f64], p: usize) {
        fit(self.of, self.layout, x, p);
    }
}

/// Equal parts of the weight on each foot that stands, and a little of it as impulse on each that is hit.
pub(super) fn weights(of: &Collocation, layout: &Layout, x: &mut [f64], p: usize) {
    let phase = &layout.phases[p];
    let feet = of.phases[p].feet.iter().flatten().count().max(1) as f64;
    let time = Similarity::new(of, height(of)).time();
    for node in 0..phase.nodes() {
        for foot in of.phases[p].feet.iter().flatten() {
            x[layout.forces(p, node) + foot.force[1]] = weight(of) / feet;
        }
    }
    for foot in of.changes[p].feet.iter().flatten() {
        x[phase.impulses.start + foot.force[1]] = 0.02 * weight(of) * time;
    }
}

/// Fits the coefficients of a phase to what its nodes do (least squares).
pub(super) fn fit(of: &Collocation, layout: &Layout, x: &mut [f64], p: usize) {
    let (phase, of_phase) = (&layout.phases[p], &of.phases[p]);
    let (outputs, count) = (of_phase.outputs.len(), of_phase.coefficients);
    x[phase.coefficients.clone()].fill(0.0);
    let place = |kind: NodeRow| of_phase.rows.iter().find(|row| row.0 == kind).map_or(0, |row| row.1);
    let [first, last] = phase.ends().map(|k| x[k]);
    let mut basis = DMatrix::zeros(phase.nodes(), count);
    let mut wanted = DMatrix::zeros(phase.nodes(), outputs);
    for node in 0..phase.nodes() {
        let local: Vec<f64> = layout.node(p, node).iter().map(|&k| x[k]).collect();
        let mut values = vec![0.0; of_phase.node.rows()];
        of_phase.node.values(&local, &mut values);
        let s = (values[place(NodeRow::Phase)] - first) / (last - first);
        let mut binomial = 1.0;
        for k in 0..count {
            basis[(node, k)] = binomial * s.powi(k as i32) * (1.0 - s).powi((count - 1 - k) as i32);
            binomial = binomial * (count - 1 - k) as f64 / (k + 1) as f64;
        }
        for k in 0..outputs {
            wanted[(node, k)] = values[place(NodeRow::Output) + k];
        }
    }
    let normal = basis.transpose() * &basis + DMatrix::identity(count, count) * 1e-9;
    if let Some(found) = normal.lu().solve(&(basis.transpose() * wanted)) {
        for output in 0..outputs {
            for k in 0..count {
                x[phase.coefficients.start + output * count + k] = found[(k, output)];
            }
        }
    }
}
