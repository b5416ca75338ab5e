//! Zero-phase low-pass filter of fourth order.

/// A second-order section with unit gain at frequency zero.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Section {
    b: [f64; 3],
    /// Denominator without its leading 1.
    a: [f64; 2],
}

impl Section {
    /// Filters signals side by side in place; the state starts as if the first value had always been there.
    fn run<const N: usize>(&self, values: &mut [[f64; N]]) {
        let Some(first) = values.first() else { return };
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let (mut s1, mut s2) = (first.map(|x| (1.0 - b0) * x), first.map(|x| (b2 - a2) * x));
        for value in values {
            for k in 0..N {
                let x = value[k];
                let y = b0 * x + s1[k];
                s1[k] = b1 * x - a1 * y + s2[k];
                s2[k] = b2 * x - a2 * y;
                value[k] = y;
            }
        }
    }
}

/// Samples added on either side by odd reflection, as scipy's `sosfiltfilt` does for two sections.
const PADDING: usize = 15;

/// What a wrong guess about the samples beyond a cut of the signal may leave at the overlap's inner end,
/// as a part of the guess's error.
///
/// The guess (odd reflection, then constant) is off by at most four times the range of the signal, so filtered
/// values of a signal cut into blocks differ from those of the whole by less than 4e-12 of its range; velocities
/// by that times 2π·cutoff, accelerations times its square.
pub const TRUNCATION: f64 = 1e-12;

/// The highest cut-off as a part of the sampling rate: at half of it the filter rings for ever (a log's step of 0.02 s is not 0.02 to the last digit, so that
/// 25 Hz may seem to lie below).
const HIGHEST: f64 = 0.49;

/// A cut-off that the filter cannot have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FilterError {
    /// Not below half the sampling rate by a fiftieth of that, or not a positive number.
    OutOfRange,
    /// Below a ten-thousandth of the sampling rate: the coefficients lose their digits.
    TooLow,
}

/// Butterworth low-pass of fourth order, run forwards and backwards: no phase, gain ½ at the cut-off.
#[derive(Debug, Clone, PartialEq)]
pub struct Butterworth {
    sections: [Section; 2],
}

impl Butterworth {
    /// The filter for a cut-off and a sampling rate, both Hz (bilinear transform with prewarping, as scipy's
    /// `butter(4, cutoff, fs=rate)`).
    ///
    /// # Errors
    /// The cut-off is no positive number below 0.49 of the rate, or below a ten-thousandth of it.
    pub fn new(cutoff: f64, rate: f64) -> Result<Self, FilterError> {
        let part = cutoff / rate;
        if !(part > 0.0 && part < HIGHEST) {
            return Err(FilterError::OutOfRange);
        }
        if part < 1e-4 {
            return Err(FilterError::TooLow);
        }
        let k = (std::f64::consts::PI * part).tan();
        // Poles of the analog filter at angles of 22.5° and 67.5° from the negative real axis.
        let sections = [std::f64::consts::FRAC_PI_8, 3.0 * std::f64::consts::FRAC_PI_8].map(|angle| {
            let damping = 2.0 * angle.cos();
            let norm = 1.0 / (1.0 + damping * k + k * k);
            let gain = k * k * norm;
            let a = [2.0 * (k * k - 1.0) * norm, (1.0 - damping * k + k * k) * norm];
            Section { b: [gain, 2.0 * gain, gain], a }
        });
        Ok(Self { sections })
    }

    /// Filters forwards and backwards, as scipy's `sosfiltfilt`: odd reflection of 15 samples at both ends
    /// (fewer if the signal is shorter) and initial states of a constant signal.
    pub fn zero_phase(&self, signal: &[f64]) -> Vec<f64> {
        let [filtered] = self.zero_phases([signal]);
        filtered
    }

