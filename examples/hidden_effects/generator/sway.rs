//! A free robot that sways on both feet and then stands on the right one while the left leg swings.
//!
//! The motion is chosen, the forces follow: base and feet are prescribed, the legs reach by inverse kinematics, the
//! base rows of the inverse dynamics say what the ground has to give.
use super::contact::{Corner, corners, spread, value};
use super::legs::{FUNCTIONS, Legs};
use super::model::{Rigid, read, with_effects};
use super::postures::bent;
use super::random::Random;
use super::truth::{Plan, Scales, Truth};
use super::{Failure, Made, draw, failure, sway_sensors};
use bipedc_compiler::robot::Robot;
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3, Vector6};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

/// Length of the two logs, s.
const DURATION: [f64; 2] = [16.0, 12.0];
/// From here on the robot shifts its weight to the right foot: a part of the duration.
const SHIFT: f64 = 0.6;

/// A sample without sensor errors.
#[derive(Debug, Clone, Default)]
pub struct Sample {
    /// Floating base, then joints.
    pub q: Vec<f64>,
    /// In the base's axes.
    pub v: Vec<f64>,
    /// Joint torques, N m.
    pub effort: Vec<f64>,
    /// Of the corners, world axes, N.
    pub forces: Vec<Vector3<f64>>,
}

/// A prescribed motion.
struct Motion {
    /// Of x, y, z, roll, pitch, yaw: amplitude, angular frequency, phase.
    waves: [[[f64; 3]; 2]; 6],
    step: [f64; 3],
    duration: f64,
    height: f64,
}

/// From 0 to 1 and flat at both ends, six times differentiable enough for our purposes.
fn blend(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x.powi(4) * (35.0 - 84.0 * x + 70.0 * x * x - 20.0 * x.powi(3))
}

impl Motion {
    fn draw(duration: f64, height: f64, r: &mut Random) -> Self {
        let sizes = [0.02, 0.025, 0.015, 0.04, 0.05, 0.05];
        let waves = sizes.map(|size| {
            [(0.25, 0.6), (0.8, 1.3)].map(|(low, high)| {
                let omega = TAU * r.range(low, high);
                [size * r.range(0.4, 0.7) * if low > 0.5 { 0.4 } else { 1.0 }, omega, r.range(0.0, TAU)]
            })
        });
        let step = [r.range(0.02, 0.06), r.range(0.02, 0.05), r.range(3.0, 6.0)];
        Self { waves, step, duration, height }
    }

    /// How far the weight is on the right foot, and how far the left foot is lifted: 0 to 1.
    fn phases(&self, time: f64) -> [f64; 2] {
        let part = time / self.duration;
        let shift = blend((part - SHIFT) / 0.1);
        [shift, blend((part - SHIFT - 0.14) / 0.1)]
    }

    fn base(&self, time: f64) -> Isometry3<f64> {
        let [shift, _] = self.phases(time);
        let wave = |i: usize| {
            let sum: f64 = self.waves[i].iter().map(|[a, w, p]| a * (w * time + p).sin()).sum();
            sum * (1.0 - 0.6 * shift)
        };
        let y = 0.0764 * (1.0 - shift);
        let at = Translation3::new(0.04 + wave(0), y + wave(1), self.height + 0.56 + wave(2));
        Isometry3::from_parts(at, UnitQuaternion::from_euler_angles(wave(3), wave(4), wave(5)))
    }

    /// Right and left foot on rigid ground.
    fn feet(&self, time: f64) -> [Isometry3<f64>; 2] {
        let [_, lift] = self.phases(time);
        let [forward, up, omega] = self.step;
        let swing = lift * (omega * time).sin();
        let left = Translation3::new(forward * swing, 0.1528 + 0.02 * swing, self.height + lift * up);
        let turn = UnitQuaternion::from_euler_angles(0.1 * swing, 0.2 * swing, 0.15 * swing);
        [Isometry3::translation(0.0, 0.0, self.height), Isometry3::from_parts(left, turn)]
    }

    /// How much of the load a foot (right, left) may take.
    fn weights(&self, time: f64) -> [f64; 2] {
        let part = time / self.duration;
        [1.0, 1.0 - blend((part - SHIFT - 0.05) / 0.08)]
    }
}

/// Draws and measures a case.
pub fn generate(plan: &Plan, folder: &Path) -> Result<Made, Failure> {
    let nominal = read(folder, false)?;
    let mut random = Random::named(&plan.seed);
    let mut truth = Truth::new(plan);
    truth.rate_hz = plan.rate.min(500.0);
    if plan.parts.iter().any(|part| part.place.joint.is_some()) {
        truth.scales = scales(plan, &nominal, truth.rate_hz)?;
    }
    draw::effects(plan, &nominal.description, &mut truth, &mut random);
    let actual = with_effects(&nominal, &truth.effects)?;
    let corners = corners(&nominal.description);
    let functions = [&FUNCTIONS[..], &["inverse_dynamics", "inverse_dynamics_with_forces"]].concat();
    let model = Rigid::new(&actual, &functions)?;
    let mut runs = Vec::new();
    for duration in DURATION {
        let motion = Motion::draw(duration, -corners[0].position.z, &mut random);
        runs.push(run(&model, &motion, &corners, &truth.effects, truth.rate_hz)?);
    }
    sway_sensors::measure(plan, [&nominal, &actual], truth, &runs, &corners, &mut random)
}

