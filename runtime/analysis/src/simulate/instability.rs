//! A held controller that is too strong for its step swings: its torque turns round again and again and never less.

/// Turns in a row after which it is no coincidence.
const ROW: usize = 20;

/// Most steps from turn to turn.
const SLOWEST: usize = 50;

/// How a torque swings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Swing {
    /// It turns round in every step.
    EveryStep,
    /// Within some steps.
    Slower,
}

/// Turning points of one torque.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct InstabilityDetector {
    torque: f64,
    /// The last change that was one.
    change: f64,
    /// The last turning point, and the steps since.
    turned: f64,
    since: usize,
    /// Turns in a row, the size of the first, and the longest time from turn to turn.
    row: usize,
    first: f64,
    longest: usize,
}

impl InstabilityDetector {
    /// Notes the torque of a step; whether it has swung to and fro for long without growing smaller.
    pub fn swings(&mut self, torque: f64) -> Option<Swing> {
        let change = torque - self.torque;
        self.since += 1;
        let mut found = None;
        if change * self.change < 0.0 {
            let size = (self.torque - self.turned).abs();
            if self.since > SLOWEST || self.row == 0 {
                (self.row, self.first, self.longest) = (0, size, 0);
            }
            self.longest = if self.row == 0 { 0 } else { self.longest.max(self.since) };
            self.row += 1;
            if self.row >= ROW && size >= 0.9 * self.first {
                found = Some(if self.longest <= 1 { Swing::EveryStep } else { Swing::Slower });
            }
            (self.turned, self.since) = (self.torque, 0);
        }
        if change != 0.0 {
            self.change = change;
        }
        self.torque = torque;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lasting_swings_count() {
        let run = |torque: fn(i32) -> f64| {
            let mut instability = InstabilityDetector::default();
            (0..900).find_map(|i| instability.swings(torque(i)))
        };
        assert_eq!(run(|i| if i % 2 == 0 { 1.0 } else { -1.0 }), Some(Swing::EveryStep));
        assert_eq!(run(|i| (-1.05_f64).powi(i)), Some(Swing::EveryStep));
        assert_eq!(run(|i| (-0.9_f64).powi(i)), None);
        assert_eq!(run(|i| 1.002_f64.powi(i) * (0.6 * f64::from(i)).sin()), Some(Swing::Slower));
        assert_eq!(run(|i| 0.99_f64.powi(i) * (0.6 * f64::from(i)).sin()), None);
        // A motion that the controller follows.
        assert_eq!(run(|i| (0.03 * f64::from(i)).sin()), None);
        assert_eq!(run(|_| 1.0), None);
    }
}
