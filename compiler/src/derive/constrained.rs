//! Accelerations and contact forces of a phase (4.23), and the solver that the impact shares.
use super::articulated::{duration, less};
use super::composite::mass_matrix;
use super::constraint::Constraints;
use super::effects::{Driven, JointLaws, Returned};
use super::kinematics::Motions;
use super::model::{InertiaMode, RobotModel};
use super::newton_euler::generalised_forces;
use super::pinned;
use super::reduced::{self, flat_support};
use super::solve::Factor;
use super::standing::{self, Load, Solution};
use super::support::Support;
use crate::expression::{Graph, Sym};
use bipedc_runtime::Argument;

/// Motion and contact forces of a phase.
#[derive(Debug, Clone)]
pub struct Constrained<'g> {
    /// v̇ in the order of `v`.
    pub acceleration: Vec<Sym<'g>>,
    /// λ in the order of [`Constraints::names`], N and N m; without constraints empty.
    pub forces: Vec<Sym<'g>>,
}

/// D q̈ + H = τ + W λ with Wᵀ q̈ + w = 0:
/// λ = Y (Wᵀ D⁻¹ (H − τ) − w), Y = (Wᵀ D⁻¹ W)⁻¹ (4.23a and Table 4.1, corrected).
///
/// τ is the full vector of generalised forces ([`Argument::Tau`], order of `v`; base rows are usually zero).
/// The rows must be independent; [`super::support::supports`] says what it takes care of.
pub fn constrained_dynamics<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
) -> Constrained<'g> {
    constrained_dynamics_with(model, constraints, &[])
}

/// The same with inertias added to the diagonal of D, by row of `v`, kg m²: those of rotors
/// ([`super::drive::reflected_inertia`]). Missing ones are zero.
pub fn constrained_dynamics_with<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[f64],
) -> Constrained<'g> {
    let rotors: Vec<Sym<'g>> = rotors.iter().map(|&x| model.constant(x)).collect();
    let tau: Vec<Sym<'g>> = (0..model.tree.nv).map(|k| model.input(Argument::Tau, k)).collect();
    under_forces(model, constraints, &rotors, &tau)
}

/// Under generalised forces, in the order of `v`, by whichever way takes the least time.
fn under_forces<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    tau: &[Sym<'g>],
) -> Constrained<'g> {
    let bias = generalised_forces(model, Motions::NO_ACCELERATION, false);
    let free = less(tau, &bias);
    let eliminated = respond(model, constraints, rotors, &free, Demand::Rates);
    let (acceleration, forces) = quickest(model, constraints, rotors, Load::Forces(tau), eliminated);
    Constrained { acceleration, forces }
}

/// The solution that takes the least time: `eliminated`, or those of a robot on one foot.
pub(super) fn quickest<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    load: Load<'_, 'g>,
    eliminated: Solution<'g>,
) -> Solution<'g> {
    let takes = |(motion, forces): &Solution<'g>| duration(model, &[motion.as_slice(), forces].concat());
    let rooted = standing::respond(model, constraints, rotors, load);
    let pinned = pinned::respond(model, constraints, rotors, load);
    let others = rooted.into_iter().chain(pinned);
    others.fold(eliminated, |best, other| if takes(&other) < takes(&best) { other } else { best })
}

/// [`constrained_dynamics`] with the effects at joints; none of them may couple joints by their accelerations.
pub fn constrained_dynamics_with_effects<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    laws: &JointLaws,
) -> Constrained<'g> {
    let tau: Vec<Sym<'g>> = (0..model.tree.nv).map(|k| model.input(Argument::Tau, k)).collect();
    let solve = |driven: &Driven<'g>| {
        let mut rotors = vec![model.constant(0.0); model.tree.nv];
        for &(row, column, m) in driven.inertias.iter().filter(|(row, column, _)| row == column) {
            rotors[row] = rotors[column] + m;
        }
        under_forces(model, constraints, &rotors, &driven.forces)
    };
    Returned::new(model, laws, &tau).settle(solve, |found| &found.acceleration).1
}

/// What the constraints ask of the motion x: J x = −J̇ v or J x = −J v.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Demand {
    /// x is an acceleration.
    Rates,
    /// x is the jump of the velocity at an impact.
    Velocity,
}

/// Solves D x = f + Jᵀ λ together with the constraints' demand: (x, λ in the published rows).
pub(super) fn respond<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    f: &[Sym<'g>],
    demand: Demand,
) -> (Vec<Sym<'g>>, Vec<Sym<'g>>) {
    if let Some(flat) = flat_support(model, constraints) {
        return reduced::respond(model, constraints, rotors, f, (flat, demand));
    }
    let mut d = mass_matrix(model);
    for (k, &rotor) in rotors.iter().enumerate() {
        d[k][k] = d[k][k] + rotor;
    }
    let factor = Factor::new(model, &d);
    let held =
        ConstraintSolves::new(&factor, rows(model, constraints), movable_rows(model, constraints, rows));
    let rates = constraints.blocks.iter().flat_map(|block| block.demanded(model, demand)).collect();
    let (x, forces) = held.solve(&factor, f, rates);
    (x, constraints.publish(&forces))
}

