//! Efforts from the currents of stiff drives.
use crate::free_run::cli::{bipedc, text};
use crate::free_run::leg::{JOINTS, Torques, log, motion, robot};
use crate::free_run::{free_run, number};
use serde_json::Value;

const GEAR: f64 = 111.0;
const TORQUE_CONSTANT: f64 = 0.0259;
/// At the motor shaft, N m.
const COULOMB: f64 = 0.002;
const EXAMPLE: &str = "tests/data/examples/elastic_leg/validation.csv.gz";

/// All six joints with the same stiff drive.
fn stiff(description: String) -> String {
    let head = description.split("[actuation]").next().unwrap().to_owned();
    let drive = |joint: &&str| {
        format!(
            "\n[drives.{joint}]\nkind = \"stiff\"\ngear_ratio = {GEAR:?}\nrotor_inertia = 3.35e-06\n\
             torque_constant = {TORQUE_CONSTANT}\nviscous_friction = 4e-05\ncoulomb_friction = {COULOMB}\n"
        )
    };
    head + &JOINTS.iter().map(drive).collect::<String>()
}

/// The drive's own function has rotor and viscous friction; Coulomb friction is added here. Angles are the motors'.
#[test]
fn currents_of_stiff_drives_are_efforts() {
    let folder = robot("currents_stiff", stiff);
    let file = folder.join("log.csv");
    let torques = Torques::new(&folder, "drive_inverse_dynamics");
    let current = |j: usize, t: f64| {
        let dry = GEAR * COULOMB * (motion(j, t)[1] / 0.02).tanh();
        (torques.at(t, &[0.0; 6])[j] + dry) / (GEAR * TORQUE_CONSTANT)
    };
    log(&file, &[("motor_position", &|j, t| GEAR * motion(j, t)[0]), ("motor_current", &current)]);
    let value = free_run(&folder, &file, &["0.2", "--cutoff", "90"]).ok().json();
    println!("efforts from currents: rms {} N m, free run {} rad", value["rms"], value["free_run"]["rms"]);
    for channel in value["channels"].as_array().unwrap() {
        assert!(number(&channel["relative"]) < 1e-6, "{channel}");
        assert_eq!(channel["unit"], "N m");
    }
    assert!(number(&value["free_run"]["rms"]) < 1e-6);
    let assumptions = value["assumptions"].to_string();
    for words in ["2.87490 N m/A", "rotor inertia 0.0413 kg m²", "coulomb friction 0.2220 N m", "/ 111"] {
        assert!(assumptions.contains(words), "no `{words}` in {assumptions}");
    }
    // An effect of the description stands in the place of the drive's number.
    let doubled = "\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"right_hip_yaw\"\ntorque = 0.444\n";
    let changed = robot("currents_doubled", |description| stiff(description) + doubled);
    let value = bipedc(&["compare", text(&changed), text(&file), "--cutoff", "90", "--json"]).ok().json();
    let yaw = &value["channels"][0];
    assert!((number(&yaw["rms"]) / 0.222 - 1.0).abs() < 0.1, "{yaw}");
}

/// Stiff joints of an example by another simulator, beside elastic ones: the description's friction is up to 23 % off there.
#[test]
fn stiff_joints_are_compared_beside_elastic_ones() {
    let compared = |folder: &str| bipedc(&["compare", folder, EXAMPLE, "--json"]).ok();
    let run = compared("robots/tulip_v1_leg");
    for words in ["right_knee_pitch/motor_current", "a spring lies between", "--method elastic"] {
        assert!(run.err.contains(words), "no `{words}` in {}", run.err);
    }
    // By motor shaft, as the example's truth says: yaw, roll; viscous, Coulomb.
    let truth = std::fs::read_to_string("tests/data/examples/elastic_leg/truth.json").unwrap();
    let effects = serde_json::from_str::<Value>(&truth).unwrap()["effects"].clone();
    let more: String = (0..2)
        .map(|k| {
            let of = |key: &str| number(&effects[k]["parameters"][key]);
            let joint = effects[k]["joint"].as_str().unwrap();
            let (viscous, dry) = (of("viscous_friction") * GEAR * GEAR, of("coulomb_friction") * GEAR);
            format!(
                "\n[[effect]]\nkind = \"viscous_friction\"\njoint = \"{joint}\"\ndamping = {viscous}\n\
                 \n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"{joint}\"\ntorque = {dry}\n"
            )
        })
        .collect();
    let known = compared(text(&robot("currents_known", |description| description + &more)));
    let relative = |run: &Value| {
        let channels = run["channels"].as_array().unwrap();
        let names: Vec<&Value> = channels.iter().map(|channel| &channel["name"]).collect();
        assert_eq!(names, ["right_hip_yaw", "right_hip_roll"]);
        [0, 1].map(|k| number(&channels[k]["relative"]))
    };
    let (described, known) = (relative(&run.json()), relative(&known.json()));
    println!("stiff joints from currents: described {described:?}, with the true friction {known:?}");
    assert!(known[0] < 0.05 && known[1] < 0.05 && known[0] < described[0] && known[1] < described[1]);
}

