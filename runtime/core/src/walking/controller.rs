//! Walks by footsteps, zero moment point and divergent component: a state in, torques out.
use super::divergent::{DivergentBias, Point};
use super::elastic::Springs;
use super::gains::Gains;
use super::ground_forces::{Limits, Shared, StandingFoot, share};
use super::motion::{Motion, Wish};
use super::payload::Payload;
use super::payload_observer::PayloadObserver;
use super::robot::{BASE, Columns, Leg, MOST_VELOCITIES, Place, Sole, WalkingRobot};
use super::space::{Vector, about_z, add, along, product, scale, subtract, turn_between, zero};
use super::steps::{Foothold, Phase, Steps, Velocity, clamp};
use super::swing::Moving;
use crate::control::slices::get;
use crate::control::{Controller, JointCommand, Observation, Refusal};
use crate::model::Model;
use crate::real::Scalar;

/// Bend of a knee (rad) below which the robot goes down.
const BENT: f64 = 0.35;

/// A foot that has not found the ground goes down in so long (s) as far as it was lifted.
const LATE: f64 = 0.1;

/// What the controller does just now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walked<R> {
    /// Divergent component: measured, wished; m.
    pub divergent: [Point<R>; 2],
    /// Zero moment point: commanded, wished; m.
    pub zero_moment_point: [Point<R>; 2],
    /// The commanded one was at its limit.
    pub limited: bool,
    /// Where the centre of mass is on the ground, m.
    pub center: Point<R>,
    /// Of the centre of mass above the standing soles, m.
    pub height: R,
    /// Whether ground and drives could give what was wished.
    pub shared: Option<Shared<R>>,
}

/// See [`WalkingController::new`].
#[derive(Debug, Clone)]
pub struct WalkingController<M, R> {
    model: M,
    pub(super) robot: WalkingRobot<R>,
    pub(super) gains: Gains<R>,
    pub(super) steps: Option<Steps<R>>,
    pub(super) asked: Velocity<R>,
    /// x, y, z, yaw of the swinging foot.
    swinging: [Moving<R>; 4],
    /// Of the torso.
    yaw: Moving<R>,
    /// By how much the centre of mass is lower than it should be, so that no leg is stretched, m.
    lower: R,
    last: Option<R>,
    pub(super) bias: DivergentBias<R>,
    pub(super) walked: Option<Walked<R>>,
    pub(super) motion: Motion<R>,
    room: Columns<R>,
    torques: [R; MOST_VELOCITIES],
    pub(super) payload: Payload<R>,
    pub(super) observer: Option<PayloadObserver<R>>,
    springs: Springs<R>,
}

pub(super) fn two<R: Scalar>(f: impl Fn(usize) -> R) -> Point<R> {
    [f(0), f(1)]
}

pub(super) fn mean<R: Scalar>([a, b]: [R; 2]) -> R {
    R::constant(0.5) * (a + b)
}

fn upward<R: Scalar>(z: R) -> Vector<R> {
    [R::constant(0.0), R::constant(0.0), z]
}

/// Acceleration that makes an error and its rate vanish, critically damped, at a natural frequency (rad/s).
fn follow<R: Scalar>(frequency: R, error: Vector<R>, rate: Vector<R>) -> Vector<R> {
    along(scale(frequency * frequency, error), R::constant(2.0) * frequency, rate)
}

impl<M: Model<R>, R: Scalar> WalkingController<M, R> {
    /// Of a robot that stands when it is first asked.
    pub fn new(model: M, robot: WalkingRobot<R>, gains: Gains<R>) -> Self {
        let o = R::constant(0.0);
        Self {
            model,
            robot,
            gains,
            steps: None,
            asked: Velocity::zero(),
            swinging: [Moving::resting(o); 4],
            yaw: Moving::resting(o),
            lower: o,
            last: None,
            bias: DivergentBias::new(),
            walked: None,
            motion: Motion::default(),
            room: [o; 6 * MOST_VELOCITIES],
            torques: [o; MOST_VELOCITIES],
            payload: Payload::none(),
            observer: None,
            springs: Springs::new(),
        }
    }

