//! The mass matrix with the inertias of laws, which need not be symmetric.
use crate::derive::RobotModel;
use crate::derive::solve::Factor;
use crate::expression::Sym;

/// D + M, factored: D with the diagonal of M along the tree, the rest as a change of low rank (Woodbury).
pub(super) struct System<'g> {
    factor: Factor<'g>,
    /// By row with other columns: those elements of M.
    rows: Vec<Vec<(usize, Sym<'g>)>>,
    /// By the same: (D + diagonal)⁻¹ of the row's unit vector.
    answers: Vec<Vec<Sym<'g>>>,
}

impl<'g> System<'g> {
    /// D and the elements of M: (row, column, value).
    pub fn new(model: &RobotModel<'g, '_>, d: &[Vec<Sym<'g>>], inertias: &[(usize, usize, Sym<'g>)]) -> Self {
        let mut d = d.to_vec();
        let mut others: Vec<(usize, Vec<(usize, Sym<'g>)>)> = Vec::new();
        for &(row, column, m) in inertias {
            if row == column {
                d[row][row] = d[row][row] + m;
                continue;
            }
            match others.iter_mut().find(|(other, _)| *other == row) {
                Some((_, list)) => list.push((column, m)),
                None => others.push((row, vec![(column, m)])),
            }
        }
        let factor = Factor::new(model, &d);
        let unit = |row: usize| {
            let element = |k| model.constant(if k == row { 1.0 } else { 0.0 });
            (0..model.tree.nv).map(element).collect::<Vec<_>>()
        };
        let answers = others.iter().map(|(row, _)| factor.solve(&unit(*row))).collect();
        Self { factor, rows: others.into_iter().map(|(_, list)| list).collect(), answers }
    }

    /// (D + M)⁻¹ b
    pub fn solve(&self, b: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let mut x = self.factor.solve(b);
        if self.rows.is_empty() {
            return x;
        }
        let along = |row: &Vec<(usize, Sym<'g>)>, x: &[Sym<'g>]| {
            row.iter().fold(x[0].zero(), |sum, &(column, m)| sum + m * x[column])
        };
        let one = x[0].constant(1.0);
        let element = |(i, row): (usize, &Vec<_>), k: usize| {
            let product = along(row, &self.answers[k]);
            if i == k { one + product } else { product }
        };
        let rows = || self.rows.iter().enumerate();
        let matrix = rows().map(|row| (0..self.rows.len()).map(|k| element(row, k)).collect()).collect();
        let right = self.rows.iter().map(|row| along(row, &x)).collect();
        for (answer, &s) in self.answers.iter().zip(&solve_dense(matrix, right)) {
            for (x, &z) in x.iter_mut().zip(answer) {
                *x = *x - z * s;
            }
        }
        x
    }
}

/// A small system without symmetry; elimination without exchange of rows (it stays close to the identity), two
/// unknowns by determinants, which need none.
fn solve_dense<'g>(mut m: Vec<Vec<Sym<'g>>>, mut b: Vec<Sym<'g>>) -> Vec<Sym<'g>> {
    let n = b.len();
    if n == 2 {
        let inverse = b[0].constant(1.0) / (m[0][0] * m[1][1] - m[0][1] * m[1][0]);
        let first = m[1][1] * b[0] - m[0][1] * b[1];
        let second = m[0][0] * b[1] - m[1][0] * b[0];
        return vec![first * inverse, second * inverse];
    }
    for k in 0..n {
        let inverse = b[k].constant(1.0) / m[k][k];
        let (done, below) = m.split_at_mut(k + 1);
        for (r, row) in below.iter_mut().enumerate() {
            let factor = row[k] * inverse;
            for (x, &above) in row[k + 1..].iter_mut().zip(&done[k][k + 1..]) {
                *x = *x - factor * above;
            }
            b[k + 1 + r] = b[k + 1 + r] - factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let rest = (k + 1..n).fold(b[k], |sum, c| sum - m[k][c] * b[c]);
        b[k] = rest / m[k][k];
    }
    b
}
