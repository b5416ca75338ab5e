//! What sensors report wrongly.
use super::*;

const TURN: &str = "Repeat with the robot turned by half a turn about the vertical.";

/// A joint's zero is off.
pub static ENCODER_OFFSET: Kind = Kind {
    name: "encoder_offset",
    title: "Offset of a joint encoder",
    place: Place::Joint,
    parameters: &[estimated("offset", "rad", (-3.2, 3.2), (-0.35, 0.35), "logged minus true position")],
    law: Law::EncoderOffset,
    simulation: Simulation::Law,
    search: Search::slopes(EVERYWHERE, 1e-4),
    relations: Relations::NONE,
    identified: None,
    meaning: "The zero of a joint's encoder is off.",
    symptom: "is the change of the gravity torques with this joint's angle, at all joints that feel it",
    confounders: &[
        confounder("com_offset", "Take postures out of the plane, or turn the base."),
        confounder("parallel_spring", "Turn the base, or move over a wide range of angles."),
        confounder("gravity_tilt", "Move the joint through its whole range."),
    ],
    experiment: "Take postures that turn the following links about two horizontal axes.",
};

/// The upright direction is off.
pub static GRAVITY_TILT: Kind = Kind {
    name: "gravity_tilt",
    title: "Tilt of gravity",
    place: Place::Robot,
    parameters: &[
        estimated("roll", "rad", (-0.8, 0.8), (-0.15, 0.15), "roll of the base that the log does not report"),
        estimated(
            "pitch",
            "rad",
            (-0.8, 0.8),
            (-0.15, 0.15),
            "pitch of the base that the log does not report",
        ),
    ],
    law: Law::GravityTilt,
    simulation: Simulation::Law,
    search: Search::slopes(&[Evidence::Motion, Evidence::Contact, Evidence::Postures], 1e-4),
    relations: Relations::NONE,
    identified: None,
    meaning: "The base is tilted against gravity more than the log says: stand, IMU mounting, calibration.",
    symptom: "fits one rotation of gravity at all joints at once",
    confounders: &[
        confounder("force_sensor_bias", TURN),
        confounder("encoder_offset", "Move the joint through its whole range."),
        confounder("com_offset", TURN),
        confounder("ground_slope", TURN),
    ],
    experiment: "Repeat the motion with the robot turned by half a turn about the vertical.",
};

/// A factor on foot forces.
pub static FORCE_SENSOR_GAIN: Kind = Kind {
    name: "force_sensor_gain",
    title: "Gain of a foot force sensor",
    place: Place::Sensor,
    parameters: &[estimated(
        "gain",
        "1",
        (0.05, 20.0),
        (0.7, 1.4),
        "reported force and torque per true force and torque",
    )
    .of_size(Size::NothingAt(1.0))],
    law: Law::ForceSensorGain,
    simulation: Simulation::Law,
    search: Search {
        sought: ON_THE_GROUND,
        nonlinear: None,
        starts: Starts::None,
        columns: Columns::Combined {
            probes: |_| vec![vec![(1e4, vec![("gain", 1.0001)])]],
            parameters: |_, c| c.iter().map(|c| ("gain", 1.0 + c)).collect(),
        },
        refused: same_gain,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "A foot force sensor's calibration is off by a factor, of its force and of its torque alike.",
    symptom: "is a fixed fraction of the reported force",
    confounders: &[confounder("payload", "Weigh the robot on a scale.")],
    experiment: "Shift the weight from foot to foot, and weigh the robot on a scale.",
};

/// A constant on foot forces.
pub static FORCE_SENSOR_BIAS: Kind = Kind {
    name: "force_sensor_bias",
    title: "Bias of a foot force sensor",
    place: Place::Sensor,
    parameters: &[
        estimated("x", "N", INFINITE, (-60.0, 60.0), "reported minus true force, world axes"),
        estimated("y", "N", INFINITE, (-60.0, 60.0), "reported minus true force, world axes"),
        estimated("z", "N", INFINITE, (-60.0, 60.0), "reported minus true force, world axes"),
    ],
    law: Law::ForceSensorBias,
    simulation: Simulation::Law,
    search: Search::linear(ON_THE_GROUND),
    relations: Relations::NONE,
    identified: None,
    meaning: "A foot force sensor is off by a constant.",
    symptom: "is constant, also while the foot is in the air",
    confounders: &[
        confounder("gravity_tilt", TURN),
        confounder("payload", "Lift the foot: a bias stays."),
        confounder("com_offset", "Lift the foot: a bias stays."),
    ],
    experiment: "Lift the foot off the ground.",
};

/// A limit of foot forces.
pub static FORCE_SENSOR_SATURATION: Kind = Kind {
    name: "force_sensor_saturation",
    title: "Saturation of a foot force sensor",
    place: Place::Sensor,
    parameters: &[estimated("limit", "N", POSITIVE, (1.0, 1e4), "largest reading")
        .of_size(Size::NeverNothing)
        .within(NEAR)],
    law: Law::ForceSensorSaturation,
    simulation: Simulation::Law,
    search: Search {
        sought: ON_THE_GROUND,
        nonlinear: Some("limit"),
        starts: Starts::Limits,
        columns: only_start!("limit"),
        refused: beyond_the_limit,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "A foot force sensor reports no more than its limit.",
    symptom: "shows only where the reading stays at its largest value",
    confounders: &[confounder("force_sensor_gain", "Load the sensor lightly: a gain stays.")],
    experiment: "Load one corner of the foot more and more.",
};
