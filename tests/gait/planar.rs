//! Planar robots that nobody prepared, from a bare URDF: description, form of a gait, optimised gait, twenty steps.
use crate::cli::{bipedc, scratch, text};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The robot in a folder of its own, described by `init`, with the form of a gait by `gait new`.
fn begun(name: &str) -> PathBuf {
    // Tests of the same robot run at the same time.
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = scratch(&format!("planar-{name}-{count}"));
    let urdf = folder.join("robot.urdf");
    std::fs::copy(format!("tests/data/planar/{name}.urdf"), &urdf).unwrap();
    bipedc(&["init", text(&urdf), "--force"]).ok();
    bipedc(&["check", text(&folder)]).ok();
    let form = folder.join("gaits").join("form.toml");
    bipedc(&["gait", "new", text(&folder), "--out", text(&form), "--force"]).ok();
    folder
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Two legs on points, three joints each, names in one word, axes and frames turned: the direction of the leg knows the signs.
#[test]
fn a_robot_on_points_has_a_form_of_one_phase() {
    let folder = begun("bird");
    let form = read(&folder.join("gaits/form.toml"));
    let again =
        bipedc(&["gait", "new", text(&folder), "--out", text(&folder.join("gaits/again.toml")), "--force"])
            .ok();
    // A fifth of √(9.81 · 0.85).
    assert!(
        again.err.contains("0.58 to begin with") || again.out.contains("0.58 to begin with"),
        "{} {}",
        again.out,
        again.err
    );
    // By hand: 0.85 m from hip to foot, of which 0.57 m are below the knee and 0.25 m below the ankle; the hip's axis is +y in the body, the others −y.
    let phi = "base_pitch + RightHipJoint - 0.67 * RightKneeJoint - 0.29 * RightAnkleJoint";
    assert!(form.contains(phi), "{form}");
    assert_eq!(form.matches("[[phase.output]]").count(), 6, "{form}");
    bipedc(&["gait", "new", text(&folder), "--out", text(&folder.join("gaits/form.toml"))])
        .fails_with(&["exists", "--force"]);
}

/// Names that tell no side, knees that are bent at zero: pairs by place, four phases, heel and toe.
#[test]
fn a_robot_with_feet_and_names_without_sides_has_four_phases() {
    let folder = begun("child");
    let described = read(&folder.join("biped.toml"));
    for words in [
        "points.heel = [-0.05, 0.0, -0.035]",
        "left = \"leg1_j2\", right = \"leg2_j2\", sign = 1.0",
        "next = \"push_off\"",
    ] {
        let without_point = words.replace("1.0", "1");
        assert!(
            described.contains(words) || described.contains(&without_point),
            "no `{words}` in {described}"
        );
    }
    let form = read(&folder.join("gaits/form.toml"));
    // N − M − 1 of 10 coordinates and 3, 2, 4 and 5 rows of contacts.
    let counts: Vec<usize> =
        form.split("[[phase]]").skip(1).map(|phase| phase.matches("[[phase.output]]").count()).collect();
    assert_eq!(counts, [6, 7, 5, 4], "{form}");
    let knees = folder.join("gaits/knees.toml");
    bipedc(&["gait", "new", text(&folder), "--knees", "--out", text(&knees), "--force"]).ok();
    let form = read(&knees);
    // On two feet the knees, which straight legs leave as they are, not the height of the base, which straight legs do not follow.
    let of_phase = |name: &str| {
        let phase = form.split("[[phase]]").find(|phase| phase.contains(&format!("name = \"{name}\"")));
        let outputs = phase.unwrap().split("[[phase.output]]").skip(1);
        let controlled = |output: &str| {
            output.split("controlled = \"").nth(1).unwrap().split('"').next().unwrap().to_owned()
        };
        outputs.map(controlled).collect::<Vec<_>>()
    };
    let pitch = "base_pitch + leg1_j1 + leg1_j2 + leg1_j3";
    assert_eq!(of_phase("touch_down").len(), 5);
    assert!(of_phase("touch_down").contains(&pitch.to_owned()), "{form}");
    for phase in ["touch_down", "push_off"] {
        for joint in ["base_pitch", "leg1_j2", "leg2_j2"] {
            assert!(of_phase(phase).contains(&joint.to_owned()), "{phase} {joint} {form}");
        }
    }
}

/// A waist may be called `base_to_torso`, and is driven: no joint of the base has something that weighs before it.
#[test]
fn a_waist_named_after_the_base_is_driven() {
    let folder = begun("stilt");
    let urdf = folder.join("robot.urdf");
    std::fs::write(&urdf, read(&urdf).replace("joint name=\"pi\"", "joint name=\"base_to_torso\"")).unwrap();
    bipedc(&["init", text(&urdf), "--force"]).ok();
    let described = read(&folder.join("biped.toml"));
    assert!(
        described.contains("  \"base_to_torso\",") && !described.contains("joint of the base"),
        "{described}"
    );
}

/// As simulators have it: a world, two slides and a turn before the trunk. The base coordinates take their place.
#[test]
fn joints_that_move_the_whole_robot_become_base_coordinates() {
    let folder = begun("stilt");
    let urdf = folder.join("robot.urdf");
    let joint = |name: &str, kind: &str, [parent, child]: [&str; 2], axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-9\" upper=\"9\" effort=\"0\" velocity=\"9\"/></joint>\n"
        )
    };
    let before = format!(
        "<robot name=\"rail\">\n<link name=\"world\"/><link name=\"along\"/><link name=\"above\"/>\n{}{}{}",
        joint("x", "prismatic", ["world", "along"], "1 0 0"),
        joint("z", "prismatic", ["along", "above"], "0 0 1"),
        joint("turn", "revolute", ["above", "base_x"], "0 1 0")
    );
    std::fs::write(&urdf, read(&urdf).replace("<robot name=\"stilt\">", &before)).unwrap();
    bipedc(&["init", text(&urdf), "--force"]).ok();
    let described = read(&folder.join("biped.toml"));
    for words in
        ["kind = \"planar\"", "root = \"base_x\"", "locked = [\"x\", \"z\", \"turn\"]", "\n[[phase]]"]
    {
        assert!(described.contains(words), "no `{words}` in {described}");
    }
    bipedc(&["check", text(&folder)]).ok();
    let form = folder.join("gaits/form.toml");
    bipedc(&["gait", "new", text(&folder), "--out", text(&form), "--force"]).ok();
    assert_eq!(read(&form).matches("[[phase.output]]").count(), 6);
}

