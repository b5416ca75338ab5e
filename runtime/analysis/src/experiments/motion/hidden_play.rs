//! The motion of a link behind play, where only its motor's angle is measured.
//!
//! A link that rests on a stop moves as its motor does, half a gap away on the side to which the transmitted torque pushes; stops give way by
//! torque times yielding. Where that torque, τ₀ + K e, comes to zero the link leaves: M ë + K e + τ₀ = 0, with e = q − θ and what hidden_link
//! calls M, K, τ₀, until it meets a stop, where it stays (stops of gears hardly let it bounce). Nothing is drawn after the
//! measured torque: the contact forgets what the estimate was off by. What comes out is as sharp as reality; it passes the
//! filter of all positions, so that it is what a filtered encoder on the link would have said.
use super::hidden_link::LEAST_INERTIA;
use crate::signal::{Butterworth, Spline};
use std::ops::Range;

/// Longest step of the flight between the stops, s.
const FLIGHT_STEP: f64 = 5e-4;

/// What is known of the joint at every sample.
pub(super) struct Play<'a> {
    /// τ₀, N m.
    pub load: &'a [f64],
    /// M (kg m²) and K (N m/rad).
    pub resistance: &'a [[f64; 2]],
    /// Stretches without gaps.
    pub segments: &'a [Range<usize>],
    /// s
    pub step: f64,
    /// That of the positions; `None`: none.
    pub filter: Option<&'a Butterworth>,
}

/// Where the link is between the stops.
#[derive(Clone, Copy)]
enum Place {
    /// On the stop that pushes it forwards (1) or backwards (−1).
    On(f64),
    /// Link minus motor and its rate: rad, rad/s.
    Between([f64; 2]),
}

