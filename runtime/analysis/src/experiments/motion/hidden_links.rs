//! The motion of several links behind springs, where only their motors' angles are measured and each shakes the others.
//!
//! As in `hidden_link`, with the mass matrix of all of them: Σₖ Mⱼₖ ëₖ + Kⱼ eⱼ + τ₀ⱼ = −kⱼ eⱼ. One after the other would not converge: what a shank does
//! to its thigh near their resonances is as large as what the thigh does by itself.
use super::hidden_link::{BETA, GAMMA, LEAST_INERTIA, along, drawn, middle, reversed};
use nalgebra::DMatrix;
use std::ops::Range;

/// What is known of some joints at every sample.
pub(super) struct Links<'a> {
    /// τ₀ by joint, N m.
    pub load: &'a [Vec<f64>],
    /// M of these joints, `joints × joints` at each sample, kg m².
    pub inertia: &'a [DMatrix<f64>],
    /// Of each joint M and K (kg m², N m/rad), see `hidden_link`.
    pub resistance: &'a [&'a [[f64; 2]]],
    /// Measured torque through each spring, N m; empty: none.
    pub measured: &'a [Vec<f64>],
    /// Stretches without gaps.
    pub segments: &'a [Range<usize>],
    /// s
    pub step: f64,
}

/// Link minus motor by joint: rad, rad/s, rad/s².
type State = Vec<[f64; 3]>;

