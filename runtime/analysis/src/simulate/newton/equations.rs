//! Linear equations of a Newton step in as few unknowns as it has.
use super::Newton;
use super::arrange::Unknown;
use crate::simulate::dense::{self, row_length};
use crate::simulate::problem::Problem;

/// What the equations of the last whole step were factored into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Factors {
    /// Nothing: there was none yet for the present problem, or it has no solution.
    #[default]
    None,
    /// `Lᵀ L` of rows of G where nothing slides.
    Symmetric,
    /// An elimination.
    General,
}

impl Newton {
    /// Assembles and factors; false: singular.
    pub(super) fn factor(&mut self, problem: &Problem) -> bool {
        let n = self.arrangement.unknowns.len();
        self.factors = Factors::None;
        self.matrix.resize(n * row_length(n), 0.0);
        if self.arrangement.is_symmetric()
            && self.assemble_symmetric(problem)
            && dense::factor(&mut self.matrix, n)
        {
            self.factors = Factors::Symmetric;
            return true;
        }
        self.assemble(problem);
        if dense::eliminate(&mut self.matrix, n, &mut self.order) {
            self.factors = Factors::General;
        }
        self.factors == Factors::General
    }

    /// The lower triangle of `G + nearness/r`; false: a row that nothing moves.
    fn assemble_symmetric(&mut self, problem: &Problem) -> bool {
        let unknowns = &self.arrangement.unknowns;
        let length = row_length(unknowns.len()).max(1);
        let all = unknowns.len() == problem.rows();
        for (at, (target, unknown)) in self.matrix.chunks_exact_mut(length).zip(unknowns).enumerate() {
            let Unknown::Still(row) = *unknown else { return false };
            let (own, weight) = (problem.row(row), problem.weight[row]);
            if weight <= 0.0 {
                return false;
            }
            if all {
                target[..=at].copy_from_slice(&own[..=at]);
            } else {
                for (x, other) in target.iter_mut().zip(&unknowns[..=at]) {
                    let Unknown::Still(column) = *other else { return false };
                    *x = own[column];
                }
            }
            target[at] += self.nearness / weight;
        }
        true
    }

    /// Every equation scaled by r.
    fn assemble(&mut self, problem: &Problem) {
        let Self { arrangement, matrix, row: by_row, nearness, .. } = self;
        let length = row_length(arrangement.unknowns.len()).max(1);
        for (at, (target, unknown)) in matrix.chunks_exact_mut(length).zip(&arrangement.unknowns).enumerate()
        {
            by_row.clear();
            let diagonal = match *unknown {
                Unknown::Still(row) => {
                    let weight = problem.weight[row];
                    by_row.extend(problem.row(row).iter().map(|own| weight * own));
                    *nearness
                }
                Unknown::Across(first, slide) => {
                    let [a, b] = slide.across().map(|x| x * slide.ratio * problem.weight[first]);
                    let both = problem.row(first).iter().zip(problem.row(first + 1));
                    by_row.extend(both.map(|(x, y)| a * x + b * y));
                    1.0 - slide.ratio
                }
            };
            for follow in &arrangement.follows {
                let by_follower = follow.share * by_row[follow.row];
                by_row[follow.normals.clone()].iter_mut().for_each(|x| *x += by_follower);
            }
            for (x, other) in target.iter_mut().zip(&arrangement.unknowns) {
                *x = match *other {
                    Unknown::Still(row) => by_row[row],
                    Unknown::Across(first, slide) => {
                        let [a, b] = slide.across();
                        a * by_row[first] + b * by_row[first + 1]
                    }
                };
            }
            target[at] += diagonal;
        }
    }

    /// From the right sides by row to the step by row, with the factors at hand; false: no finite solution.
    pub(super) fn solve(&mut self, problem: &Problem) -> bool {
        self.known(problem);
        self.right_of_unknowns(problem);
        let n = self.values.len();
        match self.factors {
            Factors::None => return false,
            Factors::Symmetric => {
                dense::forward_one(&self.matrix, n, &mut self.values);
                dense::backward(&self.matrix, n, &mut self.values);
            }
            Factors::General => {
                dense::substitute(&self.matrix, n, &self.order, &mut self.values);
            }
        }
        for (unknown, value) in self.arrangement.unknowns.iter().zip(&self.values) {
            match *unknown {
                Unknown::Still(row) => self.step[row] = *value,
                Unknown::Across(first, slide) => {
                    let [a, b] = slide.across();
                    self.step[first] += a * value;
                    self.step[first + 1] += b * value;
                }
            }
        }
        for follow in &self.arrangement.follows {
            let load: f64 = self.step[follow.normals.clone()].iter().sum();
            self.step[follow.row] += follow.share * load;
        }
        self.step.iter().all(|step| step.is_finite())
    }

    /// The part of the step that needs no solving into `step`, what it does to ξ into `row`.
    fn known(&mut self, problem: &Problem) {
        let rows = problem.rows();
        for values in [&mut self.step, &mut self.row] {
            values.clear();
            values.resize(rows, 0.0);
        }
        for &row in &self.arrangement.given {
            self.step[row] = self.right[row];
        }
        for unknown in &self.arrangement.unknowns {
            if let Unknown::Across(first, slide) = *unknown {
                let [x, y] = slide.along;
                let along = x * self.right[first] + y * self.right[first + 1];
                (self.step[first], self.step[first + 1]) = (x * along, y * along);
            }
        }
        if self.step.iter().any(|step| *step != 0.0) {
            dense::add_rows(&problem.delassus, &self.step, &mut self.row);
        }
    }

    fn right_of_unknowns(&mut self, problem: &Problem) {
        self.values.clear();
        let symmetric = self.factors == Factors::Symmetric;
        self.values.extend(self.arrangement.unknowns.iter().map(|unknown| match *unknown {
            Unknown::Still(row) if symmetric => self.right[row] / problem.weight[row] - self.row[row],
            Unknown::Still(row) => self.right[row] - problem.weight[row] * self.row[row],
            Unknown::Across(first, slide) => {
                let [a, b] = slide.across();
                let weight = slide.ratio * problem.weight[first];
                a * (self.right[first] - weight * self.row[first])
                    + b * (self.right[first + 1] - weight * self.row[first + 1])
            }
        }));
    }
}
