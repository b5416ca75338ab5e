//! Moreau's time stepping: impulses over a step, no matter whether something strikes, slides or lets go in it.
mod contact;
mod energy_accounting;
mod extended;
mod free_motion;
mod rows;
mod sticking;
mod within_limits;

pub(super) use rows::CLOSED;

use super::carried::Carried;
use super::dense::{self, Filled};
use super::drives::Coupled;
use super::ground::{Ground, JointLaw};
use super::heights::Terrain;
use super::mechanics::{Frame, Mechanics};
use super::motors::Motors;
use super::problem::Problem;
use super::proximal::{Solved, Solver, Tolerance};
use super::servo::DriveServo;
use super::soles::Soles;
use bipedc_effects::diagnostic::Diagnostic;

/// Configuration and velocity at a time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MotionState {
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
    /// Contact points on the ground, or coming down onto it.
    pub contacts: usize,
    /// Kinetic energy after the impulses minus that of the same step without them, J; servos within their limits and friction of
    /// joints that stick push in both.
    /// Never positive without restitution.
    pub work: f64,
    /// What Newton's law of impact made, J: `½ Λ · (γ⁻ + γ⁺)` on hard ground, as far as it is in `work` too. Never positive
    /// where tangential and normal restitution are equal; it can be where they differ (Kane and Levinson, 1985). `work` has the
    /// forces of the step besides, such as those of a turning body: an error of the stepping, of first order.
    pub made: f64,
}

