//! `bipedc excite --separate`: motions that tell two effects apart.
use crate::{cli, support};

use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::Argument;
use cli::{Run, bipedc, scratch, text};
use serde_json::Value;
use std::path::Path;
use support::{Inputs, evaluate, read_robot};

const ROBOT: &str = "robots/tulip_v1_leg";
const JOINTS: [&str; 6] = [
    "right_hip_yaw",
    "right_hip_roll",
    "right_hip_pitch",
    "right_knee_pitch",
    "right_ankle_pitch",
    "right_ankle_roll",
];
const KNEE: &str = "right_knee_pitch";
/// Its index.
const K: usize = 3;

/// The sagittal joints above the ankle move.
fn separate(file: &Path, effects: [&str; 2], options: &[&str]) -> Run {
    let fixed = [
        "excite",
        ROBOT,
        "--joints",
        "right_hip_pitch,right_knee_pitch",
        "--acceleration",
        "20",
        "--starts",
        "2",
        "--evaluations",
        "120",
        "--json",
        "--out",
        text(file),
        "--separate",
    ];
    bipedc(&[&fixed[..], &effects, options].concat())
}

/// A time with positions, velocities and accelerations of all joints.
type Sample = (f64, [Vec<f64>; 3]);

fn trajectory(file: &Path) -> Vec<Sample> {
    let table = std::fs::read_to_string(file).unwrap();
    let row = |line: &str| {
        let values: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        (values[0], [1, 2, 3].map(|from| values[from..].iter().copied().step_by(3).collect()))
    };
    table.lines().skip(1).map(row).collect()
}

/// The knee alone swings slowly and as a sine; the others hang.
fn poor() -> Vec<Sample> {
    let omega = std::f64::consts::TAU * 0.1;
    let sample = |i: usize| {
        let time = 0.005 * i as f64;
        let (sin, cos) = (omega * time).sin_cos();
        let only = |x: f64| (0..JOINTS.len()).map(|j| if j == K { x } else { 0.0 }).collect();
        (time, [only(0.5 + 0.15 * sin), only(0.15 * omega * cos), only(-0.15 * omega * omega * sin)])
    };
    (0..4001).map(sample).collect()
}

