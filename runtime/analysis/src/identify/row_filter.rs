//! Low-passes that a row of the regression passes as a whole, regressor and torque alike: what holds for every sample holds for
//! weighted means of samples too, so that they take off noise and make nothing wrong, whatever they take off the motion.
use std::f64::consts::PI;
use std::ops::Range;

/// The part of a decimated sample that may be made of samples of which nothing is known.
const LITTLE: f64 = 0.1;
/// The same of a smoothed one: what a joint does at rest must not count.
const LEAST: f64 = 0.02;
/// Half length of the decimation filter, in kept samples.
const REACH: usize = 8;
/// Half length of a smoothing filter in its standard deviations.
const DEVIATIONS: f64 = 4.0;
/// Rows kept per period of a smoothing filter's cut-off.
const PER_PERIOD: f64 = 10.0;
/// Fewest samples of a piece, and how many times longer than the filter it is: neighbours share the filter's length.
const PIECE: usize = 256;
const LONGER: usize = 4;

/// A symmetric low-pass after which every so many-th sample is kept: no delay.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RowFilter {
    taps: Vec<f64>,
    stride: usize,
    /// The part of a row that may be made of unknown samples.
    unknown: f64,
}

impl RowFilter {
    /// Keeps every `factor`-th sample, and nothing above the new rate's half.
    pub fn decimation(factor: usize) -> Self {
        let reach = (REACH * factor) as isize;
        // A sinc that ends at 0.8 of the new Nyquist frequency, under a Hamming window.
        let cut = 0.8 / factor as f64;
        let tap = |i: isize| {
            let x = PI * cut * i as f64;
            let sinc = if i == 0 { 1.0 } else { x.sin() / x };
            sinc * (0.54 + 0.46 * (PI * i as f64 / reach as f64).cos())
        };
        Self::of((-reach..=reach).map(tap).collect(), factor, LITTLE)
    }

    /// A bell of gain ½ at `cutoff_hz`: nothing is as short in time and in frequency, so that rests and ends of a log cost little.
    pub fn smooth(cutoff_hz: f64, step: f64) -> Self {
        let deviation = (0.5 * 2f64.ln()).sqrt() / (PI * cutoff_hz * step);
        let reach = (DEVIATIONS * deviation).ceil() as isize;
        let tap = |i: isize| (-0.5 * (i as f64 / deviation).powi(2)).exp();
        let stride = (1.0 / (PER_PERIOD * cutoff_hz * step)) as usize;
        Self::of((-reach..=reach).map(tap).collect(), stride.max(1), LEAST)
    }

    fn of(taps: Vec<f64>, stride: usize, unknown: f64) -> Self {
        let sum: f64 = taps.iter().sum();
        Self { taps: taps.iter().map(|tap| tap / sum).collect(), stride, unknown }
    }

    /// Samples that make one row.
    pub fn length(&self) -> usize {
        self.taps.len()
    }

    /// Samples from row to row.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Pieces of a stretch of samples, whose rows are together those of the stretch.
    pub fn pieces(&self, stretch: Range<usize>) -> impl Iterator<Item = Range<usize>> + use<> {
        let (length, stride) = (self.taps.len(), self.stride);
        let rows = if stretch.len() < length { 0 } else { (stretch.len() - length) / stride + 1 };
        let each = (PIECE.max(LONGER * length) / stride).max(1);
        (0..rows).step_by(each).map(move |first| {
            let last = rows.min(first + each) - 1;
            stretch.start + first * stride..stretch.start + last * stride + length
        })
    }

    /// The rows' values of a column.
    pub fn column(&self, signal: &[f64]) -> Vec<f64> {
        let windows = signal.windows(self.taps.len()).step_by(self.stride);
        windows.map(|window| window.iter().zip(&self.taps).map(|(x, tap)| x * tap).sum()).collect()
    }

    /// Rows that are made of known samples, but for a part that counts little.
    pub fn known(&self, known: &[bool]) -> Vec<bool> {
        let all: f64 = self.taps.iter().map(|tap| tap.abs()).sum();
        let unknown = |window: &[bool]| -> f64 {
            window.iter().zip(&self.taps).filter(|(known, _)| !**known).map(|(_, tap)| tap.abs()).sum()
        };
        let windows = known.windows(self.taps.len()).step_by(self.stride);
        windows.map(|window| unknown(window) <= self.unknown * all).collect()
    }

    /// Times of the rows.
    pub fn places(&self, times: &[f64]) -> Vec<f64> {
        times.windows(self.taps.len()).step_by(self.stride).map(|window| window[window.len() / 2]).collect()
    }

    /// The part of a signal's variance that passes, of noise with this response to one sample's error.
    pub fn part_of_noise(&self, response: &[f64]) -> f64 {
        let ends = vec![0.0; self.taps.len() - 1];
        let padded = [&ends, response, &ends].concat();
        let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
        // Nothing passes above half the rate of the rows, so that they tell all squares.
        self.stride as f64 * squares(&self.column(&padded)) / squares(response).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(cycles: f64) -> Vec<f64> {
        (0..2000).map(|i| (TAU * cycles * f64::from(i)).sin()).collect()
    }

    #[test]
    fn decimation_keeps_what_is_slow_and_drops_what_is_fast() {
        let decimation = RowFilter::decimation(10);
        let places = decimation.places(&(0..2000).map(f64::from).collect::<Vec<_>>());
        // A twentieth of the new rate passes with its phase; a tone above half the new rate does not.
        let slow = decimation.column(&wave(0.005));
        assert_eq!(slow.len(), places.len());
        for (x, i) in slow.iter().zip(&places) {
            assert!((x - (TAU * 0.005 * i).sin()).abs() < 0.01);
        }
        assert!(decimation.column(&wave(0.08)).iter().all(|x| x.abs() < 0.01));
        assert!(decimation.column(&[3.0; 500]).iter().all(|x| (x - 3.0).abs() < 1e-12));
    }

    #[test]
    fn smoothing_halves_its_cutoff_and_pieces_are_the_whole() {
        let smooth = RowFilter::smooth(4.0, 0.002);
        let size =
            |hz: f64| smooth.column(&wave(0.002 * hz)).iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!((size(4.0) - 0.5).abs() < 0.01 && size(1.0) > 0.94 && size(12.0) < 0.01);
        let signal = wave(0.007);
        let pieces: Vec<f64> =
            smooth.pieces(100..1900).flat_map(|piece| smooth.column(&signal[piece])).collect();
        assert_eq!(pieces, smooth.column(&signal[100..1900]));
        assert_eq!(smooth.pieces(0..smooth.length() - 1).count(), 0);
    }
}
