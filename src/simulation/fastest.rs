//! How near the joints of a walk come to the velocity limits of the URDF, which no simulation keeps.
use super::walking::figure;
use bipedc_analysis::simulate::phases::Fastest;
use bipedc_analysis::simulate::{Plant, Sample};
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;

/// The joint that was nearest to its velocity limit, or farthest beyond it, in a walk; in time stepping at rows of the log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FastestJoint {
    /// As in the URDF.
    pub joint: String,
    /// s
    pub time: f64,
    /// Without its sign, rad/s or m/s.
    pub speed: f64,
    /// Of the URDF, rad/s or m/s.
    pub limit: f64,
    /// `limit` less `speed`; negative: beyond it.
    pub margin: f64,
    /// Of all three.
    #[serde(skip)]
    pub unit: &'static str,
}

/// Looks at every row of time stepping.
pub(super) struct FastestWatch<'p> {
    plant: &'p Plant,
    found: Option<Fastest>,
}

impl<'p> FastestWatch<'p> {
    pub fn new(plant: &'p Plant) -> Self {
        Self { plant, found: None }
    }

    pub fn see(&mut self, sample: &Sample) {
        Fastest::see(&mut self.found, &self.plant.velocity_limits, (sample.time, &sample.v));
    }

    /// None where no joint has a limit.
    pub fn end(self) -> Option<FastestJoint> {
        FastestJoint::new(self.plant, self.found?)
    }
}

impl FastestJoint {
    /// None where the joint has no limit.
    pub(super) fn new(plant: &Plant, found: Fastest) -> Option<Self> {
        let Fastest { joint, time, speed, margin } = found;
        let limit = *plant.velocity_limits.get(joint)?;
        let of = &plant.layout.joints[joint];
        let unit = if of.prismatic { "m/s" } else { "rad/s" };
        Some(Self { joint: of.name.clone(), time, speed, limit: limit?, margin, unit })
    }

    /// For people, a line.
    pub(super) fn text(&self) -> String {
        let Self { joint, time, limit, margin, unit, .. } = self;
        format!(
            "velocity margin {} {unit}: `{joint}` at {time:.4} s, limit {limit} {unit}\n",
            figure(*margin)
        )
    }

    /// Said of a joint that was faster than its limit.
    pub(super) fn warning(&self) -> Option<Diagnostic> {
        let Self { joint, time, speed, limit, margin, unit } = self;
        let message = format!(
            "`{joint}` moves at {} {unit} at {time:.4} s, faster than its limit of {limit} {unit} in the URDF",
            figure(*speed)
        );
        let help = "the simulation does not keep velocity limits, a drive may; walk more slowly, or correct <limit velocity>";
        (*margin < 0.0).then(|| Diagnostic::warning(message).help(help))
    }
}
