//! Logs of one joint in closed form: what its bodies and filters hide from a search.
use crate::cli::{bipedc, scratch, text};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Mass (kg), distance of its centre below the axis (m) and inertia there (kg m²).
const ARM: [f64; 3] = [0.13, 0.07, 2.87e-4];
const GRAVITY: f64 = 9.81;

const URDF: &str = r#"<robot name="arm"><link name="bench"/><link name="arm"><inertial><origin xyz="0 0 -0.07"/>
<mass value="0.13"/><inertia ixx="2.87e-4" ixy="0" ixz="0" iyy="2.87e-4" iyz="0" izz="2e-5"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="bench"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="10" velocity="20"/></joint></robot>"#;

/// A folder with the arm in it.
fn arm(name: &str) -> PathBuf {
    let folder = scratch(name);
    std::fs::write(folder.join("robot.urdf"), URDF).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    folder
}

/// Twenty seconds of two sines at 500 Hz; `effort` has position, velocity, acceleration and time.
fn log(folder: &Path, name: &str, rates: [f64; 2], effort: &dyn Fn([f64; 4]) -> f64) -> PathBuf {
    let mut csv = "time,shoulder/position,shoulder/effort\n".to_owned();
    // Noise of a tenth of a thousandth of a newton metre, the same every time.
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        1e-4 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
    };
    for sample in 0..10_000 {
        let time = f64::from(sample) * 0.002;
        let parts = [0.6, 0.4].into_iter().zip(rates);
        let motion = parts.fold([0.0; 3], |[q, v, a], (size, rate)| {
            let (sin, cos) = (rate * time).sin_cos();
            [q + size * sin, v + size * rate * cos, a - size * rate * rate * sin]
        });
        let torque = effort([motion[0], motion[1], motion[2], time]) + noise();
        writeln!(csv, "{time:.3},{:.9},{torque:.9}", motion[0]).unwrap();
    }
    let path = folder.join(name);
    std::fs::write(&path, csv).unwrap();
    path
}

/// The torque that moves the arm with a point mass (kg) so far below the axis (m).
fn torque([position, _, acceleration, _]: [f64; 4], mass: f64, below: f64) -> f64 {
    let [own, centre, inertia] = ARM;
    let moment = own * centre + mass * below;
    let about = inertia + own * centre * centre + mass * below * below;
    about * acceleration + GRAVITY * moment * position.sin()
}

fn diagnosed(folder: &Path, train: &Path, judge: &Path) -> Value {
    let arguments = ["diagnose", text(folder), text(train), "--validate", text(judge), "--json", "--anyway"];
    bipedc(&arguments).ok().json()
}

/// Linear in the rows is the first moment alone: a rotor and a gain of one half were found in its place.
#[test]
fn a_payload_about_a_fixed_axis_is_one_effect() {
    let folder = arm("one_joint_payload");
    let loaded = |motion: [f64; 4]| torque(motion, 0.06, 0.13);
    let train = log(&folder, "train.csv", [2.9, 5.3], &loaded);
    let judge = log(&folder, "judge.csv", [2.3, 6.7], &loaded);
    let answer = diagnosed(&folder, &train, &judge);
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!((&found["kind"], &found["link"]), (&"payload".into(), &"arm".into()));
    let [mass, z] = ["mass", "z"].map(|name| found["parameters"][name].as_f64().unwrap());
    assert!((mass / 0.06 - 1.0).abs() < 0.02 && (z / -0.13 - 1.0).abs() < 0.02, "{found:#}");
    // The same from one given kind.
    let amend = ["amend", text(&folder), text(&train), "--effect", "payload", "--link", "arm", "--json"];
    bipedc(&amend).ok();
    let errors = bipedc(&["compare", text(&folder), text(&judge), "--json"]).ok().json();
    let channel = &errors["channels"][0];
    let [rms, noise] = ["rms", "noise"].map(|key| channel[key].as_f64().unwrap());
    assert!(rms < 1.5 * noise, "{rms} N m, noise {noise} N m");
}

/// A slope over a hundredth of a second says nothing of a delay of a twelfth: friction and a rotor were found in its place.
#[test]
fn a_long_delay_is_found() {
    const DELAY: f64 = 0.083;
    let folder = arm("one_joint_delay");
    let rates = [[2.9, 5.3], [2.3, 6.7]];
    let early = |rates: [f64; 2]| {
        move |[_, _, _, time]: [f64; 4]| {
            let parts = [0.6, 0.4].into_iter().zip(rates);
            let motion = parts.fold([0.0, 0.0], |[q, a], (size, rate)| {
                let sin = (rate * (time + DELAY)).sin();
                [q + size * sin, a - size * rate * rate * sin]
            });
            torque([motion[0], 0.0, motion[1], 0.0], 0.0, 0.0)
        }
    };
    let train = log(&folder, "train.csv", rates[0], &early(rates[0]));
    let judge = log(&folder, "judge.csv", rates[1], &early(rates[1]));
    let answer = diagnosed(&folder, &train, &judge);
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!(found["kind"], "actuator_delay");
    let delay = found["parameters"]["delay"].as_f64().unwrap();
    assert!((delay / DELAY - 1.0).abs() < 0.01, "{found:#}");
    assert!(!answer["unexplained"].as_bool().unwrap(), "{}", answer["summary"]);
}

