//! The robots of these tests.
use bipedc_macros::Biped;

/// Planar, every function.
#[derive(Biped)]
#[biped(description = "robots/three_link")]
pub struct ThreeLink;

/// Floating, every function: the same items as the macro's, which another test compares as tokens, compiled once for all tests.
pub use tulip::Tulip;

/// The same as [`ThreeLink`], but in parts of at most 25 instructions.
#[derive(Biped)]
#[biped(description = "robots/three_link", split_above = 25)]
pub struct SplitThreeLink;

/// The functions of TUlip that call for the most parts.
#[derive(Biped)]
#[biped(
    description = "robots/tulip",
    split_above = 300,
    functions = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_dynamics_regressor"]
)]
pub struct SplitTulip;

/// One leg after the other.
#[derive(Biped)]
#[biped(
    description = "robots/tulip",
    limbs_apart = true,
    functions = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_dynamics_regressor"]
)]
pub struct TulipLegByLeg;

/// An effect of every kind that stands in a formula.
#[derive(Biped)]
#[biped(description = "tests/data/effects/five_link")]
pub struct FiveLinkWithEffects;

/// Effects in joints, bodies and sensors.
#[derive(Biped)]
#[biped(description = "tests/data/effects/tulip")]
pub struct TulipWithEffects;

/// With a gait.
#[derive(Biped)]
#[biped(description = "robots/five_link", functions = ["inverse_dynamics"], gait = "thesis")]
pub struct FiveLinkWalker;

/// The same of another robot, in parts.
#[derive(Biped)]
#[biped(description = "robots/three_link", functions = ["bias"], gait = "thesis", split_above = 40)]
pub struct ThreeLinkWalker;

/// With a gait of four phases.
#[derive(Biped)]
#[biped(description = "robots/seven_link_v1", functions = ["bias"], gait = "collocated")]
pub struct SevenLinkWalker;
