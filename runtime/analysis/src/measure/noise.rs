//! How noisy a measured signal is.
use bipedc_effects::random::Random;

/// Most differences of a signal from which its noise is judged; of longer signals, windows evenly spread.
const MOST: usize = crate::measure::HELD;
/// Differences of a window in which noise is judged.
const WINDOW: usize = 64;

/// Third differences of noise that is more than rounding are more than this many times what rounding makes.
const MORE: f64 = 1.5;

/// Changes of an encoder that are this many times as large as others are no single steps.
const ALIKE: f64 = 2.5;

/// Changes that are this part of usual large ones are made by the decimals of a log.
const DECIMALS: f64 = 1e-3;

/// The windows that count: up to this quantile of their medians.
const QUIETER: f64 = 0.3;
/// What that quantile is of white noise, as a part of the median of all differences (by simulation, to 0.2 % from a thousand samples).
const OF_QUIETER: f64 = 0.8895;
/// Three standard deviations of the ratio between what all differences and what the quieter windows tell of white noise, times √n (by simulation).
const UNALIKE: f64 = 4.5;

/// Standard deviation of white noise on a smooth signal, from its third differences.
///
/// Third differences of white noise have 20 times its variance and those of a motion below a tenth of the sampling
/// rate next to nothing. Medians forgive jumps, such as those of friction; of all windows the quieter ones count, so
/// that rattling or a controller at its limit does not pass for noise.
pub(crate) fn white_noise(signal: &[f64]) -> f64 {
    of_differences(signal.windows(4).map(third_difference).collect())
}

/// Standard deviation of the noise of an encoder's angle, or of the difference of two: white, or from rounding to steps.
///
/// Between two steps a slow joint's encoder says the same again and again: third differences see nothing. Of a fast joint they are whole
/// steps, and so is their median, up to a quarter too large. Where less than rounding's own noise is seen besides, an angle is uniformly
/// rounded: to steps s, which makes s/√12, two make s/√6.
pub(crate) fn of_encoders(angle: &[f64], encoders: u8) -> f64 {
    let (white, rounding) = white_and_rounding(angle, encoders);
    if white > MORE * rounding { white } else { rounding }
}

/// The step that an angle is rounded to, where there is little noise besides.
pub(crate) fn rounding_step(angle: &[f64]) -> Option<f64> {
    let (white, rounding) = white_and_rounding(angle, 1);
    (rounding > 0.0 && white <= MORE * rounding).then(|| rounding * 12f64.sqrt())
}

/// Standard deviations as third differences and as steps tell them.
fn white_and_rounding(angle: &[f64], encoders: u8) -> (f64, f64) {
    let changes = angle.windows(2).map(|w| (w[1] - w[0]).abs());
    let mut steps: Vec<f64> = changes.filter(|change| *change > 0.0).collect();
    // Differences of equal numbers may be nearly nothing, and those of two encoders' as much as the log's decimals leave.
    let least = DECIMALS * quantile(&mut steps, 0.9);
    steps.retain(|change| *change > least);
    let usual = median(&mut steps);
    // Steps are all alike; the changes of a joint that rests and then moves, with a fine encoder, are not.
    let rests = 2 * steps.len() < angle.len()
        && quantile(&mut steps, 0.9) < ALIKE * usual
        && ALIKE * quantile(&mut steps, 0.1) > usual;
    let step = step_of_encoder(&steps, usual).or_else(|| rests.then_some(usual)).unwrap_or(0.0);
    (white_noise(angle), step * (f64::from(encoders) / 12.0).sqrt())
}

/// The step of an encoder whose angle changes by these amounts, and usually by `usual`; `None` if they are not whole steps.
fn step_of_encoder(changes: &[f64], usual: f64) -> Option<f64> {
    /// Usual changes are of fewer steps where these matter.
    const FEW: f64 = 50.0;
    /// Part of a step by which a change may be no whole number of them.
    const EXACT: f64 = 0.05;
    let step = changes.iter().copied().fold(f64::INFINITY, f64::min);
    let is_whole = |change: &&f64| (**change / step - (**change / step).round()).abs() < EXACT;
    let whole = changes.iter().filter(is_whole).count();
    (usual < FEW * step && 20 * whole > 19 * changes.len()).then_some(step)
}