    /// The functions, and which of them tell what.
    pub fn parts(&self) -> (&M, &WalkingRobot<R>) {
        (&self.model, &self.robot)
    }

    /// How it walks.
    pub fn gains(&self) -> &Gains<R> {
        &self.gains
    }

    /// How fast it shall walk from the next step on; what is not finite is not heard.
    pub fn walk(&mut self, velocity: Velocity<R>) {
        if velocity.is_finite() {
            self.asked = velocity;
        }
    }

    /// Forgets its steps: asked again it stands where it is, and goes on from there.
    pub(super) fn begin_anew(&mut self) {
        (self.steps, self.last, self.walked) = (None, None, None);
        (self.bias, self.lower) = (DivergentBias::new(), R::constant(0.0));
        self.springs = Springs::new();
        self.pause_learning();
    }

    /// The steps, once it was asked.
    pub fn steps(&self) -> Option<&Steps<R>> {
        self.steps.as_ref()
    }

    /// Height of the centre of mass above the standing soles, m, when it was last asked.
    pub fn height(&self) -> Option<R> {
        self.walked.as_ref().map(|walked| walked.height)
    }

    /// What it did last.
    pub fn walked(&self) -> Option<&Walked<R>> {
        self.walked.as_ref()
    }

    /// Goes from phase to phase.
    fn follow(&mut self, steps: &mut Steps<R>, place: &Place<R>, loads: Option<[R; 2]>, step: R) {
        let stride = self.gains.stride;
        steps.time = steps.time + step;
        let over = steps.time >= steps.duration;
        match steps.phase {
            Phase::Stand if !self.asked.is_zero() => {
                // The foot of the side to which it goes leads.
                let aside = self.asked.left + R::constant(0.1) * self.asked.turning;
                let stands = usize::from(aside < R::constant(0.0));
                steps.start(&stride, stands, self.gains.start);
            }
            Phase::Stand => {}
            Phase::Shift if over && self.may_lift(steps, place) => {
                steps.lift(&stride, &self.asked);
                let foot = steps.swings();
                let from = steps.foot(foot);
                let [x, y, z] = from.place;
                self.swinging = [x, y, z, from.yaw].map(Moving::resting);
            }
            Phase::Halt if over => steps.rest(),
            Phase::Shift | Phase::Halt => {}
            Phase::Swing => {
                let foot = steps.swings();
                let [right, left] = &place.soles;
                let sole = if foot == 0 { right } else { left };
                let shorter = -(-steps.duration).larger(-steps.usual);
                let late = steps.time > R::constant(0.6) * shorter;
                let touches = loads.map(|loads| get(&loads, foot) > self.gains.touch);
                // Without sensors the plan is believed.
                if late && touches.unwrap_or(over) {
                    let at = Foothold::of(&sole.pose, steps.goal.yaw);
                    self.bias.step();
                    steps.land(&stride, at, &self.asked);
                }
            }
        }
    }

    /// Accelerations of soles, torso and height.
    fn wish(
        &mut self,
        steps: &Steps<R>,
        place: &Place<R>,
        (zmp, beyond): (Point<R>, Point<R>),
        step: R,
    ) -> Wish<R> {
        let gains = self.gains;
        let swings = (steps.phase == Phase::Swing).then(|| steps.swings());
        let mut soles = [[zero(); 2]; 2];
        for (foot, (wish, sole)) in soles.iter_mut().zip(&place.soles).enumerate() {
            *wish = if swings == Some(foot) {
                self.swing(steps, step);
                self.swinging_sole(sole)
            } else {
                sole.velocity.map(|velocity| scale(-gains.brake, velocity))
            };
        }
        let torso = add(self.torso(steps, place, step), self.hip(beyond));
        let ground = self.ground(steps, place);
        let [center, velocity] = place.center;
        let missing = ground + gains.height - self.lower - get(&center, 2);
        let rise = gains.rise * gains.rise * missing - R::constant(2.0) * gains.rise * get(&velocity, 2);
        let [x, y] = zmp;
        Wish { soles, torso, rise, zero_moment_point: [x, y, ground] }
    }

