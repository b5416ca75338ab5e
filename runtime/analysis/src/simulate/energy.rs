//! Where the energy of a run went.
use super::mechanics::Mechanics;
use super::stepper::{MotionState, Stepper};
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;

/// Energy of a run, J. Change of kinetic, potential and rotors' energy and of the ground's springs = `drives` + `laws` −
/// all losses + `remainder`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct EnergyBalance {
    /// Of the links, at the start and at the end.
    pub kinetic: [f64; 2],
    /// Of the links.
    pub potential: [f64; 2],
    /// Kinetic, of rotors (`rotor_inertia`).
    pub rotors: [f64; 2],
    /// In the springs of soft ground.
    pub ground_springs: [f64; 2],
    /// Work that the drives did.
    pub drives: f64,
    /// Work of smooth laws in joints: springs, ripple, coupling, formulas.
    pub laws: f64,
    /// Lost in viscous friction of joints.
    pub viscous_friction: f64,
    /// Lost in dry friction of joints.
    pub dry_friction: f64,
    /// Lost in stops of joints.
    pub stops: f64,
    /// Lost in impacts of feet; negative: restitution or `recovery` made energy.
    pub impacts: f64,
    /// Lost in sliding of feet.
    pub sliding: f64,
    /// Lost in the dampers of soft ground.
    pub ground_dampers: f64,
    /// Sum of all losses.
    pub lost: f64,
    /// What the sums above do not explain: the error of the time stepping.
    pub remainder: f64,
}

impl EnergyBalance {
    /// Of all stored energies, J.
    pub fn change(&self) -> f64 {
        [self.kinetic, self.potential, self.rotors, self.ground_springs].iter().map(|e| e[1] - e[0]).sum()
    }
}

/// Keeps the accounting of a run.
#[derive(Debug, Clone, Default)]
pub(super) struct EnergyFlow {
    balance: EnergyBalance,
    /// Torques that the drives give in the next step, by joint.
    pub torque: Vec<f64>,
    /// Velocities of the joints before the step.
    before: Vec<f64>,
}

impl EnergyFlow {
    /// Begins at this state.
    ///
    /// # Errors
    /// The model has no energies.
    pub fn new(stepper: &Stepper<'_>, motion: &MotionState) -> Result<Self, Diagnostic> {
        let mut energy_flow = Self { torque: vec![0.0; stepper.mechanics().joints()], ..Self::default() };
        energy_flow.weigh(stepper, motion, 0)?;
        Ok(energy_flow)
    }

    /// Before a step.
    pub fn begin(&mut self, motion: &MotionState) {
        self.before.clear();
        self.before.extend_from_slice(&motion.v[motion.v.len() - self.torque.len()..]);
    }

    /// After it.
    pub fn end(&mut self, motion: &MotionState, time: f64) {
        let after = &motion.v[motion.v.len() - self.torque.len()..];
        for ((torque, before), after) in self.torque.iter().zip(&self.before).zip(after) {
            self.balance.drives += 0.5 * time * torque * (before + after);
        }
    }

    /// The balance at the end of the run.
    ///
    /// # Errors
    /// The model has no energies.
    pub fn close(mut self, stepper: &Stepper<'_>, motion: &MotionState) -> Result<EnergyBalance, Diagnostic> {
        self.weigh(stepper, motion, 1)?;
        let mut b = self.balance;
        let account = stepper.account().copied().unwrap_or_default();
        b.ground_springs[1] = account.ground_springs;
        b.laws = account.applied - b.drives;
        b.drives += account.servos;
        b.viscous_friction = account.viscous_friction;
        b.dry_friction = account.dry_friction;
        b.stops = account.stops;
        b.impacts = account.impacts;
        b.sliding = account.sliding;
        b.ground_dampers = account.soft_ground - account.ground_springs;
        b.lost = b.viscous_friction + b.dry_friction + b.stops + b.impacts + b.sliding + b.ground_dampers;
        b.remainder = b.change() - account.applied - account.servos + b.lost;
        Ok(b)
    }

    /// Energies at the start (0) or at the end (1).
    fn weigh(&mut self, stepper: &Stepper<'_>, motion: &MotionState, when: usize) -> Result<(), Diagnostic> {
        let mechanics = stepper.mechanics();
        self.balance.kinetic[when] = energy(mechanics, "kinetic_energy", motion)?;
        self.balance.potential[when] = energy(mechanics, "potential_energy", motion)?;
        let joints = motion.v[motion.v.len() - stepper.joints().len()..].iter().zip(stepper.joints());
        self.balance.rotors[when] = joints.map(|(v, law)| 0.5 * law.rotor_inertia * v * v).sum();
        Ok(())
    }
}

fn energy(mechanics: &Mechanics<'_>, name: &str, motion: &MotionState) -> Result<f64, Diagnostic> {
    let found = mechanics.named(name, &motion.q, &motion.v);
    found.and_then(|values| values.first().copied()).ok_or_else(|| {
        Diagnostic::error(format!("the model has no function `{name}`"))
            .help("an energy balance needs a model with `kinetic_energy` and `potential_energy`")
    })
}
