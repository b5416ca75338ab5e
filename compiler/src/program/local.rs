//! Functions of a few numbers with exact first and second derivatives and their structure: what a nonlinear program is put together from.
use super::along::Along;
use super::slopes::Slopes;
use super::tangent::LANES;
use super::{Evaluator, Order, lower};
use crate::expression::{Expr, Graph, Input, Sym, gradient, inputs};
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::{Argument, Real, State};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Rows r(x) of local variables x. Derivatives are those of the program itself, by numbers that carry them (first ones) and by the symbolic
/// gradient of Σ multiplier · row on such numbers (second ones).
#[derive(Debug, Clone)]
pub struct LocalFunction {
    variables: usize,
    rows: usize,
    value: Evaluator,
    /// ∂(Σ multiplier · row)/∂x, of x and then the multipliers.
    gradient: Evaluator,
    jacobian: Vec<[usize; 2]>,
    hessian: Vec<[usize; 2]>,
    /// Variables along which second derivatives are taken, in groups of lanes, and for each element of the Hessian: group, lane, row.
    directions: Vec<usize>,
    places: Vec<[usize; 3]>,
    /// Elements of the Jacobian and of the Hessian as machine code.
    slopes: Arc<[Along; 2]>,
}

impl LocalFunction {
    /// Of rows whose only inputs are the first `variables` elements of [`Argument::Parameters`].
    pub fn new(graph: &Graph, variables: usize, rows: &[Sym<'_>]) -> Self {
        let outputs: Vec<Expr> = rows.iter().map(|row| row.expr).collect();
        let value_program = lower(graph, &outputs, Order::DepthFirst);
        let index_of = |input: &Input| input.index as usize;
        let jacobian = rows.iter().enumerate().flat_map(|(row, of)| {
            let of = inputs(*of);
            of.iter().map(|input| [row, index_of(input)]).collect::<Vec<_>>()
        });
        let jacobian: Vec<[usize; 2]> = jacobian.collect();
        let zero = Sym::new(graph, Expr::ZERO);
        let weighted = rows.iter().enumerate().fold(zero, |sum, (row, &of)| {
            sum + of * Sym::new(graph, graph.input(Argument::Parameters, variables + row))
        });
        let slopes: BTreeMap<usize, Sym<'_>> = gradient(weighted)
            .into_iter()
            .map(|(input, slope)| (index_of(&input), slope))
            .filter(|&(index, _)| index < variables)
            .collect();
        let columns: Vec<Sym<'_>> = (0..variables).map(|k| slopes.get(&k).copied().unwrap_or(zero)).collect();
        let outputs: Vec<Expr> = columns.iter().map(|x| x.expr).collect();
        let gradient_program = lower(graph, &outputs, Order::DepthFirst);
        let mut pairs: BTreeSet<[usize; 2]> = BTreeSet::new();
        for (i, column) in columns.iter().enumerate() {
            for j in inputs(*column).iter().map(index_of).filter(|&j| j < variables) {
                pairs.insert([i.max(j), i.min(j)]);
            }
        }
        let hessian: Vec<[usize; 2]> = pairs.into_iter().collect();
        let directions = cover(&hessian);
        let place = |&[i, j]: &[usize; 2]| {
            let along = |k: usize| directions.iter().position(|&d| d == k);
            let (direction, row) = match along(j) {
                Some(direction) => (direction, i),
                None => (along(i).unwrap_or(0), j),
            };
            [direction / LANES, direction % LANES, row]
        };
        let places: Vec<[usize; 3]> = hessian.iter().map(place).collect();
        let all: Vec<usize> = (0..variables).collect();
        let wanted = jacobian.iter().map(|&[row, k]| [k / LANES, k % LANES, row]).collect();
        let slopes = Arc::new([
            Along::new(&value_program, variables, &all, wanted),
            Along::new(&gradient_program, variables + rows.len(), &directions, places.clone()),
        ]);
        let [value, gradient] = [&value_program, &gradient_program].map(Evaluator::new);
        Self { variables, rows: rows.len(), value, gradient, jacobian, hessian, directions, places, slopes }
    }

    /// Number of variables.
    pub fn variables(&self) -> usize {
        self.variables
    }
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }
    /// Row and variable of each element of ∂r/∂x.
    pub fn jacobian_structure(&self) -> &[[usize; 2]] {
        &self.jacobian
    }
    /// Variables of each element of the second derivatives, the larger first.
    pub fn hessian_structure(&self) -> &[[usize; 2]] {
        &self.hessian
    }

    /// r(x).
    pub fn values(&self, x: &[f64], out: &mut [f64]) {
        self.value.run_one(&State::new().with(Argument::Parameters, x), out);
    }

    /// ∂r/∂x in the order of its structure.
    pub fn jacobian(&self, x: &[f64], out: &mut [f64]) {
        if self.slopes[0].run(x.iter().copied(), out) {
            return;
        }
        let mut workspace = self.value.workspace::<Slopes>();
        let mut rows = vec![Slopes::constant(0.0); self.rows];
        for first in (0..self.variables).step_by(LANES) {
            let seeded = seeded(x, |k| (first..first + LANES).contains(&k).then(|| k - first));
            self.value.run(&State::new().with(Argument::Parameters, &seeded), &mut workspace, &mut rows);
            let slopes: Vec<[f64; LANES]> = rows.iter().map(|row| row.1.to_array()).collect();
            for (&[row, variable], out) in self.jacobian.iter().zip(out.iter_mut()) {
                if (first..first + LANES).contains(&variable) {
                    *out = slopes[row][variable - first];
                }
            }
        }
    }

