//! From wishes for soles, centre of mass and torso to joint angles, velocities and accelerations (6.47)–(6.53).
use super::kinematics::{Posture, ROWS};
use super::legs::Legs;
use bipedc_analysis::walking::{
    Instant, Moved, bounded_least_squares, straight_direction, turn_error, turn_matrix,
};
use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Corrections at one instant.
const MOST: usize = 60;
/// What is left of errors, m and rad.
const SMALL: f64 = 1e-11;
/// What may be left.
const GOOD: f64 = 1e-9;
/// Longest step of a joint in a correction, rad.
const LONGEST: f64 = 0.4;
/// Largest error of a velocity (m/s, rad/s) before a posture counts as singular.
const RATE: f64 = 1e-7;

/// All that is wished at an instant, the centre of mass included.
#[derive(Debug, Clone)]
pub struct Wish {
    /// Feet, torso, contact.
    pub instant: Instant,
    /// x, y, z, m.
    pub center: [Moved; 3],
}

/// A state that does what is wished.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// As the model's.
    pub q: Vec<f64>,
    /// As the model's.
    pub v: Vec<f64>,
    /// As the model's.
    pub a: Vec<f64>,
}

/// Why no state does.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// Joints at their limits: index, limit.
    pub limits: Vec<(usize, f64)>,
    /// The joint that a stretched leg feels most, with its angle.
    pub stretched: Option<(usize, f64)>,
    /// What is missing, m or rad.
    pub error: f64,
}

/// `q` after the motion `v` of unit time: linear part in the root's axes.
pub fn advance(q: &mut [f64], v: &[f64]) {
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
    let moved = turn * Vector3::new(v[0], v[1], v[2]);
    (0..3).for_each(|i| q[i] += moved[i]);
    let after = turn * UnitQuaternion::from_scaled_axis(Vector3::new(v[3], v[4], v[5]));
    q[3..7].copy_from_slice(after.coords.as_slice());
    q[7..].iter_mut().zip(&v[6..]).for_each(|(q, v)| *q += v);
}

impl Legs {
    /// Moves `q` to what is wished, from where it is; every correction is (6.52) with gains of one per correction.
    ///
    /// # Errors
    /// Nothing within the joints' limits does it.
    pub fn reach(&self, q: &mut [f64], wish: &Wish) -> Result<Posture, Stuck> {
        let bounds_of = |q: &[f64]| -> Vec<[f64; 2]> {
            let of = |column: &usize| match self.joint_at(*column) {
                Some(joint) => joint.position.map(|limit| limit - q[column + 1]),
                None => [-1e9, 1e9],
            };
            self.active.iter().map(of).collect()
        };
        let mut held = Vec::new();
        for _ in 0..MOST {
            let here = self.kinematics.posture(q, &self.soles, &self.heading);
            let missing = self.missing(&here, wish);
            if missing.amax() < SMALL {
                return Ok(here);
            }
            let solved = bounded_least_squares(&self.active_columns(&here), &missing, &bounds_of(q));
            let largest = solved.step.rows_range(6..).amax();
            let part = f64::min(1.0, LONGEST / largest.max(1e-12));
            let mut v = vec![0.0; self.kinematics.nv()];
            self.active.iter().zip(solved.step.iter()).for_each(|(&column, x)| v[column] = part * x);
            advance(q, &v);
            held = solved.held;
        }
        let here = self.kinematics.posture(q, &self.soles, &self.heading);
        let missing = self.missing(&here, wish);
        if missing.amax() < GOOD { Ok(here) } else { Err(self.stuck(q, &here, &held, missing.amax())) }
    }

    /// Velocities and accelerations of the wish at a posture that does it.
    ///
    /// # Errors
    /// The posture is singular: no velocities do it.
    pub fn rates(&self, q: &[f64], here: &Posture, wish: &Wish) -> Result<[Vec<f64>; 2], Stuck> {
        let jacobian = self.active_columns(here);
        let free = vec![[f64::NEG_INFINITY, f64::INFINITY]; self.active.len()];
        let solve = |right: &DVector<f64>| {
            let solved = bounded_least_squares(&jacobian, right, &free);
            let error = (&jacobian * &solved.step - right).amax();
            if error.is_nan() || error >= RATE * (1.0 + right.amax()) {
                return Err(self.stuck(q, here, &[], error));
            }
            let mut full = vec![0.0; self.kinematics.nv()];
            self.active.iter().zip(solved.step.iter()).for_each(|(&column, x)| full[column] = *x);
            Ok(full)
        };
        let v = solve(&rate(wish, 1))?;
        let a = solve(&(rate(wish, 2) - self.kinematics.drift(q, &v, &self.soles)))?;
        Ok([v, a])
    }

    fn joint_at(&self, column: usize) -> Option<&super::soles::Limited> {
        self.joints.iter().find(|joint| joint.column == column)
    }

    fn active_columns(&self, here: &Posture) -> DMatrix<f64> {
        here.jacobian.select_columns(&self.active)
    }

    /// Errors of all tasks (6.50), (6.51), as they enter (6.52).
    fn missing(&self, here: &Posture, wish: &Wish) -> DVector<f64> {
        let mut missing = DVector::zeros(ROWS);
        let turned = |here: &Matrix3<f64>, yaw: f64| {
            let wished = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw).into_inner();
            let error = turn_error(here, &wished);
            turn_matrix(here, &wished).lu().solve(&error).unwrap_or(error)
        };
        for (k, sole) in wish.instant.soles.iter().enumerate() {
            (0..3).for_each(|i| missing[6 * k + i] = sole[i][0] - here.places[k][i]);
            missing.fixed_rows_mut::<3>(6 * k + 3).copy_from(&turned(&here.turns[k], sole[3][0]));
        }
        (0..3).for_each(|i| missing[12 + i] = wish.center[i][0] - here.center[i]);
        missing.fixed_rows_mut::<3>(15).copy_from(&turned(&here.torso, wish.instant.yaw[0]));
        missing
    }

    fn stuck(&self, q: &[f64], here: &Posture, held: &[usize], error: f64) -> Stuck {
        let index = |column: usize| self.joints.iter().position(|joint| joint.column == column);
        let limits = held.iter().filter_map(|&k| {
            let joint = index(self.active[k])?;
            let [low, high] = self.joints[joint].position;
            let angle = q[self.active[k] + 1];
            Some((joint, if (angle - low).abs() < (high - angle).abs() { low } else { high }))
        });
        let column = straight_direction(&self.active_columns(here), 6..self.active.len());
        let stretched = column.and_then(|k| Some((index(self.active[k])?, q[self.active[k] + 1])));
        Stuck { limits: limits.collect(), stretched, error }
    }
}

/// First (1) or second (2) derivatives of all tasks.
fn rate(wish: &Wish, order: usize) -> DVector<f64> {
    let mut rate = DVector::zeros(ROWS);
    for (k, sole) in wish.instant.soles.iter().enumerate() {
        (0..3).for_each(|i| rate[6 * k + i] = sole[i][order]);
        rate[6 * k + 5] = sole[3][order];
    }
    (0..3).for_each(|i| rate[12 + i] = wish.center[i][order]);
    rate[17] = wish.instant.yaw[order];
    rate
}
