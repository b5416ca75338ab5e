//! The motion of a step without contact: the factored mass matrix, and what forces do in it.
use super::{MotionState, Stepper, too_long};
use crate::simulate::dense;
use crate::simulate::motors::embed;
use bipedc_effects::diagnostic::Diagnostic;

impl Stepper<'_> {
    /// Factors D at the midpoint; `drive` becomes `L⁻ᵀ h (τ − H)`. `goes_on`: this step follows the last one.
    pub(super) fn free_motion(
        &mut self,
        motion: &MotionState,
        force: &[f64],
        time: f64,
        goes_on: bool,
    ) -> Result<(), Diagnostic> {
        let (nv, n) = (self.mechanics.nv(), self.size());
        let first = nv - self.joints.len();
        let length = dense::row_length(n);
        self.mechanics.mass_matrix(&motion.q, &mut self.inner);
        embed(&self.inner, nv, &mut self.mass, length);
        for (j, joint) in self.joints.iter().enumerate() {
            let i = first + j;
            self.mass[i * length + i] += joint.rotor_inertia + 0.5 * time * (joint.damping + joint.slope);
        }
        for pair in &self.coupled {
            let [a, b] = pair.joints;
            self.mass[(first + a.max(b)) * length + first + a.min(b)] += pair.inertia;
        }
        self.motors.add_inertia(&mut self.mass, n, first, time);
        for (axis, inertia) in self.inertia.iter_mut().enumerate() {
            *inertia = self.mass[(first + axis) * (length + 1)];
        }
        if !self.servos.is_empty() || self.joints.iter().any(|joint| joint.dry != [0.0; 2]) {
            self.within.inertia.copy_from_slice(&self.mass);
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
        self.look_ahead(goes_on);
        self.push(motion, force, time, true);
        Ok(())
    }

    /// The velocity that H is taken at.
    fn look_ahead(&mut self, goes_on: bool) {
        let nv = self.around.len();
        self.around.copy_from_slice(&self.middle[..nv]);
        // What bounces is pushed now and then, not step by step.
        if !goes_on || self.ground.normal_restitution > 0.0 {
            return;
        }
        let [last, before] = &self.last.by_contact;
        let ground = last.iter().zip(before);
        for ((around, v), (last, before)) in self.around.iter_mut().zip(&self.speed).zip(ground) {
            // Half of what there would be without it. It takes that back, no more, where it does so step by step: an impact does not go on.
            let free = *around - v;
            let ground = 0.5 * last.abs().min(before.abs());
            if last * before > 0.0 && last * free < 0.0 {
                *around -= free.signum() * ground.min(free.abs());
            }
        }
    }

    /// What ground and stops changed of the velocity in this step: the difference of what there was and what it would have been without.
    pub(super) fn remember(&mut self, touched: bool, time: f64) {
        self.last.time = time;
        self.last.by_contact.swap(0, 1);
        let own = self.drive.iter().zip(&self.speed).zip(&self.middle);
        for (by_contact, ((change, v), middle)) in self.last.by_contact[0].iter_mut().zip(own) {
            *by_contact = if touched { change - 2.0 * (middle - v) } else { 0.0 };
        }
    }

    /// `drive = L⁻ᵀ h (τ − H(q_M, v) − damping)`, with the velocity `around` in H or the present one.
    fn push(&mut self, motion: &MotionState, force: &[f64], time: f64, around: bool) {
        let (nv, n, joints) = (self.mechanics.nv(), self.size(), self.joints.len());
        let first = nv - joints;
        let v = if around { &self.around } else { &self.speed };
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
        if !around {
            // Servos and friction give about what they gave before: without them the middle's velocity, and with it H, would
            // be of first order only.
            for axis in 0..self.inertia.len() {
                let slot = self.slot_of_axis(axis);
                self.drive[first + axis] += self.memory[slot] + self.memory[slot + 3];
            }
        }
        if around {
            self.within.push.copy_from_slice(&self.drive);
        }
        dense::forward_one(&self.mass, n, &mut self.drive);
    }
}
