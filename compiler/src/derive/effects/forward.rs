//! Forward dynamics with effects: the inverse of the inverse dynamics.
//!
//! By row, T = f + S L + Σ M a with S > 0 that depends on the sign of L where friction follows the load. So
//! L + (M / S) a = (T − f) / S, and with L = D a + H: (D + M / S) a = (T − f) / S − H. Where a row has no
//! inertia of its own, sign L = sign (T − f) is known beforehand; where it has both, L depends on the
//! accelerations: the signs are found by solving up to three times more, which settles them in all states but a few
//! with a load near zero, where they hardly matter.
use super::system::System;
use super::{At, Joint, JointLaws, Seed};
use crate::derive::sensitivity::Sensitivity;
use crate::derive::{RobotModel, articulated};
use crate::expression::{Call, Sym};

/// Rounds in which signs of loads are found.
const ROUNDS: usize = 3;

/// A joint's row of the equations.
#[derive(Debug, Clone)]
pub(super) struct Row<'g> {
    pub row: usize,
    /// T − f
    rest: Sym<'g>,
    /// S for positive and for negative loads.
    sides: [Sym<'g>; 2],
    /// M by column.
    inertias: Vec<(usize, Sym<'g>)>,
    /// dT/du
    pub slope: Sym<'g>,
}

/// Rigid-body torques and inertias in place of the laws.
#[derive(Debug, Clone)]
pub struct Driven<'g> {
    /// (T − f) / S, in the order of `v`.
    pub forces: Vec<Sym<'g>>,
    /// M / S: (row, column, value).
    pub inertias: Vec<(usize, usize, Sym<'g>)>,
    /// 1 / S by row, where it is not 1.
    pub scales: Vec<(usize, Sym<'g>)>,
}

/// The laws at a state, to be solved for accelerations.
#[derive(Debug, Clone)]
pub struct Returned<'g> {
    reported: Vec<Sym<'g>>,
    pub(super) rows: Vec<Row<'g>>,
}

impl<'g> Row<'g> {
    fn new(model: &RobotModel<'g, '_>, joint: &Joint, reported: Sym<'g>) -> Self {
        let at = At::new(model, true, false);
        let one = model.constant(1.0);
        let at_load = |load| joint.torque(model, &at, load);
        let free = at_load(model.constant(0.0));
        let truth = joint.truth(reported);
        // The first seed is the load.
        let sides = [at_load(one).slopes[0], at_load(-one).slopes[0]];
        let inertia = |(seed, slope): (&Seed, &Sym<'g>)| match seed {
            Seed::Acceleration(column) if !slope.is_zero() => Some((*column, *slope)),
            _ => None,
        };
        let inertias = joint.seeds.iter().zip(&free.slopes).filter_map(inertia).collect();
        Self { row: joint.row, rest: truth.value - free.value, sides, inertias, slope: truth.slopes[0] }
    }

    fn is_one_sided(&self) -> bool {
        self.sides[0].expr == self.sides[1].expr
    }

    /// Whether the sign of the load takes a solution to find.
    fn is_implicit(&self) -> bool {
        !self.is_one_sided() && !self.inertias.is_empty()
    }

    /// S where this has the sign of the load.
    fn side(&self, like_load: Sym<'g>) -> Sym<'g> {
        if self.is_one_sided() {
            return self.sides[0];
        }
        let [above, below] = self.sides;
        (above + below) * 0.5 + (above - below) * 0.5 * like_load.call(Call::Sign)
    }

    /// T − f − M a, which has the sign of L.
    fn like_load(&self, a: Option<&[Sym<'g>]>) -> Sym<'g> {
        let Some(a) = a else { return self.rest };
        self.inertias.iter().fold(self.rest, |sum, &(column, m)| sum - m * a[column])
    }
}

impl<'g> Returned<'g> {
    /// `reported` are the torques that a log reports or a controller commands, in the order of `v`.
    pub fn new(model: &RobotModel<'g, '_>, laws: &JointLaws, reported: &[Sym<'g>]) -> Self {
        let row = |joint: &Joint| Row::new(model, joint, reported[joint.row]);
        Self { reported: reported.to_vec(), rows: laws.joints.iter().map(row).collect() }
    }

    /// The equations with the signs that loads have at accelerations `a`, or would have without inertias.
    pub fn driven(&self, a: Option<&[Sym<'g>]>) -> Driven<'g> {
        let mut out = Driven { forces: self.reported.clone(), inertias: Vec::new(), scales: Vec::new() };
        for row in &self.rows {
            let scale = row.rest.constant(1.0) / row.side(row.like_load(a));
            out.forces[row.row] = row.rest * scale;
            out.inertias.extend(row.inertias.iter().map(|&(column, m)| (row.row, column, m * scale)));
            if scale.constant_value() != Some(1.0) {
                out.scales.push((row.row, scale));
            }
        }
        out
    }

    /// Accelerations (and what else `solve` finds) with the signs of loads settled.
    pub fn settle<T>(
        &self,
        solve: impl Fn(&Driven<'g>) -> T,
        accelerations: impl Fn(&T) -> &[Sym<'g>],
    ) -> (Driven<'g>, T) {
        let mut driven = self.driven(None);
        let mut found = solve(&driven);
        if self.rows.iter().any(Row::is_implicit) {
            for _ in 0..ROUNDS {
                driven = self.driven(Some(accelerations(&found)));
                found = solve(&driven);
            }
        }
        (driven, found)
    }
}

/// Accelerations under reported torques; `external` are the generalised forces of external forces.
pub fn forward_dynamics<'g>(
    model: &RobotModel<'g, '_>,
    laws: &JointLaws,
    reported: &[Sym<'g>],
    external: &[Sym<'g>],
) -> Vec<Sym<'g>> {
    let returned = Returned::new(model, laws, reported);
    let with = |driven: &Driven<'g>| sum(&driven.forces, external);
    if returned.rows.iter().all(|row| row.inertias.is_empty()) {
        return articulated::forward_dynamics(model, &with(&returned.driven(None)));
    }
    let still = Sensitivity::new(model, &vec![model.constant(0.0); model.tree.nv], true, 2.0);
    let (d, h) = (still.mass_matrix(), still.forces());
    let solve =
        |driven: &Driven<'g>| System::new(model, &d, &driven.inertias).solve(&less(&with(driven), &h));
    returned.settle(solve, |a| a).1
}

fn sum<'g>(a: &[Sym<'g>], b: &[Sym<'g>]) -> Vec<Sym<'g>> {
    a.iter().zip(b).map(|(&a, &b)| a + b).collect()
}

pub(super) fn less<'g>(a: &[Sym<'g>], b: &[Sym<'g>]) -> Vec<Sym<'g>> {
    a.iter().zip(b).map(|(&a, &b)| a - b).collect()
}
