//! The estimator on a body whose motion is known in closed form, with noise, biases and every fault.
use super::ground_forces::Numbers;
use bipedc_runtime::Scalar;
use bipedc_runtime::walking::estimator::{Estimated, Estimator, Fault, LegKinematics, Sensed, Settings};
use bipedc_runtime::walking::space::{
    Pose, Turn, Vector, about_z, add, cross, identity, length, of_quaternion, product, scale, subtract,
    transpose, turn_between, turned, turned_back,
};
use std::f64::consts::{PI, TAU};

/// Legs of three sliding joints (along x, y, z of the base) and three turning ones (yaw, pitch, roll).
struct Legs;

/// Turns about y and x.
fn about<R: Scalar>(axis: usize, angle: R) -> Turn<R> {
    // z → y → x → z.
    let [[c, m, _], ..] = about_z(angle);
    let (o, one, s) = (R::constant(0.0), R::constant(1.0), -m);
    match axis {
        0 => [[one, o, o], [o, c, -s], [o, s, c]],
        _ => [[c, o, s], [o, one, o], [-s, o, c]],
    }
}

impl<R: Scalar> LegKinematics<R> for Legs {
    fn joints(&self) -> usize {
        12
    }

    fn sole(&self, foot: usize, joint_position: &[R], jacobian: &mut [[R; 6]]) -> Option<Pose<R>> {
        let own = joint_position.get(6 * foot..6 * foot + 6)?;
        let [x, y, z, yaw, pitch, roll] = own else { return None };
        let (o, one) = (R::constant(0.0), R::constant(1.0));
        let (first, second) = (about_z(*yaw), product(about_z(*yaw), about(1, *pitch)));
        let [a, b, c] = [[o, o, one], turned(first, [o, one, o]), turned(second, [one, o, o])];
        let columns = [[one, o, o, o, o, o], [o, one, o, o, o, o], [o, o, one, o, o, o]];
        let turning = [a, b, c].map(|[x, y, z]| [o, o, o, x, y, z]);
        let places = jacobian.get_mut(6 * foot..6 * foot + 6)?;
        places.iter_mut().zip(columns.into_iter().chain(turning)).for_each(|(place, column)| *place = column);
        Some(Pose { position: [*x, *y, *z], turn: product(second, about(0, *roll)) })
    }
}

const STEP: f64 = 0.5;
const BOTH: f64 = 0.1;
const SPEED: f64 = 0.3;
const WEIGHT: f64 = 200.0;

/// The base, which sways, nods and turns on its way.
fn base(t: f64) -> Pose<f64> {
    // From rest, with continuous accelerations.
    let s = if t < 1.0 { 0.5 * (t - (PI * t).sin() / PI) } else { t - 0.5 };
    let (phase, heading) = (PI * t / STEP, 0.3 * (0.2 * s).sin());
    let part = t.clamp(0.0, 1.0);
    let started = part.powi(3) * (10.0 - 15.0 * part + 6.0 * part * part);
    let turn = product(
        about_z(heading),
        product(about(1, 0.05 * started * (0.7 * phase).sin()), about(0, 0.04 * started * phase.sin())),
    );
    let sway = 0.03 * started * phase.sin();
    Pose { position: [SPEED * s, sway, 0.6 + 0.01 * started * (2.0 * phase).cos()], turn }
}

