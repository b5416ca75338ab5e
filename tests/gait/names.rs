//! Names of robots and gaits that mean something else elsewhere.
use crate::cli::{bipedc, scratch, text};
use std::fs;
use std::path::{Path, PathBuf};

/// A robot in a folder of its own, its files changed.
fn copy(name: &str, robot: &str, change: impl Fn(String) -> String) -> PathBuf {
    let (folder, from) = (scratch(name), Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot));
    fs::create_dir_all(folder.join("gaits")).unwrap();
    for file in ["robot.urdf", "biped.toml", "gaits/thesis.toml"] {
        fs::write(folder.join(file), change(fs::read_to_string(from.join(file)).unwrap())).unwrap();
    }
    folder
}

/// Files of a library are called by their speed; no type begins with a digit.
#[test]
fn a_gait_named_by_a_number_becomes_code() {
    let robot = copy("named_by_a_number", "three_link", |text| text);
    fs::copy(robot.join("gaits/thesis.toml"), robot.join("gaits/0.443.toml")).unwrap();
    let out = robot.join("code");
    bipedc(&["generate", text(&robot), "--gait", "0.443", "--out", text(&out)]).ok();
    let module = fs::read_dir(out.join("src")).unwrap().flatten().map(|entry| entry.path());
    let module = module.into_iter().find(|path| path.to_string_lossy().contains("gait_")).unwrap();
    assert!(fs::read_to_string(&module).unwrap().contains("pub struct N0443Gait"), "{}", module.display());
}

#[test]
fn joints_may_be_called_as_other_things() {
    let step = |robot: &Path| {
        let found = bipedc(&["gait", "step", text(robot), "--gait", "thesis", "--speed", "1.2", "--json"]);
        found.ok().json()["next_speed"].as_f64().unwrap()
    };
    let known = step(&copy("called_as_ever", "three_link", |text| text));
    for name in ["pi", "phase", "sin", "base_x"] {
        let change = |text: String| {
            let in_formulas = text.contains("[[phase.output]]");
            text.replace(
                "right_hip_pitch",
                &if in_formulas { format!("joint_{name}") } else { name.to_owned() },
            )
        };
        let robot = copy(&format!("called_{name}"), "three_link", change);
        assert_eq!(step(&robot).to_bits(), known.to_bits(), "{name}");
        // Called by its own name, where that says something else.
        if ["phase", "sin"].contains(&name) {
            let gait = robot.join("gaits/thesis.toml");
            let wrong = fs::read_to_string(&gait).unwrap().replace(&format!("joint_{name}"), name);
            let file = robot.join("gaits/wrong.toml");
            fs::write(&file, wrong).unwrap();
            let asked = ["gait", "step", text(&robot), "--gait", "wrong", "--speed", "1.2"];
            bipedc(&asked).fails_with(&[&format!("the joint of that name is called `joint_{name}`")]);
        }
        let form = robot.join("form.toml");
        bipedc(&["gait", "new", text(&robot), "--out", text(&form)]).ok();
        let written = fs::read_to_string(&form).unwrap();
        assert!(written.contains(&format!("controlled = \"joint_{name}\"")), "{written}");
    }
}

#[test]
fn pictures_and_logs_replace_no_gait() {
    let robot = copy("replaced", "three_link", |text| text);
    let gait = robot.join("gaits/other.toml");
    fs::copy(robot.join("gaits/thesis.toml"), &gait).unwrap();
    let before = fs::read(&gait).unwrap();
    let ask = ["gait", "capture", text(&robot), "--gait", "thesis", "--speed", "1", "--svg", text(&gait)];
    bipedc(&ask).fails_with(&["would replace a file that people write"]);
    assert_eq!(fs::read(&gait).unwrap(), before);
}

#[test]
fn sides_are_told_by_other_words_too() {
    for (left, right) in [("lt", "rt"), ("li", "re"), ("port", "starboard")] {
        let words =
            |text: String| text.replace("left_", &format!("{left}_")).replace("right_", &format!("{right}_"));
        let robot = copy(&format!("sides_{left}"), "five_link", words);
        fs::remove_file(robot.join("biped.toml")).unwrap();
        bipedc(&["init", text(&robot.join("robot.urdf"))]).ok();
        let written = fs::read_to_string(robot.join("biped.toml")).unwrap();
        let foot = format!("[feet.left_foot]\nlink = \"{left}_");
        assert!(
            written.contains(&foot) && written.contains(&format!("left = \"{left}_hip_pitch\"")),
            "{written}"
        );
    }
}

