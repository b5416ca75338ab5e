//! What is unknown in a Newton step, and what follows from it without solving anything.
use super::{Newton, wanted};
use crate::simulate::problem::{Block, Cone, Law, Problem};
use std::ops::Range;

/// Two tangential rows that slide: `λ_T = μ λ_N z/|z|`, `z = λ_T − r ξ_T`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slide {
    pub first: usize,
    /// `z/|z|`
    pub along: [f64; 2],
    /// `μ λ_N/|z|`, below 1.
    pub ratio: f64,
}

impl Slide {
    /// What a row's entries give together, across.
    pub fn across(&self, by_row: &[f64]) -> f64 {
        self.along[0] * by_row[self.first + 1] - self.along[1] * by_row[self.first]
    }
}

/// A row of friction that changes with the load: by `share` times the sum of the changes of its normal rows.
#[derive(Debug, Clone)]
pub(super) struct Follow {
    pub row: usize,
    pub normals: Range<usize>,
    pub share: f64,
}

/// Unknowns, and what all other active rows do.
#[derive(Debug, Clone, Default)]
pub(super) struct Arrangement {
    /// Rows whose ξ is to vanish: an unknown each.
    pub still: Vec<usize>,
    /// What slides: an unknown each, the change across the direction of sliding.
    pub slides: Vec<Slide>,
    pub follows: Vec<Follow>,
    /// Rows that change by their right side, and by what they follow.
    pub given: Vec<usize>,
}

impl Arrangement {
    pub fn with_room(rows: usize) -> Self {
        Self {
            still: Vec::with_capacity(rows),
            slides: Vec::with_capacity(rows),
            follows: Vec::with_capacity(rows),
            given: Vec::with_capacity(rows),
        }
    }

    /// How many unknowns there are.
    pub fn size(&self) -> usize {
        self.still.len() + self.slides.len()
    }

    /// Whether the equations are those of symmetric rows of G.
    pub fn is_symmetric(&self) -> bool {
        self.follows.is_empty()
    }
}

/// What presses on rows of friction.
#[derive(Debug, Clone)]
struct Load {
    normals: Range<usize>,
    force: f64,
}

impl Newton {
    /// Arranges the step of the active rows, and writes their right sides.
    pub(super) fn arrange(&mut self, problem: &Problem) {
        self.arrangement.still.clear();
        self.arrangement.slides.clear();
        self.arrangement.follows.clear();
        self.arrangement.given.clear();
        self.right.clear();
        self.right.resize(problem.rows(), 0.0);
        for (index, block) in problem.blocks.iter().enumerate() {
            if self.active[block.first] {
                self.arrange_block(problem, block, problem.at_limit.get(index) == Some(&true));
            }
        }
    }

    /// `slides`: friction at its limit stays there, whatever its velocity.
    fn arrange_block(&mut self, problem: &Problem, block: &Block, slides: bool) {
        let first = block.first;
        match block.law {
            Law::Unilateral => self.still(problem, first),
            Law::Limited { low, high } => {
                let target = wanted(problem, first);
                if target <= low || target >= high {
                    self.right[first] = target.max(low).min(high) - problem.impulse[first];
                    self.arrangement.given.push(first);
                } else {
                    self.still(problem, first);
                }
            }
            Law::Contact { friction, tangents, cone } => {
                self.still(problem, first);
                let load = Load { normals: first..first + 1, force: problem.impulse[first].max(0.0) };
                if tangents == 2 && cone == Cone::Round {
                    return self.round(problem, &load, first + 1, friction, slides);
                }
                (first + 1..=first + tangents).for_each(|row| self.straight(problem, &load, row, friction));
            }
            Law::Sole { friction, turning, normals, cone } => {
                let load = Load { normals: first - normals..first, force: problem.load(first, normals) };
                match cone {
                    Cone::Round => self.round(problem, &load, first, friction, slides),
                    Cone::Pyramid => {
                        (first..first + 2).for_each(|row| self.straight(problem, &load, row, friction));
                    }
                }
                self.straight(problem, &load, first + 2, turning);
            }
        }
    }

    /// `r ξ = 0` after the step.
    fn still(&mut self, problem: &Problem, row: usize) {
        self.right[row] = -problem.weight[row] * self.velocity_without_open(problem, row);
        self.arrangement.still.push(row);
    }

    /// ξ when open contacts let go.
    fn velocity_without_open(&self, problem: &Problem, row: usize) -> f64 {
        let own = problem.row(row);
        self.opening.iter().fold(problem.velocity[row], |sum, k| sum - own[*k] * problem.impulse[*k])
    }

    /// One tangential row that sticks, or slips with `λ_T = ± μ λ_N`.
    fn straight(&mut self, problem: &Problem, load: &Load, row: usize, friction: f64) {
        let target = wanted(problem, row);
        if target.abs() <= friction * load.force {
            return self.still(problem, row);
        }
        let share = target.signum() * friction;
        self.right[row] = share * load.force - problem.impulse[row];
        self.arrangement.given.push(row);
        self.arrangement.follows.push(Follow { row, normals: load.normals.clone(), share });
    }

    /// Both tangential rows: stick, or slip with `λ_T = μ λ_N z/|z|`, whose derivative has the part along `z` (through λ_N) and
    /// the part across it.
    fn round(&mut self, problem: &Problem, load: &Load, first: usize, friction: f64, slides: bool) {
        let target = [first, first + 1].map(|row| wanted(problem, row));
        let length = (target[0] * target[0] + target[1] * target[1]).sqrt();
        let most = friction * load.force;
        if length <= most && !(slides && length > 0.0) {
            self.still(problem, first);
            return self.still(problem, first + 1);
        }
        let along = target.map(|x| x / length);
        for (row, along) in (first..).zip(along) {
            self.right[row] = most * along - problem.impulse[row];
            let share = friction * along;
            self.arrangement.follows.push(Follow { row, normals: load.normals.clone(), share });
        }
        self.arrangement.slides.push(Slide { first, along, ratio: (most / length).min(1.0) });
    }
}
