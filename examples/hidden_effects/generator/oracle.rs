//! How well a set of effects explains a log of a hanging robot: formulas of our own, written once more.
use super::drive::{Drive, Dry, Mechanism, Moving, mechanism, smooth_torque};
use super::model::Rigid;
use super::{Failure, failure};
use bipedc_analysis::signal::{Butterworth, Spline};
use bipedc_compiler::description::model::JointKind;
use bipedc_compiler::robot::Robot;
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;

/// Cut-offs that are tried, Hz; the one with the smallest error counts.
const CUTOFFS: [f64; 6] = [10.0, 16.0, 25.0, 40.0, 60.0, 90.0];
/// Left out at both ends, s.
const TRIM: f64 = 0.5;
/// Speed over which the sign of friction changes, of turning (rad/s) and sliding (m/s) joints: the usual smoothing of
/// controllers.
const SMOOTHING: [f64; 2] = [0.02, 0.002];

/// One joint as measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointLog {
    /// Name of the joint.
    pub name: String,
    /// rad
    pub position: Vec<f64>,
    /// N m
    pub effort: Vec<f64>,
    /// rad, as seen from the joint; empty without a sensor.
    pub motor: Vec<f64>,
}

/// A measured run of a hanging robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HangingLog {
    /// Hz
    pub rate: f64,
    /// s
    pub time: Vec<f64>,
    /// In the order of the model.
    pub joints: Vec<JointLog>,
}

/// Root mean square error over all joints (transmission: over those with motor angles): N m, or rad. `actual` already
/// has the effects on masses and gravity.
///
/// # Errors
/// Effects on joints that do not exist; logs that are too short.
pub fn error(
    actual: &Robot,
    log: &HangingLog,
    effects: &[Effect],
    transmission: bool,
) -> Result<f64, Failure> {
    let rigid = Rigid::new(actual, &["inverse_dynamics"])?;
    let local: Vec<Effect> = effects.iter().filter(|e| e.location.joint.is_some()).cloned().collect();
    let drives = mechanism(&rigid.joints, &local)?;
    let slides = |name: &String| {
        actual
            .description
            .joints
            .iter()
            .any(|joint| joint.name == *name && joint.kind == JointKind::Prismatic)
    };
    let smoothing: Vec<f64> = rigid.joints.iter().map(|name| SMOOTHING[usize::from(slides(name))]).collect();
    let mechanism = (&drives, &smoothing[..]);
    let usable = CUTOFFS.iter().filter(|&&cutoff| cutoff < 0.4 * log.rate);
    let errors = usable.map(|&cutoff| at_cutoff(&rigid, mechanism, log, cutoff, transmission));
    errors.collect::<Result<Vec<f64>, _>>().map(|all| all.into_iter().fold(f64::INFINITY, f64::min))
}

fn at_cutoff(
    rigid: &Rigid,
    (drives, smoothing): (&Mechanism, &[f64]),
    log: &HangingLog,
    cutoff: f64,
    transmission: bool,
) -> Result<f64, Failure> {
    let joints = motion(log, drives, cutoff)?;
    let torques = torques(rigid, &joints, log.time.len())?;
    let trim = (TRIM * log.rate) as usize;
    let (mut sum, mut count) = (0.0, 0);
    for (j, (drive, joint)) in drives.iter().zip(&log.joints).enumerate() {
        if transmission && joint.motor.is_empty() {
            continue;
        }
        let gap = if transmission { transmission_of(drive, joint, &torques[j]) } else { Vec::new() };
        let residual = if transmission {
            gap
        } else {
            effort(drive, joint, &predicted(drives, (j, smoothing[j]), &joints, &torques), log.rate)?
        };
        for r in &residual[trim..residual.len().saturating_sub(trim).max(trim)] {
            sum += r * r;
            count += 1;
        }
    }
    Ok((sum / f64::from(count.max(1))).sqrt())
}

/// Positions, velocities and accelerations of one joint.
type Motion = [Vec<f64>; 3];

