//! Friction in a joint and its gear.
use super::*;

const SAME_SPEEDS: &str = "Move the joint at speeds that differ by a factor of five or more: only viscous friction grows with speed.";

const FASTER: &str = "Move the joint at speeds that differ by a factor of five or more, up to the fastest: drag grows with the square of speed.";

/// Proportional to velocity.
pub static VISCOUS_FRICTION: Kind = Kind {
    name: "viscous_friction",
    title: "Viscous friction",
    place: Place::Joint,
    parameters: &[estimated("damping", "N m s/rad", POSITIVE, (0.0, 20.0), "damping coefficient")],
    law: Law::Torque("damping * velocity"),
    simulation: Simulation::Damping("damping"),
    search: Search::linear(MOTION),
    relations: Relations::NONE,
    identified: identified("viscous", "viscous_friction", true, true),
    meaning: "A torque against the motion that grows in proportion to speed: grease, seals, eddy currents.",
    symptom: "grows in proportion to velocity",
    confounders: &[
        confounder("coulomb_friction", SAME_SPEEDS),
        confounder("quadratic_drag", FASTER),
        confounder(
            "actuator_delay",
            "Excite at two frequencies a decade apart: a delay's lag grows with frequency, damping does not.",
        ),
    ],
    experiment: "Sweep the joint back and forth at several constant speeds.",
};

/// Proportional to the square of velocity.
pub static QUADRATIC_DRAG: Kind = Kind {
    name: "quadratic_drag",
    title: "Quadratic drag",
    place: Place::Joint,
    parameters: &[estimated("drag", "N m s²/rad²", POSITIVE, (0.0, 10.0), "drag coefficient")],
    law: Law::Torque("drag * abs(velocity) * velocity"),
    simulation: Simulation::Formula,
    search: Search::linear(MOTION),
    relations: Relations::NONE,
    identified: identified("quadratic_drag", "quadratic_drag", false, true),
    meaning: "A torque against the motion that grows with the square of speed: air, a liquid, a damper with an orifice.",
    symptom: "grows with the square of velocity, against the motion",
    confounders: &[confounder("viscous_friction", FASTER), confounder("coulomb_friction", FASTER)],
    experiment: "Sweep the joint back and forth at several constant speeds, up to the fastest.",
};

/// Depends on the sign of velocity.
pub static COULOMB_FRICTION: Kind = Kind {
    name: "coulomb_friction",
    title: "Coulomb friction",
    place: Place::Joint,
    parameters: &[estimated("torque", "N m", POSITIVE, (0.0, 30.0), "friction torque"), SMOOTHING],
    law: Law::Torque("torque * sign(velocity)"),
    simulation: Simulation::Dry(Dry::Constant { positive: "torque", negative: "torque" }),
    search: Search::linear(MOTION),
    relations: Relations::NONE,
    identified: identified("coulomb", "coulomb_friction", true, true),
    meaning: "A torque of constant size against the motion: dry friction in bearings, gears and seals.",
    symptom: "follows the sign of velocity and jumps where the joint reverses",
    confounders: &[
        confounder("viscous_friction", SAME_SPEEDS),
        confounder(
            "stribeck_friction",
            "Sweep slowly at ten constant speeds in both directions, down to a hundredth of the usual speed.",
        ),
        confounder(
            "backlash",
            "Reverse the load without reversing the motion: play jumps with the load, friction with the velocity.",
        ),
        confounder(
            "asymmetric_coulomb_friction",
            "Repeat the motion in another posture, so that gravity differs.",
        ),
    ],
    experiment: "Sweep the joint back and forth through many reversals.",
};

/// Different in the two directions.
pub static ASYMMETRIC_COULOMB_FRICTION: Kind = Kind {
    name: "asymmetric_coulomb_friction",
    title: "Asymmetric Coulomb friction",
    place: Place::Joint,
    parameters: &[
        estimated("positive", "N m", POSITIVE, (0.0, 30.0), "friction torque at positive velocity"),
        estimated("negative", "N m", POSITIVE, (0.0, 30.0), "friction torque at negative velocity"),
        SMOOTHING,
    ],
    law: Law::Torque(
        "(positive + negative) / 2 * sign(velocity) + (positive - negative) / 2 * abs(sign(velocity))",
    ),
    simulation: Simulation::Dry(Dry::Constant { positive: "positive", negative: "negative" }),
    search: Search::linear(MOTION),
    relations: Relations {
        contains: &["coulomb_friction", "torque_bias"],
        resembles: &["torque_bias", "coulomb_friction", "stribeck_friction"],
        sum_of: Some(["coulomb_friction", "torque_bias"]),
        ..Relations::NONE
    },
    identified: None,
    meaning: "Dry friction that is larger in one direction than in the other.",
    symptom: "follows the sign of velocity, with different sizes in the two directions",
    confounders: &[
        confounder(
            "torque_bias",
            "Hold the joint still at several angles, approaching from both sides: a bias stays, friction does not.",
        ),
        confounder("coulomb_friction", "Record more reversals: the difference of the directions is small."),
        confounder("parallel_spring", "Move over a wider range of angles: a spring grows with the angle."),
    ],
    experiment: "Sweep back and forth at constant speeds, and rest between.",
};

