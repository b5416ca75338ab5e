//! Servos within their limits are springs and dampers like others: part of the mass matrix, without rows of their own.
//!
//! The row of a servo, `γ⁺ + s Λ + c = 0`, says `Λ = −(γ⁺ + c)/s` as long as Λ is within its limits. In `D (v⁺ − v) = p + W Λ` that
//! adds `1/s` to the diagonal of D and takes `(γ⁻ + c)/s` off p. What is left is the problem of ground, stops and friction, a third
//! smaller for a robot on two feet, with the same solution. If a servo turns out to exceed a limit, the step is solved again with rows
//! for all of them; in the next step it keeps its own.
use super::{MotionState, RowSource, Stepper};
use crate::simulate::dense::{self, row_length};
use crate::simulate::implicit::Relaxed;
use crate::simulate::motors::Motors;
use crate::simulate::servo::DriveServo;

/// A servo whose softness is less than this part of what moves its axis keeps its row: what it gives would be a small difference.
const SOFT: f64 = 1e-4;

/// What servos without rows need.
#[derive(Debug, Clone, Default)]
pub(super) struct WithinLimits {
    /// By servo: what it is as long as it has no row.
    relaxed: Vec<Option<Relaxed>>,
    /// Whether any has none, or a joint sticks.
    any: bool,
    /// D; rows as those of the stepper's.
    pub inertia: Vec<f64>,
    /// The factor L of D with the servos, without what sticks.
    pub mass: Vec<f64>,
    /// p, N s or N m s.
    pub push: Vec<f64>,
    /// `L⁻ᵀ p` with the factor of D alone.
    drive: Vec<f64>,
    /// Of the velocities, by servos and everything.
    pub change: Vec<f64>,
    /// By servo, those without rows, N m s.
    pub impulses: Vec<f64>,
}

impl WithinLimits {
    pub fn with_room(size: usize, axes: usize) -> Self {
        let room = || vec![0.0; size];
        Self {
            relaxed: Vec::with_capacity(axes),
            any: false,
            inertia: vec![0.0; size * row_length(size)],
            mass: vec![0.0; size * row_length(size)],
            push: room(),
            drive: room(),
            change: room(),
            impulses: Vec::with_capacity(axes),
        }
    }

    /// The factor of the mass matrix: `plain` without servos.
    pub fn factor_or<'a>(&'a self, plain: &'a [f64]) -> &'a [f64] {
        if self.any { &self.mass } else { plain }
    }

    /// Whether a servo has a row of the contact problem.
    pub fn has_row(&self, servo: usize) -> bool {
        self.relaxed[servo].is_none()
    }
}

impl Stepper<'_> {
    /// Puts the servos that were within their limits in the last step into the mass matrix, and takes joints that stuck out of it; none
    /// where their work is asked for, or what impacts restore.
    pub(super) fn put_in(&mut self, motion: &MotionState, time: f64) {
        let rows_for_all = self.energy_accounting.is_some() || self.ground.restores();
        let joints = self.joints.len();
        let state = (&motion.q[motion.q.len() - joints..], &motion.v[motion.v.len() - joints..]);
        self.within.relaxed.clear();
        for (index, servo) in self.servos.iter().enumerate() {
            let last = self.memory[self.slot(RowSource::Servo(index))];
            let [low, high] = servo.limits.map(|limit| time * limit);
            let relaxed = relaxed(servo, &self.motors, state, &self.inertia, time);
            let is_within = !rows_for_all && low < last && last < high;
            let stiff = SOFT / self.inertia[servo.axis];
            self.within.relaxed.push(relaxed.filter(|relaxed| is_within && relaxed.softness > stiff));
        }
        self.sticking.joints.clear();
        if !rows_for_all {
            self.find_sticking(state.0, time);
        }
        self.within.any = self.within.relaxed.iter().any(Option::is_some) || !self.sticking.joints.is_empty();
        if self.within.any && !self.factor_with_servos() {
            self.take_out();
        }
    }

    /// The factor with servos, and `drive` in its coordinates; false: not positive definite.
    fn factor_with_servos(&mut self) -> bool {
        let (n, first) = (self.size(), self.mechanics.nv() - self.joints.len());
        let within = &mut self.within;
        within.mass.copy_from_slice(&within.inertia);
        within.drive.copy_from_slice(&self.drive);
        self.drive.copy_from_slice(&within.push);
        for (servo, relaxed) in self.servos.iter().zip(&within.relaxed) {
            let Some(Relaxed { softness, offset }) = relaxed else { continue };
            let coordinate = first + servo.axis;
            within.mass[coordinate * (row_length(n) + 1)] += 1.0 / softness;
            self.drive[coordinate] -= (self.speed[coordinate] + offset) / softness;
        }
        self.hold_sticking();
        if !dense::factor(&mut self.within.mass, n) {
            return false;
        }
        dense::forward_one(&self.within.mass, n, &mut self.drive);
        true
    }

    /// Rows for all servos and all dry friction of this step.
    pub(super) fn take_out(&mut self) {
        self.sticking.joints.clear();
        self.within.relaxed.fill(None);
        self.within.any = false;
        self.drive.copy_from_slice(&self.within.drive);
    }

    /// Works out what servos and dry friction without rows give; false: more than one of them may.
    pub(super) fn is_within(&mut self, rows: usize, time: f64) -> bool {
        let within = &mut self.within;
        if !within.any {
            return true;
        }
        let (n, first) = (self.drive.len(), self.mechanics.nv() - self.joints.len());
        within.change.copy_from_slice(&self.drive);
        if rows > 0 {
            within.change.iter_mut().zip(&self.pushes).for_each(|(change, push)| *change += push);
        }
        dense::backward(&within.mass, n, &mut within.change);
        within.impulses.clear();
        let mut all = true;
        for (servo, relaxed) in self.servos.iter().zip(&within.relaxed) {
            let impulse = relaxed.map_or(0.0, |Relaxed { softness, offset }| {
                let coordinate = first + servo.axis;
                -(self.speed[coordinate] + within.change[coordinate] + offset) / softness
            });
            let [low, high] = servo.limits.map(|limit| time * limit);
            // Written so that NaN is not within.
            all &= relaxed.is_none() || (low <= impulse && impulse <= high);
            within.impulses.push(impulse);
        }
        all && self.sticks(time)
    }

    /// Remembers the impulses of servos without rows.
    pub(super) fn remember_servos(&mut self) {
        if !self.within.any {
            return;
        }
        for index in 0..self.servos.len() {
            if !self.within.has_row(index) {
                let (slot, impulse) = (self.slot(RowSource::Servo(index)), self.within.impulses[index]);
                self.memory[slot] = impulse;
                self.asked[self.servos[index].axis] = impulse;
            }
        }
    }
}

/// A servo as a relaxed row; `None`: it has no gains. `q`, `v` of the joints; `inertia` by axis.
pub(super) fn relaxed(
    servo: &DriveServo,
    motors: &Motors,
    (q, v): (&[f64], &[f64]),
    inertia: &[f64],
    time: f64,
) -> Option<Relaxed> {
    let axis = servo.axis;
    let state = match axis.checked_sub(q.len()) {
        Some(k) => [motors.angle[k], motors.rate[k]],
        None => [q[axis], v[axis]],
    };
    servo.relaxed(state, 1.0 / inertia[axis], time)
}
