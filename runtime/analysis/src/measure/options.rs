//! How a log is read and filtered.

/// Cut-offs that are tried if none is given, Hz. Slow ones are for slow motions and coarse encoders, whose accelerations are noise above.
pub const CANDIDATES: [f64; 8] = [4.0, 6.3, 10.0, 16.0, 25.0, 40.0, 60.0, 90.0];

/// Those at which a diagnosis begins, Hz: a slower filter takes motion away, which looks like rotors and gains until more is known.
pub const FIRST: [f64; 6] = [10.0, 16.0, 25.0, 40.0, 60.0, 90.0];

/// Where velocities come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VelocitySource {
    /// Filtered positions, differentiated: logged velocities are often late and noisy.
    #[default]
    Positions,
    /// Logged velocities, filtered; accelerations are their derivative. Joints without a velocity column fall
    /// back to positions, with a warning.
    Logged,
}

/// How to compare.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Cut-off of the filter, Hz; `None`: the one of `candidates` at which errors are smallest, as the geometric mean
    /// over the joints: one joint of which much is unknown must not choose for all.
    pub cutoff_hz: Option<f64>,
    /// Tried if `cutoff_hz` is not given, Hz.
    pub candidates: Vec<f64>,
    /// Left out of the error at both ends of the log and on both sides of gaps, s.
    pub trim_s: f64,
    /// Samples before this time (of the log's own clock, s) do not count.
    pub from_s: Option<f64>,
    /// Samples after this time do not count.
    pub to_s: Option<f64>,
    /// For the joints.
    pub velocity: VelocitySource,
    /// Logs of robots on their feet are filtered from impact to impact.
    pub cut_at_impacts: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            cutoff_hz: None,
            candidates: CANDIDATES.to_vec(),
            trim_s: 0.5,
            from_s: None,
            to_s: None,
            velocity: VelocitySource::Positions,
            cut_at_impacts: true,
        }
    }
}