/// Hips that tell their sides carry knees that do not: these are paired by their places.
#[test]
fn knees_without_sides_are_paired_below_hips_with_sides() {
    let folder = begun("stilt");
    let urdf = folder.join("robot.urdf");
    let words = read(&urdf)
        .replace("name=\"port_2\"", "name=\"knee1\"")
        .replace("name=\"starboard_2\"", "name=\"knee2\"");
    std::fs::write(&urdf, words).unwrap();
    bipedc(&["init", text(&urdf), "--force"]).ok();
    let described = read(&folder.join("biped.toml"));
    for words in ["left = \"knee1\", right = \"knee2\"", "\n[[phase]]\nname = \"single_support\""] {
        assert!(described.contains(words), "no `{words}` in {described}");
    }
}

/// Legs of four joints, knees that bend backwards and hocks that bend ahead: on two feet a leg is told by how much more the knee bends than the hock. With the
/// knee alone told, hip and hock do not settle the foot's place where the leg below the hip is in line with that below the hock, which a step passes.
#[test]
fn legs_with_hocks_are_told_by_what_bends_them_apart() {
    let folder = begun("ostrich");
    let form = read(&folder.join("gaits/form.toml"));
    let counts: Vec<usize> =
        form.split("[[phase]]").skip(1).map(|phase| phase.matches("[[phase.output]]").count()).collect();
    // N − M − 1 of 11 coordinates and 3, 2, 4 and 5 rows of contacts.
    assert_eq!(counts, [7, 8, 6, 5], "{form}");
    for leg in ["left", "right"] {
        let apart = format!("controlled = \"{leg}_knee + {leg}_hock\"");
        assert_eq!(form.matches(&apart).count(), 2, "{form}");
    }
}

/// Legs that slide: in the plane as well, paired, and the direction from foot to hip is that of the hip alone, however long the leg is.
#[test]
fn telescopic_legs_have_a_form() {
    let folder = begun("heron");
    let described = read(&folder.join("biped.toml"));
    for words in ["kind = \"planar\"", "left = \"left_slide\", right = \"right_slide\", sign = 1"] {
        assert!(described.contains(words), "no `{words}` in {described}");
    }
    let form = read(&folder.join("gaits/form.toml"));
    assert!(form.contains("variable = \"base_pitch + right_hip\""), "{form}");
    assert!(form.contains("unit = \"m\"\ncontrolled = \"left_slide\""), "{form}");
}

#[test]
#[ignore = "takes long"]
fn a_robot_with_telescopic_legs_walks_from_its_urdf() {
    walks("heron", "0.5", &[]);
}

