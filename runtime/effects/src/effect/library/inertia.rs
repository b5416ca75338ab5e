//! Masses and inertias.
use super::*;

const WEIGH: &str = "Weigh the robot, or record a second run with a known extra mass.";

/// Rotor and gear as seen from the joint.
pub const ROTOR_INERTIA: Kind = Kind {
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
pub const PAYLOAD: Kind = Kind {
    name: "payload",
    title: "Payload",
    place: Place::Link,
    parameters: &[
        estimated("mass", "kg", POSITIVE, (0.0, 20.0), "point mass"),
        estimated("x", "m", INFINITE, (-0.5, 0.5), "its position in the link frame"),
        estimated("y", "m", INFINITE, (-0.5, 0.5), "its position in the link frame"),
        estimated("z", "m", INFINITE, (-0.5, 0.5), "its position in the link frame"),
    ],
    law: Law::Payload,
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
pub const COM_OFFSET: Kind = Kind {
    name: "com_offset",
    title: "Offset of the centre of mass",
    place: Place::Link,
    parameters: &[
        estimated("x", "m", INFINITE, (-0.08, 0.08), "shift of the centre of mass in the link frame"),
        estimated("y", "m", INFINITE, (-0.08, 0.08), "shift of the centre of mass in the link frame"),
        estimated("z", "m", INFINITE, (-0.08, 0.08), "shift of the centre of mass in the link frame"),
    ],
    law: Law::CenterOfMassOffset,
    meaning: "The centre of mass of a link lies elsewhere than the URDF says.",
    symptom: "turns with gravity in the link's frame, without a change of weight",
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

/// Another inertia about the centre of mass.
pub const INERTIA_ERROR: Kind = Kind {
    name: "inertia_error",
    title: "Error of the inertia",
    place: Place::Link,
    parameters: &[
        estimated(
            "ixx",
            "kg m²",
            INFINITE,
            (-2.0, 2.0),
            "added to the inertia about the centre of mass, link axes",
        ),
        estimated(
            "ixy",
            "kg m²",
            INFINITE,
            (-1.0, 1.0),
            "added to the inertia about the centre of mass, link axes",
        ),
        estimated(
            "ixz",
            "kg m²",
            INFINITE,
            (-1.0, 1.0),
            "added to the inertia about the centre of mass, link axes",
        ),
        estimated(
            "iyy",
            "kg m²",
            INFINITE,
            (-2.0, 2.0),
            "added to the inertia about the centre of mass, link axes",
        ),
        estimated(
            "iyz",
            "kg m²",
            INFINITE,
            (-1.0, 1.0),
            "added to the inertia about the centre of mass, link axes",
        ),
        estimated(
            "izz",
            "kg m²",
            INFINITE,
            (-2.0, 2.0),
            "added to the inertia about the centre of mass, link axes",
        ),
    ],
    law: Law::InertiaError,
    meaning: "The moments of inertia of a link differ from the URDF's.",
    symptom: "grows with angular accelerations of the link, also those caused by the joints before it",
    confounders: &[confounder("rotor_inertia", "Move the parent joints at the same time.")],
    experiment: "Turn the link fast about three axes.",
};
