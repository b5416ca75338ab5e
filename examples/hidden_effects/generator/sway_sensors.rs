//! Logs of a free robot: base, joints and feet, with sensor errors; and their errors against a model.
use super::contact::{Corner, reading};
use super::model::Rigid;
use super::random::Random;
use super::sensors::rounded;
use super::sway::Sample;
use super::table::Table;
use super::truth::{Plan, Truth};
use super::{Failure, Made, failure};
use bipedc_analysis::signal::{Butterworth, Spline, rotation};
use bipedc_compiler::robot::Robot;
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::f64::consts::TAU;

/// Standard deviations: corner force (N), base position (m), quaternion (1), velocities (m/s, rad/s), effort (N m).
const NOISE: [f64; 5] = [0.15, 2e-4, 2e-4, 3e-3, 0.03];
/// Below this load a foot has no centre of pressure, N.
const LOADED: f64 = 5.0;
/// Cut-off of the comparison, Hz, and what is left out at both ends, s.
pub const CUTOFF: f64 = 10.0;
const TRIM: f64 = 0.5;

/// Makes the tables and judges nominal and true model.
pub fn measure(
    plan: &Plan,
    [nominal, actual]: [&Robot; 2],
    mut truth: Truth,
    runs: &[Vec<Sample>],
    corners: &[Corner],
    random: &mut Random,
) -> Result<Made, Failure> {
    let names = ["corner_force", "base_position", "base_orientation", "base_velocity", "effort"];
    truth.noise = names.iter().map(|name| (*name).to_owned()).zip(NOISE).collect();
    let measured: Vec<Vec<Sample>> =
        runs.iter().map(|run| run.iter().map(|s| blurred(s, plan.counts, random)).collect()).collect();
    let rigid = Rigid::new(nominal, &["inverse_dynamics"])?;
    truth.metric = "base_force".to_owned();
    truth.nominal = error(&rigid, &measured[1], &truth, corners, false)?;
    truth.oracle = error(&Rigid::new(actual, &["inverse_dynamics"])?, &measured[1], &truth, corners, true)?;
    let mut tables = measured.iter().map(|run| table(&rigid.joints, run, &truth, corners));
    let (Some(train), Some(validation)) = (tables.next(), tables.next()) else {
        return Err(failure("two runs are needed"));
    };
    Ok(Made { train, validation, truth })
}

/// With noise, before what the force sensors do.
fn blurred(sample: &Sample, counts: f64, r: &mut Random) -> Sample {
    let [force, position, turn, speed, effort] = NOISE;
    let blur = |value: &f64, sigma: f64, r: &mut Random| value + sigma * r.normal();
    let mut q: Vec<f64> = Vec::new();
    for (i, value) in sample.q.iter().enumerate() {
        q.push(match i {
            0..3 => blur(value, position, r),
            3..7 => blur(value, turn, r),
            _ => rounded(*value, TAU / counts),
        });
    }
    Sample {
        q,
        v: sample.v.iter().map(|v| blur(v, speed, r)).collect(),
        effort: sample.effort.iter().map(|u| blur(u, effort, r)).collect(),
        forces: sample.forces.iter().map(|f| f + Vector3::from_fn(|_, _| force * r.normal())).collect(),
    }
}

/// Force and centre of pressure of a foot as its sensors report them.
fn foot(sample: &Sample, side: &str, effects: &[Effect], corners: &[Corner]) -> (Vector3<f64>, [f64; 2]) {
    let name = format!("{side}_foot");
    let own = corners.iter().zip(&sample.forces).filter(|(corner, _)| corner.foot == name);
    let (mut force, mut moment) = (Vector3::zeros(), [0.0; 2]);
    for (corner, f) in own {
        force += f;
        moment[0] += corner.position.x * f.z;
        moment[1] += corner.position.y * f.z;
    }
    let cop = if force.z > LOADED { moment.map(|m| m / force.z) } else { [f64::NAN; 2] };
    (reading(effects, &name, "", force), cop)
}