/// Limits of a pair that no position keeps are told at once, with both joints, their limits and what to do: searches ended after minutes.
#[test]
fn limits_of_a_pair_that_contradict_each_other_are_refused() {
    let folder = begun("heron");
    let urdf = folder.join("robot.urdf");
    let text_of = read(&urdf);
    let (left, right) = text_of.split_once("<joint name=\"right_slide\"").unwrap();
    let right = right.replacen("lower=\"-0.02\" upper=\"0.2\"", "lower=\"-0.3\" upper=\"-0.1\"", 1);
    std::fs::write(&urdf, format!("{left}<joint name=\"right_slide\"{right}")).unwrap();
    let out = folder.join("gaits/refused.toml");
    let asked = ["gait", "optimise", text(&folder), "--gait", "form", "--speed", "0.5", "--out", text(&out)];
    let told =
        bipedc(&asked).fails_with(&["`left_slide` has -0.02 to 0.2 m", "`right_slide` has -0.3 to -0.1 m"]);
    assert!(told.err.contains("robot.urdf:") && told.err.contains("help: "), "{}", told.err);
}

/// As a new user would go on; twenty steps with all assumptions checked.
fn walks(name: &str, speed: &str, form: &[&str]) {
    let folder = begun(name);
    let out = folder.join("gaits").join("form.toml");
    bipedc(&[&["gait", "new", text(&folder), "--out", text(&out), "--force"], form].concat()).ok();
    let gait = folder.join("gaits").join("walk.toml");
    let asked = [
        "gait",
        "optimise",
        text(&folder),
        "--gait",
        "form",
        "--speed",
        speed,
        "--out",
        text(&gait),
        "--json",
    ];
    let found = bipedc(&asked).ok().json();
    let walked = &found["gaits"][0]["closed_loop"];
    let wished: f64 = speed.parse().unwrap();
    assert!((walked["walking_speed"].as_f64().unwrap() / wished - 1.0).abs() < 0.01, "{found}");
    let cycle = bipedc(&["gait", "cycle", text(&folder), "--gait", text(&gait), "--json"]).ok().json();
    for key in ["speed", "multiplier", "cost_of_transport"] {
        let (tried, cycle) =
            (walked[key].as_f64().unwrap(), cycle["cycles"][0]["cycle"][key].as_f64().unwrap());
        assert!((tried / cycle - 1.0).abs() < 1e-3, "{key} {tried} {cycle}");
    }
    let scenario = folder.join("walk.toml");
    let mid_stance = walked["speed"].as_f64().unwrap();
    let words = format!(
        "method = \"event_driven\"\nduration = 60.0\nsteps = 20\nlog_step = 0.005\n[assumptions]\nfriction = 0.6\n[initial]\n\
         mid_stance_speed = {mid_stance}\n[control]\ngait = \"{}\"\n",
        text(&gait)
    );
    std::fs::write(&scenario, words).unwrap();
    let log = folder.join("run.csv");
    let run =
        bipedc(&["simulate", text(&folder), "--scenario", text(&scenario), "--out", text(&log), "--json"]);
    let run = run.ok().json();
    assert_eq!((run["steps"].as_u64(), run["verdict"].is_null()), (Some(20), true), "{run}");
}

#[test]
#[ignore = "takes long"]
fn a_robot_on_points_walks_from_its_urdf() {
    walks("bird", "0.6", &[]);
}

/// 2 kg and 0.3 m from the hips to the ground, in four phases.
#[test]
#[ignore = "takes long"]
fn a_small_robot_with_feet_walks_from_its_urdf() {
    walks("mouse", "0.34", &[]);
}

#[test]
#[ignore = "takes long"]
fn a_robot_of_nine_joints_with_feet_walks_from_its_urdf() {
    walks("human", "0.6", &["--knees"]);
}

/// 8 kg and 0.35 m, knees that bend backwards and are never straight: from feet on straight lines the rear toe cannot be pushed as the front toe lands, so that a first
/// search ends there; the second begins at a posture in which it can.
#[test]
#[ignore = "takes long"]
fn a_robot_with_knees_of_a_bird_walks_from_its_urdf() {
    walks("stork", "0.371", &[]);
}

/// 20 kg and 0.6 m, with hocks.
#[test]
#[ignore = "takes long"]
fn a_robot_with_hocks_and_with_knees_of_a_bird_walks_from_its_urdf() {
    walks("ostrich", "0.485", &[]);
}

/// A trunk, a neck and legs on points with long shanks; joints called `pi` and `phi`, the base `base_x`, sides of a ship.
#[test]
fn a_robot_with_odd_names_walks_from_its_urdf() {
    walks("stilt", "0.49", &[]);
}

/// A trunk, a head and a tail, soles, names with dots. The walk has little room: near its own speed alone limits let its outputs be met.
#[test]
#[ignore = "takes long"]
fn a_robot_with_a_tail_and_a_neck_walks_from_its_urdf() {
    walks("theropod", "0.51", &[]);
}

/// Joints without limits of any kind (`continuous`), soles on fixed links: which way knees bend is told by nothing.
#[test]
#[ignore = "takes long"]
fn a_robot_without_limits_walks_from_its_urdf() {
    walks("limitless", "0.48", &[]);
}
