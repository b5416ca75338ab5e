//! Noise behind a filter that is hardly faster than the motion: its spectrum is flat where the motion's is not.
use super::coloured::{between_reversals, seen};
use super::noise::third_difference;
use nalgebra::{DMatrix, DVector};

/// Means are taken over times from this part of the time between two reversals
const FROM: f64 = 0.25;
/// to so many times of it, as far as a log of so many means reaches,
const TO: f64 = 2.0;
const MEANS: usize = 30;
/// in steps of this factor.
const STEP: f64 = 1.4;
/// What follows the motion is largest in means over half that time: they reach to this part of it at least.
const LEAST: f64 = 0.6;
/// Their power is the same within this part of it and [`SCATTER`] · √(length / n).
const FLAT: f64 = 0.2;
const SCATTER: f64 = 3.0;
/// In the mean over the longer times it is between these parts of that of the shortest.
const FALL: f64 = 0.7;
const RISE: f64 = 1.45;
/// Of noise less than this part of the squares goes with the joint's own motion, of chance alone.
const FOLLOWED: f64 = 0.15;
/// Noise is as large where the joint is fast as where it is slow, within this factor of its variance.
const STEADY: f64 = 1.6;
/// That is looked at over the first lag whose differences show this part of it.
const RISING: f64 = 0.2;

/// Standard deviation of a residual that is noise in all that can be seen of it: means over longer and longer times have the power of
/// independent numbers, from a quarter of the time between two reversals on (what follows the motion is largest there), it does not
/// go with the joint's motion, and it is as large where the joint is fast as where it is slow (a ripple is not).
pub(super) fn flat_noise(residual: &[f64], velocity: &[f64]) -> Option<f64> {
    let n = residual.len();
    let turn = between_reversals(velocity);
    let (first, last) = (FROM * turn, (TO * turn).min(n as f64 / MEANS as f64));
    if first < 2.0 || last < LEAST * turn || velocity.len() != n {
        return None;
    }
    let lengths: Vec<usize> = std::iter::successors(Some(first), |length| Some(length * STEP))
        .take_while(|length| *length <= last)
        .map(|length| length as usize)
        .collect();
    let powers: Vec<f64> = lengths.iter().map(|length| power(residual, *length)).collect();
    let mut sorted = powers.clone();
    sorted.sort_by(f64::total_cmp);
    let middle = *sorted.get(sorted.len() / 2)?;
    let is_flat = |(length, power): (&usize, &f64)| {
        (power / middle - 1.0).abs() < FLAT + SCATTER * (*length as f64 / n as f64).sqrt()
    };
    // What follows the motion rises from the first lengths to half the time between two reversals.
    let longer: Vec<f64> = powers.iter().skip(2).copied().collect();
    let rise = longer.iter().sum::<f64>() / longer.len().max(1) as f64 / powers[0];
    if !(FALL..RISE).contains(&rise) || followed(residual, velocity) > FOLLOWED {
        return None;
    }
    let variance = residual.iter().map(|x| x * x).sum::<f64>() / n as f64;
    // Where differences rise towards the whole, a ripple shows how fast the joint is.
    let white = seen(residual, 1);
    let rises = |lag: &usize| seen(residual, *lag) > white + RISING * (variance - white);
    let is_noise = || Some(is_steady(residual, velocity, (2..=first as usize).find(rises)?, white));
    (lengths.iter().zip(&powers).all(is_flat) && is_noise()?).then(|| variance.sqrt())
}

/// Mean square of the means over so many samples in a row, times their number: the spectrum's density below half their rate.
fn power(signal: &[f64], length: usize) -> f64 {
    let mut total: f64 = signal[..length].iter().sum();
    let mut squares = total * total;
    for i in length..signal.len() {
        total += signal[i] - signal[i - length];
        squares += total * total;
    }
    squares / (signal.len() - length + 1) as f64 / length as f64
}

/// Part of the squares that is linear in the joint's angle, velocity, its sign and acceleration.
fn followed(residual: &[f64], velocity: &[f64]) -> f64 {
    let n = residual.len();
    let mut angle = 0.0;
    let mut signals = DMatrix::zeros(n, 5);
    for i in 0..n {
        angle += velocity[i];
        let change = velocity[(i + 1).min(n - 1)] - velocity[i.saturating_sub(1)];
        signals.row_mut(i).copy_from_slice(&[1.0, angle, velocity[i], velocity[i].signum(), change]);
    }
    for mut column in signals.column_iter_mut() {
        let size = column.norm();
        column /= size.max(f64::MIN_POSITIVE);
    }
    let right = signals.tr_mul(&DVector::from_column_slice(residual));
    let explained =
        signals.tr_mul(&signals).cholesky().map_or(0.0, |factor| right.dot(&factor.solve(&right)));
    explained / residual.iter().map(|x| x * x).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Whether what changes over a lag, beside white noise of this variance, is as large where the joint is fast as where it is slow.
fn is_steady(residual: &[f64], velocity: &[f64], lag: usize, white: f64) -> bool {
    let mut speeds: Vec<f64> = velocity.iter().map(|v| v.abs()).collect();
    let middle = *speeds.select_nth_unstable_by(velocity.len() / 2, f64::total_cmp).1;
    let change = |fast: bool| {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for i in 3 * lag..residual.len() {
            if (velocity[i - 3 * lag / 2].abs() > middle) == fast {
                let window = [residual[i - 3 * lag], residual[i - 2 * lag], residual[i - lag], residual[i]];
                (sum, count) = (sum + third_difference(&window).powi(2) / 20.0, count + 1.0);
            }
        }
        sum / count.max(1.0) - white
    };
    let (fast, slow) = (change(true), change(false));
    fast > 0.0 && slow > 0.0 && fast < STEADY * slow && slow < STEADY * fast
}
