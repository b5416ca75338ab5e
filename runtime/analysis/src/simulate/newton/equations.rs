//! Linear equations of a Newton step in as few unknowns as it has.
use super::Newton;
use super::arrange::Slide;
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
        let n = self.arrangement.size();
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
        let still = &self.arrangement.still;
        let length = row_length(still.len()).max(1);
        let all = still.len() == problem.rows();
        if all {
            // What lies above the diagonal is not read.
            self.matrix.copy_from_slice(&problem.delassus);
        }
        for (at, (target, &row)) in self.matrix.chunks_exact_mut(length).zip(still).enumerate() {
            let (own, weight) = (problem.row(row), problem.weight[row]);
            if weight <= 0.0 {
                return false;
            }
            if !all {
                target.iter_mut().zip(&still[..=at]).for_each(|(x, column)| *x = own[*column]);
            }
            target[at] += self.nearness / weight;
        }
        true
    }

    /// Every equation scaled by r.
    fn assemble(&mut self, problem: &Problem) {
        let Self { arrangement, matrix, row: by_row, nearness, .. } = self;
        let (n, still) = (arrangement.size(), arrangement.still.len());
        let mut rows = matrix.chunks_exact_mut(row_length(n).max(1)).enumerate();
        let mut write = |by_row: &mut [f64], diagonal: f64| {
            for follow in &arrangement.follows {
                let by_follower = follow.share * by_row[follow.row];
                by_row[follow.normals.clone()].iter_mut().for_each(|x| *x += by_follower);
            }
            let Some((at, row)) = rows.next() else { return };
            let (left, right) = row.split_at_mut(still);
            left.iter_mut().zip(&arrangement.still).for_each(|(x, column)| *x = by_row[*column]);
            right.iter_mut().zip(&arrangement.slides).for_each(|(x, slide)| *x = slide.across(by_row));
            row[at] += diagonal;
        };
        for &row in &arrangement.still {
            let weight = problem.weight[row];
            by_row.clear();
            by_row.extend(problem.row(row).iter().map(|own| weight * own));
            write(by_row, *nearness);
        }
        for slide in &arrangement.slides {
            let weight = slide.ratio * problem.weight[slide.first];
            let [x, y] = slide.along.map(|x| x * weight);
            let both = problem.row(slide.first).iter().zip(problem.row(slide.first + 1));
            by_row.clear();
            by_row.extend(both.map(|(first, second)| x * second - y * first));
            write(by_row, 1.0 - slide.ratio);
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
        let (still, across) = self.values.split_at(self.arrangement.still.len());
        self.arrangement.still.iter().zip(still).for_each(|(row, value)| self.step[*row] = *value);
        for (Slide { first, along: [x, y], .. }, value) in self.arrangement.slides.iter().zip(across) {
            self.step[*first] -= y * value;
            self.step[first + 1] += x * value;
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
        for &Slide { first, along: [x, y], .. } in &self.arrangement.slides {
            let along = x * self.right[first] + y * self.right[first + 1];
            (self.step[first], self.step[first + 1]) = (x * along, y * along);
        }
        if self.step.iter().any(|step| *step != 0.0) {
            dense::add_rows(&problem.delassus, &self.step, &mut self.row);
        }
    }

    fn right_of_unknowns(&mut self, problem: &Problem) {
        self.values.clear();
        let symmetric = self.factors == Factors::Symmetric;
        self.values.extend(self.arrangement.still.iter().map(|&row| {
            let (right, weight, known) = (self.right[row], problem.weight[row], self.row[row]);
            if symmetric { right / weight - known } else { right - weight * known }
        }));
        self.values.extend(self.arrangement.slides.iter().map(|slide| {
            slide.across(&self.right) - slide.ratio * problem.weight[slide.first] * slide.across(&self.row)
        }));
    }
}