/// Where a row comes from: a contact point, or an axis (joints in their order, then motors of their own).
#[derive(Debug, Clone, Copy, PartialEq)]
enum RowSource {
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

impl RowSource {
    /// Whether its first row is the normal of a point.
    fn is_normal(&self) -> bool {
        matches!(self, RowSource::Point(_) | RowSource::Normal(_))
    }
}

/// What the step before left behind.
#[derive(Debug, Clone, Default)]
struct LastStep {
    /// What ground and stops changed of the velocity, in the last step and in the one before it.
    by_contact: [Vec<f64>; 2],
    /// s
    time: f64,
}

/// Rows that one axis can have.
const ROWS_OF_AXIS: usize = 4;

/// Steps a robot on the ground through time (4.7), (4.14).
///
/// One step of length `h`: with the midpoint `q_M = q + ½ h v` and the points and limits that are closed there,
/// `D(q_M) (v⁺ − v) = h (τ − H(q_M, ṽ)) + W Λ`, where Λ and `ξ = γ⁺ + e γ⁻` obey Signorini's and Coulomb's laws; then
/// `q⁺ = q_M + ½ h v⁺`. `ṽ` is the velocity at the midpoint: in the air as it would be without contact, which makes motion
/// without contact second order; on the ground and at stops with what these did in the last step, because without it, under the torques that
/// carry the robot, light feet would turn so fast that `H(q_M, ṽ)` were another one. Damping of joints is part of the left side and never unstable.
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
    within: within_limits::WithinLimits,
    sticking: sticking::Sticking,
    soles: Soles,
    terrain: Option<Terrain>,
    tolerance: Tolerance,
    solver: Solver,
    problem: Problem,
    sources: Vec<RowSource>,
    /// Impulses of the last step by source; where the next one starts.
    memory: Vec<f64>,
    /// The same of the step before.
    earlier: Vec<f64>,
    /// Heights of the points at the last midpoint, m.
    gaps: Vec<f64>,
    /// Points up to this height have rows, m.
    near: f64,
    /// Whether `normal` and `tangential` are of this step.
    directed: bool,
    /// Rows as long as [`dense::row_length`] says; then its factor L.
    mass: Vec<f64>,
    /// Of the model alone.
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
    /// At the middle of the step, without contact.
    middle: Vec<f64>,
    /// The same with it, of the model alone.
    around: Vec<f64>,
    last: LastStep,
    drive: Vec<f64>,
    /// `W` of the closed rows, one row per coordinate (of [`dense::row_length`]); then `L⁻ᵀ W`.
    directions: Vec<f64>,
    /// `W` of the closed rows, one after the other, each of [`dense::row_length`].
    by_row: Vec<f64>,
    /// Where `directions` are not zero.
    filled: Vec<Filled>,
    normal: Vec<f64>,
    tangential: Vec<f64>,
    /// γ⁻ of the closed rows.
    before: Vec<f64>,
    /// The same without what sticks; then twice the mean of their velocities without and with impulses.
    mean: Vec<f64>,
    /// What the impulses do to `drive`.
    pushes: Vec<f64>,
    energy_accounting: Option<energy_accounting::EnergyAccounting>,
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
            within: within_limits::WithinLimits::default(),
            sticking: sticking::Sticking::default(),
            soles: Soles::default(),
            terrain: None,
            tolerance,
            solver: Solver::default(),
            problem: Problem::default(),
            sources: Vec::new(),
            memory: Vec::new(),
            earlier: Vec::new(),
            gaps: vec![0.0; points],
            near: 0.0,
            directed: false,
            mass: Vec::new(),
            inner: vec![0.0; nv * nv],
            speed: Vec::new(),
            inertia: Vec::new(),
            stops: Vec::new(),
            asked: Vec::new(),
            bias: vec![0.0; nv],
            middle: Vec::new(),
            around: vec![0.0; nv],
            last: LastStep { by_contact: [vec![0.0; nv], vec![0.0; nv]], time: 0.0 },
            drive: Vec::new(),
            directions: Vec::new(),
            by_row: Vec::new(),
            normal: vec![0.0; nv * points],
            tangential: vec![0.0; nv * points * tangents],
            before: Vec::new(),
            mean: Vec::new(),
            pushes: Vec::new(),
            filled: Vec::new(),
            energy_accounting: None,
        }
        .with_room())
    }

    /// The root link carries this from now on.
    pub fn carry(&mut self, carried: Carried) {
        self.mechanics.carry(carried);
    }

    /// The robot.
    pub fn mechanics(&self) -> &Mechanics<'a> {
        &self.mechanics
    }

    /// The ground.
    pub fn ground(&self) -> &Ground {
        &self.ground
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

    /// Heights of the contact points above the ground at the middle of the last step, m.
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
    pub fn step(
        &mut self,
        motion: &mut MotionState,
        force: &[f64],
        time: f64,
    ) -> Result<Stepped, Diagnostic> {
        let (nv, n) = (self.mechanics.nv(), self.size());
        // Somebody may have changed the velocity.
        let goes_on = self.last.time == time && self.speed[..nv] == motion.v[..];
        self.mechanics.advance(&mut motion.q, &motion.v, 0.5 * time, Frame::Start);
        self.motors.advance(0.5 * time);
        self.speed[..nv].copy_from_slice(&motion.v);
        self.speed[nv..].copy_from_slice(&self.motors.rate);
        self.free_motion(motion, force, time, goes_on)?;
        self.put_in(motion, time);
        let mut stepped = Stepped { solved: self.push_back(motion, time), ..Stepped::default() };
        if !self.is_within(self.problem.rows(), time) {
            self.take_out();
            stepped.solved = self.push_back(motion, time);
        }
        let rows = self.problem.rows();
        stepped.work = self.apply(rows);
        stepped.contacts = (0..self.gaps.len()).filter(|point| self.touches(*point)).count();
        stepped.made = stepped.work.min(self.made()).max(0.0);
        self.velocities_after(rows);
        dense::backward(self.within.factor_or(&self.mass), n, &mut self.drive);
        self.book(motion, force, time);
        let at_stop = |source: &RowSource| matches!(source, RowSource::Lower(_) | RowSource::Upper(_));
        self.remember(stepped.contacts > 0 || self.sources.iter().any(at_stop), time);
        for (v, change) in self.speed.iter_mut().zip(&self.drive) {
            *v += change;
        }
        self.finish(motion, time);
        if self.speed.iter().all(|v| v.is_finite()) { Ok(stepped) } else { Err(too_long(motion.time)) }
    }

    /// Finds the impulses of what is closed, or closes in this step, and what they do to `drive`.
    fn push_back(&mut self, motion: &MotionState, time: f64) -> Solved {
        self.close(motion, time);
        if self.problem.rows() == 0 {
            return Solved::default();
        }
        self.assemble(motion, time);
        let solved = self.solve();
        dense::dots(&self.directions, &self.problem.impulse, &mut self.pushes);
        solved
    }

    /// The second half of the motion.
    fn finish(&mut self, motion: &mut MotionState, time: f64) {
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

    /// Adds the impulses' `pushes` to `drive` (in the coordinates `L⁻ᵀ`), remembers them, and gives the work of those of
    /// ground, stops and friction.
    fn apply(&mut self, rows: usize) -> f64 {
        std::mem::swap(&mut self.memory, &mut self.earlier);
        self.memory.fill(0.0);
        let (mut work, mut row) = (0.0, 0);
        for index in 0..self.sources.len() {
            let size = self.problem.blocks[index].size();
            let slot = self.slot(self.sources[index]);
            self.memory[slot..slot + size].copy_from_slice(&self.problem.impulse[row..row + size]);
            if let RowSource::Servo(servo) = self.sources[index] {
                // Within its limits ξ = 0; beyond, ξ is what is left of the row `γ⁺ + softness Λ + offset`.
                let axis = self.servos[servo].axis;
                let softness = self.asked[axis];
                let missing = if softness > 0.0 { self.problem.velocity[row] / softness } else { 0.0 };
                self.asked[axis] = self.problem.impulse[row] - missing;
            }
            row += size;
        }
        self.remember_servos();
        self.remember_sticking();
        self.share();
        if rows == 0 {
            return work;
        }
        // Twice the mean of the velocities without and with all impulses: what each impulse works against.
        self.mean.iter_mut().for_each(|gamma| *gamma *= 2.0);
        for (drive, push) in self.drive.iter_mut().zip(&mut self.pushes) {
            let both = 2.0 * *drive + *push;
            *drive += *push;
            *push = both;
        }
        dense::add_rows(&self.directions, &self.pushes, &mut self.mean);
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
}

fn too_long(time: f64) -> Diagnostic {
    Diagnostic::error(format!("at {time} s the motion is no longer finite"))
        .help("shorten the step; if a controller drives the robot, lower its gains")
}
