//! Vectors, turns and poses in space, without a panic: arrays of three numbers, matrices by rows.
use crate::real::Scalar;

/// x, y, z
pub type Vector<R> = [R; 3];
/// Rows of a 3 × 3 matrix; of a turn: what takes a frame's coordinates to the world's.
pub type Turn<R> = [[R; 3]; 3];

/// A frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose<R> {
    /// Its origin, m.
    pub position: Vector<R>,
    /// Its axes are the columns.
    pub turn: Turn<R>,
}

/// 0, 0, 0
pub fn zero<R: Scalar>() -> Vector<R> {
    [R::constant(0.0); 3]
}

/// The turn by nothing.
pub fn identity<R: Scalar>() -> Turn<R> {
    diagonal(R::constant(1.0))
}

/// x times the identity.
pub fn diagonal<R: Scalar>(x: R) -> Turn<R> {
    let o = R::constant(0.0);
    [[x, o, o], [o, x, o], [o, o, x]]
}

/// a + b
pub fn add<R: Scalar>([a, b, c]: Vector<R>, [d, e, f]: Vector<R>) -> Vector<R> {
    [a + d, b + e, c + f]
}

/// a − b
pub fn subtract<R: Scalar>([a, b, c]: Vector<R>, [d, e, f]: Vector<R>) -> Vector<R> {
    [a - d, b - e, c - f]
}

/// x a
pub fn scale<R: Scalar>(x: R, [a, b, c]: Vector<R>) -> Vector<R> {
    [x * a, x * b, x * c]
}

/// a + x b
pub fn along<R: Scalar>([a, b, c]: Vector<R>, x: R, [d, e, f]: Vector<R>) -> Vector<R> {
    [R::fused(x, d, a), R::fused(x, e, b), R::fused(x, f, c)]
}

/// a · b
pub fn dot<R: Scalar>([a, b, c]: Vector<R>, [d, e, f]: Vector<R>) -> R {
    R::fused(a, d, R::fused(b, e, c * f))
}

/// a × b
pub fn cross<R: Scalar>([a, b, c]: Vector<R>, [d, e, f]: Vector<R>) -> Vector<R> {
    [R::fused(b, f, -(c * e)), R::fused(c, d, -(a * f)), R::fused(a, e, -(b * d))]
}

/// |a|
pub fn length<R: Scalar>(a: Vector<R>) -> R {
    dot(a, a).sqrt()
}

/// M a
pub fn turned<R: Scalar>([x, y, z]: Turn<R>, a: Vector<R>) -> Vector<R> {
    [dot(x, a), dot(y, a), dot(z, a)]
}

/// Mᵀ
pub fn transpose<R: Scalar>([[a, b, c], [d, e, f], [g, h, i]]: Turn<R>) -> Turn<R> {
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// Mᵀ a
pub fn turned_back<R: Scalar>(turn: Turn<R>, a: Vector<R>) -> Vector<R> {
    turned(transpose(turn), a)
}

/// A B
pub fn product<R: Scalar>(a: Turn<R>, b: Turn<R>) -> Turn<R> {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// The matrix of a × ·
pub fn cross_matrix<R: Scalar>([x, y, z]: Vector<R>) -> Turn<R> {
    let o = R::constant(0.0);
    [[o, -z, y], [z, o, -x], [-y, x, o]]
}

/// Counterclockwise about z by this angle, rad.
pub fn about_z<R: Scalar>(angle: R) -> Turn<R> {
    let (s, c) = crate::math::sin_cos(angle);
    let (o, one) = (R::constant(0.0), R::constant(1.0));
    [[c, -s, o], [s, c, o], [o, o, one]]
}

/// Of a unit quaternion x, y, z, w.
pub fn of_quaternion<R: Scalar>([x, y, z, w]: [R; 4]) -> Turn<R> {
    let (one, two) = (R::constant(1.0), R::constant(2.0));
    [
        [one - two * (y * y + z * z), two * (x * y - z * w), two * (x * z + y * w)],
        [two * (x * y + z * w), one - two * (x * x + z * z), two * (y * z - x * w)],
        [two * (x * z - y * w), two * (y * z + x * w), one - two * (x * x + y * y)],
    ]
}

/// The rotation vector (world axes, its sine instead of its angle, rad) that takes `here` to `there`; good below a quarter turn.
pub fn turn_between<R: Scalar>(here: Turn<R>, there: Turn<R>) -> Vector<R> {
    let half = R::constant(0.5);
    let (here, there) = (transpose(here), transpose(there));
    let [a, b, c] = [0, 1, 2].map(|k| match (here.get(k), there.get(k)) {
        (Some(here), Some(there)) => cross(*here, *there),
        _ => zero(),
    });
    scale(half, add(a, add(b, c)))
}

/// The angle near 0 (rad, below a quarter turn) of a direction (cosine, sine; of any length), by Newton's method.
pub fn angle_near_zero<R: Scalar>(cosine: R, sine: R) -> R {
    let length = (cosine * cosine + sine * sine).sqrt();
    let least = R::constant(1e-30);
    if length <= least || !length.is_finite() {
        return R::constant(0.0);
    }
    let (cosine, sine) = (cosine / length, sine / length);
    let mut angle = sine;
    for _ in 0..4 {
        let (s, c) = crate::math::sin_cos(angle);
        // sin(θ − angle) ≈ θ − angle.
        let rest = R::fused(sine, c, -(cosine * s));
        angle = angle + rest * (R::constant(1.0) + rest * rest * R::constant(1.0 / 6.0));
    }
    angle
}

/// The angle of a direction (cosine, sine; of any length), rad, from −π to π.
pub fn angle<R: Scalar>(cosine: R, sine: R) -> R {
    let zero = R::constant(0.0);
    if cosine >= zero {
        return angle_near_zero(cosine, sine);
    }
    let half_turn = R::constant(core::f64::consts::PI);
    angle_near_zero(-cosine, -sine) + if sine < zero { -half_turn } else { half_turn }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_turn() {
        let quarter = about_z(core::f64::consts::FRAC_PI_2);
        let x = turned(quarter, [1.0, 0.0, 0.0]);
        assert!(length(subtract(x, [0.0, 1.0, 0.0])) < 1e-15);
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let same = of_quaternion([0.0, 0.0, half, half]);
        assert!(same.iter().flatten().zip(quarter.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-15));
        let vector = [0.3, -2.0, 0.7];
        assert!(length(subtract(turned_back(quarter, turned(quarter, vector)), vector)) < 1e-15);
        assert_eq!(cross([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(turned(cross_matrix([1.0, 2.0, 3.0]), vector), cross([1.0, 2.0, 3.0], vector));
    }

    #[test]
    fn the_turn_between_two_frames_is_a_rotation_vector() {
        let small: f64 = 1e-3;
        let found = turn_between(about_z(0.4), about_z(0.4 + small));
        assert!(length(subtract(found, [0.0, 0.0, small.sin()])) < 1e-15);
    }

    #[test]
    fn angles_are_found_again() {
        for k in -14..=14 {
            let angle = 0.1 * f64::from(k);
            assert!((angle_near_zero(2.0 * angle.cos(), 2.0 * angle.sin()) - angle).abs() < 1e-14, "{angle}");
        }
        assert_eq!(angle_near_zero(0.0, 0.0), 0.0);
        for k in -314..=314 {
            let wished = 0.01 * f64::from(k);
            assert!((angle(3.0 * wished.cos(), 3.0 * wished.sin()) - wished).abs() < 1e-14, "{wished}");
        }
    }
}
