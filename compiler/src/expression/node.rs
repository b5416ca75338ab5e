//! Edges that carry a sign, and the operations that they lead to.
use bipedc_runtime::Argument;

/// An edge to a node; negation is part of the edge and costs no node.
///
/// `x`, `-x`, `a - b` and `b - a` therefore share nodes, and a sign never becomes an operation before the
/// program is written down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Expr(u32);

impl Expr {
    /// The constant 0.
    pub const ZERO: Self = Self(0);
    /// The constant 1.
    pub const ONE: Self = Self(2);

    pub(super) fn new(node: usize) -> Self {
        Self(u32::try_from(node << 1).expect("fewer than 2^31 nodes"))
    }
    /// The positive edge to the node with this index.
    pub fn positive(node: usize) -> Self {
        Self::new(node)
    }
    /// Index of the node.
    pub fn node(self) -> usize {
        (self.0 >> 1) as usize
    }
    /// Whether the edge negates.
    pub fn is_negated(self) -> bool {
        self.0 & 1 == 1
    }
    /// The edge without its sign.
    pub fn abs(self) -> Self {
        Self(self.0 & !1)
    }
    pub(super) fn negate_if(self, condition: bool) -> Self {
        Self(self.0 ^ u32::from(condition))
    }
}

impl std::ops::Neg for Expr {
    type Output = Self;
    fn neg(self) -> Self {
        // One zero only, so that a zero is recognised by its id.
        if self == Self::ZERO { self } else { Self(self.0 ^ 1) }
    }
}

/// A run-time value: one element of an argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Input {
    /// Which argument.
    pub argument: Argument,
    /// Which element of it.
    pub index: u32,
}

/// One operation. Operands always have smaller indices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Node {
    /// A number ≥ 0 (the sign is on the edge).
    Constant(f64),
    /// A run-time value.
    Input(Input),
    /// Sum; the first operand is positive, the second may be negated.
    Add(Expr, Expr),
    /// Product of two positive edges.
    Mul(Expr, Expr),
    /// Quotient of two positive edges.
    Div(Expr, Expr),
    /// Square root.
    Sqrt(Expr),
    /// Sine of a positive edge.
    Sin(Expr),
    /// Cosine of a positive edge.
    Cos(Expr),
    /// Another function of one edge; of an odd or even one the edge is positive.
    Call(Call, Expr),
    /// The larger of two edges, the smaller one first.
    Larger(Expr, Expr),
}

/// Functions that no rigid body needs but the laws of effects do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Call {
    /// Exponential function.
    Exp,
    /// Hyperbolic tangent.
    Tanh,
    /// Magnitude.
    Abs,
    /// 1, -1, or 0 of zero.
    Sign,
    /// Sine of what depends on a sine itself: those of [`Node::Sin`] are all computed together before.
    Sin,
    /// Cosine of what depends on a cosine itself.
    Cos,
}

impl Call {
    /// Its name in text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exp => "exp",
            Self::Tanh => "tanh",
            Self::Abs => "abs",
            Self::Sign => "sign",
            Self::Sin => "sin",
            Self::Cos => "cos",
        }
    }

    /// Its value at a number.
    pub fn of(self, x: f64) -> f64 {
        match self {
            Self::Exp => x.exp(),
            Self::Tanh => x.tanh(),
            Self::Abs => x.abs(),
            Self::Sign => bipedc_runtime::Real::sign(x),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
        }
    }

    /// `f(-x)` as a multiple of `f(x)`: -1, 1, or none.
    pub(super) fn parity(self) -> Option<bool> {
        match self {
            Self::Exp => None,
            Self::Tanh | Self::Sign | Self::Sin => Some(true),
            Self::Abs | Self::Cos => Some(false),
        }
    }
}

impl Node {
    /// The operands, none for leaves.
    pub fn operands(self) -> impl Iterator<Item = Expr> {
        let pair = match self {
            Self::Constant(_) | Self::Input(_) => [None, None],
            Self::Add(a, b) | Self::Mul(a, b) | Self::Div(a, b) | Self::Larger(a, b) => [Some(a), Some(b)],
            Self::Sqrt(a) | Self::Sin(a) | Self::Cos(a) | Self::Call(_, a) => [Some(a), None],
        };
        pair.into_iter().flatten()
    }
}
