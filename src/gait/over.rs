//! Ranges of parameters and of speeds, as they are asked for.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::magnitude;

/// Most values of one range.
pub const MOST_VALUES: usize = 2000;

/// Evenly spaced values from `low` to `high`, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The smallest.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// How many.
    pub count: usize,
}

/// Values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Over {
    /// Of the parameter.
    pub name: String,
    /// Its values.
    pub range: Range,
}

impl Range {
    /// All values. Both ends are exactly as they were asked for.
    pub fn values(&self) -> Vec<f64> {
        let last = self.count.saturating_sub(1).max(1);
        let place = |k: usize| {
            let part = k as f64 / last as f64;
            // Not low + part (high − low): the last one would miss the end by its last bit.
            if k == last { self.high } else { self.low + part * (self.high - self.low) }
        };
        (0..self.count).map(place).collect()
    }

    /// All values of a range that is one; `of` names it in messages.
    ///
    /// # Errors
    /// Ends that are no numbers or in the wrong order, too few or too many values.
    pub fn checked(&self, of: &str) -> Result<Vec<f64>, Diagnostic> {
        self.refusal(of).map_or_else(|| Ok(self.values()), Err)
    }

    /// What is wrong with it; `of` names it in messages.
    pub(super) fn refusal(&self, of: &str) -> Option<Diagnostic> {
        let Self { low, high, count } = *self;
        let refuse = |message: String, help: &str| Some(Diagnostic::error(message).help(help));
        for x in [low, high] {
            if !x.is_finite() {
                return refuse(
                    format!("{of}: an end of {x} is not possible"),
                    "write A:B:N with numbers A and B",
                );
            }
            if let Some((what, help)) = magnitude::refusal(x) {
                return refuse(format!("{of}: an end of {x} {what}"), help);
            }
        }
        if low >= high {
            return refuse(
                format!("{of}: {low} to {high} is no range"),
                "write A:B:N, the smaller end first",
            );
        }
        if count < 2 {
            return refuse(
                format!("{of}: {count} is too few values for a range"),
                "write A:B:N with N of at least 2: both ends are among the values",
            );
        }
        if count > MOST_VALUES {
            return refuse(
                format!("{of}: {count} values are too many"),
                &format!("write A:B:N with N of at most {MOST_VALUES}"),
            );
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_among_the_values() {
        let range = Range { low: 0.1, high: 0.7, count: 7 };
        assert!(range.refusal("x").is_none());
        let values = range.values();
        assert_eq!((values[0], values[6], values.len()), (0.1, 0.7, 7));
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn ranges_that_are_none_are_refused() {
        let wrong = [
            (f64::NAN, 1.0, 5),
            (0.0, f64::INFINITY, 5),
            (0.0, 1e300, 5),
            (1.0, 0.0, 5),
            (1.0, 1.0, 5),
            (0.0, 1.0, 0),
            (0.0, 1.0, 1),
            (0.0, 1.0, usize::MAX),
        ];
        for (low, high, count) in wrong {
            let found = Range { low, high, count }.refusal("--over x").unwrap();
            assert!(found.message.contains("--over x") && found.help.is_some(), "{found}");
        }
    }
}
