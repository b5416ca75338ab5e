//! The noise that a model leaves: white, remembering, behind a low-pass, and larger at some times than at others.
use super::coloured::{
    LAG_SCATTER, MOST_RATIO, SAMPLES_PER_LAG, between_reversals, coloured_noise, longest_lag, seen,
};
use super::flat_noise::flat_noise;
use super::noise::{third_difference, white_noise};
use super::strays::Strays;
use std::cell::LazyCell;

/// Lags at which differences are looked at, samples.
const LAGS: [usize; 14] = [1, 2, 3, 4, 6, 8, 12, 16, 20, 24, 32, 40, 48, 64];
/// From a lag to one that is so many times as long third differences have to see the same, at least at so many lags.
const SPAN: f64 = 3.0;
const FEWEST: usize = 4;
/// What they see is the same within this part of it and [`LAG_SCATTER`] · √(lag / n).
const ALIKE: f64 = 0.25;
/// At the last of these lags at most so many times what they see at the first: jumps are seen more and more.
const SETTLED: f64 = 1.3;
/// The variance of noise that remembers is so many times what neighbours show.
const MORE: f64 = 1.3;

/// Samples of a window in which noise is of one size.
const WINDOW: usize = 64;
/// So many third differences of a window do not count, the largest: one jump or one stray sample makes them.
const STRAY: usize = 4;
/// What the others make of the squares of white noise (by simulation).
const OF_OTHERS: f64 = 0.6874;
/// Six standard deviations of the root mean square over windows of white noise, times √n (by simulation).
const SCATTER: f64 = 6.0;
/// A window that is so many times as noisy as is usual of the quieter ones is loud.
const LOUD: f64 = 1.5;
/// Noise that is only louder has the same colour within this part, and what chance does.
const SAME_COLOUR: f64 = 0.2;

/// Standard deviation of a residual's noise where that is more than white noise of one size shows; `None` where it is not, as far as one
/// can see.
///
/// `residual`: measured less modelled, evenly sampled, N m or N, as the answer; `velocity`: of the joint, one per sample, rad/s or m/s. What follows the motion may be in the residual, as long as
/// over a twelfth of the motion's period it does next to nothing. `measured`: root mean square of the measured signal. Its noise is a part of
/// it: a residual that is larger is the model's, however little it follows the motion.
pub(crate) fn residual_noise(
    residual: &[f64],
    velocity: impl FnOnce() -> Vec<f64>,
    measured: f64,
) -> Option<f64> {
    of_any_size(residual, &LazyCell::new(velocity)).map(|noise| noise.min(measured))
}

fn of_any_size<F: FnOnce() -> Vec<f64>>(residual: &[f64], velocity: &LazyCell<Vec<f64>, F>) -> Option<f64> {
    let Some(Strays { rest, rms }) = Strays::of(residual, &|| (**velocity).clone()) else {
        return without_strays(residual, velocity);
    };
    Some(without_strays(&rest, velocity).unwrap_or_else(|| white_noise(&rest)).hypot(rms))
}

/// The same of a residual of which no reading strays alone.
fn without_strays<F: FnOnce() -> Vec<f64>>(
    residual: &[f64],
    velocity: &LazyCell<Vec<f64>, F>,
) -> Option<f64> {
    let turn = || between_reversals(velocity);
    let remembering = |residual: &[f64]| {
        let variance = residual.iter().map(|x| x * x).sum::<f64>() / residual.len().max(1) as f64;
        // Nothing is left but what neighbours show.
        if variance < MORE * seen(residual, 1) {
            return None;
        }
        coloured_noise(residual, turn)
            .or_else(|| low_passed(residual, turn()))
            .or_else(|| flat_noise(residual, velocity))
    };
    let Some(Unsteady { levels, mean }) = Unsteady::seen(residual) else { return remembering(residual) };
    let steady: Vec<f64> = residual.iter().enumerate().map(|(i, x)| x / level(&levels, i)).collect();
    Some(remembering(&steady).map_or(mean, |times| times * mean))
}

