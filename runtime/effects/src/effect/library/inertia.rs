//! Masses and inertias.
use super::*;

const WEIGH: &str = "Weigh the robot, or record a second run with a known extra mass.";

/// Rotor and gear as seen from the joint.
pub static ROTOR_INERTIA: Kind = Kind {
    name: "rotor_inertia",
    title: "Rotor inertia",
    place: Place::Joint,
    parameters: &[estimated(
        "inertia",
        "kg m²",
        POSITIVE,
        (0.0, 2.0),
        "inertia at the joint, gear ratio squared times the rotor's",
    )],
    law: Law::Torque("inertia * acceleration"),
    simulation: Simulation::Inertia("inertia"),
    search: Search::linear(&[Evidence::Motion, Evidence::Impacts]),
    relations: Relations::NONE,
    identified: identified("rotor_inertia", "rotor_inertia", false, true),
    meaning: "The inertia of motor and gear behind the gear ratio, which a URDF cannot state.",
    symptom: "grows in proportion to the joint's own acceleration, in any posture",
    confounders: &[
        confounder(
            "inertia_error",
            "Move the parent joints at the same time: the rotor does not feel them, the link does.",
        ),
        confounder("actuator_delay", "Excite at two frequencies a decade apart."),
    ],
    experiment: "Move the joint fast, together with the joints before it.",
};

/// A point mass.
pub static PAYLOAD: Kind = Kind {
    name: "payload",
    title: "Payload",
    place: Place::Link,
    parameters: &[
        estimated("mass", "kg", POSITIVE, (0.0, 20.0), "point mass"),
        estimated("x", "m", INFINITE, (-0.5, 0.5), "its position in the link frame").of_size(Size::Place),
        estimated("y", "m", INFINITE, (-0.5, 0.5), "its position in the link frame").of_size(Size::Place),
        estimated("z", "m", INFINITE, (-0.5, 0.5), "its position in the link frame").of_size(Size::Place),
    ],
    law: Law::Payload,
    simulation: Simulation::Law,
    search: Search {
        sought: EVERYWHERE,
        nonlinear: None,
        starts: Starts::None,
        columns: Columns::Combined {
            probes: |_| {
                let mass = 1e-3;
                let at = |x: f64, y: f64, z: f64| vec![("mass", mass), ("x", x), ("y", y), ("z", z)];
                let none = at(0.0, 0.0, 0.0);
                let shifted = |p: Parameters| vec![(1e6, p), (-1e6, none.clone())];
                vec![
                    vec![(1.0 / mass, none.clone())],
                    // Shifts of a millimetre: what enters linearly is mass times position.
                    shifted(at(1e-3, 0.0, 0.0)),
                    shifted(at(0.0, 1e-3, 0.0)),
                    shifted(at(0.0, 0.0, 1e-3)),
                ]
            },
            parameters: |_, c| match c {
                [m] => vec![("mass", *m)],
                [m, x, y, z] => vec![("mass", *m), ("x", x / m), ("y", y / m), ("z", z / m)],
                _ => Vec::new(),
            },
        },
        refused: |_, _| None,
    },
    relations: Relations { contains: &["com_offset"], repeats: true, ..Relations::NONE },
    identified: None,
    meaning: "A mass on a link that the URDF does not know: cables, covers, batteries, a tool.",
    symptom: "turns with gravity in the link's frame and shows at all joints before it",
    confounders: &[
        confounder("com_offset", WEIGH),
        confounder("torque_gain", WEIGH),
        confounder("force_sensor_gain", WEIGH),
        confounder("encoder_offset", "Take postures that turn the link about two axes."),
    ],
    experiment: "Take postures that turn the link about two horizontal axes, and move it fast between them.",
};

