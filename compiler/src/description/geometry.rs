//! A little geometry for checks and guesses; the derivations proper have their own, symbolic one.
use super::model::{Inertial, Pose};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

pub(crate) type Vector = [f64; 3];
pub(crate) type Matrix = [[f64; 3]; 3];

pub(crate) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Rotation and translation from a frame to the one it is described in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) rotation: Matrix,
    pub(crate) position: Vector,
}

impl Frame {
    pub(crate) const IDENTITY: Self = Self { rotation: IDENTITY, position: [0.0; 3] };

    pub(crate) fn of(pose: &Pose) -> Self {
        Self { rotation: rotation(pose.rpy), position: pose.xyz }
    }

    /// First `inner`, then `self`.
    pub(crate) fn compose(&self, inner: &Self) -> Self {
        Self { rotation: multiply(&self.rotation, &inner.rotation), position: self.point(inner.position) }
    }

    pub(crate) fn point(&self, p: Vector) -> Vector {
        add(self.direction(p), self.position)
    }

    pub(crate) fn inverse(&self) -> Self {
        let rotation = transpose(&self.rotation);
        Self { rotation, position: rotation.map(|row| -dot(row, self.position)) }
    }

    pub(crate) fn direction(&self, v: Vector) -> Vector {
        self.rotation.map(|row| dot(row, v))
    }
}

/// `Rz(yaw) Ry(pitch) Rx(roll)`.
pub(crate) fn rotation([roll, pitch, yaw]: Vector) -> Matrix {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// Roll, pitch and yaw of the rotation of a quaternion x y z w of any length but zero, which has none.
///
/// From half the sum and half the difference of roll and yaw, which keep all digits where the pitch comes near a right angle
/// and only one of them means something.
pub(crate) fn quaternion_to_rpy([x, y, z, w]: [f64; 4]) -> Option<Vector> {
    if [x, y, z, w] == [0.0; 4] {
        return None;
    }
    let (with, against) = ((w - y).hypot(x + z), (w + y).hypot(x - z));
    let half_sum = if with == 0.0 { 0.0 } else { (x + z).atan2(w - y) };
    let half_difference = if against == 0.0 { 0.0 } else { (x - z).atan2(w + y) };
    let within_a_turn = |angle: f64| if angle.abs() > PI { angle - TAU.copysign(angle) } else { angle };
    let (roll, yaw) = (half_sum + half_difference, half_sum - half_difference);
    Some([within_a_turn(roll), 2.0 * against.atan2(with) - FRAC_PI_2, within_a_turn(yaw)])
}

/// The rotation about a unit axis, as a quaternion x y z w.
pub(crate) fn axis_quaternion([x, y, z]: Vector, angle: f64) -> [f64; 4] {
    let (sin, cos) = (0.5 * angle).sin_cos();
    [x * sin, y * sin, z * sin, cos]
}

/// First `b`, then `a`; quaternions x y z w.
pub(crate) fn quaternion_product([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// A direction turned by roll, pitch and yaw.
pub(crate) fn turn(rpy: Vector, direction: Vector) -> Vector {
    rotation(rpy).map(|row| dot(row, direction))
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|x| x * factor)
}

pub(crate) fn norm(a: Vector) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

pub(crate) fn transpose(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

pub(crate) fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// Eigenvalues of a symmetric matrix, ascending (Jacobi rotations).
pub(crate) fn eigenvalues(symmetric: &Matrix) -> Vector {
    let mut a = *symmetric;
    // Each sweep squares the relative size of what is off the diagonal; a fixed count also ends on NaN.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (sine, cosine) = (0.5 * (2.0 * a[p][q]).atan2(a[p][p] - a[q][q])).sin_cos();
            let mut turn = IDENTITY;
            turn[p][p] = cosine;
            turn[q][q] = cosine;
            turn[p][q] = -sine;
            turn[q][p] = sine;
            a = multiply(&multiply(&transpose(&turn), &a), &turn);
        }
    }
    let mut values = [a[0][0], a[1][1], a[2][2]];
    values.sort_by(f64::total_cmp);
    values
}

/// Mass, first moment and inertia about the frame's origin: quantities that simply add.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    pub(crate) mass: f64,
    pub(crate) first: Vector,
    pub(crate) second: Matrix,
}

impl Moments {
    pub(crate) const ZERO: Self = Self { mass: 0.0, first: [0.0; 3], second: [[0.0; 3]; 3] };

    /// Of a link, in the frame that `frame` leads to.
    pub(crate) fn of(inertial: &Inertial, frame: &Frame) -> Self {
        let frame = frame.compose(&Frame::of(&inertial.origin));
        let (mass, c) = (inertial.mass, frame.position);
        let central = inertia_matrix(inertial.inertia);
        let turned = multiply(&multiply(&frame.rotation, &central), &transpose(&frame.rotation));
        Self { mass, first: scale(c, mass), second: combine(&turned, &steiner(mass, c), 1.0) }
    }

    pub(crate) fn add(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: add(self.first, other.first),
            second: combine(&self.second, &other.second, 1.0),
        }
    }

    pub(crate) fn center_of_mass(&self) -> Vector {
        if self.mass > 0.0 { scale(self.first, 1.0 / self.mass) } else { [0.0; 3] }
    }

    /// Inertia about the centre of mass.
    pub(crate) fn central(&self) -> Matrix {
        combine(&self.second, &steiner(self.mass, self.center_of_mass()), -1.0)
    }
}

/// `ixx, ixy, ixz, iyy, iyz, izz` as a matrix.
pub(crate) fn inertia_matrix([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Matrix {
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

/// `m (|c|² 1 − c cᵀ)`.
fn steiner(mass: f64, c: Vector) -> Matrix {
    let square = dot(c, c);
    std::array::from_fn(|i| std::array::from_fn(|j| mass * (if i == j { square } else { 0.0 } - c[i] * c[j])))
}

fn combine(a: &Matrix, b: &Matrix, factor: f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + factor * b[i][j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also where roll and yaw turn about one axis, and beside it.
    #[test]
    fn angles_of_quaternions_turn_as_they_do() {
        for k in 0..2000 {
            let mut quaternion: [f64; 4] =
                std::array::from_fn(|i| ((k * k + 3 * i * k + i) as f64 * 0.731).sin());
            if k % 4 == 0 {
                // w = y and z = -x: the pitch is a right angle; then up to 1e-15 beside it.
                let [x, y, ..] = quaternion;
                quaternion = [x, y, -x, y * (1.0 + 10f64.powi(-(k as i32 / 4) % 16))];
            }
            let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
            let [x, y, z, w] = quaternion.map(|part| part / length);
            let expected = [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
                [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
            ];
            let found = rotation(quaternion_to_rpy(quaternion).unwrap());
            for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((found - expected).abs() < 3e-15, "{quaternion:?}: {found} {expected}");
            }
        }
        assert_eq!(quaternion_to_rpy([0.0; 4]), None);
    }
}
