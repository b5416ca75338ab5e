//! What identification answers; the keys of `identify --json` (docs/identification.md explains them).
use super::estimate::{HeldOutError, Method};
use super::motions::Repetition;
use super::physical::{Certificate, Consistency, TriedWeight};
use serde::Serialize;

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    /// Estimator.
    pub method: Method,
    /// Logs that taught.
    pub logs: Vec<LogSummary>,
    /// Rows of the regression.
    pub rows: usize,
    /// Cut-off of the signals' filter that was asked for, Hz; none: it was chosen ([`LogSummary::cutoff_hz`]).
    pub cutoff_hz: Option<f64>,
    /// Cut-off of the low-pass that regressor and torque pass together, Hz; none: they pass none.
    pub rows_hz: Option<f64>,
    /// Motions that were seen more than once.
    pub repetitions: Vec<Repetition>,
    /// Number of different motions.
    pub different_motions: usize,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// What is odd.
    pub warnings: Vec<String>,
    /// Largest over smallest singular value (5.9), columns scaled to length 1.
    pub condition_number: f64,
    /// Singular values, descending, columns scaled to length 1.
    pub singular_values: Vec<f64>,
    /// Estimates.
    pub parameters: Vec<Parameter>,
    /// Unknowns that the data do not tell: they have no estimate.
    pub unseen: Vec<String>,
    /// Pairs that the data can hardly tell apart.
    pub pairs: Vec<Pair>,
    /// The fewest parameters that predict as well.
    pub essential: EssentialSummary,
    /// Errors by channel.
    pub channels: Vec<ChannelSummary>,
    /// Parameters that bodies can have.
    pub physical: PhysicalSummary,
    /// Errors on a log that did not teach.
    pub validation: Option<Validation>,
}

/// A log that was read.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogSummary {
    /// Its path.
    pub file: String,
    /// FNV-1a of its bytes, 16 hex digits; whoever opened it fills it in.
    pub hash: String,
    /// Usable samples.
    pub samples: usize,
    /// s
    pub step: f64,
    /// Hz
    pub cutoff_hz: f64,
}

/// One estimate with its error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// The sum that is estimated, or the extra.
    pub name: String,
    /// Unit of all numbers.
    pub unit: &'static str,
    /// Estimate.
    pub value: f64,
    /// One standard deviation, correlation of residuals in time taken into account.
    pub standard_error: f64,
    /// As if residuals were independent (8.2, 8.3), for comparison.
    pub independent_error: f64,
    /// `standard_error` over |value|, per cent (8.2); absent where the value is zero.
    pub relative_error_percent: Option<f64>,
    /// 95 % confidence interval.
    pub interval: [f64; 2],
    /// Value for the parameters of the description.
    pub nominal: f64,
    /// Whether the relative error is below 15 %.
    pub well_identified: bool,
    /// Whether it is among the essential parameters.
    pub essential: bool,
}

/// Two estimates that mirror each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// Names.
    pub parameters: [String; 2],
    /// (8.4)
    pub correlation: f64,
}

/// The fewest parameters that predict as well.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EssentialSummary {
    /// Names.
    pub parameters: Vec<String>,
    /// |error| / |measured| on held-out folds with these.
    pub held_out: f64,
    /// The same with all.
    pub held_out_of_all: f64,
}

/// Errors of a channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelSummary {
    /// Joint, or row of the base.
    pub name: String,
    /// N m or N.
    pub unit: &'static str,
    /// Rows that counted.
    pub rows: usize,
    /// Rows left out because its joint, whose dry friction is estimated, rests there or next to there.
    pub resting: usize,
    /// Root mean square of what was measured.
    pub measured: f64,
    /// Root mean square error of the description.
    pub description: f64,
    /// Of least squares on the data that taught.
    pub least_squares: f64,
    /// Of least squares on held-out folds.
    pub held_out: f64,
    /// Of the physically possible parameters on the data that taught.
    pub physical: f64,
}

/// Parameters that bodies can have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhysicalSummary {
    /// Weight of CAD.
    pub weight: f64,
    /// Whether it was chosen by folds.
    pub chosen: bool,
    /// Weights that were tried.
    pub trials: Vec<TriedWeight>,
    /// Proof of optimality.
    pub certificate: Certificate,
    /// All links with mass that move.
    pub links: Vec<LinkSummary>,
    /// What joints add.
    pub extras: Vec<ExtraSummary>,
    /// Whether every link passed the independent check.
    pub consistent: bool,
}

/// A value with one standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Value {
    /// Estimate.
    pub value: f64,
    /// One standard deviation.
    pub standard_error: f64,
}

/// A link's parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinkSummary {
    /// URDF name.
    pub name: String,
    /// kg
    pub mass: Value,
    /// In the link frame, m.
    pub center: [Value; 3],
    /// xx, xy, xz, yy, yz, zz about the centre of mass, link axes, kg m².
    pub inertia: [Value; 6],
    /// Mass in the description, kg.
    pub nominal_mass: f64,
    /// The independent check.
    pub check: Consistency,
}

/// What a joint adds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExtraSummary {
    /// Such as `left_knee.coulomb_friction`.
    pub name: String,
    /// Unit of both numbers.
    pub unit: &'static str,
    /// Estimate and error.
    #[serde(flatten)]
    pub value: Value,
}

/// Errors on a log that did not teach.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Validation {
    /// Its path.
    pub file: String,
    /// FNV-1a of its bytes, as of the logs that taught.
    pub hash: String,
    /// Usable samples.
    pub samples: usize,
    /// Whether it shows a motion of the logs that taught.
    pub shares_motion: bool,
    /// By channel.
    pub channels: Vec<ValidationChannel>,
    /// |error| / |measured| over all channels.
    pub total: Models,
}

/// One channel of a validation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ValidationChannel {
    /// Joint, or row of the base.
    pub name: String,
    /// N m or N.
    pub unit: &'static str,
    /// Root mean square of what was measured.
    pub measured: f64,
    /// Root mean square errors.
    pub rms: Models,
}

/// One number per model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Models {
    /// Rigid bodies as described, without friction.
    pub description: f64,
    /// All base parameters.
    pub least_squares: f64,
    /// The essential ones.
    pub essential: f64,
    /// Physically possible.
    pub physical: f64,
}

impl Models {
    /// The numbers of the four models, in that order.
    pub fn of(held: [HeldOutError; 4], number: impl Fn(&HeldOutError) -> f64) -> Self {
        let [description, least_squares, essential, physical] = held.each_ref().map(number);
        Self { description, least_squares, essential, physical }
    }
}
