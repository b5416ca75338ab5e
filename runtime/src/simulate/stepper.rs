//! Moreau's time stepping: impulses over a step, no matter whether something strikes, slides or lets go in it.
use super::account::{Account, Done};
use super::dense::{self, Stretch};
use super::drives::Coupled;
use super::ground::{Ground, JointLaw, within};
use super::mechanics::{Frame, Mechanics};
use super::motors::{MotorLaw, Motors, embed};
use super::problem::{Block, Law, Problem};
use super::proximal::{Solved, Solver, Tolerance};
use super::servo::DriveServo;
use super::soles::Soles;
use crate::diagnostic::Diagnostic;
use std::ops::Range;

/// Configuration and velocity at a time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// s
    pub time: f64,
    /// As the model's.
    pub q: Vec<f64>,
    /// As the model's.
    pub v: Vec<f64>,
}

/// What a step did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stepped {
    /// Of the contact problem; all zero without contact.
    pub solved: Solved,
    /// Closed contact points.
    pub contacts: usize,
    /// Kinetic energy after the impulses minus that of the same step without them, J. Never positive without
    /// restitution; clearly positive: Newton's law of impact made energy, which it can where tangential and normal
    /// restitution differ (Kane and Levinson, 1985).
    pub work: f64,
}

/// Where a row comes from: a contact point, or an axis (joints in their order, then motors of their own).
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    Point(usize),
    Dry(usize),
    /// Stops of a joint, or of the play of a motor.
    Lower(usize),
    Upper(usize),
    /// Index of the servo.
    Servo(usize),
    /// A corner of a flat sole, whose friction is that of the sole.
    Normal(usize),
    /// Index of the sole.
    Sole(usize),
}

/// Rows that one axis can have.
const ROWS_OF_AXIS: usize = 4;

/// Steps a robot on the ground through time (4.7), (4.14).
///
/// One step of length `h`: with the midpoint `q_M = q + ½ h v` and the points and limits that are closed there,
/// `D(q_M) (v⁺ − v) = h (τ − H(q_M, ṽ)) + W Λ`, where Λ and `ξ = γ⁺ + e γ⁻` obey Signorini's and Coulomb's laws; then
/// `q⁺ = q_M + ½ h v⁺`. `ṽ` is the velocity at the midpoint as it would be without contact, which makes motion without
/// contact second order. Damping of joints is part of the left side and never unstable.
///
/// Motors of their own ([`Self::with_motors`]) are further coordinates after those of the model. Their angles and speeds are kept
/// here.
pub struct Stepper<'a> {
    mechanics: Mechanics<'a>,
    ground: Ground,
    joints: Vec<JointLaw>,
    motors: Motors,
    coupled: Vec<Coupled>,
    servos: Vec<DriveServo>,
    soles: Soles,
    tolerance: Tolerance,
    solver: Solver,
    problem: Problem,
    sources: Vec<Source>,
    /// Impulses of the last step by source; where the next one starts.
    memory: Vec<f64>,
    /// Heights of the points at the last midpoint, m.
    gaps: Vec<f64>,
    mass: Vec<f64>,
    /// Of the model alone, where motors make the other one larger.
    inner: Vec<f64>,
    /// `v` and the speeds of the motors before the step.
    speed: Vec<f64>,
    /// Diagonal of the mass matrix, by axis.
    inertia: Vec<f64>,
    /// Impulses at the play of the motors.
    stops: Vec<f64>,
    /// Impulses that servos asked for, by axis.
    asked: Vec<f64>,
    bias: Vec<f64>,
    middle: Vec<f64>,
    drive: Vec<f64>,
    /// `W` of the closed rows, one row per coordinate; then `L⁻ᵀ W`.
    directions: Vec<f64>,
    /// Where its rows are not zero.
    stretches: Vec<Stretch>,
    normal: Vec<f64>,
    tangential: Vec<f64>,
    /// γ⁻ of the closed rows.
    before: Vec<f64>,
    /// Twice the mean of their velocities without and with impulses.
    mean: Vec<f64>,
    bookkeeping: Option<Bookkeeping>,
}