/// How large the joints' signals are in a motion of this kind.
fn scales(plan: &Plan, nominal: &Robot, rate: f64) -> Result<BTreeMap<String, Scales>, Failure> {
    let functions = [&FUNCTIONS[..], &["inverse_dynamics", "inverse_dynamics_with_forces"]].concat();
    let model = Rigid::new(nominal, &functions)?;
    let corners = corners(&nominal.description);
    let mut random = Random::named(&format!("{} quiet", plan.seed));
    let motion = Motion::draw(DURATION[1], -corners[0].position.z, &mut random);
    let run = run(&model, &motion, &corners, &[], rate)?;
    let of = |j: usize| {
        let column = |value: &dyn Fn(&Sample) -> f64| -> Vec<f64> { run.iter().map(value).collect() };
        let (q, v) = (column(&|s| s.q[7 + j]), column(&|s| s.v[6 + j]));
        let a: Vec<f64> = v.windows(2).map(|pair| (pair[1] - pair[0]) * rate).collect();
        Scales::of([&q, &v, &a, &column(&|s| s.effort[j])])
    };
    Ok(model.joints.iter().cloned().enumerate().map(|(j, name)| (name, of(j))).collect())
}

fn run(
    model: &Rigid,
    motion: &Motion,
    corners: &[Corner],
    effects: &[Effect],
    rate: f64,
) -> Result<Vec<Sample>, Failure> {
    let count = (motion.duration * rate).round() as usize + 1;
    let mut sunk = vec![[Isometry3::identity(); 2]; count + 4];
    let soft =
        value(effects, "ground_compliance", "stiffness").zip(value(effects, "ground_compliance", "damping"));
    // Forces depend on how far the feet sink, but hardly.
    let passes = if soft.is_some() { 3 } else { 1 };
    let mut samples = Vec::new();
    for _ in 0..passes {
        let configurations = configurations(model, motion, &sunk, rate)?;
        samples = (0..count)
            .map(|i| {
                let moment = (&configurations[i..i + 5], i as f64 / rate, rate);
                sample(model, (motion, effects), corners, moment)
            })
            .collect::<Result<Vec<_>, _>>()?;
        if let Some(soil) = soft {
            sunk = sink(&samples, corners, soil, rate);
        }
    }
    Ok(samples)
}

/// Two samples before the first to two after the last, for differences.
fn configurations(
    model: &Rigid,
    motion: &Motion,
    sunk: &[[Isometry3<f64>; 2]],
    rate: f64,
) -> Result<Vec<Vec<f64>>, Failure> {
    let legs = Legs::new(model)?;
    let mut guess: Vec<f64> = model.joints.iter().map(|name| bent(name)).collect();
    let at = sunk.iter().enumerate().map(|(i, sunk)| {
        let time = (i as f64 - 2.0) / rate;
        let rigid = motion.feet(time);
        let q = legs.place(&motion.base(time), &[rigid[0] * sunk[0], rigid[1] * sunk[1]], &guess)?;
        guess = q[7..].to_vec();
        Ok(q)
    });
    at.collect()
}

/// First and second differences of fourth order.
fn differences(values: [f64; 5], rate: f64) -> [f64; 2] {
    let [a, b, c, d, e] = values;
    [
        (a - 8.0 * b + 8.0 * d - e) * rate / 12.0,
        (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) * rate * rate / 12.0,
    ]
}

fn rotation(q: &[f64]) -> Rotation3<f64> {
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5])).to_rotation_matrix()
}

/// Velocity and acceleration from five configurations around a sample.
fn derivatives(around: &[Vec<f64>], rate: f64) -> [Vec<f64>; 2] {
    let here = rotation(&around[2]);
    let turns: Vec<Rotation3<f64>> = around.iter().map(|q| here.inverse() * rotation(q)).collect();
    // Skew parts of R'Ṙ and R'R̈ are angular velocity and acceleration.
    let skew = |order: usize, i: usize, j: usize| {
        let of = |a: usize, b: usize| differences(std::array::from_fn(|k| turns[k][(a, b)]), rate)[order];
        0.5 * (of(i, j) - of(j, i))
    };
    let turn = [0, 1].map(|order| Vector3::new(skew(order, 2, 1), skew(order, 0, 2), skew(order, 1, 0)));
    let element = |i: usize| differences(std::array::from_fn(|k| around[k][i]), rate);
    let world = [0, 1].map(|order| here.inverse() * Vector3::from_fn(|i, _| element(i)[order]));
    let linear = [world[0], world[1] - turn[0].cross(&world[0])];
    [0, 1].map(|order| {
        let base = linear[order].iter().chain(turn[order].iter()).copied();
        base.chain((7..around[2].len()).map(|i| element(i)[order])).collect()
    })
}

