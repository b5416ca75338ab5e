//! How near motions come to limits, and motions that keep them.
use super::basis::Basis;
use super::information::shifted;
use super::machine::{Limits, Machine, shape_of};
use crate::robot::Trajectory;
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;

/// Part of every limit that covers what lies between the samples of [`fine`].
const GUARD: f64 = 0.003;
/// Step of central differences of torques, rad and rad/s, rad/s².
const STEP: f64 = 1e-5;
/// Halvings of the scale that keeps torques.
const HALVINGS: usize = 12;

/// The largest values of a joint during a motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Peaks {
    /// Smallest and largest position, rad or m.
    pub position: (f64, f64),
    /// rad/s or m/s.
    pub velocity: f64,
    /// rad/s² or m/s².
    pub acceleration: f64,
    /// N m or N.
    pub effort: f64,
}

/// The largest values of each moving joint at the samples of a motion.
///
/// # Errors
/// Those of the model.
pub fn peaks(machine: &Machine<'_>, motion: &Trajectory) -> Result<Vec<Peaks>, Diagnostic> {
    let tau = machine.torques(motion)?;
    let of = |joint: usize| {
        // Unlike `f64::max`, this keeps what is no number.
        let larger = |most: f64, x: f64| if x.is_nan() || x.abs() > most { x.abs() } else { most };
        let range = (f64::INFINITY, f64::NEG_INFINITY);
        Peaks {
            position: motion.positions(joint).fold(range, |(low, high), x| (low.min(x), high.max(x))),
            velocity: motion.velocities(joint).fold(0.0, larger),
            acceleration: motion.accelerations(joint).fold(0.0, larger),
            effort: motion.of_joint(&tau, joint).fold(0.0, larger),
        }
    };
    Ok(machine.moving.iter().map(|&joint| of(joint)).collect())
}

/// Samples at which limits are kept.
pub fn fine(basis: &Basis) -> usize {
    20 * basis.samples() + 1
}

/// Why the middle posture of a motion cannot be held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstacle {
    /// A joint cannot carry it.
    Overload {
        /// Index among the moving joints.
        joint: usize,
        /// What it needs and what it has, N m or N.
        effort: (f64, f64),
    },
    /// Feet are this near, m; negative: they overlap.
    Feet(f64),
}

/// The motion, made smaller where it has to be, so that all limits less `margin` hold at all times.
///
/// Positions, velocities and accelerations by the scale and offset of each joint, torques and the distance of feet by a
/// common scale towards the middle posture, which is bisected: the scale that is taken was checked.
///
/// # Errors
/// Those of the model. Inner: the middle posture alone needs too much.
pub fn kept(
    machine: &Machine<'_>,
    basis: &Basis,
    coefficients: &[f64],
    margin: f64,
) -> Result<Result<Vec<f64>, Obstacle>, Diagnostic> {
    let part = 1.0 - margin - GUARD;
    let count = fine(basis);
    let mut x = coefficients.to_vec();
    for (x, limits) in x.chunks_exact_mut(basis.len()).zip(machine.limits) {
        let [(low, high), v, a] = shape_of(basis, x, count);
        let [v, a] = [v, a].map(|(low, high)| high.max(-low));
        let fits = |peak: f64, limit: f64| if peak > part * limit { part * limit / peak } else { 1.0 };
        let scale = fits(0.5 * (high - low), 1.0)
            .min(fits(limits.room() * v, limits.velocity))
            .min(fits(limits.room() * a, limits.acceleration));
        x[1..].iter_mut().for_each(|x| *x *= scale);
        // Rounding may leave the two a hair apart the wrong way round.
        let (least, most) = (-part - scale * low, part - scale * high);
        x[0] = x[0].clamp(least.min(most), most.max(least));
    }
    let scaled = |scale: f64| -> Vec<f64> {
        let scale = |(k, x): (usize, &f64)| if k % basis.len() == 0 { *x } else { scale * x };
        x.iter().enumerate().map(scale).collect()
    };
    let obstacle = |x: &[f64], count: usize| obstacle(machine, &machine.motion(basis, x, count), part);
    if obstacle(&x, count)?.is_none() {
        return Ok(Ok(x));
    }
    if let Some(obstacle) = obstacle(&scaled(0.0), 1)? {
        return Ok(Err(obstacle));
    }
    let (mut good, mut bad) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if obstacle(&scaled(middle), count)?.is_none() { good = middle } else { bad = middle }
    }
    Ok(Ok(scaled(good)))
}

/// What is in the way of a motion if joints may use this part of their efforts.
fn obstacle(machine: &Machine<'_>, motion: &Trajectory, part: f64) -> Result<Option<Obstacle>, Diagnostic> {
    if let Some(clearance) = machine.clearance {
        let distance = clearance.distance(motion);
        if distance.is_nan() || distance < clearance.least() {
            return Ok(Some(Obstacle::Feet(distance)));
        }
    }
    let peaks = peaks(machine, motion)?;
    let efforts =
        peaks.iter().zip(machine.limits).map(|(peaks, limits)| (peaks.effort, part * limits.effort));
    let worst = efforts.enumerate().max_by(|(_, a), (_, b)| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    // What is no number is the worst of all and no effort at all.
    let worst = worst.filter(|(_, (needed, limit))| needed.is_nan() || needed > limit);
    Ok(worst.map(|(joint, effort)| Obstacle::Overload { joint, effort }))
}

/// Sum over joints and samples of `(|x|/limit − 1)²` where limits are exceeded, and of [`Clearance::excess`]; with its
/// derivatives by positions, velocities and accelerations, laid out like these.
///
/// [`Clearance::excess`]: super::Clearance::excess
///
/// # Errors
/// Those of the model.
pub fn excess(
    machine: &Machine<'_>,
    motion: &Trajectory,
    margin: f64,
) -> Result<(f64, Trajectory), Diagnostic> {
    let joints = machine.layout.joints.len();
    let tau = machine.torques(motion)?;
    let mut gradient = motion.zeros();
    let (mut sum, mut of_torques, mut overloaded) = (0.0, vec![0.0; tau.len()], false);
    let mut over = |x: f64, limit: f64| {
        let excess = (x.abs() / limit - 1.0).max(0.0);
        sum += excess * excess;
        2.0 * excess * x.signum() / limit
    };
    let limits: Vec<Limits> = machine.limits.iter().map(|limits| limits.within(margin + GUARD)).collect();
    for i in 0..motion.len() {
        for (&joint, limits) in machine.moving.iter().zip(&limits) {
            let at = i * joints + joint;
            gradient.q[at] = over(motion.q[at] - limits.center(), limits.room());
            gradient.v[at] = over(motion.v[at], limits.velocity);
            gradient.a[at] = over(motion.a[at], limits.acceleration);
            of_torques[at] = over(tau[at], limits.effort);
            overloaded |= of_torques[at] != 0.0;
        }
    }
    if overloaded {
        for &joint in machine.moving {
            for order in 0..3 {
                let up = machine.torques(&shifted(motion, order, joint, STEP))?;
                let down = machine.torques(&shifted(motion, order, joint, -STEP))?;
                for i in 0..motion.len() {
                    let range = i * joints..(i + 1) * joints;
                    let change: f64 =
                        range.map(|at| of_torques[at] * (up[at] - down[at]) / (2.0 * STEP)).sum();
                    gradient.order_mut(order)[i * joints + joint] += change;
                }
            }
        }
    }
    if let Some(clearance) = machine.clearance {
        sum += clearance.excess(motion, &mut gradient.q);
    }
    Ok((sum, gradient))
}
