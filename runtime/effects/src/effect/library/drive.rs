//! Motors, gears and what couples joints.
use super::*;

/// A spring beside the drive.
pub static PARALLEL_SPRING: Kind = Kind {
    name: "parallel_spring",
    title: "Parallel spring",
    place: Place::Joint,
    parameters: &[
        estimated("stiffness", "N m/rad", POSITIVE, (0.0, 500.0), "stiffness").of_size(Size::NeverNothing),
        estimated("rest_angle", "rad", INFINITE, (-6.3, 6.3), "angle without torque").of_size(Size::Place),
    ],
    law: Law::Torque("stiffness * (position - rest_angle)"),
    simulation: Simulation::Formula,
    search: Search {
        sought: MOTION,
        nonlinear: None,
        starts: Starts::None,
        columns: Columns::Combined {
            probes: |_| {
                let spring = |rest: f64| vec![("stiffness", 1.0), ("rest_angle", rest)];
                vec![vec![(1.0, spring(0.0))], vec![(1.0, spring(0.0)), (-1.0, spring(1.0))]]
            },
            // The second column is the torque of stiffness 1 per rad of rest angle, with its sign turned.
            parameters: |_, c| match c {
                [k, m] => vec![("stiffness", *k), ("rest_angle", -m / k)],
                _ => Vec::new(),
            },
        },
        refused: |_, _| None,
    },
    relations: Relations { contains: &["torque_bias"], resembles: &["torque_bias"], ..Relations::NONE },
    identified: None,
    meaning: "An elastic element beside the drive: a spring, a cable loop, a tight cover.",
    symptom: "grows in proportion to the joint's angle, whatever the direction of motion",
    confounders: &[
        confounder("torque_bias", "Move over a wider range of angles."),
        confounder("com_offset", "Turn the base: gravity turns with it, a spring does not."),
        confounder("encoder_offset", "Turn the base, or move over a wide range of angles."),
    ],
    experiment: "Move slowly over the whole range of the joint, in two orientations of the base.",
};

