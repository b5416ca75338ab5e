//! Parameters that bodies can have: every link's pseudo-inertia positive definite, near CAD where the data do not tell.
//!
//! The pseudo-inertia of a link (Wensing, Kim and Slotine, "Linear matrix inequalities for physically consistent inertial
//! parameter identification", 2018) is `P = [Σ h; hᵀ m]` with mass m, first moment h and second moment
//! `Σ = ½ tr(L) 1 − L`; a distribution of mass exists exactly if P is positive semidefinite, and the triangle inequality
//! of principal moments follows. Near CAD is measured as Lee, Wensing and Park do ("Geometric robot dynamic
//! identification: a convex programming approach", 2020) by the constant pullback metric
//! `d² = ‖C⁻¹ (P − P₀) C⁻ᵀ‖²` with `P₀ = C Cᵀ`: the second-order part of the entropic (log-determinant) divergence, which
//! depends neither on frames nor on units.
//!
//! In the coordinates X of `P = C (1 + X) Cᵀ` both are plain: `d² = ‖X‖²` and `1 + X ⪰ 0`. The estimate is a semidefinite
//! program, `min ‖R θ(X, e) − z‖²/N + w Σ ‖X‖²`, solved by clarabel; its duality gap certifies the answer.
mod bodies;
mod bounds;
mod check;
mod program;

// For its symbols: clarabel calls BLAS and LAPACK by name.
use bipedc_lapack as _;

pub use bodies::{Body, COORDINATES, Inertia, Links, is_possible};
pub use bounds::{Bound, Bounds};
pub use check::{Consistency, check};
pub use program::{Certificate, LeastSquares, Physical, Problem};
