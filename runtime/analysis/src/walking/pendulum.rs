//! The linear inverted pendulum under a given zero moment point, bounded by its divergent component of motion.

/// Samples at the beginning and at the end in which the robot comes out of rest and back to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rest {
    /// At the beginning.
    pub start: usize,
    /// At the end.
    pub end: usize,
}

/// Position (m), velocity and acceleration of the centre of mass along one axis, whose pendulum `ẍ = ω² (x − p)` has the zero moment point
/// `p` (m, one per sample of `step` s, straight in between).
///
/// Over one step with constant `p` this is (6.45), (6.46). The divergent component `ξ = x + ẋ / ω` is unstable forwards, so it is
/// integrated backwards from rest at the end, `x` forwards along `ẋ = ω (ξ − x)`; both in closed form between samples. That the motion
/// also begins and ends at rest above `p` takes one bump of `p` in the first and one in the last samples (`rest`), of the form `1 − cos`, which
/// are returned within the second result: `p` as it is really used.
pub fn pendulum(zmp: &[f64], step: f64, omega: f64, rest: Rest) -> (Vec<[f64; 3]>, Vec<f64>) {
    let n = zmp.len();
    if n < 2 {
        return (zmp.iter().map(|p| [*p, 0.0, 0.0]).collect(), zmp.to_vec());
    }
    let bumps = [bump(n, 0, rest.start), bump(n, n - 1 - rest.end.min(n - 1), rest.end)];
    // What is missing at both ends is linear in the sizes of both bumps.
    let missing = |p: &[f64]| {
        let (motion, start) = follow(p, step, omega);
        [start - p[0], motion[n - 1][0] - p[n - 1]]
    };
    let own = missing(zmp);
    let of_bumps = bumps.each_ref().map(|bump| missing(bump));
    let [[a, c], [b, d]] = of_bumps;
    let determinant = a * d - b * c;
    let sizes = if determinant.abs() > 1e-300 {
        [(b * own[1] - d * own[0]) / determinant, (c * own[0] - a * own[1]) / determinant]
    } else {
        [0.0; 2]
    };
    let used: Vec<f64> = (0..n).map(|k| zmp[k] + sizes[0] * bumps[0][k] + sizes[1] * bumps[1][k]).collect();
    (follow(&used, step, omega).0, used)
}

fn bump(n: usize, first: usize, length: usize) -> Vec<f64> {
    let at = |k: usize| {
        let part = (k as f64 - first as f64) / length.max(1) as f64;
        if (0.0..=1.0).contains(&part) { 0.5 * (1.0 - (std::f64::consts::TAU * part).cos()) } else { 0.0 }
    };
    (0..n).map(at).collect()
}

/// The motion that begins above `p`, and the divergent component at the beginning.
fn follow(p: &[f64], step: f64, omega: f64) -> (Vec<[f64; 3]>, f64) {
    let n = p.len();
    let shrinks = (-omega * step).exp();
    let mut divergent = vec![p[n - 1]; n];
    for k in (0..n - 1).rev() {
        let slope = (p[k + 1] - p[k]) / step;
        divergent[k] = shrinks * divergent[k + 1]
            + p[k] * (1.0 - shrinks)
            + slope * ((1.0 - shrinks) / omega - step * shrinks);
    }
    let (grown, sine) = ((omega * step).cosh(), (omega * step).sinh());
    let mut x = p[0];
    let mut motion = Vec::with_capacity(n);
    for k in 0..n {
        let velocity = omega * (divergent[k] - x);
        motion.push([x, velocity, omega * omega * (x - p[k])]);
        if k + 1 < n {
            let slope = (p[k + 1] - p[k]) / step;
            x = p[k + 1] + (x - p[k]) * grown + (velocity - slope) / omega * sine;
        }
    }
    (motion, divergent[0])
}
