//! The moment of the ground on a foot about its sole's origin: what a sensor of six components says beside the force.
use super::plant::Plant;
use bipedc_runtime::model::{Argument, Model, State};
use nalgebra::{Matrix3, Vector3};

/// How the soles are turned.
pub(super) struct SoleAxes<'a> {
    model: &'a dyn Model<f64>,
    /// By foot.
    rotations: Vec<usize>,
}

impl<'a> SoleAxes<'a> {
    /// `None`: the model does not tell it of every foot.
    pub fn new(model: &'a dyn Model<f64>, plant: &Plant) -> Option<Self> {
        let rotation = |frame: &str| model.function(&format!("rotation_of_{frame}"));
        let rotations = plant.feet.iter().map(|foot| rotation(&foot.frame)).collect::<Option<Vec<_>>>()?;
        Some(Self { model, rotations })
    }

    /// By foot, column after column, in the axes of the model's world.
    pub fn at(&self, q: &[f64], out: &mut Vec<[f64; 9]>) {
        out.resize(self.rotations.len(), [0.0; 9]);
        let state = State::new().with(Argument::Q, q);
        for (rotation, own) in self.rotations.iter().zip(out) {
            // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
            if self.model.evaluate(*rotation, &state, own).is_err() {
                own.fill(f64::NAN);
            }
        }
    }
}

/// Force and moment in the same axes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Wrench {
    /// N
    pub force: [f64; 3],
    /// N m
    pub moment: [f64; 3],
}

/// A place of the sole frame from that frame's origin, in the world's axes.
pub(super) fn lever(axes: &[f64; 9], place: [f64; 3]) -> [f64; 3] {
    (Matrix3::from_column_slice(axes) * Vector3::from(place)).into()
}

/// Moment of a force at a place of the sole frame about that frame's origin, world axes.
pub(super) fn moment(axes: &[f64; 9], place: Vector3<f64>, force: [f64; 3]) -> [f64; 3] {
    Vector3::from(lever(axes, place.into())).cross(&Vector3::from(force)).into()
}
