//! The step where nothing slides: its equations are symmetric, and rows at a bound leave them.
use super::{Factors, Newton, sticks, wanted};
use crate::simulate::dense::{self, row_length};
use crate::simulate::problem::{Block, Cone, Law, Problem};

impl Newton {
    /// Factors `(G + nearness/r) δ = −ξ` of the active rows that stand still, if no contact slides, and writes the right side.
    /// Rows at a bound, whose step is known, come last among the active ones then.
    ///
    /// `false`: something slides, or G is not definite enough; the active rows are as before.
    pub(super) fn factor_symmetric(&mut self, problem: &Problem) -> bool {
        if self.active.iter().any(|row| problem.weight[*row] <= 0.0) || self.slides(problem) {
            return false;
        }
        let still = self.sort(problem);
        self.copy(problem, still);
        self.factors = Factors::Symmetric { still };
        if dense::factor(&mut self.matrix, still) {
            self.right_side(problem, still);
            return true;
        }
        // Elimination expects them in the order of the blocks.
        self.active.sort_unstable();
        false
    }

    /// Whether friction of a closed contact gives way.
    fn slides(&self, problem: &Problem) -> bool {
        let mut at = 0;
        problem.blocks.iter().any(|block| {
            if self.active.get(at) != Some(&block.first) {
                return false;
            }
            at += block.size();
            !holds(problem, block)
        })
    }

    /// Rows that stand still first: how many they are.
    fn sort(&mut self, problem: &Problem) -> usize {
        self.given.clear();
        let mut at = 0;
        for block in &problem.blocks {
            if self.active.get(at) == Some(&block.first) {
                if let Some(bound) = bound(problem, block) {
                    self.given.push((block.first, bound));
                    self.active.remove(at);
                } else {
                    at += block.size();
                }
            }
        }
        let still = self.active.len();
        self.active.extend(self.given.iter().map(|(row, _)| *row));
        still
    }

    /// The lower triangle.
    fn copy(&mut self, problem: &Problem, still: usize) {
        let length = row_length(still);
        self.matrix.resize(still * length, 0.0);
        let rows = &self.active[..still];
        for (at, (target, &row)) in self.matrix.chunks_exact_mut(length.max(1)).zip(rows).enumerate() {
            let own = problem.row(row);
            if still == own.len() {
                target[..=at].copy_from_slice(&own[..=at]);
            } else {
                target.iter_mut().zip(&rows[..=at]).for_each(|(x, column)| *x = own[*column]);
            }
            target[at] += self.nearness / problem.weight[row];
        }
    }

    fn right_side(&mut self, problem: &Problem, still: usize) {
        self.step.clear();
        for &row in &self.active[..still] {
            self.step.push(-problem.weight[row] * self.velocity_without_open(problem, row));
        }
        self.step.extend(self.given.iter().map(|(row, bound)| bound - problem.impulse[*row]));
    }
}

/// Where a row of limited impulse stands at its bound.
fn bound(problem: &Problem, block: &Block) -> Option<f64> {
    let Law::Limited { low, high } = block.law else { return None };
    let target = wanted(problem, block.first);
    (target <= low || target >= high).then(|| target.max(low).min(high))
}

/// Whether the friction of a contact can give what is wanted.
fn holds(problem: &Problem, block: &Block) -> bool {
    let wanted = |row: usize| wanted(problem, row);
    let pair = |first: usize, most: f64, cone: Cone| match cone {
        Cone::Round => sticks(&[wanted(first), wanted(first + 1)], most),
        Cone::Pyramid => sticks(&[wanted(first)], most) && sticks(&[wanted(first + 1)], most),
    };
    let row = block.first;
    match block.law {
        Law::Unilateral | Law::Limited { .. } => true,
        Law::Contact { friction, tangents, cone } => {
            let most = friction * problem.impulse[row].max(0.0);
            if tangents == 2 { pair(row + 1, most, cone) } else { sticks(&[wanted(row + 1)], most) }
        }
        Law::Sole { friction, turning, normals, cone } => {
            let load = problem.load(row, normals);
            pair(row, friction * load, cone) && sticks(&[wanted(row + 2)], turning * load)
        }
    }
}
