//! The cosine profile of velocities (6.43), corrected.
use std::f64::consts::TAU;

/// Position, velocity and acceleration.
pub type Moved = [f64; 3];

/// The part of the way after the part `s` of the time, and its first two derivatives by `s`: `s − sin(2π s) / 2π`.
///
/// Equation (6.43) as corrected: the sine stands outside the quotient of time and duration. Velocity and acceleration vanish at both ends.
pub fn cosine(s: f64) -> Moved {
    let s = s.clamp(0.0, 1.0);
    let (sine, cosine) = (TAU * s).sin_cos();
    [s - sine / TAU, 1.0 - cosine, TAU * sine]
}

/// On the way from `from` to `to` within `duration` (s), `time` (s) after its beginning.
pub fn moved([from, to]: [f64; 2], time: f64, duration: f64) -> Moved {
    if duration <= 0.0 {
        return [to, 0.0, 0.0];
    }
    let [x, v, a] = cosine(time / duration);
    let way = to - from;
    [from + way * x, way * v / duration, way * a / (duration * duration)]
}
