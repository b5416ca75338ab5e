//! Simulate a robot with something hidden, compare, diagnose, amend, compare again; and series elastic drives from
//! simulated motors; through the command line.
use crate::loops::cli::{bipedc, scratch, text};
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Controllers inside the drives, encoders and noise of all runs.
const ALL: &str = "step = 0.001
log_step = 0.004
[control]
stiffness = 300.0
damping = 5.0
servo = \"drive\"
[sensors]
encoder_counts = 200000
effort_noise = 0.03
[joint]
";

/// Begins at rest.
const TRAIN: &str = "
right_hip_pitch = { position = -0.2, sines = [[0.25, 0.5, 1.5708], [0.08, 1.1, -1.5708]] }
right_knee_pitch = { position = 0.6, sines = [[0.25, 0.4, -1.5708], [0.1, 0.9, 1.5708]] }
left_hip_pitch = { position = -0.2, sines = [[0.25, 0.45, -1.5708], [0.08, 1.3, 1.5708]] }
left_knee_pitch = { position = 0.8, sines = [[0.25, 0.55, 1.5708], [0.1, 1.2, -1.5708]] }
";

/// Another motion.
const JUDGE: &str = "
right_hip_pitch = { position = -0.1, sines = [[0.2, 0.62, -1.5708], [0.1, 0.9, 1.5708]] }
right_knee_pitch = { position = 0.7, sines = [[0.25, 0.47, 1.5708], [0.1, 1.0, 1.5708]] }
left_hip_pitch = { position = -0.3, sines = [[0.22, 0.55, 1.5708], [0.1, 1.05, -1.5708]] }
left_knee_pitch = { position = 0.7, sines = [[0.26, 0.48, -1.5708], [0.1, 1.15, 1.5708]] }
";

/// A hidden effect.
fn effect(kind: &str, place: &str, parameters: &str) -> String {
    format!("[[effect]]\nkind = \"{kind}\"\n{place}\n{parameters}\n")
}

const KNEE: &str = "joint = \"left_knee_pitch\"";

fn rotor() -> String {
    effect("rotor_inertia", KNEE, "inertia = 0.05")
}

/// A robot that may be amended, and its two logs.
pub(super) struct Hidden {
    pub robot: PathBuf,
    pub train: PathBuf,
    pub judge: PathBuf,
}

impl Hidden {
    pub fn simulated(name: &str, effects: &str) -> Self {
        Self::moved(name, effects, [TRAIN, JUDGE], "1.57")
    }

    /// The same with other motions, of a robot whose hips turn so far (rad).
    fn moved(name: &str, effects: &str, [train, judge]: [&str; 2], reach: &str) -> Self {
        let robot = scratch(&format!("simulated_{name}"));
        let shipped = Path::new("robots/five_link");
        std::fs::copy(shipped.join("biped.toml"), robot.join("biped.toml")).unwrap();
        let urdf = std::fs::read_to_string(shipped.join("robot.urdf")).unwrap();
        std::fs::write(robot.join("robot.urdf"), urdf.replace("1.57", reach)).unwrap();
        let run = |name: &str, duration: f64, seed: u64, motion: &str| {
            let (scenario, log) = (robot.join(format!("{name}.toml")), robot.join(format!("{name}.csv")));
            let all = format!("duration = {duration:.1}\nseed = {seed}\n{ALL}{motion}{effects}");
            std::fs::write(&scenario, all).unwrap();
            let words = ["simulate", text(&robot), "--base", "fixed", "--scenario", text(&scenario)];
            bipedc(&[&words[..], &["--out", text(&log)]].concat()).ok();
            log
        };
        let (train, judge) = (run("train", 8.0, 3, train), run("judge", 6.0, 4, judge));
        Self { robot, train, judge }
    }

    /// Error of the description on the motion that teaches nothing, N m.
    fn error(&self) -> f64 {
        let words = ["compare", text(&self.robot), text(&self.judge), "--base", "fixed", "--json"];
        bipedc(&words).ok().json()["rms"].as_f64().unwrap()
    }

    fn diagnosed(&self, inertial: &[&str]) -> Value {
        let words = ["diagnose", text(&self.robot), text(&self.train), "--validate", text(&self.judge)];
        bipedc(&[&words[..], &["--base", "fixed", "--json"], inertial].concat()).ok().json()
    }

