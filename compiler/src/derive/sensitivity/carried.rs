//! Motions that a chain of bodies hands on from the root to its end.
use super::{Sensitivity, Wrench};
use crate::expression::{Sym, Vector3};
use crate::tree::JointMotion;

impl<'g> Sensitivity<'_, 'g, '_> {
    /// Linear and angular part of what the last body of a chain has of changes of accelerations, or of velocities, in the order of `v`;
    /// at its origin and in its joint axes. What carries the chain's first body does not change.
    pub fn handed_on(&self, chain: &[usize], changes: &[Sym<'g>]) -> Wrench<'g> {
        let model = self.model;
        let mut motion = (model.zero3(), model.zero3());
        for (k, &index) in chain.iter().enumerate() {
            if k > 0 {
                motion = self.to_joint(index, chain[k - 1], motion);
            }
            let change = |k: usize| changes[model.tree.bodies[index].v_index + k];
            let along = |axis: usize| model.along(axis, model.signed(index, change(0)));
            match model.tree.bodies[index].motion {
                JointMotion::Free => {
                    motion = (Vector3([0, 1, 2].map(change)), Vector3([3, 4, 5].map(change)));
                }
                JointMotion::Revolute { axis, .. } => motion.1 = motion.1 + along(axis),
                JointMotion::Prismatic { axis, .. } => motion.0 = motion.0 + along(axis),
            }
        }
        motion
    }

    /// From the origin and the joint axes of a body's parent to its own, before its joint.
    pub(super) fn to_joint(&self, index: usize, parent: usize, motion: Wrench<'g>) -> Wrench<'g> {
        let joined = self.axes[index].joined;
        let into = |x| if joined { x } else { self.axes[parent].into_body(x) };
        let (linear, angular) = (into(motion.0), into(motion.1));
        let placement = &self.model.tree.bodies[index].placement;
        let down = |x| if joined { x } else { self.model.placed_back(placement, x) };
        (down(linear + angular.cross(self.links[index].arm)), down(angular))
    }

    /// Whether all bodies of a chain but the first have the joint axes of the first.
    pub fn share_axes(&self, chain: &[usize]) -> bool {
        chain.iter().skip(1).all(|&index| self.axes[index].joined)
    }

    /// Acceleration less gravity and angular acceleration of a body's point (its axes) in its joint axes, with a change of both at
    /// its origin.
    pub fn acceleration_of(&self, index: usize, point: Vector3<'g>, change: Wrench<'g>) -> Wrench<'g> {
        let (motion, arm) = (&self.links[index].joint, self.axes[index].out(point));
        (motion.a + motion.u * arm + change.0 + change.1.cross(arm), motion.wd + change.1)
    }

    /// The same in its own axes.
    pub fn acceleration_in(&self, index: usize, point: Vector3<'g>, change: Wrench<'g>) -> Wrench<'g> {
        let motion = &self.links[index].own;
        let (linear, angular) = (self.axes[index].into_body(change.0), self.axes[index].into_body(change.1));
        (motion.a + motion.u * point + linear + angular.cross(point), motion.wd + angular)
    }

    /// A wrench from a body's own axes to its joint axes.
    pub fn out(&self, index: usize, (force, moment): Wrench<'g>) -> Wrench<'g> {
        (self.axes[index].out(force), self.axes[index].out(moment))
    }

    /// Linear and angular velocity at a body's point (its axes), from those at its origin in its joint axes: in the joint axes, and in
    /// its own.
    pub fn at_point(&self, index: usize, point: Vector3<'g>, motion: Wrench<'g>) -> (Wrench<'g>, Wrench<'g>) {
        let axes = self.axes[index];
        let joint = (motion.0 + motion.1.cross(axes.out(point)), motion.1);
        let (linear, angular) = (axes.into_body(motion.0), axes.into_body(motion.1));
        (joint, (linear + angular.cross(point), angular))
    }
}
