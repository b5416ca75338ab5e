//! Where a search stands: variables, slacks, multipliers, and everything evaluated there.
use super::scaling::Scaling;
use super::{Central, Program};

/// A program with slacks: cᵢ(x) = sᵢ between two numbers, or cᵢ(x) = limit.
pub(super) struct Slacked<'p> {
    pub program: &'p dyn Program,
    pub scaling: Scaling,
    /// Of the variables, then of the slacks, a little wider than asked for; an equation's slack has one value.
    pub bounds: Vec<[f64; 2]>,
    pub n: usize,
    pub m: usize,
    pub jacobian: Vec<[usize; 2]>,
    pub hessian: Vec<[usize; 2]>,
}

/// Variables and slacks with their multipliers.
#[derive(Debug, Clone)]
pub(super) struct Iterate {
    /// Variables, then slacks.
    pub x: Vec<f64>,
    /// Of the constraints.
    pub y: Vec<f64>,
    /// Of lower and upper bounds of variables and slacks.
    pub z: Vec<[f64; 2]>,
}

/// Values at an iterate, scaled.
#[derive(Debug, Clone)]
pub(super) struct Values {
    pub objective: f64,
    pub gradient: Vec<f64>,
    pub residual: Vec<f64>,
    pub jacobian: Vec<f64>,
}

/// Part of its room that a variable keeps from bounds at the beginning, and one that is known from a neighbour.
const FAR: f64 = 1e-2;
const NEAR: f64 = 1e-5;

/// How much wider bounds are than asked for, relative to their size.
const WIDER: f64 = 1e-8;

impl<'p> Slacked<'p> {
    pub fn new(program: &'p dyn Program, start: &[f64]) -> Self {
        let jacobian = program.jacobian_structure();
        let scaling = Scaling::new(program, &jacobian, start);
        let limits = program.limits();
        let wider = |[low, high]: [f64; 2]| {
            [low - WIDER * low.abs().clamp(1.0, 1e8), high + WIDER * high.abs().clamp(1.0, 1e8)]
        };
        let bounds = program.bounds();
        let (n, m) = (bounds.len(), limits.len());
        let of_rows = limits.iter().zip(&scaling.rows).map(|(&[low, high], factor)| {
            let scaled = [low * factor, high * factor];
            if low == high { scaled } else { wider(scaled) }
        });
        let bounds = bounds.into_iter().map(wider).chain(of_rows).collect();
        let hessian = program.hessian_structure();
        Self { program, bounds, n, m, jacobian, hessian, scaling }
    }

    /// Whether a row is an equation.
    pub fn equation(&self, row: usize) -> bool {
        let [low, high] = self.bounds[self.n + row];
        low == high
    }

    /// The first iterate, inside all bounds.
    pub fn begin(&self, start: &[f64], barrier: f64) -> Iterate {
        let x = self.inside(start, FAR);
        let (y, z) = (vec![0.0; self.m], self.central(&x, barrier));
        Iterate { x, y, z }
    }

    /// The first iterate from a place on the central path of a neighbour. Slacks are where its multipliers are central, whatever limits have become: what
    /// they have moved by is left to the constraints, and nothing else is to be made up for.
    pub fn go_on(&self, from: &Central) -> Iterate {
        let mut x = self.inside(&from.x, NEAR);
        let scaled = from.multipliers.iter().zip(&self.scaling.rows);
        let y: Vec<f64> = scaled.map(|(y, factor)| y * self.scaling.objective / factor).collect();
        for (row, y) in y.iter().enumerate() {
            let slack = central_place(self.bounds[self.n + row], -y, from.barrier);
            x[self.n + row] = slack.unwrap_or(x[self.n + row]);
        }
        let z = self.central(&x, from.barrier);
        Iterate { x, y, z }
    }

    /// Variables, then slacks, this part of their room away from all bounds.
    fn inside(&self, start: &[f64], push: f64) -> Vec<f64> {
        let inside = |x: f64, [low, high]: [f64; 2]| {
            let room = |b: f64| (push * b.abs().max(1.0)).min(push * (high - low));
            let (from, to) = (low + room(low), high - room(high));
            if low.is_finite() && x < from {
                from
            } else if high.is_finite() && x > to {
                to
            } else {
                x
            }
        };
        let mut x: Vec<f64> = start.iter().zip(&self.bounds).map(|(&x, &b)| inside(x, b)).collect();
        let mut values = vec![0.0; self.m];
        self.program.constraints(&x, &mut values);
        for (row, value) in values.iter().enumerate() {
            let bounds = self.bounds[self.n + row];
            let value = value * self.scaling.rows[row];
            x.push(if self.equation(row) { bounds[0] } else { inside(value, bounds) });
        }
        x
    }

    /// Multipliers of the constraints, unscaled.
    pub fn multipliers(&self, y: &[f64]) -> Vec<f64> {
        y.iter().zip(&self.scaling.rows).map(|(y, factor)| y * factor / self.scaling.objective).collect()
    }

    /// Multipliers of the bounds on the central path.
    pub fn central(&self, x: &[f64], barrier: f64) -> Vec<[f64; 2]> {
        let of = |k: usize| self.distances(x, k).map(|d| if d.is_finite() { barrier / d } else { 0.0 });
        (0..x.len()).map(of).collect()
    }

    /// Distances from both bounds; of an equation's slack infinite.
    pub fn distances(&self, x: &[f64], k: usize) -> [f64; 2] {
        let [low, high] = self.bounds[k];
        if low == high { [f64::INFINITY; 2] } else { [x[k] - low, high - x[k]] }
    }

