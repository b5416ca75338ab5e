//! Derivatives of inverse and forward dynamics with effects.
use super::forward::{Driven, Returned, less};
use super::system::System;
use super::{At, JointLaws, Seed};
use crate::derive::RobotModel;
use crate::derive::sensitivity::{Column, Sensitivity};
use crate::expression::Sym;
use bipedc_runtime::Argument;

/// A matrix by rows.
type Rows<'g> = Vec<Vec<Sym<'g>>>;

/// ∂a/∂q, ∂a/∂v, ∂a/∂τ at a = a(q, v, τ), rows a: −J⁻¹ ∂T/∂q, −J⁻¹ ∂T/∂v and J⁻¹ dT/dτ with J = ∂T/∂a, all
/// of the true torque T.
pub fn forward_dynamics_derivatives<'g>(
    model: &RobotModel<'g, '_>,
    laws: &JointLaws,
    reported: &[Sym<'g>],
) -> (Rows<'g>, Rows<'g>, Rows<'g>) {
    let nv = model.tree.nv;
    let zero = model.constant(0.0);
    let still = Sensitivity::new(model, &vec![zero; nv], true, 2.0);
    let (d, h) = (still.mass_matrix(), still.forces());
    let returned = Returned::new(model, laws, reported);
    let system = |driven: &Driven<'g>| System::new(model, &d, &driven.inertias);
    let solve = |driven: &Driven<'g>| system(driven).solve(&less(&driven.forces, &h));
    let (driven, a) = returned.settle(solve, |a| a);
    let system = system(&driven);
    let moving = Sensitivity::new(model, &a, true, 2.0);
    let loads = moving.forces();
    let at = At { acceleration: a, ..At::new(model, true, false) };
    // Rows divided by S: then what stands before D is 1.
    let answer = |mut column: Vec<Sym<'g>>| {
        for &(row, scale) in &driven.scales {
            column[row] = column[row] * scale;
        }
        system.solve(&column)
    };
    let transposed = |columns: Vec<Vec<Sym<'g>>>| -> Rows<'g> {
        (0..nv).map(|r| columns.iter().map(|column| column[r]).collect()).collect()
    };
    let by_state = |column: Column| {
        let rows = laws.true_torque_change(model, &at, &loads, column, moving.matrix(column));
        let columns = (0..nv).map(|c| answer(rows.iter().map(|row| -row[c]).collect()));
        transposed(columns.collect())
    };
    let (dq, dv) = (by_state(Column::Position), by_state(Column::Velocity));
    let dtau = (0..nv).map(|c| {
        let mut unit = vec![zero; nv];
        let slope = returned.rows.iter().find(|row| row.row == c).map(|row| row.slope);
        unit[c] = slope.unwrap_or(model.constant(1.0));
        answer(unit)
    });
    (dq, dv, transposed(dtau.collect()))
}

/// ∂u/∂q, ∂u/∂v and ∂u/∂a of the reported torques, rows u.
pub fn inverse_dynamics_derivatives<'g>(
    model: &RobotModel<'g, '_>,
    laws: &JointLaws,
) -> (Rows<'g>, Rows<'g>, Rows<'g>) {
    let given: Vec<Sym<'g>> = (0..model.tree.nv).map(|k| model.input(Argument::A, k)).collect();
    let moving = Sensitivity::new(model, &given, true, 2.0);
    let at = At::new(model, true, true);
    let loads = moving.forces();
    let change = |column| laws.reported_change(model, &at, &loads, column, moving.matrix(column));
    let inertia = laws.reported_inertia(model, &at, &loads, moving.mass_matrix());
    (change(Column::Position), change(Column::Velocity), inertia)
}

impl JointLaws {
    /// ∂T/∂q or ∂T/∂v from those of the loads, by rows.
    fn true_torque_change<'g>(
        &self,
        model: &RobotModel<'g, '_>,
        at: &At<'g>,
        loads: &[Sym<'g>],
        column: Column,
        mut rows: Rows<'g>,
    ) -> Rows<'g> {
        for joint in &self.joints {
            let torque = joint.torque(model, at, loads[joint.row]);
            apply(&mut rows[joint.row], column, joint.seeds.iter().copied().zip(torque.slopes).collect());
        }
        rows
    }

    /// ∂u/∂q or ∂u/∂v of reported torques from those of the loads, by rows.
    fn reported_change<'g>(
        &self,
        model: &RobotModel<'g, '_>,
        at: &At<'g>,
        loads: &[Sym<'g>],
        column: Column,
        mut rows: Rows<'g>,
    ) -> Rows<'g> {
        for (row, slopes) in self.slopes(model, at, loads) {
            apply(&mut rows[row], column, slopes);
        }
        rows
    }

    /// ∂u/∂a from the mass matrix, by rows.
    fn reported_inertia<'g>(
        &self,
        model: &RobotModel<'g, '_>,
        at: &At<'g>,
        loads: &[Sym<'g>],
        mut rows: Rows<'g>,
    ) -> Rows<'g> {
        for (row, slopes) in self.slopes(model, at, loads) {
            let slope = slopes[0].1;
            rows[row].iter_mut().for_each(|x| *x = *x * slope);
            for (seed, slope) in slopes {
                if let Seed::Acceleration(column) = seed {
                    rows[row][column] = rows[row][column] + slope;
                }
            }
        }
        rows
    }
}

/// A row of the loads' change becomes one of the torques'.
fn apply<'g>(row: &mut [Sym<'g>], column: Column, slopes: Vec<(Seed, Sym<'g>)>) {
    // The first seed is the load.
    let by_load = slopes[0].1;
    row.iter_mut().for_each(|x| *x = *x * by_load);
    for (seed, slope) in slopes {
        let at = match (seed, column) {
            (Seed::Position(at), Column::Position) | (Seed::Velocity(at), Column::Velocity) => at,
            _ => continue,
        };
        row[at] = row[at] + slope;
    }
}
