//! Legs that put their feet where they are wanted, under a free torso.
use super::model::{Function, Rigid};
use super::{Failure, failure};
use bipedc_runtime::Argument;
use nalgebra::{Isometry3, Matrix3, Matrix6, Rotation3, Vector3, Vector6};

/// Places feet by Newton's method.
pub struct Legs<'a> {
    rigid: &'a Rigid,
    feet: [Foot; 2],
}

/// One leg: its foot's functions and the joints that move it.
struct Foot {
    position: Function,
    rotation: Function,
    jacobian: Function,
    joints: Vec<usize>,
}

/// Functions that [`Legs`] needs.
pub const FUNCTIONS: [&str; 6] = [
    "position:right_foot",
    "rotation:right_foot",
    "jacobian:right_foot",
    "position:left_foot",
    "rotation:left_foot",
    "jacobian:left_foot",
];

impl<'a> Legs<'a> {
    /// Right and left leg of a robot with six joints in each.
    ///
    /// # Errors
    /// Other robots.
    pub fn new(rigid: &'a Rigid) -> Result<Self, Failure> {
        let foot = |side: &str| {
            let joints =
                (0..rigid.joints.len()).filter(|&j| rigid.joints[j].starts_with(side)).collect::<Vec<_>>();
            if joints.len() != 6 {
                return Err(failure(format!("the {side} leg has {} joints instead of 6", joints.len())));
            }
            Ok(Foot {
                position: rigid.function(&format!("position_of_{side}_foot"))?,
                rotation: rigid.function(&format!("rotation_of_{side}_foot"))?,
                jacobian: rigid.function(&format!("jacobian_of_{side}_foot"))?,
                joints,
            })
        };
        Ok(Self { rigid, feet: [foot("right")?, foot("left")?] })
    }

    /// Configuration (base and joints) with the base and both feet (right, left) at these poses. `guess` are the
    /// joint angles to start from.
    ///
    /// # Errors
    /// Out of reach.
    pub fn place(
        &self,
        base: &Isometry3<f64>,
        feet: &[Isometry3<f64>; 2],
        guess: &[f64],
    ) -> Result<Vec<f64>, Failure> {
        let mut q: Vec<f64> = base.translation.vector.iter().copied().collect();
        q.extend(base.rotation.coords.iter());
        q.extend(guess);
        for (foot, wanted) in self.feet.iter().zip(feet) {
            self.reach(foot, wanted, &mut q)?;
        }
        Ok(q)
    }

    fn reach(&self, foot: &Foot, wanted: &Isometry3<f64>, q: &mut [f64]) -> Result<(), Failure> {
        for _ in 0..60 {
            let arguments = [(Argument::Q, &*q)];
            let at = Vector3::from_vec(self.rigid.run(foot.position, &arguments));
            let turned = Matrix3::from_vec(self.rigid.run(foot.rotation, &arguments));
            let left =
                wanted.rotation.to_rotation_matrix() * Rotation3::from_matrix_unchecked(turned).inverse();
            // The skew part: an arc cosine would lose half of the digits near the goal.
            let turn = 0.5
                * Vector3::new(
                    left[(2, 1)] - left[(1, 2)],
                    left[(0, 2)] - left[(2, 0)],
                    left[(1, 0)] - left[(0, 1)],
                );
            let shift = wanted.translation.vector - at;
            let error = Vector6::from_iterator(shift.iter().chain(turn.iter()).copied());
            if error.norm() < 1e-13 {
                return Ok(());
            }
            let jacobian = self.rigid.run(foot.jacobian, &arguments);
            let columns =
                foot.joints.iter().map(|j| Vector6::from_column_slice(&jacobian[6 * (6 + j)..6 * (7 + j)]));
            let square = Matrix6::from_columns(&columns.collect::<Vec<_>>());
            let step = square.lu().solve(&error).ok_or_else(|| failure("the leg is straight"))?;
            let short = (0.3 / step.amax().max(0.3)).min(1.0);
            foot.joints.iter().zip(step.iter()).for_each(|(&j, s)| q[7 + j] += short * s);
            if error.norm() < 1e-11 {
                return Ok(());
            }
        }
        Err(failure("the feet are out of reach"))
    }
}
