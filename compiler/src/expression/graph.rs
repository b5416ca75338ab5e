//! All expressions of one compilation, and the identities applied while they are built.
use super::node::{Call, Expr, Input, Node};
use super::{Purpose, decimal, exact_sin_cos};
use bipedc_runtime::Argument;
use rustc_hash::FxHashMap;
use std::cell::{Cell, RefCell};

#[derive(PartialEq, Eq, Hash)]
enum Key {
    Constant(u64),
    Input(Input),
    Binary(u8, Expr, Expr),
    Unary(u8, Expr),
}

impl Key {
    fn of(node: Node) -> Self {
        match node {
            Node::Constant(value) => Self::Constant(value.to_bits()),
            Node::Input(input) => Self::Input(input),
            Node::Add(a, b) => Self::Binary(0, a, b),
            Node::Mul(a, b) => Self::Binary(1, a, b),
            Node::Div(a, b) => Self::Binary(2, a, b),
            Node::Sqrt(a) => Self::Unary(0, a),
            Node::Sin(a) => Self::Unary(1, a),
            Node::Cos(a) => Self::Unary(2, a),
            Node::Call(call, a) => Self::Unary(3 + call as u8, a),
            Node::Larger(a, b) => Self::Binary(3, a, b),
        }
    }
}

#[derive(Default)]
struct Store {
    nodes: Vec<Node>,
    /// What each node was made for.
    purposes: Vec<Purpose>,
    ids: FxHashMap<Key, u32>,
}

impl Store {
    fn intern(&mut self, node: Node, purpose: Purpose) -> Expr {
        let next = self.nodes.len() as u32;
        let id = *self.ids.entry(Key::of(node)).or_insert(next);
        if id == next {
            self.nodes.push(node);
            self.purposes.push(purpose);
        }
        Expr::new(id as usize)
    }
}

/// All expressions of one compilation.
///
/// Grows through shared references, so that [`crate::expression::Sym`] can be `Copy` and carry operators.
pub struct Graph {
    store: RefCell<Store>,
    exact: bool,
    divided_by_zero: Cell<bool>,
    pub(super) purpose: Cell<Purpose>,
}

impl Default for Graph {
    fn default() -> Self {
        Self::new()
    }
}

impl Graph {
    /// A graph that knows 0 and 1.
    pub fn new() -> Self {
        Self::with_exactness(false)
    }

    /// A graph for exact analysis: nothing in it is rounded (but the square root of a number, once).
    ///
    /// Numbers fold only where the result is certainly exact, and sine and cosine of a constant stay nodes
    /// unless the angle is a multiple of π/2. What is nearly one is for [`crate::tree::Tree::structure`] to decide.
    pub fn exact() -> Self {
        Self::with_exactness(true)
    }

    fn with_exactness(exact: bool) -> Self {
        let graph = Self {
            store: RefCell::default(),
            exact,
            divided_by_zero: Cell::new(false),
            purpose: Cell::default(),
        };
        assert_eq!(graph.intern(Node::Constant(0.0)), Expr::ZERO);
        assert_eq!(graph.intern(Node::Constant(1.0)), Expr::ONE);
        graph
    }

    /// Whether nothing may be rounded.
    pub fn is_exact(&self) -> bool {
        self.exact
    }

    /// Whether something was divided by the constant 0: then what was derived means nothing, and is refused.
    pub fn divided_by_zero(&self) -> bool {
        self.divided_by_zero.get()
    }

    /// Whether sum, difference and product of these two numbers may be formed here.
    fn may_fold(&self, x: f64, y: f64) -> bool {
        // Sixteenths below 2^16: their products have 40 bits, so no bit is lost, and they are read as
        // fractions by the exact analysis as what they are.
        let short = |x: f64| x.abs() < 65536.0 && (x * 16.0).fract() == 0.0;
        let finite = (x + y).is_finite() && (x * y).is_finite();
        finite && (!self.exact || (short(x) && short(y)))
    }

    fn intern(&self, node: Node) -> Expr {
        self.store.borrow_mut().intern(node, self.purpose.get())
    }

    /// Number of nodes so far.
    pub fn len(&self) -> usize {
        self.store.borrow().nodes.len()
    }

    /// Never true: 0 and 1 are always there.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The node with this index.
    pub fn node(&self, index: usize) -> Node {
        self.store.borrow().nodes[index]
    }

    /// A copy of all nodes, operands before users.
    pub fn nodes(&self) -> Vec<Node> {
        self.store.borrow().nodes.clone()
    }