/// All rows in axes of the feet.
pub(super) fn rows<'g>(_: &RobotModel<'g, '_>, constraints: &Constraints<'g>) -> Vec<Vec<Sym<'g>>> {
    constraints.blocks.iter().flat_map(|block| block.jacobian.clone()).collect()
}

/// Which of `rows` anything can move along, in [`crate::tree::Tree::structure`]: where digits of right angles are missing,
/// a row that vanishes leaves 1e-11 behind, and dividing by its square would be meaningless.
pub(super) fn movable_rows<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rows: impl for<'a> Fn(&RobotModel<'a, '_>, &Constraints<'a>) -> Vec<Vec<Sym<'a>>>,
) -> Vec<bool> {
    let moves = |row: &Vec<Sym<'_>>| row.iter().any(|x| !x.is_zero());
    let tree = model.tree.structure();
    if std::ptr::eq(tree, model.tree) {
        return rows(model, constraints).iter().map(moves).collect();
    }
    let graph = Graph::new();
    let straight = RobotModel::new(&graph, tree, InertiaMode::Plain);
    let supports: Vec<Support> = constraints.supports.iter().map(Support::straightened).collect();
    rows(&straight, &Constraints::of_supports(&straight, &supports)).iter().map(moves).collect()
}

/// The rows' half solves.
pub(super) struct ConstraintSolves<'g> {
    /// L⁻ᵀ of the rows.
    half: Vec<Vec<Sym<'g>>>,
    /// The same over Δ.
    scaled: Vec<Vec<Sym<'g>>>,
    /// By row: whether anything can move along it.
    movable: Vec<bool>,
}

impl<'g> ConstraintSolves<'g> {
    pub fn new(factor: &Factor<'g>, rows: Vec<Vec<Sym<'g>>>, movable: Vec<bool>) -> Self {
        let live = rows.iter().zip(&movable).filter(|(_, movable)| **movable);
        let half: Vec<Vec<Sym<'g>>> = live.map(|(row, _)| factor.half_solve(row)).collect();
        let over =
            |row: &Vec<Sym<'g>>| row.iter().zip(factor.inverse_diagonal()).map(|(&x, &d)| x * d).collect();
        let scaled = half.iter().map(over).collect();
        Self { half, scaled, movable }
    }

    /// x and λ of D x = f + Jᵀ λ, J x = −rates. A row along which nothing can move repeats what the robot's
    /// joints do anyway (the sideways rows of a planar robot's second foot, in space): its λ is 0.
    pub fn solve(
        &self,
        factor: &Factor<'g>,
        f: &[Sym<'g>],
        rates: Vec<Sym<'g>>,
    ) -> (Vec<Sym<'g>>, Vec<Sym<'g>>) {
        let half = factor.half_solve(f);
        let n = self.half.len();
        let gram = (0..n).map(|r| (0..=r).map(|c| dot(&self.half[r], &self.scaled[c])).collect()).collect();
        let live = rates.iter().zip(&self.movable).filter_map(|(&w, &movable)| movable.then_some(w));
        let residual = self.scaled.iter().zip(live).map(|(row, w)| -(dot(row, &half) + w)).collect();
        let forces = solve_symmetric(gram, residual);
        let mut x: Vec<Sym<'g>> = half.iter().zip(factor.inverse_diagonal()).map(|(&y, &d)| y * d).collect();
        for (row, &force) in self.scaled.iter().zip(&forces) {
            for (x, &a) in x.iter_mut().zip(row) {
                *x = *x + a * force;
            }
        }
        let mut solved = forces.into_iter();
        let force = |(&movable, rate): (&bool, &Sym<'g>)| match movable {
            true => solved.next().unwrap_or(rate.zero()),
            false => rate.zero(),
        };
        (factor.back_solve(x), self.movable.iter().zip(&rates).map(force).collect())
    }
}

/// Σ a b without the terms that vanish.
pub(super) fn dot<'g>(a: &[Sym<'g>], b: &[Sym<'g>]) -> Sym<'g> {
    let mut products = a.iter().zip(b).map(|(&x, &y)| x * y).filter(|x| !x.is_zero());
    match products.next() {
        Some(first) => products.fold(first, |sum, x| sum + x),
        None => a[0].zero(),
    }
}

/// Solves a symmetric positive definite system, given the lower triangle: L Δ Lᵀ without pivoting.
pub fn solve_symmetric<'g>(mut g: Vec<Vec<Sym<'g>>>, mut b: Vec<Sym<'g>>) -> Vec<Sym<'g>> {
    let n = b.len();
    for k in 0..n {
        let (done, below) = g.split_at_mut(k + 1);
        let inverse = b[k].constant(1.0) / done[k][k];
        let column: Vec<Sym<'g>> = below.iter().map(|row| row[k]).collect();
        for (r, row) in below.iter_mut().enumerate() {
            let factor = column[r] * inverse;
            for (x, &c) in row[k + 1..].iter_mut().zip(&column) {
                *x = *x - factor * c;
            }
            b[k + 1 + r] = b[k + 1 + r] - factor * b[k];
            row[k] = factor;
        }
        b[k] = b[k] * inverse;
    }
    for k in (0..n).rev() {
        let rest = g[k + 1..].iter().zip(&b[k + 1..]);
        b[k] = rest.fold(b[k], |sum, (row, &x)| sum - row[k] * x);
    }
    b
}
