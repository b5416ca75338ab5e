//! `bipedc evaluate`: the format of states, against known torques, and its errors.
use crate::cli;

use cli::{Run, bipedc, scratch, text};
use serde_json::{Value, json};

fn evaluate(name: &str, robot: &str, function: &str, states: &str, more: &[&str]) -> Run {
    let file = scratch(name).join("states.json");
    std::fs::write(&file, states).unwrap();
    bipedc(&[&["evaluate", robot, function, "--states", text(&file)], more].concat())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn gravity_of_an_empty_state_is_the_weight() {
    let value = evaluate("weight", "robots/five_link", "gravity", "{}", &["--json"]).ok().json();
    assert_eq!(value["function"], "gravity");
    assert_eq!(value["rows"][0], "base/x");
    assert_eq!(value["columns"], json!(["value"]));
    assert_eq!(value["row_units"][2], "N m");
    let tau = numbers(&value["values"][0]);
    assert!((tau[1] - 32.0 * 9.81).abs() < 1e-9, "{tau:?}");
    let run = evaluate("weight_text", "robots/five_link", "gravity", "{}", &[]).ok();
    assert!(
        run.out.contains("base/z") && run.out.contains("313.920000000") && run.out.contains("N m"),
        "{}",
        run.out
    );
}

#[test]
fn several_states_and_matrices() {
    let states = r#"[{}, {"position": {"right_hip_pitch": 0.3}}]"#;
    let value = evaluate("matrix", "robots/three_link", "mass_matrix", states, &["--json"]).ok().json();
    let values = value["values"].as_array().unwrap();
    assert_eq!(values.len(), 2);
    assert_eq!(values[0].as_array().unwrap().len(), 5);
    assert_eq!(values[0][0], values[0][0].clone());
    assert_eq!(values[1][0][2], values[1][2][0], "symmetric");
    assert_ne!(values[0][0][2], values[1][0][2]);
    assert_eq!(value["columns"], value["rows"]);
}

/// A planar base moving along a known path, once as planar and once as floating robot: the same joint torques,
/// and the base's wrench turned into world axes.
#[test]
fn planar_and_floating_bases_agree() {
    let (pitch, half) = (0.4_f64, 0.2_f64);
    let state = json!({
        "base": {
            "position": [0.1, 0, 0.8], "orientation": [0, half.sin(), 0, half.cos()],
            "linear_velocity": [0.5, 0, -0.2], "angular_velocity": [0, 0.7, 0],
            "linear_acceleration": [1.0, 0, 0.3], "angular_acceleration": [0, -0.6, 0],
            "force": [3.0, 0, 4.0], "torque": [0, 5.0, 0]
        },
        "position": {"right_hip_pitch": 0.3, "left_hip_pitch": -0.5},
        "velocity": {"right_hip_pitch": 1.1}, "acceleration": {"left_hip_pitch": 2.0}, "effort": {"right_hip_pitch": 7.0}
    })
    .to_string();
    let both = |function: &str| {
        let ask = |base: &str| {
            let name = format!("{function}_{base}");
            let run = evaluate(&name, "robots/three_link", function, &state, &["--base", base, "--json"]);
            numbers(&run.ok().json()["values"][0])
        };
        (ask("planar"), ask("floating"))
    };
    let (s, c) = pitch.sin_cos();
    let world = |x: f64, z: f64| [c * x + s * z, c * z - s * x];
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{a} {b}");
    let (planar, floating) = both("inverse_dynamics");
    let [x, z] = world(floating[0], floating[2]);
    let expected = [x, z, floating[4], floating[6], floating[7]];
    planar.iter().zip(expected).for_each(|(&a, b)| close(a, b));
    // The floating robot's answer is a rate of twist components; the planar one's is R (v̇ + ω × v).
    let (planar, floating) = both("forward_dynamics");
    let [x, z] = world(floating[0] + 0.7 * -0.2, floating[2] - 0.7 * 0.5);
    let expected = [x, z, floating[4], floating[6], floating[7]];
    planar.iter().zip(expected).for_each(|(&a, b)| close(a, b));
}

#[test]
fn forces_at_contact_points() {
    let states = r#"{"forces": {"right_foot/point_foot": [0, 0, 313.92]}}"#;
    let run =
        evaluate("forces", "robots/five_link", "inverse_dynamics_with_forces", states, &["--json"]).ok();
    let tau = numbers(&run.json()["values"][0]);
    assert!(tau[1].abs() < 1e-9, "the ground carries the weight: {tau:?}");
}

#[test]
fn functions_of_a_frame() {
    let run = evaluate(
        "frame",
        "robots/five_link",
        "position",
        "{}",
        &["--point", "right_foot/point_foot", "--json"],
    );
    let value = run.ok().json();
    assert_eq!(value["rows"], json!(["x", "y", "z"]));
    assert!((numbers(&value["values"][0])[2] + 0.8).abs() < 1e-12, "{value}");
    evaluate("frame_none", "robots/five_link", "position", "{}", &[]).fails_with(&["about one frame"]);
}

#[test]
fn bad_states_name_their_line() {
    let bad = |name: &str, states: &str, words: &[&str]| {
        evaluate(name, "robots/five_link", "bias", states, &[]).fails_with(words);
    };
    bad(
        "joint",
        "{\n \"position\": {\n  \"right_hip_pich\": 1}}",
        &["`right_hip_pich`", "states.json:3:", "did you mean `right_hip_pitch`?"],
    );
    bad("key", "{\"positon\": {}}", &["unknown key `positon`", "did you mean `position`?"]);
    bad(
        "base_key",
        "{\"base\": {\"velocity\": [0,0,0]}}",
        &["unknown key of the base `velocity`", "`linear_velocity`"],
    );
    bad(
        "text",
        "[{},\n {\"velocity\": {\"left_hip_pitch\": \"fast\"}}]",
        &["invalid type: string", "states.json:2:"],
    );
    bad("short", "{\"base\": {\"position\": [1, 2]}}", &["invalid length 2"]);
    bad(
        "sideways",
        "{\"base\": {\n\"position\": [0, 1, 0]}}",
        &["`position` has y component 1", "must be 0", "states.json:2:"],
    );
    bad("quaternion", "{\"base\": {\"orientation\": [0, 0, 0, 2]}}", &["length 2", "unit quaternion"]);
    bad("syntax", "{\"base\": \n", &["EOF", "states.json:"]);
    bad("twice", "{\"position\": {}, \"position\": {}}", &["stands twice"]);
    bad(
        "joint_twice",
        "{\"velocity\": {\"left_hip_pitch\": 1,\n \"left_hip_pitch\": 2}}",
        &["joint `left_hip_pitch` stands twice", "remove one", "states.json:2:"],
    );
    bad(
        "base_twice",
        "{\"base\": {\"force\": [0,0,0],\n \"force\": [1,0,0]}}",
        &["`force` of the base stands twice", "states.json:2:"],
    );
    bad(
        "point_twice",
        "{\"forces\": {\"right_foot/point_foot\": [0,0,1], \"right_foot/point_foot\": [0,0,2]}}",
        &["contact point `right_foot/point_foot` stands twice", "states.json:1:"],
    );
    bad(
        "point",
        "{\"forces\": {\"right_foot/heel\": [0,0,1]}}",
        &["unknown contact point", "right_foot/point_foot"],
    );
}

#[test]
fn a_fixed_base_does_not_move() {
    let states = r#"{"base": {"linear_velocity": [0.1, 0, 0]}}"#;
    let run = evaluate("fixed", "robots/five_link", "bias", states, &["--base", "fixed"]);
    run.fails_with(&["`linear_velocity` has x component 0.1", "does not move"]);
}

#[test]
fn missing_files_and_functions() {
    bipedc(&["evaluate", "robots/five_link", "bias", "--states", "nowhere.json"])
        .fails_with(&["cannot read the states", "nowhere.json"]);
    evaluate("function", "robots/five_link", "biass", "{}", &[]).fails_with(&["did you mean `bias`?"]);
}
