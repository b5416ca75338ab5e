//! The symmetric system of an iteration, factorised as L D Lᵀ, with the signs of D counted.
use super::factor::Factor;
use std::collections::BTreeMap;

/// [H + Σ, Jᵀ; J, −Δ] with fixed structure.
pub(super) struct Kkt {
    n: usize,
    m: usize,
    /// Upper triangle by columns: where each column begins, and the rows.
    columns: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    /// With what is added to its diagonal.
    sum: Vec<f64>,
    hessian: Vec<usize>,
    jacobian: Vec<usize>,
    diagonal: Vec<usize>,
    factor: Option<Factor>,
}

/// A relative residual with which a step is as good as an exact one.
const ENOUGH: f64 = 1e-10;

impl Kkt {
    /// Of n variables and m constraints.
    pub fn new(n: usize, m: usize, hessian: &[[usize; 2]], jacobian: &[[usize; 2]]) -> Self {
        let mut places: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let upper = |[a, b]: [usize; 2]| (a.max(b), a.min(b));
        let elements = || {
            let hessian = hessian.iter().map(|&e| upper(e));
            let jacobian = jacobian.iter().map(|&[row, column]| (n + row, column));
            hessian.chain(jacobian).chain((0..n + m).map(|k| (k, k)))
        };
        for element in elements() {
            places.insert(element, 0);
        }
        let (mut columns, mut rows) = (vec![0; n + m + 1], Vec::with_capacity(places.len()));
        for (index, (&(column, row), place)) in places.iter_mut().enumerate() {
            *place = index;
            rows.push(row);
            columns[column + 1] = index + 1;
        }
        let found: Vec<usize> = elements().map(|element| places[&element]).collect();
        let (hessian, rest) = found.split_at(hessian.len());
        let (jacobian, diagonal) = rest.split_at(jacobian.len());
        let values = vec![0.0; rows.len()];
        Self {
            n,
            m,
            factor: Factor::new(&columns, &rows),
            columns,
            rows,
            sum: values.clone(),
            values,
            hessian: hessian.to_vec(),
            jacobian: jacobian.to_vec(),
            diagonal: diagonal.to_vec(),
        }
    }

    /// Takes numbers: `sigma` is added to H's diagonal, `delta` subtracted from that of the constraints.
    pub fn fill(&mut self, hessian: &[f64], jacobian: &[f64], sigma: &[f64], delta: &[f64]) {
        self.values.fill(0.0);
        for (&place, value) in self.hessian.iter().zip(hessian) {
            self.values[place] += value;
        }
        for (&place, value) in self.jacobian.iter().zip(jacobian) {
            self.values[place] += value;
        }
        for (&place, value) in self.diagonal.iter().zip(sigma) {
            self.values[place] += value;
        }
        for (&place, value) in self.diagonal[self.n..].iter().zip(delta) {
            self.values[place] -= value;
        }
    }

    /// Factorises with additions to both diagonals that [`Self::solve`] removes again by refinement; whether there are as many positive
    /// pivots as variables.
    pub fn factorise(&mut self, primal: f64, dual: f64) -> bool {
        let Some(factor) = &mut self.factor else { return false };
        self.sum.clone_from(&self.values);
        for (k, &place) in self.diagonal.iter().enumerate() {
            self.sum[place] += if k < self.n { primal } else { -dual };
        }
        factor.factorise(&self.sum) && factor.positive() == self.n
    }

    /// The system without additions but for `primal` times a vector.
    fn product(&self, x: &[f64], primal: f64, out: &mut [f64]) {
        out.fill(0.0);
        for column in 0..self.n + self.m {
            let (mut sum, own) = (0.0, x[column]);
            for place in self.columns[column]..self.columns[column + 1] {
                let (row, value) = (self.rows[place], self.values[place]);
                if row == column {
                    sum += value * own;
                } else {
                    sum += value * x[row];
                    out[row] += value * own;
                }
            }
            out[column] += sum + if column < self.n { primal * own } else { 0.0 };
        }
    }

    /// Solves with iterative refinement; `primal` belongs to the equations. Returns the relative residual.
    pub fn solve(&mut self, right: &[f64], primal: f64, x: &mut Vec<f64>) -> f64 {
        let norm =
            |r: &[f64]| r.iter().fold(0.0f64, |a, b| if b.is_nan() { f64::NAN } else { a.max(b.abs()) });
        let scale = norm(right).max(1e-300);
        x.clear();
        x.resize(right.len(), 0.0);
        let mut residual = right.to_vec();
        let mut best = (1.0, x.clone());
        let mut product = vec![0.0; right.len()];
        for _ in 0..10 {
            let mut correction = residual.clone();
            let Some(factor) = &self.factor else { return f64::INFINITY };
            factor.solve(&mut correction);
            x.iter_mut().zip(&correction).for_each(|(x, c)| *x += c);
            self.product(x, primal, &mut product);
            residual.iter_mut().zip(right.iter().zip(&product)).for_each(|(r, (b, p))| *r = b - p);
            let found = norm(&residual) / scale;
            let better = found < best.0;
            if !better {
                break;
            }
            best = (found, x.clone());
            if found < ENOUGH {
                break;
            }
        }
        *x = best.1;
        best.0
    }
}