/// A log of which two seconds are something else teaches nothing: that is said, with the time.
#[test]
fn what_teaches_and_does_not_judge_is_said() {
    let folder = arm("one_joint_episode");
    let held = |motion: [f64; 4]| {
        let episode = (12.0..14.0).contains(&motion[3]);
        torque(motion, 0.0, 0.0) + if episode { 3.0 * (40.0 * motion[3]).sin() } else { 0.0 }
    };
    let train = log(&folder, "train.csv", [2.9, 5.3], &held);
    let judge = log(&folder, "judge.csv", [2.3, 6.7], &|motion| torque(motion, 0.0, 0.0));
    let answer = diagnosed(&folder, &train, &judge);
    assert_eq!(answer["effects"].as_array().unwrap().len(), 0, "{}", answer["summary"]);
    let warnings = answer["warnings"].as_array().unwrap().iter().filter_map(Value::as_str);
    let said: Vec<&str> = warnings.filter(|w| w.contains("does not hold elsewhere")).collect();
    let [said] = said[..] else { panic!("{}", answer["warnings"]) };
    assert!(said.contains("between 12.") && said.contains(" and 13."), "{said}");
    // Whole, it says so; without that time nothing is left to say.
    let cut = ["diagnose", text(&folder), text(&train), "--to", "11.5", "--validate", text(&judge), "--json"];
    let warnings = bipedc(&cut).ok().json()["warnings"].to_string();
    assert!(!warnings.contains("does not hold elsewhere"), "{warnings}");
}

/// Whose effort is not logged is not looked at, and the answer says so beside "nothing is missing".
#[test]
fn a_joint_without_effort_is_named() {
    let folder = arm("one_joint_unseen");
    let second = r#"<link name="hand"><inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>
</inertial></link><joint name="wrist" type="revolute"><parent link="bench"/><child link="hand"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="10" velocity="20"/></joint></robot>"#;
    std::fs::write(folder.join("robot.urdf"), URDF.replace("</robot>", second)).unwrap();
    let plain = log(&folder, "plain.csv", [2.9, 5.3], &|motion| torque(motion, 0.0, 0.0));
    let with_wrist: String = std::fs::read_to_string(plain)
        .unwrap()
        .lines()
        .enumerate()
        .map(|(row, line)| format!("{line},{}\n", if row == 0 { "wrist/position" } else { "0.0" }))
        .collect();
    let file = folder.join("train.csv");
    std::fs::write(&file, with_wrist).unwrap();
    let run = bipedc(&["diagnose", text(&folder), text(&file)]).ok();
    assert!(run.out.contains("Nothing is missing"), "{}", run.out);
    assert!(
        run.out.contains("assumed: `wrist` is not compared: the log has no column `wrist/effort`"),
        "{}",
        run.out
    );
}

/// Writes friction of this size into the description, and perhaps over which speeds its sign changes; then the error on a log and its noise.
fn error_with(folder: &Path, log: &Path, friction: f64, smoothing: Option<f64>) -> [f64; 2] {
    let mut toml = format!(
        "[base]\nkind = \"fixed\"\n\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"shoulder\"\ntorque = {friction}\n"
    );
    if let Some(width) = smoothing {
        writeln!(toml, "smoothing = {width}").unwrap();
    }
    std::fs::write(folder.join("biped.toml"), toml).unwrap();
    let errors = bipedc(&["compare", text(folder), text(log), "--json", "--cutoff", "16"]).ok().json();
    ["rms", "noise"].map(|key| errors["channels"][0][key].as_f64().unwrap())
}

/// In a motion this slow a sign that changes over 0.02 rad/s is wrong for a tenth of the time.
#[test]
fn friction_along_a_smooth_motion_jumps_as_efforts_do() {
    let folder = arm("one_joint_sharp");
    let rubbed = |motion: [f64; 4]| torque(motion, 0.0, 0.1) + 0.03 * motion[1].signum();
    let slow = log(&folder, "slow.csv", [0.31, 0.47], &rubbed);
    // It turns about three times: at one sample each the side may be the wrong one.
    let [rms, noise] = error_with(&folder, &slow, 0.03, None);
    assert!(rms < 2.0 * 0.03 * (3.0 / 9500.0_f64).sqrt(), "{rms} N m, noise {noise} N m");
    // A width that was stated is a claim about the robot.
    let [wide, _] = error_with(&folder, &slow, 0.03, Some(0.1));
    assert!(wide > 10.0 * rms, "{wide} N m, {rms} N m");
}

