//! States of a robot over time.
use super::{Batch, JointLayout};
use std::ops::Range;

/// Configurations, velocities and accelerations, state after state, each as models take it: the base, then the joints.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trajectory {
    nq: usize,
    nv: usize,
    joints: usize,
    /// `len × nq`; m, rad, quaternion x y z w.
    pub q: Vec<f64>,
    /// `len × nv`; per s.
    pub v: Vec<f64>,
    /// `len × nv`; per s².
    pub a: Vec<f64>,
}

impl Trajectory {
    /// Without states yet.
    pub fn new(layout: &JointLayout) -> Self {
        let joints = layout.joints.len();
        Self::with_widths(layout.base.nq() + joints, layout.base.nv() + joints, joints)
    }

    /// Of states with `nq` and `nv` elements, the last of which are those of the joints.
    pub fn with_widths(nq: usize, nv: usize, joints: usize) -> Self {
        Self { nq, nv, joints, ..Self::default() }
    }

    /// As many states, all zero.
    pub fn zeros(&self) -> Self {
        let zeros = |values: &[f64]| vec![0.0; values.len()];
        Self { q: zeros(&self.q), v: zeros(&self.v), a: zeros(&self.a), ..*self }
    }

    /// As many states with other configurations.
    pub fn turned(&self, q: Vec<f64>) -> Self {
        Self { q, v: self.v.clone(), a: self.a.clone(), ..*self }
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.q.len() / self.nq.max(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.q.is_empty()
    }

    /// Elements of a configuration.
    pub fn nq(&self) -> usize {
        self.nq
    }

    /// Elements of a velocity.
    pub fn nv(&self) -> usize {
        self.nv
    }

    /// Positions of a joint, rad or m.
    pub fn positions(&self, joint: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        coordinate(&self.q, self.nq, self.nq - self.joints + joint)
    }

    /// Velocities of a joint, rad/s or m/s.
    pub fn velocities(&self, joint: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        coordinate(&self.v, self.nv, self.nv - self.joints + joint)
    }

    /// Accelerations of a joint, rad/s² or m/s².
    pub fn accelerations(&self, joint: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        coordinate(&self.a, self.nv, self.nv - self.joints + joint)
    }

    /// Configurations (0), velocities (1) or accelerations (2), to be changed.
    pub fn order_mut(&mut self, order: usize) -> &mut Vec<f64> {
        [&mut self.q, &mut self.v, &mut self.a][order.min(2)]
    }

    /// The same of one joint.
    pub fn joint_mut(&mut self, order: usize, joint: usize) -> impl Iterator<Item = &mut f64> {
        let width = if order == 0 { self.nq } else { self.nv };
        let first = width - self.joints + joint;
        self.order_mut(order).iter_mut().skip(first).step_by(width.max(1))
    }

    /// Positions of a joint in a copy of the configurations, to be changed.
    pub fn positions_in<'s>(
        &self,
        q: &'s mut [f64],
        joint: usize,
    ) -> impl Iterator<Item = &'s mut f64> + use<'s> {
        q.iter_mut().skip(self.nq - self.joints + joint).step_by(self.nq.max(1))
    }

    /// Exchanges two joints.
    pub(crate) fn swap(&mut self, one: usize, other: usize) {
        for (values, width) in [(&mut self.q, self.nq), (&mut self.v, self.nv), (&mut self.a, self.nv)] {
            let first = width - self.joints;
            values.chunks_exact_mut(width).for_each(|state| state.swap(first + one, first + other));
        }
    }