    /// Diagnoses and amends: effects by kind, error before and after.
    fn amended(&self, inertial: &[&str]) -> (Vec<Value>, f64, f64) {
        let before = self.error();
        let answer = self.diagnosed(inertial);
        let file = self.robot.join("diagnosis.json");
        std::fs::write(&file, answer.to_string()).unwrap();
        bipedc(&["amend", text(&self.robot), "--from", text(&file)]).ok();
        let steps = answer["steps"].as_array().unwrap();
        let found = steps.iter().map(|step| step["effect"].clone()).collect();
        let after = self.error();
        println!("{found:?}: {before:.4} -> {after:.4} N m");
        (found, before, after)
    }
}

/// The parameter of the effect of this kind; there must be one.
fn value(found: &[Value], kind: &str, parameter: &str) -> f64 {
    let effect = found.iter().find(|effect| effect["kind"] == kind);
    let effect = effect.unwrap_or_else(|| panic!("no {kind} in {found:?}"));
    effect["parameters"][parameter].as_f64().unwrap()
}

fn near(found: f64, truth: f64, part: f64) {
    assert!((found / truth - 1.0).abs() < part, "{found} for {truth}");
}

#[test]
#[ignore = "takes long"]
fn play_and_the_rotor_before_it() {
    let hidden = Hidden::simulated("play", &(effect("backlash", KNEE, "gap = 0.02") + &rotor()));
    let (found, before, after) = hidden.amended(&["--inertial", "none"]);
    assert_eq!(found.len(), 2, "{found:?}");
    near(value(&found, "backlash", "gap"), 0.02, 0.02);
    near(value(&found, "rotor_inertia", "inertia"), 0.05, 0.1);
    assert!(after < 0.6 * before, "{before} {after}");
    let again = hidden.diagnosed(&["--inertial", "none"]);
    assert_eq!(again["steps"].as_array().unwrap().len(), 0, "{again}");
}

#[test]
#[ignore = "takes long"]
fn a_spring_and_the_rotor_before_it() {
    let hidden =
        Hidden::simulated("spring", &(effect("series_elasticity", KNEE, "stiffness = 250.0") + &rotor()));
    let (found, before, after) = hidden.amended(&["--inertial", "none"]);
    near(value(&found, "series_elasticity", "stiffness"), 250.0, 0.001);
    // The estimator's rotor turns with the joint, the true one with the motor.
    near(value(&found, "rotor_inertia", "inertia"), 0.05, 0.2);
    assert!(after < 0.4 * before, "{before} {after}");
}

/// A kind of which only the library knows: it is listed, simulated, found, written, emitted and identified.
#[test]
#[ignore = "takes long"]
fn a_kind_of_the_library_goes_through_all_tools() {
    assert!(bipedc(&["effects"]).ok().out.contains("quadratic_drag"));
    let hidden = Hidden::simulated("drag", &effect("quadratic_drag", KNEE, "drag = 0.8"));

    let words = ["identify", text(&hidden.robot), text(&hidden.train), "--base", "fixed", "--json"];
    let run = bipedc(&[&words[..], &["--friction", "viscous,quadratic_drag"]].concat()).ok().json();
    let unknowns = run["parameters"].as_array().unwrap();
    let drag = unknowns.iter().find(|unknown| unknown["name"] == "left_knee_pitch.quadratic_drag").unwrap();
    assert_eq!(drag["unit"], "N m s²/rad²");
    near(drag["value"].as_f64().unwrap(), 0.8, 0.05);

    let (found, before, after) = hidden.amended(&["--inertial", "none"]);
    assert_eq!(found.len(), 1, "{found:?}");
    near(value(&found, "quadratic_drag", "drag"), 0.8, 0.02);
    assert!(after < 0.6 * before, "{before} {after}");
    let again = hidden.diagnosed(&["--inertial", "none"]);
    assert_eq!(again["steps"].as_array().unwrap().len(), 0, "{again}");

    let out = hidden.robot.join("generated");
    bipedc(&["generate", text(&hidden.robot), "--out", text(&out)]).ok();
    let code = std::fs::read_to_string(out.join("src/inverse_dynamics.rs")).unwrap();
    assert!(code.contains("Contains the effects: Quadratic drag at left_knee_pitch"), "the code says it");
}

