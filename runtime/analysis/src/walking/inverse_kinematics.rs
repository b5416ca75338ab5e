//! Differential inverse kinematics with compensation of drift (6.47)–(6.53): errors of orientations, and steps within bounds.
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Below this part of the largest singular value directions are damped.
const NEARLY_SINGULAR: f64 = 2e-3;
/// Largest damping, as a part of the largest singular value.
const DAMPING: f64 = 2e-3;

/// The error of an orientation `e_o = ½ (n_e × n_d + s_e × s_d + a_e × a_d)` (6.51): world axes; rotations have their frame's axes
/// as columns.
pub fn turn_error(here: &Matrix3<f64>, wished: &Matrix3<f64>) -> Vector3<f64> {
    (0..3).map(|k| here.column(k).cross(&wished.column(k))).fold(Vector3::zeros(), |sum, x| sum + x) * 0.5
}

/// `L = −½ (S(n_d) S(n_e) + S(s_d) S(s_e) + S(a_d) S(a_e))` (6.53).
pub fn turn_matrix(here: &Matrix3<f64>, wished: &Matrix3<f64>) -> Matrix3<f64> {
    let skew = |m: &Matrix3<f64>, k: usize| m.column(k).into_owned().cross_matrix();
    (0..3).map(|k| skew(wished, k) * skew(here, k)).fold(Matrix3::zeros(), |sum, x| sum + x) * -0.5
}

/// A step of the joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Of all columns.
    pub step: DVector<f64>,
    /// Columns that are held at their bounds.
    pub held: Vec<usize>,
    /// The equations were close to singular, the step is damped.
    pub damped: bool,
}

/// The least `|J x − b|` within bounds, damped where it is close to singular (Nakamura and Hanafusa, 1986): (6.48), (6.52) with joint
/// limits as constraints. Columns that would leave their bounds are held there one after the other, the farthest first.
pub fn bounded_least_squares(jacobian: &DMatrix<f64>, right: &DVector<f64>, bounds: &[[f64; 2]]) -> Solved {
    let n = jacobian.ncols();
    let mut solved = Solved { step: DVector::zeros(n), held: Vec::new(), damped: false };
    loop {
        let free: Vec<usize> = (0..n).filter(|k| !solved.held.contains(k)).collect();
        let mut rest = right.clone();
        for &k in &solved.held {
            rest -= jacobian.column(k) * solved.step[k];
        }
        let (step, damped) = damped_least_squares(&jacobian.select_columns(&free), &rest);
        solved.damped |= damped;
        free.iter().zip(step.iter()).for_each(|(&k, x)| solved.step[k] = *x);
        let beyond = |k: usize| (bounds[k][0] - solved.step[k]).max(solved.step[k] - bounds[k][1]);
        let farthest = free.iter().copied().max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)));
        match farthest {
            Some(k) if beyond(k) > 0.0 => {
                solved.step[k] = solved.step[k].clamp(bounds[k][0], bounds[k][1]);
                solved.held.push(k);
            }
            _ => return solved,
        }
    }
}

/// Square and far from singular: by LU; else by singular values.
fn damped_least_squares(jacobian: &DMatrix<f64>, right: &DVector<f64>) -> (DVector<f64>, bool) {
    if jacobian.is_square() && jacobian.nrows() > 0 {
        let lu = jacobian.clone().lu();
        let diagonal = lu.u().diagonal().abs();
        if diagonal.min() > NEARLY_SINGULAR * diagonal.max()
            && let Some(x) = lu.solve(right)
        {
            return (x, false);
        }
    }
    if !decomposes(jacobian) {
        return (DVector::zeros(jacobian.ncols()), true);
    }
    let svd = jacobian.clone().svd(true, true);
    let (Some(u), Some(vt)) = (&svd.u, &svd.v_t) else { return (DVector::zeros(jacobian.ncols()), true) };
    let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
    let small = NEARLY_SINGULAR * largest;
    let mut coordinates = u.tr_mul(right);
    let mut damped = false;
    for (x, s) in coordinates.iter_mut().zip(svd.singular_values.iter()) {
        let near = 1.0 - (s / small).powi(2);
        let damping = if *s < small { near * (DAMPING * largest).powi(2) } else { 0.0 };
        damped |= *s < small;
        let square = s * s + damping;
        *x *= if square > 0.0 { s / square } else { 0.0 };
    }
    (vt.tr_mul(&coordinates), damped)
}

/// Singular values exist: of an empty matrix there are none, and of one with NaN they are never found.
fn decomposes(matrix: &DMatrix<f64>) -> bool {
    !matrix.is_empty() && matrix.iter().all(|x| x.is_finite())
}

/// The column that takes the largest part in the direction that the equations feel least: the joint that is stretched.
pub fn straight_direction(jacobian: &DMatrix<f64>, columns: std::ops::Range<usize>) -> Option<usize> {
    if !decomposes(jacobian) {
        return None;
    }
    let svd = jacobian.clone().svd(false, true);
    let vt = svd.v_t?;
    let least = svd.singular_values.imin();
    columns.max_by(|a, b| vt[(least, *a)].abs().total_cmp(&vt[(least, *b)].abs()))
}
