//! Noise that neighbouring samples hardly show: behind a low-pass it is louder where rows are judged than their differences say.
use crate::signal::Butterworth;

/// Edges of two bands above the cut-off of the rows' filter, as parts of it: a motion that rows show leaves next to nothing there.
const EDGES: [f64; 3] = [1.5, 2.4, 3.8];
/// The highest frequency of a band, as part of the sampling rate.
const HIGHEST: f64 = 0.45;
/// Noise that remembers is at least so many times as large in the lower band as third differences say of white noise,
const MORE: f64 = 1.12;
/// and its power there is at most so many times that in the upper one: noise of the first order falls by 2.5, motions and jolts by much more.
const STEEPEST: f64 = 3.0;
/// The fewest independent values of a band.
const FEWEST: f64 = 40.0;
/// Three standard deviations of a variance that is told by a median, times the root of the number of independent values.
const SCATTER: f64 = 5.0;
/// Noise of one size is as large by its larger values as by its smaller ones, within this factor.
const UNEVEN: f64 = 1.3;
/// Frequencies at which a spectrum is averaged.
const FREQUENCIES: usize = 100;

/// Standard deviation of the white noise that would leave as much behind a filter at `cutoff_hz` as the noise of this signal does, where
/// that is more than `white`, which third differences show; as the signal, whose samples are `step` s apart.
///
/// The power in two bands just above the cut-off gives a spectrum of the first order, and that tells what lies below.
pub(crate) fn slow_noise(signal: &[f64], step: f64, cutoff_hz: f64, white: f64) -> Option<f64> {
    let [low, middle, high] = EDGES.map(|part| part * cutoff_hz);
    let independent = 2.0 * (middle - low) * step * signal.len() as f64;
    if high * step > HIGHEST || independent < FEWEST {
        return None;
    }
    let behind = |cutoff: f64| Some(Butterworth::new(cutoff, 1.0 / step).ok()?.zero_phase(signal));
    let [below, within, above] = [behind(low)?, behind(middle)?, behind(high)?];
    let near =
        density(&below, &within)? / mean(|f| (gain(f, middle, step) - gain(f, low, step)).powi(2), step);
    let far =
        density(&within, &above)? / mean(|f| (gain(f, high, step) - gain(f, middle, step)).powi(2), step);
    let chance = 1.0 + SCATTER / independent.sqrt();
    let is_noise = near > white * white * chance.max(MORE * MORE) && near < STEEPEST * chance * far;
    is_noise.then(|| {
        let spectrum = FirstOrder::through([((low * middle).sqrt(), near), ((middle * high).sqrt(), far)]);
        let passed = |f: f64| gain(f, cutoff_hz, step).powi(4);
        (mean(|f| passed(f) * spectrum.at(f), step) / mean(passed, step)).sqrt()
    })
}

/// What a zero-phase filter of this cut-off leaves of a frequency.
fn gain(frequency: f64, cutoff: f64, step: f64) -> f64 {
    let warped = |f: f64| (std::f64::consts::PI * f * step).tan();
    1.0 / (1.0 + (warped(frequency) / warped(cutoff)).powi(8))
}

/// Mean over all frequencies of a sampled signal.
fn mean(of_frequency: impl Fn(f64) -> f64, step: f64) -> f64 {
    let at = |k: usize| 0.5 / step * (k as f64 + 0.5) / FREQUENCIES as f64;
    (0..FREQUENCIES).map(|k| of_frequency(at(k))).sum::<f64>() / FREQUENCIES as f64
}

/// Variance of what one filter lets pass and the other one does not, by the median; `None` where it is no noise of one size: jumps and strokes ring there.
fn density(below: &[f64], above: &[f64]) -> Option<f64> {
    let mut sizes: Vec<f64> = below.iter().zip(above).map(|(below, above)| (above - below).abs()).collect();
    let mut deviation = |part: f64, of_normal: f64| {
        let index = (part * sizes.len() as f64) as usize;
        *sizes.select_nth_unstable_by(index, f64::total_cmp).1 / of_normal
    };
    let [quiet, usual, loud] = [deviation(0.25, 0.3186), deviation(0.5, 0.6745), deviation(0.9, 1.6449)];
    (loud < UNEVEN * quiet).then_some(usual * usual)
}

