//! Joints that the description locks: the rest moves as the whole robot does with these joints held.
use crate::compiler::effects::support::{Random, Values, call, close, compiled};
use bipedc_compiler::compile::ProgramModel;
use bipedc_compiler::description::{SourceFiles, model::RobotDescription, parse};
use std::path::Path;

const FUNCTIONS: [&str; 5] =
    ["inverse_dynamics", "mass_matrix", "center_of_mass", "momentum", "center_of_mass_acceleration"];

fn sources(robot: &str) -> SourceFiles {
    SourceFiles::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot)).unwrap()
}

fn read(robot: &str, more: &str) -> Result<RobotDescription, String> {
    let files = sources(robot);
    let text = files.toml_text.clone() + more;
    let read = parse(&files.urdf_text, Path::new("robot.urdf"), &text, Path::new("biped.toml"));
    read.map(|(description, _)| description).map_err(|errors| errors.to_string())
}

/// Rows of the whole robot's `v` that the other keeps.
fn kept(whole: &ProgramModel, part: &ProgramModel) -> Vec<usize> {
    let rows = whole.compiled().tree.row_names();
    let left: Vec<String> = part.compiled().tree.row_names();
    left.iter().map(|row| rows.iter().position(|other| other == row).unwrap()).collect()
}

fn held_joints_are_as_locked_ones(robot: &str, locked: &[(&str, f64)]) {
    let list: Vec<String> = locked.iter().map(|(joint, at)| format!("{joint} = {at}")).collect();
    let part = read(robot, &format!("\n[joints]\nlocked = {{ {} }}\n", list.join(", "))).unwrap();
    let (whole, part) = (compiled(&read(robot, "").unwrap(), &FUNCTIONS), compiled(&part, &FUNCTIONS));
    let rows = kept(&whole, &part);
    let tree = &whole.compiled().tree;
    assert_eq!(rows.len() + locked.len(), tree.nv);
    let shift = tree.nq - tree.nv;
    let mut random = Random(7);
    for _ in 0..20 {
        let mut held = Values::random(&whole, &mut random);
        for (joint, at) in locked {
            let row = tree.joints.iter().find(|other| other.name == *joint).unwrap().v_index;
            (held.q[row + shift], held.v[row], held.a[row]) = (*at, 0.0, 0.0);
        }
        let of = |values: &[f64]| rows.iter().map(|row| values[*row]).collect::<Vec<_>>();
        let base = tree.nq - tree.joints.len();
        let joints = rows.iter().filter(|row| **row >= tree.base_nv()).map(|row| held.q[row + shift]);
        let free = Values {
            q: held.q[..base].iter().copied().chain(joints).collect(),
            v: of(&held.v),
            a: of(&held.a),
            tau: of(&held.tau),
            forces: held.forces.clone(),
        };
        let what = |name: &str| format!("{robot}: {name}");
        for name in ["center_of_mass", "momentum", "center_of_mass_acceleration"] {
            close(&call(&part, name, &free), &call(&whole, name, &held), 1e-12, &what(name));
        }
        let torques = of(&call(&whole, "inverse_dynamics", &held));
        close(&call(&part, "inverse_dynamics", &free), &torques, 1e-12, &what("inverse_dynamics"));
        let mass = call(&whole, "mass_matrix", &held);
        let left: Vec<f64> = rows
            .iter()
            .flat_map(|j| rows.iter().map(|i| mass[j * tree.nv + i]).collect::<Vec<_>>())
            .collect();
        close(&call(&part, "mass_matrix", &free), &left, 1e-12, &what("mass_matrix"));
    }
}

#[test]
fn the_rest_moves_as_with_these_joints_held() {
    let tulip = [
        ("left_hip_yaw", 0.31),
        ("right_hip_yaw", 0.31),
        ("left_ankle_roll", -0.2),
        ("right_ankle_roll", 0.2),
        ("left_knee_pitch", 1.2),
        ("right_knee_pitch", 0.0),
    ];
    held_joints_are_as_locked_ones("tulip", &tulip);
    held_joints_are_as_locked_ones("seven_link", &[("left_ankle_pitch", 0.4), ("right_ankle_pitch", -0.3)]);
    held_joints_are_as_locked_ones("tulip_v1_leg", &[("right_hip_roll", -0.7), ("right_knee_pitch", 0.9)]);
}

