//! Where the robot is and how it moves, from encoders, gyroscope, accelerometer and the load of its feet.
//!
//! An extended Kalman filter on the errors of a state (Bloesch and others, *State estimation for legged robots*, RSS 2012; feet with an attitude: Rotella
//! and others, IROS 2014): position, velocity and attitude of the inertial unit, biases of both of its sensors, and pose of each sole that stands. The unit is
//! integrated; feet that stand stay where they are, so that the legs' kinematics measure the unit against them. A foot is anchored where it touches down;
//! on level ground it comes to lie flat at the ground's height. What nothing tells is the position along the ground and the heading: both drift with the
//! way, step by step.
//!
//! Each of a foot's measurements counts by its load, less if it disagrees with all others (Huber), and a foot that goes on disagreeing is anchored anew: it slipped.
use super::error_state::{ACCELEROMETER, ATTITUDE, Errors, FEET, GYROSCOPE, POSITION, Row, VELOCITY};
use super::readings::{Believed, Readings};
use super::space::{
    Pose, Turn, Vector, add, along, cross, cross_matrix, diagonal, identity, length, of_quaternion, product,
    scale, subtract, transpose, turn_between, turned, turned_back, zero,
};
use crate::control::slices::{copy, get, set};
use crate::real::Scalar;

/// Most joints behind the base.
pub const MOST_JOINTS: usize = 42;
/// Position and quaternion of the base; its twist.
const BASE: [usize; 2] = [7, 6];
/// Longer than this nothing is integrated, s.
const LONGEST_STEP: f64 = 0.1;
/// So many refused samples of a foot in a row: it slipped.
const SLIPPED: u16 = 10;
/// A foot that touched down comes to rest, s.
const SETTLING: f64 = 0.05;
/// Errors of kinematics and of the ground last about so long, s: samples within that time say the same.
const LASTING: [f64; 2] = [0.01, 0.5];

/// What sensors say at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensed<'a, R> {
    /// s
    pub time: R,
    /// rad; m of prismatic joints
    pub joint_position: &'a [R],
    /// rad/s; `None`: positions are differenced and filtered.
    pub joint_velocity: Option<&'a [R]>,
    /// Of the gyroscope, axes of the base, rad/s.
    pub angular_velocity: [R; 3],
    /// Of the accelerometer, axes of the base: 9.81 upward at rest, m/s².
    pub specific_force: [R; 3],
    /// Normal force on each foot, N: right, left.
    pub load: [R; 2],
}

/// Where the soles are, seen from the base.
pub trait LegKinematics<R> {
    /// How many joints there are.
    fn joints(&self) -> usize;

    /// The pose of a sole (0: right, 1: left) in the frame of the base, axes forward, left, up; into `jacobian`, for every joint, the linear and angular
    /// velocity of its origin per rate of the joint, axes of the base. `None`: there is no such foot.
    fn sole(&self, foot: usize, joint_position: &[R], jacobian: &mut [[R; 6]]) -> Option<Pose<R>>;
}

/// How good sensors, legs and ground are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<R> {
    /// m/s²
    pub gravity: R,
    /// Place of the inertial unit in the frame of the base, m.
    pub unit: Vector<R>,
    /// Noise of the gyroscope, rad/s/√Hz, and of the accelerometer, m/s²/√Hz.
    pub noise: [R; 2],
    /// Standard deviations of their biases at the beginning, rad/s and m/s².
    pub bias: [R; 2],
    /// How these wander, per √s.
    pub bias_walk: [R; 2],
    /// Standard deviation of a joint's reading, rad.
    pub encoder: R,
    /// What else is wrong with where a leg says that the sole is: m, rad.
    pub leg: [R; 2],
    /// How a foot that stands moves nevertheless: m/√s, rad/√s.
    pub foot: [R; 2],
    /// Level ground: how far a foot at rest is from its height (m) and from lying flat (rad); infinite: nothing is known of it.
    pub ground: [R; 2],
    /// Loads (N) below which a foot is lifted, from which on it stands, from which on it counts fully.
    pub loads: [R; 3],
    /// Fastest motion of a joint, rad/s.
    pub joint_speed: R,
    /// Largest readings of gyroscope and accelerometer, rad/s and m/s².
    pub ranges: [R; 2],
    /// Time constant of differenced joint positions, s.
    pub velocity_filter: R,
}

