//! Walks by footsteps, zero moment point and divergent component: a state in, torques out.
use super::divergent::Point;
use super::ground_forces::{Limits, Shared, StandingFoot, share};
use super::motion::{Motion, Wish};
use super::robot::{BASE, Columns, Leg, MOST_VELOCITIES, Place, WalkingRobot};
use super::space::{Vector, about_z, add, along, product, scale, subtract, transpose, turn_between};
use super::steps::{Foothold, Phase, Steps, Stride, Velocity};
use super::support::Support;
use super::swing::Moving;
use crate::control::slices::get;
use crate::control::{Controller, JointCommand, Observation, Refusal};
use crate::model::Model;
use crate::real::Scalar;

/// How the robot walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains<R> {
    /// Steps.
    pub stride: Stride<R>,
    /// Height of the centre of mass above the standing soles, m.
    pub height: R,
    /// How high feet are lifted, m.
    pub lift: R,
    /// Of the zero moment point from the edges of the soles, m.
    pub margin: R,
    /// Of the divergent component, 1/s.
    pub divergent: R,
    /// Natural frequencies of errors, critically damped, rad/s: torso, height, swinging foot, other joints.
    pub torso: R,
    /// See [`Self::torso`].
    pub rise: R,
    /// See [`Self::torso`].
    pub swing: R,
    /// See [`Self::torso`].
    pub posture: R,
    /// With which soles that stand but move are braked, 1/s.
    pub brake: R,
    /// From standing to the first step, s.
    pub start: R,
    /// With which joints are braked where there are no commands, N m s/rad.
    pub passive: R,
    /// Load (N) from which a foot is on the ground.
    pub touch: R,
    /// Largest horizontal force of the ground per vertical one.
    pub friction: R,
    /// Largest moment about the sole's normal per normal force, m.
    pub turning: R,
    /// Least normal force of a foot that stands, N.
    pub least_load: R,
}

/// Bend of a knee (rad) below which the robot goes down.
const BENT: f64 = 0.35;

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
    robot: WalkingRobot<R>,
    gains: Gains<R>,
    steps: Option<Steps<R>>,
    asked: Velocity<R>,
    /// x, y, z, yaw of the swinging foot.
    swinging: [Moving<R>; 4],
    /// Of the torso.
    yaw: Moving<R>,
    /// By how much the centre of mass is lower than it should be, so that no leg is stretched, m.
    lower: R,
    last: Option<R>,
    walked: Option<Walked<R>>,
    motion: Motion<R>,
    room: Columns<R>,
    torques: [R; MOST_VELOCITIES],
}

