//! Absolute angles of parallel revolute joints as coordinates.
use super::Sensitivity;
use super::subtree::{Change, Wrench};
use crate::expression::Sym;
use crate::tree::JointMotion;

impl<'g> Sensitivity<'_, 'g, '_> {
    /// The parent, where the body's absolute angle takes the place of its angle from the parent: both
    /// revolute, about parallel axes.
    pub(super) fn absolute_parent(&self, index: usize) -> Option<usize> {
        let bodies = &self.model.tree.bodies;
        let revolute = |k: usize| matches!(bodies[k].motion, JointMotion::Revolute { .. });
        bodies[index].parent.filter(|&p| self.axes[index].joined && revolute(index) && revolute(p))
    }

    /// Generalised forces in absolute angles from those in joint angles. Absolute angles count about the
    /// coordinate axis, whatever the joint's direction.
    pub fn in_absolute_angles(&self, tau: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let mut out = tau.to_vec();
        for (index, body) in self.model.tree.bodies.iter().enumerate() {
            if let JointMotion::Revolute { .. } = body.motion {
                out[body.v_index] = self.model.signed(index, tau[body.v_index]);
            }
        }
        for (index, body) in self.model.tree.bodies.iter().enumerate() {
            if let Some(parent) = self.absolute_parent(index) {
                let at = self.model.tree.bodies[parent].v_index;
                out[at] = out[at] - self.model.signed(index, tau[body.v_index]);
            }
        }
        out
    }

    /// Rates of joint angles from those of absolute angles.
    pub fn joint_velocities(&self, v: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let mut out = v.to_vec();
        for (index, body) in self.model.tree.bodies.iter().enumerate() {
            if let JointMotion::Revolute { .. } = body.motion {
                let carried = self.absolute_parent(index).map(|p| v[self.model.tree.bodies[p].v_index]);
                let own = carried.map_or(v[body.v_index], |carried| v[body.v_index] - carried);
                out[body.v_index] = self.model.signed(index, own);
            }
        }
        out
    }

    /// Like `projections`, about coordinate axes.
    fn absolute_projections(&self, index: usize, wrench: Wrench<'g>) -> Vec<(usize, Sym<'g>)> {
        let body = &self.model.tree.bodies[index];
        match body.motion {
            JointMotion::Revolute { axis, .. } => vec![(body.v_index, wrench.1[axis])],
            _ => self.projections(index, wrench),
        }
    }

    /// [`Self::forces`] in absolute angles: each body's own balance of moments.
    pub fn absolute_forces(&self) -> Vec<Sym<'g>> {
        let mut out = vec![self.model.constant(0.0); self.model.tree.nv];
        let mut moments: Vec<_> = self.cores.iter().map(|core| core.1.1).collect();
        for index in 0..self.links.len() {
            let _work = self.model.work(index, "moment in absolute angles");
            if let Some(parent) = self.absolute_parent(index) {
                moments[parent] = moments[parent] + self.links[index].arm.cross(self.wrenches[index].0);
            }
        }
        for (index, &moment) in moments.iter().enumerate() {
            let wrench = match self.model.tree.bodies[index].motion {
                JointMotion::Revolute { .. } => (self.wrenches[index].0, moment),
                _ => self.wrenches[index],
            };
            for (row, x) in self.absolute_projections(index, wrench) {
                out[row] = x;
            }
        }
        out
    }

    /// Mass matrix in absolute angles, all entries.
    pub fn absolute_mass_matrix(&self) -> Vec<Vec<Sym<'g>>> {
        let nv = self.model.tree.nv;
        let mut d = vec![vec![self.model.constant(0.0); nv]; nv];
        for (index, body) in self.model.tree.bodies.iter().enumerate() {
            let _work = self.model.work(index, "mass matrix in absolute angles");
            let JointMotion::Revolute { axis, .. } = body.motion else {
                for (k, change) in self.units(index).iter().enumerate() {
                    let wrench = self.subtrees[index].response(change);
                    self.absolute_walk(index, wrench, body.v_index + k, &mut d);
                }
                continue;
            };
            let axis = self.model.along(axis, self.model.constant(1.0));
            let still = self.still();
            let (force, own) = self.cores[index].0.response(&Change { angular: axis, ..still });
            let (mut force, mut own, mut carried) = (force, own, self.model.zero3());
            for child in index + 1..self.links.len() {
                if self.absolute_parent(child) != Some(index) {
                    continue;
                }
                let arm = self.links[child].arm;
                let (f, n) =
                    self.subtrees[child].response(&Change { acceleration: axis.cross(arm), ..still });
                force = force + f;
                own = own + arm.cross(f);
                carried = carried + n;
            }
            for (row, x) in self.absolute_projections(index, (force, own)) {
                d[row][row] = x;
            }
            self.absolute_carry(index, (force, own + carried), body.v_index, &mut d);
        }
        d
    }

    fn absolute_walk(&self, index: usize, wrench: Wrench<'g>, column: usize, d: &mut [Vec<Sym<'g>>]) {
        for (row, x) in self.absolute_projections(index, wrench) {
            d[row][column] = x;
            d[column][row] = x;
        }
        self.absolute_carry(index, wrench, column, d);
    }

    fn absolute_carry(&self, index: usize, wrench: Wrench<'g>, column: usize, d: &mut [Vec<Sym<'g>>]) {
        let (mut at, mut wrench) = (index, wrench);
        while let Some(parent) = self.model.tree.bodies[at].parent {
            let lifted = self.lift(at, parent, wrench);
            // In absolute angles the moment of a parallel joint is the child's alone.
            let felt = match self.absolute_parent(at) {
                Some(_) => (lifted.0, self.links[at].arm.cross(wrench.0)),
                None => lifted,
            };
            for (row, x) in self.absolute_projections(parent, felt) {
                d[row][column] = x;
                d[column][row] = x;
            }
            (at, wrench) = (parent, lifted);
        }
    }
}