/// The effort of a joint as it will be so many rows later: the true torque is late.
fn hasten(log: &Path, joint: &str, rows: usize) {
    let told = std::fs::read_to_string(log).unwrap();
    let mut lines: Vec<Vec<&str>> = told.lines().map(|line| line.split(',').collect()).collect();
    let header = lines.iter().position(|cells| cells[0] == "time").unwrap();
    let column = lines[header].iter().position(|name| *name == format!("{joint}/effort")).unwrap();
    for row in header + 1..lines.len() - rows {
        lines[row][column] = lines[row + rows][column];
    }
    lines.truncate(lines.len() - rows);
    let lines: Vec<String> = lines.iter().map(|cells| cells.join(",")).collect();
    std::fs::write(log, lines.join("\n") + "\n").unwrap();
}

/// Of a leg that points upwards weight grows against the way, so that a delay takes back what friction adds: together they leave a
/// smaller error than the delay alone, and neither removes anything by itself.
#[test]
fn friction_and_a_delay_that_hide_one_another() {
    let upwards = |legs: &str, phase: f64| {
        format!(
            "{legs}left_hip_pitch = {{ position = 3.0, sines = [[0.3, 0.45, {phase}], [0.1, 0.7, {}]] }}\n",
            -phase
        )
    };
    let without = |motion: &str| -> String {
        let others = motion.lines().filter(|line| !line.starts_with("left"));
        others.map(|line| format!("{line}\n")).collect()
    };
    let calm = "left_knee_pitch = { position = 0.2, sines = [[0.1, 0.55, 1.5708], [0.05, 0.8, -1.5708]] }\n";
    let [train, judge] = [(TRAIN, -FRAC_PI_2), (JUDGE, FRAC_PI_2)]
        .map(|(motion, phase)| upwards(&(without(motion) + calm), phase));
    let place = "joint = \"left_hip_pitch\"";
    for torque in [0.3, 0.5] {
        let hidden = Hidden::moved(
            &format!("hidden_delay_{torque}"),
            &effect("coulomb_friction", place, &format!("torque = {torque}")),
            [&train, &judge],
            "6.2",
        );
        // 16 ms.
        hasten(&hidden.train, "left_hip_pitch", 4);
        hasten(&hidden.judge, "left_hip_pitch", 4);
        let (found, before, after) = hidden.amended(&[]);
        assert_eq!(found.len(), 2, "{found:?}");
        near(value(&found, "coulomb_friction", "torque"), torque, 0.02);
        near(value(&found, "actuator_delay", "delay"), 0.016, 0.01);
        assert!(after < 0.25 * before, "{before} {after}");
        let again = hidden.diagnosed(&[]);
        assert_eq!(again["steps"].as_array().unwrap().len(), 0, "{again}");
    }
}

#[test]
#[ignore = "takes long"]
fn a_mass_on_a_link() {
    let place = "link = \"left_tibia\"";
    let hidden =
        Hidden::simulated("mass", &effect("payload", place, "mass = 0.9\nx = 0.04\ny = 0.0\nz = -0.15"));
    let (found, before, after) = hidden.amended(&[]);
    assert_eq!(found.len(), 1, "{found:?}");
    near(value(&found, "payload", "mass"), 0.9, 0.01);
    near(value(&found, "payload", "z"), -0.15, 0.01);
    assert!(after < 0.1 * before, "{before} {after}");
}

#[test]
fn a_wrong_torque_constant() {
    let hidden =
        Hidden::simulated("gain", &effect("torque_gain", "joint = \"left_hip_pitch\"", "gain = 0.85"));
    let (found, before, after) = hidden.amended(&["--inertial", "none"]);
    assert_eq!(found.len(), 1, "{found:?}");
    near(value(&found, "torque_gain", "gain"), 0.85, 0.001);
    assert!(after < 0.1 * before, "{before} {after}");
}

/// True stiffness (N m/rad), viscous (N m s/rad) and Coulomb friction (N m) of drives that are described otherwise.
const LEG: [(&str, Option<f64>, f64, f64); 5] = [
    ("right_hip_yaw", None, 4.8e-5, 0.0075),
    ("right_hip_roll", None, 3.7e-4, 0.0195),
    ("right_hip_pitch", Some(118.0), 9.5e-5, 0.0052),
    ("right_knee_pitch", Some(105.0), 6.6e-5, 0.0031),
    ("right_ankle_pitch", Some(74.0), 4.6e-5, 0.0101),
];

