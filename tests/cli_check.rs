//! `bipedc check` and `bipedc init`, what they print and how they fail.
use crate::cli;

use cli::{bipedc, command, piped, scratch, text};
use std::io::Read;
use std::process::Stdio;

#[test]
fn help_teaches_with_examples() {
    let run = bipedc(&["--help"]).ok();
    assert!(run.out.contains("bipedc generate robots/tulip"), "{}", run.out);
    for name in ["init", "check", "generate", "inspect", "evaluate", "compare", "excite"] {
        let run = bipedc(&[name, "--help"]).ok();
        assert!(run.out.contains("Examples:") && run.out.contains(&format!("bipedc {name}")), "{}", run.out);
    }
}

#[test]
fn check_prints_tree_masses_and_height() {
    let run = bipedc(&["check", "robots/five_link"]).ok();
    for words in
        ["right_tibia  3.2 kg", "total mass 32.000000 kg", "height 0.715250 m", "physically consistent"]
    {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
    assert_eq!(run.err, "");
}

#[cfg(unix)]
#[test]
fn a_urdf_may_come_through_a_pipe() {
    let urdf = std::fs::read("robots/five_link/robot.urdf").unwrap();
    let value = piped(&["check", "/dev/stdin", "--json"], &urdf).ok().json();
    assert_eq!(value["robot"], "five_link");
    let error = piped(&["check", "/dev/stdin"], b"<robot name=\"x\">").fails_with(&["/dev/stdin:1"]).err;
    assert!(!error.contains("TOML"), "{error}");
    // Nothing is written to /dev.
    piped(&["init", "/dev/stdin"], &urdf).fails_with(&["/dev/stdin", "robot.urdf in a folder"]);
}

#[test]
fn check_speaks_json() {
    let value = bipedc(&["check", "robots/five_link", "--json"]).ok().json();
    assert_eq!(value["robot"], "five_link");
    assert_eq!(value["total_mass"], 32.0);
    assert_eq!(value["links"][0]["name"], "torso");
    assert_eq!(value["errors"], serde_json::json!([]));
    assert!(value["warnings"].is_array() && value["inconsistencies"].is_array());
}

#[test]
fn check_reports_all_errors_at_once() {
    let folder = scratch("check_all");
    let urdf = std::fs::read_to_string("robots/three_link/robot.urdf").unwrap();
    let broken = urdf.replacen("mass value=\"", "mass value=\"-", 1).replacen(
        "<axis xyz=\"0 1 0\"",
        "<axis xyz=\"0 0 0\"",
        1,
    );
    std::fs::write(folder.join("robot.urdf"), broken).unwrap();
    std::fs::copy("robots/three_link/biped.toml", folder.join("biped.toml")).unwrap();
    bipedc(&["check", text(&folder)]).fails_with(&["is negative", "axis", "robot.urdf:"]);
    let run = bipedc(&["check", text(&folder), "--json"]).fails_with(&["is negative"]);
    let errors = run.json()["errors"].as_array().unwrap().clone();
    assert!(errors.len() >= 2, "{errors:?}");
    assert!(errors[0]["line"].is_u64() && errors[0]["file"].is_string() && errors[0]["help"].is_string());
}

#[test]
fn a_wrong_path_is_one_message() {
    let run = bipedc(&["check", "robots/nowhere"]).fails_with(&[
        "error: ",
        "robots/nowhere",
        "help: give a robot's folder",
    ]);
    assert_eq!(run.out, "");
}

#[test]
fn a_function_that_does_not_exist_is_found_by_check() {
    let folder = scratch("check_function");
    let toml = std::fs::read_to_string("robots/three_link/biped.toml").unwrap();
    std::fs::copy("robots/three_link/robot.urdf", folder.join("robot.urdf")).unwrap();
    std::fs::write(folder.join("biped.toml"), toml + "\n[generate]\nfunctions = [\"mass_matrx\"]\n").unwrap();
    bipedc(&["check", text(&folder)]).fails_with(&["`mass_matrx`", "did you mean `mass_matrix`?"]);
}

#[test]
fn bases_are_overridden_and_checked() {
    let run = bipedc(&["check", "robots/five_link", "--base", "floating", "--root", "right_tibia"]).ok();
    assert!(run.out.contains("base floating at `right_tibia`"), "{}", run.out);
    bipedc(&["check", "robots/five_link", "--root", "rigth_tibia"])
        .fails_with(&["`rigth_tibia`", "known are"]);
}

#[test]
fn init_writes_once() {
    let folder = scratch("init");
    let urdf = folder.join("robot.urdf");
    std::fs::copy("robots/five_link/robot.urdf", &urdf).unwrap();
    let run = bipedc(&["init", text(&urdf)]).ok();
    assert!(run.out.contains("wrote ") && run.out.contains("bipedc check"), "{}", run.out);
    let toml = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    assert!(toml.contains("kind = \"planar\""), "{toml}");
    bipedc(&["check", text(&folder)]).ok();
    bipedc(&["init", text(&urdf)]).fails_with(&["exists already", "--force"]);
    bipedc(&["init", text(&urdf), "--force"]).ok();
    bipedc(&["init", text(&folder.join("none.urdf"))]).fails_with(&["cannot read"]);
}

/// The feet of a robot without collision shapes were points at its ankles, and nothing but a comment said so: its gait walked on them.
#[test]
fn init_says_where_feet_are_a_guess() {
    let folder = scratch("init_without_shapes");
    let mut urdf = std::fs::read_to_string("robots/seven_link_v1/robot.urdf").unwrap();
    let whole = folder.join("whole.urdf");
    std::fs::write(&whole, &urdf).unwrap();
    assert_eq!(bipedc(&["init", text(&whole)]).ok().err, "");
    while let Some(from) = urdf.find("<collision") {
        let length = urdf[from..].find("</collision>").unwrap() + "</collision>".len();
        urdf.replace_range(from..from + length, "");
    }
    let bare = folder.join("bare.urdf");
    std::fs::write(&bare, &urdf).unwrap();
    let run = bipedc(&["init", text(&bare), "--force"]).ok();
    assert!(run.err.contains("no collision shape shows where a foot touches the ground"), "{}", run.err);
    assert!(run.err.contains("biped.toml:"), "{}", run.err);
}

/// Heel and toe of a robot that faces −x were exchanged, and nothing was said of it: no gait was found. With the remedy it is the robot that it
/// was before.
#[test]
fn init_says_that_a_robot_faces_backward() {
    let folder = scratch("init_backward");
    let urdf = std::fs::read_to_string("robots/seven_link_v1/robot.urdf").unwrap();
    let turned = |urdf: &str, root: &str, new: &str| {
        let fixed = format!(
            "<link name=\"{new}\"/><joint name=\"{new}_joint\" type=\"fixed\"><parent link=\"{new}\"/><child link=\"{root}\"/>\
             <origin rpy=\"0 0 3.141592653589793\"/></joint></robot>"
        );
        urdf.replace("</robot>", &fixed)
    };
    let described = |name: &str, urdf: &str| {
        let file = folder.join(format!("{name}.urdf"));
        std::fs::write(&file, urdf).unwrap();
        let said = bipedc(&["init", text(&file), "--force"]).ok().err;
        (said, std::fs::read_to_string(folder.join("biped.toml")).unwrap())
    };
    let feet =
        |toml: &str| toml.lines().filter(|line| line.contains("points.")).collect::<Vec<_>>().join("\n");
    let (said, forward) = described("forward", &urdf);
    assert_eq!(said, "");
    assert!(forward.contains("150 mm before the joint"), "{forward}");
    let backward = turned(&urdf, "torso", "to_the_rear");
    let (said, wrong) = described("backward", &backward);
    for words in ["seems to face −x", "rpy=\"0 0 3.141592653589793\"", "biped.toml:"] {
        assert!(said.contains(words), "{said}");
    }
    assert_ne!(feet(&wrong), feet(&forward));
    let (said, mended) = described("mended", &turned(&backward, "to_the_rear", "to_the_front"));
    assert_eq!((said.as_str(), feet(&mended)), ("", feet(&forward)));
    bipedc(&["check", text(&folder)]).ok();
}

/// The reader takes one byte and leaves: `bipedc … | head -c1`.
#[test]
fn a_broken_pipe_is_no_error() {
    let mut child = command(&["inspect", "robots/tulip", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut byte = [0];
    let mut out = child.stdout.take().unwrap();
    out.read_exact(&mut byte).unwrap();
    drop(out);
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert!(child.wait().unwrap().success(), "{err}");
    assert_eq!(err, "");
}

/// A torso with a thin rod that turns about itself; `INERTIA` is that of the rod about the joint's axis.
const ROD: &str = r#"<robot name="rod">
<link name="torso"><inertial><mass value="3"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="rod"><inertial><origin xyz="0 0 0.2"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0"/></inertial></link>
<joint name="spin" type="continuous"><parent link="torso"/><child link="rod"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/></joint>
</robot>
"#;

fn robot(name: &str, urdf: &str, toml: &str) -> std::path::PathBuf {
    let folder = scratch(name);
    std::fs::write(folder.join("robot.urdf"), urdf).unwrap();
    std::fs::write(folder.join("biped.toml"), toml).unwrap();
    folder
}

/// They divided by the constant 0.
#[test]
fn a_joint_without_inertia_is_told_and_costs_only_the_inverses() {
    let folder = robot("rod", ROD, "");
    let run = bipedc(&["check", text(&folder)]).ok();
    for words in ["no inertia resists joint `spin`", "robot.urdf:4:1", "rotor_inertia"] {
        assert!(run.err.contains(words), "no `{words}` in {}", run.err);
    }
    let run = bipedc(&["inspect", text(&folder)]).ok();
    assert!(run.out.contains("inverse_dynamics ") && !run.out.contains("forward_dynamics"), "{}", run.out);
    for function in ["forward_dynamics", "forward_dynamics_dtau", "forward_dynamics_with_forces"] {
        bipedc(&["inspect", text(&folder), function])
            .fails_with(&[&format!("`{function}` has no solution"), "joint `spin`"]);
    }
    let rotor = "[[effect]]\nkind = \"rotor_inertia\"\njoint = \"spin\"\ninertia = 0.01\n";
    let folder = robot("rod_with_rotor", ROD, rotor);
    let run = bipedc(&["inspect", text(&folder)]).ok();
    assert!(run.out.contains("forward_dynamics") && run.err.is_empty(), "{}", run.err);
}

/// The rod lies across two rotations: its inertia about the axis is 1e-18 kg m² and not 0.
#[test]
fn dust_is_no_inertia() {
    let turned = ROD.replace("<origin xyz=\"0 0 0.2\"/>", "<origin xyz=\"0 0 0\" rpy=\"0.3 0.4 0.5\"/>");
    // Rz(0.5) Ry(0.4) Rx(0.3) z
    let axis = "0.4681915 0.0019497 0.8799232";
    let (sr, cr) = 0.3_f64.sin_cos();
    let (sp, cp) = 0.4_f64.sin_cos();
    let (sy, cy) = 0.5_f64.sin_cos();
    let exact = format!("{} {} {}", cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr);
    let folder = robot("dust", &turned.replace("axis xyz=\"0 0 1\"", &format!("axis xyz=\"{exact}\"")), "");
    assert!(bipedc(&["check", text(&folder)]).ok().err.contains("no inertia resists joint `spin`"));
    // An axis of seven digits is another one: there is a little inertia about it.
    let folder =
        robot("not_dust", &turned.replace("axis xyz=\"0 0 1\"", &format!("axis xyz=\"{axis}\"")), "");
    assert!(!bipedc(&["check", text(&folder)]).ok().err.contains("no inertia"));
}

#[test]
fn robots_without_moving_joints_have_functions() {
    let one = r#"<robot name="one">
<link name="a"><inertial><mass value="3"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="b"/><joint name="weld" type="fixed"><parent link="a"/><child link="b"/></joint>
</robot>
"#;
    let feet = "[feet.b]\npoints.a = [0.1, 0.1, 0]\npoints.b = [0.1, -0.1, 0]\npoints.c = [-0.1, 0.1, 0]\npoints.d = [-0.1, -0.1, 0]\n[[phase]]\nname = \"stand\"\ncontacts = [\"b\"]\nimpact = [\"b\"]\n";
    for (kind, key) in [("fixed", "link"), ("floating", "root")] {
        let toml = format!("[base]\nkind = \"{kind}\"\n{key} = \"a\"\n{feet}");
        let folder = robot(&format!("one_{kind}"), one, &toml);
        let run = bipedc(&["inspect", text(&folder)]).ok();
        // What nothing can move has positions, but no accelerations.
        assert!(run.out.contains("position_of_b "), "{}", run.out);
        assert_eq!(run.out.contains("constrained_dynamics_of_stand"), kind == "floating", "{}", run.out);
        bipedc(&["generate", text(&folder), "--out", text(&folder.join("crate"))]).ok();
    }
    bipedc(&["inspect", text(&robot("one_free", one, "")), "base-parameters", "--of", "dynamics"]).ok();
}

/// Damping and friction of the URDF are no part of the equations: `init` offers them as effects, `check` names them until they are.
#[test]
fn friction_of_the_urdf_is_offered_and_named() {
    let folder = scratch("check_friction");
    let urdf = r#"<robot name="arm"><link name="base"/>
<link name="rod"><inertial><mass value="1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tip"><inertial><mass value="1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
  <dynamics damping="0.25" friction="1.5"/></joint>
<joint name="slide" type="prismatic"><parent link="rod"/><child link="tip"/><axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/>
  <dynamics damping="3" friction="none"/></joint></robot>"#;
    let file = folder.join("robot.urdf");
    std::fs::write(&file, urdf).unwrap();
    bipedc(&["init", text(&file)]).ok();
    let description = folder.join("biped.toml");
    let written = std::fs::read_to_string(&description).unwrap();
    for words in ["# damping = 0.25   # N m s/rad", "# torque = 1.5   # N m\n", "# damping = 3.0   # N s/m"] {
        assert!(written.contains(words), "no `{words}` in {written}");
    }
    let said = bipedc(&["check", text(&folder)]).ok().err;
    for words in [
        "robot.urdf:5:3",
        "leaves out: `hinge`, `slide`",
        "--effect viscous_friction --joint hinge --set damping=0.25",
    ] {
        assert!(said.contains(words), "no `{words}` in {said}");
    }
    // As effects of the description they are part of the model, and there is nothing more to say.
    let offered = written.split("Were they measured?\n").nth(1).unwrap();
    let taken = written.replace(
        offered,
        &offered
            .replace("# [[", "[[")
            .replace("# kind", "kind")
            .replace("# joint", "joint")
            .replace("# damping", "damping")
            .replace("# torque", "torque"),
    );
    std::fs::write(&description, &taken).unwrap();
    assert_eq!(bipedc(&["check", text(&folder)]).ok().err, "");
    // Another value than the URDF's is the model's, with a word.
    std::fs::write(&description, taken.replace("damping = 0.25", "damping = 0.5")).unwrap();
    let said = bipedc(&["check", text(&folder)]).ok().err;
    assert!(
        said.contains("counts: `hinge` damping 0.5 instead of 0.25 N m s/rad")
            && said.contains("robot.urdf:5:3"),
        "{said}"
    );
    assert!(!said.contains("slide"), "{said}");
    let friction = bipedc(&["export", text(&folder), "--urdf", text(&folder.join("out.urdf"))]).ok().out;
    assert!(friction.contains("joints hinge, slide"), "{friction}");
}