/// Where a foot stands in its n-th hold, and how far it is lifted on its way; the load.
fn foot(foot: usize, t: f64) -> (Pose<f64>, f64) {
    let side = if foot == 0 { -0.1 } else { 0.1 };
    // The right one swings in even steps, the left one in odd ones.
    let own = t / STEP - foot as f64;
    let cycle = (own / 2.0).floor();
    let within = (own - 2.0 * cycle) * STEP;
    let place = |cycle: f64| {
        let hold = (2.0 * cycle + foot as f64 + 1.5) * STEP;
        let at = base(hold.max(0.0));
        let heading = at.turn[1][0].atan2(at.turn[0][0]);
        Pose {
            position: add([at.position[0], 0.0, 0.0], turned(about_z(heading), [0.0, side, 0.0])),
            turn: about_z(heading),
        }
    };
    let (from, to) = (place(cycle - 1.0), place(cycle));
    let swing = STEP - BOTH;
    if within >= swing {
        let since = within - swing;
        let up = (since / BOTH).min(1.0);
        let down = ((2.0 * STEP - within) / BOTH).min(1.0);
        return (to, WEIGHT * up.min(down).clamp(0.0, 1.0));
    }
    let s = within / swing;
    let part = s - (TAU * s).sin() / TAU;
    let angle = |pose: &Pose<f64>| pose.turn[1][0].atan2(pose.turn[0][0]);
    let mut position = add(from.position, scale(part, subtract(to.position, from.position)));
    position[2] = 0.02 * (1.0 - (TAU * s).cos());
    let yaw = angle(&from) + part * (angle(&to) - angle(&from));
    (Pose { position, turn: product(about_z(yaw), about(1, 0.2 * (TAU * s).sin())) }, 0.0)
}

/// Readings of one time.
#[derive(Clone)]
struct Reading {
    time: f64,
    joints: [f64; 12],
    angular: Vector<f64>,
    force: Vector<f64>,
    load: [f64; 2],
}

/// Noise of a joint's reading, rad.
const ENCODER: f64 = 3e-4;

/// Noise of sensors; 1: encoders of 0.3 mrad, 0.005 rad/s, 0.1 m/s².
struct Sensors {
    numbers: Numbers,
    noise: f64,
    bias: [Vector<f64>; 2],
}

impl Sensors {
    fn new(seed: u64, noise: f64) -> Self {
        let bias = [[0.005, -0.004, 0.006], [0.05, -0.03, 0.04]].map(|b| scale(noise, b));
        Self { numbers: Numbers(seed), noise, bias }
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| 0.5 * self.numbers.next()).sum::<f64>() * self.noise
    }

    fn read(&mut self, t: f64) -> Reading {
        let here = base(t);
        let h = 1e-3;
        let [before, after] = [t - h, t + h].map(base);
        let acceleration: Vector<f64> = std::array::from_fn(|k| {
            (after.position[k] - 2.0 * here.position[k] + before.position[k]) / (h * h)
        });
        let turn = turned_back(here.turn, scale(0.5 / h, turn_between(before.turn, after.turn)));
        let force = turned_back(here.turn, add(acceleration, [0.0, 0.0, 9.81]));
        let mut joints = [0.0; 12];
        let mut load = [0.0; 2];
        for k in 0..2 {
            let (sole, carried) = foot(k, t);
            load[k] = carried;
            let arm = turned_back(here.turn, subtract(sole.position, here.position));
            let s = product(transpose(here.turn), sole.turn);
            let angles = [s[1][0].atan2(s[0][0]), (-s[2][0]).asin(), s[2][1].atan2(s[2][2])];
            joints[6 * k..6 * k + 3].copy_from_slice(&arm);
            joints[6 * k + 3..6 * k + 6].copy_from_slice(&angles);
        }
        joints.iter_mut().for_each(|x| *x += ENCODER * self.normal());
        let [gyroscope, accelerometer] = self.bias;
        let mut noisy =
            |x: Vector<f64>, bias: Vector<f64>, size: f64| add(x, bias).map(|x| x + size * self.normal());
        let (angular, force) = (noisy(turn, gyroscope, 0.005), noisy(force, accelerometer, 0.1));
        let load = load.map(|x| x + 0.5 * self.normal());
        Reading { time: t, joints, angular, force, load }
    }
}

impl Reading {
    fn give<R: Scalar>(&self, estimator: &mut Estimator<R>) -> Estimated<R> {
        let joints = self.joints.map(R::constant);
        let sensed = Sensed {
            time: R::constant(self.time),
            joint_position: &joints,
            joint_velocity: None,
            angular_velocity: self.angular.map(R::constant),
            specific_force: self.force.map(R::constant),
            load: self.load.map(R::constant),
            center: [[R::constant(f64::NAN); 2]; 2],
            motor_position: &[],
        };
        let found = estimator.update(&sensed, &Legs);
        let all = estimator.q().iter().chain(estimator.v());
        assert!(all.clone().all(|x| x.is_finite()), "{}: {found:?}", self.time);
        found
    }
}

