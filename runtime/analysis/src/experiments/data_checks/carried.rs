//! Something that a link carries, which looks like a sign or a zero that is mixed up: a mass beside the axis of a last joint turns its load
//! about.
use super::Evidence;
use super::hypothesis::{SMOOTHING, View};
use nalgebra::{SMatrix, SVector};

/// Mass and first moment of a body, friction, damping and bias.
const UNKNOWNS: usize = 7;

impl View {
    /// Part of the variance of some joints' torques that is left, in sum, if one body had another mass and another first moment: of the body with
    /// which least is left.
    pub fn left_by_a_body(&self, evidence: &Evidence<'_>, joints: &[usize]) -> f64 {
        let moments = (evidence.moments)(&self.motion);
        let states = self.motion.v.len() / self.motion.nv().max(1);
        let bodies = moments.len() / (4 * self.motion.v.len()).max(1);
        let of = |body: usize| -> f64 {
            joints.iter().map(|&joint| self.left_by(&moments, [body, bodies], joint, states)).sum()
        };
        (0..bodies).map(of).fold(f64::INFINITY, f64::min)
    }

    fn left_by(&self, moments: &[f64], [body, bodies]: [usize; 2], joint: usize, states: usize) -> f64 {
        let (nv, effort) = (self.motion.nv(), &self.effort[joint]);
        let row = nv - self.effort.len() + joint;
        let loads = self.motion.of_joint(&self.load, joint).zip(self.motion.velocities(joint));
        let mut gram = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        let (mut right, mut squares) = (SVector::<f64, UNKNOWNS>::zeros(), 0.0);
        for (state, ((load, v), measured)) in loads.zip(effort).enumerate().take(states) {
            let at = |k: usize| moments[((state * bodies + body) * 4 + k) * nv + row];
            let x = SVector::from([at(0), at(1), at(2), at(3), (v / SMOOTHING).tanh(), v, 1.0]);
            let y = measured - load;
            gram += x * x.transpose();
            right += x * y;
            squares += y * y;
        }
        let ridge = SMatrix::from_diagonal(&gram.diagonal().map(|d| 1e-9 * d + 1e-30));
        let Some(found) = (gram + ridge).lu().solve(&right) else { return 1.0 };
        let left = squares - 2.0 * found.dot(&right) + (gram * found).dot(&found);
        let mean = effort.iter().sum::<f64>() / effort.len().max(1) as f64;
        let variance: f64 = effort.iter().map(|u| (u - mean).powi(2)).sum();
        left.max(0.0) / variance.max(f64::MIN_POSITIVE)
    }
}