impl Play<'_> {
    /// Link minus motor at every sample behind this play (rad) of stops that yield (rad/(N m)): angle, velocity, acceleration
    /// (rad, rad/s, rad/s²).
    pub fn behind(&self, gap: f64, yielding: f64) -> Vec<[f64; 3]> {
        let mut motion = vec![[0.0; 3]; self.load.len()];
        for segment in self.segments {
            let sharp = self.angles(gap, yielding, segment.clone());
            let smooth = self.filter.map_or_else(|| sharp.clone(), |filter| filter.zero_phase(&sharp));
            match Spline::new(&smooth, self.step) {
                Some(spline) => {
                    let motion = motion[segment.clone()].iter_mut().enumerate();
                    motion.for_each(|(i, motion)| *motion = spline.at_sample(i));
                }
                None => motion[segment.clone()].iter_mut().zip(smooth).for_each(|(m, e)| m[0] = e),
            }
        }
        motion
    }

    /// The angles of a stretch before the filter.
    fn angles(&self, gap: f64, yielding: f64, samples: Range<usize>) -> Vec<f64> {
        let half = 0.5 * gap;
        let mut place = Place::On(1.0_f64.copysign(self.load.get(samples.start).copied().unwrap_or(0.0)));
        let mut angles = Vec::with_capacity(samples.len());
        for i in samples.clone() {
            angles.push(match place {
                Place::On(side) => {
                    let pressed = (self.load[i] - self.resistance[i][1] * side * half) * side;
                    -side * (half + yielding * pressed.max(0.0))
                }
                Place::Between([e, _]) => e,
            });
            if i + 1 < samples.end {
                place = self.next(half, i, place);
            }
        }
        angles
    }

    /// From a sample to the next; what is known lies on straight lines between them.
    fn next(&self, half: f64, i: usize, mut place: Place) -> Place {
        let parts = (self.step / FLIGHT_STEP).ceil().clamp(1.0, 100.0);
        for part in 0..parts as usize {
            let (from, to) = (part as f64 / parts, (part + 1) as f64 / parts);
            place = match place {
                Place::On(side) => match self.leaves(half, i, side, [from, to]) {
                    Some(at) => self.fly(half, i, [-side * half, 0.0], [at, to]),
                    None => place,
                },
                Place::Between(state) => self.fly(half, i, state, [from, to]),
            };
        }
        place
    }

    /// Between samples: τ₀, M and K.
    fn between(&self, i: usize, part: f64) -> [f64; 3] {
        let mix = |a: f64, b: f64| a + part * (b - a);
        let ([m0, k0], [m1, k1]) = (self.resistance[i], self.resistance[i + 1]);
        [mix(self.load[i], self.load[i + 1]), mix(m0, m1).max(LEAST_INERTIA), mix(k0, k1)]
    }

    /// When, as a part of the sampling step, a stop no longer pushes.
    fn leaves(&self, half: f64, i: usize, side: f64, [from, to]: [f64; 2]) -> Option<f64> {
        let pressed = |part: f64| {
            let [load, _, slope] = self.between(i, part);
            (load - slope * side * half) * side
        };
        let [before, after] = [pressed(from), pressed(to)];
        let part = if before <= 0.0 { 0.0 } else { before / (before - after) };
        (after < 0.0).then_some(from + part * (to - from))
    }

    /// Freely, or until it meets a stop.
    fn fly(&self, half: f64, i: usize, [e, v]: [f64; 2], [from, to]: [f64; 2]) -> Place {
        let [load, inertia, slope] = self.between(i, 0.5 * (from + to));
        let h = (to - from) * self.step;
        let v = v - h * (load + slope * e) / inertia;
        let e = e + h * v;
        if e.abs() < half { Place::Between([e, v]) } else { Place::On(-e.signum()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAP: f64 = 0.02;
    const STEP: f64 = 0.002;

    /// A link of 0.1 kg m² under a load that passes zero at 1 s with 5 N m/s.
    fn crossing(filter: Option<&Butterworth>, gap: f64, yielding: f64) -> Vec<[f64; 3]> {
        let load: Vec<f64> = (0..1000).map(|i| 5.0 * (f64::from(i) * STEP - 1.0)).collect();
        let resistance = vec![[0.1, 0.0]; load.len()];
        let whole = 0..load.len();
        let segments = std::slice::from_ref(&whole);
        Play { load: &load, resistance: &resistance, segments, step: STEP, filter }.behind(gap, yielding)
    }

    #[test]
    fn a_link_flies_from_stop_to_stop_as_long_as_its_equation_says() {
        let motion = crossing(None, GAP, 0.0);
        // Negative load: it hangs on the stop that pushes backwards, behind its motor by +gap/2.
        assert!(motion[..500].iter().all(|[e, ..]| (e - 0.5 * GAP).abs() < 1e-12));
        // e = gap/2 − s t³/6M until −gap/2.
        let flight = (6.0 * 0.1 * GAP / 5.0_f64).cbrt();
        let landed = motion.iter().position(|[e, ..]| *e <= -0.5 * GAP).unwrap();
        assert!((landed as f64 * STEP - 1.0 - flight).abs() < 1.5 * STEP, "{landed}: {flight}");
        let middle = 1.0 + 0.6 * flight;
        let expected = 0.5 * GAP - 5.0 * (0.6 * flight).powi(3) / 0.6;
        let [e, ..] = motion[(middle / STEP).round() as usize];
        assert!((e - expected).abs() < 0.06 * GAP, "{e} {expected}");
        assert!(motion[landed..].iter().all(|[e, ..]| (e + 0.5 * GAP).abs() < 1e-12));
    }

    #[test]
    fn small_changes_of_the_play_change_little() {
        // What an estimate of the play by slopes rests on.
        let [less, more] = [GAP, GAP + 1e-6].map(|gap| crossing(None, gap, 0.0));
        let slopes: Vec<f64> = less.iter().zip(&more).map(|(a, b)| (b[0] - a[0]) / 1e-6).collect();
        assert!(slopes.iter().all(|slope| slope.abs() < 1.2), "{slopes:?}");
        assert!((slopes[100] - 0.5).abs() < 1e-6 && (slopes[900] + 0.5).abs() < 1e-6);
    }

    #[test]
    fn stops_that_yield_widen_the_play_by_the_torque() {
        let motion = crossing(None, GAP, 1e-3);
        assert!((motion[0][0] - (0.5 * GAP + 5e-3)).abs() < 1e-12);
    }

    #[test]
    fn it_is_filtered_as_positions_are() {
        let filter = Butterworth::new(10.0, 1.0 / STEP).unwrap();
        let sharp: Vec<f64> = crossing(None, GAP, 0.0).iter().map(|m| m[0]).collect();
        let smooth = filter.zero_phase(&sharp);
        let motion = crossing(Some(&filter), GAP, 0.0);
        assert!(motion.iter().zip(&smooth).all(|(m, e)| (m[0] - e).abs() < 1e-9));
        // Its velocity is that of the filtered angle.
        let rate = (smooth[541] - smooth[539]) / (2.0 * STEP);
        assert!((motion[540][1] / rate - 1.0).abs() < 0.01, "{} {rate}", motion[540][1]);
    }
}
