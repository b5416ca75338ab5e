//! Noise that remembers: its size, told from what a motion leaves.
//!
//! Third differences over one sample see all of white noise and little of noise that is correlated in time. Over `h` samples they
//! see, of a first-order noise of variance s whose neighbours correlate by ρ and white noise of variance w,
//!
//! V(h) / 20 = w + s (1 − 1.5 ρʰ + 0.6 ρ²ʰ − 0.1 ρ³ʰ):
//!
//! it grows by no more than h, from the first sample on, until the noise has forgotten. What follows the motion does otherwise: it
//! is not there over few samples, and grows by h² to h⁶ once it is. So the lags that count are those up to which the formula holds.
use super::noise::of_continuous;

/// Lags at which differences are looked at, samples.
const LAGS: [usize; 12] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];
/// The fewest that tell a formula of three numbers from anything else.
const FEWEST: usize = 5;
/// A signal has at least so many times a lag of samples.
pub(super) const SAMPLES_PER_LAG: usize = 60;
/// V(2) / V(1) of white noise scatters by less than this around 1, of `n` samples by less than [`SCATTER`] / √n.
const WHITE: f64 = 0.15;
/// Three standard deviations of that ratio, times √n (by simulation).
const SCATTER: f64 = 13.5;
/// The same ratio of noise with whatever memory of the first order is at most 2, and of what is smooth at least 4.
pub(super) const MOST_RATIO: f64 = 2.8;
/// V is as the formula says within this part of it and [`LAG_SCATTER`] · √(h / n).
const MISFIT: f64 = 0.3;
/// Three times the longest lag is at most this part of the time between two reversals of the motion: dry friction jumps there.
const OF_TURN: f64 = 0.5;
/// Where all lags are as the formula says and the last one shows this part of the variance, the formula tells the rest.
const SHOWN: f64 = 0.6;
/// Three standard deviations of V, times √(n / h) (by simulation).
pub(super) const LAG_SCATTER: f64 = 3.9;

/// Standard deviation of a residual's noise if that is correlated in time, and more than white noise would be; `None` where it is
/// white as far as one can see, or where what the residual does over a few samples is not noise of the first order.
///
/// `turn`: samples between two reversals of the motion. `residual`: measured less modelled, evenly sampled. What follows the motion may be in it, as long as over some ten samples it is
/// less than the noise; else the answer is the part that was told from it, too small rather than too large.
pub(crate) fn coloured_noise(residual: &[f64], turn: impl FnOnce() -> f64) -> Option<f64> {
    let n = residual.len() as f64;
    let scatter = SCATTER / n.max(1.0).sqrt();
    let first = seen(residual, 1);
    let ratio = seen(residual, 2) / first.max(f64::MIN_POSITIVE);
    if !(1.0 + WHITE.max(scatter)..MOST_RATIO).contains(&ratio) {
        return None;
    }
    let longest = longest_lag(turn());
    let tells = |lag: &usize| lag * SAMPLES_PER_LAG <= residual.len() && *lag as f64 <= longest;
    let lags: Vec<usize> = LAGS.into_iter().filter(tells).collect();
    let points: Vec<Point> = lags
        .into_iter()
        .map(|lag| Point { lag, variance: seen(residual, lag), scatter: (lag as f64 / n).sqrt() })
        .collect();
    let told = (FEWEST..=points.len()).rev().find_map(|count| Memory::shown(&points, count));
    told.map(|variance| variance.max(first).sqrt())
}

/// Longest lag, samples, over which what follows a motion with this time between two reversals is hardly seen.
pub(super) fn longest_lag(turn: f64) -> f64 {
    OF_TURN / 3.0 * turn
}

/// Variance that third differences over a lag see, by their median.
pub(super) fn seen(signal: &[f64], lag: usize) -> f64 {
    let mut differences = Vec::with_capacity(signal.len());
    for phase in 0..lag.min(signal.len()) {
        let every: Vec<f64> = signal[phase..].iter().step_by(lag).copied().collect();
        differences.extend(every.windows(4).map(super::noise::third_difference));
    }
    // What is left by a model is continuous, however coarse the measurement is.
    of_continuous(differences).powi(2)
}

/// What third differences see over a lag.
struct Point {
    lag: usize,
    variance: f64,
    /// √(lag / samples).
    scatter: f64,
}

/// White noise and noise of the first order.
struct Memory {
    white: f64,
    coloured: f64,
    /// Correlation of neighbours.
    rho: f64,
}

impl Memory {
    /// The variance by the formula that fits the first `count` points, if one does: what the last of them shows, and all of it where no
    /// point is left and most of it is shown.
    fn shown(all: &[Point], count: usize) -> Option<f64> {
        let points = &all[..count];
        let tried = (1..99).map(|percent| Self::fitted(points, 0.01 * f64::from(percent)));
        let (_, best) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let fits = |point: &Point| {
            let off = point.variance / best.at(point.lag) - 1.0;
            off.abs() < MISFIT + LAG_SCATTER * point.scatter
        };
        let (whole, shown) = (best.white + best.coloured, best.at(points.last()?.lag));
        let variance = if count == all.len() && shown >= SHOWN * whole { whole } else { shown };
        (best.coloured > 0.0 && points.iter().all(fits)).then_some(variance)
    }