/// Work so far, with the room to sum it.
#[derive(Debug, Clone, Default)]
struct Bookkeeping {
    account: Account,
    /// γ⁺ of the closed rows.
    after: Vec<f64>,
    /// Height at the midpoint of every row that is the normal of a point.
    heights: Vec<f64>,
    /// By block: whether it is a servo's.
    driven: Vec<bool>,
}

impl<'a> Stepper<'a> {
    /// On this ground. `joints` in the order of the model's.
    ///
    /// # Errors
    /// Impossible numbers of ground or joints.
    pub fn new(
        mechanics: Mechanics<'a>,
        ground: Ground,
        joints: Vec<JointLaw>,
        tolerance: Tolerance,
    ) -> Result<Self, Diagnostic> {
        ground.check()?;
        if joints.len() != mechanics.joints() {
            return Err(Diagnostic::error(format!(
                "{} joint laws were given for {} joints",
                joints.len(),
                mechanics.joints()
            )));
        }
        joints.iter().try_for_each(JointLaw::check)?;
        let (nv, points, tangents) = (mechanics.nv(), mechanics.points(), mechanics.tangents());
        Ok(Self {
            mechanics,
            ground,
            joints,
            motors: Motors::default(),
            coupled: Vec::new(),
            servos: Vec::new(),
            soles: Soles::default(),
            tolerance,
            solver: Solver::default(),
            problem: Problem::default(),
            sources: Vec::new(),
            memory: Vec::new(),
            gaps: vec![0.0; points],
            mass: Vec::new(),
            inner: vec![0.0; nv * nv],
            speed: Vec::new(),
            inertia: Vec::new(),
            stops: Vec::new(),
            asked: Vec::new(),
            bias: vec![0.0; nv],
            middle: Vec::new(),
            drive: Vec::new(),
            directions: Vec::new(),
            normal: vec![0.0; nv * points],
            tangential: vec![0.0; nv * points * tangents],
            before: Vec::new(),
            mean: Vec::new(),
            stretches: Vec::new(),
            bookkeeping: None,
        }
        .with_room())
    }

    /// The same with these motors, each at its joint's angle and speed in `motion`: springs without load, play in its middle.
    ///
    /// # Errors
    /// Impossible numbers, joints that there are not, or two motors at one.
    pub fn with_motors(mut self, laws: Vec<MotorLaw>, motion: &Motion) -> Result<Self, Diagnostic> {
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

    /// Place for the largest problem, so that no step allocates.
    fn with_room(mut self) -> Self {
        let (n, points, tangents) = (self.size(), self.mechanics.points(), self.mechanics.tangents());
        let axes = self.joints.len() + self.motors.laws.len();
        let rows = points * (1 + tangents) + ROWS_OF_AXIS * axes + 3 * self.soles.points.len();
        self.problem.reserve(rows);
        self.solver = Solver::with_room(rows);
        self.servos = Vec::with_capacity(axes);
        self.sources = Vec::with_capacity(rows);
        self.memory = vec![0.0; rows];
        self.mass = vec![0.0; n * n];
        self.speed = vec![0.0; n];
        self.inertia = vec![0.0; axes];
        self.stops = vec![0.0; self.motors.laws.len()];
        self.asked = vec![0.0; axes];
        self.middle = vec![0.0; n];
        self.drive = vec![0.0; n];
        self.directions = Vec::with_capacity(n * rows);
        self.before = Vec::with_capacity(rows);
        self.mean = Vec::with_capacity(rows);
        self.stretches = Vec::with_capacity(n);
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

    /// The same, and the work of everything is summed from now on: [`Self::account`].
    #[must_use]
    pub fn accounted(mut self) -> Self {
        let room = || Vec::with_capacity(self.before.capacity());
        let driven = Vec::with_capacity(self.before.capacity());
        self.bookkeeping =
            Some(Bookkeeping { account: Account::default(), after: room(), heights: room(), driven });
        self
    }

    /// What acts and is not part of [`Self::account`].
    pub(super) fn beyond_books(&self) -> Option<&'static str> {
        if !self.motors.laws.is_empty() {
            return Some("motors behind springs or play");
        }
        if !self.coupled.is_empty() {
            return Some("joints coupled by an inertia");
        }
        (!self.soles.points.is_empty()).then_some("soles that turn")
    }

    /// Work so far; `None` unless [`Self::accounted`].
    pub fn account(&self) -> Option<&Account> {
        self.bookkeeping.as_ref().map(|books| &books.account)
    }

    /// The model.
    pub fn mechanics(&self) -> &Mechanics<'a> {
        &self.mechanics
    }