/// The robot on points of `tests/data/planar` with other names for its joints: described, with a form.
fn renamed(name: &str, joints: &[(&str, &str)]) -> PathBuf {
    let folder = scratch(name);
    let words = fs::read_to_string("tests/data/planar/stilt.urdf").unwrap();
    let words = joints.iter().fold(words, |text, (from, to)| {
        text.replace(&format!("joint name=\"{from}\""), &format!("joint name=\"{to}\""))
    });
    fs::write(folder.join("robot.urdf"), words).unwrap();
    bipedc(&["init", text(&folder.join("robot.urdf")), "--force"]).ok();
    let form = folder.join("gaits/form.toml");
    bipedc(&["gait", "new", text(&folder), "--out", text(&form), "--force"]).ok();
    folder
}

fn form_of(robot: &Path) -> String {
    fs::read_to_string(robot.join("gaits/form.toml")).unwrap()
}

/// Names in other letters stay; of those that are one word with `_` for what is no letter all but one are numbered.
#[test]
fn no_two_joints_have_one_name_in_formulas() {
    let other = renamed(
        "called_in_chinese",
        &[("port_1", "左髋"), ("starboard_1", "右髋"), ("pi", "腰"), ("phi", "颈")],
    );
    let form = form_of(&other);
    assert!(form.contains("variable = \"base_pitch + 右髋 + 0.65 * starboard_2\""), "{form}");
    for joint in ["左髋", "腰", "颈"] {
        assert!(form.contains(&format!("controlled = \"{joint}\"")), "{form}");
    }
    let same = renamed(
        "called_alike",
        &[("port_1", "hip.a"), ("starboard_1", "hip-a"), ("pi", "left_foot_point_foot_x")],
    );
    let form = form_of(&same);
    for joint in ["hip_a_2", "hip_a", "joint_left_foot_point_foot_x"] {
        assert!(form.contains(&format!("controlled = \"{joint}\"")), "{form}");
    }
    assert!(form.contains("variable = \"base_pitch + hip_a + 0.65 * starboard_2\""), "{form}");
}

/// A word that is both a joint and something else is told, where a file never calls the joint as formulas do.
#[test]
fn a_joint_that_is_also_a_number_is_not_mistaken_for_it() {
    let robot = renamed("called_pi", &[("phi", "base_pitch_")]);
    let step = |gait: &Path| bipedc(&["gait", "step", text(&robot), "--gait", text(gait), "--speed", "0.6"]);
    let form = form_of(&robot);
    let gait = robot.join("gaits/mistaken.toml");
    fs::write(&gait, form.replace("controlled = \"joint_pi\"", "controlled = \"0.5 * pi\"")).unwrap();
    step(&gait).fails_with(&["`pi` is both a number of formulas and a joint", "`joint_pi`", "3.14159"]);
    // Who calls the joint by its name knows the difference.
    fs::write(&gait, form.replace("controlled = \"joint_pi\"", "controlled = \"joint_pi + 0.001 * pi\""))
        .unwrap();
    let known = step(&gait);
    assert!(!known.err.contains("`pi`"), "{}", known.err);
}

#[test]
fn a_coordinate_that_is_also_a_joint_is_warned_of() {
    let robot = renamed("called_base_z", &[("port_2", "base_z"), ("starboard_2", "base_knee")]);
    let form = form_of(&robot);
    assert!(form.contains("controlled = \"joint_base_z\""), "{form}");
    let gait = robot.join("gaits/mistaken.toml");
    let wrong = form
        .replace("controlled = \"joint_base_z\"", "controlled = \"left_foot_point_foot_z - base_z\"")
        .replace("name = \"joint_base_z\"\nunit = \"rad\"", "name = \"swing_foot\"\nunit = \"m\"")
        .replace(
            "\n\n[[phase.output]]\nname = \"joint_pi\"",
            "\nposture = { base_z = 0.6 }\n\n[[phase.output]]\nname = \"joint_pi\"",
        );
    fs::write(&gait, wrong).unwrap();
    let told = bipedc(&["gait", "step", text(&robot), "--gait", text(&gait), "--speed", "0.6"]);
    let words =
        ["`base_z` is here a coordinate of the base", "mistaken.toml:", "called `joint_base_z` there"];
    assert!(words.iter().all(|words| told.err.contains(words)), "{}", told.err);
}
