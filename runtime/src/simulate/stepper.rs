//! Moreau's time stepping: impulses over a step, no matter whether something strikes, slides or lets go in it.
use super::account::{Account, Done};
use super::dense::{self, Stretch};
use super::ground::{Ground, JointLaw};
use super::mechanics::{Frame, Mechanics};
use super::problem::{Block, Law, Problem};
use super::proximal::{Solved, Solver, Tolerance};
use crate::diagnostic::Diagnostic;

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

/// Where a row comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    Point(usize),
    Dry(usize),
    Lower(usize),
    Upper(usize),
}

/// Steps a robot on the ground through time (4.7), (4.14).
///
/// One step of length `h`: with the midpoint `q_M = q + ½ h v` and the points and limits that are closed there,
/// `D(q_M) (v⁺ − v) = h (τ − H(q_M, ṽ)) + W Λ`, where Λ and `ξ = γ⁺ + e γ⁻` obey Signorini's and Coulomb's laws; then
/// `q⁺ = q_M + ½ h v⁺`. `ṽ` is the velocity at the midpoint as it would be without contact, which makes motion without
/// contact second order. Damping of joints is part of the left side and never unstable.
pub struct Stepper<'a> {
    mechanics: Mechanics<'a>,
    ground: Ground,
    joints: Vec<JointLaw>,
    tolerance: Tolerance,
    solver: Solver,
    problem: Problem,
    sources: Vec<Source>,
    /// Impulses of the last step by source; where the next one starts.
    memory: Vec<f64>,
    /// Heights of the points at the last midpoint, m.
    gaps: Vec<f64>,
    mass: Vec<f64>,
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
        let rows = points * (1 + tangents) + 3 * joints.len();
        let mut problem = Problem::default();
        problem.reserve(rows);
        Ok(Self {
            mechanics,
            ground,
            joints,
            tolerance,
            solver: Solver::with_room(rows),
            problem,
            sources: Vec::with_capacity(rows),
            memory: vec![0.0; rows],
            gaps: vec![0.0; points],
            mass: vec![0.0; nv * nv],
            bias: vec![0.0; nv],
            middle: vec![0.0; nv],
            drive: vec![0.0; nv],
            directions: Vec::with_capacity(nv * rows),
            stretches: Vec::with_capacity(nv),
            normal: vec![0.0; nv * points],
            tangential: vec![0.0; nv * points * tangents],
            before: Vec::with_capacity(rows),
            bookkeeping: None,
        })
    }

    /// The same, and the work of everything is summed from now on: [`Self::account`].
    #[must_use]
    pub fn accounted(mut self) -> Self {
        let room = || Vec::with_capacity(self.before.capacity());
        self.bookkeeping = Some(Bookkeeping { account: Account::default(), after: room(), heights: room() });
        self
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
        let at = |source| self.memory[self.slot(source)];
        at(Source::Dry(joint)) + at(Source::Lower(joint)) - at(Source::Upper(joint))
    }

    /// One step of `time` seconds under generalised forces (N, N m; in the order of `v`). Allocates nothing.
    ///
    /// # Errors
    /// The mass matrix is not positive definite or the state became infinite: the step is too long, or controller
    /// gains too high for it.
    pub fn step(&mut self, motion: &mut Motion, force: &[f64], time: f64) -> Result<Stepped, Diagnostic> {
        let nv = self.mechanics.nv();
        self.mechanics.advance(&mut motion.q, &motion.v, 0.5 * time, Frame::Start);
        self.free_motion(motion, force, time)?;
        self.close(motion);
        let rows: usize = self.problem.rows();
        let mut stepped = Stepped::default();
        if rows > 0 {
            self.assemble(motion, time);
            stepped.solved = self.solver.solve(&mut self.problem, &self.tolerance);
            stepped.contacts = self.sources.iter().filter(|s| matches!(s, Source::Point(_))).count();
        }
        stepped.work = self.apply(rows);
        self.velocities_after(rows);
        dense::backward(&self.mass, nv, &mut self.drive);
        self.book(motion, force, time);
        for (v, change) in motion.v.iter_mut().zip(&self.drive) {
            *v += change;
        }
        self.mechanics.advance(&mut motion.q, &motion.v, 0.5 * time, Frame::End);
        motion.time += time;
        if motion.v.iter().all(|v| v.is_finite()) { Ok(stepped) } else { Err(too_long(motion.time)) }
    }

    /// Factors D at the midpoint; `drive` becomes `L⁻ᵀ h (τ − H)`.
    fn free_motion(&mut self, motion: &Motion, force: &[f64], time: f64) -> Result<(), Diagnostic> {
        let nv = self.mechanics.nv();
        let first = nv - self.joints.len();
        self.mechanics.mass_matrix(&motion.q, &mut self.mass);
        for (j, joint) in self.joints.iter().enumerate() {
            let i = first + j;
            self.mass[i * nv + i] += joint.rotor_inertia + 0.5 * time * joint.damping;
        }
        if !dense::factor(&mut self.mass, nv) {
            return Err(too_long(motion.time));
        }
        self.push(motion, force, time, false);
        self.middle.copy_from_slice(&self.drive);
        dense::backward(&self.mass, nv, &mut self.middle);
        for (middle, v) in self.middle.iter_mut().zip(&motion.v) {
            *middle = v + 0.5 * *middle;
        }
        self.push(motion, force, time, true);
        Ok(())
    }

    /// `drive = L⁻ᵀ h (τ − H(q_M, v) − damping)`, with the velocity `middle` in H or the present one.
    fn push(&mut self, motion: &Motion, force: &[f64], time: f64, middle: bool) {
        let nv = self.mechanics.nv();
        let first = nv - self.joints.len();
        let v = if middle { &self.middle } else { &motion.v };
        self.mechanics.bias(&motion.q, v, &mut self.bias);
        for ((drive, force), bias) in self.drive.iter_mut().zip(force).zip(&self.bias) {
            *drive = time * (force - bias);
        }
        for (j, joint) in self.joints.iter().enumerate() {
            self.drive[first + j] -= time * joint.damping * motion.v[first + j];
        }
        dense::forward_one(&self.mass, nv, &mut self.drive);
    }

    /// Finds the closed points and limits at the midpoint and makes place for them.
    fn close(&mut self, motion: &Motion) {
        self.mechanics.distances(&motion.q, &mut self.gaps);
        self.sources.clear();
        let tangents = self.mechanics.tangents();
        let mut rows = 0;
        for (point, &gap) in self.gaps.iter().enumerate() {
            if gap <= 0.0 {
                self.sources.push(Source::Point(point));
                rows += 1 + tangents;
            }
        }
        let first = motion.q.len() - self.joints.len();
        for (j, joint) in self.joints.iter().enumerate() {
            let q = motion.q[first + j];
            let closed = [
                (joint.dry != [0.0; 2], Source::Dry(j)),
                (joint.limits.is_some_and(|limits| q <= limits[0]), Source::Lower(j)),
                (joint.limits.is_some_and(|limits| q >= limits[1]), Source::Upper(j)),
            ];
            for (_, source) in closed.into_iter().filter(|(closed, _)| *closed) {
                self.sources.push(source);
                rows += 1;
            }
        }
        self.problem.clear(rows);
    }

    /// Delassus' matrix, free velocities, laws and the guess.
    fn assemble(&mut self, motion: &Motion, time: f64) {
        let (nv, rows, tangents) = (self.mechanics.nv(), self.problem.rows(), self.mechanics.tangents());
        self.directions.clear();
        self.directions.resize(nv * rows, 0.0);
        if matches!(self.sources.first(), Some(Source::Point(_))) {
            self.mechanics.directions(&motion.q, &mut self.normal, &mut self.tangential);
        }
        let first = nv - self.joints.len();
        let mut row = 0;
        for index in 0..self.sources.len() {
            let source = self.sources[index];
            let law = match source {
                Source::Point(point) => {
                    for i in 0..nv {
                        let target = &mut self.directions[i * rows + row..i * rows + row + 1 + tangents];
                        target[0] = self.normal[point * nv + i];
                        for (k, target) in target[1..].iter_mut().enumerate() {
                            *target = self.tangential[(point * tangents + k) * nv + i];
                        }
                    }
                    Law::Contact { friction: self.ground.friction, tangents, cone: self.ground.cone }
                }
                Source::Dry(j) => {
                    self.directions[(first + j) * rows + row] = 1.0;
                    let [positive, negative] = self.joints[j].dry;
                    Law::Limited { low: -time * positive, high: time * negative }
                }
                Source::Lower(j) => {
                    self.directions[(first + j) * rows + row] = 1.0;
                    Law::Unilateral
                }
                Source::Upper(j) => {
                    self.directions[(first + j) * rows + row] = -1.0;
                    Law::Unilateral
                }
            };
            let block = Block { first: row, law };
            let slot = self.slot(source);
            let guess = &self.memory[slot..slot + block.size()];
            self.problem.impulse[row..row + block.size()].copy_from_slice(guess);
            self.problem.blocks.push(block);
            row += block.size();
        }
        self.free_velocities(motion);
        dense::gram(&self.directions, rows, &self.stretches, &mut self.problem.delassus);
        self.soften(time);
    }

    /// `c = γ_free + e γ⁻`; `directions` becomes `L⁻ᵀ W`.
    fn free_velocities(&mut self, motion: &Motion) {
        let (nv, rows) = (self.mechanics.nv(), self.problem.rows());
        self.before.clear();
        self.before.resize(rows, 0.0);
        for (w, v) in self.directions.chunks_exact(rows).zip(&motion.v) {
            self.before.iter_mut().zip(w).for_each(|(gamma, w)| *gamma += w * v);
        }
        self.stretches.clear();
        self.stretches.extend(self.directions.chunks_exact(rows).map(Stretch::of));
        dense::forward(&self.mass, nv, &mut self.directions, rows, &mut self.stretches);
        self.problem.free.copy_from_slice(&self.before);
        for (y, z) in self.directions.chunks_exact(rows).zip(&self.drive) {
            self.problem.free.iter_mut().zip(y).for_each(|(gamma, y)| *gamma += y * z);
        }
        if self.ground.compliance.is_some() {
            return;
        }
        let [normal, tangential] = [self.ground.normal_restitution, self.ground.tangential_restitution];
        for block in &self.problem.blocks {
            if let Law::Contact { tangents, .. } = block.law {
                self.problem.free[block.first] += normal * self.before[block.first];
                for row in block.first + 1..block.first + 1 + tangents {
                    self.problem.free[row] += tangential * self.before[row];
                }
            }
        }
    }

    /// Spring and damper below each corner, taken at the end of the step: `λ = −k (κ_M + ½ h γ⁺) − d γ⁺`, written as
    /// `γ⁺ + Λ/(h (½ h k + d)) + k κ_M/(½ h k + d) = 0`, the relaxed constraint of (4.17). And the recovery from
    /// penetration of hard ground.
    fn soften(&mut self, time: f64) {
        let rows = self.problem.rows();
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            let Source::Point(point) = *source else { continue };
            let (row, gap) = (block.first, self.gaps[point]);
            match self.ground.compliance {
                Some(soft) => {
                    let stiff = 0.5 * time * soft.stiffness + soft.damping;
                    self.problem.delassus[row * rows + row] += 1.0 / (time * stiff);
                    self.problem.free[row] += soft.stiffness * gap / stiff;
                }
                None => self.problem.free[row] += self.ground.recovery * gap,
            }
        }
    }

    /// Adds the impulses to `drive` (in the coordinates `L⁻ᵀ`), remembers them, and gives their work.
    fn apply(&mut self, rows: usize) -> f64 {
        self.memory.fill(0.0);
        let (mut work, mut row) = (0.0, 0);
        for index in 0..self.sources.len() {
            let size = self.problem.blocks[index].size();
            let slot = self.slot(self.sources[index]);
            self.memory[slot..slot + size].copy_from_slice(&self.problem.impulse[row..row + size]);
            row += size;
        }
        if rows == 0 {
            return work;
        }
        for (gamma, impulse) in self.before.iter().zip(&self.problem.impulse) {
            work += gamma * impulse;
        }
        for (drive, y) in self.drive.iter_mut().zip(self.directions.chunks_exact(rows)) {
            let push: f64 = y.iter().zip(&self.problem.impulse).map(|(y, impulse)| y * impulse).sum();
            work += push * (*drive + 0.5 * push);
            *drive += push;
        }
        work
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
        for (block, source) in self.problem.blocks.iter().zip(&self.sources) {
            if let Source::Point(point) = *source {
                books.heights[block.first] = self.gaps[point];
            }
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
            soft: self.ground.compliance,
        });
    }

    /// Where a source's impulses are remembered.
    fn slot(&self, source: Source) -> usize {
        let size = 1 + self.mechanics.tangents();
        let joints = self.mechanics.points() * size;
        match source {
            Source::Point(point) => point * size,
            Source::Dry(j) => joints + 3 * j,
            Source::Lower(j) => joints + 3 * j + 1,
            Source::Upper(j) => joints + 3 * j + 2,
        }
    }
}

fn too_long(time: f64) -> Diagnostic {
    Diagnostic::error(format!("at {time} s the motion is no longer finite"))
        .help("shorten the step; if a controller drives the robot, lower its gains")
}
