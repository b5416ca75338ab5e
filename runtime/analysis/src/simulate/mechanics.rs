//! The functions of a model that a simulation calls, and how its coordinates move.
use super::carried::Carried;
use crate::robot::BaseKind;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::math::sin_cos;
use bipedc_runtime::model::{Argument, Model, State};

/// A model on its base, ready to be simulated.
#[derive(Clone, Copy)]
pub struct Mechanics<'a> {
    model: &'a dyn Model<f64>,
    base: BaseKind,
    mass: usize,
    bias: usize,
    contact: Option<ContactFunctions>,
    carried: Option<Carried>,
}

/// Indices of the functions of contact points.
#[derive(Debug, Clone, Copy)]
struct ContactFunctions {
    distances: usize,
    positions: usize,
    normal: usize,
    tangential: usize,
    points: usize,
    tangents: usize,
}

/// Functions that [`Mechanics`] looks up; a robot without contact points has only the first two.
pub const FUNCTIONS: [&str; 6] = [
    "mass_matrix_upper",
    "bias",
    "contact_distances",
    "contact_positions",
    "contact_normal_directions",
    "contact_tangential_directions",
];

impl<'a> Mechanics<'a> {
    /// Looks the functions up.
    ///
    /// # Errors
    /// One is missing, or the base does not fit to the model's coordinates.
    pub fn new(model: &'a dyn Model<f64>, base: BaseKind) -> Result<Self, Diagnostic> {
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add it to what is generated from the description")
            })
        };
        let velocities = if base == BaseKind::Floating { 6 } else { base.nq() };
        if model.nq() != base.nq() + model.joints() || model.nv() != velocities + model.joints() {
            return Err(Diagnostic::error(format!(
                "a model with {} coordinates and {} joints does not stand on a {base:?} base",
                model.nq(),
                model.joints()
            ))
            .help("simulate robots on a floating, planar or fixed base"));
        }
        let contact = match model.function("contact_distances") {
            None => None,
            Some(distances) => {
                let columns = |function: usize| model.signature(function).map_or(0, |s| s.columns);
                let (normal, tangential) =
                    (find("contact_normal_directions")?, find("contact_tangential_directions")?);
                let points = columns(normal);
                let tangents = columns(tangential).checked_div(points).unwrap_or(0);
                let positions = find("contact_positions")?;
                (points > 0).then_some(ContactFunctions {
                    distances,
                    positions,
                    normal,
                    tangential,
                    points,
                    tangents,
                })
            }
        };
        let mass = find("mass_matrix_upper").or_else(|_| find("mass_matrix"))?;
        Ok(Self { model, base, mass, bias: find("bias")?, contact, carried: None })
    }

    /// The same in the air: nothing touches the ground.
    #[must_use]
    pub fn without_contact(self) -> Self {
        Self { contact: None, ..self }
    }

    /// The model itself.
    pub fn model(&self) -> &'a dyn Model<f64> {
        self.model
    }

    /// How the robot hangs in the world.
    pub fn base(&self) -> BaseKind {
        self.base
    }
    /// Length of `q`.
    pub fn nq(&self) -> usize {
        self.model.nq()
    }
    /// Length of `v`.
    pub fn nv(&self) -> usize {
        self.model.nv()
    }
    /// Number of joints; they are the last coordinates of `q` and `v`.
    pub fn joints(&self) -> usize {
        self.model.joints()
    }
    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.contact.map_or(0, |contact| contact.points)
    }
    /// Tangential directions of each: x and y, or x alone in the plane.
    pub fn tangents(&self) -> usize {
        self.contact.map_or(0, |contact| contact.tangents)
    }

    /// Lower triangle of `D`, row after row; what stands above the diagonal is of no use.
    pub fn mass_matrix(&self, q: &[f64], out: &mut [f64]) {
        self.call(self.mass, &State::new().with(Argument::Q, q), out);
        if let Some(carried) = &self.carried {
            carried.add_to_mass(out, self.nv());
        }
    }
    /// `H = C v + G`.
    pub fn bias(&self, q: &[f64], v: &[f64], out: &mut [f64]) {
        self.call(self.bias, &State::new().with(Argument::Q, q).with(Argument::V, v), out);
        if let Some(carried) = &self.carried {
            // What holds the whole robot at rest is its mass times what holds any body.
            let (mut weight, still) = (vec![0.0; out.len()], vec![0.0; out.len()]);
            self.call(self.bias, &State::new().with(Argument::Q, q).with(Argument::V, &still), &mut weight);
            let mut mass = vec![0.0; out.len() * out.len()];
            self.call(self.mass, &State::new().with(Argument::Q, q), &mut mass);
            carried.add_to_bias(out, v, [weight[0], weight[1], weight[2]].map(|f| f / mass[0]));
        }
    }
    /// The root link carries this from now on.
    pub fn carry(&mut self, carried: Carried) {
        self.carried = Some(carried);
    }
    /// Heights of the contact points, m.
    pub fn distances(&self, q: &[f64], out: &mut [f64]) {
        if let Some(contact) = self.contact {
            self.call(contact.distances, &State::new().with(Argument::Q, q), out);
        }
    }
    /// Horizontal positions of the contact points, m.
    pub fn positions(&self, q: &[f64], out: &mut [f64]) {
        if let Some(contact) = self.contact {
            self.call(contact.positions, &State::new().with(Argument::Q, q), out);
        }
    }
    /// `W_N` and `W_T`, column after column.
    pub fn directions(&self, q: &[f64], normal: &mut [f64], tangential: &mut [f64]) {
        if let Some(contact) = self.contact {
            let state = State::new().with(Argument::Q, q);
            self.call(contact.normal, &state, normal);
            self.call(contact.tangential, &state, tangential);
        }
    }
    /// A function of configuration and velocity by its name; `None`: the model does not have it.
    pub fn named(&self, name: &str, q: &[f64], v: &[f64]) -> Option<Vec<f64>> {
        let function = self.model.function(name)?;
        let signature = self.model.signature(function)?;
        let mut out = vec![0.0; signature.rows * signature.columns];
        self.call(function, &State::new().with(Argument::Q, q).with(Argument::V, v), &mut out);
        Some(out)
    }

    fn call(&self, function: usize, state: &State<'_, f64>, out: &mut [f64]) {
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, state, out).is_err() {
            out.fill(f64::NAN);
        }
    }

    /// Moves `q` with the velocity `v` for `time` seconds.
    ///
    /// The orientation turns by the exponential of the angular velocity. The linear velocity of a floating base is in
    /// the base's own axes: those of the start or of the end of the motion, so that a half step of either kind is
    /// together one of second order.
    pub fn advance(&self, q: &mut [f64], v: &[f64], time: f64, frame: Frame) {
        advance(self.base, self.joints(), (q, v), time, frame);
    }
}

