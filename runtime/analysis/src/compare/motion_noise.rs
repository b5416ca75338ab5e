//! What the noise of a measured motion makes of the torques that it needs.
use crate::robot::{Batch, EvaluationError, InverseDynamics};

/// What the noise of the joints' accelerations makes of their efforts, through the mass matrix and rotors at these configurations.
pub(super) fn motion_noise(
    model: &mut dyn InverseDynamics,
    base: usize,
    postures: &[f64],
    accelerations: &[f64],
) -> Result<Vec<f64>, EvaluationError> {
    let (nq, nv) = (model.nq(), model.nv());
    let count = postures.len() / nq.max(1);
    let still = vec![0.0; count * nv];
    let mut torques = |a: &[f64]| {
        let mut tau = vec![0.0; count * nv];
        model.torques(&Batch { count, q: postures, v: &still, a }, &mut tau).map(|()| tau)
    };
    let held = torques(&still)?;
    let mut variances = vec![0.0; accelerations.len()];
    for (moving, noise) in accelerations.iter().enumerate().filter(|(_, noise)| **noise > 0.0) {
        let mut pushed = still.clone();
        pushed.iter_mut().skip(base + moving).step_by(nv).for_each(|a| *a = 1.0);
        let heavy = torques(&pushed)?;
        for (joint, variance) in variances.iter_mut().enumerate() {
            let row = |tau: &[f64], i: usize| tau[i * nv + base + joint];
            let squares: f64 = (0..count).map(|i| (row(&heavy, i) - row(&held, i)).powi(2)).sum();
            *variance += noise.powi(2) * squares / count.max(1) as f64;
        }
    }
    Ok(variances.into_iter().map(f64::sqrt).collect())
}
