//! One semismooth Newton step on `λ = prox(λ − r ξ(λ))`.
mod symmetric;

use super::dense::{self, row_length};
use super::problem::{Cone, Law, Problem};
use super::proximal::residual;

/// Added to the scaled rows `r ξ = 0`, whose diagonal is 1, for the solution nearest to the present one. The first leaves the
/// choice to the springs of `sharing`; larger ones make shorter steps, which arrive where many contacts are about to change
/// between sticking, slipping and letting go.
pub(super) const NEARNESS: [f64; 4] = [1e-14, 1e-6, 1e-4, 1e-2];

/// The first one where no springs share the load.
pub(super) const NEAR: f64 = 1e-9;

/// Step lengths that are tried.
const LENGTHS: [f64; 4] = [1.0, 0.5, 0.25, 0.0625];

/// What the equations of the last whole step were factored into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Factors {
    /// Nothing: there was none yet for the present problem, or it has no solution.
    #[default]
    None,
    /// `Lᵀ L` of the rows of G that stand still: the first so many active ones. The steps of the others are known.
    Symmetric { still: usize },
    /// An elimination of all active rows.
    General,
}

/// Workspace.
#[derive(Debug, Clone, Default)]
pub(super) struct Newton {
    /// Rows that are not simply zero.
    active: Vec<usize>,
    /// Rows of open contacts whose impulses are not zero yet.
    opening: Vec<usize>,
    /// Rows at a bound, and the impulse there.
    given: Vec<(usize, f64)>,
    matrix: Vec<f64>,
    /// Row exchanges of an elimination.
    order: Vec<usize>,
    factors: Factors,
    /// Of the active rows, in their order.
    step: Vec<f64>,
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
            given: Vec::with_capacity(rows),
            matrix: Vec::with_capacity(rows * row_length(rows)),
            order: Vec::with_capacity(rows),
            factors: Factors::None,
            step: room(),
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
        self.step.clear();
        self.step.extend(self.active.iter().map(|row| problem.missed[*row]));
        if self.substitute(problem) {
            for (&row, step) in self.active.iter().zip(&self.step) {
                problem.impulse[row] += step;
            }
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
        if !self.factor_symmetric(problem) && !self.factor_general(problem) {
            return false;
        }
        if !self.substitute(problem) {
            return false;
        }
        self.after.clear();
        self.after.resize(problem.rows(), 0.0);
        for (&row, step) in self.active.iter().zip(&self.step) {
            self.after[row] = self.before[row] + step;
        }
        true
    }

    /// Equations of all active rows, and their right side.
    fn factor_general(&mut self, problem: &Problem) -> bool {
        self.assemble(problem);
        let solvable = dense::eliminate(&mut self.matrix, self.active.len(), &mut self.order);
        self.factors = if solvable { Factors::General } else { Factors::None };
        solvable
    }

