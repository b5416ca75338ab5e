//! The axes in which each body's quantities are written.
use crate::derive::RobotModel;
use crate::derive::model::rotate;
use crate::expression::{Sym, Vector3};
use crate::tree::JointMotion;

/// A turn about a coordinate axis: axis, sine, cosine.
pub(in crate::derive) type Turn<'g> = (usize, Sym<'g>, Sym<'g>);

/// Where a body's *joint axes* lie: the axes just before its own turn. Along a chain of parallel joints all
/// bodies share the first one's, so that nothing is rotated between them.
#[derive(Clone, Copy)]
pub(in crate::derive) struct Axes<'g> {
    /// The joint axes are the parent's joint axes (else: constant in the parent's body).
    pub joined: bool,
    /// Takes vectors from the body's own axes to the joint axes; `None` where both are the same.
    pub turn: Option<Turn<'g>>,
}

impl<'g> Axes<'g> {
    /// From the body's own axes to the joint axes.
    pub fn out(&self, x: Vector3<'g>) -> Vector3<'g> {
        self.turn.map_or(x, |(axis, s, c)| rotate(axis, s, c, x))
    }
    /// From the joint axes to the body's own.
    pub fn into_body(self, x: Vector3<'g>) -> Vector3<'g> {
        self.turn.map_or(x, |(axis, s, c)| rotate(axis, -s, c, x))
    }
}

/// Axes of all bodies.
pub(super) fn choose<'g>(model: &RobotModel<'g, '_>) -> Vec<Axes<'g>> {
    // Angle of each body's own axes from its joint axes, where there is a turn.
    let mut turned: Vec<Option<(usize, Sym<'g>)>> = Vec::new();
    let mut out = Vec::new();
    for (index, body) in model.tree.bodies.iter().enumerate() {
        let q = || model.signed(index, model.input(bipedc_runtime::Argument::Q, body.q_index));
        let (axis, own) = match body.motion {
            JointMotion::Revolute { axis, .. } => (axis, Some(q())),
            JointMotion::Prismatic { axis, .. } => (axis, None),
            JointMotion::Free => (0, None),
        };
        let carrier = body.parent.and_then(|p| turned[p]).filter(|(k, _)| *k == axis);
        let parallel = body.placement.rotation.0.iter().all(|(k, _)| *k == axis);
        let shared = carrier.filter(|_| parallel && body.motion != JointMotion::Free).map(|(_, angle)| {
            body.placement.rotation.0.iter().fold(angle, |sum, (_, constant)| sum + *constant)
        });
        let angle = match (shared, own) {
            (Some(carried), Some(own)) => Some(carried + own),
            (carried, own) => carried.or(own),
        };
        turned.push(angle.map(|angle| (axis, angle)));
        out.push(Axes {
            joined: shared.is_some(),
            turn: angle.map(|angle| (axis, angle.sin(), angle.cos())),
        });
    }
    out
}
