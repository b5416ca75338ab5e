//! Why a step is not made, in one word: for maps and plans, where many steps are sorted by it.
use super::margins::Margins;
use super::step::Refusal;
use serde::{Serialize, Serializer};

/// What comes of a step: it passes its dead centre and all that is assumed holds, or why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Reason {
    /// The dead centre is passed, assumptions hold.
    Passes,
    /// The energy does not reach the dead centre (6.13).
    FallsBack,
    /// The guard is reached nowhere.
    GuardNotReached,
    /// At some phase no posture satisfies the outputs.
    NoPosture,
    /// Formulas or zero dynamics are no numbers.
    NotFinite,
    /// The foot that lands is not on the ground.
    NotOnTheGround,
    /// φ₊ does not settle, or the outputs jump at the impact.
    OutputsJump,
    /// φ₊ does not lie before φ₋.
    NoPhaseLeft,
    /// φ turns back at the impact.
    TurnsBack,
    /// φ does not grow with the angular momentum.
    Singular,
    /// A phase of several goes on without its end.
    PhaseWithoutEnd,
    /// Limits of ground and joints do not let the outputs of a phase be met.
    OutputsMissed,
    /// The foot that stands, or the one that lands, needs more friction than there is.
    Slips,
    /// The foot that stands or lands would have to pull, or the other one does not come off.
    Pulls,
    /// A point in the air is below the ground.
    Scuffs,
    /// A torque exceeds its limit.
    Torque,
    /// A joint gets to its stop.
    Stop,
    /// A joint is faster than its limit.
    Velocity,
    /// An interruption came before.
    NotComputed,
}

impl Reason {
    /// All of them.
    pub const ALL: [Self; 19] = [
        Self::Passes,
        Self::FallsBack,
        Self::GuardNotReached,
        Self::NoPosture,
        Self::NotFinite,
        Self::NotOnTheGround,
        Self::OutputsJump,
        Self::NoPhaseLeft,
        Self::TurnsBack,
        Self::Singular,
        Self::PhaseWithoutEnd,
        Self::OutputsMissed,
        Self::Slips,
        Self::Pulls,
        Self::Scuffs,
        Self::Torque,
        Self::Stop,
        Self::Velocity,
        Self::NotComputed,
    ];

    /// As files have it.
    pub fn code(self) -> &'static str {
        match self {
            Self::Passes => "passes",
            Self::FallsBack => "falls_back",
            Self::GuardNotReached => "guard_not_reached",
            Self::NoPosture => "no_posture",
            Self::NotFinite => "not_finite",
            Self::NotOnTheGround => "not_on_the_ground",
            Self::OutputsJump => "outputs_jump",
            Self::NoPhaseLeft => "no_phase_left",
            Self::TurnsBack => "turns_back",
            Self::Singular => "singular",
            Self::PhaseWithoutEnd => "phase_without_end",
            Self::OutputsMissed => "outputs_missed",
            Self::Slips => "slips",
            Self::Pulls => "pulls",
            Self::Scuffs => "scuffs",
            Self::Torque => "torque",
            Self::Stop => "joint_stop",
            Self::Velocity => "velocity",
            Self::NotComputed => "not computed",
        }
    }

    /// The reason with this code.
    pub fn of_code(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reason| reason.code() == code)
    }

    /// For legends.
    pub fn words(self) -> &'static str {
        match self {
            Self::Passes => "passes its dead centre",
            Self::FallsBack => "falls back before the dead centre",
            Self::GuardNotReached => "the step has no end: guard not reached",
            Self::NoPosture => "no posture satisfies the outputs",
            Self::NotFinite => "formulas have no value",
            Self::NotOnTheGround => "the foot lands off the ground",
            Self::OutputsJump => "outputs jump at the impact",
            Self::NoPhaseLeft => "no phase is left for a step",
            Self::TurnsBack => "phase turns back at the impact",
            Self::Singular => "phase does not grow with the momentum",
            Self::PhaseWithoutEnd => "a phase does not come to its end",
            Self::OutputsMissed => "limits let outputs be missed",
            Self::Slips => "a foot slips",
            Self::Pulls => "a foot would have to pull",
            Self::Scuffs => "a foot scuffs",
            Self::Torque => "a torque exceeds its limit",
            Self::Stop => "a joint gets to its stop",
            Self::Velocity => "a joint is faster than its limit",
            Self::NotComputed => "not computed",
        }
    }
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.code())
    }
}

impl From<&Refusal> for Reason {
    fn from(refusal: &Refusal) -> Self {
        match refusal {
            Refusal::GuardNotReached(_) => Self::GuardNotReached,
            Refusal::NoPosture(..) => Self::NoPosture,
            Refusal::NotFinite(_) => Self::NotFinite,
            Refusal::NotOnTheGround(_) => Self::NotOnTheGround,
            Refusal::NoSteadyStart | Refusal::OutputsJump(_) => Self::OutputsJump,
            Refusal::NoPhaseLeft(_) => Self::NoPhaseLeft,
            Refusal::TurnsBack(_) => Self::TurnsBack,
            Refusal::Singular(_) => Self::Singular,
            Refusal::FallsBack { .. } => Self::FallsBack,
        }
    }
}

/// Whether a joint's distance from a limit is beyond it; a gait may lie at it, as a straight knee does.
pub(super) fn beyond(distance: f64) -> bool {
    distance < -1e-9
}

/// What is assumed of a step beside that it passes its dead centre; the thesis assumes nothing else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Assumptions {
    /// No foot slips, in the step or at the impact before it.
    pub friction: bool,
    /// The foot that stands and the one that lands push, the other one comes off.
    pub pull: bool,
    /// Points in the air stay above the ground over the middle four fifths of the phase.
    pub clearance: bool,
    /// Torques stay within the efforts of the URDF.
    pub torque: bool,
    /// Joints stay within the position limits of the URDF.
    pub joints: bool,
    /// Joints stay within the velocity limits of the URDF.
    pub velocity: bool,
}

impl Assumptions {
    /// Their names with whether each is assumed.
    pub fn named(self) -> [(&'static str, bool); 6] {
        let Self { friction, pull, clearance, torque, joints, velocity } = self;
        [
            ("friction", friction),
            ("pull", pull),
            ("clearance", clearance),
            ("torque", torque),
            ("joints", joints),
            ("velocity", velocity),
        ]
    }

    /// Whether some margin has to be known.
    pub fn any(self) -> bool {
        self != Self::default()
    }

    /// The first one that does not hold; a margin without a number does not.
    pub fn violated(self, margins: &Margins) -> Option<Reason> {
        let bad = |margin: Option<f64>| margin.is_none_or(|margin| margin < 0.0);
        let cases = [
            (
                self.pull,
                [margins.pull, margins.impact_pull, margins.lift_off].into_iter().any(bad),
                Reason::Pulls,
            ),
            (self.friction, bad(margins.friction) || bad(margins.impact_friction), Reason::Slips),
            (self.clearance, bad(margins.clearance), Reason::Scuffs),
            (self.torque, bad(margins.torque), Reason::Torque),
            // Without a number no joint has such limits.
            (self.joints, margins.joint.is_some_and(beyond), Reason::Stop),
            (self.velocity, margins.velocity.is_some_and(beyond), Reason::Velocity),
        ];
        cases.into_iter().find(|(asked, violated, _)| *asked && *violated).map(|(.., reason)| reason)
    }
}
