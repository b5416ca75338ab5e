//! Effects that look like a sign, a zero or a scale that is mixed up: a mass beside the axis of a last joint turns its load about, a strong
//! spring makes of a knee's torque what another angle of the thigh would.
use super::Evidence;
use super::hypothesis::{SMOOTHING, View, spread};
use nalgebra::{DMatrix, DVector};

/// Mass and first moment of a body.
const OF_BODY: usize = 4;
/// Friction, damping, inertia, bias and a spring of each joint: what is carried resists by the square of its distance.
const OF_JOINT: usize = 5;

impl View {
    /// Part of the variance of some joints' torques that is left, in sum, if one body carried something and each joint had friction, a
    /// rotor, a bias and a spring: of the body with which least is left.
    pub fn left_by_effects(&self, evidence: &Evidence<'_>, joints: &[usize]) -> f64 {
        let moments = (evidence.moments)(&self.motion);
        let bodies = moments.len() / (OF_BODY * self.motion.v.len()).max(1);
        let of = |body: usize| self.left_by(&moments, [body, bodies], joints);
        (0..bodies).map(of).fold(f64::INFINITY, f64::min)
    }

    /// The same mass and first moment in all joints' rows, each row in parts of its own spread.
    fn left_by(&self, moments: &[f64], [body, bodies]: [usize; 2], joints: &[usize]) -> f64 {
        let (nv, size) = (self.motion.nv(), OF_BODY + OF_JOINT * joints.len());
        let (mut gram, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
        let mut squares = 0.0;
        for (place, &joint) in joints.iter().enumerate().filter(|(_, joint)| !self.effort[**joint].is_empty())
        {
            let (row, own) = (nv - self.effort.len() + joint, OF_BODY + OF_JOINT * place);
            let scale = spread(&self.effort[joint]).max(f64::MIN_POSITIVE).recip();
            let rates = self.motion.velocities(joint).zip(self.motion.accelerations(joint));
            let moves = self.motion.positions(joint).zip(rates);
            let loads = self.motion.of_joint(&self.load, joint).zip(moves);
            for (state, ((load, (q, (v, a))), measured)) in loads.zip(&self.effort[joint]).enumerate() {
                let mut x = DVector::zeros(size);
                for k in 0..OF_BODY {
                    x[k] = scale * moments[((state * bodies + body) * OF_BODY + k) * nv + row];
                }
                let others = [(v / SMOOTHING).tanh(), v, a, 1.0, q];
                others.iter().enumerate().for_each(|(k, value)| x[own + k] = scale * value);
                let y = scale * (measured - load);
                gram.ger(1.0, &x, &x, 1.0);
                right.axpy(y, &x, 1.0);
                squares += y * y;
            }
        }
        let possible = |(found, less): (DVector<f64>, f64)| (found[0] >= 0.0).then_some(less);
        // A mass below nothing is none at all: its link's own mass sits elsewhere.
        let less = solved(&gram, &right).and_then(possible).or_else(|| {
            let (gram, right) = (gram.remove_row(0).remove_column(0), right.remove_row(0));
            solved(&gram, &right).map(|(_, less)| less)
        });
        let samples = self.motion.v.len() / nv.max(1);
        less.map_or(f64::INFINITY, |less| (squares - less).max(0.0) / samples.max(1) as f64)
    }
}

/// The minimum of a sum of squares, and by how much it is below what nothing explains.
fn solved(gram: &DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, f64)> {
    let ridge = DMatrix::from_diagonal(&gram.diagonal().map(|d| 1e-9 * d + 1e-30));
    let found = (gram + ridge).lu().solve(right)?;
    let less = 2.0 * found.dot(right) - (gram * &found).dot(&found);
    less.is_finite().then_some((found, less))
}
