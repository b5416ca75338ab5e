//! Attitudes as unit quaternions x, y, z, w.
use super::space::{Turn, Vector, cross, length, scale};
use crate::real::Scalar;

/// The turn of a frame whose z axis in its own coordinates is `up`, with its x axis in the plane of the world's x and z.
pub(super) fn upright<R: Scalar>(up: Vector<R>) -> Turn<R> {
    let (one, o) = (R::constant(1.0), R::constant(0.0));
    let up = scale(one / length(up), up);
    let [x, _, _] = up;
    let forward = if x.abs() < R::constant(0.9) { [one, o, o] } else { [o, one, o] };
    let left = cross(up, forward);
    let left = scale(one / length(left), left);
    [cross(left, up), left, up]
}

/// A unit quaternion x, y, z, w of a turn.
pub(super) fn to_quaternion<R: Scalar>([[a, b, c], [d, e, f], [g, h, i]]: Turn<R>) -> [R; 4] {
    let one = R::constant(1.0);
    // The largest of the four decides.
    let candidates = [
        [one + a - e - i, b + d, c + g, h - f],
        [b + d, one - a + e - i, f + h, c - g],
        [c + g, f + h, one - a - e + i, d - b],
        [h - f, c - g, d - b, one + a + e + i],
    ];
    let sizes = candidates.map(|[x, y, z, w]| x * x + y * y + z * z + w * w);
    let mut best = ([R::constant(0.0), R::constant(0.0), R::constant(0.0), one], R::constant(0.0));
    for (candidate, size) in candidates.into_iter().zip(sizes) {
        if size > best.1 {
            best = (candidate, size);
        }
    }
    unit(best.0)
}

fn unit<R: Scalar>(q: [R; 4]) -> [R; 4] {
    let [x, y, z, w] = q;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    q.map(|x| x / length)
}

/// A quaternion x, y, z, w turned by a rotation vector in axes of the world.
pub(super) fn turned_by<R: Scalar>([x, y, z, w]: [R; 4], vector: Vector<R>) -> [R; 4] {
    let half = R::constant(0.5);
    let angle = length(vector);
    let (sine, cosine) = crate::math::sin_cos(half * angle);
    // sin(a / 2) / a
    let part = if angle > R::constant(1e-6) { sine / angle } else { half };
    let [a, b, c] = scale(part, vector);
    unit([
        cosine * x + a * w + b * z - c * y,
        cosine * y - a * z + b * w + c * x,
        cosine * z + a * y - b * x + c * w,
        cosine * w - a * x - b * y - c * z,
    ])
}
