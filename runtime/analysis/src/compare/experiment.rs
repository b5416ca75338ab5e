//! Comparisons of measurements of any kind, by way of their experiments.
use super::report::{Channel, Comparison, Cutoff, KindError};
use super::statistics::geometric_mean;
use crate::experiments::Experiment;
use crate::experiments::jumps::Jumps;
use crate::experiments::moving::moving;
use crate::experiments::noise::noise_of;
use crate::measure::Missing;
use bipedc_effects::diagnostic::Diagnostic;
use std::collections::BTreeMap;

/// Kinds of channels, those that a table is about first.
const KINDS: [&str; 6] =
    ["post_impact_velocity", "cop", "effort", "base_force", "base_moment", "transmission"];

/// Motors' angles against those of their joints: they stand beside torques, and choose no filter.
const TRANSMISSION: &str = "transmission";

/// How a file was read.
#[derive(Debug, Clone, Default)]
pub struct Reading {
    /// What samples run over: `time`, `posture` or `impact`.
    pub abscissa: &'static str,
    /// Hz; 0 for tables.
    pub cutoff_hz: f64,
    /// Left out at both ends, s.
    pub trim_s: f64,
    /// What could not be compared and why.
    pub missing: Vec<Missing>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// What is odd about the file.
    pub warnings: Vec<Diagnostic>,
}

/// One channel per row of an experiment.
pub fn channels_of(experiment: &dyn Experiment) -> Vec<Channel> {
    let rows = experiment.rows().iter().enumerate();
    let jumps = Jumps::of(experiment, &[]);
    let channel = |(index, row): (usize, &crate::experiments::Row)| {
        let residual = experiment.residual(index);
        let rms =
            |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt();
        let measured = experiment.measured(index).map(|values| rms(&values)).filter(|size| *size > 0.0);
        let moving = moving(experiment, index, residual, &|_, _| true);
        Channel {
            name: row.name.clone(),
            unit: row.unit.to_owned(),
            rms: rms(residual),
            max: residual.iter().fold(0.0, |max, r| max.max(r.abs())),
            // A sole on the ground measures a height of nothing.
            relative: measured
                .filter(|_| row.channel != crate::experiments::Channel::Sole)
                .map(|size| rms(residual) / size),
            samples: residual.len(),
            noise: noise_of(experiment, index, residual),
            rms_moving: moving.map(|moving| moving.rms()),
            sticking: moving.map(|moving| moving.sticking),
            away_from_jumps: jumps.away(experiment, index, residual, &|_, _| true),
            kind: row.channel.name(),
        }
    };
    rows.map(channel).collect()
}

/// Errors over all channels of a kind.
pub(super) fn by_kind(channels: &[Channel]) -> BTreeMap<&'static str, KindError> {
    let mut kinds: BTreeMap<&'static str, KindError> = BTreeMap::new();
    for channel in channels {
        let new = || KindError { unit: channel.unit.clone(), rms: 0.0, rms_moving: None };
        let kind = kinds.entry(channel.kind).or_insert_with(new);
        if kind.unit != channel.unit {
            "mixed".clone_into(&mut kind.unit);
        }
    }
    for (name, kind) in &mut kinds {
        let own = || channels.iter().filter(|c| c.kind == *name);
        let squares: f64 = own().map(|c| c.rms * c.rms * c.samples as f64).sum();
        kind.rms = (squares / own().map(|c| c.samples).sum::<usize>().max(1) as f64).sqrt();
        let told = |c: &Channel| c.samples as f64 * (1.0 - c.sticking.unwrap_or(0.0));
        let squares: f64 = own().map(|c| c.moving().powi(2) * told(c)).sum();
        let moving = (squares / own().map(told).sum::<f64>().max(f64::MIN_POSITIVE)).sqrt();
        kind.rms_moving = own().any(|c| c.rms_moving.is_some()).then_some(moving);
    }
    kinds
}

/// The kind that a table is about: `cop` of postures, but the efforts of a log where both are.
fn main_kind(kinds: &BTreeMap<&'static str, KindError>, abscissa: &str) -> KindError {
    let mut order = KINDS;
    if abscissa == "time" {
        order.swap(1, 2);
    }
    let first = order.iter().find_map(|name| kinds.get(name)).cloned();
    first.unwrap_or(KindError { unit: String::new(), rms: 0.0, rms_moving: None })
}