fn two<R: Scalar>(f: impl Fn(usize) -> R) -> Point<R> {
    [f(0), f(1)]
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
            walked: None,
            motion: Motion::default(),
            room: [o; 6 * MOST_VELOCITIES],
            torques: [o; MOST_VELOCITIES],
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
            Phase::Shift if over => {
                steps.lift(&stride, &self.asked);
                let foot = if steps.stands == 0 { 1 } else { 0 };
                let from = steps.foot(foot);
                let [x, y, z] = from.place;
                self.swinging = [x, y, z, from.yaw].map(Moving::resting);
            }
            Phase::Halt if over => steps.rest(),
            Phase::Shift | Phase::Halt => {}
            Phase::Swing => {
                let foot = if steps.stands == 0 { 1 } else { 0 };
                let [right, left] = &place.soles;
                let sole = if foot == 0 { right } else { left };
                let late = steps.time > R::constant(0.6) * steps.duration;
                let touches = loads.map(|loads| get(&loads, foot) > self.gains.touch);
                // Without sensors the plan is believed.
                if late && touches.unwrap_or(over) {
                    let at = Foothold::of(&sole.pose, steps.goal.yaw);
                    steps.land(&stride, at, &self.asked);
                }
            }
        }
    }

    /// Where the foot goes: as planned, and farther where the zero moment point alone does not bring the divergent component back.
    fn adjust(&self, steps: &mut Steps<R>, place: &Place<R>, divergent: Point<R>) {
        let (zero, stride) = (R::constant(0.0), &self.gains.stride);
        let left = steps.left();
        // A foot that is nearly down stays with its goal.
        if steps.phase != Phase::Swing || left < R::constant(0.05) {
            return;
        }
        let [right, other] = &self.robot.legs;
        let (leg, sole) =
            if steps.stands == 0 { (right, place.soles.first()) } else { (other, place.soles.last()) };
        let Some(sole) = sole else { return };
        let end = steps.divergent_at_end(stride, &steps.nominal);
        let wished = steps.divergent_now(stride, end);
        let stand = steps.foot(steps.stands);
        let [forward, across, _] = transpose(about_z(stand.yaw));
        let error = two(|i| get(&divergent, i) - get(&wished, i));
        let growth = (stride.omega * left).exp();
        let reference = steps.reference_zmp();
        let inside =
            leg.inside(&sole.pose, [get(&reference, 0), get(&reference, 1), get(&sole.pose.position, 2)]);
        let beyond = |axis: Vector<R>, low: usize| {
            let e = get(&axis, 0) * get(&error, 0) + get(&axis, 1) * get(&error, 1);
            let side = if e > zero { low + 1 } else { low };
            let room = (get(&inside, side) - self.gains.margin).larger(zero) * R::constant(0.5);
            let rest = (e.abs() * growth - (growth - R::constant(1.0)) * room).larger(zero);
            if e > zero { rest } else { -rest }
        };
        let (ahead, aside) = (beyond(forward, 0), beyond(across, 2));
        // As seen from the foot that stands.
        let way = subtract(steps.nominal.place, stand.place);
        let seen = |axis: Vector<R>| get(&axis, 0) * get(&way, 0) + get(&axis, 1) * get(&way, 1);
        let [nearest, farthest] = stride.across;
        let clamp = |x: R, low: R, high: R| -(-x.larger(low)).larger(-high);
        let (far, wide) = (seen(forward) + ahead, seen(across) + aside);
        let x = clamp(far, -stride.longest, stride.longest);
        let y =
            if steps.stands == 0 { clamp(wide, nearest, farthest) } else { clamp(wide, -farthest, -nearest) };
        let place = along(along(stand.place, x, forward), y, across);
        steps.goal = Foothold { place, yaw: steps.nominal.yaw };
    }

    /// Accelerations of soles, torso and height.
    fn wish(&mut self, steps: &Steps<R>, place: &Place<R>, zmp: Point<R>, step: R) -> Wish<R> {
        let gains = self.gains;
        let (zero, two) = (R::constant(0.0), R::constant(2.0));
        let swings = (steps.phase == Phase::Swing).then_some(if steps.stands == 0 { 1 } else { 0 });
        let left = steps.left();
        let mut soles = [[[zero; 3]; 2]; 2];
        for (foot, (wish, sole)) in soles.iter_mut().zip(&place.soles).enumerate() {
            let [linear, angular] = sole.velocity;
            if swings != Some(foot) {
                *wish = [scale(-gains.brake, linear), scale(-gains.brake, angular)];
                continue;
            }
            self.swing(steps, step);
            let [x, y, z, yaw] = self.swinging;
            let p = [x, y, z].map(|x| x.place);
            let v = [x, y, z].map(|x| x.rate);
            let a = [x, y, z].map(|x| x.acceleration);
            let (square, damping) = (gains.swing * gains.swing, two * gains.swing);
            let pull = along(scale(square, subtract(p, sole.pose.position)), damping, subtract(v, linear));
            let turn = turn_between(sole.pose.turn, about_z(yaw.place));
            let rate = subtract([zero, zero, yaw.rate], angular);
            let twist = along(scale(square, turn), damping, rate);
            *wish = [add(a, pull), add([zero, zero, yaw.acceleration], twist)];
        }
        // The torso looks between the feet.
        let half = R::constant(0.5);
        let goal = match swings {
            Some(_) => half * (steps.foot(steps.stands).yaw + steps.goal.yaw),
            None => half * (steps.foot(0).yaw + steps.foot(1).yaw),
        };
        self.yaw.toward(goal, left.larger(R::constant(0.3)), step);
        let here = product(place.base.turn, self.robot.heading);
        let turn = turn_between(here, about_z(self.yaw.place));
        let rate = subtract([zero, zero, self.yaw.rate], place.angular);
        let torso = along(scale(gains.torso * gains.torso, turn), two * gains.torso, rate);
        let torso = add(torso, [zero, zero, self.yaw.acceleration]);
        let ground = self.ground(steps, place);
        let [center, velocity] = place.center;
        let missing = ground + gains.height - self.lower - get(&center, 2);
        let rise = gains.rise * gains.rise * missing - two * gains.rise * get(&velocity, 2);
        let [x, y] = zmp;
        Wish { soles, torso, rise, zero_moment_point: [x, y, ground] }
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

    /// Height of the ground below the zero moment point, m.
    fn ground(&self, steps: &Steps<R>, place: &Place<R>) -> R {
        let [right, left] = place.soles.each_ref().map(|sole| get(&sole.pose.position, 2));
        match steps.phase {
            Phase::Swing if steps.stands == 0 => right,
            Phase::Swing => left,
            _ => R::constant(0.5) * (right + left),
        }
    }

    /// Goes on with the reference of the swinging foot.
    fn swing(&mut self, steps: &Steps<R>, step: R) {
        let left = steps.left();
        let half = R::constant(0.5) * steps.duration;
        let [x, y, z] = steps.goal.place;
        let high =
            z.larger(get(&steps.foot(if steps.stands == 0 { 1 } else { 0 }).place, 2)) + self.gains.lift;
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
            to_z.at_rate(-self.gains.lift / steps.duration, step);
        }
    }
}