    /// The ground from now on.
    pub fn ground_mut(&mut self) -> &mut Ground {
        &mut self.ground
    }

    /// Laws of the joints.
    pub fn joints(&self) -> &[JointLaw] {
        &self.joints
    }

    /// Laws of the joints from now on, such as friction that depends on the load.
    pub fn joints_mut(&mut self) -> &mut [JointLaw] {
        &mut self.joints
    }

    /// Heights of the contact points at the middle of the last step, m.
    pub fn gaps(&self) -> &[f64] {
        &self.gaps
    }

    /// Impulse of the ground on a point in the last step, world axes, N s.
    pub fn impulse(&self, point: usize) -> [f64; 3] {
        let tangents = self.mechanics.tangents();
        let own = &self.memory[point * (1 + tangents)..(point + 1) * (1 + tangents)];
        [own[1], if tangents == 2 { own[2] } else { 0.0 }, own[0]]
    }

    /// Impulse of dry friction and limits on a joint in the last step, N m s.
    pub fn joint_impulse(&self, joint: usize) -> f64 {
        let own = &self.memory[self.slot_of_axis(joint)..][..ROWS_OF_AXIS];
        own[0] + own[1] - own[2]
    }

    /// One step of `time` seconds under generalised forces (N, N m; in the order of `v`, then of the motors). Allocates
    /// nothing.
    ///
    /// # Errors
    /// The mass matrix is not positive definite or the state became infinite: the step is too long, or controller
    /// gains too high for it.
    pub fn step(&mut self, motion: &mut Motion, force: &[f64], time: f64) -> Result<Stepped, Diagnostic> {
        let (nv, n) = (self.mechanics.nv(), self.size());
        self.mechanics.advance(&mut motion.q, &motion.v, 0.5 * time, Frame::Start);
        self.motors.advance(0.5 * time);
        self.speed[..nv].copy_from_slice(&motion.v);
        self.speed[nv..].copy_from_slice(&self.motors.rate);
        self.free_motion(motion, force, time)?;
        self.close(motion);
        let rows: usize = self.problem.rows();
        let mut stepped = Stepped::default();
        if rows > 0 {
            self.assemble(motion, time);
            stepped.solved = self.solver.solve(&mut self.problem, &self.tolerance);
            let touches = |source: &&Source| matches!(source, Source::Point(_) | Source::Normal(_));
            stepped.contacts = self.sources.iter().filter(touches).count();
        }
        stepped.work = self.apply(rows);
        self.velocities_after(rows);
        dense::backward(&self.mass, n, &mut self.drive);
        self.book(motion, force, time);
        for (v, change) in self.speed.iter_mut().zip(&self.drive) {
            *v += change;
        }
        self.finish(motion, time);
        if self.speed.iter().all(|v| v.is_finite()) { Ok(stepped) } else { Err(too_long(motion.time)) }
    }

    /// The second half of the motion.
    fn finish(&mut self, motion: &mut Motion, time: f64) {
        let (nv, joints) = (self.mechanics.nv(), self.joints.len());
        for k in 0..self.stops.len() {
            let own = &self.memory[self.slot_of_axis(joints + k)..][..ROWS_OF_AXIS];
            self.stops[k] = own[2] - own[1];
        }
        let (q, v) = (&motion.q[motion.q.len() - joints..], &motion.v[nv - joints..]);
        self.motors.finish(&self.speed, q, v, nv - joints, &self.stops, time);
        motion.v.copy_from_slice(&self.speed[..nv]);
        self.mechanics.advance(&mut motion.q, &motion.v, 0.5 * time, Frame::End);
        self.motors.advance(0.5 * time);
        motion.time += time;
    }