    /// Quantities of a joint (efforts, loads) that stand in rows like velocities, `len × nv`.
    pub fn of_joint<'s>(
        &self,
        values: &'s [f64],
        joint: usize,
    ) -> impl Iterator<Item = f64> + Clone + use<'s> {
        coordinate(values, self.nv, self.nv - self.joints + joint)
    }

    /// Positions and velocities of all joints in a state.
    pub fn joints_at(&self, state: usize) -> [&[f64]; 2] {
        let last = |width: usize| (state + 1) * width - self.joints..(state + 1) * width;
        [&self.q[last(self.nq)], &self.v[last(self.nv)]]
    }

    /// Position, velocity and acceleration of a joint in a state.
    pub fn joint_at(&self, state: usize, joint: usize) -> [f64; 3] {
        let place = |width: usize| (state + 1) * width - self.joints + joint;
        [self.q[place(self.nq)], self.v[place(self.nv)], self.a[place(self.nv)]]
    }

    /// Some states.
    pub fn part(&self, states: Range<usize>) -> Batch<'_> {
        let of = |width: usize| states.start * width..states.end * width;
        Batch::new(states.len(), [&self.q[of(self.nq)], &self.v[of(self.nv)], &self.a[of(self.nv)]])
    }

    /// All states.
    pub fn batch(&self) -> Batch<'_> {
        self.part(0..self.len())
    }

    /// Adds states behind the others.
    pub fn extend(&mut self, [q, v, a]: [&[f64]; 3]) {
        self.q.extend_from_slice(q);
        self.v.extend_from_slice(v);
        self.a.extend_from_slice(a);
    }

    /// The same of states that nobody else needs: the first ones are not copied.
    pub(crate) fn append(&mut self, [q, v, a]: [Vec<f64>; 3]) {
        if self.is_empty() {
            (self.q, self.v, self.a) = (q, v, a);
        } else {
            self.extend([&q, &v, &a]);
        }
    }

    /// Forgets all states.
    pub fn clear(&mut self) {
        [&mut self.q, &mut self.v, &mut self.a].into_iter().for_each(Vec::clear);
    }

    /// These states alone.
    pub fn some(&self, kept: &[usize]) -> Self {
        let pick = |values: &[f64], width: usize| -> Vec<f64> {
            let mut picked = Vec::with_capacity(kept.len() * width);
            kept.iter().for_each(|&i| picked.extend_from_slice(&values[i * width..(i + 1) * width]));
            picked
        };
        let [q, v, a] = [(&self.q, self.nq), (&self.v, self.nv), (&self.a, self.nv)].map(|(x, w)| pick(x, w));
        Self { q, v, a, ..*self }
    }

    /// Keeps these states.
    pub fn retain(&mut self, kept: &[usize]) {
        *self = self.some(kept);
    }
}

/// One element of all rows of a matrix that is stored row after row.
pub(crate) fn coordinate(
    values: &[f64],
    width: usize,
    index: usize,
) -> impl Iterator<Item = f64> + Clone + use<'_> {
    values.iter().skip(index).step_by(width.max(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_stand_behind_the_base() {
        // A floating base and two joints, three states; every number tells its place.
        let mut motion = Trajectory::with_widths(9, 8, 2);
        let numbers = |n: usize| (0..n).map(|i| i as f64).collect::<Vec<f64>>();
        motion.extend([&numbers(27), &numbers(24), &numbers(24)]);
        assert_eq!((motion.len(), motion.is_empty()), (3, false));
        assert_eq!(motion.positions(1).collect::<Vec<_>>(), [8.0, 17.0, 26.0]);
        assert_eq!(motion.velocities(0).collect::<Vec<_>>(), [6.0, 14.0, 22.0]);
        assert_eq!(motion.joints_at(1), [&[16.0, 17.0], &[14.0, 15.0]]);
        assert_eq!(motion.part(1..2).q[0], 9.0);
        motion.joint_mut(0, 0).for_each(|q| *q = -1.0);
        assert_eq!(motion.positions(0).collect::<Vec<_>>(), [-1.0; 3]);
        motion.retain(&[0, 2]);
        assert_eq!(motion.accelerations(1).collect::<Vec<_>>(), [7.0, 23.0]);
        motion.clear();
        assert_eq!(motion.len(), 0);
    }
}
