//! The list of cases. The random numbers of a case follow from its name; sampling and encoders take turns.
use super::truth::{Experiment, Group, Part, Plan};
use bipedc_effects::effect::Location;

/// Robot, kind, place (`joint`, `joint<other`, `link:…`, `sensor:…` or nothing).
type Entry = (&'static str, &'static str, &'static str);

const SINGLE: &[Entry] = &[
    ("tulip", "viscous_friction", "left_hip_pitch"),
    ("five_link", "viscous_friction", "right_knee_pitch"),
    ("tulip", "coulomb_friction", "right_hip_roll"),
    ("tulip_v1_leg", "coulomb_friction", "right_ankle_pitch"),
    ("tulip", "asymmetric_coulomb_friction", "left_knee_pitch"),
    ("three_link", "asymmetric_coulomb_friction", "left_hip_pitch"),
    ("tulip", "stribeck_friction", "right_knee_pitch"),
    ("seven_link", "stribeck_friction", "left_hip_pitch"),
    ("tulip", "load_dependent_friction", "left_hip_roll"),
    ("biped_3d", "load_dependent_friction", "right_hip_pitch"),
    ("tulip", "rotor_inertia", "left_ankle_pitch"),
    ("biped_3d", "rotor_inertia", "right_knee_pitch"),
    ("tulip", "payload", "link:right_lower_leg"),
    ("biped_3d", "payload", "link:left_foot"),
    ("tulip", "com_offset", "link:left_upper_leg"),
    ("tulip", "com_offset", "link:right_foot"),
    ("tulip", "inertia_error", "link:left_lower_leg"),
    ("biped_3d", "inertia_error", "link:right_foot"),
    ("tulip", "parallel_spring", "right_ankle_pitch"),
    ("five_link", "parallel_spring", "left_knee_pitch"),
    ("tulip", "series_elasticity", "left_hip_pitch"),
    ("seven_link", "series_elasticity", "right_knee_pitch"),
    ("tulip", "backlash", "right_hip_roll"),
    ("tulip", "backlash", "left_knee_pitch"),
    ("tulip", "torque_gain", "right_hip_pitch"),
    ("seven_link", "torque_gain", "left_knee_pitch"),
    ("tulip", "torque_bias", "left_hip_yaw"),
    ("five_link", "torque_bias", "right_hip_pitch"),
    ("tulip", "torque_saturation", "left_hip_pitch"),
    ("biped_3d", "torque_saturation", "right_hip_roll"),
    ("tulip", "torque_ripple", "right_knee_pitch"),
    ("tulip_v1_leg", "torque_ripple", "right_hip_yaw"),
    ("tulip", "actuator_delay", "right_hip_pitch"),
    ("seven_link", "actuator_delay", "left_knee_pitch"),
    ("tulip", "encoder_offset", "left_hip_roll"),
    ("biped_3d", "encoder_offset", "right_hip_pitch"),
    ("tulip", "gravity_tilt", ""),
    ("biped_3d", "gravity_tilt", ""),
    ("tulip", "coupling", "left_ankle_roll<left_ankle_pitch"),
    ("tulip_v1_leg", "coupling", "right_ankle_pitch<right_knee_pitch"),
];

/// Name, robot and two effects: kind and place.
type Pair = (&'static str, &'static str, [(&'static str, &'static str); 2]);

const PAIRS: &[Pair] = &[
    (
        "pair_viscous_coulomb",
        "tulip",
        [("viscous_friction", "left_knee_pitch"), ("coulomb_friction", "left_knee_pitch")],
    ),
    (
        "pair_coulomb_rotor",
        "tulip",
        [("coulomb_friction", "right_hip_pitch"), ("rotor_inertia", "right_hip_pitch")],
    ),
    ("pair_bias_coulomb", "tulip", [("torque_bias", "left_hip_roll"), ("coulomb_friction", "left_hip_roll")]),
    (
        "pair_spring_viscous",
        "seven_link",
        [("parallel_spring", "right_ankle_pitch"), ("viscous_friction", "right_ankle_pitch")],
    ),
    (
        "pair_gain_coulomb",
        "tulip",
        [("torque_gain", "right_knee_pitch"), ("coulomb_friction", "right_knee_pitch")],
    ),
    (
        "pair_ripple_viscous",
        "biped_3d",
        [("torque_ripple", "left_hip_pitch"), ("viscous_friction", "left_hip_pitch")],
    ),
    (
        "pair_coulomb_and_rotor",
        "tulip",
        [("coulomb_friction", "left_hip_pitch"), ("rotor_inertia", "right_knee_pitch")],
    ),
    (
        "pair_payload_and_coulomb",
        "tulip",
        [("payload", "link:right_foot"), ("coulomb_friction", "left_hip_roll")],
    ),
    (
        "pair_delay_and_viscous",
        "biped_3d",
        [("actuator_delay", "right_hip_pitch"), ("viscous_friction", "left_knee_pitch")],
    ),
    (
        "pair_spring_and_gain",
        "tulip",
        [("parallel_spring", "left_ankle_roll"), ("torque_gain", "right_hip_roll")],
    ),
    (
        "pair_saturation_and_load",
        "tulip",
        [("torque_saturation", "right_hip_pitch"), ("load_dependent_friction", "left_hip_pitch")],
    ),
    (
        "pair_backlash_and_coulomb",
        "tulip",
        [("backlash", "left_hip_pitch"), ("coulomb_friction", "right_hip_roll")],
    ),
];

/// Beside errors of the inertias.
const WITH_CAD: &[Entry] = &[
    ("tulip", "viscous_friction", "right_hip_roll"),
    ("tulip", "coulomb_friction", "left_hip_pitch"),
    ("tulip", "rotor_inertia", "right_hip_pitch"),
    ("tulip", "parallel_spring", "left_hip_roll"),
    ("biped_3d", "coulomb_friction", "left_knee_pitch"),
    ("biped_3d", "torque_bias", "right_ankle_pitch"),
    ("tulip", "torque_ripple", "left_knee_pitch"),
    ("tulip", "asymmetric_coulomb_friction", "right_ankle_pitch"),
    ("seven_link", "load_dependent_friction", "right_hip_pitch"),
    ("five_link", "torque_gain", "left_hip_pitch"),
];

const OUTSIDE: &[Entry] = &[
    ("tulip", "position_friction", "left_knee_pitch"),
    ("tulip", "warming_friction", "right_hip_pitch"),
    ("tulip", "cubic_spring", "right_hip_roll"),
    ("biped_3d", "cubic_drag", "left_hip_pitch"),
    ("tulip", "hidden_oscillator", "right_knee_pitch"),
    ("tulip", "velocity_product", "left_hip_pitch<left_knee_pitch"),
];

/// Experiments on the ground.
const CONTACT: &[(Experiment, Entry)] = &[
    (Experiment::Postures, ("tulip", "com_offset", "link:torso")),
    (Experiment::Postures, ("tulip", "payload", "link:torso")),
    (Experiment::Postures, ("tulip", "ground_slope", "")),
    (Experiment::Postures, ("biped_3d", "ground_slope", "")),
    (Experiment::Postures, ("tulip", "force_sensor_gain", "sensor:right_foot/front_left")),
    (Experiment::Postures, ("tulip", "force_sensor_saturation", "sensor:left_foot/front_right")),
    (Experiment::Postures, ("biped_3d", "force_sensor_saturation", "sensor:right_foot/rear_left")),
    (Experiment::Postures, ("tulip", "force_sensor_bias", "sensor:left_foot/rear_left")),
    (Experiment::Swaying, ("tulip", "payload", "link:torso")),
    (Experiment::Swaying, ("tulip", "gravity_tilt", "")),
    (Experiment::Swaying, ("tulip", "force_sensor_gain", "sensor:left_foot")),
    (Experiment::Swaying, ("tulip", "force_sensor_bias", "sensor:right_foot")),
    (Experiment::Swaying, ("tulip", "ground_compliance", "")),
    (Experiment::Swaying, ("biped_3d", "ground_compliance", "")),
    (Experiment::Impacts, ("five_link", "impact_restitution", "")),
    (Experiment::Impacts, ("three_link", "impact_restitution", "")),
    (Experiment::Impacts, ("five_link", "foot_slip", "")),
    (Experiment::Impacts, ("three_link", "foot_slip", "")),
];

/// Feet that strike flat; last, so that the sampling of the others does not depend on them.
const FLAT: &[Entry] = &[("tulip", "spin_friction", ""), ("biped_3d", "spin_friction", "")];

/// Added after the others, whose sampling does not depend on them.
const LATER: &[Entry] =
    &[("biped_3d", "quadratic_drag", "right_knee_pitch"), ("five_link", "quadratic_drag", "left_hip_pitch")];

/// Other robots than TUlip, hanging or bolted down: an arm, a small biped, a quadruped, a humanoid with 29 joints, two with
/// sliding joints. Added last.
const ROBOTS: &[(Group, Entry)] = &[
    (Group::Single, ("arm", "load_dependent_friction", "elbow")),
    (Group::Single, ("arm", "gravity_tilt", "")),
    (Group::Single, ("arm", "encoder_offset", "shoulder")),
    (Group::Single, ("arm", "com_offset", "link:forearm")),
    (Group::Single, ("arm", "payload", "link:tool")),
    (Group::Single, ("arm", "torque_saturation", "elbow")),
    (Group::Single, ("arm", "asymmetric_coulomb_friction", "wrist_pitch")),
    (Group::CadAndEffect, ("arm", "stribeck_friction", "turn")),
    (Group::Single, ("small_biped", "gravity_tilt", "")),
    (Group::Single, ("small_biped", "encoder_offset", "left_knee")),
    (Group::Single, ("small_biped", "com_offset", "link:right_thigh")),
    (Group::Single, ("small_biped", "payload", "link:left_sole")),
    (Group::Single, ("small_biped", "parallel_spring", "right_ankle")),
    (Group::Single, ("small_biped", "asymmetric_coulomb_friction", "left_hip_pitch")),
    (Group::CadAndEffect, ("small_biped", "coulomb_friction", "right_hip_roll")),
    (Group::Cad, ("small_biped", "", "")),
    (Group::Single, ("quadruped", "asymmetric_coulomb_friction", "front_left_calf")),
    (Group::Single, ("quadruped", "quadratic_drag", "rear_right_thigh")),
    (Group::Single, ("quadruped", "gravity_tilt", "")),
    (Group::Single, ("quadruped", "payload", "link:rear_left_lower")),
    (Group::Single, ("quadruped", "parallel_spring", "front_right_hip")),
    (Group::CadAndEffect, ("quadruped", "rotor_inertia", "rear_left_calf")),
    (Group::Single, ("humanoid", "coulomb_friction", "left_elbow")),
    (Group::Single, ("humanoid", "torque_gain", "right_knee")),
    (Group::Single, ("humanoid", "encoder_offset", "left_hip_roll")),
    (Group::Single, ("humanoid", "payload", "link:right_hand")),
    (Group::Single, ("humanoid", "com_offset", "link:left_thigh")),
    (Group::CadAndEffect, ("humanoid", "viscous_friction", "waist_pitch")),
    (Group::Clean, ("humanoid", "", "")),
    (Group::Single, ("gantry", "coulomb_friction", "bridge")),
    (Group::Single, ("gantry", "viscous_friction", "cart")),
    (Group::Single, ("gantry", "asymmetric_coulomb_friction", "lift")),
    (Group::Single, ("gantry", "torque_saturation", "bridge")),
    (Group::Clean, ("gantry", "", "")),
    (Group::Single, ("scara", "coulomb_friction", "quill")),
    (Group::Single, ("scara", "stribeck_friction", "elbow")),
    (Group::Single, ("scara", "torque_gain", "elbow")),
    (Group::CadAndEffect, ("scara", "actuator_delay", "shoulder")),
];

/// Robots whose encoders all sit on the motors. Added last.
const MOTOR_SIDE: &[(Group, Entry)] = &[
    (Group::Single, ("tulip", "series_elasticity", "left_hip_pitch")),
    (Group::Single, ("seven_link", "series_elasticity", "right_knee_pitch")),
    (Group::Single, ("biped_3d", "series_elasticity", "right_hip_roll")),
    (Group::Single, ("tulip", "backlash", "right_hip_roll")),
    (Group::Single, ("seven_link", "backlash", "left_knee_pitch")),
    (Group::Single, ("biped_3d", "backlash", "right_hip_pitch")),
    (Group::Single, ("tulip", "coulomb_friction", "left_knee_pitch")),
    (Group::Single, ("seven_link", "actuator_delay", "right_hip_pitch")),
    (Group::Single, ("biped_3d", "torque_bias", "left_knee_pitch")),
    (Group::Single, ("tulip", "encoder_offset", "right_hip_pitch")),
    (Group::Clean, ("tulip", "", "")),
    (Group::Clean, ("seven_link", "", "")),
];

/// Group, name, robot, and kinds with their places.
type Several = (Group, &'static str, &'static str, &'static [(&'static str, &'static str)]);

/// Standing robots whose joints lack something, alone or beside a payload. Added last.
const STANDING: &[Several] = &[
    (Group::Single, "coulomb_friction", "tulip", &[("coulomb_friction", "left_knee_pitch")]),
    (Group::Single, "viscous_friction", "biped_3d", &[("viscous_friction", "right_hip_roll")]),
    (Group::Single, "rotor_inertia", "tulip", &[("rotor_inertia", "left_hip_pitch")]),
    (
        Group::Pair,
        "payload_and_coulomb",
        "tulip",
        &[("payload", "link:torso"), ("coulomb_friction", "left_knee_pitch")],
    ),
    (
        Group::Pair,
        "payload_and_viscous",
        "biped_3d",
        &[("payload", "link:torso"), ("viscous_friction", "left_hip_pitch")],
    ),
    (Group::Clean, "clean", "biped_3d", &[]),
];

/// Two effects of which one hides in another form of the other: a payload further out looks like a rotor, a tilt of gravity like offsets of
/// encoders and centres of mass. Added last.
const MEETING: &[Several] = &[
    (Group::Pair, "arm_payload_and_rotor", "arm", &[("payload", "link:tool"), ("rotor_inertia", "turn")]),
    (
        Group::Pair,
        "humanoid_payload_and_rotor",
        "humanoid",
        &[("payload", "link:right_hand"), ("rotor_inertia", "waist_yaw")],
    ),
    (Group::Pair, "arm_payload_and_tilt", "arm", &[("payload", "link:forearm"), ("gravity_tilt", "")]),
    (
        Group::Pair,
        "small_biped_offset_and_com",
        "small_biped",
        &[("encoder_offset", "left_knee"), ("com_offset", "link:right_thigh")],
    ),
];

const CLEAN: &[(Experiment, &str)] = &[
    (Experiment::Hanging, "tulip"),
    (Experiment::Hanging, "five_link"),
    (Experiment::Hanging, "biped_3d"),
    (Experiment::Swaying, "tulip"),
    (Experiment::Postures, "tulip"),
    (Experiment::Impacts, "five_link"),
];

const CAD: &[&str] = &["tulip", "seven_link", "biped_3d", "five_link", "tulip"];

fn place(text: &str) -> Location {
    match (text.split_once(':'), text.split_once('<')) {
        (Some(("link", link)), _) => Location::link(link),
        (Some((_, sensor)), _) => Location::sensor(sensor),
        (_, Some((joint, other))) => Location::pair(joint, other),
        _ if text.is_empty() => Location::default(),
        _ => Location::joint(text),
    }
}

/// Names of cases whose encoders sit on the motors.
const ON_MOTORS: &str = "motor_side";

/// All cases, in the order of the scoreboard.
pub fn all() -> Vec<Plan> {
    let mut cases: Vec<Plan> = Vec::new();
    let mut add = |name: String, group, robot, experiment, parts: &[(&'static str, &'static str)]| {
        let same =
            cases.iter().filter(|case| case.name.rsplit_once('-').is_some_and(|(n, _)| n == name)).count();
        let parts = parts.iter().map(|(kind, at)| Part { kind, place: place(at) }).collect();
        let index = cases.len();
        cases.push(Plan {
            name: format!("{name}-{}", same + 1),
            seed: format!("{name}-{}", same + 1),
            group,
            robot,
            size: if robot == "small_biped" { 0.35 } else { 1.0 },
            experiment,
            parts,
            rate: [250.0, 500.0, 200.0, 1000.0][index % 4],
            // 2000 counts of the motor behind a gear of 111, or a cheap encoder at the joint.
            counts: if index % 5 == 3 { 4096.0 } else { 222_000.0 },
            velocities: index % 3 != 1,
            motor_side: name.starts_with(ON_MOTORS),
        });
    };
    for &(robot, kind, at) in SINGLE {
        add(kind.to_owned(), Group::Single, robot, Experiment::Hanging, &[(kind, at)]);
    }
    for &(experiment, (robot, kind, at)) in CONTACT {
        let name = format!("{experiment:?}_{kind}").to_lowercase();
        add(name, Group::Single, robot, experiment, &[(kind, at)]);
    }
    for (name, robot, parts) in PAIRS {
        add((*name).to_owned(), Group::Pair, robot, Experiment::Hanging, parts);
    }
    for &(experiment, robot) in CLEAN {
        add(format!("clean_{experiment:?}").to_lowercase(), Group::Clean, robot, experiment, &[]);
    }
    for robot in CAD {
        add("cad".to_owned(), Group::Cad, robot, Experiment::Hanging, &[]);
    }
    for &(robot, kind, at) in WITH_CAD {
        add(format!("cad_{kind}"), Group::CadAndEffect, robot, Experiment::Hanging, &[(kind, at)]);
    }
    for &(robot, kind, at) in OUTSIDE {
        add(format!("outside_{kind}"), Group::Outside, robot, Experiment::Hanging, &[(kind, at)]);
    }
    for &(robot, kind, at) in FLAT {
        add(format!("flatimpacts_{kind}"), Group::Single, robot, Experiment::FlatImpacts, &[(kind, at)]);
    }
    for &(robot, kind, at) in LATER {
        add(kind.to_owned(), Group::Single, robot, Experiment::Hanging, &[(kind, at)]);
    }
    for &(group, (robot, kind, at)) in ROBOTS {
        let what = match group {
            Group::Clean => "clean",
            Group::Cad => "cad",
            _ => kind,
        };
        let parts = if kind.is_empty() { &[][..] } else { &[(kind, at)] };
        add(format!("{robot}_{what}"), group, robot, Experiment::Hanging, parts);
    }
    for &(group, (robot, kind, at)) in MOTOR_SIDE {
        let (what, parts) = if kind.is_empty() { ("clean", &[][..]) } else { (kind, &[(kind, at)][..]) };
        add(format!("{ON_MOTORS}_{what}"), group, robot, Experiment::Hanging, parts);
    }
    for &(group, what, robot, parts) in STANDING {
        add(format!("standing_{what}"), group, robot, Experiment::Swaying, parts);
    }
    for &(group, what, robot, parts) in MEETING {
        add(what.to_owned(), group, robot, Experiment::Hanging, parts);
    }
    cases
}