    /// Factors D at the midpoint; `drive` becomes `L⁻ᵀ h (τ − H)`.
    fn free_motion(&mut self, motion: &Motion, force: &[f64], time: f64) -> Result<(), Diagnostic> {
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
    fn push(&mut self, motion: &Motion, force: &[f64], time: f64, middle: bool) {
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

    /// Finds the closed points and limits at the midpoint and makes place for them.
    fn close(&mut self, motion: &Motion) {
        self.mechanics.distances(&motion.q, &mut self.gaps);
        self.sources.clear();
        let mut rows = self.touch();
        let first = motion.q.len() - self.joints.len();
        let before = self.sources.len();
        for (j, joint) in self.joints.iter().enumerate() {
            let q = motion.q[first + j];
            let closed = [
                (joint.dry != [0.0; 2], Source::Dry(j)),
                (joint.limits.is_some_and(|limits| q <= limits[0]), Source::Lower(j)),
                (joint.limits.is_some_and(|limits| q >= limits[1]), Source::Upper(j)),
            ];
            self.sources.extend(closed.into_iter().filter(|(closed, _)| *closed).map(|(_, source)| source));
        }
        for (k, motor) in self.motors.laws.iter().enumerate() {
            let (axis, plays) = (self.joints.len() + k, motor.gap > 0.0);
            let closed = [
                (motor.dry != [0.0; 2], Source::Dry(axis)),
                (plays, Source::Lower(axis)),
                (plays, Source::Upper(axis)),
            ];
            self.sources.extend(closed.into_iter().filter(|(closed, _)| *closed).map(|(_, source)| source));
        }
        self.sources.extend((0..self.servos.len()).map(Source::Servo));
        rows += self.sources.len() - before;
        self.problem.clear(rows);
    }

    /// Lists the closed points: how many rows they have.
    fn touch(&mut self) -> usize {
        let size = 1 + self.mechanics.tangents();
        let (mut rows, mut point) = (0, 0);
        while point < self.gaps.len() {
            if let Some(sole) = self.soles.flat(point, &self.gaps) {
                let points = self.soles.points[sole].clone();
                point = points.end;
                let closed = points.filter(|point| self.gaps[*point] <= 0.0);
                let before = self.sources.len();
                self.sources.extend(closed.map(Source::Normal));
                self.sources.push(Source::Sole(sole));
                rows += self.sources.len() - before + 2;
                continue;
            }
            if self.gaps[point] <= 0.0 {
                self.sources.push(Source::Point(point));
                rows += size;
            }
            point += 1;
        }
        rows
    }

    /// Delassus' matrix, free velocities, laws and the guess.
    fn assemble(&mut self, motion: &Motion, time: f64) {
        let (n, rows) = (self.size(), self.problem.rows());
        self.directions.clear();
        self.directions.resize(n * rows, 0.0);
        if matches!(self.sources.first(), Some(Source::Point(_) | Source::Normal(_))) {
            self.mechanics.directions(&motion.q, &mut self.normal, &mut self.tangential);
            if !self.soles.points.is_empty() {
                self.mechanics.positions(&motion.q, &mut self.soles.places);
            }
        }
        let mut row = 0;
        for index in 0..self.sources.len() {
            let source = self.sources[index];
            let law = self.law(source, time);
            self.direct(source, row);
            let block = Block { first: row, law };
            let slot = self.slot(source);
            let guess = &self.memory[slot..slot + block.size()];
            self.problem.impulse[row..row + block.size()].copy_from_slice(guess);
            self.problem.blocks.push(block);
            row += block.size();
        }
        self.free_velocities();
        dense::gram(&self.directions, rows, &self.stretches, &mut self.problem.delassus);
        self.soften(motion, time);
    }

    fn law(&self, source: Source, time: f64) -> Law {
        match source {
            Source::Point(_) => Law::Contact {
                friction: self.ground.friction,
                tangents: self.mechanics.tangents(),
                cone: self.ground.cone,
            },
            Source::Dry(axis) => {
                let joints = self.joints.len();
                let [positive, negative] =
                    if axis < joints { self.joints[axis].dry } else { self.motors.laws[axis - joints].dry };
                Law::Limited { low: -time * positive, high: time * negative }
            }
            Source::Normal(_) | Source::Lower(_) | Source::Upper(_) => Law::Unilateral,
            Source::Sole(sole) => {
                let points = self.soles.points[sole].clone();
                Law::Sole {
                    friction: self.ground.friction,
                    turning: self.soles.turning,
                    normals: self.gaps[points].iter().filter(|gap| **gap <= 0.0).count(),
                    cone: self.ground.cone,
                }
            }
            Source::Servo(index) => {
                let [low, high] = self.servos[index].limits;
                Law::Limited { low: time * low, high: time * high }
            }
        }
    }

    /// Writes the directions of a source into the columns from `row` on.
    fn direct(&mut self, source: Source, row: usize) {
        let (nv, rows, tangents) = (self.mechanics.nv(), self.problem.rows(), self.mechanics.tangents());
        let (axis, sign) = match source {
            Source::Point(point) => {
                for i in 0..nv {
                    let target = &mut self.directions[i * rows + row..i * rows + row + 1 + tangents];
                    target[0] = self.normal[point * nv + i];
                    for (k, target) in target[1..].iter_mut().enumerate() {
                        *target = self.tangential[(point * tangents + k) * nv + i];
                    }
                }
                return;
            }
            Source::Normal(point) => {
                for i in 0..nv {
                    self.directions[i * rows + row] = self.normal[point * nv + i];
                }
                return;
            }
            Source::Sole(sole) => {
                for (point, parts) in self.soles.parts(sole) {
                    for (k, part) in parts.iter().enumerate() {
                        for i in 0..nv {
                            let along = |axis: usize| self.tangential[(2 * point + axis) * nv + i];
                            self.directions[i * rows + row + k] += part[0] * along(0) + part[1] * along(1);
                        }
                    }
                }
                return;
            }
            Source::Dry(axis) => (axis, 1.0),
            Source::Servo(index) => (self.servos[index].axis, 1.0),
            Source::Lower(axis) | Source::Upper(axis) => {
                let sign = if matches!(source, Source::Upper(_)) { -1.0 } else { 1.0 };
                // Play lies between a motor and its joint.
                if let Some(k) = axis.checked_sub(self.joints.len()) {
                    let joint = self.coordinate(self.motors.laws[k].joint);
                    self.directions[joint * rows + row] = -sign;
                }
                (axis, sign)
            }
        };
        let coordinate = self.coordinate(axis);
        self.directions[coordinate * rows + row] = sign;
    }

    /// `c = γ_free + e γ⁻`; `directions` becomes `L⁻ᵀ W`.
    fn free_velocities(&mut self) {
        let (n, rows) = (self.size(), self.problem.rows());
        self.before.clear();
        self.before.resize(rows, 0.0);
        for (w, v) in self.directions.chunks_exact(rows).zip(&self.speed) {
            self.before.iter_mut().zip(w).for_each(|(gamma, w)| *gamma += w * v);
        }
        self.stretches.clear();
        self.stretches.extend(self.directions.chunks_exact(rows).map(Stretch::of));
        dense::forward(&self.mass, n, &mut self.directions, rows, &mut self.stretches);
        self.problem.free.copy_from_slice(&self.before);
        for (y, z) in self.directions.chunks_exact(rows).zip(&self.drive) {
            self.problem.free.iter_mut().zip(y).for_each(|(gamma, y)| *gamma += y * z);
        }
        if self.ground.compliance.is_some() {
            return;
        }
        let [normal, tangential] = [self.ground.normal_restitution, self.ground.tangential_restitution];
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            let (first, size) = (block.first, block.size());
            // Where the tangential rows begin.
            let slides = match source {
                Source::Point(_) | Source::Normal(_) => {
                    self.problem.free[first] += normal * self.before[first];
                    first + 1
                }
                Source::Sole(_) => first,
                _ => continue,
            };
            for row in slides..first + size {
                self.problem.free[row] += tangential * self.before[row];
            }
        }
    }

    /// Relaxed rows: soft ground, springs behind play, servos.
    ///
    /// Spring and damper below each corner are taken at the end of the step: `λ = −k (κ_M + ½ h γ⁺) − d γ⁺`, written as
    /// `γ⁺ + Λ/(h (½ h k + d)) + k κ_M/(½ h k + d) = 0`, the relaxed constraint of (4.17). And the recovery from
    /// penetration of hard ground.
    fn soften(&mut self, motion: &Motion, time: f64) {
        let (rows, joints) = (self.problem.rows(), self.joints.len());
        let (q, v) = (&motion.q[motion.q.len() - joints..], &motion.v[motion.v.len() - joints..]);
        for (block, source) in self.problem.blocks.iter_mut().zip(&self.sources) {
            let row = block.first;
            let relaxed = match *source {
                Source::Point(point) | Source::Normal(point) => {
                    Some(self.ground.relaxed(self.gaps[point], time))
                }
                Source::Lower(axis) | Source::Upper(axis) if axis >= joints => {
                    self.motors.stop(axis - joints, matches!(source, Source::Upper(_)), q, v)
                }
                Source::Servo(index) => {
                    let (servo, axis) = (&self.servos[index], self.servos[index].axis);
                    let state = match axis.checked_sub(joints) {
                        Some(k) => [self.motors.angle[k], self.motors.rate[k]],
                        None => [q[axis], v[axis]],
                    };
                    let relaxed = servo.relaxed(state, 1.0 / self.inertia[axis], time);
                    self.asked[axis] = relaxed.map_or(0.0, |relaxed| relaxed.softness);
                    if relaxed.is_none() {
                        // Without gains what is left is constant.
                        let given = time * servo.bias.max(servo.limits[0]).min(servo.limits[1]);
                        block.law = Law::Limited { low: given, high: given };
                    }
                    relaxed
                }
                _ => None,
            };
            if let Some(relaxed) = relaxed {
                self.problem.delassus[row * rows + row] += relaxed.softness;
                self.problem.free[row] += relaxed.offset;
            }
        }
    }

    /// Adds the impulses to `drive` (in the coordinates `L⁻ᵀ`), remembers them, and gives the work of those of
    /// ground, stops and friction.
    fn apply(&mut self, rows: usize) -> f64 {
        self.memory.fill(0.0);
        let (mut work, mut row) = (0.0, 0);
        for index in 0..self.sources.len() {
            let size = self.problem.blocks[index].size();
            let slot = self.slot(self.sources[index]);
            self.memory[slot..slot + size].copy_from_slice(&self.problem.impulse[row..row + size]);
            if let Source::Servo(servo) = self.sources[index] {
                // Within its limits ξ = 0; beyond, ξ is what is left of the row `γ⁺ + softness Λ + offset`.
                let axis = self.servos[servo].axis;
                let softness = self.asked[axis];
                let missing = if softness > 0.0 { self.problem.velocity[row] / softness } else { 0.0 };
                self.asked[axis] = self.problem.impulse[row] - missing;
            }
            row += size;
        }
        self.share();
        if rows == 0 {
            return work;
        }
        // Twice the mean of the velocities without and with all impulses: what each impulse works against.
        self.mean.clear();
        self.mean.extend(self.before.iter().map(|gamma| 2.0 * gamma));
        for (drive, y) in self.drive.iter_mut().zip(self.directions.chunks_exact(rows)) {
            let push: f64 = y.iter().zip(&self.problem.impulse).map(|(y, impulse)| y * impulse).sum();
            let both = 2.0 * *drive + push;
            self.mean.iter_mut().zip(y).for_each(|(gamma, y)| *gamma += y * both);
            *drive += push;
        }
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            // Springs and servos give energy by their nature.
            if !self.is_drive(*source) {
                let rows = block.first..block.first + block.size();
                let of = rows.map(|row| 0.5 * self.mean[row] * self.problem.impulse[row]);
                work += of.sum::<f64>();
            }
        }
        work
    }

