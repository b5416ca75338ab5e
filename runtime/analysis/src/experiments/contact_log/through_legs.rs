//! What the ground does to the joints: its forces through the legs, and the noise of the joints' rows.
use super::ContactExperiment;
use super::effects::Change;
use super::foot::SIGNALS;
use super::forces::mapped;
use super::rows::NOISE_SAMPLES;
use super::unlogged::Elimination;
use crate::robot::feet::Sole;
use nalgebra::Vector3;

impl ContactExperiment<'_> {
    /// Generalised forces of the ground, `Jᵀ w`, of all samples under a change; `samples × nv`.
    pub(super) fn ground_forces(&self, change: &Change) -> Vec<f64> {
        let logged = self.recording.logged();
        let at = |i: usize| {
            let [q, ..] = self.kinematics(i, change);
            let wrench = |f: usize, sole: &Sole| {
                self.recording.feet[f].wrench(sole, &self.true_signals(f, i, sole, change))
            };
            mapped(&self.robot, &self.calls, &self.feet, &q, &logged, wrench)
        };
        let ground = (0..self.samples()).flat_map(at);
        ground.zip(&self.recording.products).map(|(ground, lost)| ground - lost).collect()
    }

    /// Samples at which noise and dependences are looked at.
    fn probes(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.samples()).step_by((self.samples() / NOISE_SAMPLES).max(1))
    }

    /// Noise of the joints' rows: of efforts, of forces through the legs, of accelerations through the mass matrix.
    pub(super) fn joint_noise(&self, change: &Change, elimination: &Elimination) -> Vec<[f64; 2]> {
        let (first, r) = (self.robot.layout.base.nv(), &self.recording);
        let still = r.noise_gain();
        let accelerations = r.acceleration_noise();
        let mut sums = vec![0.0; self.robot.layout.joints.len()];
        let mut shared = sums.clone();
        let mut add = |sample: usize, mut tau: Vec<f64>, sigma: f64, is_effort: bool| {
            elimination.rest_at(sample, &mut tau[first..]);
            let squares = tau[first..].iter().map(|tau| (tau * sigma).powi(2));
            for ((sum, shared), square) in sums.iter_mut().zip(&mut shared).zip(squares) {
                *sum += square;
                *shared += if is_effort { 0.0 } else { square };
            }
        };
        let mut count = 0.0;
        for i in self.probes() {
            count += 1.0;
            let [q, ..] = self.kinematics(i, change);
            for (foot, record) in r.feet.iter().enumerate().filter(|(_, record)| record.is_logged) {
                for k in (0..12).filter(|k| record.noise[*k] > 0.0) {
                    let mut unit = [0.0; SIGNALS];
                    unit[k] = 1.0;
                    let one = |f: usize, sole: &Sole| {
                        if f == foot {
                            record.wrench(sole, &unit)
                        } else {
                            (Vector3::zeros(), Vector3::zeros())
                        }
                    };
                    let tau = mapped(&self.robot, &self.calls, &self.feet, &q, &r.logged(), one);
                    add(i, tau, record.noise[k] * still.sqrt(), false);
                }
            }
            let [q, v, a] = self.true_state(&self.logged_state(i), change);
            for (joint, noise) in r.effort_noise.iter().enumerate() {
                let mut one = vec![0.0; self.calls.nv];
                one[first + joint] = 1.0;
                add(i, one, noise * still.sqrt(), true);
            }
            let mut needed = vec![0.0; self.calls.nv];
            self.calls.moving(self.inverse_dynamics, &q, &v, &a, &mut needed);
            let axes = self.base_axes(&q);
            for (k, sigma) in accelerations.iter().enumerate().filter(|(_, sigma)| **sigma > 0.0) {
                let mut faster = a.clone();
                if first == 6 && k < 3 {
                    // Logged in world axes, wanted in those of the base.
                    faster.iter_mut().zip(axes.row(k).iter()).for_each(|(a, part)| *a += part);
                } else {
                    faster[k] += 1.0;
                }
                let mut more = vec![0.0; self.calls.nv];
                self.calls.moving(self.inverse_dynamics, &q, &v, &faster, &mut more);
                more.iter_mut().zip(&needed).for_each(|(more, needed)| *more -= needed);
                add(i, more, *sigma, false);
            }
        }
        let root = |sum: &f64| (sum / count).sqrt();
        sums.iter().zip(&shared).map(|(all, shared)| [root(all), root(shared)]).collect()
    }
}
