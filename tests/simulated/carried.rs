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

#[test]
fn a_clean_log_on_two_feet_is_missed_by_next_to_nothing() {
    let folder = scratch("carried");
    let [file, log] = ["scenario.toml", "log.csv"].map(|name| folder.join(name));
    std::fs::write(&file, SWAY).unwrap();
    bipedc(&["simulate", "robots/tulip", "--scenario", text(&file), "--out", text(&log)]).ok();
    let compared = bipedc(&["compare", "robots/tulip", text(&log), "--json"]).ok().json();
    let missed = |name: &str| {
        let channels = compared["channels"].as_array().unwrap();
        channels.iter().find(|row| row["name"] == name).map(|row| row["rms"].as_f64().unwrap())
    };
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