/// A displaced centre of mass.
pub static COM_OFFSET: Kind = Kind {
    name: "com_offset",
    title: "Offset of the centre of mass",
    place: Place::Link,
    parameters: &[
        estimated("x", "m", INFINITE, (-0.08, 0.08), "shift of the centre of mass in the link frame"),
        estimated("y", "m", INFINITE, (-0.08, 0.08), "shift of the centre of mass in the link frame"),
        estimated("z", "m", INFINITE, (-0.08, 0.08), "shift of the centre of mass in the link frame"),
    ],
    law: Law::CenterOfMassOffset,
    simulation: Simulation::Law,
    search: Search::slopes(EVERYWHERE, 1e-4),
    relations: Relations::NONE,
    identified: None,
    meaning: "The centre of mass of a link lies elsewhere than the URDF says.",
    symptom: "turns with gravity in the link's frame, and asks for no change of weight",
    confounders: &[
        confounder("payload", WEIGH),
        confounder("encoder_offset", "Take postures out of the plane, or turn the base."),
        confounder(
            "ground_slope",
            "Repeat at another height of the centre of mass, and with the robot turned by half a turn.",
        ),
        confounder("gravity_tilt", "Repeat with the robot turned by half a turn about the vertical."),
    ],
    experiment: "Take postures that turn the link about two horizontal axes.",
};

const ABOUT: &str = "added to the inertia about the centre of mass, link axes";

const fn change(name: &'static str, unit: &'static str, meaning: &'static str) -> Parameter {
    let (role, size) = (Role::Setting(0.0), Size::NothingAt(0.0));
    Parameter {
        name,
        unit,
        role,
        bounds: INFINITE,
        plausible: INFINITE,
        meaning,
        size,
        reach: None,
        sliding: None,
    }
}

/// Another mass, centre of mass and inertia: all ten parameters of a link, as a diagnosis or an identification of the whole
/// robot found them. It is not searched for by itself.
pub static INERTIAL_CORRECTION: Kind = Kind {
    name: "inertial_correction",
    title: "Inertial correction",
    place: Place::Link,
    parameters: &[
        change("mass", "kg", "added to the mass"),
        change("x", "m", "shift of the centre of mass in the link frame"),
        change("y", "m", "shift of the centre of mass in the link frame"),
        change("z", "m", "shift of the centre of mass in the link frame"),
        change("ixx", "kg m²", ABOUT),
        change("ixy", "kg m²", ABOUT),
        change("ixz", "kg m²", ABOUT),
        change("iyy", "kg m²", ABOUT),
        change("iyz", "kg m²", ABOUT),
        change("izz", "kg m²", ABOUT),
    ],
    law: Law::InertialCorrection,
    simulation: Simulation::Law,
    search: Search::none(),
    relations: Relations::NONE,
    identified: None,
    meaning: "Mass, centre of mass and inertia of a link are others than the URDF says.",
    symptom: "turns with gravity in the link's frame and grows with its accelerations",
    confounders: &[],
    experiment: "Weigh the robot and its parts.",
};

/// Another inertia about the centre of mass.
pub static INERTIA_ERROR: Kind = Kind {
    name: "inertia_error",
    title: "Error of the inertia",
    place: Place::Link,
    parameters: &[
        estimated("ixx", "kg m²", INFINITE, (-2.0, 2.0), ABOUT),
        estimated("ixy", "kg m²", INFINITE, (-1.0, 1.0), ABOUT),
        estimated("ixz", "kg m²", INFINITE, (-1.0, 1.0), ABOUT),
        estimated("iyy", "kg m²", INFINITE, (-2.0, 2.0), ABOUT),
        estimated("iyz", "kg m²", INFINITE, (-1.0, 1.0), ABOUT),
        estimated("izz", "kg m²", INFINITE, (-2.0, 2.0), ABOUT),
    ],
    law: Law::InertiaError,
    simulation: Simulation::Law,
    search: Search {
        sought: &[Evidence::Motion, Evidence::Contact, Evidence::Impacts],
        nonlinear: None,
        starts: Starts::None,
        columns: Columns::Inertial,
        refused: |_, _| None,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The moments of inertia of a link differ from the URDF's.",
    symptom: "grows with angular accelerations of the link, also those caused by the joints before it",
    confounders: &[confounder("rotor_inertia", "Move the parent joints at the same time.")],
    experiment: "Turn the link fast about three axes.",
};