    /// Least squares of relative errors for a given ρ, neither part below nothing; and their sum.
    fn fitted(points: &[Point], rho: f64) -> (f64, Self) {
        let weight = |p: &Point| 1.0 / (p.variance.powi(2) * (3e-3 + 1.7 * p.scatter.powi(2)));
        let (mut ww, mut wg, mut gg, mut yw, mut yg) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for point in points {
            let (w, g) = (weight(point), forgotten(rho, point.lag));
            ww += w;
            wg += w * g;
            gg += w * g * g;
            yw += w * point.variance;
            yg += w * g * point.variance;
        }
        let determinant = ww * gg - wg * wg;
        let both = [(gg * yw - wg * yg) / determinant, (ww * yg - wg * yw) / determinant];
        let inside = both.iter().all(|x| *x >= 0.0 && x.is_finite());
        let [white, coloured] = if inside { both } else { [0.0, yg / gg] };
        let memory = Self { white, coloured, rho };
        let error = points.iter().map(|p| weight(p) * (p.variance - memory.at(p.lag)).powi(2)).sum();
        (error, memory)
    }

    /// V(lag) / 20.
    fn at(&self, lag: usize) -> f64 {
        self.white + self.coloured * forgotten(self.rho, lag)
    }
}

/// The part of a first-order noise's variance that third differences over a lag see.
fn forgotten(rho: f64, lag: usize) -> f64 {
    let r = rho.powi(lag as i32);
    1.0 - r * (1.5 - r * (0.6 - 0.1 * r))
}

/// A joint that is faster than that moves, rad/s or m/s, root mean square.
const MOVES: f64 = 0.02;
/// A joint whose speed is this part of the fastest one's (root mean squares) rests: encoders' noise and rounding turn back all the time.
const AT_REST: f64 = 1e-3;

/// The velocity with which a row's residual may go: the joint's own, or, where that rests, of those joints that move that one which turns back most
/// often.
pub(crate) fn telling_velocity(own: usize, joints: usize, velocity: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    let size =
        |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let of_own = velocity(own);
    if size(&of_own) > MOVES {
        return of_own;
    }
    let all: Vec<Vec<f64>> = (0..joints).map(velocity).collect();
    let least = AT_REST * all.iter().map(|values| size(values)).fold(0.0, f64::max);
    if size(&of_own) > least {
        return of_own;
    }
    let moving = all.into_iter().filter(|values| size(values) > least);
    moving.min_by(|a, b| between_reversals(a).total_cmp(&between_reversals(b))).unwrap_or(of_own)
}

