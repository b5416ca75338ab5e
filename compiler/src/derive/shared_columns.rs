//! Columns of a regressor that are sums of others: what a joint cannot tell from its parent's inertia.
//!
//! Mass on the axis of a revolute joint, and all moments of inertia on a slide, act on everything before the joint as if they
//! were the parent's (the regrouping behind base parameters). So these columns are constant combinations of the parent's, and
//! need not be carried through all joints once more.
use super::model::RobotModel;
use crate::expression::Sym;
use crate::tree::{Body, Inertia, JointMotion};

/// Parameters of a body.
const TEN: usize = 10;
/// Longer sums cost more than to carry the column.
const MOST_TERMS: usize = 6;

/// `pivot = Σ factor · column`, columns among those of the child and of its parent.
struct Sum {
    pivot: usize,
    terms: Vec<(usize, f64)>,
}

/// Replaces columns of a body by sums where that is cheaper; `columns`: ten per body, those of its parent are known.
/// `joint_rows`: rows are those of `v`, and a joint's own row stays as it is: its parent knows nothing of it.
pub fn share<'g>(model: &RobotModel<'g, '_>, index: usize, columns: &mut [Vec<Sym<'g>>], joint_rows: bool) {
    let (bodies, body) = (&model.tree.bodies, &model.tree.bodies[index]);
    let Some(parent) = body.parent.filter(|&parent| !bodies[parent].is_virtual) else { return };
    let _work = model.work(index, "columns that its parent has too");
    for moved in movable(body.motion) {
        let Some(sum) = sum(&moved, (index, body), (parent, &bodies[parent])) else { continue };
        for row in (0..columns[sum.pivot].len()).filter(|&row| !(joint_rows && row == body.v_index)) {
            let term = |&(column, factor): &(usize, f64)| columns[column][row] * factor;
            columns[sum.pivot][row] = sum.terms.iter().map(term).fold(model.constant(0.0), |s, x| s + x);
        }
    }
}

/// Unit distributions of mass in the body's frame that its joint does not move in the parent.
fn movable(motion: JointMotion) -> Vec<Inertia> {
    let second = |r: usize, c: usize| {
        let mut unit = Inertia::default();
        unit.second_moment[r][c] = 1.0;
        unit.second_moment[c][r] = 1.0;
        unit
    };
    match motion {
        JointMotion::Free => Vec::new(),
        JointMotion::Prismatic { .. } => {
            [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(r, c)| second(r, c)).to_vec()
        }
        JointMotion::Revolute { axis, .. } => {
            let mut along = Inertia::default();
            along.first_moment[axis] = 1.0;
            let thin = second((axis + 1) % 3, (axis + 1) % 3).plus(&second((axis + 2) % 3, (axis + 2) % 3));
            vec![Inertia { mass: 1.0, ..Inertia::default() }, along, thin]
        }
    }
}

/// The child's first parameter of a distribution, by its others and those of the parent; `None` where that is no gain.
fn sum(moved: &Inertia, child: (usize, &Body), parent: (usize, &Body)) -> Option<Sum> {
    let own = moved.transformed(&child.1.main_link.inverse()).parameters();
    let of_parent = moved.transformed(&child.1.placement).transformed(&parent.1.main_link.inverse());
    let pivot = own.iter().position(|&x| x != 0.0)?;
    let factor = own[pivot];
    let others = own.iter().enumerate().skip(pivot + 1).map(|(k, &x)| (TEN * child.0 + k, -x * factor));
    let theirs = of_parent.parameters();
    let theirs = theirs.iter().enumerate().map(|(k, &x)| (TEN * parent.0 + k, x * factor));
    let terms: Vec<(usize, f64)> = theirs.chain(others).filter(|(_, x)| *x != 0.0).collect();
    // A factor of ±1 is its own inverse.
    (factor.abs() == 1.0 && terms.len() <= MOST_TERMS).then_some(Sum { pivot: TEN * child.0 + pivot, terms })
}