    /// Solves with the factors at hand, `step` from right side to answer. The right sides are those of scaled rows, `r ξ = 0`.
    fn substitute(&mut self, problem: &Problem) -> bool {
        match self.factors {
            Factors::None => false,
            Factors::General => {
                dense::substitute(&self.matrix, self.active.len(), &self.order, &mut self.step)
            }
            Factors::Symmetric { still } => {
                let (held, known) = self.active.split_at(still);
                let (steps, given) = self.step.split_at_mut(still);
                for (&row, step) in held.iter().zip(&mut *steps) {
                    let own = problem.row(row);
                    let by_given: f64 = known.iter().zip(&*given).map(|(k, step)| own[*k] * step).sum();
                    *step = *step / problem.weight[row] - by_given;
                }
                dense::forward_one(&self.matrix, still, steps);
                dense::backward(&self.matrix, still, steps);
                self.step.iter().all(|step| step.is_finite())
            }
        }
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
            if closed {
                self.active.extend(rows);
            } else {
                self.opening.extend(rows.filter(|row| problem.impulse[*row] != 0.0));
            }
        }
    }

    /// Linear equations of the step of the active rows. Rows that become zero contribute with their whole way there.
    fn assemble(&mut self, problem: &Problem) {
        let n = self.active.len();
        self.matrix.clear();
        self.matrix.resize(n * row_length(n), 0.0);
        self.step.clear();
        self.step.resize(n, 0.0);
        let mut at = 0;
        for block in &problem.blocks {
            if self.active.get(at) != Some(&block.first) {
                continue;
            }
            match block.law {
                Law::Unilateral => self.still(problem, at),
                Law::Limited { low, high } => {
                    let target = wanted(problem, block.first);
                    if target <= low || target >= high {
                        self.matrix[at * row_length(n) + at] = 1.0;
                        self.step[at] = target.max(low).min(high) - problem.impulse[block.first];
                    } else {
                        self.still(problem, at);
                    }
                }
                Law::Contact { friction, tangents, cone } => {
                    self.still(problem, at);
                    let load = Load { rows: (at, at + 1), force: problem.impulse[block.first].max(0.0) };
                    self.slip(problem, load, at + 1, (friction, tangents, cone));
                }
                Law::Sole { friction, turning, normals, cone } => {
                    let last = block.first - normals;
                    let first = (0..at).rev().take_while(|k| self.active[*k] >= last).last().unwrap_or(at);
                    let load = Load { rows: (first, at), force: problem.load(block.first, normals) };
                    self.slip(problem, load, at, (friction, 2, cone));
                    self.slip_straight(problem, load, at + 2, turning);
                }
            }
            at += block.size();
        }
    }

    /// `r ξ = 0` after the step.
    fn still(&mut self, problem: &Problem, at: usize) {
        let n = self.active.len();
        let row = self.active[at];
        let (weight, own) = (problem.weight[row], problem.row(row));
        let target = &mut self.matrix[at * row_length(n)..][..n];
        if n == own.len() {
            target.iter_mut().zip(own).for_each(|(x, own)| *x = weight * own);
        } else {
            target.iter_mut().zip(&self.active).for_each(|(x, column)| *x = weight * own[*column]);
        }
        target[at] += self.nearness;
        self.step[at] = -weight * self.velocity_without_open(problem, row);
    }

    /// ξ when open contacts let go.
    fn velocity_without_open(&self, problem: &Problem, row: usize) -> f64 {
        let own = problem.row(row);
        self.opening.iter().fold(problem.velocity[row], |sum, k| sum - own[*k] * problem.impulse[*k])
    }

    /// Tangential rows from `at` on.
    fn slip(
        &mut self,
        problem: &Problem,
        load: Load,
        at: usize,
        (friction, tangents, cone): (f64, usize, Cone),
    ) {
        if tangents == 2 && cone == Cone::Round {
            return self.slip_round(problem, load, at, friction);
        }
        for k in at..at + tangents {
            self.slip_straight(problem, load, k, friction);
        }
    }

    /// One tangential row that sticks, or slips with `λ_T = ± μ λ_N`.
    fn slip_straight(&mut self, problem: &Problem, load: Load, at: usize, friction: f64) {
        let n = row_length(self.active.len());
        let row = self.active[at];
        let target = wanted(problem, row);
        if sticks(&[target], friction * load.force) {
            return self.still(problem, at);
        }
        let sign = target.signum();
        self.matrix[at * n + at] = 1.0;
        self.matrix[at * n + load.rows.0..at * n + load.rows.1].fill(-sign * friction);
        self.step[at] = sign * friction * load.force - problem.impulse[row];
    }

    /// Both tangential rows: stick, or slip with `λ_T = μ λ_N z/|z|`, `z = λ_T − r ξ_T`, whose derivative has the part
    /// along `z` (through λ_N) and the part across it.
    fn slip_round(&mut self, problem: &Problem, load: Load, first: usize, friction: f64) {
        let n = row_length(self.active.len());
        let rows = [self.active[first], self.active[first + 1]];
        let target = rows.map(|row| wanted(problem, row));
        let length = size_of(&target);
        if sticks(&target, friction * load.force) {
            self.still(problem, first);
            return self.still(problem, first + 1);
        }
        let along = target.map(|x| x / length);
        let ratio = friction * load.force / length;
        for k in 0..2 {
            let at = first + k;
            for other in 0..2 {
                let across = f64::from(u8::from(k == other)) - along[k] * along[other];
                let (row, weight) = (rows[other], problem.weight[rows[other]]);
                for (j, &column) in self.active.iter().enumerate() {
                    self.matrix[at * n + j] += ratio * across * weight * problem.row(row)[column];
                }
                self.matrix[at * n + first + other] -= ratio * across;
            }
            self.matrix[at * n + at] += 1.0;
            for normal in load.rows.0..load.rows.1 {
                self.matrix[at * n + normal] -= friction * along[k];
            }
            self.step[at] = friction * load.force * along[k] - problem.impulse[rows[k]];
        }
    }
}

/// What presses on rows of friction: active rows from the first to before the second, and their force.
#[derive(Debug, Clone, Copy)]
struct Load {
    rows: (usize, usize),
    force: f64,
}

/// Length of a tangential impulse.
fn size_of(tangential: &[f64]) -> f64 {
    tangential.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether friction can give what is wanted.
fn sticks(wanted: &[f64], most: f64) -> bool {
    size_of(wanted) <= most
}

fn wanted(problem: &Problem, row: usize) -> f64 {
    problem.impulse[row] - problem.weight[row] * problem.velocity[row]
}
