//! Effects that turn the world or shift joint zeros, gathered from a list.
use crate::robot::JointLayout;
use crate::robot::calls::joint;
use bipedc_effects::effect::{Acts, Effect, Law};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// What a list of effects does to the kinematics.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct World {
    /// Logged minus true position by joint, rad; empty if all are zero.
    pub offsets: Vec<f64>,
    /// True orientation of the base = tilt · logged one.
    pub tilt: Matrix3<f64>,
    /// The ground's axes.
    pub slope: Matrix3<f64>,
}

/// `R_y(pitch) R_x(roll)` of an effect.
fn turn(effect: &Effect) -> Matrix3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle).into_inner();
    about(Vector3::y(), effect.value("pitch")) * about(Vector3::x(), effect.value("roll"))
}

impl World {
    /// Effects of one kind add up (offsets) or follow one another (turns).
    pub fn of(effects: &[Effect], layout: &JointLayout) -> Self {
        let mut world = Self { offsets: Vec::new(), tilt: Matrix3::identity(), slope: Matrix3::identity() };
        for effect in effects {
            match effect.kind.law {
                Law::EncoderOffset => {
                    if let Some(index) = joint(layout, effect.location.joint.as_deref()) {
                        world.offsets.resize(layout.joints.len(), 0.0);
                        world.offsets[index] += effect.value("offset");
                    }
                }
                Law::GravityTilt => world.tilt = turn(effect) * world.tilt,
                Law::GroundSlope => world.slope = turn(effect) * world.slope,
                law => debug_assert!(!matches!(law.acts(), Acts::Position | Acts::Gravity)),
            }
        }
        world
    }

    /// Logged to true joint positions, in place; `joints` are the last elements of `q`.
    pub fn correct(&self, q: &mut [f64]) {
        let first = q.len() - self.offsets.len();
        for (q, offset) in q[first..].iter_mut().zip(&self.offsets) {
            *q -= offset;
        }
    }
}

/// Whether a sensor of this foot and corner is meant; `None` means all, `foot` all of that foot.
pub(crate) fn is_meant(sensor: Option<&str>, foot: &str, corner: Option<&str>) -> bool {
    let Some(sensor) = sensor else { return true };
    match sensor.strip_prefix(foot) {
        Some("") => true,
        Some(rest) => corner.is_some() && rest.strip_prefix('/') == corner,
        None => false,
    }
}
