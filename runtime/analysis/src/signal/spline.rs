//! Quintic spline through evenly spaced samples.
//!
//! M. Unser, "Splines: a perfect fit for signal and image processing", IEEE Signal Processing Magazine 1999: the
//! B-spline coefficients come from two recursive filters, forwards and backwards.
use super::butterworth::{odd_extension, side_by_side};

/// Poles of the quintic B-spline's inverse filter.
const POLES: [f64; 2] = [-0.430_575_347_099_973_8, -0.043_096_288_203_264_65];
/// Reflected samples at either end: 0.43³² is 2e-12.
const MARGIN: usize = 32;

/// A quintic spline: four times continuously differentiable, exact at the samples.
///
/// At its ends it continues by odd reflection: exact for straight ends, so the second derivative of the first
/// and last few samples is poor. [`crate::compare`] leaves half a second out there.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// Coefficient `margin` belongs to the first sample.
    coefficients: Vec<f64>,
    margin: usize,
    samples: usize,
    step: f64,
}

impl Spline {
    /// Through these samples, `step` (s) apart; `None` for fewer than 8 samples.
    pub fn new(samples: &[f64], step: f64) -> Option<Self> {
        let [spline] = Self::all([samples], step)?;
        Some(spline)
    }

    /// The same through signals of one length, to the last bit: each step waits for the one before, so that several signals take as long
    /// as one.
    ///
    /// # Panics
    /// If one of them is shorter than the first.
    pub fn all<const N: usize>(signals: [&[f64]; N], step: f64) -> Option<[Self; N]> {
        let samples = signals.first().map_or(0, |signal| signal.len());
        if samples < 8 {
            return None;
        }
        let margin = MARGIN.min(samples - 1);
        let mut values = side_by_side(signals.map(|signal| odd_extension(signal, margin)));
        for pole in POLES {
            invert(&mut values, pole);
        }
        let coefficients = |k: usize| values.iter().map(|value| value[k]).collect();
        Some(std::array::from_fn(|k| Self { coefficients: coefficients(k), margin, samples, step }))
    }

    /// Value and first two derivatives at a sample: unit, unit/s, unit/s².
    ///
    /// # Panics
    /// If there is no such sample.
    pub fn at_sample(&self, index: usize) -> [f64; 3] {
        assert!(index < self.samples, "the spline has {} samples", self.samples);
        let i = index + self.margin;
        let c = &self.coefficients[i - 2..=i + 2];
        let (near, far) = (c[1] + c[3], c[0] + c[4]);
        let value = (66.0 * c[2] + 26.0 * near + far) / 120.0;
        let slope = (10.0 * (c[3] - c[1]) + (c[4] - c[0])) / 24.0;
        let curvature = (2.0 * near + far - 6.0 * c[2]) / 6.0;
        [value, slope / self.step, curvature / (self.step * self.step)]
    }

    /// The same at a time (s) after the first sample; outside of the samples it is held at the ends.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let last = (self.samples - 1) as f64;
        let x = (time / self.step).clamp(0.0, last);
        let i = (x.floor() as usize).min(self.samples - 2);
        let u = x - i as f64;
        let c = &self.coefficients[i + self.margin - 2..=i + self.margin + 3];
        let mut sums = [0.0; 3];
        for (k, c) in c.iter().enumerate() {
            let weights = basis(u + 2.0 - k as f64);
            for (sum, weight) in sums.iter_mut().zip(weights) {
                *sum += c * weight;
            }
        }
        [sums[0], sums[1] / self.step, sums[2] / (self.step * self.step)]
    }
}

/// The quintic B-spline and its first two derivatives at `x`.
fn basis(x: f64) -> [f64; 3] {
    const BINOMIALS: [f64; 6] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0];
    // Symmetric: the sum of truncated powers is evaluated where it has few terms.
    let side = if x > 0.0 { -1.0 } else { 1.0 };
    let mut sums = [0.0; 3];
    for (j, binomial) in BINOMIALS.iter().enumerate() {
        let y = 3.0 - x.abs() - j as f64;
        if y <= 0.0 {
            break;
        }
        let cube = binomial * y * y * y;
        sums[0] += cube * y * y / 120.0;
        sums[1] += cube * y / 24.0;
        sums[2] += cube / 6.0;
    }
    [sums[0], side * sums[1], sums[2]]
}

/// Divides by `z + z⁻¹ − pole − 1/pole` in place, as for signals mirrored at their ends.
fn invert<const N: usize>(values: &mut [[f64; N]], pole: f64) {
    let n = values.len();
    let gain = (1.0 - pole) * (1.0 - 1.0 / pole);
    let mut power = 1.0;
    let mut state = [0.0; N];
    for value in values.iter().take(64) {
        state = std::array::from_fn(|k| state[k] + power * value[k]);
        power *= pole;
    }
    values[0] = state.map(|state| state * gain);
    for i in 1..n {
        values[i] = std::array::from_fn(|k| gain * values[i][k] + pole * values[i - 1][k]);
    }
    let last = pole / (pole * pole - 1.0);
    values[n - 1] = std::array::from_fn(|k| last * (values[n - 1][k] + pole * values[n - 2][k]));
    for i in (0..n - 1).rev() {
        values[i] = std::array::from_fn(|k| pole * (values[i + 1][k] - values[i][k]));
    }
}