/// Samples from one reversal, start or stop of a motion to the next one, on average over those in which it moves.
///
/// Where a joint rests its speed behind a filter rings about nothing: that is no motion.
pub(crate) fn between_reversals(velocity: &[f64]) -> f64 {
    /// Parts of the root mean square speed at which a joint begins to move, and at which it rests again.
    const BEGINS: f64 = 0.1;
    const RESTS: f64 = 0.03;
    let n = velocity.len();
    let usual = (velocity.iter().map(|v| v * v).sum::<f64>() / n.max(1) as f64).sqrt();
    let (mut moving, mut moves, mut direction) = (0usize, 0usize, 0.0);
    for v in velocity {
        if v * direction < RESTS * usual {
            direction = 0.0;
        }
        if direction == 0.0 && v.abs() > BEGINS * usual {
            (direction, moves) = (v.signum(), moves + 1);
        }
        moving += usize::from(direction != 0.0);
    }
    if moves == 0 { n as f64 } else { moving as f64 / moves as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::random::Random;

    /// As of a motion with 0.8 reversals a second, sampled at 250 Hz.
    fn told(residual: &[f64]) -> Option<f64> {
        coloured_noise(residual, || 312.0)
    }

    /// First-order noise of variance 1.
    fn noise(count: usize, rho: f64, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        let mut last = random.normal();
        let next = |_| {
            last = rho * last + (1.0 - rho * rho).sqrt() * random.normal();
            last
        };
        (0..count).map(next).collect()
    }

    fn with(noise: &[f64], size: f64, left: impl Fn(f64) -> f64) -> Vec<f64> {
        noise.iter().enumerate().map(|(i, x)| size * x + left(i as f64)).collect()
    }

    #[test]
    fn noise_that_remembers_has_the_size_it_has() {
        for (k, rho) in [0.3, 0.4, 0.6, 0.75, 0.9].into_iter().enumerate() {
            for seed in 0..6 {
                let found = told(&with(&noise(5000, rho, 10 * k as u64 + seed), 0.03, |_| 0.0));
                let off = found.unwrap_or(0.0) / 0.03 - 1.0;
                assert!(off.abs() < 0.15, "{rho}, {seed}: {off}");
            }
        }
    }

    /// Rounding of an angle that is not nothing turns back at every sample: noise that remembers was told as half of what it is, on eight faultless joints.
    #[test]
    fn a_joint_that_rests_turns_back_with_those_that_move() {
        let mut random = Random::new(5);
        let rounding: Vec<f64> = (0..5000).map(|_| 1e-15 * random.normal()).collect();
        let swinging = |rate: f64| (0..5000).map(|i| (rate * f64::from(i)).sin()).collect::<Vec<f64>>();
        let all = [rounding.clone(), swinging(0.005), swinging(0.02), vec![0.01; 5000]];
        let of = |own: usize| telling_velocity(own, all.len(), |joint| all[joint].clone());
        assert!(of(0) == all[2] && of(1) == all[1] && of(3) == all[3]);
        assert!(telling_velocity(0, 1, |_| rounding.clone()) == rounding);
        for seed in 0..6 {
            let residual = noise(5000, 0.73, seed);
            let told = |velocity: &[f64]| coloured_noise(&residual, || between_reversals(velocity));
            assert!(told(&rounding).is_none() && (told(&of(0)).unwrap() - 1.0).abs() < 0.15, "{seed}");
        }
    }

    #[test]
    fn beside_white_noise_it_is_still_seen() {
        for seed in 0..6 {
            let mut white = Random::new(100 + seed);
            let both = with(&noise(6000, 0.85, seed), 1.0, |_| 0.0);
            let both: Vec<f64> = both.iter().map(|x| x + 0.4 * white.normal()).collect();
            let off = told(&both).unwrap_or(0.0) / 1.16_f64.sqrt() - 1.0;
            assert!(off.abs() < 0.15, "{seed}: {off}");
        }
    }

    #[test]
    fn white_noise_is_white_whatever_the_motion_leaves() {
        let hz = |f: f64, i: f64| (std::f64::consts::TAU * f * i / 250.0).sin();
        let ripple = |i: f64| 3.0 * (14.0 * hz(0.6, i)).sin();
        let dry = |i: f64| 3.0 * (hz(0.7, i) + 0.4 * hz(1.3, i)).signum();
        let spring = |i: f64| 4.0 * hz(0.5, i) + hz(4.0, i);
        for seed in 0..8 {
            let white = noise(5000, 0.0, seed);
            assert_eq!(told(&with(&white, 1.0, |_| 0.0)), None);
            assert_eq!(told(&with(&white, 1.0, ripple)), None);
            assert_eq!(told(&with(&white, 1.0, dry)), None);
            assert_eq!(told(&with(&white, 1.0, spring)), None);
            // A motion without noise has none.
            assert_eq!(told(&with(&white, 1e-9, spring)), None);
        }
    }

    #[test]
    fn what_the_motion_leaves_is_not_taken_for_noise() {
        let hz = |f: f64, i: f64| (std::f64::consts::TAU * f * i / 250.0).sin();
        let ripple = |i: f64| 3.0 * (14.0 * hz(0.6, i)).sin();
        let dry = |i: f64| 3.0 * (hz(0.7, i) + 0.4 * hz(1.3, i)).signum();
        for seed in 0..8 {
            let coloured = noise(5000, 0.6, seed);
            for (what, left) in [("ripple", with(&coloured, 1.0, ripple)), ("dry", with(&coloured, 1.0, dry))]
            {
                let found = told(&left).unwrap_or(1.0);
                assert!((0.7..1.5).contains(&found), "{what}, {seed}: {found}");
            }
        }
    }

    /// Counted by signs the rests alone had a reversal every eighth of a second, and noise that remembers was taken for what the model lacks.
    #[test]
    fn a_joint_at_rest_does_not_reverse() {
        let speed = |i: usize| {
            let time = i as f64 / 250.0;
            let (turn, within) = ((time / 1.9) as usize, time % 1.9);
            let direction = if turn % 2 == 0 { 1.0 } else { -1.0 };
            let ringing = 1e-3 * (std::f64::consts::TAU * 8.0 * time).sin();
            if within < 1.1 {
                direction * (std::f64::consts::PI * within / 1.1).sin().powi(2)
            } else {
                ringing
            }
        };
        let velocity: Vec<f64> = (0..6000).map(speed).collect();
        let turn = between_reversals(&velocity);
        assert!((200.0..280.0).contains(&turn), "{turn} samples");
        let swings: Vec<f64> = (0..6000).map(|i| (0.02 * i as f64).cos()).collect();
        let turn = between_reversals(&swings);
        assert!((140.0..160.0).contains(&turn), "{turn} samples");
        assert_eq!(between_reversals(&[0.0; 50]), 50.0);
    }

    #[test]
    fn too_little_says_nothing() {
        assert_eq!(told(&[]), None);
        assert_eq!(told(&noise(200, 0.9, 1)), None);
        assert_eq!(told(&[0.0; 5000]), None);
    }
}
