//! Walking by what sensors tell: the estimator and the controller, one after the other.
use super::controller::WalkingController;
use super::estimator::{Estimated, Estimator, LegKinematics, Sensed, Settings};
use super::gains::Gains;
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
}

impl<M: Model<R>, R: Scalar> OnBoardWalker<M, R> {
    /// Of a robot that stands still on flat ground when it is first asked, which may slope; the world's plane is the ground's, its origin below the middle of its soles then.
    pub fn new(model: M, robot: WalkingRobot<R>, gains: Gains<R>, settings: Settings<R>) -> Self {
        let estimator = Estimator::new(settings, None);
        Self { estimator, controller: WalkingController::new(model, robot, gains) }
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

    /// Commands for what sensors say, always finite and within the drives' limits. Where the controller has none, joints are braked.
    pub fn step(&mut self, sensed: &Sensed<'_, R>, commands: &mut [JointCommand<R>]) -> Stepped<R> {
        let (model, robot) = self.controller.parts();
        let estimated = self.estimator.update(sensed, &Legs { model, robot });
        let loads = robot.legs_by_foot(sensed.load);
        let centers = robot.legs_by_foot(sensed.center);
        let observed = Observation::new(sensed.time, 0, self.estimator.q(), self.estimator.v());
        let observed = observed.with_loads(&loads).with_centers(&centers);
        let refusal = self.controller.command(&observed, commands).err();
        if refusal.is_some() {
            self.brake(commands);
        }
        Stepped { estimated, refusal }
    }

    /// Torques against the motion, as the estimator last knew it.
    fn brake(&self, commands: &mut [JointCommand<R>]) {
        let (_, robot) = self.controller.parts();
        let damping = self.controller.gains().passive;
        for (joint, command) in commands.iter_mut().enumerate() {
            let asked = -damping * get(self.estimator.v(), BASE + joint);
            let limit = get(&robot.torque, joint);
            let torque = -(-asked.larger(-limit)).larger(-limit);
            *command = JointCommand::Torque(if torque.is_finite() { torque } else { R::constant(0.0) });
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
}
