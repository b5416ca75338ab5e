//! What the ground gives is what the motion takes: logs without noise are missed by next to nothing.
use crate::cli::{bipedc, scratch, text};
use serde_json::Value;

/// TUlip sways and bends its knees under stiff servos, with its feet on the ground; its hip yaws twist the soles against each other.
const SWAY: &str = "duration = 3.0
log_step = 0.001
[control]
stiffness = 6000.0
damping = 30.0
servo = \"drive\"
[joint]
right_hip_yaw = { reference = 0.0, points = [[0.0, 0.0], [0.8, 0.01], [3.0, 0.01]] }
right_hip_roll = { points = [[0.0, 0.0], [0.8, 0.12], [2.2, -0.1], [3.0, 0.0]] }
left_hip_roll = { points = [[0.0, 0.0], [0.8, 0.12], [2.2, -0.1], [3.0, 0.0]] }
right_ankle_roll = { points = [[0.0, 0.0], [0.8, -0.12], [2.2, 0.1], [3.0, 0.0]] }
left_ankle_roll = { points = [[0.0, 0.0], [0.8, -0.12], [2.2, 0.1], [3.0, 0.0]] }
right_hip_pitch = { position = -0.25, points = [[0.0, -0.25], [1.5, -0.35], [3.0, -0.25]] }
left_hip_pitch = { position = -0.25, points = [[0.0, -0.25], [1.5, -0.35], [3.0, -0.25]] }
right_knee_pitch = { position = 0.5, points = [[0.0, 0.5], [1.5, 0.7], [3.0, 0.5]] }
left_knee_pitch = { position = 0.5, points = [[0.0, 0.5], [1.5, 0.7], [3.0, 0.5]] }
right_ankle_pitch = { position = -0.25, points = [[0.0, -0.25], [1.5, -0.35], [3.0, -0.25]] }
left_ankle_pitch = { position = -0.25, points = [[0.0, -0.25], [1.5, -0.35], [3.0, -0.25]] }
";

/// The error of a row, if it is compared.
fn missed(compared: &Value, name: &str) -> Option<f64> {
    let channels = compared["channels"].as_array().unwrap();
    channels.iter().find(|row| row["name"] == name).map(|row| row["rms"].as_f64().unwrap())
}

/// A log without the columns whose names have this in them.
fn without(log: &str, part: &str) -> String {
    let kept: Vec<bool> = log.lines().next().unwrap().split(',').map(|name| !name.contains(part)).collect();
    let line = |line: &str| {
        let fields = line.split(',').zip(&kept).filter(|(_, kept)| **kept).map(|(field, _)| field);
        fields.collect::<Vec<_>>().join(",") + "\n"
    };
    log.lines().map(line).collect()
}

#[test]
fn a_clean_log_on_two_feet_is_missed_by_next_to_nothing() {
    let folder = scratch("carried");
    let [file, log] = ["scenario.toml", "log.csv"].map(|name| folder.join(name));
    std::fs::write(&file, SWAY).unwrap();
    bipedc(&["simulate", "robots/tulip", "--scenario", text(&file), "--out", text(&log)]).ok();
    // With the moments on the feet all joints are compared.
    let whole = bipedc(&["compare", "robots/tulip", text(&log), "--json"]).ok().json();
    for joint in ["right_hip_yaw", "left_hip_yaw", "right_hip_pitch", "left_hip_pitch"] {
        let error = missed(&whole, joint).unwrap();
        assert!(error < 0.01, "{joint}: {error} N m");
    }
    // Without them one joint of each leg tells the moment about the vertical, and the others go without it.
    let rest = without(&std::fs::read_to_string(&log).unwrap(), "_foot/torque/");
    std::fs::write(&log, rest).unwrap();
    let compared = bipedc(&["compare", "robots/tulip", text(&log), "--json"]).ok().json();
    let missed = |name: &str| missed(&compared, name);
    // Of 186 N; 0.2 N when the Coriolis forces of a step were those of feet without the ground below them.
    let force = missed("base/force/z").unwrap();
    assert!(force < 0.002, "{force} N");
    // The soles twist against each other, which pitch joints of leaning legs feel by 0.4 N m; no column says it.
    for side in ["right", "left"] {
        for (joint, most) in [("ankle_pitch", 0.003), ("knee_pitch", 0.01), ("hip_pitch", 0.01)] {
            let error = missed(&format!("{side}_{joint}")).unwrap();
            assert!(error < most, "{side}_{joint}: {error} N m");
        }
        let told =
            |text: &Value| text.as_str().unwrap().contains(&format!("`{side}_hip_yaw` is not compared"));
        assert!(compared["assumptions"].as_array().unwrap().iter().any(told), "{}", compared["assumptions"]);
        assert_eq!(missed(&format!("{side}_hip_yaw")), None);
    }
}
