//! What a filter does to products, and joints that meet their stops: faultless logs leave nothing but noise.
use super::{rows, scratch, simulate};
use crate::cli::{bipedc, text};

/// TUlip walks ahead; forces, lever arms and accelerations change within the reach of a slow filter.
const WALK: &str = "duration = 10.0
step = 0.0005
log_step = 0.004
seed = 1
[walking]
velocity = [{ time = 0.5, forward = 0.3 }]
[sensors]
position_noise = 1e-4
force_noise = 0.3
effort_noise = 0.05
";

/// Filtered one by one the vertical force was missed by 3.8 times its noise, hips and knees by twice theirs.
#[test]
fn a_walk_behind_a_slow_filter_leaves_nothing_but_noise() {
    let folder = scratch("simulate_slow_filter");
    simulate("robots/tulip", &folder, "walk", WALK, &[]).ok();
    let log = folder.join("walk.csv");
    let run = bipedc(&["compare", "robots/tulip", text(&log), "--cutoff", "5", "--json"]).ok().json();
    let rows = rows(&run);
    assert!(rows.len() > 17, "{rows:?}");
    assert!(rows.iter().all(|(_, rms, noise)| *rms < 1.35 * noise), "{rows:?}");
}

/// The knees are asked to bend the wrong way, and lie at their stops for a part of every swing.
const AT_STOPS: &str = "duration = 12.0
step = 0.001
log_step = 0.004
seed = 7
[control]
stiffness = 150.0
damping = 6.0
servo = \"drive\"
[joint]
right_hip_pitch = { position = -0.2, sines = [[0.3, 0.5, 0.0], [0.1, 1.1, 1.0]] }
right_knee_pitch = { position = 0.3, sines = [[0.5, 0.4, 0.2], [0.1, 0.9, 0.5]] }
left_hip_pitch = { position = -0.2, sines = [[0.25, 0.45, 0.3], [0.1, 1.3, 0.0]] }
left_knee_pitch = { position = 0.3, sines = [[0.5, 0.55, 0.7], [0.12, 1.2, 0.0]] }
[[effect]]
kind = \"coulomb_friction\"
joint = \"right_knee_pitch\"
torque = 0.8
[sensors]
encoder_counts = 200000
effort_noise = 0.03
";

/// The stops' torque was called whatever fitted it, and masses were wrong by as much: errors of 32 % after `identify`.
#[test]
fn joints_at_their_stops_tell_bounds() {
    let folder = scratch("simulate_stops");
    let other = AT_STOPS.replace("seed = 7", "seed = 8").replace("0.55, 0.7", "0.5, 0.9");
    simulate("robots/tulip", &folder, "train", AT_STOPS, &["--base", "fixed"]).ok();
    simulate("robots/tulip", &folder, "judge", &other, &["--base", "fixed"]).ok();
    let [train, judge] = ["train.csv", "judge.csv"].map(|file| folder.join(file));
    let logs = ["robots/tulip", text(&train), "--validate", text(&judge), "--json"];
    let found = bipedc(&[&["diagnose"], &logs[..]].concat()).ok().json();
    let effects = found["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{effects:#?}");
    assert_eq!(
        (&effects[0]["kind"], &effects[0]["joint"]),
        (&"coulomb_friction".into(), &"right_knee_pitch".into())
    );
    let torque = effects[0]["parameters"]["torque"].as_f64().unwrap();
    assert!((torque - 0.8).abs() < 0.04, "{torque} N m of 0.8 N m");
    let said = |answer: &serde_json::Value| answer["assumptions"].to_string().contains("lie at their stops");
    assert!(said(&found), "{}", found["assumptions"]);
    let judged = found.get("judged_at_hz").unwrap_or(&found["cutoff_hz"]);
    let cutoff = judged.to_string();
    let compared = ["compare", "robots/tulip", text(&judge), "--cutoff", &cutoff, "--json"];
    let compared = bipedc(&compared).ok().json();
    assert!(said(&compared), "{}", compared["assumptions"]);
    // What the stop carries is no error, and both commands say the same.
    for row in compared["channels"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64().unwrap();
        let before = found["rows"][row["name"].as_str().unwrap()]["before"].as_f64().unwrap();
        assert!((number("rms") / before - 1.0).abs() < 1e-6, "{before} in {row:#}");
        assert!(row["name"] != "left_knee_pitch" || number("rms") < 3.0 * number("noise"), "{row:#}");
    }
}

/// TUlip walks with play in an ankle that nobody told its controller; both angles are logged.
const PLAY: &str = "[[effect]]
kind = \"backlash\"
joint = \"left_ankle_pitch\"
gap = 0.0175
[[effect]]
kind = \"rotor_inertia\"
joint = \"left_ankle_pitch\"
inertia = 0.02
";

/// Angles between motors and links were not looked at in logs with forces of feet: play came out as a rotor, a fifth too light, and a delay.
#[test]
#[ignore = "takes long"]
fn play_of_an_ankle_is_found_in_a_walk() {
    let folder = scratch("simulate_walk_with_play");
    for (name, seed) in [("train", "seed = 41"), ("judge", "seed = 72")] {
        let walk = WALK.replace("seed = 1", seed).replace("forward = 0.3", "forward = 0.2");
        let walk =
            walk.replace("step = 0.0005", "step = 0.001").replace("log_step = 0.004", "log_step = 0.005");
        simulate("robots/tulip", &folder, name, &(walk + PLAY), &[]).ok();
    }
    let [train, judge] = ["train.csv", "judge.csv"].map(|file| folder.join(file));
    let logs = ["robots/tulip", text(&train), "--validate", text(&judge), "--json"];
    let found = bipedc(&[&["diagnose"], &logs[..]].concat()).ok().json();
    let effects = found["effects"].as_array().unwrap();
    let value = |kind: &str, name: &str| {
        let it = effects.iter().find(|e| e["kind"] == kind && e["joint"] == "left_ankle_pitch");
        it.and_then(|it| it["parameters"][name].as_f64()).unwrap_or(f64::NAN)
    };
    assert_eq!(effects.len(), 2, "{effects:#?}");
    let [gap, inertia] = [value("backlash", "gap"), value("rotor_inertia", "inertia")];
    assert!((gap / 0.0175 - 1.0).abs() < 0.02, "{gap} rad of 0.0175 rad");
    assert!((inertia / 0.02 - 1.0).abs() < 0.05, "{inertia} kg m² of 0.02 kg m²");
}