/// What a joint's own effects ask of its drive, N m.
fn joint_torque(effect: &Effect, v: f64, a: f64) -> f64 {
    match effect.kind.name {
        "viscous_friction" => effect.value("damping") * v,
        "coulomb_friction" if v != 0.0 => effect.value("torque") * v.signum(),
        "rotor_inertia" => effect.value("inertia") * a,
        _ => 0.0,
    }
}

fn sample(
    model: &Rigid,
    (motion, effects): (&Motion, &[Effect]),
    corners: &[Corner],
    (around, time, rate): (&[Vec<f64>], f64, f64),
) -> Result<Sample, Failure> {
    let q = around[2].clone();
    let [v, a] = derivatives(around, rate);
    let mut arguments = vec![(Argument::Q, &q[..]), (Argument::V, &v[..]), (Argument::A, &a[..])];
    let needed = Vector6::from_column_slice(&model.run(model.function("inverse_dynamics")?, &arguments)[..6]);
    let turn = rotation(&q);
    let force = turn * Vector3::new(needed[0], needed[1], needed[2]);
    let moment = turn * Vector3::new(needed[3], needed[4], needed[5]);
    let base = Vector3::new(q[0], q[1], q[2]);
    let points = points(model, corners, &q)?;
    let share = motion.weights(time);
    let weights: Vec<f64> = corners.iter().map(|c| share[usize::from(c.foot.starts_with("left"))]).collect();
    let forces = spread(&points, &weights, force, moment + base.cross(&force));
    arguments.push((Argument::Forces, &forces));
    let torque = model.run(model.function("inverse_dynamics_with_forces")?, &arguments);
    if torque[..6].iter().any(|t| t.abs() > 1e-6) {
        return Err(failure(format!("the ground's forces leave {:?} on the base", &torque[..6])));
    }
    let forces = forces.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let mut effort = torque[6..].to_vec();
    for effect in effects {
        let joint = effect.location.joint.as_ref();
        if let Some(j) = joint.and_then(|joint| model.joints.iter().position(|name| name == joint)) {
            effort[j] += joint_torque(effect, v[6 + j], a[6 + j]);
        }
    }
    Ok(Sample { effort, forces, q, v })
}

/// Corners in the world.
fn points(model: &Rigid, corners: &[Corner], q: &[f64]) -> Result<Vec<Vector3<f64>>, Failure> {
    let mut poses = Vec::new();
    for side in ["right", "left"] {
        let run = |what: &str| {
            Ok(model.run(model.function(&format!("{what}_of_{side}_foot"))?, &[(Argument::Q, q)]))
        };
        poses.push((Vector3::from_vec(run("position")?), nalgebra::Matrix3::from_vec(run("rotation")?)));
    }
    let at = corners.iter().map(|corner| {
        let (position, turn) = &poses[usize::from(corner.foot.starts_with("left"))];
        position + turn * corner.position
    });
    Ok(at.collect())
}

/// How far the feet sink: every corner on a spring and damper, the sole in the plane nearest to the corners.
fn sink(
    samples: &[Sample],
    corners: &[Corner],
    (stiffness, damping): (f64, f64),
    rate: f64,
) -> Vec<[Isometry3<f64>; 2]> {
    let keep = (-stiffness / (damping * rate)).exp();
    let still = |sample: &Sample| {
        sample.forces.iter().map(|force| -force.z.max(0.0) / stiffness).collect::<Vec<f64>>()
    };
    let mut depth = still(&samples[0]);
    let all = samples.iter().map(|sample| {
        depth = depth.iter().zip(still(sample)).map(|(z, end)| end + (z - end) * keep).collect();
        ["right", "left"].map(|side| plane(corners, &depth, side))
    });
    let mut all: Vec<_> = all.collect();
    let (first, last) = (all[0], all[all.len() - 1]);
    all.splice(0..0, [first; 2]);
    all.extend([last; 2]);
    all
}

/// The small motion of a foot that brings its corners nearest to these heights.
fn plane(corners: &[Corner], heights: &[f64], side: &str) -> Isometry3<f64> {
    let own: Vec<(Vector3<f64>, f64)> = corners
        .iter()
        .zip(heights)
        .filter(|(corner, _)| corner.foot.starts_with(side))
        .map(|(corner, z)| (corner.position, *z))
        .collect();
    let rows = nalgebra::DMatrix::from_fn(own.len(), 3, |i, k| [1.0, own[i].0.y, -own[i].0.x][k]);
    let wanted = nalgebra::DVector::from_iterator(own.len(), own.iter().map(|(_, z)| *z));
    let fit = (rows.transpose() * &rows).lu().solve(&(rows.transpose() * wanted));
    fit.map_or(Isometry3::identity(), |x| {
        Isometry3::new(Vector3::new(0.0, 0.0, x[0]), Vector3::new(x[1], x[2], 0.0))
    })
}
