//! Limbs of the same make: what is computed for one leg is computed for the other at once.
use super::{JointMotion, Tree};
use bipedc_runtime::Argument;

/// Of a robot's bodies, those that have the same place in two limbs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Twins {
    /// Of each body, the other one.
    of: Vec<Option<usize>>,
    /// Of each element of `q`, the other body's.
    q: Vec<Option<u32>>,
    /// Of each element of `v`.
    v: Vec<Option<u32>>,
    /// Of each joint, in the order of motors.
    joints: Vec<Option<u32>>,
}

impl Twins {
    /// Two limbs that begin at the same body are of the same make if their joints turn or slide about the same axes of bodies, one
    /// after the other; dimensions and inertias may differ.
    pub fn of(tree: &Tree) -> Self {
        let mut of = vec![None; tree.bodies.len()];
        let parents = std::iter::once(None).chain((0..tree.bodies.len()).map(Some));
        for parent in parents {
            let limbs = children(tree, parent);
            for (k, &first) in limbs.iter().enumerate() {
                let free = |&&other: &&usize| of[other].is_none() && same_make(tree, first, other);
                if of[first].is_none()
                    && let Some(&second) = limbs[k + 1..].iter().find(free)
                {
                    pair(tree, first, second, &mut of);
                }
            }
        }
        Self::of_bodies(tree, of)
    }

    /// Nobody has a twin.
    pub fn none(tree: &Tree) -> Self {
        Self::of_bodies(tree, vec![None; tree.bodies.len()])
    }

    fn of_bodies(tree: &Tree, of: Vec<Option<usize>>) -> Self {
        let (mut q, mut v) = (vec![None; tree.nq], vec![None; tree.nv]);
        for (body, twin) in tree.bodies.iter().zip(&of) {
            let Some(twin) = twin.map(|twin| &tree.bodies[twin]) else { continue };
            (0..body.motion.nq()).for_each(|k| q[body.q_index + k] = Some((twin.q_index + k) as u32));
            (0..body.motion.nv()).for_each(|k| v[body.v_index + k] = Some((twin.v_index + k) as u32));
        }
        let joint =
            |at: u32| tree.joints.iter().position(|joint| joint.v_index == at as usize).map(|k| k as u32);
        let joints = tree.joints.iter().map(|own| v[own.v_index].and_then(joint)).collect();
        Self { of, q, v, joints }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.of.iter().all(Option::is_none)
    }

    /// The body that has a body's place in the other limb.
    pub fn body(&self, index: usize) -> Option<usize> {
        self.of[index]
    }

    /// The element of an argument that belongs to the other limb; `None` for those that belong to no limb.
    pub fn element(&self, argument: Argument, index: u32) -> Option<u32> {
        let list = match argument {
            Argument::Q => &self.q,
            Argument::V | Argument::A | Argument::Tau => &self.v,
            Argument::MotorQ | Argument::MotorV | Argument::MotorA => &self.joints,
            Argument::Forces | Argument::Parameters => return None,
        };
        list.get(index as usize).copied().flatten()
    }
}

fn children(tree: &Tree, parent: Option<usize>) -> Vec<usize> {
    (0..tree.bodies.len()).filter(|&k| tree.bodies[k].parent == parent).collect()
}

fn same_make(tree: &Tree, a: usize, b: usize) -> bool {
    let axis = |body: usize| match tree.bodies[body].motion {
        JointMotion::Free => None,
        JointMotion::Revolute { axis, .. } => Some((true, axis)),
        JointMotion::Prismatic { axis, .. } => Some((false, axis)),
    };
    let (of_a, of_b) = (children(tree, Some(a)), children(tree, Some(b)));
    axis(a) == axis(b)
        && of_a.len() == of_b.len()
        && of_a.iter().zip(&of_b).all(|(&a, &b)| same_make(tree, a, b))
}

fn pair(tree: &Tree, a: usize, b: usize, of: &mut [Option<usize>]) {
    (of[a], of[b]) = (Some(b), Some(a));
    children(tree, Some(a)).into_iter().zip(children(tree, Some(b))).for_each(|(a, b)| pair(tree, a, b, of));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;
    use std::path::Path;

    fn tree(robot: &str) -> Tree {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(robot);
        Robot::read(&folder).unwrap().compile().unwrap().tree
    }

    #[test]
    fn legs_are_twins_joint_by_joint() {
        for robot in ["tulip", "biped_3d", "five_link", "seven_link"] {
            let tree = tree(robot);
            let twins = Twins::of(&tree);
            let mut count = 0;
            for (k, body) in tree.bodies.iter().enumerate() {
                let Some(twin) = twins.body(k) else { continue };
                let other = &tree.bodies[twin];
                assert_eq!(twins.body(twin), Some(k));
                assert_eq!(
                    body.name.replace("left", "right"),
                    other.name.replace("left", "right"),
                    "{robot}"
                );
                assert_eq!(
                    twins.element(Argument::V, body.v_index as u32),
                    Some(other.v_index as u32),
                    "{robot}"
                );
                assert_eq!(
                    twins.element(Argument::Q, body.q_index as u32),
                    Some(other.q_index as u32),
                    "{robot}"
                );
                count += 1;
            }
            assert_eq!(count, tree.joints.len(), "{robot}: all joints are in legs");
            assert_eq!(twins.element(Argument::V, 0), None, "{robot}: the base has no twin");
        }
    }

    #[test]
    fn a_single_leg_has_no_twin() {
        assert!(Twins::of(&tree("tulip_v1_leg")).is_empty());
    }
}