impl<R: Scalar> Settings<R> {
    /// For a robot of so many newtons with sensors of today: noise of a small inertial unit, encoders of 0.5 mrad.
    pub fn of_weight(weight: R) -> Self {
        let x = R::constant;
        Self {
            gravity: x(9.81),
            unit: zero(),
            noise: [x(1e-3), x(1e-2)],
            bias: [x(0.02), x(0.1)],
            bias_walk: [x(1e-4), x(1e-3)],
            encoder: x(5e-4),
            leg: [x(5e-4), x(1e-3)],
            foot: [x(2e-4), x(5e-4)],
            ground: [x(2e-3), x(5e-3)],
            loads: [x(0.05) * weight, x(0.1) * weight, x(0.4) * weight],
            joint_speed: x(30.0),
            ranges: [x(50.0), x(500.0)],
            velocity_filter: x(5e-3),
        }
    }
}

/// What was not as it should be; the first thing if there were several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Time did not advance, or by more than 0.1 s: that long nothing is integrated, and feet are anchored anew.
    Time,
    /// There are not as many joints as the legs have, or more than [`MOST_JOINTS`]: nothing was done.
    Length,
    /// A joint's position is not finite or jumped: its leg is not believed.
    JointPosition(usize),
    /// A joint's velocity is not finite: positions are differenced.
    JointVelocity(usize),
    /// Not finite, out of range or frozen: the legs alone tell how the base turns.
    Gyroscope,
    /// Not finite, out of range or frozen: the legs alone tell how the base moves.
    Accelerometer,
    /// The load of a foot is not finite: it counts as lifted.
    Load(usize),
    /// The legs' kinematics gave nothing finite.
    Kinematics(usize),
    /// A foot that stood moved away.
    Slip(usize),
    /// No foot stands.
    Aloft,
    /// Numbers went out of bounds: begun anew where the robot was.
    Restarted,
}

/// What became of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated<R> {
    /// Which feet the estimate stands on.
    pub standing: [bool; 2],
    /// How much each of them counts, 0 to 1.
    pub trust: [R; 2],
    /// What was wrong.
    pub fault: Option<Fault>,
}

/// A foot.
#[derive(Debug, Clone, Copy)]
struct Anchor<R> {
    standing: bool,
    position: Vector<R>,
    turn: Turn<R>,
    /// Since it stands, s.
    age: R,
    refused: u16,
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Estimator<R> {
    settings: Settings<R>,
    start: Option<Pose<R>>,
    time: Option<R>,
    position: Vector<R>,
    velocity: Vector<R>,
    quaternion: [R; 4],
    gyroscope: Vector<R>,
    accelerometer: Vector<R>,
    /// Readings less biases.
    angular: Vector<R>,
    force: Vector<R>,
    feet: [Anchor<R>; 2],
    errors: Errors<R>,
    readings: Readings<R>,
    joints: usize,
    q: [R; BASE[0] + MOST_JOINTS],
    v: [R; BASE[1] + MOST_JOINTS],
}

/// A sole in axes of the world, from the unit, and how well it is known.
struct Seen<R> {
    arm: Vector<R>,
    turn: Turn<R>,
    variance: [R; 6],
}

impl<R: Scalar> Estimator<R> {
    /// `start`: pose of the base in the world when it begins. Without, the world's origin is below the middle of the soles that stand then,
    /// and its x axis along that of the base.
    pub fn new(settings: Settings<R>, start: Option<Pose<R>>) -> Self {
        let o = R::constant(0.0);
        let anchor = Anchor { standing: false, position: zero(), turn: identity(), age: o, refused: 0 };
        Self {
            settings,
            start,
            time: None,
            position: zero(),
            velocity: zero(),
            quaternion: [o, o, o, R::constant(1.0)],
            gyroscope: zero(),
            accelerometer: zero(),
            angular: zero(),
            force: zero(),
            feet: [anchor; 2],
            errors: Errors::new(),
            readings: Readings::new(),
            joints: 0,
            q: [o; BASE[0] + MOST_JOINTS],
            v: [o; BASE[1] + MOST_JOINTS],
        }
    }

