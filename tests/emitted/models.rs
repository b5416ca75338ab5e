//! The robots of these tests.
use bipedc_macros::Biped;

/// Planar, every function.
#[derive(Biped)]
#[biped(description = "robots/three_link")]
pub struct ThreeLink;

/// Floating, every function.
#[derive(Biped)]
#[biped(description = "robots/tulip")]
pub struct Tulip;
