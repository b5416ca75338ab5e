//! The list of cases. The random numbers of a case follow from its name; sampling and encoders take turns.
use super::few;
use super::truth::{Experiment, Group, Part, Plan};
use bipedc_effects::effect::Location;
use std::collections::BTreeMap;

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

/// Joints that stop for three quarters of a second again and again and stick meanwhile, under soft control. Added last.
const RESTING: &[Several] = &[
    (Group::Single, "coulomb", "arm", &[("coulomb_friction", "elbow")]),
    (Group::Single, "coulomb", "humanoid", &[("coulomb_friction", "left_hip_roll")]),
    (Group::Single, "asymmetric", "small_biped", &[("asymmetric_coulomb_friction", "left_hip_pitch")]),
    (
        Group::Pair,
        "coulomb_and_viscous",
        "arm",
        &[("coulomb_friction", "shoulder"), ("viscous_friction", "shoulder")],
    ),
    (
        Group::Pair,
        "two_joints",
        "tulip",
        &[("coulomb_friction", "left_knee_pitch"), ("coulomb_friction", "right_hip_pitch")],
    ),
    (
        Group::Pair,
        "coulomb_and_rotor",
        "biped_3d",
        &[("coulomb_friction", "right_knee_pitch"), ("rotor_inertia", "right_knee_pitch")],
    ),
    (Group::Clean, "clean", "quadruped", &[]),
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

/// Names of cases whose joints stop again and again.
const RESTS: &str = "resting";

/// A case without what takes turns.
struct Case {
    name: String,
    group: Group,
    robot: &'static str,
    experiment: Experiment,
    parts: Vec<(&'static str, &'static str)>,
    /// Joints that move; empty: all.
    moving: &'static [&'static str],
}

impl Case {
    /// A case of joints that follow a motion.
    fn hanging(name: String, group: Group, (robot, kind, at): Entry) -> Self {
        let parts = if kind.is_empty() { Vec::new() } else { vec![(kind, at)] };
        Self { name, group, robot, experiment: Experiment::Hanging, parts, moving: &[] }
    }

    /// Cases of one list, their names behind a word.
    fn several(word: &str, experiment: Experiment, list: &[Several]) -> Vec<Self> {
        let case = |&(group, what, robot, parts): &Several| {
            let name = format!("{word}_{what}").trim_start_matches('_').to_owned();
            Self { name, group, robot, experiment, parts: parts.to_vec(), moving: &[] }
        };
        list.iter().map(case).collect()
    }

    /// As the `index`-th of the scoreboard and the `count`-th of its name.
    fn plan(self, index: usize, count: usize) -> Plan {
        let name = format!("{}-{count}", self.name);
        Plan {
            seed: name.clone(),
            name,
            group: self.group,
            robot: self.robot,
            size: if self.robot == "small_biped" { 0.35 } else { 1.0 },
            experiment: self.experiment,
            parts: self.parts.into_iter().map(|(kind, at)| Part { kind, place: place(at) }).collect(),
            rate: [250.0, 500.0, 200.0, 1000.0][index % 4],
            // 2000 counts of the motor behind a gear of 111, or a cheap encoder at the joint.
            counts: if index % 5 == 3 { 4096.0 } else { 222_000.0 },
            velocities: index % 3 != 1,
            motor_side: self.name.starts_with(ON_MOTORS),
            rests: self.name.starts_with(RESTS),
            moving: self.moving,
        }
    }
}

/// All cases, in the order of the scoreboard.
pub fn all() -> Vec<Plan> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let of_tulip = of_tulip_and_shipped().into_iter();
    let cases = of_tulip.chain(of_other_robots()).enumerate();
    let plan = |(index, case): (usize, Case)| {
        let count = seen.entry(case.name.clone()).or_default();
        *count += 1;
        case.plan(index, *count)
    };
    cases.map(plan).collect()
}

/// Cases of the robots in `robots/`.
fn of_tulip_and_shipped() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    let named = |word: &str, group: Group, list: &[Entry]| -> Vec<Case> {
        list.iter().map(|entry| Case::hanging(format!("{word}{}", entry.1), group, *entry)).collect()
    };
    cases.extend(named("", Group::Single, SINGLE));
    cases.extend(CONTACT.iter().map(|&(experiment, (robot, kind, at))| Case {
        name: format!("{experiment:?}_{kind}").to_lowercase(),
        group: Group::Single,
        robot,
        experiment,
        parts: vec![(kind, at)],
        moving: &[],
    }));
    cases.extend(PAIRS.iter().map(|&(name, robot, parts)| Case {
        name: name.to_owned(),
        group: Group::Pair,
        robot,
        experiment: Experiment::Hanging,
        parts: parts.to_vec(),
        moving: &[],
    }));
    cases.extend(CLEAN.iter().map(|&(experiment, robot)| Case {
        name: format!("clean_{experiment:?}").to_lowercase(),
        group: Group::Clean,
        robot,
        experiment,
        parts: Vec::new(),
        moving: &[],
    }));
    cases.extend(CAD.iter().map(|robot| Case::hanging("cad".to_owned(), Group::Cad, (robot, "", ""))));
    cases.extend(named("cad_", Group::CadAndEffect, WITH_CAD));
    cases.extend(named("outside_", Group::Outside, OUTSIDE));
    let flat = named("flatimpacts_", Group::Single, FLAT).into_iter();
    cases.extend(flat.map(|case| Case { experiment: Experiment::FlatImpacts, ..case }));
    cases.extend(named("", Group::Single, LATER));
    cases
}

/// Cases that were added later, most of them of other robots.
fn of_other_robots() -> Vec<Case> {
    let what = |group: Group, kind: &'static str| match group {
        Group::Clean => "clean",
        Group::Cad => "cad",
        _ => kind,
    };
    let robots = ROBOTS
        .iter()
        .map(|&(group, entry)| Case::hanging(format!("{}_{}", entry.0, what(group, entry.1)), group, entry));
    let motors = MOTOR_SIDE
        .iter()
        .map(|&(group, entry)| Case::hanging(format!("{ON_MOTORS}_{}", what(group, entry.1)), group, entry));
    let mut cases: Vec<Case> = robots.chain(motors).collect();
    cases.extend(Case::several("standing", Experiment::Swaying, STANDING));
    cases.extend(Case::several("", Experiment::Hanging, MEETING));
    cases.extend(Case::several(RESTS, Experiment::Hanging, RESTING));
    cases.extend(few::CASES.iter().map(|&(group, what, robot, parts, moving)| Case {
        name: format!("{}_{what}", few::FEW),
        group,
        robot,
        experiment: Experiment::Hanging,
        parts: parts.to_vec(),
        moving,
    }));
    cases
}