/// The effort of a drive that yields passes from one side to the other over a tenth of a second.
#[test]
fn friction_behind_a_slow_drive_does_not_jump() {
    let folder = arm("one_joint_slow_drive");
    let rubbed = |motion: [f64; 4]| torque(motion, 0.0, 0.1) + 0.03 * (motion[1] / 0.02).tanh();
    let slow = log(&folder, "slow.csv", [0.31, 0.47], &rubbed);
    let [rms, noise] = error_with(&folder, &slow, 0.03, None);
    assert!(rms < 1.1 * noise, "{rms} N m, noise {noise} N m");
    let [sharp, _] = error_with(&folder, &slow, 0.03, Some(1e-4));
    assert!(sharp > 5.0 * noise, "{sharp} N m, noise {noise} N m");
}

/// What is usual is usual of robots that people carry: ten times as heavy, friction is no other effect than on them.
#[test]
fn large_effects_are_found_on_heavy_joints() {
    let folder = scratch("one_joint_heavy");
    let scaled = URDF
        .replace("0 0 -0.07", "0 0 -0.7")
        .replace("mass value=\"0.13\"", "mass value=\"40\"")
        .replace("ixx=\"2.87e-4\"", "ixx=\"3.1\"")
        .replace("iyy=\"2.87e-4\"", "iyy=\"3.1\"")
        .replace("izz=\"2e-5\"", "izz=\"0.2\"");
    std::fs::write(folder.join("robot.urdf"), scaled).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    // A rotor of four times what is usual, and friction of three times that.
    let heavy = |[position, velocity, acceleration, _]: [f64; 4]| {
        (3.1 + 40.0 * 0.49 + 8.3) * acceleration
            + GRAVITY * 40.0 * 0.7 * position.sin()
            + 91.0 * velocity.signum()
    };
    let train = log(&folder, "train.csv", [1.9, 3.3], &heavy);
    let judge = log(&folder, "judge.csv", [1.3, 4.1], &heavy);
    let answer = diagnosed(&folder, &train, &judge);
    let effects = answer["effects"].as_array().unwrap();
    let of = |kind: &str, parameter: &str| {
        let found = effects.iter().find(|effect| effect["kind"] == kind);
        found.map_or(f64::NAN, |effect| effect["parameters"][parameter].as_f64().unwrap())
    };
    let [inertia, friction] = [of("rotor_inertia", "inertia"), of("coulomb_friction", "torque")];
    assert!(
        (inertia / 8.3 - 1.0).abs() < 0.01 && (friction / 91.0 - 1.0).abs() < 0.01,
        "{}",
        answer["summary"]
    );
    assert_eq!(effects.len(), 2, "{}", answer["summary"]);
    // What is usual grows with the robot.
    assert!(!answer["summary"].as_str().unwrap().contains("usual range"), "{}", answer["summary"]);
}

/// What hangs above the axis turns the load about: it was called a wrong sign of the effort, or a zero half of a turn elsewhere.
#[test]
fn a_payload_that_turns_the_load_about_is_no_wrong_sign() {
    let folder = arm("one_joint_turned_about");
    let loaded = |motion: [f64; 4]| torque(motion, 0.06, -0.3);
    let train = log(&folder, "train.csv", [2.9, 5.3], &loaded);
    let judge = log(&folder, "judge.csv", [2.3, 6.7], &loaded);
    let answer = bipedc(&["diagnose", text(&folder), text(&train), "--validate", text(&judge), "--json"]);
    let answer = answer.ok().json();
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{}", answer["summary"]) };
    assert_eq!((&found["kind"], &found["link"]), (&"payload".into(), &"arm".into()), "{found:#}");
    let moment = |name: &str| found["parameters"][name].as_f64().unwrap();
    assert!((moment("mass") * moment("z") / 0.018 - 1.0).abs() < 0.05, "{found:#}");
}

/// A slide that swings up and down: its position in mm was a correction of its mass.
#[test]
fn a_slide_in_millimetres_is_named() {
    let folder = arm("one_joint_slide");
    let slide = URDF.replace("\"revolute\"", "\"prismatic\"").replace("0 1 0", "0 0 1");
    std::fs::write(folder.join("robot.urdf"), slide).unwrap();
    let force = |[_, _, a, _]: [f64; 4]| ARM[0] * (a + GRAVITY);
    let path = log(&folder, "metres.csv", [2.9, 5.3], &force);
    let lines = std::fs::read_to_string(&path).unwrap();
    let (header, rows) = lines.split_once('\n').unwrap();
    let rows = rows.lines().map(|row| {
        let mut fields = row.split(',');
        let [time, position, effort] = [(); 3].map(|()| fields.next().unwrap());
        format!("{time},{:.6},{effort}\n", 1e3 * position.parse::<f64>().unwrap())
    });
    std::fs::write(folder.join("wrong.csv"), format!("{header}\n{}", rows.collect::<String>())).unwrap();
    let refused = bipedc(&["diagnose", text(&folder), text(&folder.join("wrong.csv"))]);
    refused.fails_with(&["`shoulder/position` is in mm instead of m", "scale = 0.001"]);
    bipedc(&["diagnose", text(&folder), text(&path)]).ok();
}