    /// Linear and angular acceleration with which the swinging sole follows its reference.
    fn swinging_sole(&self, sole: &Sole<R>) -> [Vector<R>; 2] {
        let [linear, angular] = sole.velocity;
        let [x, y, z, yaw] = self.swinging;
        let p = [x, y, z].map(|x| x.place);
        let v = [x, y, z].map(|x| x.rate);
        let a = [x, y, z].map(|x| x.acceleration);
        let frequency = self.gains.swing;
        let pull = follow(frequency, subtract(p, sole.pose.position), subtract(v, linear));
        let turn = turn_between(sole.pose.turn, about_z(yaw.place));
        let twist = follow(frequency, turn, subtract(upward(yaw.rate), angular));
        [add(a, pull), add(upward(yaw.acceleration), twist)]
    }

    /// Angular acceleration of the torso, which looks between the feet.
    fn torso(&mut self, steps: &Steps<R>, place: &Place<R>, step: R) -> Vector<R> {
        let yaws = match steps.phase {
            Phase::Swing => [steps.foot(steps.stands).yaw, steps.goal.yaw],
            _ => [steps.foot(0).yaw, steps.foot(1).yaw],
        };
        self.yaw.toward(mean(yaws), steps.left().larger(R::constant(0.3)), step);
        let here = product(place.base.turn, self.robot.heading);
        let turn = turn_between(here, about_z(self.yaw.place));
        let torso = follow(self.gains.torso, turn, subtract(upward(self.yaw.rate), place.angular));
        add(torso, upward(self.yaw.acceleration))
    }

    /// Goes down where a leg would be stretched, up again slowly.
    fn stoop(&mut self, q: &[R], step: R) {
        let bend = self.robot.legs.iter().map(|leg| leg.bend(q));
        let missing = bend.fold(R::constant(0.0), |most, bend| most.larger(R::constant(BENT) - bend));
        // Of a leg of two equal parts the length changes by half of itself times the half angle's change, times its sine.
        let wished = R::constant(0.5) * self.gains.height * missing;
        let time = R::constant(if wished > self.lower { 0.05 } else { 0.5 });
        self.lower = self.lower + (wished - self.lower) * step / time;
    }

    /// Goes on with the reference of the swinging foot.
    fn swing(&mut self, steps: &Steps<R>, step: R) {
        let left = steps.left();
        let half = R::constant(0.5) * steps.duration;
        let [x, y, z] = steps.goal.place;
        let high = z.larger(get(&steps.foot(steps.swings()).place, 2)) + self.gains.lift;
        let [to_x, to_y, to_z, to_yaw] = &mut self.swinging;
        // Above its place a little before it comes down.
        let early = left - R::constant(0.1) * steps.duration;
        to_x.toward(x, early, step);
        to_y.toward(y, early, step);
        to_yaw.toward(steps.goal.yaw, early, step);
        if steps.time < half {
            to_z.toward(high, half - steps.time, step);
        } else if left > R::constant(0.0) {
            to_z.toward(z, left, step);
        } else {
            // The ground is lower than it should be: faster and faster, within bounds.
            to_z.at_rate(-self.gains.lift / R::constant(LATE), step);
        }
    }
}

