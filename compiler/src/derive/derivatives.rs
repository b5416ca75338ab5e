//! Derivatives of inverse and forward dynamics.
use super::RobotModel;
use super::sensitivity::{Column, Sensitivity};
use super::solve::Factor;
use crate::expression::Sym;
use bipedc_runtime::Argument;

/// A matrix by rows.
pub type Rows<'g> = Vec<Vec<Sym<'g>>>;

fn given<'g>(model: &RobotModel<'g, '_>, argument: Argument) -> Vec<Sym<'g>> {
    (0..model.tree.nv).map(|k| model.input(argument, k)).collect()
}

/// Derivatives of the inverse dynamics τ(q, v, a): ∂τ/∂q and ∂τ/∂v, `nv × nv`, rows τ.
///
/// Columns of ∂τ/∂q are the tangent space of q; a floating base is displaced and turned in its own axes
/// (q ⊕ δ on the right), as in Pinocchio's `computeRNEADerivatives`. ∂τ/∂a is the mass matrix.
pub fn inverse_dynamics<'g>(model: &RobotModel<'g, '_>) -> (Rows<'g>, Rows<'g>) {
    let sensitivity = Sensitivity::new(model, &given(model, Argument::A), true, 2.0);
    (sensitivity.matrix(Column::Position), sensitivity.matrix(Column::Velocity))
}

/// Derivatives of the forward dynamics a(q, v, τ): ∂a/∂q, ∂a/∂v and ∂a/∂τ = D⁻¹, `nv × nv`, rows a.
///
/// Columns as in [`inverse_dynamics`]: ∂a/∂q = −D⁻¹ ∂τ/∂q and ∂a/∂v = −D⁻¹ ∂τ/∂v at a = a(q, v, τ)
/// (Carpentier and Mansard, "Analytical derivatives of rigid body dynamics algorithms", 2018).
pub fn forward_dynamics<'g>(model: &RobotModel<'g, '_>) -> (Rows<'g>, Rows<'g>, Rows<'g>) {
    let zero = vec![model.constant(0.0); model.tree.nv];
    let still = Sensitivity::new(model, &zero, true, 2.0);
    let factor = Factor::new(model, &still.mass_matrix());
    let tau = given(model, Argument::Tau);
    let rest: Vec<Sym<'g>> = tau.iter().zip(still.forces()).map(|(&tau, bias)| tau - bias).collect();
    let a = factor.solve(&rest);
    let moving = Sensitivity::new(model, &a, true, 2.0);
    let inverse = Inverse::new(model, &factor);
    let answer = |column| {
        let forces = moving.matrix(column);
        let mut rows = inverse.times(&forces);
        for (k, known) in moving.known_accelerations(column) {
            for (row, x) in rows.iter_mut().zip(known) {
                row[k] = x;
            }
        }
        rows.into_iter().map(|row| row.into_iter().map(|x| -x).collect()).collect()
    };
    (answer(Column::Position), answer(Column::Velocity), inverse.matrix())
}

/// D⁻¹ = L⁻¹ Δ⁻¹ L⁻ᵀ with L⁻¹ explicit, which is as sparse as L: columns without forces on a branch pass
/// over the branch's own coupling.
struct Inverse<'m, 'g> {
    factor: &'m Factor<'g>,
    zero: Sym<'g>,
    /// Columns of L⁻¹.
    columns: Vec<Vec<Sym<'g>>>,
}

impl<'m, 'g> Inverse<'m, 'g> {
    fn new(model: &RobotModel<'g, '_>, factor: &'m Factor<'g>) -> Self {
        let zero = model.constant(0.0);
        let nv = model.tree.nv;
        let unit = |k: usize| (0..nv).map(|i| if i == k { model.constant(1.0) } else { zero }).collect();
        Self { factor, zero, columns: (0..nv).map(|k| factor.back_solve(unit(k))).collect() }
    }

    fn scaled(&self, y: &[Sym<'g>]) -> Vec<Sym<'g>> {
        y.iter().zip(self.factor.inverse_diagonal()).map(|(&y, &d)| y * d).collect()
    }

    /// `D⁻¹ M`
    fn times(&self, matrix: &Rows<'g>) -> Rows<'g> {
        let n = matrix.len();
        let mut out = vec![vec![self.zero; n]; n];
        for c in 0..n {
            let column: Vec<Sym<'g>> = matrix.iter().map(|row| row[c]).collect();
            let y = self.scaled(&self.factor.half_solve(&column));
            for (r, row) in out.iter_mut().enumerate() {
                row[c] = (0..n).fold(self.zero, |sum, k| sum + self.columns[k][r] * y[k]);
            }
        }
        out
    }

    /// `D⁻¹`
    fn matrix(&self) -> Rows<'g> {
        let n = self.columns.len();
        let rows: Rows<'g> = (0..n).map(|r| self.columns.iter().map(|column| column[r]).collect()).collect();
        let mut out = vec![vec![self.zero; n]; n];
        for r in 0..n {
            let scaled = self.scaled(&rows[r]);
            for c in 0..=r {
                let x = (0..n).fold(self.zero, |sum, k| sum + scaled[k] * rows[c][k]);
                out[r][c] = x;
                out[c][r] = x;
            }
        }
        out
    }
}
