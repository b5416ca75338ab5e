//! The motion of a link behind a spring, where only its motor's angle is measured.
//!
//! The torque of the spring, s = k (θ − q), moves the link: M ë + K e + τ₀ = −k e, with e = q − θ, τ₀ what the link would need if it
//! moved as the motor does, M = D_jj, and K the slope of τ₀ over the joint's angle. The equation is integrated along the log by
//! the trapezoidal rule, which damps nothing: near the resonance the numerical damping of other rules of Newmark's family is as large as
//! what the drawing below makes, and shows in the torque. Free oscillations cannot be known from the motor's motion alone: the measured
//! torque draws the estimate slowly after itself, as in an observer. That comes late; integrated from the end to the beginning it
//! comes early by as much, and the mean of both is in time.
use std::ops::Range;

/// Newmark's γ and β of the trapezoidal rule.
pub(super) const GAMMA: f64 = 0.5;
pub(super) const BETA: f64 = 0.25;
/// Damping ratio of what the estimate is off by.
const DRAWN: f64 = 0.15;
/// Least inertia, kg m²: the equation has a solution for any.
pub(super) const LEAST_INERTIA: f64 = 1e-9;

/// What is known of the joint at every sample.
pub(super) struct Link<'a> {
    /// τ₀, N m.
    pub load: &'a [f64],
    /// M (kg m²) and K (N m/rad).
    pub resistance: &'a [[f64; 2]],
    /// Measured torque through the spring, N m; empty: none.
    pub measured: &'a [f64],
    /// Stretches without gaps.
    pub segments: &'a [Range<usize>],
    /// s
    pub step: f64,
}

impl Link<'_> {
    /// Link minus motor behind a spring (N m/rad) at every sample: angle, velocity, acceleration (rad, rad/s, rad/s²).
    pub fn behind(&self, stiffness: f64) -> Vec<[f64; 3]> {
        let mut mean = vec![[0.0; 3]; self.load.len()];
        let at_rest =
            |first: usize| [-self.load[first] / (stiffness + self.resistance[first][1].max(0.0)), 0.0, 0.0];
        let next = |i: usize, state: &[f64; 3]| self.next(stiffness, i, *state);
        along(self.segments, &at_rest, &next, &|state| reversed(*state), &mut |i, late, early| {
            mean[i] = middle(*late, *early);
        });
        mean
    }

    fn next(&self, stiffness: f64, i: usize, [e, v, a]: [f64; 3]) -> [f64; 3] {
        let (h, load, [inertia, slope]) = (self.step, self.load[i], self.resistance[i]);
        let inertia = inertia.max(LEAST_INERTIA);
        let (ahead, faster) = (e + h * v + h * h * (0.5 - BETA) * a, v + h * (1.0 - GAMMA) * a);
        let inertial = inertia / (BETA * h * h);
        // A slope that turns the link over is taken explicitly: the rest always has a solution.
        let (implicit, explicit) = (slope.max(0.0), slope.min(0.0));
        let e = (inertial * ahead - load - explicit * ahead) / (inertial + implicit + stiffness);
        let a = (e - ahead) / (BETA * h * h);
        let v = faster + h * GAMMA * a;
        let off = self.measured.get(i).map_or(0.0, |measured| -measured / stiffness - e);
        drawn([e, v, a], off, (stiffness / inertia).sqrt(), h)
    }
}

/// The states of all stretches: forwards and backwards, and forwards again, since what the first pass learns until the end the others know from
/// their beginning. `put` takes a sample with its states of the last two.
pub(super) fn along<S>(
    segments: &[Range<usize>],
    at_rest: &dyn Fn(usize) -> S,
    next: &dyn Fn(usize, &S) -> S,
    reversed: &dyn Fn(&S) -> S,
    put: &mut dyn FnMut(usize, &S, &S),
) {
    let pass = |start: S, samples: &mut dyn Iterator<Item = usize>| {
        let mut states = vec![start];
        for i in samples.skip(1) {
            states.push(next(i, &states[states.len() - 1]));
        }
        states
    };
    for segment in segments.iter().filter(|segment| !segment.is_empty()) {
        let once = pass(at_rest(segment.start), &mut segment.clone());
        let early = pass(reversed(&once[once.len() - 1]), &mut segment.clone().rev());
        let late = pass(reversed(&early[early.len() - 1]), &mut segment.clone());
        for ((i, late), early) in segment.clone().zip(&late).zip(early.iter().rev()) {
            put(i, late, &reversed(early));
        }
    }
}

