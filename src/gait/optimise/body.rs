//! What usual margins and scales follow from: mass, height, gravity.
use super::guess;
use super::similarity::Measure;
use bipedc_compiler::compile::Collocation;

/// Mass of the robot (kg), height of its base (m) and gravity (m/s²), which usual margins follow from.
pub fn size(of: &Collocation) -> [f64; 3] {
    [of.mass, guess::height(of), gravity(of)]
}

/// Size of gravity, m/s².
pub(super) fn gravity(of: &Collocation) -> f64 {
    of.description.gravity.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether a joint slides.
pub fn slides(of: &Collocation) -> bool {
    Measure::of_coordinates(of)[3..].contains(&Measure::Length)
}

/// Weight of the robot, N.
pub fn weight(of: &Collocation) -> f64 {
    of.mass * gravity(of)
}