pub(super) fn third_difference(w: &[f64]) -> f64 {
    (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()
}

fn of_differences(differences: Vec<f64>) -> f64 {
    if let Some(step) = step_of_values(&differences) {
        return of_stepped(differences, step);
    }
    of_continuous(differences)
}

/// The same of a signal that does not come in steps.
pub(super) fn of_continuous(mut differences: Vec<f64>) -> f64 {
    let quiet = of_quieter(&mut differences);
    // Standing still within an encoder's step is no noise level.
    if quiet > 0.0 { quiet } else { deviation(median(&mut differences)) }
}

/// The same by the quieter windows; by all of them where these are as noisy, which tells it better by a third.
fn of_quieter(differences: &mut [f64]) -> f64 {
    let mut medians: Vec<f64> = differences.chunks_exact_mut(WINDOW).map(median).collect();
    let all = median(differences);
    let quiet = if medians.is_empty() { all } else { quantile(&mut medians, QUIETER) / OF_QUIETER };
    let is_alike = (all / quiet - 1.0).abs() * (differences.len() as f64).sqrt() < UNALIKE;
    deviation(if is_alike { all } else { quiet })
}

/// Standard deviation of a signal whose third differences have this median magnitude: that of a normal x is 0.6745 of its own.
fn deviation(median: f64) -> f64 {
    median / 0.6745 / 20f64.sqrt()
}

/// The step of a signal that is rounded to steps which matter beside its noise, by its third differences: these are whole steps, too.
fn step_of_values(differences: &[f64]) -> Option<f64> {
    /// Fewer tell nothing.
    const LEAST: usize = 50;
    // Differences of equal numbers may be nearly nothing, and those of whole steps what the log's decimals leave.
    let least = DECIMALS * quantile(&mut differences.to_vec(), 0.9);
    let changes: Vec<f64> = differences.iter().copied().filter(|change| *change > least).collect();
    let usual = quantile(&mut changes.clone(), 0.5);
    (changes.len() > LEAST).then(|| step_of_encoder(&changes, usual)).flatten()
}

/// The same of a signal in steps: noise of the size of a step is drawn to it, so that medians do not fall on steps, and taken away again. Rounding
/// makes s/√12 itself.
fn of_stepped(mut differences: Vec<f64>, step: f64) -> f64 {
    let mut random = Random::new(1);
    let mut spread = || 0.5 * step * random.symmetric();
    for difference in &mut differences {
        *difference = (*difference + spread() - 3.0 * spread() + 3.0 * spread() - spread()).abs();
    }
    let (all, rounding) = (of_quieter(&mut differences), step * step / 12.0);
    (all * all - rounding).max(rounding).sqrt()
}

fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() - 1) as f64 * part) as usize;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// [`white_noise`] of a signal that comes in pieces and may be of any length.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    /// The last samples, three at most.
    last: Vec<f64>,
    /// Of the windows that are kept.
    differences: Vec<f64>,
    /// Every so many-th window is kept.
    stride: usize,
    /// Differences seen.
    seen: usize,
    most: usize,
}

impl Noise {
    pub fn new() -> Self {
        Self::with_most(MOST)
    }

    fn with_most(most: usize) -> Self {
        Self { last: Vec::new(), differences: Vec::new(), stride: 1, seen: 0, most }
    }

    /// Goes on with the signal.
    pub fn push(&mut self, piece: &[f64]) {
        let mut signal = std::mem::take(&mut self.last);
        signal.extend_from_slice(piece);
        for w in signal.windows(4) {
            if (self.seen / WINDOW).is_multiple_of(self.stride) {
                self.differences.push(third_difference(w));
            }
            self.seen += 1;
            if self.differences.len() >= self.most && self.seen.is_multiple_of(WINDOW) {
                self.halve();
            }
        }
        self.last = signal.split_off(signal.len().saturating_sub(3));
    }

    /// Drops every other window.
    fn halve(&mut self) {
        let windows = self.differences.chunks_exact(WINDOW).step_by(2);
        self.differences = windows.flatten().copied().collect();
        self.stride *= 2;
    }

