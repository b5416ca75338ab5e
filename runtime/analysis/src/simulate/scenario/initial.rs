//! `[initial]` of a scenario: where the base begins.
use super::Initial;
use super::file::{File, Start};
use super::reading::Reading;
use crate::robot::BaseKind;
use crate::simulate::Plant;
use nalgebra::{UnitQuaternion, Vector3};

impl Reading<'_> {
    /// The state at time 0, joints at zero.
    pub(super) fn initial(&mut self, file: &File, plant: &Plant) -> Initial {
        let none = Start::default();
        let start = file.initial.as_ref().map_or(&none, |start| start.get_ref());
        let at = file.initial.as_ref().map_or(0, |start| start.span().start);
        let base = plant.layout.base;
        let joints = plant.layout.joints.len();
        let (linear, angular) = base.axes();
        let (linear, angular) = (linear.len(), angular.len());
        let axes = if linear == 3 { "[x, y, z]" } else { "[x, z]" };
        let turns = if angular == 3 { "[roll, pitch, yaw]" } else { "[pitch]" };
        let position = self.vector("base_position", start.base_position.as_ref(), linear, axes);
        let rotation = self.vector("base_rotation", start.base_rotation.as_ref(), angular, turns);
        let velocity = self.vector("base_velocity", start.base_velocity.as_ref(), linear, axes);
        let turning =
            self.vector("base_angular_velocity", start.base_angular_velocity.as_ref(), angular, turns);
        let clearance = self.number("clearance", start.clearance.as_ref(), 0.0, (0.0, 1e3), "m");
        if let (Some(clearance), Some(_)) = (&start.clearance, &start.base_position) {
            let help = "`clearance` places the lowest contact point, `base_position` the base: keep one";
            self.wrong::<()>(clearance.span().start, "both `clearance` and `base_position` are given", help);
        }
        let (mut q, mut v) = (position, velocity);
        match base {
            BaseKind::Fixed | BaseKind::Pivot => {}
            BaseKind::Planar => {
                q.extend(rotation);
                v.extend(turning);
            }
            BaseKind::Floating => {
                let turn = UnitQuaternion::from_euler_angles(rotation[0], rotation[1], rotation[2]);
                q.extend(turn.coords.iter());
                let own = turn.inverse() * Vector3::new(v[0], v[1], v[2]);
                v = own.iter().copied().chain(turning).collect();
            }
        }
        q.resize(q.len() + joints, 0.0);
        v.resize(v.len() + joints, 0.0);
        let clearance = (start.base_position.is_none() && base != BaseKind::Fixed && !plant.feet.is_empty())
            .then_some(clearance);
        Initial { q, v, clearance, position: self.place(at) }
    }
}
