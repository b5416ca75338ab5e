//! Where the bodies of a robot are that stands on one foot, and how that changes with its joints.
use crate::robot::AnyModel;
use crate::robot::InertialParameters;
use crate::robot::inertial_parameters::mass;
use crate::robot::inertial_parameters::{body_of, element_of, of_body, parameter_index};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, State};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3, Vector6};

/// A frame fixed in a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index among the bodies with inertial parameters.
    pub body: usize,
    /// Its axes in the frame in which the body's parameters are stated.
    pub rotation: Matrix3<f64>,
    /// Its origin there, m.
    pub translation: Vector3<f64>,
}

/// A joint between two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointPlace {
    /// Frame of the joint in its child body.
    pub child: Place,
    /// The body on its other side.
    pub parent: usize,
    /// Unit axis in the joint's frame.
    pub axis: Vector3<f64>,
    /// Slides instead of turning.
    pub prismatic: bool,
    /// Smallest and largest position, rad or m.
    pub limits: (f64, f64),
}

/// A flat sole.
#[derive(Debug, Clone, PartialEq)]
pub struct SolePlace {
    /// Sole frame: below the link's origin, in the plane of the corners.
    pub place: Place,
    /// Corners in the sole frame, m.
    pub corners: Vec<[f64; 2]>,
}

/// What makes a robot that stands.
pub struct StandingParts<'a> {
    /// A model whose root link is the standing foot, with `center_of_mass_regressor`.
    pub model: AnyModel<'a>,
    /// Inertial parameters as described, ten per body.
    pub parameters: InertialParameters,
    /// In the order of the model's joints.
    pub joints: Vec<JointPlace>,
    /// The foot that stands where it is, and the other one.
    pub soles: [SolePlace; 2],
    /// Frame of the torso.
    pub torso: Place,
    /// Columns of the regression: indices among the inertial parameters, masses and first moments only.
    pub columns: Vec<usize>,
    /// Names of the joints.
    pub names: Vec<String>,
}

/// A robot on its standing foot. World axes are those of the standing sole, the origin is that of the sole.
pub struct StanceModel<'a> {
    /// What it was made of.
    pub parts: StandingParts<'a>,
    function: usize,
    /// By joint, by body: whether the joint moves it.
    moved: Vec<Vec<bool>>,
    /// By joint: 1 if it moves its child, -1 if it moves its parent.
    sign: Vec<f64>,
    /// Rest configuration of the base.
    base: Vec<f64>,
}