/// Writes what a robot would log whose knee's torque is `knee` of its state and the rigid torque there, N m, with
/// normally distributed noise of 0.02 N m.
fn log(file: &Path, samples: &[Sample], knee: &dyn Fn([f64; 3], f64) -> f64) {
    let request = FunctionRequest::of_robot("inverse_dynamics");
    let model = ProgramModel::new(read_robot("tulip_v1_leg").compile_only(&[request]).unwrap());
    let mut random = 1_u64;
    let mut uniform = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((random >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let head = JOINTS.map(|joint| format!("{joint}/position,{joint}/effort")).join(",");
    let mut table = format!("time,{head}\n");
    for (time, [q, v, a]) in samples {
        let arguments = [(Argument::Q, q), (Argument::V, v), (Argument::A, a)];
        let inputs =
            arguments.into_iter().fold(Inputs::default(), |i, (argument, x)| i.with(argument, x.clone()));
        let mut tau = evaluate(&model, "inverse_dynamics", &inputs);
        tau[K] = knee([q[K], v[K], a[K]], tau[K]);
        table.push_str(&time.to_string());
        for (q, tau) in q.iter().zip(&tau) {
            table.push_str(&format!(",{q},{}", tau + 0.02 * normal()));
        }
        table.push('\n');
    }
    std::fs::write(file, table).unwrap();
}

/// Kinds at the knee that were found, and kinds that would do as well.
fn diagnosed(file: &Path) -> (Vec<String>, Vec<String>) {
    let answer =
        bipedc(&["diagnose", ROBOT, text(file), "--cutoff", "10", "--most", "1", "--json"]).ok().json();
    let kind = |effect: &Value| effect["kind"].as_str().unwrap().to_owned();
    let found = answer["effects"].as_array().unwrap().iter().map(kind).collect();
    let groups = answer["indistinguishable"].as_array().unwrap().iter();
    let alternatives =
        groups.flat_map(|group| group.as_array().unwrap()).flat_map(|set| set.as_array().unwrap());
    (found, alternatives.map(kind).collect())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Two single columns at one joint: the correlation is the cosine between them.
#[test]
#[ignore = "takes long"]
fn friction_is_told_apart_as_said() {
    let file = scratch("separate_friction").join("apart.csv");
    let answer = separate(&file, ["coulomb_friction", "viscous_friction"], &["--joint", KNEE]).ok().json();
    let velocities: Vec<f64> = trajectory(&file).iter().map(|(_, [_, v, _])| v[K]).collect();
    let dry: Vec<f64> = velocities.iter().map(|v| (v / 0.02).tanh()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let expected = dot(&dry, &velocities) / (dot(&dry, &dry) * dot(&velocities, &velocities)).sqrt();
    let (before, after) = (number(&answer["before"]["correlation"]), number(&answer["after"]["correlation"]));
    println!("Coulomb and viscous friction: {before:.4} before, {after:.4} after, {expected:.4} of the file");
    assert!((after - expected).abs() < 2e-3, "{after} instead of {expected}");
    assert!(after < before - 0.1, "{after} after {before}");
    // 0.6 N m of dry friction in one of five measured joints.
    let size = 0.6 * (dot(&dry, &dry) / dry.len() as f64 / 5.0).sqrt();
    assert!((number(&answer["after"]["sizes"][0]) / size - 1.0).abs() < 0.01);
    let rest = number(&answer["after"]["rests"][0]);
    assert!((rest / (size * (1.0 - expected * expected).sqrt()) - 1.0).abs() < 0.01);
    let deviations = rest * (5.0 * velocities.len() as f64).sqrt() / 0.1;
    assert!((number(&answer["after"]["deviations"][0]) / deviations - 1.0).abs() < 1e-9);
    let page = std::fs::read_to_string(support::project().join("docs/experiments.md")).unwrap();
    let keys = answer.as_object().unwrap().keys().chain(answer["after"].as_object().unwrap().keys());
    for key in keys {
        assert!(page.contains(&format!("`{key}`")), "docs/experiments.md does not explain `{key}`");
    }
}

/// A gear whose torque sensor has a wrong gain looks like a spring while the knee swings slowly.
#[test]
#[ignore = "takes long"]
fn a_designed_motion_ends_the_doubt_of_a_poor_one() {
    let folder = scratch("separate_diagnose");
    let (plan, good, bad) = (folder.join("apart.csv"), folder.join("good.csv"), folder.join("bad.csv"));
    let answer = separate(&plan, ["torque_gain", "parallel_spring"], &["--joint", KNEE, "--noise", "0.02"])
        .ok()
        .json();
    let [before, after] = ["before", "after"].map(|key| number(&answer[key]["correlation"]));
    println!("correlation {before:.4}, designed {after:.4}");
    assert!(after < 0.1 && after < 0.2 * before, "{after} after {before}");
    let gain = |_: [f64; 3], tau: f64| tau / 0.8;
    log(&bad, &poor(), &gain);
    log(&good, &trajectory(&plan), &gain);
    let ((first, doubts), (found, alternatives)) = (diagnosed(&bad), diagnosed(&good));
    println!("poor: {first:?} or {doubts:?}; designed: {found:?} or {alternatives:?}");
    for kind in ["torque_gain", "parallel_spring"] {
        assert!(doubts.iter().any(|doubt| doubt == kind), "{doubts:?}");
    }
    assert_eq!(found, ["torque_gain"]);
    assert!(!alternatives.iter().any(|other| other == "parallel_spring"), "{alternatives:?}");
}

#[test]
fn what_no_motion_tells_and_wrong_use_are_refused() {
    let folder = scratch("separate_refused");
    let out = folder.join("never.csv");
    let fails = |effects: [&str; 2], options: &[&str], words: &[&str]| {
        separate(&out, effects, options).fails_with(words);
        assert!(!out.exists());
    };
    let at_knee = ["--joint", KNEE];
    fails(
        ["rotor_inertia", "coulomb_frictoin"],
        &at_knee,
        &["no effect `coulomb_frictoin`", "did you mean `coulomb_friction`"],
    );
    fails(["rotor_inertia", "payload"], &at_knee, &["`payload` needs a link", "--link LINK"]);
    fails(["rotor_inertia", "coupling"], &at_knee, &["two different joints", "--other-joint"]);
    fails(["viscous_friction", "torque_bias"], &[], &["needs a joint"]);
    fails(["viscous_friction", "ground_compliance"], &at_knee, &["only in contact with the ground"]);
    fails(["viscous_friction", "series_elasticity"], &at_knee, &["motor's angle"]);
    fails(["viscous_friction", "torque_bias"], &["--joint", "elbow"], &["no joint `elbow`"]);
    fails(
        ["rotor_inertia", "payload"],
        &["--joint", KNEE, "--link", "right_lower_lek"],
        &["no link `right_lower_lek`", "did you mean `right_lower_leg`"],
    );
    fails(
        ["viscous_friction", "torque_bias"],
        &["--joint", KNEE, "--link", "right_foot"],
        &["neither effect is at such a place: --link"],
    );
    fails(
        ["viscous_friction", "torque_bias"],
        &["--joint", KNEE, "--noise", "0"],
        &["noise of torques is 0"],
    );
    fails(["viscous_friction", "torque_bias"], &["--joint", "a,b,c"], &["--joint names 3 places"]);
    // The ankle is held, so its friction is never seen.
    fails(
        ["viscous_friction", "torque_bias"],
        &["--joint", "right_ankle_pitch"],
        &["changes no measured torque", "--joints"],
    );
    // One contains the other.
    fails(["coulomb_friction", "stribeck_friction"], &at_knee, &["whatever Coulomb friction", "can do too"]);
    let first = ["--joints", "right_hip_yaw", "--joint", "right_hip_yaw", "--link", "right_hip_yaw_link"];
    let words = ["excite", ROBOT, "--out", text(&out), "--separate", "rotor_inertia", "inertia_error"];
    bipedc(&[&words[..], &first].concat()).fails_with(&["canonical correlation is 1 along every motion"]);
}