/// See [`Mechanics::advance`]; joints are the last coordinates.
pub(super) fn advance(base: BaseKind, joints: usize, (q, v): (&mut [f64], &[f64]), time: f64, frame: Frame) {
    let (nq, nv) = (q.len(), v.len());
    for (q, v) in q[nq - joints..].iter_mut().zip(&v[nv - joints..]) {
        *q += time * v;
    }
    match base {
        BaseKind::Fixed => {}
        BaseKind::Planar | BaseKind::Pivot => (0..base.nq()).for_each(|i| q[i] += time * v[i]),
        BaseKind::Floating => {
            let start = [q[3], q[4], q[5], q[6]];
            let end = turned(start, [time * v[3], time * v[4], time * v[5]]);
            let axes = if frame == Frame::Start { start } else { end };
            let velocity = rotate(axes, [v[0], v[1], v[2]]);
            (0..3).for_each(|i| q[i] += time * velocity[i]);
            q[3..7].copy_from_slice(&end);
        }
    }
}

/// Whose axes a linear velocity is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// Those at the start of the motion.
    Start,
    /// Those at its end.
    End,
}

/// The orientation (quaternion x y z w) after a rotation vector in its own axes; of unit length.
fn turned(q: [f64; 4], vector: [f64; 3]) -> [f64; 4] {
    let square: f64 = vector.iter().map(|x| x * x).sum();
    // sin(angle/2)/angle and cos(angle/2); the series' next term is below rounding.
    let (scale, cosine) = if square < 1e-8 {
        (0.5 - square / 48.0, 1.0 - square / 8.0)
    } else {
        let angle = square.sqrt();
        let (sine, cosine) = sin_cos(0.5 * angle);
        (sine / angle, cosine)
    };
    let [x, y, z, w] = q;
    let [a, b, c] = vector.map(|x| scale * x);
    let d = cosine;
    let product = [
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    ];
    let length = product.iter().map(|x| x * x).sum::<f64>().sqrt();
    product.map(|x| x / length)
}

/// A vector from the axes of an orientation into the world's.
pub(super) fn rotate(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = q;
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let axis = [x, y, z];
    let once = cross(axis, v).map(|x| 2.0 * x);
    let twice = cross(axis, once);
    std::array::from_fn(|i| v[i] + w * once[i] + twice[i])
}
