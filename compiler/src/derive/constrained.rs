//! Accelerations and contact forces of a phase (4.23), and the solver that the impact shares.
use super::composite::mass_matrix;
use super::constraint::Constraints;
use super::kinematics::Motions;
use super::model::RobotModel;
use super::newton_euler::generalised_forces;
use super::solve::Factor;
use crate::expression::Sym;
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
    constrained_dynamics_with(model, constraints, &mass_matrix(model))
}

/// The same for another mass matrix, such as one with reflected rotor inertias.
pub fn constrained_dynamics_with<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    mass_matrix: &[Vec<Sym<'g>>],
) -> Constrained<'g> {
    let factor = Factor::new(model, mass_matrix);
    let bias =
        generalised_forces(model, Motions { velocity: true, acceleration: false, gravity: true }, false);
    let free: Vec<Sym<'g>> =
        bias.iter().enumerate().map(|(k, &h)| model.input(Argument::Tau, k) - h).collect();
    let half = factor.half_solve(&free);
    let held = Held::new(&factor, constraints);
    // −(Wᵀ D⁻¹ (τ − H) + w)
    let rates = constraints.blocks.iter().flat_map(|block| block.rate_with_gravity.iter());
    let residual: Vec<Sym<'g>> = held.project(&half).into_iter().zip(rates).map(|(x, &w)| -(x + w)).collect();
    let forces = held.forces(residual);
    let scaled = half.iter().zip(factor.inverse_diagonal()).map(|(&y, &d)| y * d).collect();
    let acceleration = factor.back_solve(held.add_response(scaled, &forces));
    Constrained { acceleration, forces: constraints.publish(&forces) }
}

/// The rows' half solves and the matrix Wᵀ D⁻¹ W.
pub(super) struct Held<'g> {
    /// L⁻ᵀ of the rows.
    half: Vec<Vec<Sym<'g>>>,
    /// The same over Δ.
    scaled: Vec<Vec<Sym<'g>>>,
}

impl<'g> Held<'g> {
    pub fn new(factor: &Factor<'g>, constraints: &Constraints<'g>) -> Self {
        let rows = constraints.blocks.iter().flat_map(|block| &block.jacobian);
        let half: Vec<Vec<Sym<'g>>> = rows.map(|row| factor.half_solve(row)).collect();
        let over =
            |row: &Vec<Sym<'g>>| row.iter().zip(factor.inverse_diagonal()).map(|(&x, &d)| x * d).collect();
        let scaled = half.iter().map(over).collect();
        Self { half, scaled }
    }

    /// Wᵀ D⁻¹ b from the half solve of b.
    pub fn project(&self, half: &[Sym<'g>]) -> Vec<Sym<'g>> {
        self.scaled.iter().map(|row| dot(row, half)).collect()
    }

    /// Y b.
    pub fn forces(&self, b: Vec<Sym<'g>>) -> Vec<Sym<'g>> {
        let n = self.half.len();
        let gram = (0..n).map(|r| (0..=r).map(|c| dot(&self.half[r], &self.scaled[c])).collect()).collect();
        solve_symmetric(gram, b)
    }

    /// `y + Δ⁻¹ L⁻ᵀ W λ`, ready for the back solve.
    pub fn add_response(&self, mut y: Vec<Sym<'g>>, forces: &[Sym<'g>]) -> Vec<Sym<'g>> {
        for (row, &force) in self.scaled.iter().zip(forces) {
            for (x, &a) in y.iter_mut().zip(row) {
                *x = *x + a * force;
            }
        }
        y
    }
}

fn dot<'g>(a: &[Sym<'g>], b: &[Sym<'g>]) -> Sym<'g> {
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
        let inverse = g[k][k].constant(1.0) / g[k][k];
        for i in k + 1..n {
            let factor = g[i][k] * inverse;
            for j in k + 1..=i {
                g[i][j] = g[i][j] - factor * g[j][k];
            }
            b[i] = b[i] - factor * b[k];
        }
        for i in k + 1..n {
            g[i][k] = g[i][k] * inverse;
        }
        b[k] = b[k] * inverse;
    }
    for k in (0..n).rev() {
        for i in k + 1..n {
            b[k] = b[k] - g[i][k] * b[i];
        }
    }
    b
}
