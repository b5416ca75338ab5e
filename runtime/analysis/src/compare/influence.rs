//! Which predicted efforts depend on the motion of a joint.
use crate::robot::{BaseKind, Batch, EvaluationError, InverseDynamics, JointLayout};

/// States that are tried: a dependence that vanishes at all of them does not exist.
const STATES: usize = 4;

/// For every joint row: whether it changes when joint `moved` moves.
///
/// Found by trying, so that any model will do: position, velocity and acceleration of the joint are changed at
/// a few states. The base rests.
pub(super) fn depends_on(
    model: &mut dyn InverseDynamics,
    layout: &JointLayout,
    moved: usize,
) -> Result<Vec<bool>, EvaluationError> {
    let (still, changed) = (torques(model, layout, None)?, torques(model, layout, Some(moved))?);
    let nv = model.nv();
    let scale = still.iter().chain(&changed).fold(0.0_f64, |m, t| m.max(t.abs()));
    let rows = (0..layout.joints.len()).map(|joint| {
        let row = layout.base.nv() + joint;
        // Rounding may differ where the result does not; a true dependence is far larger at random states.
        (0..STATES).any(|s| (still[s * nv + row] - changed[s * nv + row]).abs() > 1e-12 * scale)
    });
    Ok(rows.collect())
}

fn torques(
    model: &mut dyn InverseDynamics,
    layout: &JointLayout,
    moved: Option<usize>,
) -> Result<Vec<f64>, EvaluationError> {
    let (nq, nv) = (model.nq(), model.nv());
    let (mut q, mut v, mut a) = (vec![0.0; STATES * nq], vec![0.0; STATES * nv], vec![0.0; STATES * nv]);
    for s in 0..STATES {
        if layout.base == BaseKind::Floating {
            q[s * nq + 6] = 1.0;
        }
        for joint in 0..layout.joints.len() {
            // Irrational steps: no two joints and no two states are alike.
            let seed = (s * layout.joints.len() + joint) as f64;
            let shift = if moved == Some(joint) { 0.7 } else { 0.0 };
            q[s * nq + layout.base.nq() + joint] = (1.3 * seed + 0.4).sin() + shift;
            v[s * nv + layout.base.nv() + joint] = (2.1 * seed + 1.1).sin() - shift;
            a[s * nv + layout.base.nv() + joint] = (3.7 * seed + 2.3).sin() + 2.0 * shift;
        }
    }
    let mut tau = vec![0.0; STATES * nv];
    model.torques(&Batch { count: STATES, q: &q, v: &v, a: &a }, &mut tau)?;
    Ok(tau)
}