fn motion(log: &HangingLog, drives: &Mechanism, cutoff: f64) -> Result<Vec<Motion>, Failure> {
    let filter = Butterworth::new(cutoff, log.rate).map_err(|e| failure(format!("{e:?}")))?;
    let joints = log.joints.iter().zip(drives).map(|(joint, drive)| {
        let smooth = filter.zero_phase(&joint.position);
        let spline = Spline::new(&smooth, 1.0 / log.rate).ok_or_else(|| failure("the log is too short"))?;
        let mut motion: Motion = Default::default();
        for i in 0..smooth.len() {
            let [q, v, a] = spline.at_sample(i);
            motion[0].push(q - drive.encoder_offset);
            motion[1].push(v);
            motion[2].push(a);
        }
        Ok(motion)
    });
    joints.collect()
}

/// Rigid-body torques by joint.
fn torques(rigid: &Rigid, joints: &[Motion], samples: usize) -> Result<Vec<Vec<f64>>, Failure> {
    let function = rigid.function("inverse_dynamics")?;
    let mut out = vec![Vec::with_capacity(samples); joints.len()];
    for i in 0..samples {
        let [q, v, a] = [0, 1, 2].map(|k| joints.iter().map(|joint| joint[k][i]).collect::<Vec<f64>>());
        let torque = rigid.run(function, &[(Argument::Q, &q), (Argument::V, &v), (Argument::A, &a)]);
        out.iter_mut().zip(torque).for_each(|(all, torque)| all.push(torque));
    }
    Ok(out)
}

/// True torque of the drive: rigid body plus what the joint adds.
fn predicted(
    drives: &Mechanism,
    (j, smoothing): (usize, f64),
    joints: &[Motion],
    rigid: &[Vec<f64>],
) -> Vec<f64> {
    let drive = &drives[j];
    let samples = rigid[j].len();
    let torque = |i: usize| {
        let [q, v, a] = [0, 1, 2].map(|k| joints.iter().map(|joint| joint[k][i]).collect::<Vec<f64>>());
        let (speed, load) = (v[j], rigid[j][i]);
        let dry: f64 = drive.dry.iter().map(|dry| friction(*dry, (speed, smoothing), load)).sum();
        let far = drive.coupling.map_or(0.0, |(other, [inertia, ..])| inertia * a[other]);
        let motor = drive.elastic.map_or(0.0, |elastic| elastic.motor_inertia);
        load + (drive.rotor + motor) * a[j] + far + dry + smooth_torque(drive, j, &Moving { q: &q, v: &v })
    };
    (0..samples).map(torque).collect()
}

/// Friction with a smoothed sign.
fn friction(dry: Dry, (speed, smoothing): (f64, f64), load: f64) -> f64 {
    let [positive, negative] = dry.limits(speed, load);
    let sign = (speed / smoothing).tanh();
    if sign > 0.0 { positive * sign } else { negative * sign }
}

/// Reported minus predicted torque.
fn effort(drive: &Drive, joint: &JointLog, torque: &[f64], rate: f64) -> Result<Vec<f64>, Failure> {
    let late = drive.delay > 0.0;
    let spline = Spline::new(torque, 1.0 / rate).ok_or_else(|| failure("the log is too short"))?;
    let residual = joint.effort.iter().enumerate().map(|(i, &reported)| {
        // What is reported now acts later.
        let torque = if late { spline.at(i as f64 / rate + drive.delay)[0] } else { torque[i] };
        let true_part = ((reported - drive.bias) * drive.gain).clamp(-drive.limit, drive.limit);
        (true_part - torque) / drive.gain
    });
    Ok(residual.collect())
}

/// Motor minus link angle, minus what spring and play make of the torque.
fn transmission_of(drive: &Drive, joint: &JointLog, load: &[f64]) -> Vec<f64> {
    let twist = |load: f64| {
        drive.elastic.map_or(0.0, |elastic| load / elastic.stiffness + 0.5 * elastic.gap * load.signum())
    };
    let angles = joint.motor.iter().zip(&joint.position).zip(load);
    angles.map(|((motor, link), load)| motor - link - twist(*load)).collect()
}