impl Links<'_> {
    /// Link minus motor behind springs (N m/rad) at every sample, by joint.
    pub fn behind(&self, stiffness: &[f64]) -> Vec<Vec<[f64; 3]>> {
        let samples = self.inertia.len();
        let solvers: Vec<DMatrix<f64>> = (0..samples).map(|i| self.solver(stiffness, i)).collect();
        let mut mean = vec![vec![[0.0; 3]; samples]; stiffness.len()];
        let at_rest = |first: usize| -> State {
            let of_joint = |(j, stiffness): (usize, &f64)| {
                [-self.load[j][first] / (stiffness + self.resistance[j][first][1].max(0.0)), 0.0, 0.0]
            };
            stiffness.iter().enumerate().map(of_joint).collect()
        };
        let next = |i: usize, state: &State| self.next((stiffness, &solvers[i]), i, state);
        let back = |state: &State| state.iter().copied().map(reversed).collect();
        along(self.segments, &at_rest, &next, &back, &mut |i, late: &State, early: &State| {
            for ((mean, late), early) in mean.iter_mut().zip(late).zip(early) {
                mean[i] = middle(*late, *early);
            }
        });
        mean
    }

    /// What turns forces into angles at the end of a step to a sample: the inverse of M / (β h²) + K + k. A slope that turns a link over is taken
    /// explicitly: the rest always has a solution.
    fn solver(&self, stiffness: &[f64], i: usize) -> DMatrix<f64> {
        let mut matrix = &self.inertia[i] / (BETA * self.step * self.step);
        for (j, stiffness) in stiffness.iter().enumerate() {
            matrix[(j, j)] += self.resistance[j][i][1].max(0.0) + stiffness;
        }
        let diagonal = DMatrix::from_diagonal(&matrix.diagonal().map(f64::recip));
        matrix.try_inverse().unwrap_or(diagonal)
    }

    fn next(&self, (stiffness, solver): (&[f64], &DMatrix<f64>), i: usize, state: &State) -> State {
        let h = self.step;
        let ahead: Vec<f64> = state.iter().map(|[e, v, a]| e + h * v + h * h * (0.5 - BETA) * a).collect();
        let joints = 0..stiffness.len();
        let force = |j: usize| {
            let inertial: f64 = joints.clone().map(|k| self.inertia[i][(j, k)] * ahead[k]).sum();
            inertial / (BETA * h * h) - self.load[j][i] - self.resistance[j][i][1].min(0.0) * ahead[j]
        };
        let forces: Vec<f64> = joints.clone().map(force).collect();
        let of_joint = |j: usize| {
            let e: f64 = joints.clone().map(|k| solver[(j, k)] * forces[k]).sum();
            let a = (e - ahead[j]) / (BETA * h * h);
            let v = state[j][1] + h * ((1.0 - GAMMA) * state[j][2] + GAMMA * a);
            let off = self.measured[j].get(i).map_or(0.0, |measured| -measured / stiffness[j] - e);
            let inertia = self.resistance[j][i][0].max(LEAST_INERTIA);
            drawn([e, v, a], off, (stiffness[j] / inertia).sqrt(), h)
        };
        joints.clone().map(of_joint).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STIFFNESS: [f64; 2] = [900.0, 300.0];
    const INERTIA: [[f64; 2]; 2] = [[1.1, 0.35], [0.35, 0.2]];

    /// Two links that shake each other behind motors that move by sines, by small steps of the exact equations: load, angle behind and torque of each.
    fn simulated(step: f64) -> [[Vec<f64>; 2]; 3] {
        let fine = 100_u32;
        let h = step / f64::from(fine);
        let [one, two] = [(0.3, 4.0), (0.5, 7.0)];
        let motor = |(size, rate): (f64, f64), t: f64| size * (rate * t).sin();
        let accelerated = |(size, rate): (f64, f64), t: f64| -size * rate * rate * (rate * t).sin();
        let determinant = INERTIA[0][0] * INERTIA[1][1] - INERTIA[0][1] * INERTIA[1][0];
        let (mut q, mut w) = ([0.02, -0.03], [one.0 * one.1, two.0 * two.1]);
        let [mut load, mut angle, mut torque]: [[Vec<f64>; 2]; 3] = Default::default();
        for k in 0..(10.0 / step) as u32 * fine {
            let t = f64::from(k) * h;
            let moved = [motor(one, t), motor(two, t)];
            let now: [f64; 2] = std::array::from_fn(|j| -STIFFNESS[j] * (q[j] - moved[j]));
            if k % fine == 0 {
                let a = [accelerated(one, t), accelerated(two, t)];
                for j in 0..2 {
                    load[j].push(INERTIA[j][0] * a[0] + INERTIA[j][1] * a[1]);
                    angle[j].push(q[j] - moved[j]);
                    torque[j].push(now[j]);
                }
            }
            let a = [
                (INERTIA[1][1] * now[0] - INERTIA[0][1] * now[1]) / determinant,
                (INERTIA[0][0] * now[1] - INERTIA[1][0] * now[0]) / determinant,
            ];
            for j in 0..2 {
                w[j] += h * a[j];
                q[j] += h * w[j];
            }
        }
        [load, angle, torque]
    }

    /// Root mean square by which each link is found off, as a part of how far it is behind its motor.
    fn off(step: f64) -> [f64; 2] {
        let [load, angle, torque] = simulated(step);
        let samples = load[0].len();
        let inertia = vec![DMatrix::from_fn(2, 2, |r, c| INERTIA[r][c]); samples];
        let resistance = [0, 1].map(|j| vec![[INERTIA[j][j], 0.0]; samples]);
        let resistance = [&resistance[0][..], &resistance[1][..]];
        let (whole, measured) = (0..samples, &torque);
        let segments = std::slice::from_ref(&whole);
        let links =
            Links { load: &load, inertia: &inertia, resistance: &resistance, measured, segments, step };
        let found = links.behind(&STIFFNESS);
        let rms = |values: Vec<f64>| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
        [0, 1].map(|j| {
            let late = samples / 2..samples;
            let size = rms(angle[j][late.clone()].to_vec());
            rms(late.map(|i| found[j][i][0] - angle[j][i]).collect()) / size
        })
    }

    /// The faster of both oscillations has 23 samples a period at steps of 4 ms, where the trapezoidal rule has its frequency 0.6 % too low. With half the
    /// step a quarter of the error is left (1.16 and 0.29 % of what the second link is behind).
    #[test]
    fn links_that_shake_each_other_are_found() {
        let [coarse, fine] = [0.004, 0.002].map(off);
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            assert!(coarse < 0.015 && fine < coarse / 3.5, "{coarse}, with half the step {fine}");
        }
    }
}
