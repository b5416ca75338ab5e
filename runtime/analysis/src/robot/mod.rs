//! The robot as measurements know it: joints, feet, base, link inertias, and the calls of its model.
pub(crate) mod calls;
mod dynamics;
pub(crate) mod feet;
pub mod inertial_parameters;
mod influence;
mod joints;
pub mod link_inertias;
mod trajectory;
pub(crate) mod world;

pub use bipedc_effects::base::BaseKind;
pub use bipedc_effects::feet::{ContactPoint, Side};
pub use calls::AnyModel;
pub use dynamics::{Batch, EvaluationError, InverseDynamics, ModelTorques};
pub use feet::Foot;
pub use inertial_parameters::InertialParameters;
pub(crate) use influence::depends_on;
pub use joints::{Joint, JointLayout};
pub use link_inertias::LinkInertias;
pub use trajectory::Trajectory;
pub(crate) use trajectory::coordinate;

use bipedc_effects::effect::{Effect, Location};

/// A robot: its functions, and the names and places behind them.
#[derive(Clone, Copy)]
pub struct Robot<'a> {
    /// Functions are looked up by name, so emitted code and programs in process serve alike.
    pub model: AnyModel<'a>,
    /// Joints in the order of `v`, and the base before them.
    pub layout: &'a JointLayout,
    /// Links behind the inertial parameters.
    pub link_inertias: &'a LinkInertias,
    /// With their corners.
    pub feet: &'a [Foot],
    /// Effects that the description has already: part of the nominal prediction.
    pub effects: &'a [Effect],
}

impl Robot<'_> {
    /// Whether it moves in the x-z plane only.
    pub(crate) fn planar(&self) -> bool {
        self.layout.base == BaseKind::Planar
    }

    /// Places of an effect on links: main links of the bodies that have mass and that `shows` accepts (by index).
    pub(crate) fn link_places(&self, shows: impl Fn(usize) -> bool) -> Vec<Location> {
        let bodies = self.link_inertias.bodies.iter().enumerate();
        let massive = |body: usize| self.link_inertias.links.iter().any(|l| l.body == body && l.mass > 0.0);
        bodies.filter(|(b, _)| massive(*b) && shows(*b)).map(|(_, name)| Location::link(name)).collect()
    }

    /// The effects of the description and further ones.
    pub(crate) fn with(&self, effects: &[Effect]) -> Vec<Effect> {
        self.effects.iter().chain(effects).cloned().collect()
    }

    /// One signal per joint: the last columns of `values`, `samples × width`.
    pub(crate) fn joint_signals(
        &self,
        quantity: &str,
        values: &[f64],
        width: usize,
    ) -> Vec<(String, Vec<f64>)> {
        let first = width - self.layout.joints.len();
        let joints = self.layout.joints.iter().enumerate();
        let column = |j: usize| coordinate(values, width, first + j).collect();
        joints.map(|(j, joint)| (format!("{}/{quantity}", joint.name), column(j))).collect()
    }

    /// All joints.
    pub(crate) fn joint_places(&self) -> impl Iterator<Item = Location> + '_ {
        self.layout.joints.iter().map(|joint| Location::joint(&joint.name))
    }
}
