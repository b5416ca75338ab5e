//! The result of a comparison, for people and for programs.
use crate::measure::Missing;
use crate::number::{four_decimals, worst_first};
use bipedc_effects::diagnostic::Diagnostic;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
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
    /// `rms` / root mean square of the logged effort; `None` (JSON: null) if that is zero, and
    /// for heights of soles, which measure nothing.
    pub relative: Option<f64>,
    /// How many samples count.
    pub samples: usize,
    /// Estimated noise of the measurement as the residual has it, one standard deviation, unit of `rms`.
    pub noise: f64,
    /// As `rms`, without the samples at which the joint sticks, where dry friction may be anything within its bounds. Absent where it never
    /// sticks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_moving: Option<f64>,
    /// Part of the samples at which the joint sticks; absent where it never does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sticking: Option<f64>,
    /// As `rms`, where nothing jumps by the description's effects (friction and play that turn about, limits) and the joint does not stick.
    /// Absent where nothing does, or too few samples are left.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub away_from_jumps: Option<f64>,
    /// What kind of quantity: `effort`, `base_force`, `base_moment`, `cop`, `transmission`, `post_impact_velocity`.
    pub kind: &'static str,
}

/// The total error of one kind of channels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KindError {
    /// Of `rms`; `mixed` if the channels differ.
    pub unit: String,
    /// Root mean square over all channels of the kind and all samples.
    pub rms: f64,
    /// The same without the samples at which joints stick; absent where none does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_moving: Option<f64>,
}

impl Channel {
    /// The error that is held against the noise: where the model says what the torque is, and the filter what the motion is.
    pub fn told(&self) -> f64 {
        self.away_from_jumps.unwrap_or_else(|| self.moving())
    }

    /// The error where the joint does not stick.
    pub fn moving(&self) -> f64 {
        self.rms_moving.unwrap_or(self.rms)
    }
}

/// The total error under one cut-off that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cutoff {
    /// Hz
    pub cutoff_hz: f64,
    /// As [`Comparison::rms`].
    pub rms: f64,
    /// Geometric mean of the channels' root mean squares: one channel that the model explains badly does not
    /// choose the filter of all others.
    pub geometric_mean: f64,
}

/// What a model predicts against what was logged. Its JSON keys are its field names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// One per joint with an effort, in the order of the model.
    pub channels: Vec<Channel>,
    /// By kind of channel.
    pub kinds: BTreeMap<&'static str, KindError>,
    /// Root mean square over all channels and samples of the kind that the table is about: velocities after impacts,
    /// else centres of pressure of postures, else efforts, else forces on the base.
    pub rms: f64,
    /// What samples run over: `time`, `posture` or `impact`.
    pub abscissa: &'static str,
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
        self.write_table(f)?;
        writeln!(f)?;
        let (from, to, samples) = (self.from_s, self.to_s, self.samples);
        if self.cutoff_hz > 0.0 {
            let tried: Vec<_> = self.cutoffs.iter().map(|c| format!("{} Hz", c.cutoff_hz)).collect();
            let choice =
                if tried.len() > 1 { format!(", the best of {}", tried.join(", ")) } else { String::new() };
            writeln!(f, "filter: zero-phase 4th-order Butterworth, cut-off {} Hz{choice}", self.cutoff_hz)?;
        }
        if self.abscissa == "time" {
            writeln!(
                f,
                "samples: {samples} from {from:.3} s to {to:.3} s at {:.6} Hz; {} s left out at both ends",
                self.sampling_hz, self.trim_s
            )?;
        } else {
            writeln!(f, "samples: {samples}, {} {from} to {to}", self.abscissa)?;
        }
        for assumption in &self.assumptions {
            writeln!(f, "assumed: {assumption}")?;
        }
        for missing in &self.missing {
            writeln!(f, "not compared: {}: {}", missing.name, missing.reason)?;
        }
        Ok(())
    }
}

impl Comparison {
    /// The channels with the largest error first, those of one unit together.
    pub fn worst_first(&self) -> Vec<&Channel> {
        let mut channels: Vec<&Channel> = self.channels.iter().collect();
        worst_first(&mut channels, |channel| channel.unit.clone(), |channel| channel.rms);
        channels
    }

    fn write_table(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wide = |texts: &mut dyn Iterator<Item = usize>, least: usize| texts.fold(least, usize::max);
        let name = wide(&mut self.channels.iter().map(|c| c.name.chars().count()), 5);
        let unit = wide(&mut self.channels.iter().map(|c| c.unit.len()), self.unit.len());
        let what = if self.channels.iter().all(|c| c.kind == "effort") { "joint" } else { "row" };
        let sticks = self.channels.iter().any(|c| c.rms_moving.is_some());
        let heads = ["rms"].into_iter().chain(sticks.then_some("where free")).chain(["max", "noise"]);
        let column = (10 + unit).max(if sticks { 12 } else { 0 });
        let heads: String = heads.map(|head| format!("  {head:>column$}")).collect();
        writeln!(f, "{what:name$}{heads}  {:>10}  {:>8}", "relative", "samples")?;
        let number = |x: f64, own: &str| {
            format!("  {:>width$} {own:unit$}", four_decimals(x), width = column - unit - 1)
        };
        for c in self.worst_first() {
            let relative = c.relative.map_or_else(|| "-".to_owned(), |r| format!("{:.2} %", 100.0 * r));
            let numbers = [c.rms].into_iter().chain(sticks.then(|| c.moving())).chain([c.max, c.noise]);
            let numbers: String = numbers.map(|x| number(x, &c.unit)).collect();
            writeln!(f, "{:name$}{numbers}  {relative:>10}  {:>8}", c.name, c.samples)?;
        }
        let total = |title: &str, kind: &KindError| {
            let told = sticks.then(|| number(kind.rms_moving.unwrap_or(kind.rms), &kind.unit));
            format!("{title:name$}{}{}", number(kind.rms, &kind.unit), told.unwrap_or_default())
        };
        if self.kinds.len() <= 1 {
            let all = KindError { unit: self.unit.clone(), rms: self.rms, rms_moving: None };
            return writeln!(f, "{}", total("total", self.kinds.values().next().unwrap_or(&all)));
        }
        for (kind, sum) in &self.kinds {
            writeln!(f, "{}", total(&format!("all of {kind}"), sum))?;
        }
        Ok(())
    }
}
