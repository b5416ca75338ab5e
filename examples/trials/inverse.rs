//! Inverse kinematics of TUlip: postures with given feet, torso and centre of mass.
use super::Failure;
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::{Frame, Mechanics};
use bipedc_runtime::nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

/// What a posture shall reach; world axes, x forward, y to the left, z up.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// Of right and left foot: place of the ankle's axis (m) and yaw (rad); the soles stay level.
    pub feet: [([f64; 3], f64); 2],
    /// Of the centre of mass, m.
    pub center_of_mass: [f64; 2],
    /// Of the torso's frame, m.
    pub height: f64,
    /// Of the torso, which stays upright, rad.
    pub yaw: f64,
}

/// Steps of Newton's method.
const STEPS: usize = 40;

/// What is left at most, m and rad.
const SMALL: f64 = 1e-11;

/// Moves `q` to the goal: 18 equations in 18 unknowns, by Newton's method from where it is.
///
/// # Errors
/// The goal is out of reach.
pub fn reach(mechanics: &Mechanics<'_>, q: &mut [f64], goal: &Goal) -> Result<(), Failure> {
    for _ in 0..STEPS {
        let (missed, slopes) = equations(mechanics, q, goal)?;
        if missed.iter().all(|x| x.abs() < SMALL) {
            return Ok(());
        }
        let step = slopes.lu().solve(&missed).ok_or("a singular posture")?;
        let length = f64::min(1.0, 0.3 / step.amax());
        mechanics.advance(q, (step * length).as_slice(), 1.0, Frame::Start);
    }
    Err(format!("out of reach: {goal:?}").into())
}

/// What is missing, and its change per velocity.
fn equations(
    mechanics: &Mechanics<'_>,
    q: &[f64],
    goal: &Goal,
) -> Result<(DVector<f64>, DMatrix<f64>), Failure> {
    let nv = mechanics.nv();
    let v = vec![0.0; nv];
    let of = |name: &str| mechanics.named(name, q, &v).ok_or_else(|| format!("no function {name}"));
    let (mut missed, mut slopes) = (DVector::zeros(nv), DMatrix::zeros(nv, nv));
    for (index, foot) in ["right_foot", "left_foot"].into_iter().enumerate() {
        let (place, yaw) = goal.feet[index];
        let here = of(&format!("position_of_{foot}"))?;
        let turn = Matrix3::from_column_slice(&of(&format!("rotation_of_{foot}"))?);
        let jacobian = DMatrix::from_column_slice(6, nv, &of(&format!("jacobian_of_{foot}"))?);
        for axis in 0..3 {
            missed[6 * index + axis] = place[axis] - here[axis];
        }
        missed.fixed_rows_mut::<3>(6 * index + 3).copy_from(&turn_to(&turn, yaw));
        slopes.view_mut((6 * index, 0), (6, nv)).copy_from(&jacobian);
    }
    let center = of("center_of_mass")?;
    let jacobian = DMatrix::from_column_slice(3, nv, &of("center_of_mass_jacobian")?);
    for axis in 0..2 {
        missed[12 + axis] = goal.center_of_mass[axis] - center[axis];
        slopes.row_mut(12 + axis).copy_from(&jacobian.row(axis));
    }
    let turn = torso(q);
    missed[14] = goal.height - q[2];
    slopes.view_mut((14, 0), (1, 3)).copy_from(&turn.row(2));
    missed.fixed_rows_mut::<3>(15).copy_from(&turn_to(&turn, goal.yaw));
    slopes.view_mut((15, 3), (3, 3)).copy_from(&turn);
    Ok((missed, slopes))
}

/// Sine of the angle times axis, world axes, of the rotation from an orientation to the upright one with this yaw.
fn turn_to(turn: &Matrix3<f64>, yaw: f64) -> Vector3<f64> {
    let r = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw).matrix() * turn.transpose();
    0.5 * Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)])
}

/// Torques of the joints that hold the robot on its right (0) or left foot (1) alone, N m.
///
/// # Errors
/// A model without gravity or Jacobians.
pub fn holding(mechanics: &Mechanics<'_>, q: &[f64], foot: usize) -> Result<Vec<f64>, Failure> {
    let nv = mechanics.nv();
    let of =
        |name: &str| mechanics.named(name, q, &vec![0.0; nv]).ok_or_else(|| format!("no function {name}"));
    let gravity = DVector::from_vec(of("gravity")?);
    let jacobian =
        DMatrix::from_column_slice(6, nv, &of(["jacobian_of_right_foot", "jacobian_of_left_foot"][foot])?);
    // The base is driven by the ground's wrench alone.
    let base = jacobian.columns(0, 6).transpose();
    let wrench = base.lu().solve(&gravity.rows(0, 6)).ok_or("a singular posture")?;
    Ok((gravity - jacobian.tr_mul(&wrench)).as_slice()[6..].to_vec())
}

fn torso(q: &[f64]) -> Matrix3<f64> {
    use bipedc_runtime::nalgebra::{Quaternion, UnitQuaternion};
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
    turn.to_rotation_matrix().into_inner()
}

/// TUlip on the emitted model.
pub fn mechanics() -> Result<Mechanics<'static>, Failure> {
    Ok(Mechanics::new(&tulip::Tulip, BaseKind::Floating).map_err(|error| error.to_string())?)
}
