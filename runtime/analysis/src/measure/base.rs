//! Coordinates of the base from its filtered columns.
use crate::robot::BaseKind;
use crate::signal::{rotate_to_base, rotation};

/// Base parts of `q`, `v` and `a` at one sample, for value and two derivatives of each base column.
///
/// `motion` is in the order of the base's `q`. `None` if the quaternion is zero.
pub(super) fn fill(
    kind: BaseKind,
    motion: &[[f64; 3]],
    q: &mut [f64],
    v: &mut [f64],
    a: &mut [f64],
) -> Option<()> {
    match kind {
        BaseKind::Fixed | BaseKind::Pivot => {}
        BaseKind::Planar => {
            for (i, m) in motion.iter().enumerate() {
                (q[i], v[i], a[i]) = (m[0], m[1], m[2]);
            }
        }
        BaseKind::Floating => {
            let part = |first: usize, order: usize| -> [f64; 4] {
                std::array::from_fn(|i| motion.get(first + i).map_or(0.0, |m| m[order]))
            };
            let turn = rotation(part(3, 0), part(3, 1), part(3, 2))?;
            let world = |order| {
                let [x, y, z, _] = part(0, order);
                rotate_to_base(turn.quaternion, [x, y, z])
            };
            let (linear, acceleration) = (world(1), world(2));
            // The derivative of a vector's components in turning axes: R'p̈ − ω × v.
            let turned = crate::signal::cross(turn.velocity, linear);
            for i in 0..3 {
                q[i] = motion[i][0];
                v[i] = linear[i];
                v[3 + i] = turn.velocity[i];
                a[i] = acceleration[i] - turned[i];
                a[3 + i] = turn.acceleration[i];
            }
            q[3..7].copy_from_slice(&turn.quaternion);
        }
    }
    Some(())
}
