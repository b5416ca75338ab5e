//! Which way joints and motors turn, as dry friction feels it, after the filter that efforts pass.
//!
//! The friction of a joint that turns round jumps, and the filter rounds that jump in the measured effort. A sharp sign beside it
//! would be wrong around every reversal, always to the same side: too little dry friction, too much viscous friction. So signs
//! pass the same filter. While a joint rests its friction is anything between its bounds, whatever the sign of the noise of its
//! speed: there, and as far around as the filter carries it, nothing is known.
use crate::signal::Butterworth;
use std::f64::consts::TAU;

/// A joint rests where it is slower than this part of its largest speed ...
const STILL: f64 = 0.005;
/// ... or than this many standard deviations of its speed's noise ...
const NOISE: f64 = 3.0;
/// ... for longer than this, in periods of the cut-off: shorter ones are reversals.
const PAUSE: f64 = 0.1;
/// As far as the filter carries a jump, in periods of the cut-off.
const REACH: f64 = 0.5;

/// Of which joints the directions are wanted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Directions {
    /// The direction of the sum of both joints' speeds; of one joint, that joint twice.
    pub pairs: Vec<(usize, usize)>,
    /// Largest speed of each joint, rad/s or m/s.
    pub fastest: Vec<f64>,
}

/// The direction of a joint, or of two together, sample after sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Direction {
    /// The sign of the speed after the filter, -1 to 1.
    pub sign: Vec<f64>,
    /// Whether it tells the direction of friction.
    pub known: Vec<bool>,
}

impl Direction {
    /// Forgets all samples.
    pub(super) fn clear(&mut self) {
        self.sign.clear();
        self.known.clear();
    }
}

/// What makes directions of the speeds of one block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turning<'a> {
    pub filter: &'a Butterworth,
    /// Cut-off, Hz.
    pub cutoff_hz: f64,
    /// Sampling step, s.
    pub step: f64,
}

impl Turning<'_> {
    /// Of speeds on an even grid; `fastest`: the largest of the log, `noise`: of the position, standard deviation.
    pub fn of(&self, speeds: &[f64], fastest: f64, noise: f64) -> Direction {
        // Of white noise, what an ideal low-pass leaves of its derivative.
        let noise = noise * TAU * self.cutoff_hz * (2.0 / 3.0 * self.cutoff_hz * self.step).sqrt();
        let known = self.known(speeds, (STILL * fastest).max(NOISE * noise));
        Direction { sign: self.sign(speeds), known }
    }

    /// The sign of the speed after the filter.
    pub fn sign(&self, speeds: &[f64]) -> Vec<f64> {
        let signs: Vec<f64> = speeds.iter().map(|v| if *v == 0.0 { 0.0 } else { v.signum() }).collect();
        self.filter.zero_phase(&signs)
    }

    /// Stricter than [`Direction::known`]: samples around which nothing is slower than a limit, not even in a reversal, as
    /// far as the filter carries a jump.
    pub fn nowhere_slow(&self, speeds: &[f64], slow: f64) -> Vec<bool> {
        if slow <= 0.0 {
            return vec![true; speeds.len()];
        }
        let reach = self.samples(REACH);
        let mut before = Vec::with_capacity(speeds.len() + 1);
        before.push(0_usize);
        for speed in speeds {
            before.push(before[before.len() - 1] + usize::from(speed.abs() < slow));
        }
        let last = speeds.len();
        (0..last).map(|i| before[(i + reach + 1).min(last)] == before[i.saturating_sub(reach)]).collect()
    }

    fn known(&self, speeds: &[f64], still: f64) -> Vec<bool> {
        let period = 1.0 / (self.cutoff_hz * self.step);
        resting(speeds, still, period, REACH).into_iter().map(|rests| !rests).collect()
    }

    fn samples(&self, periods: f64) -> usize {
        (periods / (self.cutoff_hz * self.step)).ceil() as usize
    }
}

/// Samples at which a joint rests (it is slower than `still` for longer than a reversal takes), and those around as far as
/// a filter carries that: `reach` periods of its cut-off, of `period` samples each.
pub(crate) fn resting(speeds: &[f64], still: f64, period: f64, reach: f64) -> Vec<bool> {
    let (pause, reach) = ((PAUSE * period).ceil() as usize, (reach * period).ceil() as usize);
    let mut rests = vec![false; speeds.len()];
    let mut first = 0;
    for stretch in speeds.chunk_by(|a, b| (a.abs() < still) == (b.abs() < still)) {
        let last = first + stretch.len();
        if stretch[0].abs() < still && stretch.len() > pause {
            rests[first.saturating_sub(reach)..(last + reach).min(speeds.len())].fill(true);
        }
        first = last;
    }
    rests
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reversals_are_rounded_and_rests_unknown() {
        let filter = Butterworth::new(10.0, 500.0).unwrap();
        let turning = Turning { filter: &filter, cutoff_hz: 10.0, step: 0.002 };
        // One turn a second; then rest with noise of the speed.
        let speed = |i: usize| match i {
            0..1500 => (TAU * i as f64 / 500.0).cos(),
            _ => 1e-4 * (i as f64 * 7.3).sin(),
        };
        let speeds: Vec<f64> = (0..2500).map(speed).collect();
        let direction = turning.of(&speeds, 1.0, 0.0);
        assert!(direction.known[..1400].iter().all(|known| *known));
        assert!(direction.known[1530..].iter().all(|known| !known));
        assert!((direction.sign[500] - 1.0).abs() < 0.02 && direction.sign[625].abs() < 0.1);
        let rounded = direction.sign[610..640].iter().filter(|sign| sign.abs() < 0.9).count();
        assert!(rounded > 10, "{rounded}");
        // So much noise of the position that the speed tells no direction at all.
        assert!(turning.of(&speeds, 1.0, 1.0).known.iter().all(|known| !known));
    }
}
