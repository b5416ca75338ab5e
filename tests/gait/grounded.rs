//! A step of one phase whose controller keeps to limits of the ground: the phase ends at a φ instead of by a guard.
use super::robot;
use crate::cli::{Run, bipedc, scratch, text};
use bipedc::gait::PhasedBench;
use bipedc::progress::Silent;
use serde_json::Value;
use std::path::Path;

const FIVE_LINK: &str = "robots/five_link";

fn shipped(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(FIVE_LINK).join(path)).unwrap()
}

fn step(gait: &str) -> Value {
    bipedc(&["gait", "step", FIVE_LINK, "--gait", gait, "--speed", "0.8", "--json"]).ok().json()
}

/// Of the whole robot on its constraint surface nothing depends on how the end of a step is written.
#[test]
fn the_step_is_that_of_the_same_motion_with_a_guard() {
    let [grounded, guarded] = ["grounded", "collocated"].map(step);
    let agree = |pick: &dyn Fn(&Value) -> &Value, within: f64| {
        let [a, b] = [&grounded, &guarded].map(|found| pick(found).as_f64().unwrap());
        assert!((a - b).abs() < within * b.abs(), "{a} {b}");
    };
    agree(&|found| &found["next_speed"], 1e-7);
    agree(&|found| &found["delta"], 1e-6);
    agree(&|found| &found["phi_m"], 1e-5);
    for margin in ["impact_pull", "joint"] {
        agree(&|found| &found["margins"][margin], 0.02);
    }
    assert_eq!(grounded["feasible"], true, "{grounded}");
}

/// The shipped scenario, or the same with another gait beside it.
fn walk(name: &str, gait: Option<&str>) -> Run {
    let folder = scratch(name);
    let (file, log) = (folder.join("scenario.toml"), folder.join("run.csv"));
    let mut scenario = shipped("scenarios/grounded.toml");
    if let Some(gait) = gait {
        std::fs::write(folder.join("other.toml"), gait).unwrap();
        let other = text(&folder.join("other.toml")).to_owned();
        scenario = scenario.replace("\"grounded\"", &format!("\"{other}\""));
    }
    std::fs::write(&file, scenario).unwrap();
    bipedc(&["simulate", FIVE_LINK, "--scenario", text(&file), "--out", text(&log), "--json"])
}

/// At 0.9 rad/s outputs ask for friction of 0.427 within the step, the impact for 0.423.
#[test]
fn outputs_give_way_where_friction_does_not_suffice() {
    let held = walk("grounded-held", None).ok().json();
    assert_eq!(held["verdict"], Value::Null, "{held}");
    assert!(held["steps"].as_u64().unwrap() >= 8, "{held}");
    let guarded = shipped("gaits/collocated.toml").replace("friction = 0.6", "friction = 0.425");
    let slipped = walk("grounded-slipped", Some(&guarded)).json();
    assert_eq!(slipped["steps"], 0, "{slipped}");
    assert!(slipped["verdict"].to_string().contains("slip"), "{slipped}");
}

#[test]
fn a_phase_ends_by_one_of_both() {
    let text = shipped("gaits/grounded.toml");
    let refused = |text: &str| {
        let read = PhasedBench::parse(&robot(FIVE_LINK), Path::new("changed.toml"), text, &Silent);
        read.map(|_| ()).unwrap_err().to_string()
    };
    let end = text.lines().find(|line| line.starts_with("end = ")).unwrap();
    let both = format!("{end}\nguard = {{ zero = \"left_foot_point_foot_z\", between = [0.1, 0.4] }}");
    let line = 1 + text.lines().position(|line| line == end).unwrap();
    let said = refused(&text.replace(end, &both));
    assert!(said.contains("a `guard` and an `end`") && said.contains(&format!(":{line}:")), "{said}");
    let said = refused(&text.replace(end, ""));
    assert!(said.contains("no `guard`, and no `end`"), "{said}");
}

/// From a bare form to steps.
#[test]
fn a_form_becomes_a_gait_that_keeps_to_the_ground() {
    let folder = scratch("grounded-form");
    let (form, gait) = (folder.join("form.toml"), folder.join("found.toml"));
    bipedc(&["gait", "new", FIVE_LINK, "--grounded", "--out", text(&form)]).ok();
    let found = bipedc(&[
        "gait",
        "optimise",
        FIVE_LINK,
        "--gait",
        text(&form),
        "--speed",
        "0.7",
        "--out",
        text(&gait),
        "--json",
    ]);
    let found = found.ok().json();
    let written = std::fs::read_to_string(&gait).unwrap();
    assert!(written.contains("\nend = ") && !written.contains("guard"), "{written}");
    let walked = &found["gaits"][0]["closed_loop"];
    let speed = walked["walking_speed"].as_f64().unwrap();
    assert!(walked["walks"] == true && (speed - 0.7).abs() < 0.01, "{walked}");
}

/// A step of one phase on a whole sole: `gait new` writes a form that ends at a φ, and one with a guard is told so, without asking for more outputs.
#[test]
fn a_step_on_a_sole_ends_at_a_place_of_the_phase_variable() {
    let folder = scratch("grounded-sole");
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/seven_link_v1");
    std::fs::copy(robot.join("robot.urdf"), folder.join("robot.urdf")).unwrap();
    let described = std::fs::read_to_string(robot.join("biped.toml")).unwrap();
    let (before, _) = described.split_once("[[phase]]").unwrap();
    let flat =
        "[[phase]]\nname = \"flat\"\ncontacts = [\"right_foot\"]\nimpact = [\"left_foot\"]\nrelabel = true\n";
    std::fs::write(folder.join("biped.toml"), format!("{before}{flat}")).unwrap();
    let form = folder.join("form.toml");
    bipedc(&["gait", "new", text(&folder), "--out", text(&form)]).ok();
    let written = std::fs::read_to_string(&form).unwrap();
    assert!(written.contains("\nend = ") && !written.contains("guard"), "{written}");
    let end = written.lines().find(|line| line.starts_with("end = ")).unwrap();
    let guard = "guard = { zero = \"left_foot_toe_z - right_foot_toe_z\", between = [0.1, 0.4] }";
    std::fs::write(&form, written.replace(end, guard)).unwrap();
    let step = ["gait", "step", text(&folder), "--gait", text(&form), "--speed", "0.8"];
    let run = bipedc(&step).fails_with(&["does not stand on one point", "`end` instead of `guard`"]);
    assert!(!run.err.contains("outputs for"), "{}", run.err);
}
