//! Motors that turn on their own: a spring and play lie between them and the joint (thesis 4.6).
use super::dense::row_length;
use super::ground::within;
use super::implicit::{ImplicitSpring, Relaxed};
use bipedc_effects::diagnostic::Diagnostic;

/// A motor and what lies between it and its joint, all as seen at the joint: with N the motor's turns per turn of the
/// joint, its angle is θ_M / N, its inertia N² I_M, its friction N² F_v and N F_c (4.26), (4.27), the stiffness k r_L² (4.29).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorLaw {
    /// Index of the joint.
    pub joint: usize,
    /// kg m²
    pub inertia: f64,
    /// N m s/rad
    pub damping: f64,
    /// Dry friction against positive and against negative motion, N m.
    pub dry: [f64; 2],
    /// Of the spring, N m/rad; infinite: stiff.
    pub stiffness: f64,
    /// Beside the spring, N m s/rad.
    pub spring_damping: f64,
    /// Play from stop to stop, rad.
    pub gap: f64,
}

impl MotorLaw {
    /// Whether its numbers are possible.
    ///
    /// # Errors
    /// Names the first one that is not.
    pub fn check(&self) -> Result<(), Diagnostic> {
        within("rotor inertia", self.inertia, f64::MIN_POSITIVE, f64::MAX, "kg m²")?;
        within("damping", self.damping, 0.0, f64::MAX, "N m s/rad")?;
        within("dry friction", self.dry[0], 0.0, f64::MAX, "N m")?;
        within("dry friction", self.dry[1], 0.0, f64::MAX, "N m")?;
        within("damping", self.spring_damping, 0.0, f64::MAX, "N m s/rad")?;
        within("gap", self.gap, 0.0, f64::MAX, "rad")?;
        if self.stiffness == f64::INFINITY && self.gap > 0.0 {
            return Ok(());
        }
        within("stiffness", self.stiffness, f64::MIN_POSITIVE, f64::MAX, "N m/rad")
    }

    /// A spring that pulls and pushes: no play, so that it needs no rows.
    fn pulls(&self) -> bool {
        self.gap == 0.0
    }
}

/// All motors with their motion.
#[derive(Debug, Clone, Default)]
pub(super) struct Motors {
    pub laws: Vec<MotorLaw>,
    /// rad, at the joint
    pub angle: Vec<f64>,
    /// rad/s, at the joint
    pub rate: Vec<f64>,
    held: Vec<ImplicitSpring>,
    /// Torque on the joint in the last step, N m.
    pub torque: Vec<f64>,
}

impl Motors {
    pub fn new(laws: Vec<MotorLaw>) -> Self {
        let zeros = vec![0.0; laws.len()];
        Self {
            angle: zeros.clone(),
            rate: zeros.clone(),
            torque: zeros,
            held: vec![ImplicitSpring::default(); laws.len()],
            laws,
        }
    }

    pub fn advance(&mut self, time: f64) {
        for (angle, rate) in self.angle.iter_mut().zip(&self.rate) {
            *angle += time * rate;
        }
    }

    /// Adds rotors and springs to the mass matrix (`n` rows and columns) whose last rows are the motors'; joints begin at `first`.
    pub fn add_inertia(&mut self, mass: &mut [f64], n: usize, first: usize, time: f64) {
        let (nv, length) = (n - self.laws.len(), row_length(n));
        for (k, (law, held)) in self.laws.iter().zip(&mut self.held).enumerate() {
            let (i, j) = (nv + k, first + law.joint);
            let mobility = 1.0 / law.inertia + 1.0 / mass[j * length + j].max(f64::MIN_POSITIVE);
            *held = ImplicitSpring::new(law.stiffness, law.spring_damping, mobility, time);
            mass[i * length + i] += law.inertia + 0.5 * time * law.damping;
            if law.pulls() {
                let added = held.inertia();
                mass[i * length + i] += added;
                mass[j * length + j] += added;
                mass[i * length + j] -= added;
            }
        }
    }

    /// Adds the impulses of springs and viscous friction; `q`, `v` of the joints.
    pub fn add_impulses(&self, drive: &mut [f64], first: usize, q: &[f64], v: &[f64], time: f64) {
        let nv = drive.len() - self.laws.len();
        for (k, law) in self.laws.iter().enumerate() {
            drive[nv + k] -= time * law.damping * self.rate[k];
            if law.pulls() {
                let pull = self.held[k].impulse(self.angle[k] - q[law.joint], self.rate[k] - v[law.joint]);
                drive[nv + k] -= pull;
                drive[first + law.joint] += pull;
            }
        }
    }

    /// A stop of a motor's play as a relaxed row in the direction that opens it; `None`: there is no play. Without a spring
    /// it is `γ⁺ + way/h ≥ 0`: the way that is left at the middle of the step would last as long as a step. It is
    /// used up within two steps, without rebound, and never overrun.
    pub fn stop(&self, k: usize, upper: bool, q: &[f64], v: &[f64]) -> Option<Relaxed> {
        let law = &self.laws[k];
        if law.pulls() {
            return None;
        }
        let sign = if upper { -1.0 } else { 1.0 };
        let way = 0.5 * law.gap + sign * (self.angle[k] - q[law.joint]);
        let speed = sign * (self.rate[k] - v[law.joint]);
        self.held[k].relaxed(way, speed)
    }

    /// Takes the velocities after a step and notes the torques of springs; `stops` are the impulses at the play's ends.
    pub fn finish(&mut self, after: &[f64], q: &[f64], v: &[f64], first: usize, stops: &[f64], time: f64) {
        let nv = after.len() - self.laws.len();
        for (k, law) in self.laws.iter().enumerate() {
            let (before, now) = (self.rate[k] - v[law.joint], after[nv + k] - after[first + law.joint]);
            self.torque[k] = if law.pulls() {
                self.held[k].torque(self.angle[k] - q[law.joint], [before, now])
            } else {
                stops[k] / time
            };
            self.rate[k] = after[nv + k];
        }
    }
}

/// A matrix of the model's size into the upper left corner of a larger one with so long rows.
pub(super) fn embed(small: &[f64], size: usize, large: &mut [f64], length: usize) {
    large.fill(0.0);
    for (from, to) in small.chunks_exact(size).zip(large.chunks_exact_mut(length)) {
        to[..size].copy_from_slice(from);
    }
}