    /// The same of signals of one length, to the last bit: each step waits for the one before, so that several signals take as long as one.
    ///
    /// # Panics
    /// If one of them is shorter than the first.
    pub fn zero_phases<const N: usize>(&self, signals: [&[f64]; N]) -> [Vec<f64>; N] {
        let n = signals.first().map_or(0, |signal| signal.len());
        let padding = PADDING.min(n.saturating_sub(1));
        let mut values = side_by_side(signals.map(|signal| odd_extension(signal, padding)));
        for _ in 0..2 {
            for section in &self.sections {
                section.run(&mut values);
            }
            values.reverse();
        }
        let within = padding..(padding + n).min(values.len());
        std::array::from_fn(|k| values[within.clone()].iter().map(|value| value[k]).collect())
    }

    /// Samples after which the response of the zero-phase filter to a step at a cut stays below [`TRUNCATION`].
    pub fn overlap(&self) -> usize {
        // |pole| = √a₂ for the complex pair of a section; the slower pair decides. Two passes and four poles
        // make the envelope a polynomial of third degree times the decay: doubled here and checked by a test.
        let slowest = self.sections.iter().map(|s| s.a[1].abs().sqrt()).fold(0.0, f64::max);
        let decay = -slowest.max(1e-3).ln();
        let time_constants = -TRUNCATION.ln() + 8.0;
        (time_constants / decay).ceil() as usize + PADDING
    }
}

/// Signals of one length, sample by sample.
pub(super) fn side_by_side<const N: usize>(signals: [Vec<f64>; N]) -> Vec<[f64; N]> {
    let n = signals.first().map_or(0, Vec::len);
    let signals = signals.each_ref().map(|signal| &signal[..n]);
    (0..n).map(|i| signals.map(|signal| signal[i])).collect()
}

/// The signal with `padding` samples before and after it, reflected about its end points.
pub(super) fn odd_extension(signal: &[f64], padding: usize) -> Vec<f64> {
    let n = signal.len();
    let mut values = Vec::with_capacity(n + 2 * padding);
    if n > padding {
        values.extend((1..=padding).rev().map(|i| 2.0 * signal[0] - signal[i]));
        values.extend_from_slice(signal);
        values.extend((1..=padding).map(|i| 2.0 * signal[n - 1] - signal[n - 1 - i]));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_overlap_is_long_enough() {
        for (cutoff, rate) in [(10.0, 250.0), (90.0, 250.0), (10.0, 1000.0), (1.0, 500.0), (120.0, 250.0)] {
            let filter = Butterworth::new(cutoff, rate).unwrap();
            let overlap = filter.overlap();
            let half = 4 * overlap;
            let step: Vec<f64> = (0..2 * half).map(|i| if i < half { 0.0 } else { 1.0 }).collect();
            let response = filter.zero_phase(&step);
            let worst = (0..=half - overlap).map(|i| response[i].abs()).fold(0.0, f64::max);
            assert!(worst < TRUNCATION, "{cutoff} Hz of {rate} Hz: {worst:e} after {overlap} samples");
        }
    }

    #[test]
    fn signals_side_by_side_are_those_that_are_alone() {
        let filter = Butterworth::new(10.0, 250.0).unwrap();
        for n in [0, 1, 2, 15, 16, 700] {
            let signals: [Vec<f64>; 3] =
                std::array::from_fn(|k| (0..n).map(|i| (0.37 * (i * (k + 2)) as f64).sin()).collect());
            let together = filter.zero_phases(signals.each_ref().map(Vec::as_slice));
            assert_eq!(together, signals.each_ref().map(|signal| filter.zero_phase(signal)));
        }
    }

    #[test]
    fn short_signals_do_not_panic() {
        let filter = Butterworth::new(10.0, 250.0).unwrap();
        for n in 0..40 {
            assert_eq!(filter.zero_phase(&vec![1.0; n]).len(), n);
        }
        assert_eq!(Butterworth::new(125.0, 250.0), Err(FilterError::OutOfRange));
        // Its ringing would take more memory than there is.
        assert_eq!(Butterworth::new(25.0, 50.000_000_01), Err(FilterError::OutOfRange));
        assert!(Butterworth::new(24.0, 50.0).is_ok_and(|filter| filter.overlap() < 5000));
        assert_eq!(Butterworth::new(f64::NAN, 250.0), Err(FilterError::OutOfRange));
        assert_eq!(Butterworth::new(0.01, 250.0), Err(FilterError::TooLow));
    }
}