impl Comparison {
    /// The errors of an experiment's rows.
    pub fn of_experiment(experiment: &dyn Experiment, reading: Reading) -> Self {
        let channels = channels_of(experiment);
        let kinds = by_kind(&channels);
        let main = main_kind(&kinds, reading.abscissa);
        let time = experiment.time();
        let (from_s, to_s) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
        let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_unstable_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().filter(|s| *s > 0.0 && reading.abscissa == "time");
        Self {
            channels,
            kinds,
            rms: main.rms,
            abscissa: reading.abscissa,
            unit: main.unit,
            cutoff_hz: reading.cutoff_hz,
            cutoffs: Vec::new(),
            trim_s: reading.trim_s,
            from_s,
            to_s,
            samples: time.len(),
            sampling_hz: step.map_or(0.0, |step| 1.0 / step),
            segments: 1 + steps
                .iter()
                .rev()
                .take_while(|s| step.is_some_and(|step| **s > 3.0 * step))
                .count(),
            missing: reading.missing,
            assumptions: reading.assumptions,
            warnings: reading.warnings,
        }
    }

    /// Takes what an experiment at the same cut-off says of where joints stick, lie at their stops and effects jump, and of channels that are no
    /// torques: motors' angles. What is left at a stop is the stop's torque, and no error. Channels are known by their names.
    pub fn without_sticking(&mut self, experiment: &dyn Experiment) {
        for told in channels_of(experiment) {
            let is_motor_of_ours = self.has_joint_of(&told);
            match self.channels.iter_mut().find(|c| c.name == told.name && c.kind == told.kind) {
                Some(own) => {
                    (own.rms_moving, own.sticking) = (told.rms_moving, told.sticking);
                    (own.away_from_jumps, own.noise) = (told.away_from_jumps, told.noise);
                    if told.rms_moving.is_some() {
                        (own.rms, own.max, own.relative) = (told.rms, told.max, told.relative);
                    }
                }
                None if is_motor_of_ours => self.channels.push(told),
                None => {}
            }
        }
        self.kinds = by_kind(&self.channels);
        self.rms = main_kind(&self.kinds, self.abscissa).rms;
    }

    /// Leaves efforts out that an experiment at the same cut-off holds against no model, with its reasons.
    pub fn leave_out(&mut self, missing: &[Missing]) {
        for joint in missing {
            let before = self.channels.len();
            self.channels.retain(|channel| channel.kind != "effort" || channel.name != joint.name);
            if self.channels.len() < before {
                self.missing.push(joint.clone());
            }
        }
        self.kinds = by_kind(&self.channels);
        self.rms = main_kind(&self.kinds, self.abscissa).rms;
    }

    /// Whether a channel is the motor's angle of a joint whose torque is compared.
    fn has_joint_of(&self, told: &Channel) -> bool {
        let joint = told.name.strip_suffix("/motor_position").filter(|_| told.kind == TRANSMISSION);
        joint.is_some_and(|joint| self.channels.iter().any(|c| c.kind == "effort" && c.name == joint))
    }

    /// Puts errors in the place of those found so far that were computed another way, by cut-off; channels are known
    /// by their names, and the cut-off stands at which the geometric mean of the torques' errors is smallest.
    pub fn judged_again(&mut self, by_cutoff: Vec<(f64, Vec<Channel>)>) {
        let own: Vec<&str> = self.channels.iter().map(|c| c.name.as_str()).collect();
        let mut best: Option<(f64, f64, Vec<Channel>)> = None;
        let mut cutoffs = Vec::new();
        for (cutoff_hz, mut channels) in by_cutoff {
            channels.retain(|c| own.contains(&c.name.as_str()) || self.has_joint_of(c));
            let rms = by_kind(&channels).get("effort").map_or(0.0, |kind| kind.rms);
            let torques = channels.iter().filter(|c| c.kind != TRANSMISSION);
            let geometric_mean = geometric_mean(torques.map(|c| c.rms));
            cutoffs.push(Cutoff { cutoff_hz, rms, geometric_mean });
            if best.as_ref().is_none_or(|(least, ..)| geometric_mean < *least) {
                best = Some((geometric_mean, cutoff_hz, channels));
            }
        }
        if let Some((_, cutoff_hz, channels)) = best {
            self.kinds = by_kind(&channels);
            let rms = self.kinds.get("effort").map_or(0.0, |kind| kind.rms);
            (self.cutoff_hz, self.rms, self.channels, self.cutoffs) = (cutoff_hz, rms, channels, cutoffs);
        }
    }
}