#[test]
fn a_rail_is_held_at_its_place() {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.1 0.2 0.3'/><mass value='2'/>
             <inertia ixx='0.1' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.3'/></inertial></link>"
        )
    };
    let urdf = format!(
        "<robot name='gantry'><link name='world'/>{}{}
         <joint name='rail' type='prismatic'><parent link='world'/><child link='cart'/><axis xyz='0 1 0'/>
         <origin xyz='1 0 0' rpy='0.3 0.2 0.1'/><limit lower='-2' upper='2' effort='9' velocity='9'/></joint>
         <joint name='swing' type='continuous'><parent link='cart'/><child link='arm'/><axis xyz='1 0 0'/></joint></robot>",
        link("cart"),
        link("arm")
    );
    let model = |toml: &str| {
        let read = parse(&urdf, Path::new("robot.urdf"), toml, Path::new("biped.toml"));
        compiled(&read.unwrap().0, &["center_of_mass", "inverse_dynamics"])
    };
    let (whole, part) = (model(""), model("[joints]\nlocked = { rail = 0.7 }"));
    let state = |q: &[f64]| Values {
        q: q.to_vec(),
        v: q.iter().map(|q| if *q == 0.7 { 0.0 } else { 2.0 }).collect(),
        a: q.iter().map(|q| if *q == 0.7 { 0.0 } else { 3.0 }).collect(),
        tau: Vec::new(),
        forces: Vec::new(),
    };
    let torque = call(&whole, "inverse_dynamics", &state(&[0.7, 0.4]));
    close(&call(&part, "inverse_dynamics", &state(&[0.4])), &torque[1..], 1e-13, "swing");
    // Without the cart, which does not move any more.
    let both = call(&whole, "center_of_mass", &state(&[0.7, 0.4]));
    let cart = call(&whole, "center_of_mass", &state(&[0.7, 0.4 + std::f64::consts::PI]));
    let arm = call(&part, "center_of_mass", &state(&[0.4]));
    let opposite = call(&part, "center_of_mass", &state(&[0.4 + std::f64::consts::PI]));
    let halves: Vec<f64> = (0..3).map(|k| 2.0 * (both[k] - cart[k])).collect();
    let moved: Vec<f64> = (0..3).map(|k| arm[k] - opposite[k]).collect();
    close(&halves, &moved, 1e-13, "centre of mass of the arm");
}

/// What a description says of a locked joint counts no more, and comes back with the joint.
#[test]
fn drives_effects_and_pairs_of_locked_joints_are_left_out() {
    let friction = "\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 0.4\n";
    let whole = read("tulip", friction).unwrap();
    let names = "[joints]\nlocked = [\"left_knee_pitch\", \"right_knee_pitch\"]\n";
    let part = read("tulip", &format!("{friction}{names}")).unwrap();
    assert_eq!(whole.effects.len(), 1);
    assert!(part.effects.is_empty());
    assert_eq!(part.actuated_joints.len() + 2, whole.actuated_joints.len());
    assert_eq!(part.symmetric_joints.len() + 1, whole.symmetric_joints.len());
    let encoders = "motor_encoders = [\"left_knee_pitch\", \"left_hip_roll\", \"left_hip_roll\"]\n";
    let measured =
        |lines: &str| read("tulip", &format!("\n[joints]\n{encoders}{lines}")).unwrap().motor_encoders;
    assert_eq!(measured(""), ["left_knee_pitch", "left_hip_roll"]);
    assert_eq!(measured("locked = [\"left_knee_pitch\", \"right_knee_pitch\"]\n"), ["left_hip_roll"]);
}

#[test]
fn mistakes_are_named() {
    let refusals = [
        (
            "locked = [\"left_kne_pitch\"]",
            &["the joint `left_kne_pitch` is none of the URDF", "did you mean `left_knee_pitch`?"][..],
        ),
        (
            "locked = [\"left_knee_pitch\"]",
            &["of `left_knee_pitch` and `right_knee_pitch` one is locked and the other moves"],
        ),
        ("locked = [\"left_knee_pitch\", \"left_knee_pitch\"]", &["does not move, or is locked twice"]),
        (
            "locked = { left_knee_pitch = \"bent\" }",
            &["`left_knee_pitch` in `locked` in [joints]", "a number"],
        ),
        ("locked = 3", &["expected an array of texts"]),
        (
            "motor_encoders = [\"left_kne_pitch\"]",
            &[
                "`motor_encoders` in [joints]: the URDF has no joint `left_kne_pitch`",
                "did you mean `left_knee_pitch`?",
            ],
        ),
        ("motor_encoders = true", &["`motor_encoders` in [joints]", "expected an array of texts"]),
        (
            "motor_encoders = [\"left_knee_pitch\"]\n[drives.left_knee_pitch]\nkind = \"passive\"",
            &["the drive of `left_knee_pitch` is passive, without a motor"],
        ),
        ("loked = []", &["unknown key `loked` in [joints]", "did you mean `locked`?"]),
    ];
    for (text, expected) in refusals {
        let message = read("tulip", &format!("\n[joints]\n{text}\n")).unwrap_err();
        for part in expected {
            assert!(message.contains(part), "{text}: {message}");
        }
    }
    let files = sources("seven_link");
    let text =
        files.toml_text.clone() + "\n[joints]\nlocked = { left_knee_pitch = 7.0, right_knee_pitch = 7.0 }\n";
    let (_, warnings) =
        parse(&files.urdf_text, Path::new("robot.urdf"), &text, Path::new("biped.toml")).unwrap();
    assert!(warnings.iter().any(|w| w.message.contains("is held at 7 rad")), "{warnings:?}");
}