/// A spring between motor and link.
pub static SERIES_ELASTICITY: Kind = Kind {
    name: "series_elasticity",
    title: "Series elasticity",
    place: Place::Joint,
    parameters: &[estimated(
        "stiffness",
        "N m/rad",
        (1e-3, f64::INFINITY),
        (0.05, 1e6),
        "stiffness between motor and link",
    )
    .of_size(Size::NeverNothing)],
    law: Law::SeriesElasticity,
    simulation: Simulation::Law,
    search: Search {
        sought: MOTION,
        nonlinear: None,
        // Between both angles one over the stiffness enters linearly, behind a motor near a stiffness.
        starts: Starts::At(&[1.0]),
        columns: Columns::Combined {
            probes: |stiffness| vec![vec![(stiffness, vec![("stiffness", stiffness)])]],
            parameters: |_, c| c.iter().map(|c| ("stiffness", 1.0 / c)).collect(),
        },
        refused: |_, _| None,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The transmission gives way: belt, cable, harmonic drive, or a spring by design.",
    symptom: "grows with the second derivative of the load; the motor angle leads in proportion to the torque",
    confounders: &[
        confounder("backlash", "Hold and reverse the load slowly: play jumps, a spring grows."),
        confounder("actuator_delay", "Excite at two frequencies a decade apart."),
    ],
    experiment: "Chirp from 0.5 to 20 Hz at small amplitude; log the angles of both motor and joint.",
};

/// Play between motor and link.
pub static BACKLASH: Kind = Kind {
    name: "backlash",
    title: "Backlash",
    place: Place::Joint,
    parameters: &[
        estimated("gap", "rad", POSITIVE, (0.0, 0.2), "play from stop to stop"),
        Parameter {
            name: "smoothing",
            unit: "N m",
            role: Role::Setting(0.2),
            bounds: (1e-9, f64::INFINITY),
            plausible: (1e-6, 10.0),
            meaning: "torque below which the play may be anywhere between its stops",
            size: Size::Place,
            sliding: None,
            reach: None,
        },
    ],
    law: Law::Backlash,
    simulation: Simulation::Law,
    search: Search {
        sought: MOTION,
        nonlinear: None,
        // Between both angles it enters linearly, behind a motor near a gap.
        starts: Starts::At(&[1.0]),
        columns: Columns::Combined {
            probes: |gap| vec![slope("gap", gap)],
            parameters: |_, c| c.iter().map(|c| ("gap", *c)).collect(),
        },
        refused: other_gap,
    },
    relations: Relations {
        // Stops give way a little, which would widen the play between them.
        nuisance: Some(("series_elasticity", &[("stiffness", 3e3)])),
        ..Relations::NONE
    },
    identified: None,
    meaning: "Play in the gear: the motor turns a little before the link follows.",
    symptom: "jumps where the load changes its sign; the motor angle differs by the play, one way or the other",
    confounders: &[
        confounder("coulomb_friction", "Reverse the load without reversing the motion."),
        confounder("series_elasticity", "Hold and reverse the load slowly: play jumps, a spring grows."),
    ],
    experiment: "Hold the position under a load that changes its sign; log the angles of both motor and joint.",
};

/// A slope over so much play says nothing of a much smaller or larger one; where it enters linearly it is probed at 1.
fn other_gap(gap: f64, c: &[f64]) -> Option<String> {
    let found = c.first().copied().filter(|_| gap < 1.0)?;
    (!(0.4..2.5).contains(&(found / gap)))
        .then(|| format!("tried as {gap:.3e} rad of play, it would be {found:.3e} rad"))
}

/// A wrong torque constant.
pub static TORQUE_GAIN: Kind = Kind {
    name: "torque_gain",
    title: "Gain of the torque signal",
    place: Place::Joint,
    parameters: &[estimated("gain", "1", (0.05, 20.0), (0.5, 2.0), "true torque per reported torque")
        .of_size(Size::NothingAt(1.0))],
    law: Law::Reading("torque / gain"),
    simulation: Simulation::Gain("gain"),
    search: Search {
        sought: MOTION,
        nonlinear: None,
        starts: Starts::None,
        // 1/gain − 1 enters linearly.
        columns: Columns::Combined {
            probes: |_| vec![vec![(1.0, vec![("gain", 0.5)])]],
            parameters: |_, c| c.iter().map(|c| ("gain", 1.0 / (1.0 + c))).collect(),
        },
        refused: same_gain,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The torque constant, the gear efficiency or the sensor's calibration is off by a factor.",
    symptom: "is a fixed fraction of the torque, with the same sign driving and braking",
    confounders: &[
        confounder("payload", "Record a second run with a known extra mass."),
        confounder("load_dependent_friction", "Lift and lower at the same speed."),
    ],
    experiment: "Repeat the same motion with and without a known extra mass.",
};

/// A constant offset.
pub static TORQUE_BIAS: Kind = Kind {
    name: "torque_bias",
    title: "Bias of the torque signal",
    place: Place::Joint,
    parameters: &[estimated(
        "bias",
        "N m",
        INFINITE,
        (-10.0, 10.0),
        "reported minus true torque; beside a gain found with it, before that gain",
    )],
    law: Law::Reading("torque + bias"),
    simulation: Simulation::Bias("bias"),
    search: Search::linear(MOTION),
    relations: Relations::NONE,
    identified: identified("offset", "torque_offset", true, false),
    meaning: "The reported torque is off by a constant: sensor or current offset.",
    symptom: "is constant",
    confounders: &[
        confounder("asymmetric_coulomb_friction", "Hold the joint still, approaching from both sides."),
        confounder("com_offset", "Move where the gravity torque of the joint varies."),
        confounder("parallel_spring", "Move over a wider range of angles."),
    ],
    experiment: "Hold several postures in which the gravity torque of the joint differs.",
};

/// The drive gives at most so much.
pub static TORQUE_SATURATION: Kind = Kind {
    name: "torque_saturation",
    title: "Saturation of the torque",
    place: Place::Joint,
    parameters: &[estimated("limit", "N m", POSITIVE, (1e-3, 1000.0), "largest true torque")
        .of_size(Size::NeverNothing)
        .within(NEAR)],
    law: Law::TrueTorque("clip(reading, -limit, limit)"),
    simulation: Simulation::Limit("limit"),
    search: Search {
        sought: MOTION,
        nonlinear: Some("limit"),
        starts: Starts::Limits,
        columns: only_start!("limit"),
        refused: beyond_the_limit,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The drive cannot give the torque that is reported: current limit or voltage limit.",
    symptom: "is one-sided and shows only where the reported torque is largest",
    confounders: &[confounder("torque_gain", "Repeat the motion more slowly, away from the limit.")],
    experiment: "Accelerate harder and harder.",
};

/// Cogging and gear errors.
pub static TORQUE_RIPPLE: Kind = Kind {
    name: "torque_ripple",
    title: "Torque ripple",
    place: Place::Joint,
    parameters: &[
        estimated("amplitude", "N m", POSITIVE, (0.0, 10.0), "amplitude"),
        estimated("periods_per_turn", "1", (0.5, 2000.0), (1.0, 500.0), "periods in one turn of the joint")
            .of_size(Size::Place)
            .at_sliding_in("rad/m"),
        estimated("phase", "rad", INFINITE, (-6.3, 6.3), "phase at position 0")
            .of_size(Size::Place)
            .at_sliding_in("rad"),
    ],
    law: Law::Torque("amplitude * sin(periods_per_turn * position + phase)"),
    simulation: Simulation::MotorFormula,
    search: Search {
        sought: MOTION,
        nonlinear: Some("periods_per_turn"),
        starts: Starts::Periods,
        columns: Columns::Combined {
            probes: |periods| {
                let wave = |phase: f64| {
                    vec![(1.0, vec![("amplitude", 1.0), ("periods_per_turn", periods), ("phase", phase)])]
                };
                vec![wave(0.0), wave(std::f64::consts::FRAC_PI_2)]
            },
            parameters: |periods, c| match c {
                [s, c] => {
                    vec![("amplitude", s.hypot(*c)), ("periods_per_turn", periods), ("phase", c.atan2(*s))]
                }
                _ => Vec::new(),
            },
        },
        refused: |_, _| None,
    },
    relations: Relations { repeats: true, ..Relations::NONE },
    identified: None,
    meaning: "A torque that repeats with the angle: cogging, gear errors, an eccentric sensor.",
    symptom: "repeats with the joint's angle, not with time",
    confounders: &[confounder("parallel_spring", "Move over a whole period of the ripple.")],
    experiment: "Turn slowly at constant speed over the whole range.",
};

/// Torque comes later than reported, or is reported later than it comes.
pub static ACTUATOR_DELAY: Kind = Kind {
    name: "actuator_delay",
    title: "Delay of the torque",
    place: Place::Joint,
    parameters: &[estimated(
        "delay",
        "s",
        (-0.05, 0.2),
        (-0.02, 0.05),
        "time from the reported to the true torque; negative: it is reported later than it acts",
    )],
    law: Law::Delay,
    simulation: Simulation::Law,
    search: Search {
        sought: MOTION,
        nonlinear: Some("delay"),
        starts: Starts::At(&[0.001, 0.004, 0.015, 0.06, -0.0005, -0.002, -0.008]),
        columns: Columns::Combined {
            probes: |delay| vec![slope("delay", delay)],
            parameters: |_, c| c.iter().map(|c| ("delay", *c)).collect(),
        },
        // A slope over so much delay says nothing of a much smaller or larger one.
        refused: |delay, c| {
            let found = c.first().copied()?;
            (!(0.3..3.0).contains(&(found / delay)))
                .then(|| format!("tried as a delay of {delay:.3e} s, it would be {found:.3e} s"))
        },
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The torque acts later than the log says (communication, a slow drive), or earlier (a filter of its sensor, unsynchronised clocks).",
    symptom: "is the rate of change of the torque times a constant",
    confounders: &[
        confounder("viscous_friction", "Excite at two frequencies a decade apart."),
        confounder("rotor_inertia", "Excite at two frequencies a decade apart."),
        confounder("series_elasticity", "Excite at two frequencies a decade apart."),
    ],
    experiment: "Excite broadly from 0.5 to 20 Hz.",
};

/// What another joint does to this one.
pub static COUPLING: Kind = Kind {
    name: "coupling",
    title: "Coupling of two joints",
    place: Place::JointPair,
    parameters: &[
        estimated("inertia", "kg m²", INFINITE, (-2.0, 2.0), "torque per acceleration of the other joint"),
        estimated("damping", "N m s/rad", INFINITE, (-20.0, 20.0), "torque per velocity of the other joint"),
        estimated(
            "coulomb",
            "N m",
            INFINITE,
            (-20.0, 20.0),
            "torque by the sign of the other joint's velocity (see differential)",
        ),
        estimated("stiffness", "N m/rad", INFINITE, (-500.0, 500.0), "torque per angle of the other joint"),
        Parameter {
            name: "differential",
            unit: "1",
            role: Role::Setting(0.0),
            bounds: (-100.0, 100.0),
            plausible: (-1.0, 1.0),
            meaning: "part of the joint's own velocity in the sign: 1 or -1 where a bearing turns with the sum or the difference of both joints, as in differential wrists",
            size: Size::Place,
            sliding: None,
            reach: None,
        },
        SMOOTHING,
    ],
    law: Law::Torque(
        "inertia * other_acceleration + damping * other_velocity + coulomb * sign(other_velocity + differential * velocity) + stiffness * other_position",
    ),
    simulation: Simulation::Coupling { inertia: "inertia" },
    search: Search {
        sought: MOTION,
        nonlinear: Some("differential"),
        starts: Starts::Neighbours(&[0.0, 1.0, -1.0]),
        columns: Columns::Combined {
            probes: |differential| {
                vec![
                    unit("inertia"),
                    unit("damping"),
                    vec![(1.0, vec![("coulomb", 1.0), ("differential", differential)])],
                    unit("stiffness"),
                ]
            },
            parameters: |differential, c| match c {
                [i, d, c, k] => {
                    let mut all = vec![("inertia", *i), ("damping", *d), ("coulomb", *c), ("stiffness", *k)];
                    if differential != 0.0 {
                        all.push(("differential", differential));
                    }
                    all
                }
                _ => Vec::new(),
            },
        },
        refused: |_, _| None,
    },
    relations: Relations::NONE,
    identified: None,
    meaning: "The motion of one joint acts on another through cables, belts or a differential gear.",
    symptom: "follows the motion of another joint",
    confounders: &[confounder("inertia_error", "Move one of the two joints while the other holds still.")],
    experiment: "Move the other joint while this one holds still.",
};

/// The user's own.
pub static FORMULA: Kind = Kind {
    name: "formula",
    title: "Formula",
    place: Place::Joint,
    parameters: &[SMOOTHING],
    law: Law::Formula,
    simulation: Simulation::Formula,
    search: Search::none(),
    relations: Relations { repeats: true, ..Relations::NONE },
    identified: None,
    meaning: "A torque that the description states as a formula.",
    symptom: "follows the formula",
    confounders: &[],
    experiment: "Move so that the formula's value varies independently of the other effects.",
};
