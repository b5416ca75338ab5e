//! A robot's functions at a posture: soles, centre of mass, torso, their Jacobians; zero moment point, joint torques.
use super::soles::SoleFrame;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::{Argument, Model, State};
use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Rows of all tasks: both soles, centre of mass, torso's orientation.
pub const ROWS: usize = 18;

/// A robot's functions by their places in the model.
pub struct Kinematics {
    model: ProgramModel,
    /// Position, rotation, Jacobian, its rate times velocity.
    feet: [[usize; 4]; 2],
    center: usize,
    center_jacobian: usize,
    center_acceleration: usize,
    zero_moment_point: usize,
    inverse_dynamics: usize,
    gravity: f64,
}

/// A posture: where soles, centre of mass and torso are, and how they move with `v`.
#[derive(Debug, Clone)]
pub struct Posture {
    /// Middles of the soles in the world, m.
    pub places: [Vector3<f64>; 2],
    /// Axes of the soles in the world.
    pub turns: [Matrix3<f64>; 2],
    /// m
    pub center: Vector3<f64>,
    /// Axes of the torso, forward, left, up, in the world.
    pub torso: Matrix3<f64>,
    /// 18 × nv: right sole and left sole (linear, angular), centre of mass, torso (angular); world axes.
    pub jacobian: DMatrix<f64>,
}

impl Kinematics {
    /// Derives what walking needs; `links` carry the feet, right and left.
    ///
    /// # Errors
    /// Functions that cannot be derived.
    pub fn new(robot: &Robot, links: [&str; 2]) -> Result<Self, Diagnostic> {
        const FRAME: [&str; 4] = ["position", "rotation", "jacobian", "jacobian_rate_times_velocity"];
        const WHOLE: [&str; 5] = [
            "center_of_mass",
            "center_of_mass_jacobian",
            "center_of_mass_acceleration",
            "zero_moment_point",
            "inverse_dynamics",
        ];
        let mut requests: Vec<FunctionRequest> = WHOLE.map(FunctionRequest::of_robot).into();
        for link in links {
            let of =
                |family: &str| FunctionRequest { family: family.to_owned(), subject: Some(link.to_owned()) };
            requests.extend(FRAME.map(of));
        }
        let model = ProgramModel::new(robot.compile_only(&requests)?);
        let functions = &model.compiled().functions;
        let find = |family: &str, subject: Option<&str>| {
            let found = functions.iter().position(|f| f.family == family && f.subject.as_deref() == subject);
            found.ok_or_else(|| Diagnostic::error(format!("the robot has no function `{family}`")))
        };
        let foot = |link: &str| -> Result<[usize; 4], Diagnostic> {
            let mut places = [0; 4];
            for (place, family) in places.iter_mut().zip(FRAME) {
                *place = find(family, Some(link))?;
            }
            Ok(places)
        };
        let gravity = robot.description.gravity;
        Ok(Self {
            feet: [foot(links[0])?, foot(links[1])?],
            center: find(WHOLE[0], None)?,
            center_jacobian: find(WHOLE[1], None)?,
            center_acceleration: find(WHOLE[2], None)?,
            zero_moment_point: find(WHOLE[3], None)?,
            inverse_dynamics: find(WHOLE[4], None)?,
            gravity: gravity.iter().map(|x| x * x).sum::<f64>().sqrt(),
            model,
        })
    }

    /// Size of the gravitational acceleration, m/s².
    pub fn gravity(&self) -> f64 {
        self.gravity
    }
    /// Length of `q`.
    pub fn nq(&self) -> usize {
        Model::<f64>::nq(&self.model)
    }
    /// Length of `v`.
    pub fn nv(&self) -> usize {
        Model::<f64>::nv(&self.model)
    }