/// Errors: of the place (m), of the tilt, of the heading (rad), of the velocity (m/s).
fn errors<R: Scalar + Into<f64>>(estimator: &Estimator<R>, t: f64) -> [f64; 4] {
    let q: Vec<f64> = estimator.q().iter().map(|x| (*x).into()).collect();
    let v: Vec<f64> = estimator.v().iter().map(|x| (*x).into()).collect();
    let (true_pose, h) = (base(t), 1e-5);
    let turn = of_quaternion([q[3], q[4], q[5], q[6]]);
    let off = turn_between(true_pose.turn, turn);
    let velocity = scale(0.5 / h, subtract(base(t + h).position, base(t - h).position));
    let apart = length(subtract(turned(turn, [v[0], v[1], v[2]]), velocity));
    [length(subtract([q[0], q[1], q[2]], true_pose.position)), off[0].hypot(off[1]), off[2].abs(), apart]
}

/// Walks so long, readings changed by `spoil`; the largest errors behind the first second, and what was said.
fn walked<R: Scalar + Into<f64>>(
    (seed, noise): (u64, f64),
    (seconds, rate): (f64, f64),
    mut spoil: impl FnMut(&mut Reading),
) -> ([f64; 4], Vec<(f64, Fault)>, Estimator<R>) {
    let start = base(0.0);
    let start =
        Pose { position: start.position.map(R::constant), turn: start.turn.map(|row| row.map(R::constant)) };
    let mut settings = Settings::of_weight(R::constant(WEIGHT));
    if noise > 0.0 {
        settings.encoder = R::constant(ENCODER * noise);
    }
    let mut estimator = Estimator::new(settings, Some(start));
    let (mut sensors, mut worst, mut faults) = (Sensors::new(seed, noise), [0.0_f64; 4], Vec::new());
    for k in 0..(seconds * rate) as u32 {
        let t = f64::from(k) / rate;
        let mut reading = sensors.read(t);
        spoil(&mut reading);
        let found = reading.give(&mut estimator);
        faults.extend(found.fault.map(|fault| (t, fault)));
        if t > 1.0 {
            worst.iter_mut().zip(errors(&estimator, t)).for_each(|(most, x)| *most = most.max(x));
        }
    }
    (worst, faults, estimator)
}

/// The largest errors of a walk with noisy sensors at 500 Hz, which nobody complains of; biases are found.
fn noisy(seed: u64, seconds: f64) -> [f64; 4] {
    let (worst, faults, estimator) = walked::<f64>((seed, 1.0), (seconds, 500.0), |_| {});
    println!("{seed}: {worst:?} {:?}", estimator.biases());
    assert!(faults.is_empty(), "{:?}", faults[0]);
    let expected = Sensors::new(0, 1.0).bias;
    let off = [0, 1].map(|k| length(subtract(estimator.biases()[k], expected[k])));
    // A bias of the accelerometer and a slope cannot be told apart before the robot has turned far: their sum can.
    let q = estimator.q();
    let turn = of_quaternion([q[3], q[4], q[5], q[6]]);
    let felt = subtract(turned(turn, estimator.biases()[1]), estimator.along_ground());
    let sum = length(subtract(felt, turned(turn, expected[1])));
    println!("{off:?}, with the slope {sum}");
    assert!(off[0] < 2e-4 && off[1] < 0.03 && sum < 0.02, "{off:?} {sum}");
    worst
}

#[test]
fn a_walk_with_noisy_sensors_is_known() {
    let worst = noisy(1, 10.0);
    assert!(worst[0] < 0.005 && worst[1] < 0.002 && worst[2] < 0.002 && worst[3] < 0.015, "{worst:?}");
}

/// 18 m of way.
#[test]
#[ignore = "takes long"]
fn a_walk_with_noisy_sensors_is_known_for_a_minute() {
    for seed in 1..=5 {
        let worst = noisy(seed, 60.0);
        assert!(worst[0] < 0.02 && worst[1] < 0.003 && worst[2] < 0.004 && worst[3] < 0.015, "{worst:?}");
    }
}

