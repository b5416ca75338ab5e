//! Base parameters in exact arithmetic (thesis 5.2): no numerical tolerance decides what is identifiable.
//!
//! The model's rows stand in an exact graph ([`crate::expression::Graph::exact`]) with symbolic inertial
//! parameters. [`separate`](crate::expression::separate) gives the regressor; it is evaluated at random
//! states over prime fields of 61 and 62 bits, where an angle is the tangent of its half and every rotation
//! is exactly orthonormal, and eliminated there. The reduced echelon form of the rows of all states is the
//! thesis' B_E (5.5). Its rational entries are recovered from as many primes as they need (Chinese
//! remainders) and certified with one more prime and fresh states.
//!
//! What is exact, and of what: numbers of the description are read as the short decimals they were written
//! as, tan(θ/2) of constant angles as a fraction within rounding, and what is analysed is the robot of
//! [`crate::tree::Tree::structure`]: angles within 1e-4 rad of right angles are right there. For that robot
//! rank and certified coefficients are right up to a chance of the order of 2⁻⁴⁰ per analysis. Lengths that the
//! tree has moved into frames turned by odd angles carry the rounding of that step (1e-17 m): it can leave
//! coefficients of 1e-16, which are kept and not printed.
mod arithmetic;
mod coefficients;
mod columns;
mod elimination;
mod evaluate;
mod field;
mod flat;
mod fraction;
mod least_squares;
mod question;
mod regressor;
mod report;
mod states;

pub use arithmetic::{Arithmetic, Rounded};
pub use columns::{Column, ParameterList};
pub use evaluate::{Assignment, Evaluator};
pub use field::Field;
pub use fraction::Fraction;
pub use question::{Model, Question};
pub use regressor::Regressor;
pub use report::{BaseParameter, BaseParameters, Term};
pub use states::StateSpace;

use crate::expression::{Expr, Graph};
use bipedc_effects::diagnostic::Diagnostic;

/// Seed of the random states; the answer does not depend on it.
const SEED: u64 = 0x5eed;

/// The base parameters of `rows` over the states of `space`.
///
/// `graph` must be exact, the inertial parameters in it symbolic
/// ([`crate::derive::InertiaMode::Symbolic`]), and the tree a [`crate::tree::Tree::structure`].
///
/// # Errors
/// A graph that is not exact, rows that are not linear in the parameters or have no exact value, states that
/// cannot be drawn.
pub fn base_parameters(
    graph: &Graph,
    rows: &[Expr],
    space: &StateSpace<'_>,
    list: ParameterList,
) -> Result<BaseParameters, Diagnostic> {
    if !graph.is_exact() {
        return Err(Diagnostic::error("base parameters need an exact graph: this one rounds constants"));
    }
    space.check()?;
    let regressor = Regressor::new(graph, rows, space, list)?;
    let found = coefficients::groups(&regressor, space, SEED)?;
    let values = list.values(space.tree);
    let right_angles = space.tree.nearly_right_angles.clone();
    Ok(BaseParameters::new(regressor.columns, &found.groups, &values, right_angles, found.primes))
}