/// TUlip's leg with its gears, springs and encoders; friction and springs are hidden.
fn leg(seed: u64, duration: f64) -> String {
    let mut text = format!(
        "duration = {duration:.1}\nstep = 0.001\nlog_step = 0.002\nseed = {seed}\ndrives = \"described\"\n[control]\nstiffness = 400.0\ndamping = 15.0\nservo = \"drive\"\njoint_stops = false\n[sensors]\ncurrent_noise = 0.005\n"
    );
    for (j, (joint, spring, viscous, coulomb)) in LEG.iter().enumerate() {
        let size = [0.08, 0.07, 0.15, 0.16, 0.13][j];
        let wave = |k: usize| {
            let phase = ((7 * j + 5 * k) as f64 + 3.3 * seed as f64).sin();
            [size * (1.0 + 0.3 * phase), 0.25 + 0.2 * k as f64 + 0.07 * phase, 3.0 * phase]
        };
        let position = if j == 3 { 0.75 } else { 0.0 };
        // Writing to a string cannot fail.
        let _ =
            writeln!(text, "[joint.{joint}]\nposition = {position:.2}\nsines = {:?}", [0, 1, 2, 3].map(wave));
        let _ = writeln!(text, "[motor.{joint}]\nviscous_friction = {viscous}\ncoulomb_friction = {coulomb}");
        if let Some(stiffness) = spring {
            let _ = writeln!(text, "stiffness = {stiffness:.1}");
        }
    }
    text
}

#[test]
#[ignore = "takes long"]
fn series_elastic_drives_are_identified_from_simulated_motors() {
    let folder = scratch("simulated_leg");
    let run = |name: &str, seed: u64, duration: f64| {
        let (scenario, log) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}.csv")));
        std::fs::write(&scenario, leg(seed, duration)).unwrap();
        let truth = folder.join(format!("{name}.json"));
        let words = ["simulate", "robots/tulip_v1_leg", "--scenario", text(&scenario), "--out", text(&log)];
        bipedc(&[&words[..], &["--truth", text(&truth)]].concat()).ok();
        let written: Value = serde_json::from_str(&std::fs::read_to_string(&truth).unwrap()).unwrap();
        assert_eq!(written["motors"]["right_knee_pitch"]["stiffness"], 105.0);
        log
    };
    let (train, judge) = (run("train", 1, 12.0), run("judge", 2, 8.0));
    let header = std::fs::read_to_string(&train).unwrap();
    let header = header.lines().next().unwrap();
    assert!(header.contains("right_knee_pitch/motor_position,right_knee_pitch/motor_current"), "{header}");
    assert!(!header.contains("effort"), "currents, not efforts, are measured: {header}");
    let words = ["identify", "robots/tulip_v1_leg", text(&train), "--method", "elastic", "--json"];
    let answer = bipedc(&[&words[..], &["--validate", text(&judge)]].concat()).ok().json();
    let joints = answer["drives"]["joints"].as_array().unwrap();
    for (name, spring, viscous, coulomb) in LEG {
        let joint = joints.iter().find(|joint| joint["joint"] == name).unwrap();
        let parameters = joint["parameters"].as_array().unwrap();
        let of = |parameter: &str| {
            let found = parameters.iter().find(|p| p["name"] == parameter);
            found.unwrap_or_else(|| panic!("{joint}"))["value"].as_f64().unwrap()
        };
        println!(
            "{name}: viscous {:.2} %, Coulomb {:.2} %",
            100.0 * (of("viscous_friction") / viscous - 1.0),
            100.0 * (of("coulomb_friction") / coulomb - 1.0)
        );
        near(of("viscous_friction"), viscous, 0.05);
        near(of("coulomb_friction"), coulomb, 0.05);
        if let Some(stiffness) = spring {
            println!("{name}: stiffness {:.3} %", 100.0 * (of("joint_stiffness") / stiffness - 1.0));
            near(of("joint_stiffness"), stiffness, 0.01);
        }
    }
}