    /// The configuration as a model on a floating base takes it: position of the base (m), quaternion x y z w, joints.
    pub fn q(&self) -> &[R] {
        self.q.get(..BASE[0] + self.joints).unwrap_or(&[])
    }

    /// The velocity as a model takes it: linear (m/s) and angular velocity (rad/s) of the base in its own axes, joints.
    pub fn v(&self) -> &[R] {
        self.v.get(..BASE[1] + self.joints).unwrap_or(&[])
    }

    /// Biases of gyroscope (rad/s) and accelerometer (m/s²): measured minus true.
    pub fn biases(&self) -> [Vector<R>; 2] {
        [self.gyroscope, self.accelerometer]
    }

    /// Standard deviations: of the position (m), the velocity (m/s), the attitude (rad) about axes of the world.
    pub fn deviations(&self) -> [Vector<R>; 3] {
        [POSITION, VELOCITY, ATTITUDE].map(|first| [0, 1, 2].map(|k| self.errors.variance(first + k).sqrt()))
    }

    /// Where a foot that stands is held to be: origin and axes of its sole in the world.
    pub fn foot(&self, foot: usize) -> Option<Pose<R>> {
        let anchor = self.feet.get(foot).filter(|anchor| anchor.standing)?;
        Some(Pose { position: anchor.position, turn: anchor.turn })
    }

    /// Takes a sample. Never hands out what is not finite, whatever is read.
    pub fn update(&mut self, sensed: &Sensed<'_, R>, legs: &impl LegKinematics<R>) -> Estimated<R> {
        let mut fault = None;
        let joints = legs.joints();
        if joints > MOST_JOINTS || sensed.joint_position.len() != joints {
            return self.answer(Some(Fault::Length), [R::constant(0.0); 2]);
        }
        let step = self.time.map(|time| sensed.time - time);
        // NaN neither.
        if !step.is_none_or(|step| step > R::constant(0.0)) || !sensed.time.is_finite() {
            return self.answer(Some(Fault::Time), [R::constant(0.0); 2]);
        }
        (self.joints, self.time) = (joints, Some(sensed.time));
        let believed = self.readings.take(sensed, &self.settings, step, &mut fault);
        let before = (self.position, self.quaternion);
        let soles = self.look(legs, &mut fault);
        match step {
            None => self.begin(&believed, &soles),
            Some(step) if step > R::constant(LONGEST_STEP) => {
                fault = Some(Fault::Time);
                self.resume();
            }
            Some(step) => self.predict(&believed, step),
        }
        let trust = self.stand(&believed, &soles, step, &mut fault);
        self.correct(before, &mut fault);
        self.write();
        self.answer(fault, trust)
    }

    fn answer(&self, fault: Option<Fault>, trust: [R; 2]) -> Estimated<R> {
        let standing = self.feet.map(|foot| foot.standing);
        let aloft = (standing == [false; 2] && self.time.is_some()).then_some(Fault::Aloft);
        Estimated { standing, trust, fault: fault.or(aloft) }
    }

    /// Both soles, seen from the unit, in axes of the base; of a leg that is believed.
    fn look(&self, legs: &impl LegKinematics<R>, fault: &mut Option<Fault>) -> [Option<Seen<R>>; 2] {
        [0, 1].map(|foot| {
            let mut jacobian = [[R::constant(0.0); 6]; MOST_JOINTS];
            let (jacobian, positions) =
                (jacobian.get_mut(..self.joints)?, self.readings.positions.get(..self.joints)?);
            let pose = legs.sole(foot, positions, jacobian)?;
            let acts = |column: &[R; 6]| column.iter().any(|x| *x != R::constant(0.0));
            let wrong = jacobian.iter().zip(self.readings.wrong).any(|(column, wrong)| wrong && acts(column));
            let mut variance = [R::constant(0.0); 6];
            for column in jacobian.iter() {
                variance.iter_mut().zip(column).for_each(|(sum, x)| *sum = R::fused(*x, *x, *sum));
            }
            let numbers = pose.position.iter().chain(pose.turn.iter().flatten()).chain(&variance);
            if !numbers.into_iter().all(|x| x.is_finite()) {
                fault.get_or_insert(Fault::Kinematics(foot));
                return None;
            }
            let encoder = self.settings.encoder * self.settings.encoder;
            let [place, angle] = self.settings.leg.map(|x| x * x);
            for (k, sum) in variance.iter_mut().enumerate() {
                *sum = R::fused(*sum, encoder, if k < 3 { place } else { angle });
            }
            let arm = subtract(pose.position, self.settings.unit);
            (!wrong).then_some(Seen { arm, turn: pose.turn, variance })
        })
    }