/// Standard deviation of noise behind a low-pass of whatever order: third differences see all of it once it has forgotten, over one lag as
/// over another. What follows the motion grows with the lag, or, where it is faster than the motion itself, goes up and down.
fn low_passed(residual: &[f64], turn: f64) -> Option<f64> {
    let n = residual.len() as f64;
    let first = seen(residual, 1);
    let longest = longest_lag(turn);
    let tells = |lag: &usize| lag * SAMPLES_PER_LAG <= residual.len() && *lag as f64 <= longest;
    let points: Vec<(f64, f64)> =
        LAGS.into_iter().filter(tells).map(|lag| (lag as f64, seen(residual, lag))).collect();
    let level = |end: usize| {
        let run = &points[points.partition_point(|(lag, _)| SPAN * lag < points[end].0)..=end];
        let mut sizes: Vec<f64> = run.iter().map(|(_, variance)| *variance).collect();
        sizes.sort_by(f64::total_cmp);
        let middle = sizes[sizes.len() / 2];
        let is_level = |(lag, variance): &(f64, f64)| {
            (variance / middle - 1.0).abs() < ALIKE + LAG_SCATTER * (lag / n).sqrt()
        };
        let settled = run[run.len() - 1].1 < SETTLED * run[0].1;
        let holds =
            run.len() >= FEWEST && settled && middle > MORE * MORE * first && run.iter().all(is_level);
        holds.then_some(middle.sqrt())
    };
    (0..points.len()).rev().find_map(level)
}

/// Noise that is larger at some times than at others.
struct Unsteady {
    /// Standard deviations of white noise in windows of [`WINDOW`] samples.
    levels: Vec<f64>,
    /// Their root mean square.
    mean: f64,
}

impl Unsteady {
    /// `None` where noise is of one size, or where louder windows are of another colour: what rattles or strikes there is no noise.
    fn seen(residual: &[f64]) -> Option<Self> {
        let quiet = white_noise(residual);
        let levels: Vec<f64> = residual.chunks_exact(WINDOW).map(|window| of_window(window, 1)).collect();
        let squares: f64 = levels.iter().map(|level| level * level).sum();
        let mean = (squares / levels.len().max(1) as f64).sqrt();
        let more = mean / quiet.max(f64::MIN_POSITIVE);
        if !more.is_finite() || more < 1.0 + SCATTER / (residual.len() as f64).sqrt() {
            return None;
        }
        let over_two: Vec<f64> = residual.chunks_exact(WINDOW).map(|window| of_window(window, 2)).collect();
        let usual = quiet * seen(residual, 2).sqrt();
        let colour = |loud: bool| {
            // By both, or those that happen to be loud over one of them would be of another colour.
            let of_kind =
                levels.iter().zip(&over_two).filter(|(one, two)| (*one * *two > LOUD * LOUD * usual) == loud);
            Colour::of(of_kind.map(|(one, two)| 2.0 * (two / one.max(f64::MIN_POSITIVE)).ln()).collect())
        };
        let (loud, elsewhere) = (colour(true), colour(false));
        // What is smooth would be larger at times, too.
        let is_noise = loud.mean.max(elsewhere.mean) < MOST_RATIO.ln() && loud.is_that_of(&elsewhere);
        is_noise.then_some(Self { levels, mean })
    }
}

/// Standard deviation of white noise on a smooth signal, from a window's third differences over a lag.
fn of_window(window: &[f64], lag: usize) -> f64 {
    let differences = (3 * lag..window.len())
        .map(|i| third_difference(&[window[i - 3 * lag], window[i - 2 * lag], window[i - lag], window[i]]));
    let mut squares: Vec<f64> = differences.map(|x| x * x / 20.0).collect();
    let count = squares.len();
    squares.sort_unstable_by(f64::total_cmp);
    (squares[..count - STRAY].iter().sum::<f64>() / count as f64 / OF_OTHERS).sqrt()
}

/// How much more differences over two samples see than those over one, as a logarithm of variances: over several windows.
struct Colour {
    mean: f64,
    /// Variance of the mean.
    variance: f64,
}

impl Colour {
    fn of(windows: Vec<f64>) -> Self {
        let count = windows.len() as f64;
        let mean = windows.iter().sum::<f64>() / count.max(1.0);
        let squares: f64 = windows.iter().map(|x| (x - mean).powi(2)).sum();
        Self { mean, variance: squares / (count * (count - 1.0)).max(1.0) }
    }