impl<M: Model<R>, R: Scalar> Controller<R> for WalkingController<M, R> {
    fn command(
        &mut self,
        observed: &Observation<'_, R>,
        commands: &mut [JointCommand<R>],
    ) -> Result<(), Refusal> {
        let state = [observed.q, observed.v];
        let mut place = self.robot.place(&self.model, state, &mut self.room)?;
        let [center, _] = place.center;
        self.payload.shift(&mut place, self.motion.modelled);
        let step = self.since(observed.time);
        let mut steps = self.steps.unwrap_or_else(|| self.begin(&place));
        let load = |leg: &Leg<R>| observed.loads.get(leg.foot).copied();
        let loads = match self.robot.legs.each_ref().map(load) {
            [Some(right), Some(left)] => Some([right, left]),
            _ => None,
        };
        self.follow(&mut steps, &place, loads, step);
        let (zmp, beyond) = self.balance(&mut steps, &place, step);
        self.bias.update(self.divergent(&place), zmp, self.gains.stride.omega, step);
        self.stoop(observed.q, step);
        let wish = self.wish(&steps, &place, (zmp, beyond), step);
        self.steps = Some(steps);
        let posture = self.gains.posture;
        let goal = &self.robot.posture;
        let (q, v) = (observed.q, observed.v);
        let others = |column: usize| {
            let error = get(goal, column - BASE) - get(q, column + 1);
            posture * posture * error - R::constant(2.0) * posture * get(v, column)
        };
        let robot = (&self.robot, &self.model, &self.payload);
        self.motion.of(robot, state, &place, &wish, others)?;
        self.torques = self.motion.torques;
        self.learn(observed, (&place, center), loads, step);
        let shares = self.shares(&steps, &place, zmp);
        let gave = self.push(&steps, &place, shares);
        if let Some(walked) = &mut self.walked {
            walked.shared = Some(gave);
        }
        let joints = observed.joints(commands.len()).0;
        self.springs.drive(&self.robot, (joints, observed.motors), step, &mut self.torques);
        for (command, torque) in commands.iter_mut().zip(self.torques) {
            *command = JointCommand::Torque(torque);
        }
        Ok(())
    }
}

impl<M, R: Scalar> WalkingController<M, R> {
    /// Time since it was last asked, s; of a clock that stands still or jumps little or nothing.
    fn since(&mut self, time: R) -> R {
        let since = self.last.map_or(R::constant(0.0), |last| time - last);
        self.last = Some(time);
        clamp(since, R::constant(0.0), R::constant(0.02))
    }

    /// Stands where it is, and looks where its feet point.
    fn begin(&mut self, place: &Place<R>) -> Steps<R> {
        let [right, left] = &place.soles;
        let feet = Foothold::both(&right.pose, &left.pose);
        self.yaw = Moving::resting(mean(feet.map(|foot| foot.yaw)));
        Steps::standing(feet)
    }

    /// Torques that make the ground give what the motion takes.
    fn push(&mut self, steps: &Steps<R>, place: &Place<R>, shares: [R; 2]) -> Shared<R> {
        let joints = self.robot.legs.map(|leg| leg.joints.map(|column| column.saturating_sub(BASE)));
        let foot = |k: usize| {
            let (leg, sole, joints) = (self.robot.legs.get(k)?, place.soles.get(k)?, joints.get(k)?);
            Some(StandingFoot {
                sole: sole.pose,
                extent: leg.extent,
                joints,
                jacobian: &sole.columns,
                share: get(&shares, k),
            })
        };
        let Gains { friction, turning, least_load, .. } = self.gains;
        let count = self.robot.lengths[1].saturating_sub(BASE);
        let torque = self.robot.torque.get(..count).unwrap_or(&[]);
        let limits = Limits { friction, turning, least_load, torque };
        let torques = self.torques.get_mut(..count).unwrap_or(&mut []);
        let mut wrenches = [[R::constant(0.0); 6]; 2];
        let ground = self.motion.ground;
        match (foot(0), foot(1)) {
            (Some(right), Some(left)) if steps.phase != Phase::Swing => {
                share(&[right, left], ground, &limits, torques, &mut wrenches)
            }
            (Some(right), _) if steps.stands == 0 => share(&[right], ground, &limits, torques, &mut wrenches),
            (_, Some(left)) => share(&[left], ground, &limits, torques, &mut wrenches),
            _ => Shared::Refused,
        }
    }
}
