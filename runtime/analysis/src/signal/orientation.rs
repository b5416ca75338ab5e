//! Angular velocity and acceleration from a filtered quaternion.

/// Orientation of the base and its rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    /// Unit quaternion x y z w, base to world.
    pub quaternion: [f64; 4],
    /// Base axes, rad/s.
    pub velocity: [f64; 3],
    /// Time derivative of `velocity`, rad/s².
    pub acceleration: [f64; 3],
}

/// Flips signs so that neighbouring quaternions (columns x, y, z, w) are near each other.
///
/// q and −q are the same orientation, but a filter needs them continuous.
pub fn align_signs(columns: [&mut [f64]; 4]) {
    let [x, y, z, w] = columns;
    let length = x.len().min(y.len()).min(z.len()).min(w.len());
    for i in 1..length {
        let dot = x[i] * x[i - 1] + y[i] * y[i - 1] + z[i] * z[i - 1] + w[i] * w[i - 1];
        if dot < 0.0 {
            for column in [&mut *x, &mut *y, &mut *z, &mut *w] {
                column[i] = -column[i];
            }
        }
    }
}

/// Orientation and rates from a quaternion x y z w and its first two time derivatives.
///
/// The quaternion need not be of unit length, and its length may change (a filter sees to both): with q = s u,
/// vec(q* q̇) = s² ω / 2 whatever ṡ is. `None` if it is zero.
pub fn rotation(q: [f64; 4], rate: [f64; 4], second: [f64; 4]) -> Option<Rotation> {
    let square = dot(q, q);
    if !(square > 1e-12 && square.is_finite()) {
        return None;
    }
    let velocity = conjugate_product(q, rate).map(|c| 2.0 * c / square);
    let growth = 2.0 * dot(q, rate) / square;
    let second = conjugate_product(q, second);
    // d/dt vec(q* q̇) = vec(q* q̈), since q̇* q̇ is a scalar.
    let acceleration = std::array::from_fn(|i| 2.0 * second[i] / square - growth * velocity[i]);
    let norm = square.sqrt();
    Some(Rotation { quaternion: q.map(|c| c / norm), velocity, acceleration })
}

/// A world vector in the axes of the base with this unit quaternion (x y z w, base to world).
pub fn rotate_to_base(quaternion: [f64; 4], vector: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = quaternion;
    let axis = [-x, -y, -z];
    let t = cross(axis, vector).map(|c| 2.0 * c);
    let u = cross(axis, t);
    std::array::from_fn(|i| vector[i] + w * t[i] + u[i])
}

/// a × b
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The vector part of q* p.
fn conjugate_product(q: [f64; 4], p: [f64; 4]) -> [f64; 3] {
    let (qv, pv) = ([q[0], q[1], q[2]], [p[0], p[1], p[2]]);
    let c = cross(qv, pv);
    std::array::from_fn(|i| q[3] * pv[i] - p[3] * qv[i] - c[i])
}
