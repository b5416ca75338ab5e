//! A held controller that is too strong for its step turns its torque round in every one.

/// Steps in a row after which it is no coincidence.
const ROW: usize = 40;

/// Changes of one torque from step to step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Chatter {
    torque: f64,
    change: f64,
    /// Changes in a row, each against the one before.
    row: usize,
    /// Size of the first of them.
    first: f64,
}

impl Chatter {
    /// Notes the torque of a step; true: it has swung to and fro for long without growing smaller.
    pub fn swings(&mut self, torque: f64) -> bool {
        let change = torque - self.torque;
        if change * self.change < 0.0 {
            self.row += 1;
        } else {
            (self.row, self.first) = (0, change.abs());
        }
        (self.torque, self.change) = (torque, change);
        self.row >= ROW && change.abs() >= 0.9 * self.first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lasting_swings_count() {
        let run = |torque: fn(i32) -> f64| {
            let mut chatter = Chatter::default();
            (0..200).any(|i| chatter.swings(torque(i)))
        };
        assert!(run(|i| if i % 2 == 0 { 1.0 } else { -1.0 }));
        assert!(run(|i| (-1.1_f64).powi(i)));
        assert!(!run(|i| (-0.9_f64).powi(i)));
        assert!(!run(|i| (0.3 * f64::from(i)).sin()));
        assert!(!run(|_| 1.0));
    }
}
