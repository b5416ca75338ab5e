//! What touches the ground, what a log holds of it, and how a fall is told.
use super::{scratch, simulate};
use crate::cli::{bipedc, text};
use std::path::Path;

const FALL: &str = "duration = 2.0
log_step = 0.005
[control]
stiffness = 300.0
damping = 10.0
servo = \"drive\"
[initial]
base_rotation = [0.0, 0.3, 0.0]
";

/// Two columns of a log.
fn last(log: &Path, column: &str) -> f64 {
    let text = std::fs::read_to_string(log).unwrap();
    let index = text.lines().next().unwrap().split(',').position(|name| name == column).unwrap();
    text.lines().last().unwrap().split(',').nth(index).unwrap().parse().unwrap()
}

#[test]
fn a_log_holds_all_that_a_comparison_needs() {
    let folder = scratch("simulate_wrench");
    let turning = "duration = 2.0\nlog_step = 0.002\n[control]\nstiffness = 300.0\ndamping = 10.0\nservo = \"drive\"\n\
                   [joint.left_hip_yaw]\nsines = [[0.05, 0.7, 0.3]]\n";
    simulate("robots/tulip", &folder, "turn", turning, &[]).ok();
    let compared = bipedc(&["compare", "robots/tulip", text(&folder.join("turn.csv")), "--json"]).ok();
    let said = compared.json();
    let rows = said["channels"].as_array().unwrap();
    for name in ["left_hip_yaw", "right_hip_yaw", "base/moment/z"] {
        let row = rows.iter().find(|row| row["name"] == name);
        let row = row.unwrap_or_else(|| panic!("no row {name}: {said}"));
        let error = row["rms"].as_f64().unwrap();
        assert!(error < 5e-3, "{name}: {error} N m");
    }
    assert!(!said["assumptions"].to_string().contains("torque"), "{said}");
}

#[test]
fn a_fall_lies_on_the_ground_with_shapes_and_is_told_without() {
    let folder = scratch("simulate_fall");
    let json = simulate("robots/tulip", &folder, "feet", FALL, &["--json"]).ok().json();
    assert_eq!(json["fall"]["cause"], "lean", "{json}");
    let told = json["fall"]["time"].as_f64().unwrap();
    assert!(told > 0.2 && told < 1.0, "{told}");

    let shapes = format!("{FALL}[ground]\nshapes = true\n");
    let run = simulate("robots/tulip", &folder, "shapes", &shapes, &[]).ok();
    assert!(run.out.contains("the robot fell at "), "{}", run.out);
    let low = last(&folder.join("feet.csv"), "base/position/z");
    let lies = last(&folder.join("shapes.csv"), "base/position/z");
    assert!(low < -0.05 && lies > 0.03, "{low} m without shapes, {lies} m with them");

    let stands = FALL.replace("0.3", "0.0").replace("2.0", "0.2");
    assert!(simulate("robots/tulip", &folder, "stands", &stands, &["--json"]).ok().json()["fall"].is_null());
    let run =
        simulate("robots/tulip", &folder, "none", &format!("{FALL}[ground]\nshapes = [\"tors\"]\n"), &[]);
    assert!(run.err.contains("did you mean `torso`?") && run.err.contains("none.toml:10:"), "{}", run.err);
}

#[test]
fn all_mistakes_of_a_scenario_are_told_together() {
    let folder = scratch("simulate_mistakes_together");
    let scenario = "duration = -4.0
step = 0.001
log_stepp = 0.005
[control]
stiffnes = 300.0
damping = \"x\"
[joint.left_kne_pitch]
position = 0.3
[grund]
friction = 0.3
[ground]
friction = -1
[[push]]
impulse = \"much\"
[[effect]]
kind = \"coulomb_frictio\"
joint = \"left_knee_pitch\"
torque = 1
[[effect]]
kind = \"coulomb_friction\"
joint = \"left_knee\"
torqe = 1
";
    let run = simulate("robots/tulip", &folder, "bads", scenario, &[]);
    let places =
        ["1:12", "3:1", "5:1", "6:11", "7:", "9:2", "12:12", "13:1", "14:11", "15:1", "21:9", "22:9"];
    for place in places {
        assert!(run.err.contains(&format!("bads.toml:{place}")), "nothing at {place}: {}", run.err);
    }
    assert_eq!(run.err.matches("error: ").count(), places.len(), "{}", run.err);
    for help in ["did you mean `log_step`?", "did you mean `stiffness`?", "did you mean `ground`?"] {
        assert!(run.err.contains(help), "{}", run.err);
    }
}
