//! `bipedc gait step`.
use crate::cli::{bipedc, scratch, text};
use serde_json::Value;

fn step(arguments: &[&str]) -> Vec<String> {
    let fixed = ["gait", "step", "robots/three_link", "--gait", "thesis"];
    fixed.iter().chain(arguments).map(|x| (*x).to_owned()).collect()
}

fn run(arguments: &[&str]) -> crate::cli::Run {
    let arguments = step(arguments);
    bipedc(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn the_keys_of_a_step() {
    let found = run(&["--speed", "1.5", "--json"]).ok();
    assert_eq!(found.err, "");
    let json = found.json();
    let numbers = ["next_speed", "delta", "p_minus", "p_max", "phi_m", "limit_speed"];
    assert!(numbers.iter().all(|key| json[key].is_f64()), "{json}");
    assert_eq!((&json["feasible"], &json["reason"]), (&Value::Bool(true), &Value::Null));
    let margins = json["margins"].as_object().unwrap();
    assert!(
        ["friction", "pull", "clearance", "torque", "joint", "velocity"]
            .iter()
            .all(|key| margins[*key].is_f64()),
        "{json}"
    );
    assert_eq!(margins["zmp"], Value::Null);
}

/// A foot that is about to be let go carries next to nothing: its quotient of forces was 0.97 or 0.49, whichever instant was looked at, and simulations let it
/// pass.
#[test]
fn a_foot_that_is_let_go_takes_no_margin() {
    for speed in ["0.40", "0.447938", "0.4479381", "0.45"] {
        let gait = ["robots/seven_link_v1", "--gait", "from_nothing", "--speed", speed, "--json"];
        let found = bipedc(&[&["gait", "step"], &gait[..]].concat()).ok().json();
        let friction = found["margins"]["friction"].as_f64().unwrap();
        assert!((0.1..0.14).contains(&friction), "{friction} at {speed} m/s");
    }
}

/// The heel of a foot that rolls over its toe is no foot in the air: the search of this gait saw 11.9 mm at its nodes.
#[test]
fn clearance_is_that_of_feet_in_the_air() {
    let gait = ["robots/seven_link_v1", "--gait", "from_nothing", "--speed", "0.4479381", "--json"];
    let found = bipedc(&[&["gait", "step"], &gait[..]].concat()).ok().json();
    let clearance = found["margins"]["clearance"].as_f64().unwrap();
    assert!((clearance - 0.0119).abs() < 3e-4, "{clearance}");
}

#[test]
fn parameters_are_set_for_both_steps_or_for_the_first() {
    let speed = |arguments: &[&str]| run(arguments).ok().json()["next_speed"].as_f64().unwrap();
    let own = speed(&["--speed", "1.5", "--json"]);
    assert_eq!(own, speed(&["--speed", "1.5", "--json", "--set", "step_length=0.5"]));
    let longer = speed(&["--speed", "1.5", "--json", "--set", "step_length=0.6"]);
    let only_the_next =
        speed(&["--speed", "1.5", "--json", "--set", "step_length=0.6", "--from", "step_length=0.5"]);
    assert!(longer != own && only_the_next != longer, "{own} {longer} {only_the_next}");
    // Leaning forward is faster (negative here).
    assert!(speed(&["--speed", "1.5", "--json", "--set", "torso_lean=-0.7"]) > own);
}

#[test]
fn an_infeasible_step_has_every_number_that_exists() {
    let found = run(&["--speed", "0.1", "--set", "torso_lean=0.3", "--json"]).ok().json();
    assert_eq!((&found["feasible"], &found["next_speed"]), (&Value::Bool(false), &Value::Null));
    assert!(found["reason"].as_str().unwrap().contains("falls back"), "{found}");
    for key in ["delta", "p_minus", "p_max", "phi_m", "energy", "next_energy"] {
        assert!(found[key].is_f64(), "{key}: {found}");
    }
    assert!(found["margins"]["clearance"].is_f64() && found["margins"]["pull"].is_null(), "{found}");
    let unreachable = run(&["--speed", "1.5", "--set", "step_length=2.5", "--json"]).ok();
    let json = unreachable.json();
    assert!(json["reason"].as_str().unwrap().contains("guard"), "{json}");
    assert!(json["delta"].is_null() && json["feasible"] == false, "{json}");
    assert!(
        unreachable.err.contains("warning: `step_length` = 2.5 m lies outside its bounds"),
        "{}",
        unreachable.err
    );
}

#[test]
fn a_table_has_units() {
    let found = run(&["--speed", "1.5", "--from", "step_length=0.4"]).ok().out;
    for words in
        ["this step", "next step", "rad/s", "(kg m²/s)²", "N m", "torso_lean", "passes its dead centre"]
    {
        assert!(found.contains(words), "no `{words}` in {found}");
    }
    let found = run(&["--speed", "0.1", "--set", "torso_lean=0.3"]).ok().out;
    assert!(found.contains("not possible: the robot falls back"), "{found}");
}

#[test]
fn wrong_use_is_named() {
    run(&["--speed", "1.5", "--set", "step_lenght=0.4"])
        .fails_with(&["step_lenght", "did you mean `step_length`?"]);
    run(&["--speed", "-1"]).fails_with(&["a speed of -1 is not possible"]);
    run(&["--speed", "1.5", "--set", "step_length=1e300"]).fails_with(&["is not possible", "number in m"]);
    let twice = ["--speed", "1", "--set", "step_length=0.4", "--set", "step_length=0.5"];
    bipedc(&[&["gait", "step", "robots/three_link", "--gait", "thesis"], &twice[..]].concat())
        .fails_with(&["`step_length` is set twice", "leave one of them out"]);
    bipedc(&["gait", "step", "robots/three_link", "--gait", "thesys", "--speed", "1"])
        .fails_with(&["no gait `thesys`", "did you mean `thesis`?"]);
    bipedc(&["gait", "step", "robots/tulip", "--gait", "thesis", "--speed", "1"])
        .fails_with(&["no gait `thesis`"]);
    for wrong in ["step_length", "step_length=x", "step_length=inf"] {
        assert_eq!(run(&["--speed", "1.5", "--set", wrong]).code, Some(2), "{wrong}");
    }
}

/// A joint that is faster than its URDF allows: a margin of steps of one phase and of several, in rad/s; the limit alone moves it.
#[test]
fn velocity_limits_are_a_margin() {
    let slower = |robot: &str, gait: &str| {
        let folder = scratch(&format!("slower-{gait}"));
        std::fs::create_dir_all(folder.join("gaits")).unwrap();
        for file in ["robot.urdf", "biped.toml", &format!("gaits/{gait}.toml")] {
            let words = std::fs::read_to_string(format!("robots/{robot}/{file}")).unwrap();
            std::fs::write(folder.join(file), words.replace("velocity=\"10\"", "velocity=\"1.5\"")).unwrap();
        }
        folder
    };
    for (robot, gait, speed) in
        [("three_link", "thesis", "1.5"), ("seven_link_v1", "from_nothing", "0.4479381")]
    {
        let margin = |folder: &str| {
            let asked = ["gait", "step", folder, "--gait", gait, "--speed", speed, "--json"];
            bipedc(&asked).ok().json()["margins"]["velocity"].as_f64().unwrap()
        };
        let [usual, less] = [margin(&format!("robots/{robot}")), margin(text(&slower(robot, gait)))];
        assert!(usual > 0.0 && less < 0.0 && (usual - less - 8.5).abs() < 1e-9, "{robot}: {usual} {less}");
    }
}

/// A simulation does not keep velocity limits, and says which joint is beyond its own, when and by how much.
#[test]
fn a_walk_says_which_joint_is_too_fast() {
    let folder = scratch("too-fast");
    std::fs::create_dir_all(folder.join("gaits")).unwrap();
    for file in ["robot.urdf", "biped.toml", "gaits/thesis.toml"] {
        let words = std::fs::read_to_string(format!("robots/three_link/{file}")).unwrap();
        std::fs::write(folder.join(file), words.replace("velocity=\"10\"", "velocity=\"1.5\"")).unwrap();
    }
    let scenario = folder.join("walk.toml");
    let words = "method = \"event_driven\"\nduration = 2.0\nsteps = 1\nlog_step = 0.005\n[assumptions]\nfriction = false\nscuffing = false\n\
                 step_length = \"gait\"\n[initial]\nmid_stance_speed = 1.5\n[control]\ngait = \"thesis\"\n";
    std::fs::write(&scenario, words).unwrap();
    let log = folder.join("run.csv");
    let asked = ["simulate", text(&folder), "--scenario", text(&scenario), "--out", text(&log), "--json"];
    let found = bipedc(&asked).ok();
    assert!(found.err.contains("faster than its limit of 1.5 rad/s"), "{}", found.err);
    let velocity = &found.json()["velocity"];
    let of = |key: &str| velocity[key].as_f64().unwrap();
    assert!(of("margin") < 0.0 && (of("limit") - of("speed") - of("margin")).abs() < 1e-12, "{velocity}");
    assert!(velocity["joint"].as_str().unwrap().ends_with("hip_pitch"), "{velocity}");
    // Without anything that says where the robot begins that is what is missing, not a joint's stop.
    std::fs::write(&scenario, words.replace("mid_stance_speed = 1.5", "")).unwrap();
    bipedc(&asked).fails_with(&["nothing says where the robot begins", "mid_stance_speed = ", ":12:8"]);
}
