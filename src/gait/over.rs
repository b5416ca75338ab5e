//! Ranges of parameters and of speeds, as they are asked for.
use super::GaitBench;
use bipedc_compiler::description::gait::GaitParameter;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
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

impl GaitBench {
    /// The parameters of ranges, by index, with their values.
    ///
    /// # Errors
    /// Parameters that the gait does not have, or that stand twice or in `fixed` too; ranges that are none.
    pub(super) fn axes(&self, over: &[Over], fixed: &[&str]) -> Result<Vec<(usize, Vec<f64>)>, Diagnostics> {
        let (mut found, mut wrong) = (Vec::new(), Vec::new());
        for Over { name, range } in over {
            let Some(index) = self.index(name) else {
                wrong.push(self.unknown(name));
                continue;
            };
            if found.iter().any(|(other, _)| *other == index) {
                let message = format!("`{name}` stands in two ranges");
                wrong
                    .push(Diagnostic::error(message).help("leave out one --over, or name another parameter"));
            } else if fixed.contains(&name.as_str()) {
                let message = format!("`{name}` is fixed and has a range");
                wrong.push(Diagnostic::error(message).help("leave out its --set or its --over"));
            }
            wrong.extend(range.refusal(&format!("--over {name}")));
            // A range that was refused may have any number of values.
            let values = if wrong.is_empty() { range.values() } else { Vec::new() };
            found.push((index, values));
        }
        if wrong.is_empty() { Ok(found) } else { Err(Diagnostics(wrong)) }
    }

    /// The parameter of an index.
    pub(super) fn parameter(&self, index: usize) -> &GaitParameter {
        &self.gait.parameters[index]
    }

    /// Refuses speeds that are none.
    pub(super) fn check_speeds(&self, speeds: &[f64]) -> Result<(), Diagnostics> {
        let possible = |speed: &f64| *speed > 0.0 && *speed <= magnitude::LARGEST;
        let help = format!("write a speed at mid-stance above 0, in {}/s", self.gait.phase.unit);
        if speeds.is_empty() {
            return Err(Diagnostic::error("no speed is given").help(help).into());
        }
        let refuse =
            |speed: &f64| Diagnostic::error(format!("a speed of {speed} is not possible")).help(help.clone());
        let wrong: Vec<Diagnostic> = speeds.iter().filter(|speed| !possible(speed)).map(refuse).collect();
        if wrong.is_empty() { Ok(()) } else { Err(Diagnostics(wrong)) }
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