    /// The first sample: a robot that stands still.
    fn begin(&mut self, believed: &Believed<R>, soles: &[Option<Seen<R>>; 2]) {
        let loads = believed.load.map(|load| load.unwrap_or(R::constant(0.0)));
        let pressed = |foot: usize| get(&loads, foot) >= get(&self.settings.loads, 1);
        // Before anything was measured a robot stands on both.
        let none = !pressed(0) && !pressed(1);
        let stands = |foot: usize| none || pressed(foot);
        let standing = || (0..2).filter(|foot| stands(*foot)).filter_map(|foot| soles.get(foot)?.as_ref());
        let up = standing().fold(zero(), |sum, sole| add(sum, transpose(sole.turn)[2]));
        let up = match believed.specific_force {
            _ if length(up) > R::constant(0.5) => up,
            Some(force) if length(force) > R::constant(0.5) => force,
            _ => [R::constant(0.0), R::constant(0.0), R::constant(1.0)],
        };
        let pose = self.start.unwrap_or_else(|| {
            let turn = upright(up);
            let count =
                standing().fold(R::constant(0.0), |sum, _| sum + R::constant(1.0)).larger(R::constant(1.0));
            let sum = standing().fold(zero(), |sum, sole| add(sum, turned(turn, sole.arm)));
            let unit = scale(-(R::constant(1.0) / count), sum);
            Pose { position: subtract(unit, turned(turn, self.settings.unit)), turn }
        });
        self.quaternion = to_quaternion(pose.turn);
        self.position = add(pose.position, turned(pose.turn, self.settings.unit));
        self.reset();
    }

    /// Variances of a beginning: the place is given.
    fn reset(&mut self) {
        let x = |x: f64| [R::constant(x * x); 3];
        self.velocity = zero();
        self.errors = Errors::new();
        self.errors.forget(POSITION, x(1e-3));
        self.errors.forget(VELOCITY, x(0.1));
        let (tilt, heading) = (R::constant(0.03 * 0.03), R::constant(1e-3 * 1e-3));
        self.errors.forget(ATTITUDE, [tilt, tilt, heading]);
        let [turning, accelerating] = self.settings.bias.map(|x| [x * x; 3]);
        self.errors.forget(GYROSCOPE, turning);
        self.errors.forget(ACCELEROMETER, accelerating);
        self.feet.iter_mut().for_each(|foot| foot.standing = false);
    }

    /// After a time without samples: where it was, but how it moves is not known any more.
    fn resume(&mut self) {
        let x = |x: f64| [R::constant(x * x); 3];
        self.velocity = zero();
        self.errors.forget(VELOCITY, x(0.5));
        self.errors.grow(POSITION, x(0.1));
        self.errors.grow(ATTITUDE, x(0.1));
        self.feet.iter_mut().for_each(|foot| foot.standing = false);
    }

