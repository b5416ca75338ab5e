//! What sensors make of a run: rounded angles, late and noisy velocities, noisy torques.
use super::drive::mechanism;
use super::hanging::{Recording, Signals};
use super::model::Rigid;
use super::oracle::{self, HangingLog, JointLog};
use super::random::Random;
use super::table::Table;
use super::truth::{Plan, Truth};
use super::{Failure, Made};
use bipedc_compiler::description::model::JointKind;
use bipedc_compiler::robot::Robot;
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;
use std::f64::consts::TAU;

/// Noise per size of the effect: the range that cases are drawn from.
pub const NOISE: (f64, f64) = (0.01, 0.2);

/// Rounded to the next multiple of the step.
pub fn rounded(value: f64, step: f64) -> f64 {
    (value / step).round() * step
}

/// Tables of both runs, and what the truth's errors are.
pub fn measure_hanging(
    plan: &Plan,
    [nominal, actual]: [&Robot; 2],
    rigid: &Rigid,
    mut truth: Truth,
    runs: [Recording; 2],
    effects: &[Effect],
    random: &mut Random,
) -> Result<Made, Failure> {
    let drives = mechanism(&rigid.joints, effects)?;
    let offsets: Vec<f64> = drives.iter().map(|drive| drive.encoder_offset).collect();
    let sizes = sizes(rigid, &runs[0], &offsets)?;
    truth.size = rigid.joints.iter().cloned().zip(sizes.iter().copied()).collect();
    let noise = noise(&rigid.joints, &sizes, &truth, random);
    truth.noise = rigid.joints.iter().cloned().zip(noise.iter().copied()).collect();
    let quanta: Vec<f64> = rigid.joints.iter().map(|name| quantum(plan, nominal, name)).collect();
    let logs = runs.map(|run| log((plan, &quanta), rigid, &run, &offsets, &noise, random));
    let known: Vec<Effect> = truth.effects.iter().chain(&truth.also_present).cloned().collect();
    let elastic = drives.iter().any(|drive| drive.elastic.is_some());
    truth.metric = if elastic { "transmission" } else { "effort" }.to_owned();
    truth.nominal = oracle::error(nominal, &logs[1], &[], elastic)?;
    truth.oracle = oracle::error(actual, &logs[1], &known, elastic)?;
    if plan.motor_side {
        // What no model knows better than: the noise of the torques.
        truth.metric = "effort".to_owned();
        truth.nominal = oracle::error(nominal, &logs[1], &[], false)?;
        truth.oracle = (noise.iter().map(|s| s * s).sum::<f64>() / noise.len().max(1) as f64).sqrt();
    }
    let [train, validation] = logs.map(|log| table(plan, &log));
    Ok(Made { train, validation, truth })
}

/// Root mean squares of what the nominal model misses at exact angles, velocities and accelerations.
fn sizes(rigid: &Rigid, run: &Recording, offsets: &[f64]) -> Result<Vec<f64>, Failure> {
    let function = rigid.function("inverse_dynamics")?;
    let mut sums = vec![0.0; offsets.len()];
    for i in 0..run.time.len() {
        let of =
            |signal: fn(&Signals) -> &Vec<f64>| run.joints.iter().map(|j| signal(j)[i]).collect::<Vec<f64>>();
        let (mut q, v, a) = (of(|s| &s.q), of(|s| &s.v), of(|s| &s.a));
        q.iter_mut().zip(offsets).for_each(|(q, offset)| *q += offset);
        let torque = rigid.run(function, &[(Argument::Q, &q), (Argument::V, &v), (Argument::A, &a)]);
        for (j, sum) in sums.iter_mut().enumerate() {
            *sum += (run.joints[j].u[i] - torque[j]).powi(2);
        }
    }
    Ok(sums.iter().map(|sum| (sum / run.time.len().max(1) as f64).sqrt()).collect())
}

/// Between 1 % and 20 % of the effect where it shows most; elsewhere a little of the joint's torque.
fn noise(joints: &[String], sizes: &[f64], truth: &Truth, random: &mut Random) -> Vec<f64> {
    let usual = |joint: &String, random: &mut Random| {
        let torque = truth.scales.get(joint).map_or(0.0, |scales| scales.torque);
        0.002 + torque * random.log_range(0.004, 0.02)
    };
    let mut noise: Vec<f64> = joints.iter().map(|joint| usual(joint, random)).collect();
    let most = (0..sizes.len()).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])).unwrap_or(0);
    for effect in truth.effects.iter().chain(&truth.outsiders) {
        let own =
            effect.location.joint.as_ref().and_then(|name| joints.iter().position(|joint| joint == name));
        let at = own.unwrap_or(most);
        let part = random.log_range(NOISE.0, NOISE.1);
        // A spring or play between motor and link does not show in the torque.
        if !matches!(effect.kind.name, "series_elasticity" | "backlash") {
            noise[at] = (part * sizes[at]).max(1e-4);
        }
    }
    noise
}

/// What an encoder tells apart: rad, or m on a wheel of 20 mm radius.
fn quantum(plan: &Plan, robot: &Robot, name: &String) -> f64 {
    let joint = robot.description.joints.iter().find(|joint| joint.name == *name);
    let slides = joint.is_some_and(|joint| joint.kind == JointKind::Prismatic);
    TAU / plan.counts * if slides { 0.02 } else { 1.0 }
}

fn log(
    (plan, quanta): (&Plan, &[f64]),
    rigid: &Rigid,
    run: &Recording,
    offsets: &[f64],
    noise: &[f64],
    random: &mut Random,
) -> HangingLog {
    let read = |j: usize, angles: &[f64], offset: f64| {
        angles.iter().map(|q| rounded(q + offset, quanta[j])).collect()
    };
    let joints = run.joints.iter().enumerate().map(|(j, signals)| JointLog {
        name: rigid.joints[j].clone(),
        position: read(j, &signals.q, offsets[j]),
        effort: signals.u.iter().map(|u| u + noise[j] * random.normal()).collect(),
        motor: read(j, &signals.motor, 0.0),
    });
    HangingLog { rate: plan.rate, joints: joints.collect(), time: run.time.clone() }
}

/// What a drive reports: backward difference of the rounded angle, low-pass of first order at 40 Hz.
fn poor_velocity(position: &[f64], rate: f64) -> Vec<f64> {
    let keep = (-TAU * 40.0 / rate).exp();
    let mut state = 0.0;
    let mut last = position.first().copied().unwrap_or(0.0);
    let slow = position.iter().map(|&q| {
        state = keep * state + (1.0 - keep) * (q - last) * rate;
        last = q;
        state
    });
    slow.collect()
}

fn table(plan: &Plan, log: &HangingLog) -> Table {
    let mut table = Table::default();
    table.push("time", 4, log.time.clone());
    for joint in &log.joints {
        let name = &joint.name;
        if plan.motor_side {
            // A motor without spring or play turns as its link does.
            let motor = if joint.motor.is_empty() { &joint.position } else { &joint.motor };
            table.push(format!("{name}/motor_position"), 7, motor.clone());
            table.push(format!("{name}/effort"), 5, joint.effort.clone());
            continue;
        }
        table.push(format!("{name}/position"), 7, joint.position.clone());
        if plan.velocities {
            table.push(format!("{name}/velocity"), 4, poor_velocity(&joint.position, plan.rate));
        }
        table.push(format!("{name}/effort"), 5, joint.effort.clone());
        if !joint.motor.is_empty() {
            table.push(format!("{name}/motor_position"), 7, joint.motor.clone());
        }
    }
    table
}
