//! One semismooth Newton step on `λ = prox(λ − r ξ(λ))`.
mod arrange;
mod equations;

use super::dense::row_length;
use super::problem::{Law, Problem};
use super::proximal::residual;
use arrange::Arrangement;
use equations::Factors;

/// Added to the scaled rows `r ξ = 0`, whose diagonal is 1, for the solution nearest to the present one. The first leaves the
/// choice to the springs of `sharing`; larger ones make shorter steps, which arrive where many contacts are about to change
/// between sticking, slipping and letting go.
pub(super) const NEARNESS: [f64; 4] = [1e-14, 1e-6, 1e-4, 1e-2];

/// The first one where no springs share the load.
pub(super) const NEAR: f64 = 1e-9;

/// Step lengths that are tried.
const LENGTHS: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];

/// Workspace. What is kept by row has all rows of the problem.
#[derive(Debug, Clone, Default)]
pub(super) struct Newton {
    /// By row: whether it is not simply zero.
    active: Vec<bool>,
    /// Rows of open contacts whose impulses are not zero yet.
    opening: Vec<usize>,
    arrangement: Arrangement,
    /// By row, of its equation.
    right: Vec<f64>,
    /// By row.
    step: Vec<f64>,
    /// Coefficients of the unknowns.
    matrix: Vec<f64>,
    /// Row exchanges of an elimination.
    order: Vec<usize>,
    factors: Factors,
    /// Coefficients of one equation by row.
    row: Vec<f64>,
    /// Right sides of the unknowns, then their values.
    values: Vec<f64>,
    /// Of [`NEARNESS`].
    nearness: f64,
    /// Present impulses.
    before: Vec<f64>,
    /// After the full step.
    after: Vec<f64>,
}

impl Newton {
    pub fn with_room(rows: usize) -> Self {
        let room = || Vec::with_capacity(rows);
        Self {
            active: Vec::with_capacity(rows),
            opening: Vec::with_capacity(rows),
            arrangement: Arrangement::with_room(rows),
            right: room(),
            step: room(),
            matrix: Vec::with_capacity(rows * row_length(rows)),
            order: Vec::with_capacity(rows),
            factors: Factors::None,
            row: room(),
            values: room(),
            nearness: NEARNESS[0],
            before: room(),
            after: room(),
        }
    }

    /// Makes the residual smaller than `present`, if it can: the new one. Expects `problem.velocity` to be current.
    pub fn step(&mut self, problem: &mut Problem, present: f64, nearness: f64) -> Option<f64> {
        if !self.aim(problem, nearness) {
            return None;
        }
        for length in LENGTHS {
            for (k, impulse) in problem.impulse.iter_mut().enumerate() {
                *impulse = self.before[k] + length * (self.after[k] - self.before[k]);
            }
            let found = residual(problem);
            if found < present * (1.0 - 0.1 * length) {
                return Some(found);
            }
        }
        problem.impulse.copy_from_slice(&self.before);
        residual(problem);
        None
    }

    /// Goes the whole way, whatever becomes of the residual: the new one. Where the present impulses are a solution but not
    /// the one that is looked for, all ways to that lead over larger residuals.
    pub fn leap(&mut self, problem: &mut Problem, nearness: f64) -> Option<f64> {
        if !self.aim(problem, nearness) {
            return None;
        }
        problem.impulse.copy_from_slice(&self.after);
        Some(residual(problem))
    }

    /// Forgets the last problem.
    pub fn begin(&mut self) {
        self.factors = Factors::None;
    }

    /// A further step with the matrix of the last one, if that makes the residual smaller than `present`: the new one. Expects
    /// `problem.missed` to be current.
    pub fn refine(&mut self, problem: &mut Problem, present: f64) -> Option<f64> {
        if self.factors == Factors::None {
            return None;
        }
        self.before.clear();
        self.before.extend_from_slice(&problem.impulse);
        self.right.copy_from_slice(&problem.missed);
        if self.solve(problem) {
            problem.impulse.iter_mut().zip(&self.step).for_each(|(impulse, step)| *impulse += step);
            let found = residual(problem);
            if found < present {
                return Some(found);
            }
        }
        problem.impulse.copy_from_slice(&self.before);
        residual(problem);
        None
    }

    /// The largest change of an impulse in the last step that was tried for the present problem.
    pub fn change(&self) -> f64 {
        if self.factors == Factors::None {
            return f64::INFINITY;
        }
        self.step.iter().fold(0.0, |largest: f64, step| largest.max(step.abs()))
    }

    /// From `before` to `after`: the whole step; false if there is none.
    fn aim(&mut self, problem: &Problem, nearness: f64) -> bool {
        self.nearness = nearness;
        self.before.clear();
        self.before.extend_from_slice(&problem.impulse);
        self.choose(problem);
        self.arrange(problem);
        if !self.factor(problem) || !self.solve(problem) {
            return false;
        }
        self.after.clear();
        let ways = self.before.iter().zip(&self.step).zip(&self.active);
        self.after.extend(ways.map(|((before, step), active)| if *active { before + step } else { 0.0 }));
        true
    }

    /// All rows but those of open contacts.
    fn choose(&mut self, problem: &Problem) {
        self.active.clear();
        self.opening.clear();
        for block in &problem.blocks {
            let closed = match block.law {
                Law::Limited { .. } => true,
                Law::Sole { normals, .. } => {
                    (block.first - normals..block.first).any(|row| wanted(problem, row) > 0.0)
                }
                _ => wanted(problem, block.first) > 0.0,
            };
            let rows = block.first..block.first + block.size();
            self.active.extend(rows.clone().map(|_| closed));
            if !closed {
                self.opening.extend(rows.filter(|row| problem.impulse[*row] != 0.0));
            }
        }
    }
}

fn wanted(problem: &Problem, row: usize) -> f64 {
    problem.impulse[row] - problem.weight[row] * problem.velocity[row]
}
