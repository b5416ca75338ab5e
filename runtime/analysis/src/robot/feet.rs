//! Feet and the functions of a model that tell where they are.
use crate::robot::calls::ModelCalls;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::feet::{ContactPoint, Side};
use nalgebra::{Matrix3, Vector3};

/// A foot as the measurements know it.
#[derive(Debug, Clone, PartialEq)]
pub struct Foot {
    /// As in columns and descriptions: `right_foot`.
    pub name: String,
    /// The link's part of the model's function names: `left_tibia` for `position_of_left_tibia`.
    pub frame: String,
    /// Of the body.
    pub side: Option<Side>,
    /// Its contact points, the corners of its sole.
    pub corners: Vec<ContactPoint>,
}

impl Foot {
    /// Origin of the sole frame in the link frame: straight below the link's origin, in the plane of the corners; its
    /// axes are those of the link.
    pub fn sole(&self) -> Vector3<f64> {
        let count = self.corners.len().max(1) as f64;
        Vector3::new(0.0, 0.0, self.corners.iter().map(|c| c.position[2]).sum::<f64>() / count)
    }

    /// A corner in the sole frame, m.
    pub fn corner(&self, index: usize) -> Vector3<f64> {
        Vector3::from(self.corners[index].position) - self.sole()
    }

    /// Whether the sole has an extent, so that it can carry a moment: along x for planar robots, along x and y else.
    pub fn is_flat(&self, planar: bool) -> bool {
        let spread = |axis: usize| {
            let of = |pick: fn(f64, f64) -> f64| {
                self.corners.iter().map(|c| c.position[axis]).reduce(pick).unwrap_or(0.0)
            };
            of(f64::max) - of(f64::min) > 1e-3
        };
        spread(0) && (planar || spread(1))
    }

    /// Mean of the corners in the sole frame, m.
    pub fn center(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = (0..self.corners.len()).map(|i| self.corner(i)).sum();
        sum / self.corners.len().max(1) as f64
    }
}

/// The foot of this name; without a name the right one, with a sentence that says so.
///
/// # Errors
/// The robot has no such foot.
pub fn choose(feet: &[Foot], name: Option<&str>, role: &str) -> Result<(usize, Option<String>), Diagnostic> {
    let known = || bipedc_effects::diagnostic::list(feet.iter().map(|f| f.name.as_str()), 8);
    if let Some(name) = name {
        return match feet.iter().position(|foot| foot.name == name) {
            Some(index) => Ok((index, None)),
            None => Err(Diagnostic::error(format!("the robot has no foot `{name}`"))
                .help(format!("feet of the robot: {}", known()))),
        };
    }
    let right = feet.iter().position(|f| f.side == Some(Side::Right));
    match right.or(if feet.len() == 1 { Some(0) } else { None }) {
        Some(index) => {
            let said = format!("the {role} foot is taken to be `{}`: none was named", feet[index].name);
            Ok((index, Some(said)))
        }
        None => Err(Diagnostic::error(format!("which foot is the {role} foot?"))
            .help(format!("name one of {}", known()))),
    }
}

/// Functions about the link of a foot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FootCalls {
    position: usize,
    rotation: usize,
    jacobian: usize,
}

/// Where a foot's sole is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sole {
    /// Origin of the sole frame, m.
    pub origin: Vector3<f64>,
    /// Its axes.
    pub rotation: Matrix3<f64>,
    /// From the link's origin to that of the sole, world axes, m.
    pub below: Vector3<f64>,
}

impl FootCalls {
    /// Looks the functions up.
    pub fn new(calls: &ModelCalls<'_>, foot: &Foot) -> Result<Self, Diagnostic> {
        let find = |what: &str| calls.find(&format!("{what}_of_{}", foot.frame));
        Ok(Self { position: find("position")?, rotation: find("rotation")?, jacobian: find("jacobian")? })
    }

    /// Pose of the sole at a configuration.
    pub fn sole(&self, calls: &ModelCalls<'_>, foot: &Foot, q: &[f64]) -> Sole {
        let (mut position, mut rotation) = ([0.0; 3], [0.0; 9]);
        calls.at(self.position, q, &mut position);
        calls.at(self.rotation, q, &mut rotation);
        let rotation = Matrix3::from_column_slice(&rotation);
        let below = rotation * foot.sole();
        Sole { origin: Vector3::from(position) + below, rotation, below }
    }

    /// Jacobian of the link's origin, 6 × nv, linear rows first, world axes; column after column.
    pub fn jacobian(&self, calls: &ModelCalls<'_>, q: &[f64], out: &mut Vec<f64>) {
        out.resize(6 * calls.nv, 0.0);
        calls.at(self.jacobian, q, out);
    }
}