    /// Integrates the unit and its errors.
    fn predict(&mut self, believed: &Believed<R>, step: R) {
        let (half, one) = (R::constant(0.5), R::constant(1.0));
        let turn = of_quaternion(self.quaternion);
        let angular = believed.angular_velocity.map_or(zero(), |reading| subtract(reading, self.gyroscope));
        let mean = match believed.angular_velocity {
            Some(_) => scale(half, add(angular, self.angular)),
            None => zero(),
        };
        self.quaternion = turned_by(self.quaternion, turned(turn, scale(step, mean)));
        let next = of_quaternion(self.quaternion);
        let rest = [R::constant(0.0), R::constant(0.0), self.settings.gravity];
        let force = believed
            .specific_force
            .map_or_else(|| turned_back(next, rest), |reading| subtract(reading, self.accelerometer));
        let felt = scale(half, add(turned(turn, self.force), turned(next, force)));
        let acceleration = match believed.specific_force {
            Some(_) => subtract(felt, rest),
            None => zero(),
        };
        self.position = along(along(self.position, step, self.velocity), half * step * step, acceleration);
        self.velocity = along(self.velocity, step, acceleration);
        (self.angular, self.force) = (angular, force);
        let minus = scale_turn(-step, next);
        self.errors.mix(POSITION, true, &[(VELOCITY, diagonal(step))]);
        let lever = scale_turn(-step, cross_matrix(felt));
        self.errors.mix(VELOCITY, true, &[(ATTITUDE, lever), (ACCELEROMETER, minus)]);
        self.errors.mix(ATTITUDE, true, &[(GYROSCOPE, minus)]);
        // Without a sensor anything that a robot does is possible.
        let [turning, accelerating] = self.settings.noise;
        let turning = if believed.angular_velocity.is_some() { turning } else { one };
        let accelerating = if believed.specific_force.is_some() { accelerating } else { one };
        self.errors.grow(ATTITUDE, [turning * turning * step; 3]);
        self.errors.grow(VELOCITY, [accelerating * accelerating * step; 3]);
        let [turning, accelerating] = self.settings.bias_walk;
        self.errors.grow(GYROSCOPE, [turning * turning * step; 3]);
        self.errors.grow(ACCELEROMETER, [accelerating * accelerating * step; 3]);
    }

    /// What the feet say; how much each of them counts.
    fn stand(
        &mut self,
        believed: &Believed<R>,
        soles: &[Option<Seen<R>>; 2],
        step: Option<R>,
        fault: &mut Option<Fault>,
    ) -> [R; 2] {
        let (one, zero) = (R::constant(1.0), R::constant(0.0));
        let step = step.unwrap_or(R::constant(1e-3));
        let [lifted, touching, full] = self.settings.loads;
        let mut trust = [zero; 2];
        let all = soles.iter().zip(believed.load).zip(FEET).zip(trust.iter_mut());
        for (foot, (((sole, load), first), trust)) in all.enumerate() {
            let Some(mut anchor) = self.feet.get(foot).copied() else { continue };
            let load = load.unwrap_or(zero);
            let stood = anchor.standing;
            anchor.standing = load >= if stood { lifted } else { touching };
            let Some(sole) = sole.as_ref().filter(|_| anchor.standing) else {
                // A leg that is not believed for a sample: its foot stands on.
                anchor.standing = anchor.standing && stood;
                set_foot(&mut self.feet, foot, anchor);
                continue;
            };
            let part = load / full;
            *trust = if part > one { one } else { part.larger(R::constant(0.05)) };
            if !stood {
                anchor.age = zero;
            }
            if !stood || anchor.refused >= SLIPPED {
                if stood {
                    fault.get_or_insert(Fault::Slip(foot));
                    *trust = zero;
                }
                self.anchor(&mut anchor, sole, first);
            } else {
                self.hold(&mut anchor, sole, first, (*trust, step));
            }
            anchor.age = anchor.age + step;
            set_foot(&mut self.feet, foot, anchor);
        }
        trust
    }

    /// A foot is where the leg says that it is.
    fn anchor(&mut self, anchor: &mut Anchor<R>, sole: &Seen<R>, first: usize) {
        let turn = of_quaternion(self.quaternion);
        let arm = turned(turn, sole.arm);
        anchor.position = add(self.position, arm);
        anchor.turn = product(turn, sole.turn);
        anchor.refused = 0;
        let one = identity();
        self.errors.mix(
            first,
            false,
            &[(POSITION, one), (ATTITUDE, scale_turn(-R::constant(1.0), cross_matrix(arm)))],
        );
        self.errors.mix(first + 3, false, &[(ATTITUDE, one)]);
        let [a, b, c, d, e, f] = sole.variance;
        self.errors.grow(first, [a.larger(b).larger(c); 3]);
        self.errors.grow(first + 3, [d.larger(e).larger(f); 3]);
    }

