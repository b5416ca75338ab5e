//! Steps that end where a guard vanishes, of gaits whose constraint surface has no closed form.
use crate::cli::{bipedc, scratch, text};
use std::fs;

/// The foot in the air moves twice as far as the base and comes down from above. At the smallest φ where the guard is looked for the legs would have to be longer
/// than they are, so that nothing told its sign before the end: steps never ended.
const GAIT: &str = r#"
[parameters.stride]
unit = "m"
meaning = "step length"
default = 0.35
bounds = [0.2, 0.5]

[parameters.lift]
unit = "m"
meaning = "lift of the foot"
default = 0.05
bounds = [0.02, 0.1]

[quantities]
curve = "lift * (1 - (2 * phase / stride)^2)"

[[phase]]
name = "single_support"
variable = "base_x - right_foot_point_foot_x"
unit = "m"
guard = { zero = "left_foot_point_foot_x - right_foot_point_foot_x - stride", between = [-0.5, 0.4] }
posture = { right_hip_pitch = -0.1, right_knee_pitch = 0.3, left_hip_pitch = 0.2, left_knee_pitch = 0.3 }

[[phase.output]]
name = "lean"
unit = "rad"
controlled = "base_pitch"
wanted = "0.1"

[[phase.output]]
name = "knee"
unit = "rad"
controlled = "right_knee_pitch"
wanted = "0.3"

[[phase.output]]
name = "ahead"
unit = "m"
controlled = "left_foot_point_foot_x - right_foot_point_foot_x"
wanted = "2 * phase"

[[phase.output]]
name = "lift"
unit = "m"
controlled = "left_foot_point_foot_z - right_foot_point_foot_z"
wanted = "curve"

[limits]
friction = 0.6
"#;
const SCENARIO: &str = r#"
method = "event_driven"
duration = 20.0
steps = 3
log_step = 0.01
[assumptions]
friction = false
step_length = "gait"
[initial]
mid_stance_speed = 0.8
[control]
gait = "GAIT"
"#;

#[test]
fn a_guard_is_seen_though_there_is_no_posture_where_it_is_looked_for_first() {
    let folder = scratch("guards");
    let (gait, scenario, log) =
        (folder.join("ahead.toml"), folder.join("scenario.toml"), folder.join("run.csv"));
    fs::write(&gait, GAIT).unwrap();
    fs::write(&scenario, SCENARIO.replace("GAIT", text(&gait))).unwrap();
    let walked = bipedc(&[
        "simulate",
        "robots/five_link",
        "--scenario",
        text(&scenario),
        "--out",
        text(&log),
        "--json",
    ]);
    let walked = walked.ok().json();
    assert_eq!(walked["steps"], 3, "{walked}");
    let cycle = bipedc(&["gait", "cycle", "robots/five_link", "--gait", text(&gait), "--json"]).ok().json();
    let cycle = &cycle["cycles"][0];
    let predicted = cycle["cycle"]["multiplier"].as_f64().unwrap();
    let whole = cycle.to_string();
    assert!(whole.contains("multipliers") && !whole.contains("StepSizeTooSmall"), "{whole}");
    assert!((predicted - 0.744493).abs() < 1e-4, "{predicted}");
}
