//! Which predicted efforts depend on the motion of a joint.
use super::{BaseKind, Batch, JointLayout};

/// States that are tried: a dependence that vanishes at all of them does not exist.
const STATES: usize = 4;

/// For every joint row of inverse dynamics (`count × nv`): whether it changes when joint `moved` moves.
///
/// Found by trying, so that any model will do: position, velocity and acceleration of the joint are changed at
/// a few states. The base rests.
pub(crate) fn depends_on<E>(
    layout: &JointLayout,
    moved: usize,
    inverse_dynamics: &mut dyn FnMut(&Batch<'_>) -> Result<Vec<f64>, E>,
) -> Result<Vec<bool>, E> {
    let mut torques = |moved| {
        let [q, v, a] = states(layout, moved);
        inverse_dynamics(&Batch { count: STATES, q: &q, v: &v, a: &a })
    };
    let (still, changed) = (torques(None)?, torques(Some(moved))?);
    let nv = layout.base.nv() + layout.joints.len();
    let scale = still.iter().chain(&changed).fold(0.0_f64, |m, t| m.max(t.abs()));
    let rows = (0..layout.joints.len()).map(|joint| {
        let row = layout.base.nv() + joint;
        // Rounding may differ where the result does not; a true dependence is far larger at random states.
        (0..STATES).any(|s| (still[s * nv + row] - changed[s * nv + row]).abs() > 1e-12 * scale)
    });
    Ok(rows.collect())
}

/// Positions, velocities and accelerations; with one joint elsewhere.
fn states(layout: &JointLayout, moved: Option<usize>) -> [Vec<f64>; 3] {
    let joints = layout.joints.len();
    let (nq, nv) = (layout.base.nq() + joints, layout.base.nv() + joints);
    let (mut q, mut v, mut a) = (vec![0.0; STATES * nq], vec![0.0; STATES * nv], vec![0.0; STATES * nv]);
    for s in 0..STATES {
        if layout.base == BaseKind::Floating {
            q[s * nq + 6] = 1.0;
        }
        for joint in 0..joints {
            // Irrational steps: no two joints and no two states are alike.
            let seed = (s * joints + joint) as f64;
            let shift = if moved == Some(joint) { 0.7 } else { 0.0 };
            q[s * nq + layout.base.nq() + joint] = (1.3 * seed + 0.4).sin() + shift;
            v[s * nv + layout.base.nv() + joint] = (2.1 * seed + 1.1).sin() - shift;
            a[s * nv + layout.base.nv() + joint] = (3.7 * seed + 2.3).sin() + 2.0 * shift;
        }
    }
    [q, v, a]
}
