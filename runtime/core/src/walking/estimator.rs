//! Where the robot is and how it moves, from encoders, gyroscope, accelerometer and the load of its feet.
//!
//! An extended Kalman filter on the errors of a state (Bloesch and others, *State estimation for legged robots*, RSS 2012; feet with an attitude: Rotella
//! and others, IROS 2014): position, velocity and attitude of the inertial unit, biases of both of its sensors, and pose of each sole that stands. The unit is
//! integrated; feet that stand stay where they are, so that the legs' kinematics measure the unit against them. A foot is anchored where it touches down;
//! on a plane it comes to lie flat at its height; the world is upright where that plane is, and gravity may pull along it. What nothing tells is the position along the ground and the heading: both drift with the
//! way, step by step.
//!
//! Each of a foot's measurements counts by its load, less if it disagrees with all others (Huber), and a foot that goes on disagreeing is anchored anew: it slipped.
use super::error_state::{ACCELEROMETER, ATTITUDE, Errors, FEET, GRAVITY, GYROSCOPE, POSITION, VELOCITY};
use super::estimator_feet::{Anchor, Seen};
use super::quaternion::{to_quaternion, turned_by, upright};
use super::readings::{Believed, Readings};
pub use super::sensed::{Fault, LegKinematics, MOST_JOINTS, Sensed, Settings};
use super::space::{
    Pose, Vector, add, along, cross, cross_matrix, diagonal, identity, length, of_quaternion, scale,
    subtract, transpose, turned, turned_back, zero,
};
use crate::control::slices::{copy, get};
use crate::real::Scalar;

/// Position and quaternion of the base; its twist.
const BASE: [usize; 2] = [7, 6];
/// Longer than this nothing is integrated, s.
const LONGEST_STEP: f64 = 0.1;

/// Biases of more standard deviations than this are none.
const LARGEST_BIAS: f64 = 5.0;
/// Soles within this angle (rad) of what the accelerometer says lie on the ground when the robot begins.
const FLAT: f64 = 0.2;
/// Slopes of more than this are none.
const STEEPEST: f64 = 0.3;
/// How fast soles that stand seem to turn when it begins, rad/s.
const RATTLE: f64 = 0.1;
/// So many samples in a row whose time does not advance: the clock was set back.
const OTHER_CLOCK: u16 = 10;

/// What became of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated<R> {
    /// Which feet the estimate stands on.
    pub standing: [bool; 2],
    /// How much each of them counts, 0 to 1.
    pub trust: [R; 2],
    /// What was wrong.
    pub fault: Option<Fault>,
    /// It does not say where the robot is: no later time, a joint without a believable position, no foot with a load, or begun anew.
    pub blind: bool,
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Estimator<R> {
    pub(super) settings: Settings<R>,
    start: Option<Pose<R>>,
    time: Option<R>,
    /// So many samples in a row were not later than the last one.
    stale: u16,
    pub(super) position: Vector<R>,
    velocity: Vector<R>,
    pub(super) quaternion: [R; 4],
    pub(super) gyroscope: Vector<R>,
    accelerometer: Vector<R>,
    /// Of gravity along the ground: what a slope makes of it; m/s².
    along_ground: Vector<R>,
    /// Readings less biases.
    angular: Vector<R>,
    force: Vector<R>,
    pub(super) feet: [Anchor<R>; 2],
    pub(super) errors: Errors<R>,
    pub(super) readings: Readings<R>,
    pub(super) joints: usize,
    /// So long no sole lay flat, s.
    pub(super) askew: R,
    /// Mean square of how fast soles that stand seem to turn, (rad/s)².
    pub(super) rattle: R,
    q: [R; BASE[0] + MOST_JOINTS],
    v: [R; BASE[1] + MOST_JOINTS],
}

