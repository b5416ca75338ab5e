//! Every assumption has a scenario that violates it, and the verdict says what happened.
use super::{scenario_text, walked};
use bipedc_analysis::simulate::phases::Violation;
use bipedc_analysis::simulate::phases::WalkEnd;

/// What ended the walk.
pub fn verdict(folder: &str, text: &str) -> Violation {
    let (summary, samples) = walked(folder, text).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(summary.end, WalkEnd::Verdict, "{summary:?}");
    let violation = summary.verdict.unwrap();
    println!("{violation:?}");
    assert_eq!(violation.time, summary.time);
    // The log is of the time before it.
    assert!(samples.iter().all(|sample| sample.time <= violation.time));
    assert!(violation.value.is_finite() && violation.value != violation.limit);
    violation
}

pub fn said(violation: &Violation, phase: &str, quantity: &str, unit: &str, meaning: &str) {
    assert_eq!((violation.phase.as_str(), violation.unit), (phase, unit));
    assert!(violation.quantity.contains(quantity), "{}", violation.quantity);
    assert!(violation.meaning.contains(meaning), "{}", violation.meaning);
}

const GAIT: &str = "robots/five_link/scenarios/gait.toml";
const PUBLISHED: &str = "robots/three_link/scenarios/published_gait.toml";

#[test]
fn point_feet_that_slip() {
    let text = scenario_text(GAIT).replace("friction = 0.6", "friction = 0.2");
    let force = verdict("robots/five_link", &text);
    said(&force, "single_support", "tangential force on right_foot", "N", "slips");
    assert!(force.value > force.limit && force.value < 1.01 * force.limit, "just when it begins");
    // The published gait's impact asks for 0.59954, its steps for less.
    let text = scenario_text(PUBLISHED).replace("friction = 0.8", "friction = 0.58");
    let impulse = verdict("robots/three_link", &text);
    said(&impulse, "single_support", "tangential impulse on left_foot", "N s", "slips");
    let ratio = 0.58 * impulse.value / impulse.limit;
    assert!((ratio - 0.59954).abs() < 2e-3, "{ratio}");
}

#[test]
fn a_point_foot_that_would_have_to_pull() {
    // Over the foot with five times the gait's speed.
    let mut text = scenario_text(GAIT).replace("friction = 0.6", "friction = false");
    for (slow, fast) in [("1.3418127107", "7.5"), ("-0.3373106887", "-1.5")] {
        text = text.replace(slow, fast);
    }
    text = text.replace("[[control.output]]", "#").replace("[control.feedback]", "[unused]");
    let start = text.find("[unused]").unwrap();
    let force = verdict("robots/five_link", &text[..start]);
    said(&force, "single_support", "normal force on right_foot", "N", "pull");
    assert!(force.value < 0.0 && force.limit == 0.0);
}

#[test]
fn a_swing_leg_without_a_knee_scuffs() {
    let text = scenario_text(PUBLISHED).replace("scuffing = false", "scuffing = 0.001");
    let height = verdict("robots/three_link", &text);
    said(&height, "single_support", "height of left_foot/point_foot", "m", "scuffs");
    assert!((height.value + 0.001).abs() < 1e-7 && height.limit == -0.001, "{height:?}");
}

#[test]
fn a_joint_that_meets_its_stop() {
    // The lifted leg's knee is told to bend the wrong way.
    let text = "method = \"event_driven\"\nduration = 1.0\n[control]\nstiffness = 200.0\ndamping = 5.0\n[joint]\n\
        right_knee_pitch = { position = 0.05 }\nleft_hip_pitch = { position = -0.6 }\n\
        left_knee_pitch = { position = 0.3, reference = -0.4 }\n";
    let position = verdict("robots/five_link", text);
    said(&position, "single_support", "position of left_knee_pitch", "rad", "stop");
    assert!(position.limit == 0.0 && position.value < 0.0 && position.value > -1e-6);
}

/// Legs that are further apart than a right angle: the impulse on the front foot pushes the rear one into the ground.
const WIDE: &str = "method = \"event_driven\"
duration = 2.0
[assumptions]
friction = false
shortest_step = 0.1
[initial]
base_rotation = [0.0]
base_angular_velocity = [0.0]
[joint]
right_hip_pitch = { position = 0.9, velocity = 1.0 }
left_hip_pitch = { position = -0.95, velocity = 0.5 }
";

#[test]
fn a_point_foot_that_strikes_again() {
    let speed = verdict("robots/three_link", WIDE);
    said(&speed, "single_support", "vertical velocity of right_foot/point_foot", "m/s", "second impact");
    assert!(speed.value < -0.01);
    // What is not checked is not said.
    let (summary, _) = walked(
        "robots/three_link",
        &WIDE.replace("friction = false", "friction = false\nsecond_impact = false"),
    )
    .unwrap();
    assert!(summary.steps >= 1, "{summary:?}");
}
