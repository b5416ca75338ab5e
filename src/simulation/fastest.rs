//! How near the joints of a walk come to the velocity limits of the URDF, which no simulation keeps.
use super::walking::figure;
use bipedc_analysis::simulate::{Plant, Sample};
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;

/// The joint that was nearest to its velocity limit, or farthest beyond it, at a row of the log.
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

/// Looks at every row.
pub(super) struct FastestWatch<'p> {
    plant: &'p Plant,
    /// Joint by index, time and speed.
    found: Option<(usize, f64, f64)>,
    margin: f64,
}

impl<'p> FastestWatch<'p> {
    pub fn new(plant: &'p Plant) -> Self {
        Self { plant, found: None, margin: f64::INFINITY }
    }

    pub fn see(&mut self, sample: &Sample) {
        let limits = &self.plant.velocity_limits;
        let joints = &sample.v[sample.v.len().saturating_sub(limits.len())..];
        for (joint, (limit, v)) in limits.iter().zip(joints).enumerate() {
            if let Some(limit) = limit.filter(|limit| limit - v.abs() < self.margin) {
                (self.found, self.margin) = (Some((joint, sample.time, v.abs())), limit - v.abs());
            }
        }
    }

    /// None where no joint has a limit.
    pub fn end(self) -> Option<FastestJoint> {
        let (joint, time, speed) = self.found?;
        let limit = self.plant.velocity_limits[joint]?;
        let of = &self.plant.layout.joints[joint];
        let unit = if of.prismatic { "m/s" } else { "rad/s" };
        Some(FastestJoint { joint: of.name.clone(), time, speed, limit, margin: limit - speed, unit })
    }
}

impl FastestJoint {
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
