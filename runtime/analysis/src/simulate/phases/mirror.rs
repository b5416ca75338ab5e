//! The exchange of left and right: between the robot as its phases name it and the robot as it is.
use crate::robot::BaseKind;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{JointCommand, Servo};
use bipedc_runtime::model::{Argument, Model, State};

/// Distance below which a mirrored contact point is the other foot's, m.
const SAME: f64 = 1e-6;

/// The robot seen in a mirror at its x-z plane. Applied twice it changes nothing.
pub(crate) struct Mirror<'a> {
    model: &'a dyn Model<f64>,
    configuration: usize,
    velocity: usize,
    /// By contact point: the one in its place.
    points: Vec<usize>,
    /// By joint: the one in its place, and the sign of its motion there.
    joints: Vec<(usize, f64)>,
    sideways: bool,
}

impl<'a> Mirror<'a> {
    /// Looks the functions up and pairs the contact points.
    ///
    /// # Errors
    /// The model lacks a function; the feet do not mirror each other.
    pub fn new(model: &'a dyn Model<f64>, base: BaseKind) -> Result<Self, Diagnostic> {
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("add [symmetry] to biped.toml: the phases exchange left and right")
            })
        };
        let mut mirror = Self {
            model,
            configuration: find("relabelled_configuration")?,
            velocity: find("relabelled_velocity")?,
            points: Vec::new(),
            joints: Vec::new(),
            sideways: base == BaseKind::Floating,
        };
        let functions = [find("contact_positions")?, find("contact_distances")?];
        mirror.points = mirror.pairs(functions, base)?;
        mirror.joints = (0..model.joints()).map(|joint| mirror.partner(joint)).collect();
        Ok(mirror)
    }

    /// Where a joint's motion is seen in the mirror: there is one place for each, with a sign.
    fn partner(&self, joint: usize) -> (usize, f64) {
        let (nv, joints) = (self.model.nv(), self.model.joints());
        let (mut moving, mut seen) = (vec![0.0; nv], vec![0.0; nv]);
        moving[nv - joints + joint] = 1.0;
        self.velocity(&moving, &mut seen);
        let found = seen[nv - joints..].iter().enumerate().find(|(_, rate)| **rate != 0.0);
        found.map_or((joint, 1.0), |(other, &sign)| (other, sign))
    }

    /// In a posture without symmetry every point has its partner at the mirrored place.
    fn pairs(&self, functions: [usize; 2], base: BaseKind) -> Result<Vec<usize>, Diagnostic> {
        let joints = self.model.joints();
        let mut q = vec![0.0; self.model.nq() - joints];
        if base == BaseKind::Floating {
            q[..7].copy_from_slice(&[0.3, 0.2, 0.9, 0.0, 0.0, 0.0, 1.0]);
        }
        q.extend((0..joints).map(|j| 0.3 + 0.2 * (1.3 * j as f64 + 0.4).sin()));
        let mut other = vec![0.0; q.len()];
        self.call(self.configuration, &State::new().with(Argument::Q, &q), &mut other);
        let places = |q: &[f64]| -> Vec<[f64; 3]> {
            let [mut flat, mut heights] = functions.map(|function| {
                let size = self.model.signature(function).map_or(0, |s| s.rows * s.columns);
                vec![0.0; size]
            });
            let state = State::new().with(Argument::Q, q);
            self.call(functions[0], &state, &mut flat);
            self.call(functions[1], &state, &mut heights);
            let across = flat.len() / heights.len().max(1);
            let place = |(i, &z): (usize, &f64)| {
                [flat[i * across], if across == 2 { flat[2 * i + 1] } else { 0.0 }, z]
            };
            heights.iter().enumerate().map(place).collect()
        };
        let (here, there) = (places(&q), places(&other));
        let partner = |p: &[f64; 3]| {
            let distance = |o: &[f64; 3]| (p[0] - o[0]).hypot(p[1] + o[1]).hypot(p[2] - o[2]);
            there.iter().position(|o| distance(o) < SAME)
        };
        let found: Option<Vec<usize>> = here.iter().map(partner).collect();
        found.ok_or_else(|| {
            Diagnostic::error("left and right foot do not mirror each other, but the phases exchange them")
                .help("give both feet mirrored contact points and legs in the URDF")
        })
    }

    fn call(&self, function: usize, state: &State<'_, f64>, out: &mut [f64]) {
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, state, out).is_err() {
            out.fill(f64::NAN);
        }
    }

    /// The other side's `q` and `v`.
    pub fn state(&self, q: &[f64], v: &[f64], to: (&mut [f64], &mut [f64])) {
        self.call(self.configuration, &State::new().with(Argument::Q, q), to.0);
        self.velocity(v, to.1);
    }

    /// The other side's velocity; generalised forces change in the same way, because signs and exchanges alone are in it.
    pub fn velocity(&self, v: &[f64], to: &mut [f64]) {
        self.call(self.velocity, &State::new().with(Argument::V, v), to);
    }

    /// The joint in the place of this one, and the same command seen in the mirror.
    pub fn command(&self, joint: usize, command: &JointCommand<f64>) -> (usize, JointCommand<f64>) {
        let (other, sign) = self.joints[joint];
        let seen = match *command {
            JointCommand::Off => JointCommand::Off,
            JointCommand::Torque(torque) => JointCommand::Torque(sign * torque),
            JointCommand::Servo(servo) => JointCommand::Servo(Servo {
                position: sign * servo.position,
                velocity: sign * servo.velocity,
                torque: sign * servo.torque,
                ..servo
            }),
        };
        (other, seen)
    }

    /// The contact point in the place of this one.
    pub fn point(&self, point: usize) -> usize {
        self.points[point]
    }

    /// By contact point: the one in its place.
    pub fn points(&self) -> &[usize] {
        &self.points
    }

    /// A force seen in the mirror.
    pub fn force(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [x, if self.sideways { -y } else { y }, z]
    }
}