/// Nothing but the differences of finite steps is left.
#[test]
fn a_walk_with_exact_sensors_is_known_exactly() {
    let coarse = walked::<f64>((1, 0.0), (4.0, 500.0), |_| {}).0;
    let fine = walked::<f64>((1, 0.0), (4.0, 2000.0), |_| {}).0;
    println!("{coarse:?} {fine:?}");
    assert!(fine[0] < 1e-5 && fine[1] < 1e-5 && fine[3] < 1e-4, "{fine:?}");
    assert!(fine[0] < 0.5 * coarse[0], "{coarse:?} {fine:?}");
}

#[test]
fn single_precision_is_enough() {
    let (worst, faults, _) = walked::<f32>((1, 1.0), (10.0, 500.0), |_| {});
    println!("{worst:?}");
    assert!(faults.is_empty(), "{:?}", faults[0]);
    assert!(worst[0] < 0.005 && worst[1] < 0.002 && worst[3] < 0.015, "{worst:?}");
}

/// What it is called, what it does to readings, what is to be said of it, the largest errors of place (m) and tilt (rad).
type Case = (&'static str, fn(&mut Reading), Fault, [f64; 2]);

/// Between 3.1 and 3.3 s.
#[test]
fn faulty_readings_are_named_and_survived() {
    let cases: [Case; 9] = [
        ("encoder", |r| r.joints[2] = f64::NAN, Fault::JointPosition(2), [0.02, 0.01]),
        ("encoder jumps", |r| r.joints[8] += 0.5, Fault::JointPosition(8), [0.02, 0.01]),
        ("gyroscope", |r| r.angular = [f64::NAN; 3], Fault::Gyroscope, [0.01, 0.01]),
        ("gyroscope frozen", |r| r.angular = [0.1, 0.0, -0.2], Fault::Gyroscope, [0.01, 0.01]),
        ("gyroscope beyond", |r| r.angular[1] = 1e5, Fault::Gyroscope, [0.01, 0.01]),
        ("accelerometer", |r| r.force[0] = f64::INFINITY, Fault::Accelerometer, [0.01, 0.01]),
        ("accelerometer frozen", |r| r.force = [0.0, 0.3, 9.7], Fault::Accelerometer, [0.01, 0.01]),
        ("load", |r| r.load[0] = f64::NAN, Fault::Load(0), [0.02, 0.01]),
        ("time", |r| r.time = 3.05, Fault::Time, [0.5, 0.1]),
    ];
    for (name, spoil, said, most) in cases {
        let spoilt = |r: &mut Reading| {
            if (3.1..3.3).contains(&r.time) {
                spoil(r)
            }
        };
        let (worst, faults, _) = walked::<f64>((1, 1.0), (5.0, 500.0), spoilt);
        println!("{name}: {worst:?} {} faults", faults.len());
        assert!(faults.iter().any(|(_, fault)| *fault == said), "{name}: {faults:?}");
        let last = faults.iter().map(|(t, _)| *t).fold(0.0, f64::max);
        assert!(last < 3.6, "{name}: still at {last}");
        assert!(worst[0] < most[0] && worst[1] < most[1], "{name}: {worst:?}");
    }
}

/// A sole that slides by 40 mm within 0.1 s while it stands alone: it is anchored anew, and half a step later all is as before.
#[test]
fn a_foot_that_slips_is_let_go() {
    let slide = |t: f64| 0.04 * ((t - 3.15) / 0.1).clamp(0.0, 1.0);
    let spoil = |r: &mut Reading| {
        // The left foot stands alone from 3.0 to 3.4 s.
        if r.time < 3.4 {
            let here = base(r.time);
            let moved = turned_back(here.turn, [slide(r.time), 0.0, 0.0]);
            (0..3).for_each(|k| r.joints[6 + k] += moved[k]);
        }
    };
    let (worst, faults, _) = walked::<f64>((1, 1.0), (5.0, 500.0), spoil);
    println!("{worst:?} {faults:?}");
    assert!(faults.iter().any(|(_, fault)| *fault == Fault::Slip(1)), "{faults:?}");
    assert!(worst[0] < 0.03 && worst[1] < 0.01, "{worst:?}");
}

/// A sole that tips by 1 mrad turns by 0.15 mrad about the vertical, less than what noise of encoders lets be seen of it: the gyroscope holds the heading.
#[test]
fn a_sole_that_tips_does_not_turn_the_robot() {
    let spoil = |r: &mut Reading| {
        // The left foot stands alone from 3.0 to 3.4 s.
        if (3.2..3.45).contains(&r.time) {
            r.joints[9] += 1.5e-4;
            r.joints[11] += 1e-3;
        }
    };
    let (worst, faults, _) = walked::<f64>((1, 0.0), (5.0, 1000.0), spoil);
    println!("{worst:?}");
    assert!(faults.is_empty(), "{:?}", faults[0]);
    assert!(worst[2] < 3e-5, "{worst:?}");
}

#[test]
fn without_a_start_the_soles_are_about_the_origin() {
    let mut estimator = Estimator::new(Settings::of_weight(WEIGHT), None);
    let mut sensors = Sensors::new(1, 1.0);
    let mut reading = sensors.read(0.0);
    (reading.load, reading.time) = ([0.5 * WEIGHT; 2], 0.0);
    let found = reading.give(&mut estimator);
    assert_eq!(found.standing, [true; 2]);
    let middle = scale(0.5, add(foot(0, 0.0).0.position, foot(1, 0.0).0.position));
    let expected = subtract(base(0.0).position, middle);
    let q = estimator.q();
    assert!((q[2] - expected[2]).abs() < 1e-3 && length([q[0], q[1], 0.0]) < 0.2, "{q:?} {expected:?}");
    let soles = [0, 1].map(|k| estimator.foot(k).unwrap().position);
    assert!(length(add(soles[0], soles[1])) < 1e-9, "{soles:?}");
}

/// Whatever is read: nothing that is not finite is handed out, nothing panics, and it is itself again when readings are.
#[test]
fn nonsense_gives_finite_numbers() {
    let mut estimator = Estimator::<f64>::new(Settings::of_weight(WEIGHT), None);
    let mut numbers = Numbers(5);
    let wild = |n: &mut Numbers| match (8.0 * (1.0 + n.next())) as u32 {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => -1e300,
        3 => 1e300 * n.next(),
        4 => 1e-320,
        _ => 10.0 * n.next(),
    };
    for k in 0..5_000 {
        let mut reading = Sensors::new(k, 1.0).read(0.0);
        reading.time = if numbers.next() > 0.9 { wild(&mut numbers) } else { f64::from(k as u32) * 1e-3 };
        reading.joints.iter_mut().for_each(|x| *x = wild(&mut numbers));
        reading
            .angular
            .iter_mut()
            .chain(&mut reading.force)
            .chain(&mut reading.load)
            .for_each(|x| *x = wild(&mut numbers));
        reading.give(&mut estimator);
    }
    let mut right = 0;
    let mut sensors = Sensors::new(1, 1.0);
    for k in 0..5000 {
        let mut reading = sensors.read(0.0);
        (reading.time, reading.load) = (1e3 + f64::from(k) * 1e-3, [0.5 * WEIGHT; 2]);
        right += u32::from(reading.give(&mut estimator).fault.is_none());
    }
    let turn = of_quaternion([estimator.q()[3], estimator.q()[4], estimator.q()[5], estimator.q()[6]]);
    let up = cross(turned_back(turn, [0.0, 0.0, 1.0]), turned_back(base(0.0).turn, [0.0, 0.0, 1.0]));
    assert!(right > 4900 && length(up) < 0.01, "{right} {up:?}");
    let wrong = Sensed {
        time: 1e4,
        joint_position: &[0.0; 3],
        joint_velocity: None,
        angular_velocity: [0.0; 3],
        specific_force: [0.0; 3],
        load: [0.0; 2],
        center: [[f64::NAN; 2]; 2],
        motor_position: &[],
    };
    assert_eq!(estimator.update(&wrong, &Legs).fault, Some(Fault::Length));
    assert_eq!(product(identity(), turn), turn);
}
