//! The four assumptions of thesis 4.2: simpler models, to see what leaving something out costs.
use super::*;

const fn assumption(
    name: &'static str,
    title: &'static str,
    law: Law,
    meaning: &'static str,
    symptom: &'static str,
) -> Kind {
    Kind {
        name,
        title,
        place: Place::Robot,
        parameters: &[],
        law,
        simulation: Simulation::Law,
        search: Search::none(),
        relations: Relations::NONE,
        identified: None,
        meaning,
        symptom,
        confounders: &[],
        experiment: "Walk with feet that roll, strike and swing.",
    }
}

/// Soles without extent.
pub static POINT_FEET: Kind = assumption(
    "point_feet",
    "Point feet",
    Law::PointFeet,
    "The feet are points: no moment between sole and ground.",
    "is the moment that the sole transmits",
);
/// Velocities that do not jump.
pub static NO_IMPACT: Kind = assumption(
    "no_impact",
    "No impact",
    Law::NoImpact,
    "The foot touches down without a jump of velocities.",
    "is concentrated just after touch-down",
);
/// One point mass.
pub static SINGLE_MASS: Kind = assumption(
    "single_mass",
    "Single mass",
    Law::SingleMass,
    "All mass is concentrated in the centre of mass: the legs have none and nothing turns.",
    "is the rate of angular momentum about the centre of mass",
);
/// Independent planes.
pub static DECOUPLED_PLANES: Kind = assumption(
    "decoupled_planes",
    "Decoupled planes",
    Law::DecoupledPlanes,
    "Motion in the sagittal plane and in the frontal plane do not influence each other.",
    "grows with simultaneous motion in both planes",
);
