//! A gait of several phases as its controller knows it.
use super::gait::GaitParameter;
use super::phase_surface::PhaseSurfaceLayout;
use crate::model::Model;

/// Most joints that a controller of several phases drives.
pub const MOST_JOINTS: usize = 32;
/// Most feet that stand at once.
pub const MOST_FEET: usize = 4;
/// Most limits of a foot's force: it pushes, it does not slip forward or backward, it does not tip over either end.
const FOOT_LIMITS: usize = 5;

/// Forces of the ground on a foot that stands, and which of their limits a controller keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingFoot {
    /// Places of the forces along x and z among the forces of the phase.
    pub force: [usize; 2],
    /// Place of the moment about the middle of the sole; `None`: the foot stands on a point.
    pub moment: Option<usize>,
    /// x of the rear and of the front end of the sole, from its middle, m.
    pub sole: [f64; 2],
    /// The foot is to push. Not so of a foot whose letting go ends the phase: its force falls to nothing.
    pub holds: bool,
    /// It is not to tip over the rear or over the front end. Not so where tipping ends the phase.
    pub level: [bool; 2],
}

/// Sizes of a gait of several phases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhasedLayout {
    /// Number of gait parameters.
    pub parameters: usize,
    /// Number of joints: all of them have actuators.
    pub joints: usize,
    /// Number of phases.
    pub phases: usize,
    /// Most outputs of a phase.
    pub outputs: usize,
    /// Most forces of the ground in a phase.
    pub forces: usize,
    /// Coulomb's coefficient that forces are held to, if they are.
    pub friction: Option<f64>,
    /// Each foot that is to push ([`StandingFoot::holds`]) pushes at least with this, N: forces are those of a measured state, and one that is just not
    /// negative there pulls in the true one.
    pub least_push: f64,
}

/// One phase, and places of its functions in the model.
///
/// Functions take the arguments of the gait in [`crate::Argument::Parameters`]: φ, φ₊, φ₋, the gait parameters, then of each output
/// the value and the slope of h_p at φ₊.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseLayout {
    /// Index of the phase in the robot's description, as observations say it.
    pub phase: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Number of forces of the ground.
    pub forces: usize,
    /// Function `controlled`: φ and h₀ with their rates.
    pub controlled: usize,
    /// Function `wanted`: h_d with its slopes along φ.
    pub wanted: usize,
    /// Function `phase_end`: φ₋, where h_p has vanished.
    pub end: usize,
    /// Function `feedforward`: torques by joint.
    pub feedforward: usize,
    /// Function `lie_derivatives`: h, L_f h, L_f² h, then L_g L_f h, and the forces of the ground below.
    pub lie_derivatives: usize,
    /// The constraint surface.
    pub surface: PhaseSurfaceLayout,
    /// Function `rate_ratio`: η.
    pub rate_ratio: usize,
    /// Whether h_p takes up what is left of the outputs and their rates where the phase begins.
    pub impact_matching: bool,
    /// K_p (1/s²) and K_d (1/s), if the phase has its own.
    pub feedback: Option<[f64; 2]>,
    /// What stands.
    pub feet: [Option<StandingFoot>; MOST_FEET],
}

impl PhasedLayout {
    /// How many arguments the gait's functions take.
    pub const fn arguments(&self) -> usize {
        3 + self.parameters + 2 * self.outputs
    }

    /// Place of the first value of h_p.
    pub const fn matching(&self) -> usize {
        3 + self.parameters
    }

    /// Most rows of the conditions that torques meet: outputs, the push of a foot that is let go, two limits of each joint, those of the feet.
    pub(super) const fn rows(&self) -> usize {
        self.outputs + 1 + 2 * self.joints + FOOT_LIMITS * MOST_FEET
    }

    /// Numbers of the results of `lie_derivatives`.
    pub(super) const fn lie(&self) -> usize {
        (self.outputs + self.forces) * (3 + self.joints)
    }

    /// Numbers that a controller keeps.
    pub const fn memory(&self) -> usize {
        let results = 2 * (1 + self.outputs) + 2 * self.outputs + self.lie();
        let conditions = self.rows() * (self.joints + 1);
        let search = self.joints * (3 * self.joints + 7);
        2 * self.arguments() + self.parameters + results + 2 * self.joints + conditions + search
    }
}

/// A robot with a gait of several phases: generated code, or programs in process.
///
/// The robot is named as the phases do: the leg that stands first, whichever it is.
pub trait PhasedGait<R>: Model<R> {
    /// Room for numbers: an array in generated code, a vector in process.
    type Memory: AsRef<[R]> + AsMut<[R]>;

    /// [`PhasedLayout::memory`] zeros.
    fn memory(&self) -> Self::Memory;

    /// Sizes.
    fn layout(&self) -> PhasedLayout;

    /// A phase in the order in which they follow each other, `None` beyond the last.
    fn phase(&self, index: usize) -> Option<PhaseLayout>;

    /// A gait parameter, `None` beyond the last.
    fn parameter(&self, index: usize) -> Option<GaitParameter<'_>>;

    /// The largest torque of a joint, in the order of `v` (N m; N of a prismatic one), if the description says one.
    fn effort_limit(&self, joint: usize) -> Option<f64>;
}
