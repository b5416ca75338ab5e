//! Tests of the expression graph.
// 1.5708 and 3.1416 are what URDFs write.
#![allow(clippy::approx_constant)]
use super::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn inputs() -> (Graph, Expr, Expr) {
    let g = Graph::new();
    let (x, y) = (g.input(Argument::Q, 0), g.input(Argument::Q, 1));
    (g, x, y)
}

#[test]
fn signs_share_nodes() {
    let (g, x, y) = inputs();
    assert_eq!(g.sub(x, y), -g.sub(y, x));
    assert_eq!(g.mul(-x, y), -g.mul(y, x));
    assert_eq!(g.add(-x, -y), -g.add(x, y));
    assert_eq!(g.sin(-x), -g.sin(x));
    assert_eq!(g.cos(-x), g.cos(x));
}

#[test]
fn zeros_ones_and_constants_fold() {
    let (g, x, y) = inputs();
    assert_eq!(g.sub(x, x), Expr::ZERO);
    assert_eq!(g.mul(x, Expr::ZERO), Expr::ZERO);
    assert_eq!(g.mul(-Expr::ONE, x), -x);
    assert_eq!(-Expr::ZERO, Expr::ZERO);
    let (two, three) = (g.constant(2.0), g.constant(-3.0));
    assert_eq!(g.mul(two, g.mul(three, y)), g.mul(g.constant(-6.0), y));
    assert_eq!(g.add(x, x), g.mul(two, x));
    assert_eq!(g.div(x, two), g.mul(g.constant(0.5), x));
}

#[test]
fn what_is_taken_away_again_leaves_no_trace() {
    let (g, x, y) = inputs();
    let sum = g.sub(x, y);
    assert_eq!(g.add(sum, y), x);
    assert_eq!(g.sub(x, sum), y);
    assert_eq!(g.sub(sum, x), -y);
    assert_eq!(g.add(-x, sum), -y);
    assert_ne!(g.add(sum, x), -y);
    let quotient = g.div(y, -x);
    assert_eq!(g.mul(x, quotient), -y);
    assert_eq!(g.mul(g.div(Expr::ONE, x), -x), -Expr::ONE);
}

#[test]
fn sine_squared_plus_cosine_squared_is_one() {
    let (g, x, y) = inputs();
    let (s, c) = (g.sin(x), g.cos(x));
    assert_eq!(g.add(g.mul(s, s), g.mul(c, c)), Expr::ONE);
    assert_ne!(g.add(g.mul(s, s), g.mul(g.cos(y), g.cos(y))), Expr::ONE);
}

#[test]
fn an_exact_graph_rounds_nothing() {
    let g = Graph::exact();
    let (a, b) = (g.constant(0.1), g.constant(0.2));
    assert_eq!(g.constant_value(g.add(a, b)), None);
    assert_eq!(g.constant_value(g.mul(a, b)), None);
    assert_eq!(g.constant_value(g.div(a, g.constant(3.0))), None);
    assert_eq!(g.constant_value(g.mul(g.constant(0.5), g.constant(3.0))), Some(1.5));
    assert_eq!(g.constant_value(g.sin(a)), None);
    assert_eq!(g.cos(g.constant(FRAC_PI_2)), Expr::ZERO);
    assert_eq!(g.sin(g.constant(-PI)), Expr::ZERO);
    assert_eq!(g.sin(g.constant(-FRAC_PI_2)), -Expr::ONE);
    assert_eq!(g.constant_value(g.cos(g.constant(1.5708))), None);
}