    /// Residuals c − s, scaled.
    pub fn residual(&self, x: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.m];
        self.program.constraints(&x[..self.n], &mut values);
        for (row, value) in values.iter_mut().enumerate() {
            *value = *value * self.scaling.rows[row] - x[self.n + row];
        }
        values
    }

    pub fn objective(&self, x: &[f64]) -> f64 {
        self.program.objective(&x[..self.n]) * self.scaling.objective
    }

    /// Everything but second derivatives.
    pub fn values(&self, x: &[f64]) -> Values {
        let mut gradient = vec![0.0; self.n];
        self.program.gradient(&x[..self.n], &mut gradient);
        gradient.iter_mut().for_each(|g| *g *= self.scaling.objective);
        let mut jacobian = vec![0.0; self.jacobian.len()];
        self.program.jacobian(&x[..self.n], &mut jacobian);
        for (value, &[row, _]) in jacobian.iter_mut().zip(&self.jacobian) {
            *value *= self.scaling.rows[row];
        }
        Values { objective: self.objective(x), gradient, residual: self.residual(x), jacobian }
    }

    /// Second derivatives of the Lagrangian.
    pub fn second(&self, x: &[f64], y: &[f64]) -> Vec<f64> {
        let multipliers: Vec<f64> = y.iter().zip(&self.scaling.rows).map(|(y, factor)| y * factor).collect();
        let mut values = vec![0.0; self.hessian.len()];
        self.program.hessian(&x[..self.n], self.scaling.objective, &multipliers, &mut values);
        values
    }

    /// f − μ Σ ln of all distances from bounds.
    pub fn barrier_function(&self, x: &[f64], objective: f64, barrier: f64) -> f64 {
        let mut logarithms = 0.0;
        for k in 0..x.len() {
            for distance in self.distances(x, k).into_iter().filter(|d| d.is_finite()) {
                logarithms += distance.ln();
            }
        }
        objective - barrier * logarithms
    }

    /// −μ (1/(x − l) − 1/(u − x)): the barriers' part of a gradient.
    pub fn barrier_slope(&self, x: &[f64], k: usize, barrier: f64) -> f64 {
        let [low, high] = self.distances(x, k);
        barrier / high - barrier / low
    }

    /// The longest step of `x` along `d`, up to 1, that keeps this part of the distance from each bound.
    pub fn longest(&self, x: &[f64], d: &[f64], kept: f64) -> f64 {
        let mut longest: f64 = 1.0;
        for (k, &d) in d.iter().enumerate().take(x.len()) {
            let [low, high] = self.distances(x, k);
            if d < 0.0 && low.is_finite() {
                longest = longest.min((1.0 - kept) * low / -d);
            } else if d > 0.0 && high.is_finite() {
                longest = longest.min((1.0 - kept) * high / d);
            }
        }
        longest
    }

    /// Gradient of the Lagrangian by variables and slacks, without that of the bounds.
    pub fn lagrangian_gradient(&self, values: &Values, y: &[f64]) -> Vec<f64> {
        let mut gradient = values.gradient.clone();
        for (value, &[row, column]) in values.jacobian.iter().zip(&self.jacobian) {
            gradient[column] += value * y[row];
        }
        gradient.extend((0..self.m).map(|row| if self.equation(row) { 0.0 } else { -y[row] }));
        gradient
    }

    /// Largest errors of the conditions of a minimum at barrier μ: stationarity, constraints, complementarity.
    pub fn errors(&self, at: &Iterate, values: &Values, barrier: f64) -> [f64; 3] {
        let gradient = self.lagrangian_gradient(values, &at.y);
        let (mut dual, mut complementary) = (0.0f64, 0.0f64);
        let (mut sum, mut count) = (0.0, 0usize);
        for (k, slope) in gradient.iter().enumerate() {
            let distances = self.distances(&at.x, k);
            if k < self.n || !self.equation(k - self.n) {
                dual = dual.max((slope - at.z[k][0] + at.z[k][1]).abs());
            }
            for (distance, z) in distances.into_iter().zip(at.z[k]).filter(|(d, _)| d.is_finite()) {
                complementary = complementary.max((distance * z - barrier).abs());
                sum += z;
                count += 1;
            }
        }
        let of_rows: f64 = at.y.iter().map(|y| y.abs()).sum();
        let scale = |total: f64, count: usize| (total / count.max(1) as f64).max(100.0) / 100.0;
        dual /= scale(sum + of_rows, count + self.m);
        complementary /= scale(sum, count);
        [dual, largest(&values.residual), complementary]
    }
}

/// Where between two bounds μ/(x − l) − μ/(u − x) has a value: nowhere if there is no bound to push that way.
fn central_place([low, high]: [f64; 2], push: f64, barrier: f64) -> Option<f64> {
    match (low.is_finite(), high.is_finite()) {
        (true, true) if low < high => {
            // From the nearer bound, so that nothing cancels.
            let (width, size) = (high - low, push.abs());
            let root = (size * width).hypot(2.0 * barrier);
            let distance = 2.0 * barrier * width / (size * width + 2.0 * barrier + root);
            Some(if push > 0.0 { low + distance } else { high - distance })
        }
        (true, false) if push > 0.0 => Some(low + barrier / push),
        (false, true) if push < 0.0 => Some(high + barrier / push),
        _ => None,
    }
}

/// Largest magnitude; NaN if there is one.
pub(super) fn largest(of: &[f64]) -> f64 {
    of.iter().fold(0.0, |a: f64, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b.abs()) })
}

/// Sum of magnitudes.
pub(super) fn total(of: &[f64]) -> f64 {
    of.iter().map(|x| x.abs()).sum()
}
