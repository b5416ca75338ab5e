//! Walking by what sensors tell: the estimator and the controller, one after the other.
use super::controller::WalkingController;
use super::estimator::{Estimated, Estimator, LegKinematics, Sensed, Settings};
use super::gains::Gains;
use super::guard::Guard;
use super::payload::Payload;
use super::robot::{BASE, Columns, MOST_VELOCITIES, WalkingRobot};
use super::space::{Pose, Vector, cross};
use super::steps::Velocity;
use crate::control::slices::{copy, get, set};
use crate::control::{Controller, JointCommand, Observation, Refusal};
use crate::model::{Argument, Model, State};
use crate::real::Scalar;

/// Coordinates of a floating base: place and quaternion.
const PLACE: usize = 7;

/// The legs of a model, seen from its base.
pub struct Legs<'a, M, R> {
    /// Its functions.
    pub model: &'a M,
    /// Which of them tell what.
    pub robot: &'a WalkingRobot<R>,
}

impl<M: Model<R>, R: Scalar> LegKinematics<R> for Legs<'_, M, R> {
    fn joints(&self) -> usize {
        let [_, nv] = self.robot.lengths;
        nv.saturating_sub(BASE)
    }

    fn sole(&self, foot: usize, joint_position: &[R], jacobian: &mut [[R; 6]]) -> Option<Pose<R>> {
        let (o, leg) = (R::constant(0.0), self.robot.legs.get(foot)?);
        let [nq, nv] = self.robot.lengths;
        let mut q = [o; PLACE + MOST_VELOCITIES];
        set(&mut q, PLACE - 1, R::constant(1.0));
        copy(joint_position, q.get_mut(PLACE..)?);
        let state = State::new().with(Argument::Q, q.get(..nq)?);
        let (mut origin, mut axes, mut room): (_, _, Columns<R>) = ([o; 3], [o; 9], [o; 6 * MOST_VELOCITIES]);
        self.model.evaluate(leg.position, &state, &mut origin).ok()?;
        self.model.evaluate(leg.rotation, &state, &mut axes).ok()?;
        self.model.evaluate(leg.jacobian, &state, room.get_mut(..6 * nv)?).ok()?;
        let pose = leg.of_link(origin, axes);
        let arm = [0, 1, 2].map(|k| get(&pose.position, k) - get(&origin, k));
        jacobian.fill([o; 6]);
        for column in leg.joints {
            let of = |first: usize| -> Vector<R> { [0, 1, 2].map(|k| get(&room, 6 * column + first + k)) };
            let (linear, angular) = (of(0), of(3));
            let ([x, y, z], [a, b, c]) = (linear, angular);
            let [dx, dy, dz] = cross(angular, arm);
            set(jacobian, column.saturating_sub(BASE), [x + dx, y + dy, z + dz, a, b, c]);
        }
        Some(pose)
    }
}

/// Sensors in, torques out.
#[derive(Debug, Clone)]
pub struct OnBoardWalker<M, R> {
    estimator: Estimator<R>,
    controller: WalkingController<M, R>,
    guard: Guard<R>,
}

impl<M: Model<R>, R: Scalar> OnBoardWalker<M, R> {
    /// Of a robot that stands still on flat ground when it is first asked, which may slope; the world's plane is the ground's, its origin below the middle of its soles then.
    pub fn new(model: M, robot: WalkingRobot<R>, gains: Gains<R>, settings: Settings<R>) -> Self {
        let estimator = Estimator::new(settings, None);
        Self { estimator, controller: WalkingController::new(model, robot, gains), guard: Guard::new() }
    }

    /// How fast it shall walk from the next step on.
    pub fn walk(&mut self, velocity: Velocity<R>) {
        self.controller.walk(velocity);
    }

    /// What it carries on its root link that the model does not know.
    pub fn carry(&mut self, payload: Payload<R>) {
        self.controller.carry(payload);
    }

    /// Whether to find out what it carries while it walks: needs centres of pressure.
    pub fn learn_payload(&mut self, learns: bool) {
        self.controller.learn_payload(learns);
    }

    /// What walks.
    pub fn controller(&self) -> &WalkingController<M, R> {
        &self.controller
    }

    /// Where it believes to be.
    pub fn estimator(&self) -> &Estimator<R> {
        &self.estimator
    }

    /// Torques for what sensors say, always finite, within the drives' limits and within [`TORQUE_CHANGE`](super::TORQUE_CHANGE) of them of the last call's.
    /// Where the controller has none, or was blind for [`BLIND_CALLS`](super::BLIND_CALLS), joints are braked, until [`SEEING_CALLS`](super::SEEING_CALLS)
    /// have told again where they are: then it stands up where it is.
    pub fn step(&mut self, sensed: &Sensed<'_, R>, commands: &mut [JointCommand<R>]) -> Stepped<R> {
        let (model, robot) = self.controller.parts();
        let sensed = &Sensed { load: robot.loads(sensed.load), ..*sensed };
        let estimated = self.estimator.update(sensed, &Legs { model, robot });
        let loads = robot.legs_by_foot(self.loads(sensed.load));
        let centers = robot.legs_by_foot(sensed.center);
        let braked = self.guard.judge(estimated.blind);
        if braked {
            self.controller.begin_anew();
        }
        if !sensed.load.iter().all(|load| load.is_finite()) {
            self.controller.pause_learning();
        }
        let observed = Observation::new(sensed.time, 0, self.estimator.q(), self.estimator.v());
        let observed = observed.with_loads(&loads).with_centers(&centers).with_motors(sensed.motor_position);
        let refusal = if braked { None } else { self.controller.command(&observed, commands).err() };
        if braked || refusal.is_some() {
            self.brake(sensed, estimated.blind, commands);
        }
        let (_, robot) = self.controller.parts();
        self.guard.pass(&robot.torque, commands);
        Stepped { estimated, refusal, braked: braked || refusal.is_some() }
    }

    /// What feet carry: one that does not say, what the other one does not.
    fn loads(&self, sensed: [R; 2]) -> [R; 2] {
        let [right, left] = sensed;
        // A foot touches from a tenth of the weight on.
        let rest =
            |known: R| (R::constant(10.0) * self.controller.gains().touch - known).larger(R::constant(0.0));
        match (right.is_finite(), left.is_finite()) {
            (true, false) => [right, rest(right)],
            (false, true) => [rest(left), left],
            _ => sensed,
        }
    }

    /// Torques against the motion of the joints, as far as it is known: what is measured, else what the estimator knows unless that is old.
    fn brake(&self, sensed: &Sensed<'_, R>, blind: bool, commands: &mut [JointCommand<R>]) {
        let (damping, o) = (self.controller.gains().passive, R::constant(0.0));
        for (joint, command) in commands.iter_mut().enumerate() {
            let measured = sensed.joint_velocity.and_then(|all| all.get(joint).copied());
            let known = if blind { o } else { get(self.estimator.v(), BASE + joint) };
            let velocity = measured.filter(|velocity| velocity.is_finite()).unwrap_or(known);
            *command = JointCommand::Torque(-damping * velocity);
        }
    }
}

/// What became of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepped<R> {
    /// Of the estimator.
    pub estimated: Estimated<R>,
    /// Why the controller had no commands, if it had none: joints are braked.
    pub refusal: Option<Refusal>,
    /// Joints are braked: the controller had no commands, or was blind for too long.
    pub braked: bool,
}