    /// Spreads the friction of flat soles over their corners, for those who ask for the forces on points.
    fn share(&mut self) {
        for &source in &self.sources {
            let Source::Sole(sole) = source else { continue };
            let slot = self.slot(source);
            let friction = [self.memory[slot], self.memory[slot + 1]];
            let points = self.soles.points[sole].clone();
            let closed = self.gaps[points.clone()].iter().filter(|gap| **gap <= 0.0).count() as f64;
            for point in points.filter(|point| self.gaps[*point] <= 0.0) {
                self.memory[3 * point + 1] = friction[0] / closed;
                self.memory[3 * point + 2] = friction[1] / closed;
            }
        }
    }

    /// γ⁺ of the closed rows, for the books; before `drive` leaves the coordinates `L⁻ᵀ`.
    fn velocities_after(&mut self, rows: usize) {
        let Some(books) = &mut self.bookkeeping else { return };
        books.after.clear();
        books.heights.clear();
        if rows == 0 {
            return;
        }
        books.after.extend_from_slice(&self.before);
        for (y, z) in self.directions.chunks_exact(rows).zip(&self.drive) {
            books.after.iter_mut().zip(y).for_each(|(gamma, y)| *gamma += y * z);
        }
        books.heights.resize(rows, 0.0);
        books.driven.clear();
        books.driven.extend(self.sources.iter().map(|source| matches!(source, Source::Servo(_))));
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            if let Source::Point(point) = *source {
                books.heights[block.first] = self.gaps[point];
            }
        }
    }

    /// A row of a servo or of the play of a motor.
    fn is_drive(&self, source: Source) -> bool {
        match source {
            Source::Servo(_) => true,
            Source::Lower(axis) | Source::Upper(axis) => axis >= self.joints.len(),
            Source::Point(_) | Source::Normal(_) | Source::Sole(_) | Source::Dry(_) => false,
        }
    }

    /// Adds the step to the books; `drive` is the change of the velocities.
    fn book(&mut self, motion: &Motion, force: &[f64], time: f64) {
        let Some(books) = &mut self.bookkeeping else { return };
        books.account.add(&Done {
            time,
            velocity: &motion.v,
            change: &self.drive,
            force,
            joints: &self.joints,
            blocks: &self.problem.blocks,
            impulse: &self.problem.impulse,
            before: &self.before,
            after: &books.after,
            heights: &books.heights,
            driven: &books.driven,
            soft: self.ground.compliance,
        });
    }

    /// Where a source's impulses are remembered.
    fn slot(&self, source: Source) -> usize {
        match source {
            Source::Point(point) | Source::Normal(point) => point * (1 + self.mechanics.tangents()),
            Source::Sole(sole) => self.slot_of_axis(self.inertia.len()) + 3 * sole,
            Source::Dry(axis) => self.slot_of_axis(axis),
            Source::Lower(axis) => self.slot_of_axis(axis) + 1,
            Source::Upper(axis) => self.slot_of_axis(axis) + 2,
            Source::Servo(index) => self.slot_of_axis(self.servos[index].axis) + 3,
        }
    }

    fn slot_of_axis(&self, axis: usize) -> usize {
        self.mechanics.points() * (1 + self.mechanics.tangents()) + ROWS_OF_AXIS * axis
    }

    /// Motors follow the joints, which are the last coordinates of the model.
    fn coordinate(&self, axis: usize) -> usize {
        self.mechanics.nv() - self.joints.len() + axis
    }
}

fn too_long(time: f64) -> Diagnostic {
    Diagnostic::error(format!("at {time} s the motion is no longer finite"))
        .help("shorten the step; if a controller drives the robot, lower its gains")
}