/// What `diagnose` makes of the same log: shaft angles are angles of the joints, so springs show as they are, and friction is
/// found beside them.
#[test]
#[ignore = "takes long"]
fn a_diagnosis_reads_currents_and_shaft_angles() {
    let words = ["diagnose", "robots/tulip_v1_leg", "tests/data/examples/elastic_leg/train.csv.gz"];
    let of = |more: &[&str]| {
        let words = [&words[..], &["--validate", EXAMPLE, "--inertial", "none", "--json"], more].concat();
        bipedc(&words).ok().json()
    };
    let trusting = of(&["--most", "0"]);
    assert!(trusting["warnings"].to_string().contains("friction of the drives"), "{}", trusting["warnings"]);
    let value = of(&["--refit"]);
    assert!(!value["warnings"].to_string().contains("friction of the drives"), "{}", value["warnings"]);
    assert!(value["assumptions"].to_string().contains("2.87490 N m/A"), "{}", value["assumptions"]);
    let parameter = |list: &str, kind: &str, joint: &str, name: &str| {
        let all = value[list].as_array().unwrap();
        let found = all.iter().find(|e| e["kind"] == kind && e["joint"] == joint);
        number(&found.unwrap_or_else(|| panic!("no {kind} at {joint} in {value}"))["parameters"][name])
    };
    // Stiffness of the cable's spring times the square of the load pulley's radius.
    for (joint, spring) in [("right_hip_pitch", 93_424.0), ("right_knee_pitch", 63_942.5)] {
        let ratio = parameter("effects", "series_elasticity", joint, "stiffness") / (spring * 0.04 * 0.04);
        println!("{joint}: stiffness {ratio} of the true one");
        assert!((ratio - 1.0).abs() < 0.005);
    }
    // Truth at the motor shaft, seen through the gear.
    let friction = [("right_hip_yaw", 3.6448e-5, 8.1592e-3), ("right_hip_roll", 3.6018e-4, 2.39811e-2)];
    for (joint, viscous, dry) in friction {
        let damping = parameter("standing", "viscous_friction", joint, "damping") / (viscous * GEAR * GEAR);
        let torque = parameter("standing", "coulomb_friction", joint, "torque") / (dry * GEAR);
        println!("{joint}: viscous {damping}, Coulomb {torque} of the true ones");
        assert!((damping - 1.0).abs() < 0.04 && (torque - 1.0).abs() < 0.02);
    }
}

#[test]
fn currents_without_a_drive_are_named() {
    let folder = robot("currents_none", |d| d.split("[actuation]").next().unwrap().to_owned());
    bipedc(&["compare", text(&folder), EXAMPLE]).fails_with(&[
        "`right_hip_yaw/motor_current`",
        "[drives.right_hip_yaw]",
        "torque_constant",
        "`right_hip_yaw/effort`",
    ]);
    bipedc(&["diagnose", text(&folder), EXAMPLE]).fails_with(&["`right_hip_yaw/motor_current`"]);
    let folder = robot("currents_no_constant", |d| d.replace("torque_constant = 0.0259 ", "# "));
    bipedc(&["compare", text(&folder), EXAMPLE]).fails_with(&[
        "no torque constant",
        "[drives.right_hip_roll]",
        "--method elastic",
    ]);
}
