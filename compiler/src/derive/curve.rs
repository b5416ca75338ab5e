//! Functions of φ by numbers: Bezier polynomials of outputs, splines of torques.
use super::virtual_constraints::inverse;
use crate::description::gait::Curve;
use crate::expression::Sym;

/// x between two numbers.
fn clipped<'g>(x: Sym<'g>, low: f64, high: f64) -> Sym<'g> {
    -(-x.larger(x.constant(low))).larger(x.constant(-high))
}

/// Σ c_k C(n,k) s^k (1−s)^(n−k), s = (φ − a)/(b − a), which stays where it is beyond [`Curve::BEYOND`].
pub fn bezier<'g>(phase: Sym<'g>, coefficients: &[f64], [a, b]: [f64; 2]) -> Sym<'g> {
    let s = clipped((phase - a) / phase.constant(b - a), -Curve::BEYOND, 1.0 + Curve::BEYOND);
    bernstein(s, coefficients.len(), |k, power, binomial| power * (coefficients[k] * binomial))
}

/// Σ t_k (1−s)^(n−k) over `count` terms, n = count − 1; `term` makes t_k of k, s^k and C(n,k).
pub fn bernstein<'g>(s: Sym<'g>, count: usize, term: impl Fn(usize, Sym<'g>, f64) -> Sym<'g>) -> Sym<'g> {
    let rest = s.constant(1.0) - s;
    let degree = count.saturating_sub(1);
    let (mut sum, mut power, mut binomial) = (s.zero(), s.constant(1.0), 1.0);
    for k in 0..count {
        sum = sum * rest + term(k, power, binomial);
        power = power * s;
        binomial = binomial * (degree - k) as f64 / (k + 1) as f64;
    }
    sum
}

/// Cubic splines through values at growing places, one for each list of values; they share their basis, powers of s = (φ − first)/(last −
/// first) and cubes of what s is beyond all places but the two first and the two last ones. Beyond its ends a spline stays where it is.
pub fn splines<'g>(phase: Sym<'g>, at: &[f64], values: &[&[f64]]) -> Option<Vec<Sym<'g>>> {
    let (first, last) = (*at.first()?, *at.last()?);
    let knots: Vec<f64> = at.iter().map(|x| (x - first) / (last - first)).collect();
    let inner = knots.get(2..knots.len().checked_sub(2)?)?;
    let basis = |s: f64| {
        let powers = (0..4).map(|k| s.powi(k));
        powers.chain(inner.iter().map(|knot| (s - knot).max(0.0).powi(3))).collect::<Vec<f64>>()
    };
    let inverse = inverse(knots.iter().map(|&s| basis(s)).collect())?;
    let s = clipped((phase - first) / phase.constant(last - first), 0.0, 1.0);
    let cube = |x: Sym<'g>| x * x * x;
    let powers = [phase.constant(1.0), s, s * s, cube(s)];
    let functions: Vec<Sym<'g>> =
        powers.into_iter().chain(inner.iter().map(|&knot| cube((s - knot).larger(s.zero())))).collect();
    let spline = |values: &&[f64]| {
        let weight = |row: &Vec<f64>| row.iter().zip(values.iter()).map(|(a, y)| a * y).sum::<f64>();
        inverse.iter().zip(&functions).fold(s.zero(), |sum, (row, &function)| sum + function * weight(row))
    };
    Some(values.iter().map(spline).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Graph;
    use crate::program::{Evaluator, Order, lower};
    use bipedc_runtime::{Argument, State};

    fn at(make: impl for<'g> Fn(Sym<'g>) -> Sym<'g>, x: f64) -> f64 {
        let graph = Graph::new();
        let of = make(Sym::new(&graph, graph.input(Argument::Q, 0)));
        let evaluator = Evaluator::new(&lower(&graph, &[of.expr], Order::Derivation));
        let mut out = [f64::NAN];
        evaluator.run(&State::new().with(Argument::Q, &[x]), &mut evaluator.workspace(), &mut out);
        out[0]
    }

    #[test]
    fn bezier_polynomials_are_those_of_de_casteljau() {
        let c = [0.3, -1.2, 0.7, 2.0, -0.4, 0.9];
        let casteljau = |s: f64| {
            let mut points = c.to_vec();
            while points.len() > 1 {
                points = points.windows(2).map(|p| (1.0 - s) * p[0] + s * p[1]).collect();
            }
            points[0]
        };
        for s in [-0.15, -0.1, 0.0, 0.25, 0.5, 0.99, 1.0, 1.1] {
            let found = at(|x| bezier(x, &c, [-0.2, 0.6]), -0.2 + 0.8 * s);
            assert!((found - casteljau(s)).abs() < 1e-13, "{s}: {found}");
        }
        let beyond = at(|x| bezier(x, &c, [0.0, 1.0]), 7.0);
        assert!((beyond - casteljau(1.15)).abs() < 1e-13);
    }

    #[test]
    fn splines_go_through_their_values_and_are_cubics_where_the_values_are() {
        let knots = [0.1, 0.15, 0.3, 0.42, 0.5, 0.7, 0.71, 0.9];
        let wild = [3.0, -1.0, 2.0, 2.5, -4.0, 0.0, 1.0, 7.0];
        let cubic = |x: f64| 1.0 - 2.0 * x + 5.0 * x * x - 7.0 * x * x * x;
        let smooth = knots.map(cubic);
        for (&x, &y) in knots.iter().zip(&wild) {
            let found = at(|x| splines(x, &knots, &[&wild]).unwrap()[0], x);
            assert!((found - y).abs() < 1e-9, "{x}: {found} {y}");
        }
        for k in 0..=20 {
            let x = 0.1 + 0.04 * f64::from(k);
            let found = at(|x| splines(x, &knots, &[&wild, &smooth]).unwrap()[1], x);
            assert!((found - cubic(x)).abs() < 1e-10, "{x}: {found}");
        }
        let beyond = at(|x| splines(x, &knots, &[&wild]).unwrap()[0], 2.0);
        assert!((beyond - 7.0).abs() < 1e-9);
    }

    /// scipy.interpolate.CubicSpline(at, values)(x), third derivatives continuous at the second and last but one place.
    #[test]
    fn splines_are_those_of_others() {
        let knots = [0.0, 1.0, 2.5, 3.0, 4.2, 5.0];
        let values = [1.0, 2.0, 0.5, -1.0, 0.0, 3.0];
        for (x, expected) in EXPECTED {
            let found = at(|x| splines(x, &knots, &[&values]).unwrap()[0], x);
            assert!((found - expected).abs() < 1e-12, "{x}: {found} {expected}");
        }
    }

    const EXPECTED: [(f64, f64); 4] = [
        (0.4, 1.4864972972972974),
        (1.7, 1.9472828828828832),
        (3.6, -1.2968851351351351),
        (4.9, 2.594664132882884),
    ];
}