    fn call(&self, function: usize, state: [&[f64]; 3]) -> Vec<f64> {
        let signature = Model::<f64>::signature(&self.model, function);
        let mut out = vec![0.0; signature.map_or(0, |s| s.rows * s.columns)];
        let [q, v, a] = state;
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
        // Lengths are the model's own; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, &state, &mut out).is_err() {
            out.fill(f64::NAN);
        }
        out
    }

    /// Position (m) and rotation of a foot's link.
    pub fn link(&self, foot: usize, q: &[f64]) -> (Vector3<f64>, Matrix3<f64>) {
        let (zero, functions) = (vec![0.0; self.nv()], self.feet[foot]);
        let of = |function: usize| self.call(function, [q, &zero, &zero]);
        (Vector3::from_column_slice(&of(functions[0])), Matrix3::from_column_slice(&of(functions[1])))
    }

    /// Everything at a posture. `heading`: the torso's axes forward, left, up in those of its link.
    pub fn posture(&self, q: &[f64], soles: &[SoleFrame; 2], heading: &Matrix3<f64>) -> Posture {
        let nv = self.nv();
        let zero = vec![0.0; nv];
        let of = |function: usize| self.call(function, [q, &zero, &zero]);
        let mut jacobian = DMatrix::zeros(ROWS, nv);
        let mut places = [Vector3::zeros(); 2];
        let mut turns = [Matrix3::zeros(); 2];
        for (k, sole) in soles.iter().enumerate() {
            let (origin, link) = self.link(k, q);
            let arm = link * sole.center;
            places[k] = origin + arm;
            turns[k] = link * sole.axes;
            let of_link = DMatrix::from_column_slice(6, nv, &of(self.feet[k][2]));
            let angular = of_link.rows(3, 3);
            let linear = of_link.rows(0, 3) - arm.cross_matrix() * angular;
            jacobian.view_mut((6 * k, 0), (3, nv)).copy_from(&linear);
            jacobian.view_mut((6 * k + 3, 0), (3, nv)).copy_from(&angular);
        }
        let center = Vector3::from_column_slice(&of(self.center));
        let of_center = DMatrix::from_column_slice(3, nv, &of(self.center_jacobian));
        jacobian.view_mut((12, 0), (3, nv)).copy_from(&of_center);
        let root = root_rotation(q);
        jacobian.view_mut((15, 3), (3, 3)).copy_from(&root);
        Posture { places, turns, center, torso: root * heading, jacobian }
    }

    /// `J̇ v` of all tasks.
    pub fn drift(&self, q: &[f64], v: &[f64], soles: &[SoleFrame; 2]) -> DVector<f64> {
        let zero = vec![0.0; self.nv()];
        let mut found = DVector::zeros(ROWS);
        for (k, sole) in soles.iter().enumerate() {
            let (_, link) = self.link(k, q);
            let arm = link * sole.center;
            let jacobian = self.call(self.feet[k][2], [q, &zero, &zero]);
            let omega: Vector3<f64> = (0..v.len())
                .map(|c| Vector3::from_column_slice(&jacobian[6 * c + 3..6 * c + 6]) * v[c])
                .sum();
            let rate = self.call(self.feet[k][3], [q, v, &zero]);
            let (linear, angular) =
                (Vector3::from_column_slice(&rate[..3]), Vector3::from_column_slice(&rate[3..]));
            let of_sole = linear + angular.cross(&arm) + omega.cross(&omega.cross(&arm));
            found.fixed_rows_mut::<3>(6 * k).copy_from(&of_sole);
            found.fixed_rows_mut::<3>(6 * k + 3).copy_from(&angular);
        }
        let center = self.call(self.center_acceleration, [q, v, &zero]);
        found.fixed_rows_mut::<3>(12).copy_from_slice(&center);
        // The angular velocity of the root in its own axes: R ω has the rate R ω̇.
        found
    }

    /// Zero moment point of the whole robot on the ground z = 0, m (4.42).
    pub fn zero_moment_point(&self, state: [&[f64]; 3]) -> [f64; 2] {
        let found = self.call(self.zero_moment_point, state);
        [found[0], found[1]]
    }

    /// Generalised forces: on the base in its own axes, then on the joints.
    pub fn inverse_dynamics(&self, state: [&[f64]; 3]) -> Vec<f64> {
        self.call(self.inverse_dynamics, state)
    }
}

/// Axes of a floating root in the world, from `q`: quaternion x y z w behind the position.
pub fn root_rotation(q: &[f64]) -> Matrix3<f64> {
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
    turn.to_rotation_matrix().into_inner()
}
