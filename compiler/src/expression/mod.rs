//! Expressions as one hash-consed graph: equal expressions share one node, so common subexpressions are
//! found while deriving.
mod adjoint;
mod angle;
pub mod decimal;
mod display;
mod formula;
mod graph;
mod linear;
mod node;
mod purpose;
mod rewrite;
mod symbol;
mod vector;

pub use adjoint::{gradient, inputs};
pub use angle::exact_sin_cos;
pub use display::{Written, write_infix};
pub(crate) use formula::{Sloped, ValuedFormula};
pub use graph::Graph;
pub use linear::{LinearForm, separate};
pub use node::{Call, Expr, Input, Node};
pub use purpose::{Purpose, Work};
pub use rewrite::{replaced, slopes_along};
pub use symbol::Sym;
pub use vector::{Matrix3, Vector3};
