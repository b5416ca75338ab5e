//! Derivatives of inverse and forward dynamics.
use super::RobotModel;
use super::articulated::price;
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
/// (Carpentier and Mansard, "Analytical derivatives of rigid body dynamics algorithms", 2018). D is factored
/// in joint angles or in absolute angles, whichever takes fewer operations.
pub fn forward_dynamics<'g>(model: &RobotModel<'g, '_>) -> (Rows<'g>, Rows<'g>, Rows<'g>) {
    let [joint, absolute] = [false, true].map(|absolute| forward_dynamics_in(model, absolute));
    let flat = |(dq, dv, dtau): &(Rows<'g>, Rows<'g>, Rows<'g>)| -> Vec<Sym<'g>> {
        [dq, dv, dtau].into_iter().flatten().flatten().copied().collect()
    };
    if price(model, &flat(&absolute)) < price(model, &flat(&joint)) { absolute } else { joint }
}

fn forward_dynamics_in<'g>(model: &RobotModel<'g, '_>, absolute: bool) -> (Rows<'g>, Rows<'g>, Rows<'g>) {
    let still = Sensitivity::new(model, &vec![model.constant(0.0); model.tree.nv], true, 2.0);
    let inverse = Inverse::new(&still, absolute);
    let a = inverse.accelerations(&given(model, Argument::Tau));
    let moving = Sensitivity::new(model, &a, true, 2.0);
    let answer = |column| {
        let mut rows = inverse.times(&moving.matrix(column));
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
struct Inverse<'r, 'm, 'g, 't> {
    robot: &'r Sensitivity<'m, 'g, 't>,
    /// Factored in absolute angles.
    absolute: bool,
    factor: Factor<'g>,
    zero: Sym<'g>,
    /// Columns of L⁻¹, rows in joint angles.
    columns: Vec<Vec<Sym<'g>>>,
}

impl<'r, 'm, 'g, 't> Inverse<'r, 'm, 'g, 't> {
    fn new(robot: &'r Sensitivity<'m, 'g, 't>, absolute: bool) -> Self {
        let model = robot.model;
        let (zero, one, nv) = (model.constant(0.0), model.constant(1.0), model.tree.nv);
        let d = if absolute { robot.absolute_mass_matrix() } else { robot.mass_matrix() };
        let factor = Factor::new(model, &d);
        let column = |k: usize| {
            let unit = (0..nv).map(|i| if i == k { one } else { zero }).collect();
            let column = factor.back_solve(unit);
            if absolute { robot.joint_velocities(&column) } else { column }
        };
        let columns = (0..nv).map(column).collect();
        Self { robot, absolute, factor, zero, columns }
    }

    /// a(q, v, τ)
    fn accelerations(&self, tau: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let less = |tau: &[Sym<'g>], bias: &[Sym<'g>]| -> Vec<Sym<'g>> {
            tau.iter().zip(bias).map(|(&tau, &bias)| tau - bias).collect()
        };
        if self.absolute {
            let rest = less(&self.robot.in_absolute_angles(tau), &self.robot.absolute_forces());
            return self.robot.joint_velocities(&self.factor.solve(&rest));
        }
        self.factor.solve(&less(tau, &self.robot.forces()))
    }

    fn scaled(&self, y: &[Sym<'g>]) -> Vec<Sym<'g>> {
        y.iter().zip(self.factor.inverse_diagonal()).map(|(&y, &d)| y * d).collect()
    }

    /// `D⁻¹ M`
    fn times(&self, matrix: &Rows<'g>) -> Rows<'g> {
        let n = matrix.len();
        let mut out = vec![vec![self.zero; n]; n];
        for c in 0..n {
            let mut column: Vec<Sym<'g>> = matrix.iter().map(|row| row[c]).collect();
            if self.absolute {
                column = self.robot.in_absolute_angles(&column);
            }
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
