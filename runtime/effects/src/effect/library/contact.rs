//! Feet and ground.
use super::*;

/// The ground is not level.
pub static GROUND_SLOPE: Kind = Kind {
    name: "ground_slope",
    title: "Slope of the ground",
    place: Place::Robot,
    parameters: &[
        estimated("roll", "rad", (-0.8, 0.8), (-0.3, 0.3), "roll of the ground"),
        estimated("pitch", "rad", (-0.8, 0.8), (-0.3, 0.3), "pitch of the ground"),
    ],
    law: Law::GroundSlope,
    simulation: Simulation::Law,
    search: Search::slopes(&[Evidence::Postures], 1e-4),
    relations: Relations::NONE,
    identified: None,
    meaning: "The ground is not level.",
    symptom: "shifts the centre of pressure in proportion to the height of the centre of mass",
    confounders: &[
        confounder(
            "gravity_tilt",
            "Turn the robot by half a turn: the slope changes its sign, an IMU's error does not.",
        ),
        confounder("com_offset", "Repeat at another height of the centre of mass."),
        confounder("payload", "Repeat at another height of the centre of mass."),
    ],
    experiment: "Stand in two directions and at two heights.",
};

/// Sole or ground give way.
pub static GROUND_COMPLIANCE: Kind = Kind {
    name: "ground_compliance",
    title: "Compliance of the ground",
    place: Place::Robot,
    parameters: &[
        estimated("stiffness", "N/m", (1.0, f64::INFINITY), (1e3, 1e7), "stiffness below each corner")
            .of_size(Size::NeverNothing),
        estimated("damping", "N s/m", POSITIVE, (0.0, 1e5), "damping below each corner"),
    ],
    law: Law::GroundCompliance,
    simulation: Simulation::Law,
    search: Search {
        sought: ON_THE_GROUND,
        nonlinear: None,
        starts: Starts::None,
        // What enters linearly is 1/k and d/k².
        columns: Columns::Combined {
            probes: |_| {
                let soil = |damping: f64| vec![("stiffness", 1.0), ("damping", damping)];
                vec![vec![(1.0, soil(0.0))], vec![(1.0, soil(1.0)), (-1.0, soil(0.0))]]
            },
            parameters: |_, c| match c {
                [c, d] => vec![("stiffness", 1.0 / c), ("damping", d / (c * c))],
                _ => Vec::new(),
            },
        },
        refused: |_, _| None,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "Sole and ground give way below each corner of the feet.",
    symptom: "tilts the soles with the load",
    confounders: &[confounder("encoder_offset", "Shift the weight while the joints hold still.")],
    experiment: "Stand still and shift the weight, then press on the robot.",
};

/// Feet bounce.
pub static IMPACT_RESTITUTION: Kind = Kind {
    name: "impact_restitution",
    title: "Restitution of impacts",
    place: Place::Robot,
    parameters: &[estimated(
        "coefficient",
        "1",
        (0.0, 1.0),
        (0.0, 0.8),
        "normal speed after per normal speed before",
    )],
    law: Law::Restitution,
    simulation: Simulation::Law,
    search: Search::slopes(&[Evidence::Impacts], 1e-3),
    relations: Relations::NONE,
    identified: None,
    meaning: "A foot bounces: it leaves the ground with a part of the speed at which it struck.",
    symptom: "is in proportion to the speed at which the foot strikes",
    confounders: &[
        confounder("foot_slip", "Strike straight down: slip needs a tangential speed."),
        confounder("ground_compliance", "Sample faster: compliance spreads the impact over time."),
    ],
    experiment: "Let the foot strike at several speeds.",
};

/// Feet slip.
pub static FOOT_SLIP: Kind = Kind {
    name: "foot_slip",
    title: "Slip of the foot",
    place: Place::Robot,
    parameters: &[estimated("friction", "1", (0.0, 10.0), (0.05, 1.5), "tangential per normal force")
        .of_size(Size::NeverNothing)],
    law: Law::Slip,
    simulation: Simulation::Law,
    search: Search {
        sought: &[Evidence::Impacts],
        nonlinear: Some("friction"),
        // Where few impacts slip, and little, two starts on either side of the truth miss it.
        starts: Starts::At(&[
            0.06, 0.08, 0.1, 0.12, 0.14, 0.16, 0.18, 0.2, 0.22, 0.25, 0.275, 0.3, 0.325, 0.35, 0.375, 0.4,
            0.43, 0.46, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.9, 1.0,
        ]),
        columns: only_start!("friction"),
        refused: far_beyond_the_limit,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The foot slides where the tangential force exceeds what friction can hold.",
    symptom: "lets the standing foot move while it is loaded",
    confounders: &[confounder("impact_restitution", "Strike straight down.")],
    experiment: "Strike or push the ground more and more obliquely.",
};

/// Feet turn.
pub static SPIN_FRICTION: Kind = Kind {
    name: "spin_friction",
    title: "Spin of the foot",
    place: Place::Robot,
    parameters: &[
        estimated("radius", "m", POSITIVE, (0.0, 0.2), "torsional moment per tangential limit force")
            .of_size(Size::NeverNothing),
        Parameter {
            name: "friction",
            unit: "1",
            role: Role::Setting(1.0),
            bounds: (1e-6, 10.0),
            plausible: (0.05, 1.5),
            meaning: "tangential limit force per normal force, unless `foot_slip` states it",
            size: Size::Place,
            sliding: None,
            reach: None,
        },
    ],
    law: Law::SpinFriction,
    simulation: Simulation::Law,
    search: Search {
        sought: &[Evidence::Impacts],
        nonlinear: Some("radius"),
        starts: Starts::At(&[0.005, 0.01, 0.02, 0.05]),
        columns: only_start!("radius"),
        refused: beyond_the_limit,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The standing foot turns about the vertical where the swing leg's reaction exceeds what friction can hold.",
    symptom: "turns the standing foot about the vertical while the other leg swings",
    confounders: &[confounder("foot_slip", "Swing the leg about the vertical axis only.")],
    experiment: "Stand on one foot and swing the other leg about the vertical.",
};
