//! Who carries what the contact laws leave open.
//!
//! Four corners of a flat sole can share a load in infinitely many ways, and so can sticking points share what pulls along the
//! ground; where the sole slides and turns, the motion itself depends on it. Real corners give way a little: with springs of
//! equal stiffness below all of them, however stiff, loads have the least sum of squares among those that do the same to the
//! robot, and no corner is pulled or holds more than its friction. So very stiff ones are put into every contact problem, and
//! taken out again when they have chosen.
use super::newton::{NEAR, NEARNESS};
use super::problem::{Block, Law, Problem};
use super::proximal::{STEADY, Solved, Solver, Tolerance, residual, residual_at_hand};
use std::ops::Range;

/// Softness of the springs, as a part of the least velocity per impulse of a contact's row.
const SOFTNESS: f64 = 5e-9;

/// The same of rows of joints, each of its own size: what feet and joints can share is left to the joints.
const BESIDE: f64 = 1e-13;

/// The residual with springs below which loads are shared to 1e-6 or so: loads that are shared wrongly by all of themselves
/// are seen in it as [`SOFTNESS`].
const SHARED: f64 = 1e-14;

/// A change of the impulses that sensors do not see, as a part of the largest.
const UNSEEN: f64 = 1e-6;

/// Whole Newton steps that are tried: one where no contact changes between sticking, slipping and letting go.
const LEAPS: usize = 8;

/// Springs in a problem, and what is remembered of the last one.
#[derive(Debug, Clone, Default)]
pub(super) struct Springs {
    /// The diagonal without them.
    hard: Vec<f64>,
    /// The last impulses known to be shared, of these blocks.
    shared: Vec<f64>,
    blocks: Vec<Block>,
}

impl Springs {
    pub fn with_room(rows: usize) -> Self {
        let room = || Vec::with_capacity(rows);
        Self { hard: room(), shared: room(), blocks: Vec::with_capacity(rows) }
    }

    /// Equal ones in all rows of contacts; false: nothing touches.
    pub fn put_into(&mut self, problem: &mut Problem) -> bool {
        let n = problem.rows();
        self.hard.clear();
        self.hard.extend((0..n).map(|row| problem.row(row)[row]));
        let own = problem.blocks.iter().flat_map(rows_of_contact).map(|row| self.hard[row]);
        let least = own.filter(|own| *own > 0.0).fold(f64::INFINITY, f64::min);
        if least == f64::INFINITY {
            return false;
        }
        for (row, hard) in self.hard.iter().enumerate() {
            *problem.diagonal_mut(row) += BESIDE * hard;
        }
        for block in 0..problem.blocks.len() {
            for row in rows_of_contact(&problem.blocks[block]) {
                *problem.diagonal_mut(row) = self.hard[row] + SOFTNESS * least;
            }
        }
        true
    }

    /// Takes them out of `problem.velocity` too.
    pub fn take_out_of(&self, problem: &mut Problem) {
        for (row, hard) in self.hard.iter().enumerate() {
            let diagonal = problem.diagonal_mut(row);
            let spring = *diagonal - hard;
            *diagonal = *hard;
            problem.velocity[row] -= spring * problem.impulse[row];
        }
    }

    /// What can be asked of a problem with springs before its loads are shared.
    pub fn tolerance(&self, wanted: &Tolerance) -> Tolerance {
        Tolerance { relative: wanted.relative.max(2.0 * SOFTNESS), ..*wanted }
    }

    /// Whether these impulses are the shared ones of the step before, but for what is not seen.
    fn known(&self, problem: &Problem) -> bool {
        self.blocks == problem.blocks
            && self.shared.len() == problem.rows()
            && apart(&self.shared, &problem.impulse) <= UNSEEN * largest(&problem.impulse)
    }

    fn remember(&mut self, problem: &Problem) {
        self.shared.clear();
        self.shared.extend_from_slice(&problem.impulse);
        self.blocks.clear();
        self.blocks.extend_from_slice(&problem.blocks);
    }
}

/// Rows of forces on contact points; of a sole that turns its normal rows, and friction in its middle.
fn rows_of_contact(block: &Block) -> Range<usize> {
    match block.law {
        Law::Contact { .. } => block.first..block.first + block.size(),
        Law::Sole { normals, .. } => block.first - normals..block.first + 2,
        Law::Unilateral | Law::Limited { .. } => 0..0,
    }
}

impl Solver {
    /// From a solution to the one that is shared, by whole Newton steps on the problem with springs; back if they do not
    /// arrive.
    pub(super) fn share(&mut self, problem: &mut Problem, solved: &mut Solved) {
        if problem.blocks.len() < 2 || solved.residual == 0.0 || self.springs.known(problem) {
            return;
        }
        self.start.clear();
        self.start.extend_from_slice(&problem.impulse);
        for _ in 0..LEAPS {
            if solved.residual <= SHARED {
                return self.springs.remember(problem);
            }
            // The matrix at hand does while nothing changes between sticking, slipping and letting go.
            let found = match self.newton.refine(problem, STEADY * solved.residual) {
                Some(found) => found,
                None if solved.residual <= SOFTNESS && self.still(problem) => {
                    return self.springs.remember(problem);
                }
                None => {
                    solved.newton += 1;
                    let Some(found) = self.newton.leap(problem, NEARNESS[0]) else { break };
                    found
                }
            };
            solved.residual = found;
            if found <= SOFTNESS && self.still(problem) {
                return self.springs.remember(problem);
            }
        }
        problem.impulse.copy_from_slice(&self.start);
        residual(problem);
    }

    /// Whether the last Newton step changed nothing that is seen.
    fn still(&self, problem: &Problem) -> bool {
        self.newton.change() <= UNSEEN * largest(&problem.impulse)
    }

    /// The nearest solution without springs, so that nothing creeps on them: one step with the matrix at hand, more if little is
    /// tolerated.
    pub(super) fn without_springs(
        &mut self,
        problem: &mut Problem,
        tolerance: &Tolerance,
        solved: &mut Solved,
    ) {
        // Sweeps that did not arrive leave velocities of other impulses.
        solved.residual = if solved.converged { residual_at_hand(problem) } else { residual(problem) };
        if let Some(smaller) = self.newton.refine(problem, solved.residual) {
            solved.residual = smaller;
        }
        if solved.converged && solved.residual > tolerance.relative {
            self.finish(problem, tolerance, NEAR, solved);
            if solved.residual > tolerance.relative {
                self.arrive(problem, tolerance, NEAR, solved);
            }
        }
        solved.converged = solved.residual <= tolerance.relative;
    }
}

fn largest(impulses: &[f64]) -> f64 {
    impulses.iter().fold(0.0, |largest, impulse| largest.max(impulse.abs()))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}