/// `level / (1 + fall · f²)`.
struct FirstOrder {
    level: f64,
    fall: f64,
}

impl FirstOrder {
    /// Through two points, the lower frequency first; it falls by no more than a first order does, and does not rise.
    fn through([(low, near), (high, far)]: [(f64, f64); 2]) -> Self {
        /// Below this part of the lower frequency the spectrum is flat: nothing that was looked at tells how it goes on.
        const FLAT: f64 = 0.3;
        let fall = (near - far) / (far * high * high - near * low * low);
        let steepest = 1.0 / (FLAT * low).powi(2);
        let fall = if near <= far {
            0.0
        } else if fall > 0.0 {
            fall.min(steepest)
        } else {
            steepest
        };
        Self { level: near * (1.0 + fall * low * low), fall }
    }

    fn at(&self, frequency: f64) -> f64 {
        self.level / (1.0 + self.fall * frequency * frequency)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::noise::white_noise;
    use bipedc_effects::random::Random;
    use std::f64::consts::TAU;

    const STEP: f64 = 4e-3;

    /// First-order noise of variance 1.
    fn noise(rho: f64, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        let mut last = random.normal();
        let next = |_| {
            last = rho * last + (1.0 - rho * rho).sqrt() * random.normal();
            last
        };
        (0..5000).map(next).collect()
    }

    fn motion(i: usize) -> f64 {
        let t = STEP * i as f64;
        40.0 * (TAU * 0.7 * t).sin() + 5.0 * (TAU * 2.9 * t).cos()
    }

    /// Dry friction on it.
    fn jumps(i: usize) -> f64 {
        2.0 * (TAU * 0.7 * STEP * i as f64).cos().signum()
    }

    fn rms(values: &[f64]) -> f64 {
        (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
    }

    /// By how much what is told is off what filters really leave of the noise, on a motion; as a logarithm, on average.
    fn off(rho: f64) -> f64 {
        let of_seed = |seed: u64| {
            let noise: Vec<f64> = noise(rho, seed).iter().map(|x| 0.1 * x).collect();
            let both: Vec<f64> = noise.iter().enumerate().map(|(i, x)| x + motion(i)).collect();
            let filter = Butterworth::new(10.0, 1.0 / STEP).unwrap();
            let passed = rms(&filter.zero_phase(&filter.zero_phase(&noise)));
            let told = slow_noise(&both, STEP, 10.0, white_noise(&both)).unwrap();
            let whole = mean(|f| gain(f, 10.0, STEP).powi(4), STEP);
            (told * whole.sqrt() / passed).ln()
        };
        (0..12).map(of_seed).sum::<f64>() / 12.0
    }

    #[test]
    fn behind_the_filter_noise_is_as_large_as_told() {
        for rho in [0.4, 0.6, 0.8] {
            let off = off(rho);
            assert!(off.abs() < 0.15, "{rho}: {off}");
        }
        // It has not forgotten at the cut-off, and nothing above it tells how it goes on: white noise would be told as a quarter.
        assert!((-0.4..0.0).contains(&off(0.9)));
    }

    #[test]
    fn white_noise_is_left_alone_whatever_the_motion() {
        for seed in 0..20 {
            let both: Vec<f64> =
                noise(0.0, seed).iter().enumerate().map(|(i, x)| 0.1 * x + motion(i)).collect();
            assert_eq!(slow_noise(&both, STEP, 10.0, white_noise(&both)), None);
            let rubbing: Vec<f64> = both.iter().enumerate().map(|(i, x)| x + jumps(i)).collect();
            assert_eq!(slow_noise(&rubbing, STEP, 10.0, white_noise(&both)), None);
        }
    }

    #[test]
    fn a_motion_without_noise_has_none() {
        let smooth =
            |i: usize| (TAU * 0.7 * STEP * i as f64).sin() + 0.3 * (TAU * 8.0 * STEP * i as f64).cos();
        let signal: Vec<f64> = (0..5000).map(smooth).collect();
        assert_eq!(slow_noise(&signal, STEP, 10.0, white_noise(&signal)), None);
        assert_eq!(slow_noise(&[], STEP, 10.0, 0.0), None);
        assert_eq!(slow_noise(&[0.0; 5000], STEP, 10.0, 0.0), None);
    }
}