    fn is_that_of(&self, other: &Self) -> bool {
        let chance = 3.0 * (self.variance + other.variance).sqrt();
        (self.mean - other.mean).abs() < SAME_COLOUR + chance
    }
}

/// The level at a sample: between the middles of windows on straight lines.
fn level(levels: &[f64], sample: usize) -> f64 {
    let at = ((sample as f64 + 0.5) / WINDOW as f64 - 0.5).clamp(0.0, (levels.len() - 1) as f64);
    let (before, after) = (levels[at as usize], levels[(at as usize + 1).min(levels.len() - 1)]);
    let level = before + (at - at.floor()) * (after - before);
    level.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::random::Random;
    use std::f64::consts::TAU;

    const RATE: f64 = 250.0;

    type OfSample = fn(usize) -> f64;
    /// Of angle and velocity.
    type OfMotion = fn(f64, f64) -> f64;

    /// As of a joint that swings 0.6 times a second.
    fn told(residual: &[f64]) -> Option<f64> {
        let velocity = || (0..residual.len()).map(|i| (TAU * 0.6 * i as f64 / RATE).cos()).collect();
        residual_noise(residual, velocity, f64::INFINITY)
    }

    fn hz(f: f64, i: usize) -> f64 {
        (TAU * f * i as f64 / RATE).sin()
    }

    fn rms(values: &[f64]) -> f64 {
        (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
    }

    /// White noise behind so many low-passes of the first order in a row, of standard deviation 1.
    fn behind(low_passes: usize, cutoff: f64, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        let kept = (-TAU * cutoff / RATE).exp();
        let mut states = vec![0.0; low_passes];
        let mut next = || {
            let white = random.normal();
            states.iter_mut().fold(white, |input, state| {
                *state = kept * *state + (1.0 - kept) * input;
                *state
            })
        };
        (0..500).for_each(|_| {
            next();
        });
        let noise: Vec<f64> = (0..6000).map(|_| next()).collect();
        let size = rms(&noise);
        noise.iter().map(|x| x / size).collect()
    }

    fn beside_white(noise: &[f64]) -> Vec<f64> {
        let mut random = Random::new(99);
        noise.iter().map(|x| x + 0.33 * random.normal()).collect()
    }

    #[test]
    fn noise_behind_low_passes_has_the_size_it_has() {
        for (low_passes, cutoff) in [(2, 20.0), (2, 40.0), (3, 20.0), (3, 40.0), (4, 40.0)] {
            for seed in 0..6 {
                let noise = behind(low_passes, cutoff, 10 * seed + low_passes as u64);
                for both in [noise.clone(), beside_white(&noise)] {
                    let found = told(&both).unwrap_or(0.0) / rms(&both);
                    assert!((found - 1.0).abs() < 0.2, "{low_passes} at {cutoff} Hz, {seed}: {found}");
                }
            }
        }
    }

    /// Angles in degrees, read as radians, leave what looks like noise and is thirty times what was measured.
    #[test]
    fn noise_is_no_larger_than_what_was_measured() {
        let left = behind(2, 20.0, 1);
        let velocity: Vec<f64> = (0..left.len()).map(lively).collect();
        let told = |measured: f64| residual_noise(&left, || velocity.clone(), measured).unwrap();
        assert!((told(2.0) - 1.0).abs() < 0.2 && told(0.03) == 0.03);
    }

    #[test]
    fn noise_that_grows_has_the_size_it_has() {
        let sizes: [(&str, OfSample); 3] = [
            ("with the load", |i| 0.2 + hz(0.6, i).abs()),
            ("in the second half", |i| if i < 3000 { 0.1 } else { 1.0 }),
            ("with the speed", |i| 0.05 + hz(0.4, i).powi(2)),
        ];
        for (what, size) in sizes {
            for seed in 0..6 {
                let grown = |noise: Vec<f64>| -> Vec<f64> {
                    noise.iter().enumerate().map(|(i, x)| x * size(i)).collect()
                };
                let white = grown(behind(0, 1.0, seed));
                let off = told(&white).unwrap_or(0.0) / rms(&white);
                assert!((off - 1.0).abs() < 0.2, "{what}, {seed}: {off}");
                let remembering = grown(behind(1, 40.0, seed));
                let off = told(&remembering).unwrap_or(0.0) / rms(&remembering);
                assert!((off - 1.0).abs() < 0.35, "{what}, remembering, {seed}: {off}");
            }
        }
    }

    /// A motion of 1.5 reversals a second, not the same ever again.
    fn lively(i: usize) -> f64 {
        [(0.43, 0.3), (0.71, 1.9), (1.13, 4.0), (1.57, 2.2)]
            .iter()
            .map(|(f, p)| (TAU * f * i as f64 / RATE + p).cos())
            .sum()
    }

    #[test]
    fn noise_that_is_hardly_faster_than_the_motion_has_the_size_it_has() {
        for (low_passes, cutoff) in [(2, 12.0), (3, 20.0), (4, 20.0)] {
            for seed in 0..6 {
                let noise = behind(low_passes, cutoff, 10 * seed + low_passes as u64);
                for both in [noise.clone(), beside_white(&noise)] {
                    let told = residual_noise(&both, || (0..6000).map(lively).collect(), rms(&both));
                    let found = told.unwrap_or(0.0) / rms(&both);
                    assert!((found - 1.0).abs() < 0.2, "{low_passes} at {cutoff} Hz, {seed}: {found}");
                }
            }
        }
    }

    #[test]
    fn what_a_lively_motion_leaves_is_no_noise() {
        let velocity: Vec<f64> = (0..6000).map(lively).collect();
        let position: Vec<f64> = velocity
            .iter()
            .scan(0.0, |q, v| {
                *q += v / RATE;
                Some(*q)
            })
            .collect();
        let left: [(&str, OfMotion); 5] = [
            ("ripple", |q, _| (30.0 * q).sin()),
            ("fast ripple", |q, _| (90.0 * q).sin()),
            ("dry friction", |_, v| v.signum()),
            ("drag", |_, v| v * v.abs()),
            ("a hardening spring", |q, _| 8.0 * q * q * q),
        ];
        // What a rotor takes, as large as noise that is hardly faster than the motion.
        for seed in 0..6 {
            let noise = behind(3, 20.0, seed);
            let change = |i: usize| 25.0 * (velocity[(i + 1).min(5999)] - velocity[i]);
            let both: Vec<f64> = noise.iter().enumerate().map(|(i, x)| x + change(i)).collect();
            let found = residual_noise(&both, || velocity.clone(), rms(&both)).unwrap_or(0.1);
            assert!(found < 1.25 && rms(&both) > 1.3, "a rotor, {seed}: {found} of {}", rms(&both));
        }
        for (what, left) in left {
            for seed in 0..6 {
                let noise = behind(0, 1.0, seed);
                let both = noise
                    .iter()
                    .zip(position.iter().zip(&velocity))
                    .map(|(x, (q, v))| 0.1 * x + left(*q, *v));
                let both: Vec<f64> = both.collect();
                let found = residual_noise(&both, || velocity.clone(), rms(&both)).unwrap_or(0.1);
                assert!(found < 0.13, "{what}, {seed}: {found}");
            }
        }
    }

    #[test]
    fn what_the_motion_leaves_is_no_noise() {
        let left: [(&str, OfSample); 7] = [
            ("nothing", |_| 0.0),
            ("ripple", |i| 3.0 * (14.0 * hz(0.6, i)).sin()),
            ("fast ripple", |i| 3.0 * (30.0 * hz(0.6, i)).sin()),
            ("dry friction", |i| 3.0 * (TAU * 0.6 * i as f64 / RATE).cos().signum()),
            ("dry friction of another joint", |i| 3.0 * (hz(0.7, i) + 0.4 * hz(1.3, i)).signum()),
            ("a spring", |i| 4.0 * hz(0.5, i) + hz(4.0, i)),
            ("several", |i| [0.5, 1.3, 2.9, 4.7, 7.1].iter().map(|f| hz(*f, i) / f).sum()),
        ];
        for (what, left) in left {
            for seed in 0..8 {
                for size in [1.0, 0.1, 1e-9] {
                    let noise = behind(0, 1.0, seed);
                    let both: Vec<f64> = noise.iter().enumerate().map(|(i, x)| size * x + left(i)).collect();
                    assert_eq!(told(&both), None, "{what}, noise of {size}, {seed}");
                }
            }
        }
    }
}