impl<M: Model<R>, R: Scalar> Controller<R> for WalkingController<M, R> {
    fn command(
        &mut self,
        observed: &Observation<'_, R>,
        commands: &mut [JointCommand<R>],
    ) -> Result<(), Refusal> {
        let zero = R::constant(0.0);
        let state = [observed.q, observed.v];
        let place = self.robot.place(&self.model, state, &mut self.room)?;
        // A clock that stands still or jumps is none.
        let since = self.last.map_or(zero, |last| observed.time - last);
        let step = -(-since.larger(zero)).larger(-R::constant(0.02));
        self.last = Some(observed.time);
        let mut steps = self.steps.unwrap_or_else(|| {
            let feet = place.soles.each_ref().map(|sole| Foothold::of(&sole.pose, zero));
            Steps::standing(feet)
        });
        let load = |leg: &Leg<R>| observed.loads.get(leg.foot).copied();
        let loads = match self.robot.legs.each_ref().map(load) {
            [Some(right), Some(left)] => Some([right, left]),
            _ => None,
        };
        self.follow(&mut steps, &place, loads, step);
        let omega = self.gains.stride.omega;
        let [center, velocity] = place.center;
        let divergent = two(|i| get(&center, i) + get(&velocity, i) / omega);
        self.adjust(&mut steps, &place, divergent);
        let end = steps.divergent_at_end(&self.gains.stride, &steps.goal);
        let wished = steps.divergent_now(&self.gains.stride, end);
        let reference = steps.reference_zmp();
        let gain = R::constant(1.0) + self.gains.divergent / omega;
        let asked = two(|i| get(&reference, i) + gain * (get(&divergent, i) - get(&wished, i)));
        let standing = self.robot.legs.iter().zip(&place.soles).enumerate();
        let standing =
            standing.filter(|(foot, _)| steps.is_standing(*foot)).map(|(_, (leg, sole))| (leg, &sole.pose));
        let support = Support::of(standing, self.gains.margin);
        let zmp = support.nearest(asked);
        self.walked = Some(Walked {
            divergent: [divergent, wished],
            zero_moment_point: [zmp, reference],
            limited: zmp != asked,
            center: two(|i| get(&center, i)),
            height: get(&center, 2) - self.ground(&steps, &place),
            shared: None,
        });
        self.stoop(observed.q, step);
        let wish = self.wish(&steps, &place, zmp, step);
        self.steps = Some(steps);
        let posture = self.gains.posture;
        let goal = &self.robot.posture;
        let (q, v) = (observed.q, observed.v);
        let others = |column: usize| {
            let error = get(goal, column - BASE) - get(q, column + 1);
            posture * posture * error - R::constant(2.0) * posture * get(v, column)
        };
        self.motion.of((&self.robot, &self.model), state, &place, &wish, others)?;
        self.torques = self.motion.torques;
        let shares = self.shares(&steps, &place, zmp);
        let gave = self.push(&steps, &place, shares);
        if let Some(walked) = &mut self.walked {
            walked.shared = Some(gave);
        }
        for (command, torque) in commands.iter_mut().zip(self.torques) {
            *command = JointCommand::Torque(torque);
        }
        Ok(())
    }
}

impl<M, R: Scalar> WalkingController<M, R> {
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

    /// Parts of the load on right and left: where the zero moment point is on the way between them.
    fn shares(&self, steps: &Steps<R>, place: &Place<R>, zmp: Point<R>) -> [R; 2] {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        if steps.phase == Phase::Swing {
            return if steps.stands == 0 { [one, zero] } else { [zero, one] };
        }
        let [right, left] = place.soles.each_ref().map(|sole| sole.pose.position);
        let way = two(|i| get(&left, i) - get(&right, i));
        let from = two(|i| get(&zmp, i) - get(&right, i));
        let along = get(&way, 0) * get(&from, 0) + get(&way, 1) * get(&from, 1);
        let square = get(&way, 0) * get(&way, 0) + get(&way, 1) * get(&way, 1);
        let part = if square > zero { along / square } else { R::constant(0.5) };
        let part = -(-part.larger(zero)).larger(-one);
        [one - part, part]
    }
}