/// A state that is off by so much, drawn to where it should be over a step `h` (s); `frequency` of its free oscillation, rad/s. Both angle and velocity, so
/// that what it is off by decays as a damped oscillation does, whatever its phase.
pub(super) fn drawn([e, v, a]: [f64; 3], off: f64, frequency: f64, h: f64) -> [f64; 3] {
    let drawn = (DRAWN * frequency * h).min(DRAWN);
    [e + 2.0 * drawn * off, v + drawn * drawn / h * off, a]
}

/// Halfway between two states.
pub(super) fn middle(late: [f64; 3], early: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| 0.5 * (late[k] + early[k]))
}

/// The state of the motion backwards in time.
pub(super) fn reversed([e, v, a]: [f64; 3]) -> [f64; 3] {
    [e, -v, a]
}

#[cfg(test)]
mod tests {
    use super::*;

    const STIFFNESS: f64 = 400.0;
    const STEP: f64 = 0.004;

    /// A link of 0.5 kg m² behind its motor, moved by sines, by small steps of the exact equation: load, angle behind, torque.
    fn simulated(oscillating: f64) -> [Vec<f64>; 3] {
        let (inertia, h, fine) = (0.5, STEP, 200);
        let motor = |t: f64| 0.4 * (5.0 * t).sin() + 0.1 * (13.0 * t).sin();
        let accelerated = |t: f64| -0.4 * 25.0 * (5.0 * t).sin() - 0.1 * 169.0 * (13.0 * t).sin();
        let (mut q, mut w) = (oscillating, 0.4 * 5.0 + 0.1 * 13.0);
        let [mut load, mut angle, mut torque] = [const { Vec::new() }; 3];
        for i in 0..2500 * fine {
            let t = i as f64 * h / fine as f64;
            let now = -STIFFNESS * (q - motor(t));
            if i % fine == 0 {
                load.push(inertia * accelerated(t));
                angle.push(q - motor(t));
                torque.push(now);
            }
            w += h / fine as f64 * now / inertia;
            q += h / fine as f64 * w;
        }
        [load, angle, torque]
    }

    fn estimated(load: &[f64], measured: &[f64]) -> Vec<[f64; 3]> {
        let resistance = vec![[0.5, 0.0]; load.len()];
        let whole = 0..load.len();
        let segments = std::slice::from_ref(&whole);
        Link { load, resistance: &resistance, measured, segments, step: STEP }.behind(STIFFNESS)
    }

    fn rms(values: impl Iterator<Item = f64>) -> f64 {
        let (sum, n) = values.fold((0.0, 0.0_f64), |(sum, n), x| (sum + x * x, n + 1.0));
        (sum / n).sqrt()
    }

    #[test]
    fn a_link_behind_a_spring_is_found_and_its_oscillation_too() {
        // The resonance of 4.5 Hz lies among what moves it.
        let [load, angle, torque] = simulated(0.05);
        let found = estimated(&load, &torque);
        let late = load.len() / 2..load.len();
        let size = rms(angle[late.clone()].iter().copied());
        let off = rms(late.clone().map(|i| found[i][0] - angle[i]));
        // Numerical damping (γ = 0.6) made it 0.033 of it.
        assert!(off < 0.002 * size, "{off} of {size}");
        // From the motor alone the oscillation is not known.
        let blind = estimated(&load, &[]);
        assert!(rms(late.map(|i| blind[i][0] - angle[i])) > 4.0 * off);
    }

    #[test]
    fn noise_of_the_torque_is_hardly_followed() {
        let mut random = bipedc_effects::random::Random::new(3);
        let noise: Vec<f64> = (0..5000).map(|_| random.symmetric()).collect();
        let found = estimated(&vec![0.0; 5000], &noise);
        let followed = rms(found.iter().map(|e| -STIFFNESS * e[0]));
        assert!(followed < 0.2 * rms(noise.into_iter()), "{followed}");
    }
}
