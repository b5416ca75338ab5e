//! The result of a comparison, for people and for programs.
use crate::diagnostic::Diagnostic;
use serde::{Serialize, Serializer};
use std::fmt;

/// The error of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channel {
    /// Of the joint.
    pub name: String,
    /// Of `rms` and `max`: `N m` or `N`.
    pub unit: String,
    /// Root mean square of logged minus predicted effort.
    pub rms: f64,
    /// Largest absolute value of it.
    pub max: f64,
    /// `rms` / root mean square of the logged effort; `None` (JSON: null) if that is zero.
    pub relative: Option<f64>,
    /// How many samples count.
    pub samples: usize,
}

/// The total error under one cut-off that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cutoff {
    /// Hz
    pub cutoff_hz: f64,
    /// As [`Comparison::rms`].
    pub rms: f64,
}

/// A joint that could not be compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Of the joint.
    pub name: String,
    /// Such as the column that is not there.
    pub reason: String,
}

/// What a model predicts against what was logged. Its JSON keys are its field names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// One per joint with an effort, in the order of the model.
    pub channels: Vec<Channel>,
    /// Root mean square over all channels and samples.
    pub rms: f64,
    /// Of `rms`: that of the channels, `mixed` if they differ.
    pub unit: String,
    /// Of the filter in use, Hz.
    pub cutoff_hz: f64,
    /// All cut-offs that were tried.
    pub cutoffs: Vec<Cutoff>,
    /// Left out at both ends of the log and on both sides of gaps, s.
    pub trim_s: f64,
    /// Times (log's clock, s) of the first and last sample that count.
    pub from_s: f64,
    /// See `from_s`.
    pub to_s: f64,
    /// Samples that count; a sample has a value in every channel.
    pub samples: usize,
    /// Hz, one over the median step.
    pub sampling_hz: f64,
    /// Stretches of the log without gaps.
    pub segments: usize,
    /// What could not be compared and why.
    pub missing: Vec<Missing>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// As texts in JSON.
    #[serde(serialize_with = "as_texts")]
    pub warnings: Vec<Diagnostic>,
}

fn as_texts<S: Serializer>(warnings: &[Diagnostic], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(warnings.iter().map(Diagnostic::to_string))
}

impl fmt::Display for Comparison {
    /// A table, then what it rests on. Warnings are not part of it: they belong on the error stream.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wide = |texts: &mut dyn Iterator<Item = usize>, least: usize| texts.fold(least, usize::max);
        let name = wide(&mut self.channels.iter().map(|c| c.name.chars().count()), 5);
        let unit = wide(&mut self.channels.iter().map(|c| c.unit.len()), self.unit.len());
        let column = 10 + unit;
        writeln!(
            f,
            "{:name$}  {:>column$}  {:>column$}  {:>10}  {:>8}",
            "joint", "rms", "max", "relative", "samples"
        )?;
        for c in &self.channels {
            let relative = c.relative.map_or_else(|| "-".to_owned(), |r| format!("{:.2} %", 100.0 * r));
            writeln!(
                f,
                "{:name$}  {:>9.4} {:unit$}  {:>9.4} {:unit$}  {relative:>10}  {:>8}",
                c.name, c.rms, c.unit, c.max, c.unit, c.samples
            )?;
        }
        writeln!(f, "{:name$}  {:>9.4} {:unit$}", "total", self.rms, self.unit)?;
        writeln!(f)?;
        let tried: Vec<_> = self.cutoffs.iter().map(|c| format!("{} Hz", c.cutoff_hz)).collect();
        let choice =
            if tried.len() > 1 { format!(", the best of {}", tried.join(", ")) } else { String::new() };
        writeln!(f, "filter: zero-phase 4th-order Butterworth, cut-off {} Hz{choice}", self.cutoff_hz)?;
        writeln!(
            f,
            "samples: {} from {:.3} s to {:.3} s at {:.6} Hz; {} s left out at both ends",
            self.samples, self.from_s, self.to_s, self.sampling_hz, self.trim_s
        )?;
        for assumption in &self.assumptions {
            writeln!(f, "assumed: {assumption}")?;
        }
        for missing in &self.missing {
            writeln!(f, "not compared: {}: {}", missing.name, missing.reason)?;
        }
        Ok(())
    }
}
