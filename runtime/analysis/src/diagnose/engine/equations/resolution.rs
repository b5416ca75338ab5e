//! How little of a row is worth an explanation: its noise, or what neither models nor sensors are right by.
//!
//! Logs of simulations have no noise; what is left there are time steps and filters, a hundred thousandth of the signal, and
//! many a cause fits that.
use crate::diagnose::engine::judge::significance::without_sticking;
use crate::experiments::{Channel, Experiment};

/// Part of a row's own signal.
const OWN: f64 = 2e-3;
/// Part of the largest signal of its kind: the others of the force or moment that it is a component of.
const OF_COMPONENTS: f64 = 2e-3;
/// The same among joints, each of which has a drive of its own size.
const OF_JOINTS: f64 = 2e-4;
/// But no more than this part of its own signal: fingers are no worse known for the arm that carries them.
const OF_FINGERS: f64 = 0.01;
/// The same where the ground's forces, which make most of the joints' torques then, are measured by sensors of their own.
const OF_JOINTS_ON_GROUND: f64 = 2e-3;
/// All of these so many times as large beside impacts at which the motion is cut, because filters know one side only there (simulated walks
/// of a five-link and a seven-link robot: 0.3 to 2 % of a joint's torque were wrong).
const BESIDE_IMPACTS: f64 = 10.0;

/// Root mean squares below which errors say nothing, by row.
pub(crate) fn resolutions(experiment: &dyn Experiment) -> Vec<f64> {
    let rows = experiment.rows();
    let size = |row: usize| {
        // Where joints stick or lie at stops drives push as hard as they can, and nothing is told by it.
        let values = experiment.measured(row).unwrap_or_default();
        let free = without_sticking(experiment, row, &values, |_| true);
        let (squares, count) = free.fold((0.0, 0.0), |(sum, n), x| (sum + x * x, n + 1.0));
        let all = || values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64;
        if count > 0.0 { (squares / count).sqrt() } else { all().sqrt() }
    };
    let sizes: Vec<f64> = (0..rows.len()).map(size).collect();
    let largest = |row: usize| {
        let alike =
            |other: &usize| (rows[*other].channel, rows[*other].unit) == (rows[row].channel, rows[row].unit);
        (0..rows.len()).filter(alike).map(|other| sizes[other]).fold(0.0, f64::max)
    };
    let on_ground = rows.iter().any(|row| row.channel == Channel::BaseForce);
    let times = (1.0 + (BESIDE_IMPACTS * BESIDE_IMPACTS - 1.0) * experiment.beside_impacts()).sqrt();
    let resolution = |row: usize| {
        let of_largest = match (rows[row].channel, on_ground) {
            (Channel::Effort, true) => OF_JOINTS_ON_GROUND * largest(row),
            (Channel::Effort, false) => (OF_JOINTS * largest(row)).min(OF_FINGERS * sizes[row]),
            _ => OF_COMPONENTS * largest(row),
        };
        rows[row].noise.max(times * (OWN * sizes[row]).max(of_largest))
    };
    (0..rows.len()).map(resolution).collect()
}
