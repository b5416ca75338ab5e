//! Expressions with operators.
use super::graph::Graph;
use super::node::{Call, Expr};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An expression together with its graph, so that formulas read like formulas.
#[derive(Clone, Copy)]
pub struct Sym<'g> {
    /// The graph that holds it.
    pub graph: &'g Graph,
    /// The expression.
    pub expr: Expr,
}

impl std::fmt::Debug for Sym<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.expr.fmt(f)
    }
}

impl<'g> Sym<'g> {
    /// Wraps an expression of `graph`.
    pub fn new(graph: &'g Graph, expr: Expr) -> Self {
        Self { graph, expr }
    }
    /// Whether it is the constant 0.
    pub fn is_zero(self) -> bool {
        self.expr == Expr::ZERO
    }
    /// The value, if constant.
    pub fn constant_value(self) -> Option<f64> {
        self.graph.constant_value(self.expr)
    }
    /// A constant of the same graph.
    pub fn constant(self, value: f64) -> Self {
        Self::new(self.graph, self.graph.constant(value))
    }
    /// 0 of the same graph.
    pub fn zero(self) -> Self {
        Self::new(self.graph, Expr::ZERO)
    }
    /// Sine.
    pub fn sin(self) -> Self {
        Self::new(self.graph, self.graph.sin(self.expr))
    }
    /// Cosine.
    pub fn cos(self) -> Self {
        Self::new(self.graph, self.graph.cos(self.expr))
    }
    /// Sine of any expression.
    pub fn sin_of_any(self) -> Self {
        if self.graph.depends_on_angles(self.expr) { self.call(Call::Sin) } else { self.sin() }
    }
    /// Cosine of any expression.
    pub fn cos_of_any(self) -> Self {
        if self.graph.depends_on_angles(self.expr) { self.call(Call::Cos) } else { self.cos() }
    }
    /// A function of the laws of effects.
    pub fn call(self, call: Call) -> Self {
        Self::new(self.graph, self.graph.call(call, self.expr))
    }
    /// The larger of two.
    pub fn larger(self, other: Self) -> Self {
        Self::new(self.graph, self.graph.larger(self.expr, other.expr))
    }
    /// Square root.
    pub fn sqrt(self) -> Self {
        Self::new(self.graph, self.graph.sqrt(self.expr))
    }
}

impl<'g> Neg for Sym<'g> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(self.graph, -self.expr)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<'g> $trait for Sym<'g> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self::new(self.graph, self.graph.$method(self.expr, other.expr))
            }
        }
        impl<'g> $trait<f64> for Sym<'g> {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                let other = self.graph.constant(other);
                Self::new(self.graph, self.graph.$method(self.expr, other))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);