    /// A foot stays where it is; on level ground, flat.
    fn hold(&mut self, anchor: &mut Anchor<R>, sole: &Seen<R>, first: usize, (trust, step): (R, R)) {
        let (one, zero) = (R::constant(1.0), R::constant(0.0));
        let young = anchor.age < R::constant(SETTLING);
        let loose = if young { R::constant(100.0) } else { one } / (trust * trust);
        let [place, angle] = self.settings.foot.map(|x| x * x * step * loose);
        self.errors.grow(first, [place; 3]);
        self.errors.grow(first + 3, [angle; 3]);
        let turn = of_quaternion(self.quaternion);
        let distance = subtract(anchor.position, self.position);
        let miss = subtract(turned(turn, sole.arm), distance);
        let twist = turn_between(anchor.turn, product(turn, sole.turn));
        let lever = cross_matrix(distance);
        let lasting = R::constant(LASTING[0]) / (step * trust);
        let lasting = if lasting > one { lasting } else { one };
        let [a, b, c, d, e, f] = sole.variance;
        let (of_place, of_angle) = (a.larger(b).larger(c) * lasting, d.larger(e).larger(f) * lasting);
        let mut farthest = zero;
        for (k, ((miss, twist), [x, y, z])) in miss.into_iter().zip(twist).zip(lever).enumerate() {
            let of_attitude = [(ATTITUDE, x), (ATTITUDE + 1, y), (ATTITUDE + 2, z)];
            let [a, b, c] = of_attitude;
            let row: Row<R> = [(first + k, one), (POSITION + k, -one), a, b, c, (0, zero)];
            farthest = farthest.larger(self.errors.measure(&row, miss, of_place));
            let row: Row<R> =
                [(first + 3 + k, one), (ATTITUDE + k, -one), (0, zero), (0, zero), (0, zero), (0, zero)];
            farthest = farthest.larger(self.errors.measure(&row, twist, of_angle));
        }
        let refused = farthest > R::constant(10.0);
        anchor.refused = if refused { anchor.refused.saturating_add(1) } else { 0 };
        if !young && !refused {
            self.level(anchor, first, (trust, step));
        }
    }

    /// Level ground.
    fn level(&mut self, anchor: &Anchor<R>, first: usize, (trust, step): (R, R)) {
        let (one, zero) = (R::constant(1.0), R::constant(0.0));
        let lasting = R::constant(LASTING[1]) / (step * trust);
        let [height, tilt] = self.settings.ground.map(|x| x * x * lasting);
        let none = (0, zero);
        let single = |index: usize| -> Row<R> { [(index, one), none, none, none, none, none] };
        if height.is_finite() {
            let [_, _, z] = anchor.position;
            self.errors.measure(&single(first + 2), -z, height);
        }
        if tilt.is_finite() {
            let [_, _, up] = transpose(anchor.turn);
            let [x, y, _] = cross(up, [zero, zero, one]);
            self.errors.measure(&single(first + 3), x, tilt);
            self.errors.measure(&single(first + 4), y, tilt);
        }
    }

    /// Corrects the state by the errors that are known now.
    fn correct(&mut self, before: (Vector<R>, [R; 4]), fault: &mut Option<Fault>) {
        let known = self.errors.take();
        let of = |first: usize| [0, 1, 2].map(|k| get(&known, first + k));
        self.position = add(self.position, of(POSITION));
        self.velocity = add(self.velocity, of(VELOCITY));
        self.quaternion = turned_by(self.quaternion, of(ATTITUDE));
        self.gyroscope = add(self.gyroscope, of(GYROSCOPE));
        self.accelerometer = add(self.accelerometer, of(ACCELEROMETER));
        for (anchor, first) in self.feet.iter_mut().zip(FEET) {
            anchor.position = add(anchor.position, of(first));
            let turn = turned_by(to_quaternion(anchor.turn), of(first + 3));
            anchor.turn = of_quaternion(turn);
        }
        let numbers = self.position.iter().chain(&self.velocity).chain(&self.quaternion);
        let numbers = numbers.chain(&self.gyroscope).chain(&self.accelerometer);
        let feet = self.feet.iter().flat_map(|foot| foot.turn.iter().flatten().chain(&foot.position));
        let bounded = |x: &R| x.abs() < R::constant(1e9);
        if !(numbers.chain(feet).all(bounded) && self.errors.is_finite()) {
            (self.position, self.quaternion) = before;
            (self.gyroscope, self.accelerometer) = (zero(), zero());
            (self.angular, self.force) = (zero(), zero());
            self.reset();
            *fault = Some(Fault::Restarted);
        }
    }

