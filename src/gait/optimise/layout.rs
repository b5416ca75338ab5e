//! Where everything stands among the variables of the program.
use bipedc_compiler::compile::{Collocation, CollocationPhase};
use std::ops::Range;

/// Places of the variables: by phase its duration, φ at its ends, coefficients, nodes, then the impulses of the change behind it.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub phases: Vec<PhaseLayout>,
    pub variables: usize,
    pub nv: usize,
    pub joints: usize,
}

#[derive(Debug, Clone)]
pub(super) struct PhaseLayout {
    /// Of the duration; φ at both ends follows.
    pub duration: usize,
    pub coefficients: Range<usize>,
    /// Of the first node.
    first: usize,
    /// Variables of a node.
    size: usize,
    /// Intervals; each has a node in its middle.
    pub intervals: usize,
    /// Their ends, as parts of the phase: 0 to 1.
    grid: Vec<f64>,
    pub forces: usize,
    pub impulses: Range<usize>,
}

impl PhaseLayout {
    pub fn nodes(&self) -> usize {
        2 * self.intervals + 1
    }
    /// Part of the phase that is over at a node.
    pub fn part(&self, node: usize) -> f64 {
        0.5 * (self.grid[node / 2] + self.grid[node.div_ceil(2)])
    }
    /// Part of the phase that an interval takes.
    pub fn width(&self, interval: usize) -> f64 {
        self.grid[interval + 1] - self.grid[interval]
    }
    pub fn ends(&self) -> [usize; 2] {
        [self.duration + 1, self.duration + 2]
    }
}

/// Of how much shorter intervals at the ends of a phase are than even ones.
const GRADING: f64 = 0.25;

/// A place of an even grid on one that is finer towards both ends.
fn graded(even: f64) -> f64 {
    let grading = GRADING;
    even - grading * (std::f64::consts::TAU * even).sin() / std::f64::consts::TAU
}

impl Layout {
    pub fn new(of: &Collocation, intervals: &[usize]) -> Self {
        let (nv, joints) = (of.tree.nv, of.tree.joints.len());
        let mut next = 0;
        let mut take = |count: usize| {
            next += count;
            next - count..next
        };
        let phase = |(phase, change, &intervals): (&CollocationPhase, usize, &usize)| {
            let duration = take(3).start;
            let coefficients = take(phase.outputs.len() * phase.coefficients);
            let (forces, nodes) = (phase.forces.len(), 2 * intervals + 1);
            let size = 3 * nv + joints + forces;
            let first = take(nodes * size).start;
            let impulses = take(change);
            let grid = (0..=intervals).map(|k| graded(k as f64 / intervals as f64)).collect();
            PhaseLayout { duration, coefficients, first, size, intervals, grid, forces, impulses }
        };
        let changes = of.changes.iter().map(|change| change.impulses.len());
        let each = of.phases.iter().zip(changes).zip(intervals).map(|((a, b), c)| (a, b, c));
        let phases = each.map(phase).collect();
        Self { phases, variables: next, nv, joints }
    }

    /// Of q, v or a (order 0, 1, 2) at a node.
    pub fn motion(&self, phase: usize, node: usize, order: usize) -> usize {
        let of = &self.phases[phase];
        of.first + node * of.size + order * self.nv
    }
    pub fn torques(&self, phase: usize, node: usize) -> usize {
        self.motion(phase, node, 3)
    }
    pub fn forces(&self, phase: usize, node: usize) -> usize {
        self.torques(phase, node) + self.joints
    }
    /// The variables of a node's function, in its order.
    pub fn node(&self, phase: usize, node: usize) -> Vec<usize> {
        let of = &self.phases[phase];
        let motion = self.motion(phase, node, 0);
        let torques = self.torques(phase, node);
        (motion..motion + 3 * self.nv)
            .chain(of.ends())
            .chain(torques..torques + self.joints + of.forces)
            .chain(of.coefficients.clone())
            .collect()
    }
    /// The variables of the function of the change behind a phase, in its order.
    pub fn change(&self, phase: usize) -> Vec<usize> {
        let of = &self.phases[phase];
        let before = self.motion(phase, of.nodes() - 1, 0);
        let after = self.motion((phase + 1) % self.phases.len(), 0, 0);
        let both = before..before + 2 * self.nv;
        both.chain(after..after + 2 * self.nv).chain(of.impulses.clone()).collect()
    }
}
