//! The motion of a step without contact: the factored mass matrix, and what forces do in it.
use super::{MotionState, Stepper, too_long};
use crate::simulate::dense;
use crate::simulate::motors::embed;
use bipedc_effects::diagnostic::Diagnostic;

impl Stepper<'_> {
    /// Factors D at the midpoint; `drive` becomes `L⁻ᵀ h (τ − H)`.
    pub(super) fn free_motion(
        &mut self,
        motion: &MotionState,
        force: &[f64],
        time: f64,
    ) -> Result<(), Diagnostic> {
        let (nv, n) = (self.mechanics.nv(), self.size());
        let first = nv - self.joints.len();
        if n == nv {
            self.mechanics.mass_matrix(&motion.q, &mut self.mass);
        } else {
            self.mechanics.mass_matrix(&motion.q, &mut self.inner);
            embed(&self.inner, nv, &mut self.mass, n);
        }
        for (j, joint) in self.joints.iter().enumerate() {
            let i = first + j;
            self.mass[i * n + i] += joint.rotor_inertia + 0.5 * time * (joint.damping + joint.slope);
        }
        for pair in &self.coupled {
            let [a, b] = pair.joints;
            self.mass[(first + a.max(b)) * n + first + a.min(b)] += pair.inertia;
        }
        self.motors.add_inertia(&mut self.mass, n, first, time);
        for (axis, inertia) in self.inertia.iter_mut().enumerate() {
            *inertia = self.mass[(first + axis) * (n + 1)];
        }
        if !dense::factor(&mut self.mass, n) {
            return Err(too_long(motion.time));
        }
        self.push(motion, force, time, false);
        self.middle.copy_from_slice(&self.drive);
        dense::backward(&self.mass, n, &mut self.middle);
        for (middle, v) in self.middle.iter_mut().zip(&self.speed) {
            *middle = v + 0.5 * *middle;
        }
        self.push(motion, force, time, true);
        Ok(())
    }

    /// `drive = L⁻ᵀ h (τ − H(q_M, v) − damping)`, with the velocity `middle` in H or the present one.
    fn push(&mut self, motion: &MotionState, force: &[f64], time: f64, middle: bool) {
        let (nv, n, joints) = (self.mechanics.nv(), self.size(), self.joints.len());
        let first = nv - joints;
        let v = if middle { &self.middle } else { &self.speed };
        self.mechanics.bias(&motion.q, &v[..nv], &mut self.bias);
        for (drive, force) in self.drive.iter_mut().zip(force) {
            *drive = time * force;
        }
        for (drive, bias) in self.drive.iter_mut().zip(&self.bias) {
            *drive -= time * bias;
        }
        for (j, joint) in self.joints.iter().enumerate() {
            self.drive[first + j] -= time * joint.damping * motion.v[first + j];
        }
        let (q, v) = (&motion.q[motion.q.len() - joints..], &motion.v[first..]);
        self.motors.add_impulses(&mut self.drive, first, q, v, time);
        if !middle {
            // Servos and friction give about what they gave before: without them the middle's velocity, and with it H, would
            // be of first order only.
            for axis in 0..self.inertia.len() {
                let slot = self.slot_of_axis(axis);
                self.drive[first + axis] += self.memory[slot] + self.memory[slot + 3];
            }
        }
        dense::forward_one(&self.mass, n, &mut self.drive);
    }
}
