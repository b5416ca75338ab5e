//! What moves within which limits, and motions of it.
use super::basis::Basis;
use super::clearance::Clearance;
use crate::identify::BatchRegressor;
use crate::robot::Trajectory;
use crate::robot::{BaseKind, InverseDynamics, JointLayout};
use bipedc_effects::diagnostic::Diagnostic;
use std::cell::RefCell;

/// What a joint may do; what is unlimited is infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Smallest and largest position, rad or m.
    pub position: (f64, f64),
    /// rad/s or m/s.
    pub velocity: f64,
    /// rad/s² or m/s².
    pub acceleration: f64,
    /// N m or N.
    pub effort: f64,
}

impl Limits {
    /// Middle of the positions.
    pub fn center(&self) -> f64 {
        0.5 * (self.position.0 + self.position.1)
    }

    /// Half the way between the positions.
    pub fn room(&self) -> f64 {
        0.5 * (self.position.1 - self.position.0)
    }

    /// The same with a part of everything left unused.
    pub fn within(&self, margin: f64) -> Self {
        let (center, room, part) = (self.center(), self.room(), 1.0 - margin);
        Self {
            position: (center - part * room, center + part * room),
            velocity: part * self.velocity,
            acceleration: part * self.acceleration,
            effort: part * self.effort,
        }
    }
}

/// A robot whose base is fixed.
pub struct Machine<'a> {
    /// Joints.
    pub layout: &'a JointLayout,
    /// Base regressor of all joints' rows.
    pub regressor: &'a dyn BatchRegressor,
    /// Torques of all joints.
    pub dynamics: RefCell<&'a mut dyn InverseDynamics>,
    /// Indices of the joints that move; the others keep their posture.
    pub moving: &'a [usize],
    /// Positions of joints that do not move (of all joints, in order), rad or m.
    pub posture: &'a [f64],
    /// Of the joints that move, in order.
    pub limits: &'a [Limits],
    /// Feet that are kept apart; none: feet are not looked at.
    pub clearance: Option<&'a Clearance>,
}

impl Machine<'_> {
    /// Refuses what has no meaning.
    ///
    /// # Errors
    /// A base that moves; no joint that moves; limits that leave no room; lengths that do not fit.
    pub fn check(&self) -> Result<(), Diagnostic> {
        let joints = self.layout.joints.len();
        if self.layout.base != BaseKind::Fixed {
            return Err(Diagnostic::error("motions are designed for robots whose base is fixed")
                .help("bolt the robot down: --base fixed"));
        }
        if self.moving.is_empty() || self.moving.iter().any(|j| *j >= joints) {
            return Err(Diagnostic::error("no joint moves").help("name at least one joint of the robot"));
        }
        if self.posture.len() != joints || self.limits.len() != self.moving.len() {
            return Err(Diagnostic::error("postures and limits do not fit the robot's joints"));
        }
        for (&joint, limits) in self.moving.iter().zip(self.limits) {
            let name = &self.layout.joints[joint].name;
            let wrong = |what: &str, value: String| {
                Err(Diagnostic::error(format!("joint `{name}`: {what} {value}"))
                    .help("give limits that leave the joint room to move"))
            };
            let (lower, upper) = limits.position;
            if !(lower.is_finite() && upper.is_finite() && lower < upper) {
                return wrong("position limits are", format!("{lower} to {upper}"));
            }
            let others = [
                ("the velocity limit is", limits.velocity),
                ("the acceleration limit is", limits.acceleration),
                ("the effort limit is", limits.effort),
            ];
            if let Some((what, value)) = others.iter().find(|(_, limit)| limit.is_nan() || *limit <= 0.0) {
                return wrong(what, value.to_string());
            }
        }
        Ok(())
    }

    /// Number of coefficients of a motion: per moving joint those of its basis, in parts of half its range about its
    /// middle.
    pub fn coefficients(&self, basis: &Basis) -> usize {
        self.moving.len() * basis.len()
    }

    /// The posture of joints that do not move, `count` times.
    pub(super) fn resting(&self, count: usize) -> Trajectory {
        let mut states = Trajectory::new(self.layout);
        let still = vec![0.0; count * self.layout.joints.len()];
        states.extend([&self.posture.repeat(count), &still, &still]);
        states
    }

    /// The motion at `count` times from start to end.
    pub fn motion(&self, basis: &Basis, coefficients: &[f64], count: usize) -> Trajectory {
        let joints = self.layout.joints.len();
        let mut motion = self.resting(count);
        for i in 0..count {
            let time = basis.duration() * i as f64 / (count.max(2) - 1) as f64;
            let functions = basis.at(time);
            for ((&joint, limits), x) in
                self.moving.iter().zip(self.limits).zip(coefficients.chunks_exact(basis.len()))
            {
                let [q, v, a] = functions.each_ref().map(|f| limits.room() * dot(f, x));
                let at = i * joints + joint;
                (motion.q[at], motion.v[at], motion.a[at]) = (limits.center() + q, v, a);
            }
        }
        motion
    }

    /// Torques of all joints, `count × joints`, N m or N.
    ///
    /// # Errors
    /// Those of the model.
    pub fn torques(&self, motion: &Trajectory) -> Result<Vec<f64>, Diagnostic> {
        let mut tau = vec![0.0; motion.len() * self.layout.joints.len()];
        self.dynamics.borrow_mut().torques(&motion.batch(), &mut tau).map_err(|error| {
            Diagnostic::error(format!("the torques of the motion cannot be computed: {error}"))
        })?;
        Ok(tau)
    }
}

/// Sum of products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Of the coefficients of one joint, without the constant: smallest and largest position, largest velocity and
/// acceleration, all in units of half the joint's range.
pub fn shape_of(basis: &Basis, x: &[f64], count: usize) -> [(f64, f64); 3] {
    let mut extremes = [(0.0_f64, 0.0_f64); 3];
    for i in 0..count {
        let functions = basis.at(basis.duration() * i as f64 / (count.max(2) - 1) as f64);
        for ((low, high), f) in extremes.iter_mut().zip(&functions) {
            let value = dot(&f[1..], &x[1..]);
            (*low, *high) = (low.min(value), high.max(value));
        }
    }
    extremes
}