/// Bodies at a configuration.
#[derive(Debug, Clone)]
pub struct Bodies {
    rotation: Vec<Matrix3<f64>>,
    position: Vec<Vector3<f64>>,
    /// By joint: axis (signed) and a point on it.
    axes: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl<'a> StanceModel<'a> {
    /// Looks up what moves what.
    ///
    /// # Errors
    /// A model without the function, or of another robot; joints that make no tree.
    pub fn new(parts: StandingParts<'a>) -> Result<Self, Diagnostic> {
        let name = "center_of_mass_regressor";
        let function = parts
            .model
            .function(name)
            .ok_or_else(|| Diagnostic::error(format!("the model has no function `{name}`")))?;
        let columns = parts.model.signature(function).map_or(0, |s| s.columns);
        if columns != parts.parameters.len() || parts.joints.len() != parts.names.len() {
            return Err(Diagnostic::error(format!("the model's `{name}` is of another robot")));
        }
        let bodies = parts.parameters.bodies().len();
        let root = parts.soles[0].place.body;
        let mut moved = Vec::new();
        let mut sign = Vec::new();
        for skipped in 0..parts.joints.len() {
            let held = reached(root, bodies, &parts.joints, skipped);
            sign.push(if held[parts.joints[skipped].child.body] { -1.0 } else { 1.0 });
            moved.push(held.iter().map(|held| !held).collect());
        }
        let mut base = vec![0.0; parts.model.nq() - parts.joints.len()];
        if let Some(w) = base.get_mut(6) {
            *w = 1.0;
        }
        Ok(Self { parts, function, moved, sign, base })
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.parts.joints.len()
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.parts.parameters.mass()
    }

    /// Where everything is.
    pub fn bodies(&self, q: &[f64]) -> Bodies {
        let configuration: Vec<f64> = self.base.iter().chain(q).copied().collect();
        let mut out = vec![0.0; 3 * self.parts.parameters.len()];
        let state = State::new().with(Argument::Q, &configuration);
        // Lengths come from the model itself; a refusal would show in the numbers.
        if self.parts.model.evaluate(self.function, &state, &mut out).is_err() {
            out.fill(f64::NAN);
        }
        let column = |k: usize| Vector3::from_column_slice(&out[3 * k..3 * k + 3]);
        let count = self.parts.parameters.bodies().len();
        let rotation: Vec<Matrix3<f64>> = (0..count)
            .map(|b| Matrix3::from_columns(&[1, 2, 3].map(|i| column(parameter_index(b, i)))))
            .collect();
        let position: Vec<Vector3<f64>> = (0..count).map(|b| column(parameter_index(b, 0))).collect();
        let mut bodies = Bodies { rotation, position, axes: Vec::new() };
        // From the frame of the foot's link to that of its sole.
        let (origin, turn) = bodies.frame(&self.parts.soles[0].place);
        let back = turn.transpose();
        bodies.position.iter_mut().for_each(|p| *p = back * (*p - origin));
        bodies.rotation.iter_mut().for_each(|r| *r = back * *r);
        bodies.axes = self
            .parts
            .joints
            .iter()
            .zip(&self.sign)
            .map(|(joint, sign)| {
                let (at, turn) = bodies.frame(&joint.child);
                (turn * joint.axis * *sign, at)
            })
            .collect();
        bodies
    }

    /// What a parameter of one body adds to `Σ m c` per unit: position of its frame, or an axis of it.
    pub fn column(&self, bodies: &Bodies, k: usize) -> Vector3<f64> {
        let (body, of) = (body_of(k), element_of(k));
        match of {
            0 => bodies.position[body],
            1..=3 => bodies.rotation[body].column(of - 1).into_owned(),
            _ => Vector3::zeros(),
        }
    }

    /// Its derivative by a joint.
    pub fn column_rate(&self, bodies: &Bodies, k: usize, joint: usize) -> Vector3<f64> {
        if !self.moved[joint][body_of(k)] || element_of(k) > 3 {
            return Vector3::zeros();
        }
        let (axis, at) = bodies.axes[joint];
        let is_mass = k.is_multiple_of(10);
        match (self.parts.joints[joint].prismatic, is_mass) {
            (true, true) => axis,
            (true, false) => Vector3::zeros(),
            (false, true) => axis.cross(&(bodies.position[body_of(k)] - at)),
            (false, false) => axis.cross(&self.column(bodies, k)),
        }
    }

    /// Centre of mass for these inertial parameters, m, and its derivatives by the joints.
    pub fn center(&self, bodies: &Bodies, parameters: &[f64]) -> (Vector3<f64>, Vec<Vector3<f64>>) {
        let mass = mass(parameters);
        let first = |b: usize| {
            let p = &parameters[of_body(b)];
            bodies.position[b] * p[0] + bodies.rotation[b] * Vector3::new(p[1], p[2], p[3])
        };
        let firsts: Vec<Vector3<f64>> = (0..bodies.position.len()).map(first).collect();
        let rate = |joint: usize| {
            let (axis, at) = bodies.axes[joint];
            let moved = self.moved[joint].iter().enumerate().filter(|(_, moved)| **moved);
            let (sum, own) = moved.fold((Vector3::zeros(), 0.0), |(sum, own), (b, _)| {
                (sum + firsts[b], own + parameters[parameter_index(b, 0)])
            });
            let turned =
                if self.parts.joints[joint].prismatic { axis * own } else { axis.cross(&(sum - at * own)) };
            turned / mass
        };
        (firsts.iter().sum::<Vector3<f64>>() / mass, (0..self.joints()).map(rate).collect())
    }

    /// Twist of a frame by the joints' rates, 6 × joints: velocity of its origin, then angular velocity.
    pub fn jacobian(&self, bodies: &Bodies, place: &Place) -> DMatrix<f64> {
        let (origin, _) = bodies.frame(place);
        let mut out = DMatrix::zeros(6, self.joints());
        for (joint, (axis, at)) in bodies.axes.iter().enumerate() {
            if !self.moved[joint][place.body] {
                continue;
            }
            let sliding = self.parts.joints[joint].prismatic;
            let linear = if sliding { *axis } else { axis.cross(&(origin - at)) };
            let angular = if sliding { Vector3::zeros() } else { *axis };
            out.fixed_view_mut::<3, 1>(0, joint).copy_from(&linear);
            out.fixed_view_mut::<3, 1>(3, joint).copy_from(&angular);
        }
        out
    }

    /// By how much the other sole misses its placement (x, y in m, yaw in rad), flat on the ground: m and rad.
    pub fn missed(&self, bodies: &Bodies, placement: &[f64; 3]) -> Vector6<f64> {
        let (origin, turn) = bodies.frame(&self.parts.soles[1].place);
        let wanted = Rotation3::from_axis_angle(&Vector3::z_axis(), placement[2]);
        let away = origin - Vector3::new(placement[0], placement[1], 0.0);
        let angle = rotation_vector(&(turn * wanted.matrix().transpose()));
        Vector6::new(away.x, away.y, away.z, angle.x, angle.y, angle.z)
    }

    /// Corners of both soles on the ground, those of the standing one first.
    pub fn corners(&self, placement: &[f64; 3]) -> [Vec<[f64; 2]>; 2] {
        let (s, c) = placement[2].sin_cos();
        let placed = |p: &[f64; 2]| [placement[0] + c * p[0] - s * p[1], placement[1] + s * p[0] + c * p[1]];
        [self.parts.soles[0].corners.clone(), self.parts.soles[1].corners.iter().map(placed).collect()]
    }
}

impl Bodies {
    /// Origin and axes of a frame.
    pub fn frame(&self, place: &Place) -> (Vector3<f64>, Matrix3<f64>) {
        let turn = self.rotation[place.body];
        (self.position[place.body] + turn * place.translation, turn * place.rotation)
    }
}

/// Axis times angle of a rotation, precise for small angles too, where the cosine says nothing.
pub fn rotation_vector(r: &Matrix3<f64>) -> Vector3<f64> {
    let twice = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let (sine, cosine) = (0.5 * twice.norm(), 0.5 * (r.trace() - 1.0));
    if sine < 1e-9 && cosine > 0.0 {
        return 0.5 * twice;
    }
    // At half a turn there is no axis to tell; nothing here comes near.
    twice * (sine.atan2(cosine) / (2.0 * sine).max(f64::MIN_POSITIVE))
}

/// Bodies that hang together with the root when one joint is cut.
fn reached(root: usize, bodies: usize, joints: &[JointPlace], skipped: usize) -> Vec<bool> {
    let mut held = vec![false; bodies];
    if let Some(root) = held.get_mut(root) {
        *root = true;
    }
    for _ in 0..bodies {
        for (_, joint) in joints.iter().enumerate().filter(|(j, _)| *j != skipped) {
            let (a, b) = (joint.child.body, joint.parent);
            if held[a] || held[b] {
                (held[a], held[b]) = (true, true);
            }
        }
    }
    held
}