    /// What is handed out.
    fn write(&mut self) {
        let turn = of_quaternion(self.quaternion);
        let unit = self.settings.unit;
        let [x, y, z] = subtract(self.position, turned(turn, unit));
        let [a, b, c, d] = self.quaternion;
        copy(&[x, y, z, a, b, c, d], &mut self.q);
        let [x, y, z] = subtract(turned_back(turn, self.velocity), cross(self.angular, unit));
        let [a, b, c] = self.angular;
        copy(&[x, y, z, a, b, c], &mut self.v);
        for (place, joint) in self.q.iter_mut().skip(BASE[0]).zip(self.readings.positions) {
            *place = joint;
        }
        for (place, rate) in self.v.iter_mut().skip(BASE[1]).zip(self.readings.velocities) {
            *place = rate;
        }
    }
}

fn set_foot<R>(feet: &mut [Anchor<R>; 2], foot: usize, anchor: Anchor<R>) {
    set(feet, foot, anchor);
}

/// x M
fn scale_turn<R: Scalar>(x: R, m: Turn<R>) -> Turn<R> {
    m.map(|row| scale(x, row))
}

/// The turn of a frame whose z axis in its own coordinates is `up`, with its x axis in the plane of the world's x and z.
fn upright<R: Scalar>(up: Vector<R>) -> Turn<R> {
    let (one, o) = (R::constant(1.0), R::constant(0.0));
    let up = scale(one / length(up), up);
    let [x, _, _] = up;
    let forward = if x.abs() < R::constant(0.9) { [one, o, o] } else { [o, one, o] };
    let left = cross(up, forward);
    let left = scale(one / length(left), left);
    [cross(left, up), left, up]
}

/// A unit quaternion x, y, z, w of a turn.
fn to_quaternion<R: Scalar>([[a, b, c], [d, e, f], [g, h, i]]: Turn<R>) -> [R; 4] {
    let one = R::constant(1.0);
    // The largest of the four decides.
    let candidates = [
        [one + a - e - i, b + d, c + g, h - f],
        [b + d, one - a + e - i, f + h, c - g],
        [c + g, f + h, one - a - e + i, d - b],
        [h - f, c - g, d - b, one + a + e + i],
    ];
    let sizes = candidates.map(|[x, y, z, w]| x * x + y * y + z * z + w * w);
    let mut best = ([R::constant(0.0), R::constant(0.0), R::constant(0.0), one], R::constant(0.0));
    for (candidate, size) in candidates.into_iter().zip(sizes) {
        if size > best.1 {
            best = (candidate, size);
        }
    }
    unit(best.0)
}

fn unit<R: Scalar>(q: [R; 4]) -> [R; 4] {
    let [x, y, z, w] = q;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    q.map(|x| x / length)
}

/// A quaternion x, y, z, w turned by a rotation vector in axes of the world.
fn turned_by<R: Scalar>([x, y, z, w]: [R; 4], vector: Vector<R>) -> [R; 4] {
    let half = R::constant(0.5);
    let angle = length(vector);
    let (sine, cosine) = crate::math::sin_cos(half * angle);
    // sin(a / 2) / a
    let part = if angle > R::constant(1e-6) { sine / angle } else { half };
    let [a, b, c] = scale(part, vector);
    unit([
        cosine * x + a * w + b * z - c * y,
        cosine * y - a * z + b * w + c * x,
        cosine * z + a * y - b * x + c * w,
        cosine * w - a * x - b * y - c * z,
    ])
}