    /// What each node was made for, by index.
    pub fn purposes(&self) -> Vec<Purpose> {
        self.store.borrow().purposes.clone()
    }

    /// The value of a constant expression.
    pub fn constant_value(&self, e: Expr) -> Option<f64> {
        match self.node(e.node()) {
            Node::Constant(value) => Some(if e.is_negated() { -value } else { value }),
            _ => None,
        }
    }

    /// A number.
    ///
    /// # Panics
    /// On NaN and infinity: descriptions are checked for them before anything is derived.
    pub fn constant(&self, value: f64) -> Expr {
        assert!(value.is_finite(), "constants of an expression are finite, got {value}");
        self.intern(Node::Constant(value.abs())).negate_if(value < 0.0)
    }

    /// An element of an argument.
    pub fn input(&self, argument: Argument, index: usize) -> Expr {
        self.intern(Node::Input(Input { argument, index: index as u32 }))
    }

    /// `a + b`
    pub fn add(&self, a: Expr, b: Expr) -> Expr {
        if a == Expr::ZERO {
            return b;
        }
        if b == Expr::ZERO {
            return a;
        }
        if a == -b {
            return Expr::ZERO;
        }
        if a == b {
            return self.mul(self.constant(2.0), a);
        }
        if let (Some(x), Some(y)) = (self.constant_value(a), self.constant_value(b))
            && self.may_fold(x, y)
        {
            return self.constant(decimal::sum(x, y));
        }
        if self.is_sine_and_cosine_squared(a, b) {
            return Expr::ONE;
        }
        if let Some(rest) = self.without(a, b).or_else(|| self.without(b, a)) {
            return rest;
        }
        // Canonical: the smaller node first and positive.
        let (first, second) = if a.node() <= b.node() { (a, b) } else { (b, a) };
        let flip = first.is_negated();
        self.intern(Node::Add(first.abs(), second.negate_if(flip))).negate_if(flip)
    }

    /// `sum + other` where `other` takes a term away again: (x + y) − y = x.
    fn without(&self, sum: Expr, other: Expr) -> Option<Expr> {
        let Node::Add(x, y) = self.node(sum.node()) else { return None };
        let (x, y) = (x.negate_if(sum.is_negated()), y.negate_if(sum.is_negated()));
        if other == -x {
            return Some(y);
        }
        (other == -y).then_some(x)
    }

    /// Whether `a + b` is sin² x + cos² x.
    fn is_sine_and_cosine_squared(&self, a: Expr, b: Expr) -> bool {
        let square = |e: Expr| match self.node(e.node()) {
            Node::Mul(x, y) if x == y && !e.is_negated() => Some(self.node(x.node())),
            _ => None,
        };
        matches!(
            (square(a), square(b)),
            (Some(Node::Sin(x)), Some(Node::Cos(y))) | (Some(Node::Cos(x)), Some(Node::Sin(y))) if x == y
        )
    }

    /// `a - b`
    pub fn sub(&self, a: Expr, b: Expr) -> Expr {
        self.add(a, -b)
    }

    /// `a * b`
    pub fn mul(&self, a: Expr, b: Expr) -> Expr {
        let negated = a.is_negated() != b.is_negated();
        let (a, b) = (a.abs(), b.abs());
        // x * 0 folds to 0 although inf * 0 is not: structural zeros depend on it, and inputs are finite.
        if a == Expr::ZERO || b == Expr::ZERO {
            return Expr::ZERO;
        }
        if a == Expr::ONE {
            return b.negate_if(negated);
        }
        if b == Expr::ONE {
            return a.negate_if(negated);
        }
        for (factor, quotient) in [(a, b), (b, a)] {
            match self.node(quotient.node()) {
                // x (n / x) = n
                Node::Div(over, under) if under == factor => return over.negate_if(negated),
                _ => {}
            }
        }
        let (a, b) = if a <= b { (a, b) } else { (b, a) };
        match (self.constant_value(a), self.constant_value(b)) {
            (Some(x), Some(y)) if self.may_fold(x, y) => {
                self.constant(decimal::product(x, y)).negate_if(negated)
            }
            (Some(_), Some(_)) => self.intern(Node::Mul(a, b)).negate_if(negated),
            (Some(x), None) => self.scale(x, a, b).negate_if(negated),
            (None, Some(y)) => self.scale(y, b, a).negate_if(negated),
            (None, None) => self.intern(Node::Mul(a, b)).negate_if(negated),
        }
    }