/// Larger at low speed.
pub static STRIBECK_FRICTION: Kind = Kind {
    name: "stribeck_friction",
    title: "Stribeck friction",
    place: Place::Joint,
    parameters: &[
        estimated("coulomb", "N m", POSITIVE, (0.0, 30.0), "friction torque at speed"),
        estimated("static", "N m", POSITIVE, (0.0, 60.0), "friction torque near rest"),
        estimated(
            "stribeck_velocity",
            "rad/s",
            (1e-3, 100.0),
            (0.03, 5.0),
            "speed at which the excess has faded",
        )
        .of_size(Size::Place),
        SMOOTHING,
    ],
    law: Law::Torque(
        "(coulomb + (static - coulomb) * exp(-(velocity / stribeck_velocity)^2)) * sign(velocity)",
    ),
    simulation: Simulation::Dry(Dry::Stribeck {
        coulomb: "coulomb",
        at_rest: "static",
        speed: "stribeck_velocity",
    }),
    search: Search {
        sought: MOTION,
        nonlinear: Some("stribeck_velocity"),
        starts: Starts::At(&[0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0]),
        columns: Columns::Combined {
            probes: |speed| {
                let torques = |coulomb: f64, at_rest: f64| {
                    vec![(1.0, vec![("coulomb", coulomb), ("static", at_rest), ("stribeck_velocity", speed)])]
                };
                vec![torques(1.0, 0.0), torques(0.0, 1.0)]
            },
            parameters: |speed, c| match c {
                [coulomb, rest] => {
                    vec![("coulomb", *coulomb), ("static", *rest), ("stribeck_velocity", speed)]
                }
                _ => Vec::new(),
            },
        },
        refused: |_, c| match c {
            [coulomb, rest] if rest < coulomb => {
                Some("friction would be smaller at rest than at speed".to_owned())
            }
            _ => None,
        },
    },
    relations: Relations {
        contains: &["coulomb_friction"],
        resembles: &["coulomb_friction"],
        repeats: true,
        ..Relations::NONE
    },
    identified: None,
    meaning: "Dry friction that is larger near rest than at speed: boundary lubrication.",
    symptom: "follows the sign of velocity and is largest at low speed",
    confounders: &[
        confounder(
            "coulomb_friction",
            "Sweep slowly at ten constant speeds in both directions, down to a hundredth of the usual speed.",
        ),
        confounder("viscous_friction", SAME_SPEEDS),
        confounder("backlash", "Reverse the load without reversing the motion."),
    ],
    experiment: "Sweep at ten constant speeds, spaced evenly in their logarithm, in both directions.",
};

/// Grows with the load on the gear.
pub static LOAD_DEPENDENT_FRICTION: Kind = Kind {
    name: "load_dependent_friction",
    title: "Load-dependent friction",
    place: Place::Joint,
    parameters: &[
        estimated("coefficient", "1", (0.0, 0.95), (0.0, 0.5), "friction per load torque"),
        SMOOTHING,
    ],
    law: Law::Torque("coefficient * abs(load) * sign(velocity)"),
    simulation: Simulation::Dry(Dry::Load("coefficient")),
    search: Search::linear(MOTION),
    relations: Relations::NONE,
    identified: None,
    meaning: "Dry friction in proportion to the torque that the gear transmits: its efficiency.",
    symptom: "follows the sign of velocity, the more the larger the load torque",
    confounders: &[
        confounder("coulomb_friction", "Repeat the same motion with a known extra load."),
        confounder(
            "torque_gain",
            "Lift and lower at the same speed: a gain has the same sign both ways, friction the opposite.",
        ),
    ],
    experiment: "Lift and lower at the same speeds with two different loads.",
};