    /// Of what was seen.
    pub fn level(&self) -> f64 {
        of_differences(self.differences.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(count: usize) -> Vec<f64> {
        let mut state = 1_u64;
        let mut noise = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(|i| (0.01 * i as f64).sin() + 0.1 * noise()).collect()
    }

    #[test]
    fn rounding_to_steps_is_noise() {
        let step = 0.0015;
        let rounded = |x: f64| (x / step).round() * step;
        let angles = |i: usize| ((2e-3 * i as f64).sin(), 4e-3 + 1e-3 * (3e-3 * i as f64).cos());
        let play: Vec<f64> = (0..6000).map(angles).map(|(q, play)| rounded(q + play) - rounded(q)).collect();
        let errors = play.iter().enumerate().map(|(i, seen)| seen - angles(i).1);
        let error = (errors.map(|e| e * e).sum::<f64>() / 6000.0).sqrt();
        let found = of_encoders(&play, 2);
        assert!((0.7..1.4).contains(&(found / error)), "{found} {error}");
        let one: Vec<f64> = (0..6000).map(|i| rounded(angles(i).0)).collect();
        let errors = one.iter().enumerate().map(|(i, seen)| seen - angles(i).0);
        let error = (errors.map(|e| e * e).sum::<f64>() / 6000.0).sqrt();
        let found = of_encoders(&one, 1);
        assert!((0.9..1.1).contains(&(found / error)), "{found} {error}");
        // A fine encoder of a joint that rests most of the time, as one does that lies at its stop.
        let bounded: Vec<f64> =
            (0..6000).map(|i| ((2e-3 * f64::from(i)).sin().min(-0.2) / 3e-5).round() * 3e-5).collect();
        assert!(of_encoders(&bounded, 1) < 2e-5, "{}", of_encoders(&bounded, 1));
        // Two encoders that a log has with seven decimals each, of a joint whose play rests on one side.
        let written = |x: f64| (rounded(x) * 1e7).round() / 1e7;
        let resting: Vec<f64> =
            (0..6000).map(angles).map(|(q, _)| written(q + 5.5e-3) - written(q)).collect();
        let found = of_encoders(&resting, 2);
        assert!((0.9..1.1).contains(&(found / (step / 6f64.sqrt()))), "{found}");
        // What does not rest on steps is judged as before.
        let noisy = signal(4000);
        assert_eq!(of_encoders(&noisy, 2).to_bits(), white_noise(&noisy).to_bits());
    }

    #[test]
    fn white_noise_has_the_size_it_has() {
        let mut random = bipedc_effects::random::Random::new(7);
        for (count, tolerance) in [(2000, 0.1), (20_000, 0.04), (200_000, 0.015)] {
            let signal: Vec<f64> =
                (0..count).map(|i| (0.01 * f64::from(i)).sin() + 0.03 * random.normal()).collect();
            let found = white_noise(&signal);
            assert!((found / 0.03 - 1.0).abs() < tolerance, "{count}: {found}");
        }
    }

    /// The quieter windows alone scatter by 2.7 per cent.
    #[test]
    fn where_all_windows_are_alike_all_of_them_tell() {
        let off = |seed: u64| {
            let mut random = Random::new(seed);
            let signal: Vec<f64> = (0..6000).map(|_| random.normal()).collect();
            (white_noise(&signal) - 1.0).powi(2)
        };
        let scatter = ((1..=100).map(off).sum::<f64>() / 100.0).sqrt();
        assert!(scatter < 0.0225, "{scatter}");
    }

    #[test]
    fn noise_of_a_signal_in_steps_is_that_of_noise_and_steps() {
        let mut random = Random::new(11);
        for steps in [0.1, 0.3, 1.0, 1.6, 2.0, 3.0, 4.0] {
            let (mut squares, mut signal) = (0.0, Vec::new());
            for i in 0..20_000 {
                let smooth = (0.013 * f64::from(i)).sin();
                let step = 0.010_031_7 * steps;
                let seen = ((smooth + 0.01 * random.normal()) / step).round() * step;
                // As a log of six decimals has it: few of these differences are whole steps to the last bit.
                let seen = (seen * 1e6).round() * 1e-6;
                squares += (seen - smooth).powi(2);
                signal.push(seen);
            }
            let (noise, found) = ((squares / 20_000.0_f64).sqrt(), white_noise(&signal));
            assert!((found / noise - 1.0).abs() < 0.08, "steps of {steps} times the noise: {found}, {noise}");
        }
    }

    #[test]
    fn pieces_are_as_noisy_as_the_whole() {
        let signal = signal(1003);
        for size in [1, 2, 7, 400, 2000] {
            let mut noise = Noise::new();
            signal.chunks(size).for_each(|piece| noise.push(piece));
            assert_eq!(noise.level().to_bits(), white_noise(&signal).to_bits(), "pieces of {size}");
        }
        assert_eq!(Noise::new().level(), 0.0);
    }

    #[test]
    fn a_long_signal_is_judged_by_windows_from_all_of_it() {
        let signal = signal(40_000);
        let mut noise = Noise::with_most(4096);
        signal.chunks(999).for_each(|piece| noise.push(piece));
        assert!(noise.differences.len() < 4096 && noise.differences.len() >= 2048 - WINDOW);
        assert!((noise.level() / white_noise(&signal) - 1.0).abs() < 0.05, "{}", noise.level());
    }
}