    /// `factor * e`, where `factor` is the node of the positive constant and `e` positive and not constant.
    fn scale(&self, factor: f64, constant: Expr, e: Expr) -> Expr {
        if let Node::Mul(x, y) = self.node(e.node()) {
            for (inner, rest) in [(x, y), (y, x)] {
                if let Some(value) = self.constant_value(inner)
                    && self.may_fold(factor, value)
                {
                    return self.mul(self.constant(decimal::product(factor, value)), rest);
                }
            }
        }
        let (a, b) = if constant <= e { (constant, e) } else { (e, constant) };
        self.intern(Node::Mul(a, b))
    }

    /// `a / b`; a division by a constant becomes a product (in an exact graph by a power of two only).
    ///
    /// A division by the constant 0 is remembered ([`Self::divided_by_zero`]) and counts as 0, so that derivations
    /// need not look out for robots of which parts have neither mass nor inertia.
    pub fn div(&self, a: Expr, b: Expr) -> Expr {
        if let Some(value) = self.constant_value(b) {
            if value == 0.0 {
                self.divided_by_zero.set(true);
                return Expr::ZERO;
            }
            if (!self.exact && value.recip().is_finite()) || [1.0, 2.0, 4.0, 8.0, 16.0].contains(&value.abs())
            {
                return self.mul(a, self.constant(value.recip()));
            }
        }
        if a == Expr::ZERO {
            return a;
        }
        let negated = a.is_negated() != b.is_negated();
        let (a, b) = (a.abs(), b.abs());
        if a == b {
            return Expr::ONE.negate_if(negated);
        }
        self.intern(Node::Div(a, b)).negate_if(negated)
    }

    /// `√e`
    ///
    /// # Panics
    /// When `e` is a negative constant.
    pub fn sqrt(&self, e: Expr) -> Expr {
        match self.constant_value(e) {
            Some(value) => self.constant(value.sqrt()),
            None => self.intern(Node::Sqrt(e)),
        }
    }

    /// Sine and cosine of a constant, if they may be folded; exact on multiples of π/2.
    fn fold_sin_cos(&self, angle: Expr) -> Option<(f64, f64)> {
        let value = self.constant_value(angle)?;
        let (s, c) = exact_sin_cos(value);
        (!self.exact || s == 0.0 || c == 0.0).then_some((s, c))
    }

    /// Sine; odd, so the sign moves out.
    pub fn sin(&self, e: Expr) -> Expr {
        match self.fold_sin_cos(e.abs()) {
            Some((s, _)) => self.constant(s).negate_if(e.is_negated() && s != 0.0),
            None => self.intern(Node::Sin(e.abs())).negate_if(e.is_negated()),
        }
    }

    /// Cosine; even, so the sign vanishes.
    pub fn cos(&self, e: Expr) -> Expr {
        match self.fold_sin_cos(e.abs()) {
            Some((_, c)) => self.constant(c),
            None => self.intern(Node::Cos(e.abs())),
        }
    }

    /// A function of the laws of effects.
    ///
    /// # Panics
    /// Where the value of a constant is not finite.
    pub fn call(&self, call: Call, e: Expr) -> Expr {
        if let Some(value) = self.constant_value(e)
            && !self.exact
        {
            return self.constant(call.of(value));
        }
        match call.parity() {
            None => self.intern(Node::Call(call, e)),
            Some(odd) => self.intern(Node::Call(call, e.abs())).negate_if(odd && e.is_negated()),
        }
    }

    /// The larger of two; the smaller one is `-larger(-a, -b)`.
    pub fn larger(&self, a: Expr, b: Expr) -> Expr {
        if a == b {
            return a;
        }
        if let (Some(x), Some(y)) = (self.constant_value(a), self.constant_value(b)) {
            return if x > y { a } else { b };
        }
        let (a, b) = if a <= b { (a, b) } else { (b, a) };
        self.intern(Node::Larger(a, b))
    }

    /// Whether a sine or cosine stands in the expression: then it cannot be an angle of [`Node::Sin`].
    pub fn depends_on_angles(&self, e: Expr) -> bool {
        let store = self.store.borrow();
        let mut seen = vec![false; e.node() + 1];
        let mut stack = vec![e.node()];
        while let Some(node) = stack.pop() {
            if std::mem::replace(&mut seen[node], true) {
                continue;
            }
            if matches!(store.nodes[node], Node::Sin(_) | Node::Cos(_)) {
                return true;
            }
            stack.extend(store.nodes[node].operands().map(Expr::node));
        }
        false
    }
}

#[cfg(test)]
#[path = "graph_tests.rs"]
mod tests;
