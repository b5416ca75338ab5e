//! Joints that stick do not move: they leave the equations of a step, without rows of their own.
//!
//! A joint whose dry friction held it in the last step is held in this one, `Δv = −v⁻` (next to nothing): its row and column of the mass
//! matrix become those of the unit matrix, and no other coordinate feels it. What friction had to give follows from its row of
//! `D (v⁺ − v) = p + W Λ`. If that is more than it may, the step is solved again with rows for all; in the next step the joint keeps
//! its own for as long as friction is at its limit. Of a robot that stands by its dry joints the base alone is left.
//!
//! What feet and joints could share (see `sharing`) is left to the joints altogether; with rows all but some thousandths of it is.
use super::{RowSource, Stepper};
use crate::simulate::dense::{self, row_length};
use crate::simulate::servo::DriveServo;

/// Friction closer to its limit than this part of it keeps its row, and so does a joint whose stop alone takes more.
const MARGIN: f64 = 0.05;

/// What joints without rows need.
#[derive(Debug, Clone, Default)]
pub(super) struct Sticking {
    /// Which joints.
    pub joints: Vec<usize>,
    /// Their rows of `W`, of the length of the problem's rows.
    directions: Vec<f64>,
    /// What friction gives at each, N m s.
    impulses: Vec<f64>,
    /// `D (v⁺ − v)`
    momentum: Vec<f64>,
}

impl Sticking {
    /// For so many coordinates, joints and rows.
    pub fn with_room(size: usize, joints: usize, rows: usize) -> Self {
        Self {
            momentum: vec![0.0; size],
            joints: Vec::with_capacity(joints),
            directions: Vec::with_capacity(joints * rows),
            impulses: Vec::with_capacity(joints),
        }
    }
}

impl Stepper<'_> {
    /// Lists the joints that stick if they did in the last step; not those near a stop, or that a servo holds by a row.
    pub(super) fn find_sticking(&mut self, q: &[f64], time: f64) {
        self.sticking.joints.clear();
        let (reach, first) = (self.reach(time), self.mechanics.nv() - self.joints.len());
        for (j, joint) in self.joints.iter().enumerate() {
            let least = time * joint.dry[0].min(joint.dry[1]);
            if least <= 0.0 {
                continue;
            }
            let friction = self.memory[self.slot_of_axis(j)];
            let sticks = friction.abs() < (1.0 - MARGIN) * least
                && (self.speed[first + j] * self.inertia[j]).abs() < MARGIN * least;
            let near_stop =
                [false, true].iter().any(|upper| joint.way(*upper, q[j]).is_some_and(|way| way <= reach));
            let held = |(index, servo): (usize, &DriveServo)| servo.axis == j && self.within.has_row(index);
            if sticks && !near_stop && !self.servos.iter().enumerate().any(held) {
                self.sticking.joints.push(j);
            }
        }
    }

    /// Takes the joints that stick out of the mass matrix with servos and of what pushes.
    pub(super) fn hold_sticking(&mut self) {
        let (n, first) = (self.size(), self.mechanics.nv() - self.joints.len());
        let (mass, length) = (&mut self.within.mass, row_length(n));
        for joint in &self.sticking.joints {
            let (own, speed) = (first + joint, self.speed[first + joint]);
            if speed != 0.0 {
                for (i, drive) in self.drive.iter_mut().enumerate() {
                    *drive += mass[own.max(i) * length + own.min(i)] * speed;
                }
            }
            mass[own * length..][..own].fill(0.0);
            mass[own * length..]
                .iter_mut()
                .skip(own)
                .step_by(length)
                .take(n - own)
                .for_each(|entry| *entry = 0.0);
            mass[own * (length + 1)] = 1.0;
        }
        for joint in &self.sticking.joints {
            self.drive[first + joint] = -self.speed[first + joint];
        }
    }

    /// Takes them out of the directions of the rows; `mean` are the velocities γ⁻ before, and without them after.
    pub(super) fn take_sticking_out_of_rows(&mut self) {
        let (rows, first) = (self.problem.rows(), self.mechanics.nv() - self.joints.len());
        let length = row_length(rows);
        self.sticking.directions.clear();
        for joint in &self.sticking.joints {
            let speed = self.speed[first + joint];
            let own = &mut self.directions[(first + joint) * length..][..rows];
            self.mean.iter_mut().zip(&*own).for_each(|(mean, own)| *mean -= own * speed);
            self.sticking.directions.extend_from_slice(own);
            own.fill(0.0);
        }
    }

    /// Works out what friction gives where joints stick, from the change of all velocities; false: more than it may.
    pub(super) fn sticks(&mut self, time: f64) -> bool {
        let (rows, first) = (self.problem.rows(), self.mechanics.nv() - self.joints.len());
        let (within, sticking) = (&self.within, &mut self.sticking);
        if sticking.joints.is_empty() {
            return true;
        }
        inertia_times(&within.inertia, &within.change, &mut sticking.momentum);
        sticking.impulses.clear();
        let mut all = true;
        for (at, &joint) in sticking.joints.iter().enumerate() {
            let own = first + joint;
            let directions = sticking.directions.get(at * rows..(at + 1) * rows).unwrap_or_default();
            let by_rows = dense::dot(directions, &self.problem.impulse[..directions.len()]);
            let servos = self.servos.iter().zip(&within.impulses).filter(|(servo, _)| servo.axis == joint);
            let by_servos: f64 = servos.map(|(_, impulse)| impulse).sum();
            let impulse = sticking.momentum[own] - within.push[own] - by_rows - by_servos;
            let [positive, negative] = self.joints[joint].dry;
            // Written so that NaN does not stick.
            all &= -time * positive <= impulse && impulse <= time * negative;
            sticking.impulses.push(impulse);
        }
        all
    }

    /// Remembers what friction gave where joints stick.
    pub(super) fn remember_sticking(&mut self) {
        for at in 0..self.sticking.joints.len() {
            let slot = self.slot(RowSource::Dry(self.sticking.joints[at]));
            self.memory[slot] = self.sticking.impulses[at];
        }
    }
}

/// A symmetric matrix, of which the lower triangle is read, times a vector.
fn inertia_times(inertia: &[f64], x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (i, row) in inertia.chunks_exact(row_length(x.len()).max(1)).take(x.len()).enumerate() {
        out[..i].iter_mut().zip(row).for_each(|(out, entry)| *out += entry * x[i]);
        out[i] += dense::dot(&row[..=i], &x[..=i]);
    }
}
