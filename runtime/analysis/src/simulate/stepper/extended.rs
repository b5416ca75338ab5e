//! What a stepper has besides the model: motors of their own, coupled joints, servos, soles that turn, ground that is not level.
use super::sticking::Sticking;
use super::within_limits::WithinLimits;
use super::{MotionState, ROWS_OF_AXIS, Stepper};
use crate::simulate::dense::{self, row_length};
use crate::simulate::drives::Coupled;
use crate::simulate::ground::within;
use crate::simulate::heights::{Heights, Terrain};
use crate::simulate::motors::{MotorLaw, Motors};
use crate::simulate::proximal::Solver;
use crate::simulate::servo::DriveServo;
use crate::simulate::soles::Soles;
use bipedc_effects::diagnostic::Diagnostic;
use std::ops::Range;

impl Stepper<'_> {
    /// The same with these motors, each at its joint's angle and speed in `motion`: springs without load, play in its middle.
    ///
    /// # Errors
    /// Impossible numbers, joints that there are not, or two motors at one.
    pub fn with_motors(mut self, laws: Vec<MotorLaw>, motion: &MotionState) -> Result<Self, Diagnostic> {
        laws.iter().try_for_each(MotorLaw::check)?;
        let joints = self.joints.len();
        let taken = |k: usize| laws[..k].iter().any(|other| other.joint == laws[k].joint);
        if let Some(k) = (0..laws.len()).find(|&k| laws[k].joint >= joints || taken(k)) {
            return Err(Diagnostic::error(format!("motor {k} does not stand at a joint of its own")));
        }
        let (q, v) = (&motion.q[motion.q.len() - joints..], &motion.v[motion.v.len() - joints..]);
        self.motors = Motors::new(laws);
        for (k, law) in self.motors.laws.iter().enumerate() {
            (self.motors.angle[k], self.motors.rate[k]) = (q[law.joint], v[law.joint]);
        }
        Ok(self.with_room())
    }

    /// The same with pairs of joints whose accelerations act on each other.
    ///
    /// # Errors
    /// Joints that there are not.
    pub fn with_coupled(mut self, coupled: Vec<Coupled>) -> Result<Self, Diagnostic> {
        let joints = self.joints.len();
        if coupled
            .iter()
            .any(|pair| pair.joints[0] == pair.joints[1] || pair.joints.iter().any(|j| *j >= joints))
        {
            return Err(Diagnostic::error("a coupling is not of two joints of the robot"));
        }
        self.coupled = coupled;
        Ok(self)
    }

    /// The same with soles that turn on the spot where the moment about the vertical through their middle exceeds
    /// `turning` (m) times the normal force: while three corners touch, their friction acts in the middle. `points` are the
    /// contact points of each.
    ///
    /// # Errors
    /// A robot in the plane, points that there are not, or an impossible number.
    pub fn with_soles(mut self, points: Vec<Range<usize>>, turning: f64) -> Result<Self, Diagnostic> {
        within("turning", turning, 0.0, f64::MAX, "m")?;
        let known =
            |points: &Range<usize>| points.start < points.end && points.end <= self.mechanics.points();
        if self.mechanics.tangents() != 2 || !points.iter().all(known) {
            return Err(Diagnostic::error("soles that turn are those of feet in space"));
        }
        self.soles = Soles { points, turning, places: vec![0.0; 2 * self.mechanics.points()] };
        Ok(self.with_room())
    }

    /// The same on ground that is not level, below a robot that begins at a place (m); `feet`: contact points of each.
    #[must_use]
    pub fn with_heights(mut self, heights: Heights, feet: Vec<Range<usize>>, start: [f64; 2]) -> Self {
        self.terrain =
            Some(Terrain::new(heights, feet, [self.mechanics.points(), self.mechanics.tangents()], start));
        self
    }

    /// Place for the largest problem, so that no step allocates.
    pub(super) fn with_room(mut self) -> Self {
        let (n, points, tangents) = (self.size(), self.mechanics.points(), self.mechanics.tangents());
        let axes = self.joints.len() + self.motors.laws.len();
        let rows = points * (1 + tangents) + ROWS_OF_AXIS * axes + 3 * self.soles.points.len();
        self.problem.reserve(rows);
        self.solver = Solver::with_room(rows);
        self.servos = Vec::with_capacity(axes);
        self.sources = Vec::with_capacity(rows);
        self.memory = vec![0.0; rows];
        self.earlier = vec![0.0; rows];
        self.mass = vec![0.0; n * row_length(n)];
        self.speed = vec![0.0; n];
        self.inertia = vec![0.0; axes];
        self.stops = vec![0.0; self.motors.laws.len()];
        self.asked = vec![0.0; axes];
        self.middle = vec![0.0; n];
        self.drive = vec![0.0; n];
        self.directions = Vec::with_capacity(n * row_length(rows));
        self.by_row = Vec::with_capacity(rows * row_length(n));
        self.before = Vec::with_capacity(rows);
        self.mean = Vec::with_capacity(rows);
        self.pushes = vec![0.0; n];
        self.filled = Vec::with_capacity(n);
        self.within = WithinLimits::with_room(n, axes);
        self.sticking = Sticking::with_room(n, self.joints.len(), rows);
        self
    }

    /// Number of coordinates: those of the model, then the motors. Forces are given for all of them.
    pub fn size(&self) -> usize {
        self.mechanics.nv() + self.motors.laws.len()
    }

    /// Angle of a motor of its own (rad) and its speed (rad/s), as seen at the joint.
    pub fn motor(&self, index: usize) -> [f64; 2] {
        [self.motors.angle[index], self.motors.rate[index]]
    }

    /// Torque of a motor's spring, or at the ends of its play, on the joint in the last step, N m.
    pub fn spring_torque(&self, index: usize) -> f64 {
        self.motors.torque[index]
    }

    /// Laws of the motors from now on, such as friction that depends on the load.
    pub fn motors_mut(&mut self) -> &mut [MotorLaw] {
        &mut self.motors.laws
    }

    /// The servos of the next steps: at most one per axis, others are passed over.
    pub fn set_servos(&mut self, servos: impl Iterator<Item = DriveServo>) {
        let axes = self.inertia.len();
        self.servos.clear();
        for servo in servos {
            let free = self.servos.iter().all(|other| other.axis != servo.axis);
            if servo.axis < axes && free {
                self.servos.push(servo);
            }
        }
    }

    /// Torque of an axis' servo in the last step, N m.
    pub fn servo_torque(&self, axis: usize, time: f64) -> f64 {
        self.memory[self.slot_of_axis(axis) + 3] / time
    }

    /// The torque that an axis' servo would have given in the last step without limits, N m.
    pub fn servo_asked(&self, axis: usize, time: f64) -> f64 {
        self.asked[axis] / time
    }

    /// Impulse of dry friction on an axis in the last step, N m s.
    pub fn dry_impulse(&self, axis: usize) -> f64 {
        self.memory[self.slot_of_axis(axis)]
    }

    /// Velocity per impulse of an axis when nothing touches, 1/(kg m²): of the last step.
    pub fn mobility(&self, axis: usize) -> f64 {
        // With D = Lᵀ L: (D⁻¹)_aa = |L⁻ᵀ e_a|².
        let n = self.size();
        let mut column = vec![0.0; n];
        column[self.coordinate(axis)] = 1.0;
        dense::forward_one(&self.mass, n, &mut column);
        column.iter().map(|x| x * x).sum()
    }
}