impl<R: Scalar> Estimator<R> {
    /// `start`: pose of the base in the world when it begins. Without, the world's origin is below the middle of the soles that stand then,
    /// and its x axis along that of the base.
    pub fn new(settings: Settings<R>, start: Option<Pose<R>>) -> Self {
        let o = R::constant(0.0);
        let anchor =
            Anchor { standing: false, position: zero(), turn: identity(), age: o, refused: 0, twist: o };
        Self {
            settings,
            start,
            time: None,
            stale: 0,
            position: zero(),
            velocity: zero(),
            quaternion: [o, o, o, R::constant(1.0)],
            gyroscope: zero(),
            accelerometer: zero(),
            along_ground: zero(),
            angular: zero(),
            force: zero(),
            feet: [anchor; 2],
            errors: Errors::new(),
            readings: Readings::new(),
            joints: 0,
            askew: o,
            rattle: R::constant(RATTLE * RATTLE),
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

    /// Gravity along the ground (m/s²), as far as it can be told from a bias of the accelerometer: their sum is what matters, and turning tells them apart.
    pub fn along_ground(&self) -> Vector<R> {
        self.along_ground
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
        if !sensed.time.is_finite() || step.is_some_and(|step| step <= R::constant(0.0)) {
            self.stale = self.stale.saturating_add(1);
            if self.stale >= OTHER_CLOCK && sensed.time.is_finite() {
                self.time = Some(sensed.time);
                self.resume();
            }
            return self.answer(Some(Fault::Time), [R::constant(0.0); 2]);
        }
        self.stale = 0;
        (self.joints, self.time) = (joints, Some(sensed.time));
        let believed = self.readings.take(sensed, &self.settings, step, &mut fault);
        let before = (self.position, self.quaternion);
        let soles = self.look(legs, believed.angular_velocity, &mut fault);
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
        let unloaded = believed.load == [None; 2];
        let answer = self.answer(fault, trust);
        Estimated { blind: answer.blind || unloaded, ..answer }
    }

    fn answer(&self, fault: Option<Fault>, trust: [R; 2]) -> Estimated<R> {
        let standing = self.feet.map(|foot| foot.standing);
        let aloft = (standing == [false; 2] && self.time.is_some()).then_some(Fault::Aloft);
        let at_once = matches!(fault, Some(Fault::Time | Fault::Length | Fault::Restarted));
        let blind = at_once || self.readings.wrong.iter().take(self.joints).any(|wrong| *wrong);
        Estimated { standing, trust, fault: fault.or(aloft), blind }
    }

    /// The first sample: a robot that stands still.
    fn begin(&mut self, believed: &Believed<R>, soles: &[Option<Seen<R>>; 2]) {
        let loads = believed.load.map(|load| load.unwrap_or(R::constant(0.0)));
        let pressed = |foot: usize| get(&loads, foot) >= get(&self.settings.loads, 1);
        // Before any load was measured a robot stands on both. Whether they lie flat then, the accelerometer has to say.
        let none = !pressed(0) && !pressed(1);
        let those = |believed: [bool; 2]| {
            let both = believed.into_iter().enumerate().filter(|(_, stands)| *stands);
            both.filter_map(|(foot, _)| soles.get(foot)?.as_ref())
        };
        let standing = || those([none || pressed(0), none || pressed(1)]);
        let mean = standing().fold(zero(), |sum, sole| add(sum, transpose(sole.turn)[2]));
        let felt = believed.specific_force.filter(|force| length(*force) > R::constant(0.5));
        let agrees = |force: Vector<R>| {
            let most = R::constant(FLAT) * length(force);
            standing().all(|sole| length(cross(transpose(sole.turn)[2], force)) < most)
        };
        let up = match felt {
            _ if length(mean) > R::constant(0.5) && (!none || felt.is_some_and(agrees)) => mean,
            Some(force) => force,
            None => [R::constant(0.0), R::constant(0.0), R::constant(1.0)],
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
        let [slope, _] = self.settings.slope.map(|x| x * self.settings.gravity);
        self.errors.forget(GRAVITY, [slope * slope, slope * slope, R::constant(0.0)]);
        self.along_ground = zero();
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
        let level = [R::constant(0.0), R::constant(0.0), self.settings.gravity];
        let rest = subtract(level, self.along_ground);
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
        let minus = next.map(|row| scale(-step, row));
        self.errors.mix(POSITION, true, &[(VELOCITY, diagonal(step))]);
        let lever = cross_matrix(scale(-step, felt));
        let parts = [(ATTITUDE, lever), (ACCELEROMETER, minus), (GRAVITY, diagonal(step))];
        self.errors.mix(VELOCITY, true, &parts);
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
        let [_, changing] = self.settings.slope.map(|x| x * self.settings.gravity);
        let changing = changing * changing * step;
        self.errors.grow(GRAVITY, [changing, changing, R::constant(0.0)]);
    }

    /// Corrects the state by the errors that are known now.
    fn correct(&mut self, before: (Vector<R>, [R; 4]), fault: &mut Option<Fault>) {
        let known = self.errors.take();
        let of = |first: usize| [0, 1, 2].map(|k| get(&known, first + k));
        self.position = add(self.position, of(POSITION));
        self.velocity = add(self.velocity, of(VELOCITY));
        self.quaternion = turned_by(self.quaternion, of(ATTITUDE));
        let [turning, accelerating] = self.settings.bias.map(|x| R::constant(LARGEST_BIAS) * x);
        self.gyroscope = within(turning, add(self.gyroscope, of(GYROSCOPE)));
        self.accelerometer = within(accelerating, add(self.accelerometer, of(ACCELEROMETER)));
        let steepest = R::constant(STEEPEST) * self.settings.gravity;
        self.along_ground = within(steepest, add(self.along_ground, of(GRAVITY)));
        for (anchor, first) in self.feet.iter_mut().zip(FEET) {
            anchor.position = add(anchor.position, of(first));
            let turn = turned_by(to_quaternion(anchor.turn), of(first + 3));
            anchor.turn = of_quaternion(turn);
            let [_, _, twisted] = subtract(of(ATTITUDE), of(first + 3));
            anchor.twist = anchor.twist + twisted;
        }
        let numbers = self.position.iter().chain(&self.velocity).chain(&self.quaternion);
        let numbers = numbers.chain(&self.gyroscope).chain(&self.accelerometer).chain(&self.along_ground);
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

/// Each coordinate within ±`most`.
fn within<R: Scalar>(most: R, vector: Vector<R>) -> Vector<R> {
    vector.map(|x| if x.abs() > most { x.sign() * most } else { x })
}
