//! Bodies so simple that their equations are written by hand.
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::{Ground, JointLaw, Mechanics, MotionState, Stepper, Tolerance};
use bipedc_runtime::{Argument, Arguments, CallError, Model, Signature, State};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

const NAMES: [&str; 6] = [
    "mass_matrix_upper",
    "bias",
    "contact_distances",
    "contact_positions",
    "contact_normal_directions",
    "contact_tangential_directions",
];

/// A rigid body whose centre of mass is its origin; in the plane or in space.
#[derive(Debug, Clone)]
pub struct Body {
    pub planar: bool,
    /// kg
    pub mass: f64,
    /// Principal moments, kg m².
    pub inertia: [f64; 3],
    /// World axes, m/s²: turned gravity stands for a slope.
    pub gravity: [f64; 3],
    /// Body axes, m.
    pub points: Vec<[f64; 3]>,
}

/// Corners of a box of this size.
pub fn corners(size: [f64; 3], planar: bool) -> Vec<[f64; 3]> {
    let signs = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let all = signs.iter().map(|s| [0.5 * s[0] * size[0], 0.5 * s[1] * size[1], -0.5 * size[2]]);
    if planar {
        all.take(2).map(|p| [p[0], 0.0, p[2]]).collect()
    } else {
        let top = all.clone().map(|p| [p[0], p[1], -p[2]]);
        all.chain(top).collect()
    }
}

impl Body {
    /// A homogeneous box of 2 kg on a slope.
    pub fn brick(planar: bool, slope: f64) -> Self {
        let size = [0.3, 0.2, 0.1];
        let mass = 2.0;
        let moment = |i: usize, j: usize| mass / 12.0 * (f64::powi(size[i], 2) + f64::powi(size[j], 2));
        Self {
            planar,
            mass,
            inertia: [moment(1, 2), moment(0, 2), moment(0, 1)],
            gravity: [9.81 * slope.sin(), 0.0, -9.81 * slope.cos()],
            points: corners(size, planar),
        }
    }

    /// A ball: a point mass that touches at its centre.
    pub fn ball() -> Self {
        Self {
            planar: true,
            mass: 0.4,
            inertia: [1e-3; 3],
            gravity: [0.0, 0.0, -9.81],
            points: vec![[0.0; 3]],
        }
    }

    pub fn base(&self) -> BaseKind {
        if self.planar { BaseKind::Planar } else { BaseKind::Floating }
    }

    /// A stepper with these laws; impossible ones fail the test.
    pub fn stepper(&self, ground: Ground) -> Stepper<'_> {
        let mechanics = Mechanics::new(self, self.base()).unwrap();
        Stepper::new(mechanics, ground, Vec::<JointLaw>::new(), Tolerance::default()).unwrap()
    }

    /// At this height, level, at rest.
    pub fn at(&self, height: f64) -> MotionState {
        let mut q = vec![0.0; self.nq()];
        q[if self.planar { 1 } else { 2 }] = height;
        if !self.planar {
            q[6] = 1.0;
        }
        MotionState { time: 0.0, q, v: vec![0.0; self.nv()] }
    }

    /// Kinetic and potential energy, J.
    pub fn energy(&self, motion: &MotionState) -> [f64; 2] {
        let v = &motion.v;
        let turning = if self.planar {
            self.inertia[1] * v[2] * v[2]
        } else {
            (0..3).map(|i| self.inertia[i] * v[3 + i] * v[3 + i]).sum()
        };
        let linear: f64 = v[..if self.planar { 2 } else { 3 }].iter().map(|v| self.mass * v * v).sum();
        let at = self.position(&motion.q);
        [0.5 * (linear + turning), -self.mass * Vector3::from(self.gravity).dot(&at)]
    }

    pub fn position(&self, q: &[f64]) -> Vector3<f64> {
        if self.planar { Vector3::new(q[0], 0.0, q[1]) } else { Vector3::new(q[0], q[1], q[2]) }
    }

    pub fn rotation(&self, q: &[f64]) -> Matrix3<f64> {
        let turn = if self.planar {
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), q[2])
        } else {
            UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]))
        };
        turn.to_rotation_matrix().into_inner()
    }

    /// Velocity of a point along a world axis per unit of each generalised velocity.
    fn row(&self, q: &[f64], point: [f64; 3], axis: Vector3<f64>) -> Vec<f64> {
        let (turn, point) = (self.rotation(q), Vector3::from(point));
        if self.planar {
            let arm = turn * point;
            return vec![axis.x, axis.z, Vector3::y().cross(&arm).dot(&axis)];
        }
        let axis = turn.transpose() * axis;
        axis.iter().chain(point.cross(&axis).iter()).copied().collect()
    }

    fn tangents(&self) -> &'static [fn() -> Vector3<f64>] {
        if self.planar { &[Vector3::x] } else { &[Vector3::x, Vector3::y] }
    }

    fn value(&self, function: usize, q: &[f64], v: &[f64]) -> Vec<f64> {
        let turn = self.rotation(q);
        let nv = self.nv();
        let places = || self.points.iter().map(|p| self.position(q) + turn * Vector3::from(*p));
        match function {
            0 => {
                let mut mass = vec![0.0; nv * nv];
                for i in 0..nv {
                    mass[i * nv + i] = match (self.planar, i) {
                        (true, 2) => self.inertia[1],
                        (false, 3..) => self.inertia[i - 3],
                        _ => self.mass,
                    };
                }
                mass
            }
            1 if self.planar => vec![-self.mass * self.gravity[0], -self.mass * self.gravity[2], 0.0],
            1 => {
                let (linear, omega) = (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5]));
                let weight = turn.transpose() * Vector3::from(self.gravity);
                let force = self.mass * (omega.cross(&linear) - weight);
                let spin = Vector3::from(self.inertia).component_mul(&omega);
                force.iter().chain(omega.cross(&spin).iter()).copied().collect()
            }
            2 => places().map(|p| p.z).collect(),
            3 => places().flat_map(|p| self.tangents().iter().map(move |t| t().dot(&p))).collect(),
            4 => self.points.iter().flat_map(|p| self.row(q, *p, Vector3::z())).collect(),
            _ => {
                let tangents = |p: &[f64; 3]| {
                    let p = *p;
                    self.tangents().iter().flat_map(move |t| self.row(q, p, t())).collect::<Vec<_>>()
                };
                self.points.iter().flat_map(tangents).collect()
            }
        }
    }
}