fn table(joints: &[String], run: &[Sample], truth: &Truth, corners: &[Corner]) -> Table {
    let mut table = Table::default();
    let column = |value: &dyn Fn(&Sample) -> f64| run.iter().map(value).collect::<Vec<f64>>();
    table.push("time", 4, (0..run.len()).map(|i| i as f64 / truth.rate_hz).collect());
    for (j, joint) in joints.iter().enumerate() {
        table.push(format!("{joint}/position"), 7, column(&|s| s.q[7 + j]));
        table.push(format!("{joint}/effort"), 4, column(&|s| s.effort[j]));
    }
    for side in ["right", "left"] {
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let force = column(&|s| foot(s, side, &truth.effects, corners).0[i]);
            table.push(format!("{side}_foot/force/{axis}"), 3, force);
        }
        for (i, axis) in ["x", "y"].into_iter().enumerate() {
            let cop = column(&|s| foot(s, side, &truth.effects, corners).1[i]);
            table.push(format!("{side}_foot/cop/{axis}"), 6, cop);
        }
    }
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        table.push(format!("base/position/{axis}"), 6, column(&|s| s.q[i]));
    }
    for (i, axis) in ["x", "y", "z", "w"].into_iter().enumerate() {
        table.push(format!("base/orientation/{axis}"), 6, column(&|s| s.q[3 + i]));
    }
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let world = |s: &Sample| (turn(&s.q) * Vector3::new(s.v[0], s.v[1], s.v[2]))[i];
        table.push(format!("base/linear_velocity/{axis}"), 5, column(&world));
    }
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        table.push(format!("base/angular_velocity/{axis}"), 5, column(&|s| s.v[3 + i]));
    }
    table
}

fn turn(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]))
}

/// A foot's force as it would be read without the effects.
fn corrected(reading: Vector3<f64>, name: &str, effects: &[Effect]) -> Vector3<f64> {
    effects.iter().filter(|e| e.location.sensor.as_deref().is_none_or(|s| s == name)).fold(
        reading,
        |f, effect| match effect.kind.name {
            "force_sensor_gain" => f / effect.value("gain"),
            "force_sensor_bias" => f - Vector3::new(effect.value("x"), effect.value("y"), effect.value("z")),
            _ => f,
        },
    )
}

/// Root mean square of the force that the feet report minus the one that the base's motion needs, world axes, N.
fn error(
    rigid: &Rigid,
    run: &[Sample],
    truth: &Truth,
    corners: &[Corner],
    correct: bool,
) -> Result<f64, Failure> {
    let rate = truth.rate_hz;
    let filter = Butterworth::new(CUTOFF, rate).map_err(|e| failure(format!("{e:?}")))?;
    let smooth = |values: Vec<f64>| {
        let filtered = filter.zero_phase(&values);
        Spline::new(&filtered, 1.0 / rate).ok_or_else(|| failure("the log is too short"))
    };
    let q: Vec<Spline> = (0..run[0].q.len())
        .map(|i| smooth(run.iter().map(|s| s.q[i]).collect()))
        .collect::<Result<_, _>>()?;
    let mut ground = Vec::new();
    for i in 0..3 {
        let total = |s: &Sample| -> f64 {
            let feet = ["right", "left"].map(|side| {
                let reading = foot(s, side, &truth.effects, corners).0;
                let name = format!("{side}_foot");
                if correct { corrected(reading, &name, &truth.effects) } else { reading }
            });
            feet[0][i] + feet[1][i]
        };
        ground.push(smooth(run.iter().map(total).collect())?);
    }
    let function = rigid.function("inverse_dynamics")?;
    let trim = (TRIM * rate) as usize;
    let (mut sum, mut count) = (0.0, 0.0);
    for i in trim..run.len() - trim {
        let motion: Vec<[f64; 3]> = q.iter().map(|spline| spline.at_sample(i)).collect();
        let (state, frame) = state(&motion)?;
        let [q, v, a] = &state;
        let needed = rigid.run(function, &[(Argument::Q, q), (Argument::V, v), (Argument::A, a)]);
        let needed = frame * Vector3::new(needed[0], needed[1], needed[2]);
        for k in 0..3 {
            sum += (ground[k].at_sample(i)[0] - needed[k]).powi(2);
            count += 1.0;
        }
    }
    Ok((sum / f64::max(count, 1.0)).sqrt())
}

/// Coordinates of the model from positions and their derivatives.
fn state(motion: &[[f64; 3]]) -> Result<([Vec<f64>; 3], UnitQuaternion<f64>), Failure> {
    let part = |order: usize| -> [f64; 4] { std::array::from_fn(|i| motion[3 + i][order]) };
    let turning = rotation(part(0), part(1), part(2)).ok_or_else(|| failure("a quaternion is zero"))?;
    let mut q: Vec<f64> = motion.iter().map(|m| m[0]).collect();
    q[3..7].copy_from_slice(&turning.quaternion);
    let frame = turn(&q);
    let world = |order: usize| frame.inverse() * Vector3::from_fn(|i, _| motion[i][order]);
    let (omega, alpha) = (Vector3::from(turning.velocity), Vector3::from(turning.acceleration));
    let linear = world(1);
    let faster = world(2) - omega.cross(&linear);
    let joints = |order: usize| motion[7..].iter().map(move |m| m[order]);
    let v = linear.iter().chain(omega.iter()).copied().chain(joints(1)).collect();
    let a = faster.iter().chain(alpha.iter()).copied().chain(joints(2)).collect();
    Ok(([q, v, a], frame))
}
