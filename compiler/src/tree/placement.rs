//! Constant rotations and placements.
use crate::expression::exact_sin_cos;
use std::f64::consts::FRAC_PI_2;

/// A constant rotation as elementary rotations about coordinate axes, applied left to right:
/// `R = R_axis0(angle0) R_axis1(angle1) …`.
///
/// Kept in angles, not as a matrix, so that exact arithmetic can make it exactly orthonormal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rotation(pub Vec<(usize, f64)>);

/// Angles this close (rad) to a multiple of π/2 are on it: URDFs write 1.5707963267949. Coarser ones are taken
/// as written, so that torques stay those of other tools to the last digits.
pub(super) const SNAP: f64 = 2e-13;

/// Angles this close (rad) to a multiple of π/2 are right in [`crate::tree::Tree::structure`], and listed in
/// [`crate::tree::Tree::nearly_right_angles`].
pub(crate) const NEARLY_RIGHT: f64 = 1e-4;

impl Rotation {
    /// From URDF roll, pitch, yaw about fixed axes.
    pub fn from_rpy(rpy: [f64; 3]) -> Self {
        Self(vec![(2, rpy[2]), (1, rpy[1]), (0, rpy[0])]).simplified(SNAP)
    }

    /// The rotation that turns the z axis onto the unit vector `axis`.
    pub fn z_onto(axis: [f64; 3]) -> Self {
        let horizontal = axis[0].hypot(axis[1]);
        Self(vec![(2, axis[1].atan2(axis[0])), (1, horizontal.atan2(axis[2]))]).simplified(SNAP)
    }

    /// The small rotation that turns coordinate axis `k` onto the unit vector `axis` beside it.
    pub(super) fn near(k: usize, axis: [f64; 3]) -> Self {
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        let first = (-axis[v]).atan2(axis[k]);
        Self(vec![(u, first), (v, axis[u].atan2(axis[v].hypot(axis[k])))]).simplified(SNAP)
    }

    /// `self · other`
    pub fn then(&self, other: &Self) -> Self {
        Self(self.0.iter().chain(&other.0).copied().collect()).simplified(SNAP)
    }

    /// The inverse.
    pub fn inverse(&self) -> Self {
        Self(self.0.iter().rev().map(|&(axis, angle)| (axis, -angle)).collect())
    }

    /// Whether nothing turns.
    pub fn is_identity(&self) -> bool {
        self.0.is_empty()
    }

    /// Merges neighbours about the same axis, snaps angles within `tolerance` (rad) of right ones and drops zeros.
    pub(super) fn simplified(self, tolerance: f64) -> Self {
        let mut out: Vec<(usize, f64)> = Vec::new();
        for (axis, angle) in self.0 {
            let mut total = angle;
            if out.last().is_some_and(|last| last.0 == axis) {
                total += out.pop().map_or(0.0, |last| last.1);
            }
            let total = snap(total, tolerance);
            if total != 0.0 {
                out.push((axis, total));
            }
        }
        Self(out)
    }

    /// Rows of the matrix.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        let mut m = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for &(axis, angle) in &self.0 {
            let (s, c) = exact_sin_cos(angle);
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for row in &mut m {
                (row[u], row[v]) = (row[u] * c + row[v] * s, row[v] * c - row[u] * s);
            }
        }
        m
    }
}

/// `angle` moved onto the multiple of π/2 that is within `tolerance`, modulo full turns; else unchanged.
pub(super) fn snap(angle: f64, tolerance: f64) -> f64 {
    let quarter = (angle / FRAC_PI_2).round();
    if (angle - quarter * FRAC_PI_2).abs() > tolerance {
        return angle;
    }
    match (quarter as i64).rem_euclid(4) {
        0 => 0.0,
        1 => FRAC_PI_2,
        2 => 2.0 * FRAC_PI_2,
        _ => -FRAC_PI_2,
    }
}

/// Matrix (rows) times vector.
pub fn matrix_vector(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|r| m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2])
}

/// A constant placement of one frame in another.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placement {
    /// Orientation.
    pub rotation: Rotation,
    /// Origin, m.
    pub translation: [f64; 3],
}

impl Placement {
    /// A shift without rotation.
    pub fn shift(translation: [f64; 3]) -> Self {
        Self { rotation: Rotation::default(), translation }
    }

    /// `self · other`: `other` is placed in the frame that `self` places.
    pub fn then(&self, other: &Self) -> Self {
        let turned = matrix_vector(&self.rotation.matrix(), other.translation);
        Self {
            rotation: self.rotation.then(&other.rotation),
            translation: [0, 1, 2].map(|i| clean(self.translation[i] + turned[i])),
        }
    }

    /// The inverse placement.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        let turned = matrix_vector(&rotation.matrix(), self.translation);
        Self { rotation, translation: turned.map(|x| clean(-x)) }
    }
}

/// Rounding dust of sums of lengths (m) counts as zero: below 1e-15 m nothing is meant.
fn clean(x: f64) -> f64 {
    if x.abs() < 1e-15 { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes() {
        let p = Placement { rotation: Rotation::from_rpy([0.3, -0.7, 1.1]), translation: [1.0, 2.0, 3.0] };
        let e = p.then(&p.inverse());
        assert!(e.translation.iter().all(|x| x.abs() < 1e-14));
        let m = e.rotation.matrix();
        for (r, row) in m.iter().enumerate() {
            for (c, x) in row.iter().enumerate() {
                assert!((x - f64::from(u8::from(r == c))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn z_onto_reaches_the_axis() {
        for axis in [[0.6, 0.0, 0.8], [0.0, -1.0, 0.0], [0.48, 0.64, -0.6], [0.0, 0.0, -1.0]] {
            let z = matrix_vector(&Rotation::z_onto(axis).matrix(), [0.0, 0.0, 1.0]);
            assert!((0..3).all(|i| (z[i] - axis[i]).abs() < 1e-15), "{z:?} {axis:?}");
        }
    }

    #[test]
    fn near_reaches_the_axis() {
        for k in 0..3 {
            let mut axis = [3e-5, -2e-6, 4e-7];
            axis[k] = (0..3).filter(|i| *i != k).fold(1.0, |rest: f64, i| rest - axis[i] * axis[i]).sqrt();
            let m = Rotation::near(k, axis).matrix();
            assert!((0..3).all(|i| (m[i][k] - axis[i]).abs() < 1e-15), "{m:?} {axis:?}");
        }
    }

    // As URDFs write them.
    #[allow(clippy::approx_constant)]
    #[test]
    fn right_angles_are_exact() {
        let m = Rotation::from_rpy([1.5707963267949, 0.0, -3.14159265358979]).matrix();
        assert!(m.iter().flatten().all(|&x| x == 0.0 || x.abs() == 1.0), "{m:?}");
    }
}
