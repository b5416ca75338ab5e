//! Angles whose sine and cosine are known exactly.
use std::f64::consts::FRAC_PI_2;

/// Sine and cosine, exact on multiples of π/2.
pub fn exact_sin_cos(angle: f64) -> (f64, f64) {
    let quarter = angle / FRAC_PI_2;
    if quarter == quarter.round() && quarter.abs() < 1e9 {
        return match (quarter as i64).rem_euclid(4) {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        };
    }
    angle.sin_cos()
}