    /// Second derivatives of Σ multiplier · row in the order of their structure.
    pub fn hessian(&self, x: &[f64], multipliers: &[f64], out: &mut [f64]) {
        if self.slopes[1].run(x.iter().chain(multipliers).copied(), out) {
            return;
        }
        let all: Vec<f64> = x.iter().chain(multipliers).copied().collect();
        let mut workspace = self.gradient.workspace::<Slopes>();
        let mut rows = vec![Slopes::constant(0.0); self.variables];
        for (group, directions) in self.directions.chunks(LANES).enumerate() {
            let seeded = seeded(&all, |k| directions.iter().position(|&d| d == k));
            self.gradient.run(&State::new().with(Argument::Parameters, &seeded), &mut workspace, &mut rows);
            let slopes: Vec<[f64; LANES]> = rows.iter().map(|row| row.1.to_array()).collect();
            for (&[of, lane, row], out) in self.places.iter().zip(out.iter_mut()) {
                if of == group {
                    *out = slopes[row][lane];
                }
            }
        }
    }
}

/// Numbers with a slope of 1 in the lane that is said of them.
fn seeded(x: &[f64], lane: impl Fn(usize) -> Option<usize>) -> Vec<Slopes> {
    let number = |(k, &value): (usize, &f64)| {
        let mut slope = [0.0; LANES];
        if let Some(lane) = lane(k) {
            slope[lane] = 1.0;
        }
        Slopes(value, F64x8::from_array(slope))
    };
    x.iter().enumerate().map(number).collect()
}

/// Few variables such that each pair has one of them.
fn cover(pairs: &[[usize; 2]]) -> Vec<usize> {
    let mut chosen: BTreeSet<usize> = pairs.iter().filter(|[i, j]| i == j).map(|pair| pair[0]).collect();
    loop {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for k in pairs.iter().filter(|pair| pair.iter().all(|k| !chosen.contains(k))).flatten() {
            *counts.entry(*k).or_default() += 1;
        }
        let Some((&most, _)) = counts.iter().max_by_key(|(_, count)| **count) else { break };
        chosen.insert(most);
    }
    chosen.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn machine_code_gives_what_numbers_with_slopes_give() {
        let graph = Graph::new();
        let x: Vec<Sym<'_>> =
            (0..11).map(|k| Sym::new(&graph, graph.input(Argument::Parameters, k))).collect();
        let angle = x[0] + x[1] * x[9];
        let root = (x[2] * x[2] + x[10] * x[10] + x[3]).sqrt();
        let rows = [angle.sin() * x[3] - x[4], x[5] / root - x[6] * angle.cos(), root * x[7] * x[8] - x[10]];
        let of = LocalFunction::new(&graph, 11, &rows);
        let at: Vec<f64> = (0..11).map(|k| 0.3 + 0.17 * k as f64).collect();
        let multipliers = [0.7, -1.1, 2.3];
        let both = || {
            let mut slopes = vec![f64::NAN; of.jacobian_structure().len()];
            of.jacobian(&at, &mut slopes);
            let mut second = vec![f64::NAN; of.hessian_structure().len()];
            of.hessian(&at, &multipliers, &mut second);
            (slopes, second)
        };
        let first = both();
        assert!(first.0.iter().chain(&first.1).all(|x| x.is_finite()));
        (0..50).for_each(|_| assert_eq!(both(), first));
    }

    /// r = (x² y + z, sin x · w, x w): first and second derivatives by hand.
    #[test]
    fn derivatives_are_those_by_hand() {
        let graph = Graph::new();
        let [x, y, z, w] = [0, 1, 2, 3].map(|k| Sym::new(&graph, graph.input(Argument::Parameters, k)));
        let of = LocalFunction::new(&graph, 4, &[x * x * y + z, x.sin() * w, x * w]);
        let at = [0.7, -1.3, 0.4, 2.1];
        let mut values = [0.0; 3];
        of.values(&at, &mut values);
        assert!((values[0] - (0.49 * -1.3 + 0.4)).abs() < 1e-15);
        let mut slopes = vec![0.0; of.jacobian_structure().len()];
        of.jacobian(&at, &mut slopes);
        let expected = |[row, variable]: [usize; 2]| match (row, variable) {
            (0, 0) => 2.0 * 0.7 * -1.3,
            (0, 1) => 0.49,
            (0, 2) => 1.0,
            (1, 0) => 0.7f64.cos() * 2.1,
            (1, 3) => 0.7f64.sin(),
            (2, 0) => 2.1,
            (2, 3) => 0.7,
            other => panic!("{other:?}"),
        };
        assert_eq!(slopes.len(), 7);
        for (&place, slope) in of.jacobian_structure().iter().zip(&slopes) {
            assert!((slope - expected(place)).abs() < 1e-14, "{place:?}");
        }
        let multipliers = [0.5, -2.0, 3.0];
        let mut second = vec![0.0; of.hessian_structure().len()];
        of.hessian(&at, &multipliers, &mut second);
        let expected = |pair: [usize; 2]| match pair {
            [0, 0] => 0.5 * 2.0 * -1.3 + 2.0 * 0.7f64.sin() * 2.1,
            [1, 0] => 0.5 * 2.0 * 0.7,
            [3, 0] => -2.0 * 0.7f64.cos() + 3.0,
            other => panic!("{other:?}"),
        };
        assert_eq!(second.len(), 3);
        for (&pair, value) in of.hessian_structure().iter().zip(&second) {
            assert!((value - expected(pair)).abs() < 1e-14, "{pair:?}");
        }
    }
}