impl Model<f64> for Body {
    fn nq(&self) -> usize {
        if self.planar { 3 } else { 7 }
    }
    fn nv(&self) -> usize {
        if self.planar { 3 } else { 6 }
    }
    fn joint_name(&self, _: usize) -> Option<&str> {
        None
    }
    fn joints(&self) -> usize {
        0
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        let (nv, points, tangents) = (self.nv(), self.points.len(), self.tangents().len());
        let (rows, columns) = match index {
            0 => (nv, nv),
            1 => (nv, 1),
            2 => (points, 1),
            3 => (points * tangents, 1),
            4 => (nv, points),
            5 => (nv, points * tangents),
            _ => return None,
        };
        let arguments = Arguments::of(&[Argument::Q, Argument::V]);
        Some(Signature { name: NAMES[index], arguments, rows, columns })
    }
    fn argument_length(&self, argument: Argument) -> usize {
        if argument == Argument::Q { self.nq() } else { self.nv() }
    }
    fn evaluate(&self, function: usize, state: &State<'_, f64>, output: &mut [f64]) -> Result<(), CallError> {
        output.copy_from_slice(&self.value(function, state.get(Argument::Q), state.get(Argument::V)));
        Ok(())
    }
}

/// A point mass on a rod, on a fixed base; the angle hangs down at 0.
#[derive(Debug, Clone, Copy)]
pub struct Pendulum {
    /// kg m²
    pub inertia: f64,
    /// Largest torque of gravity, N m.
    pub weight: f64,
}

impl Pendulum {
    /// A stepper with this law in the joint.
    pub fn stepper(&self, law: JointLaw) -> Stepper<'_> {
        let mechanics = Mechanics::new(self, BaseKind::Fixed).unwrap();
        Stepper::new(mechanics, Ground::default(), vec![law], Tolerance::default()).unwrap()
    }
}

impl Model<f64> for Pendulum {
    fn nq(&self) -> usize {
        1
    }
    fn nv(&self) -> usize {
        1
    }
    fn joint_name(&self, index: usize) -> Option<&str> {
        (index == 0).then_some("pivot")
    }
    fn joints(&self) -> usize {
        1
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        let name = *NAMES[..2].get(index)?;
        Some(Signature { name, arguments: Arguments::of(&[Argument::Q]), rows: 1, columns: 1 })
    }
    fn argument_length(&self, _: Argument) -> usize {
        1
    }
    fn evaluate(&self, function: usize, state: &State<'_, f64>, output: &mut [f64]) -> Result<(), CallError> {
        output[0] = if function == 0 { self.inertia } else { self.weight * state.get(Argument::Q)[0].sin() };
        Ok(())
    }
}
