//! `bipedc excite`: motions designed for identification.
use crate::{cli, support};
use bipedc_analysis::robot::Trajectory;

use bipedc::feet;
use bipedc_analysis::identify::excite::{CLEARANCE_FUNCTIONS, Clearance};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::Argument;
use bipedc_runtime::nalgebra::DMatrix;
use cli::{Run, bipedc, scratch, text};
use serde_json::Value;
use std::path::Path;
use support::{Inputs, evaluate, read_robot};

const ROBOT: &str = "robots/tulip_v1_leg";
/// All joints, so that the base regressor of the whole leg is the oracle.
const JOINTS: &str =
    "right_hip_yaw,right_hip_roll,right_hip_pitch,right_knee_pitch,right_ankle_pitch,right_ankle_roll";

fn excite(file: &Path, options: &[&str]) -> Run {
    let fixed = ["excite", ROBOT, "--joints", JOINTS, "--acceleration", "20", "--json", "--out", text(file)];
    bipedc(&[&fixed, options].concat())
}

/// Positions, velocities and accelerations of all joints, row after row.
fn trajectory(file: &Path) -> Vec<[Vec<f64>; 3]> {
    let table = std::fs::read_to_string(file).unwrap();
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert!(
        head[0] == "time" && head[1].ends_with("_hip_yaw/position") && head[2].ends_with("_hip_yaw/velocity")
    );
    let row = |line: &str| {
        let values: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        [1, 2, 3].map(|from| values[from..].iter().copied().step_by(3).collect())
    };
    lines.map(row).collect()
}

fn model(function: &str) -> ProgramModel {
    let request = FunctionRequest::of_robot(function);
    ProgramModel::new(read_robot("tulip_v1_leg").compile_only(&[request]).unwrap())
}

fn inputs([q, v, a]: &[Vec<f64>; 3]) -> Inputs {
    let of =
        |inputs: Inputs, (argument, values): (Argument, &Vec<f64>)| inputs.with(argument, values.clone());
    [(Argument::Q, q), (Argument::V, v), (Argument::A, a)].into_iter().fold(Inputs::default(), of)
}

/// Condition number of the stacked base regressor (thesis 5.9), columns of length 1, by its singular values.
fn condition_number(trajectory: &[[Vec<f64>; 3]], joints: usize) -> (f64, usize) {
    let function = "inverse_dynamics_base_regressor";
    let model = model(function);
    let blocks: Vec<Vec<f64>> =
        trajectory.iter().map(|state| evaluate(&model, function, &inputs(state))).collect();
    let columns = blocks[0].len() / joints;
    let mut stacked =
        DMatrix::from_fn(blocks.len() * joints, columns, |i, j| blocks[i / joints][j * joints + i % joints]);
    stacked.column_iter_mut().for_each(|mut column| _ = column.normalize_mut());
    let singular = stacked.singular_values();
    (singular.max() / singular.min(), columns)
}

/// So many rows, evenly from the first to the last.
fn thinned(rows: &[[Vec<f64>; 3]], count: usize) -> Vec<[Vec<f64>; 3]> {
    let last = (rows.len() - 1) as f64;
    (0..count).map(|i| rows[(last * i as f64 / (count - 1) as f64).round() as usize].clone()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Without a single violation, at every row of the file.
fn assert_kept(answer: &Value, trajectory: &[[Vec<f64>; 3]]) {
    let model = model("inverse_dynamics");
    for state in trajectory {
        let tau = evaluate(&model, "inverse_dynamics", &inputs(state));
        for (k, joint) in answer["joints"].as_array().unwrap().iter().enumerate() {
            let (low, high) = (number(&joint["position_limits"][0]), number(&joint["position_limits"][1]));
            assert!((low..=high).contains(&state[0][k]), "{joint}: {}", state[0][k]);
            for (value, limit) in
                [(state[1][k], "velocity"), (state[2][k], "acceleration"), (tau[k], "effort")]
            {
                assert!(value.abs() <= number(&joint[format!("{limit}_limit")]), "{joint}: {limit} {value}");
            }
        }
    }
}

#[test]
#[ignore = "takes long"]
fn fourier_series_tell_more_than_polynomials_and_keep_all_limits() {
    let folder = scratch("excite_limits");
    let (series, powers) = (folder.join("fourier.csv"), folder.join("degree5.csv"));
    // Ten times as many rows as samples at which the design keeps its limits; no margin.
    let search = ["--starts", "1", "--evaluations", "120", "--margin", "0"];
    let fourier = excite(&series, &[&search[..], &["--rate", "2000"]].concat()).ok().json();
    let degree5 = excite(&powers, &[&search[..], &["--rate", "2000", "--degree5"]].concat()).ok().json();
    let (rows, others) = (trajectory(&series), trajectory(&powers));
    assert_eq!(rows.len(), 20_001);
    assert_kept(&fourier, &rows);
    assert_kept(&degree5, &others);
    // At the times at which the design judges its motions, to a quarter of a millisecond.
    let (best, columns) = condition_number(&thinned(&rows, 640), 6);
    let (other, _) = condition_number(&thinned(&others, 480), 6);
    println!("condition number: Fourier {best:.2}, degree 5 {other:.2}");
    assert_eq!(fourier["base_parameters"], columns);
    for (own, answer) in [(best, &fourier), (other, &degree5)] {
        let said = answer["after"]["condition_number"].as_f64().unwrap();
        assert!((said / own - 1.0).abs() < 0.003, "{said} instead of {own}");
    }
    let before = fourier["before"]["condition_number"].as_f64().unwrap();
    assert!(best < 0.5 * before, "{best} after {before}");
    assert!(best < other, "{best} against {other}");
    // At rest at both ends.
    for state in [&rows[0], &rows[rows.len() - 1]] {
        assert!(state[1].iter().chain(&state[2]).all(|x| *x == 0.0), "{state:?}");
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2, "temporaries are left");
}

/// Least distance of TUlip's soles along a motion: of points all over both rectangles, never less than the true one.
fn soles_apart(rows: &[[Vec<f64>; 3]]) -> f64 {
    let corners = ["front_left", "front_right", "rear_left", "rear_right"];
    let name = |side: &str, corner: &str| format!("{side}_foot/{corner}");
    let request = |subject| FunctionRequest { family: "position".to_owned(), subject: Some(subject) };
    let names = ["left", "right"].map(|side| corners.map(|corner| name(side, corner)));
    let requests: Vec<FunctionRequest> =
        names.iter().flatten().map(|layout| request(layout.clone())).collect();
    let model = ProgramModel::new(hanging().compile_only(&requests).unwrap());
    let sole = |names: &[String; 4], state: &[Vec<f64>; 3]| -> Vec<Vec<f64>> {
        let place = |name: &String| {
            evaluate(&model, &format!("position_of_{}", name.replace('/', "_")), &inputs(state))
        };
        let at = names.each_ref().map(place);
        let part = |i: usize, j: usize, axis: usize| {
            let [x, y] = [i as f64 / 8.0, j as f64 / 8.0];
            let [front, rear] = [0, 2].map(|k| (1.0 - y) * at[k][axis] + y * at[k + 1][axis]);
            (1.0 - x) * front + x * rear
        };
        (0..81).map(|k| (0..3).map(|axis| part(k / 9, k % 9, axis)).collect()).collect()
    };
    let apart = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let mut least = f64::INFINITY;
    for state in rows {
        let [left, right] = names.each_ref().map(|names| sole(names, state));
        let all = left.iter().flat_map(|a| right.iter().map(move |b| apart(a, b)));
        least = all.fold(least, f64::min);
    }
    least.sqrt()
}

fn hanging() -> Robot {
    read_robot("tulip").with_base("fixed", None).unwrap()
}

#[test]
#[ignore = "takes long"]
fn feet_are_kept_apart() {
    let folder = scratch("excite-feet");
    let hips =
        ["left", "right"].map(|side| ["yaw", "roll", "pitch"].map(|axis| format!("{side}_hip_{axis}")));
    let hips = hips.concat().join(",");
    let design = |gap: &str| {
        let file = folder.join(format!("{gap}.csv"));
        let robot = ["excite", "robots/tulip", "--base", "fixed", "--joints", &hips, "--gap", gap, "--json"];
        let search = ["--duration", "2", "--harmonics", "3", "--starts", "1", "--evaluations", "40"];
        let answer = bipedc(&[&robot[..], &search, &["--out", text(&file)]].concat()).json();
        (number(&answer["feet_distance"]), soles_apart(&trajectory(&file)))
    };
    let (said, seen) = design("0.06");
    assert!(said >= 0.06 && seen >= 0.06 - 1e-9, "{said} {seen}");
    assert!(seen > said - 1e-9, "{said} {seen}");
    let (_, free) = design("0");
    assert!(free < 0.06, "the limit changes nothing: {free}");
}

#[test]
fn the_gradient_of_near_feet_is_that_of_their_excess() {
    let robot = hanging();
    let requests = CLEARANCE_FUNCTIONS.map(FunctionRequest::of_robot);
    let model = ProgramModel::new(robot.compile_only(&requests).unwrap());
    let clearance = Clearance::new(Box::new(model), &feet(&robot.description), 0.1).unwrap();
    let (count, joints) = (6, 12);
    let q: Vec<f64> = (0..count * joints).map(|k| 0.25 * (1.7 * k as f64).sin()).collect();
    let excess = |q: &[f64]| {
        let zero = vec![0.0; q.len()];
        let mut gradient = zero.clone();
        let mut motion = Trajectory::with_widths(joints, joints, joints);
        motion.extend([q, &zero, &zero]);
        (clearance.excess(&motion, &mut gradient), gradient)
    };
    let (value, gradient) = excess(&q);
    assert!(value > 1e-3, "{value}");
    for k in 0..q.len() {
        let moved = |by: f64| {
            let mut q = q.clone();
            q[k] += by;
            excess(&q).0
        };
        let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
        assert!((slope - gradient[k]).abs() < 1e-7, "{k}: {slope} {}", gradient[k]);
    }
    // TUlip's hips roll.
    assert!(!clearance.is_sagittal());
}

#[test]
fn a_seed_always_gives_the_same_bytes() {
    let folder = scratch("excite_seed");
    let design = |name: &str, seed: &str| {
        let file = folder.join(name);
        excite(&file, &["--starts", "1", "--evaluations", "20", "--seed", seed]).ok();
        std::fs::read(file).unwrap()
    };
    let first = design("a.csv", "7");
    assert_eq!(first, design("b.csv", "7"));
    assert_ne!(first, design("c.csv", "8"));
}

/// Within the last start too, where no other one is left out.
#[test]
fn a_time_limit_that_cuts_the_search_short_is_told() {
    let out = scratch("excite_time").join("knee.csv");
    let search = |limit: &str, more: &[&str]| {
        let robot = ["excite", ROBOT, "--joints", "right_knee_pitch", "--duration", "2", "--harmonics", "2"];
        let search = ["--starts", "1", "--evaluations", "30", "--time-limit", limit, "--out", text(&out)];
        bipedc(&[&robot[..], &search, more].concat()).ok()
    };
    let words = "warning: time ran out: another run with this seed may give another motion";
    let (short, long) = (search("1e-6", &[]), search("600", &[]));
    assert!(short.out.contains(words), "{}", short.out);
    assert!(!long.out.contains("warning"), "{}", long.out);
    for (limit, late) in [("1e-6", true), ("600", false)] {
        let answer = search(limit, &["--json"]).json();
        assert_eq!(
            (&answer["out_of_time"], &answer["interrupted"]),
            (&Value::Bool(late), &Value::Bool(false))
        );
    }
    let apart =
        ["--separate", "coulomb_friction", "viscous_friction", "--joint", "right_knee_pitch", "--json"];
    for (limit, late) in [("1e-6", true), ("600", false)] {
        let warnings = search(limit, &apart).json()["warnings"].to_string();
        assert_eq!(warnings.contains("time ran out"), late, "{warnings}");
    }
}

/// Adds the columns of the efforts that the model needs, with normally distributed noise (N m), to a trajectory's file.
fn add_efforts(file: &Path, noise: f64) {
    let model = model("inverse_dynamics");
    let mut random = 1_u64;
    let mut uniform = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((random >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let table = std::fs::read_to_string(file).unwrap();
    let mut lines = table.lines();
    let names: Vec<String> = JOINTS.split(',').map(|joint| format!("{joint}/effort")).collect();
    let mut log = format!("{},{}\n", lines.next().unwrap(), names.join(","));
    for (line, state) in lines.zip(trajectory(file)) {
        let tau = evaluate(&model, "inverse_dynamics", &inputs(&state));
        let tau: Vec<String> = tau.iter().map(|tau| (tau + noise * normal()).to_string()).collect();
        log.push_str(&format!("{line},{}\n", tau.join(",")));
    }
    std::fs::write(file, log).unwrap();
}

fn identified(file: &Path, more: &[&str]) -> Value {
    let words = ["identify", ROBOT, text(file), "--cutoff", "20", "--friction", "none", "--json"];
    bipedc(&[&words[..], more].concat()).ok().json()
}

#[test]
fn a_trajectory_with_efforts_is_a_log() {
    let file = scratch("excite_log").join("log.csv");
    excite(&file, &["--starts", "1", "--evaluations", "20"]).ok();
    add_efforts(&file, 0.0);
    let answer = identified(&file, &[]);
    assert_eq!(answer["unseen"], serde_json::json!([]));
    assert_eq!(answer["parameters"].as_array().unwrap().len(), 36);
    for parameter in answer["parameters"].as_array().unwrap() {
        let [value, nominal] = ["value", "nominal"].map(|key| parameter[key].as_f64().unwrap());
        assert!((value - nominal).abs() < 1e-3 * nominal.abs().max(0.1), "{parameter}");
    }
}

/// The measure of the thesis (5.16): series against polynomials of degree 5 by the same limits, and what that is worth
/// with equal noise. The joints with a motor move.
#[test]
#[ignore = "takes long"]
fn standard_errors_fall_with_the_condition_number() {
    let folder = scratch("excite_errors");
    let designed = |name: &str, more: &[&str]| {
        let file = folder.join(name);
        let words =
            ["excite", ROBOT, "--acceleration", "20", "--json", "--rate", "250", "--out", text(&file)];
        let search = ["--criterion", "unscaled", "--starts", "1", "--evaluations", "400"];
        let answer = bipedc(&[&words[..], &search, more].concat()).ok().json();
        add_efforts(&file, 0.05);
        let parameters = identified(&file, &["--estimator", "ordinary"])["parameters"].clone();
        let errors = parameters.as_array().unwrap().iter().map(|p| number(&p["independent_error"]));
        (number(&answer["after"]["unscaled_condition_number"]), errors.collect::<Vec<f64>>())
    };
    let (series, finer) = designed("series.csv", &["--harmonics", "10"]);
    let (powers, coarser) = designed("powers.csv", &["--degree5"]);
    let (resting, coarsest) = designed("resting.csv", &["--degree5", "--at-rest"]);
    let fall = |errors: &[f64]| {
        let ratios = errors.iter().zip(&finer).map(|(a, b)| (a / b).ln());
        (ratios.sum::<f64>() / finer.len() as f64).exp()
    };
    let [moving, still] = [&coarser, &coarsest].map(|errors| fall(errors));
    println!(
        "condition numbers {series:.1}, {powers:.1}, {resting:.1}; errors {moving:.2}, {still:.2} times as large"
    );
    assert!(series < powers / 3.0 && powers < resting);
    assert!(moving > 1.5 && still > moving);
}

#[test]
fn joints_that_do_not_move_are_held() {
    let file = scratch("excite_held").join("knee.csv");
    let run = bipedc(&[
        "excite",
        ROBOT,
        "--joints",
        "right_hip_pitch,right_knee_pitch",
        "--starts",
        "1",
        "--evaluations",
        "30",
        "--degree5",
        "--out",
        text(&file),
    ])
    .ok();
    for words in ["held: `right_hip_yaw` at 0", "polynomials of degree 5", "condition number", "rows in"] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
    for [q, v, _] in trajectory(&file) {
        assert!([0, 1, 4, 5].iter().all(|k: &usize| q[*k] == 0.0 && v[*k] == 0.0));
    }
}

#[test]
fn what_is_impossible_is_said() {
    let folder = scratch("excite_impossible");
    let out = folder.join("never.csv");
    let fails = |arguments: &[&str], words: &[&str]| {
        bipedc(&[&["excite"], arguments, &["--out", text(&out)]].concat()).fails_with(words);
        assert!(!out.exists());
    };
    fails(&["robots/tulip"], &["base is fixed", "--base fixed"]);
    fails(&[ROBOT, "--joints", "elbow"], &["no joint `elbow`", "right_knee_pitch"]);
    fails(&[ROBOT, "--duration", "-1"], &["--duration is -1"]);
    fails(&[ROBOT, "--time-limit", "0"], &["--time-limit is 0"]);
    fails(&[ROBOT, "--margin", "95"], &["--margin is 95"]);
    fails(&[ROBOT, "--harmonics", "1"], &["1 harmonics"]);
    fails(&[ROBOT, "--acceleration", "nan"], &["--acceleration is NaN"]);
    // A hip that cannot carry the leg.
    let weak = folder.join("weak.urdf");
    let urdf = std::fs::read_to_string(support::project().join(ROBOT).join("robot.urdf")).unwrap();
    let limit = r#"lower="-0.5" upper="0.35" effort="20""#;
    assert!(urdf.contains(limit));
    std::fs::write(&weak, urdf.replace(limit, r#"lower="-0.5" upper="0.35" effort="0.1""#)).unwrap();
    let weakly = [
        text(&weak),
        "--base",
        "fixed",
        "--joints",
        "right_hip_roll",
        "--starts",
        "2",
        "--evaluations",
        "20",
    ];
    fails(&weakly, &["no motion keeps the limits", "`right_hip_roll` needs", "N m"]);
}

/// Contact points of a planar model have no y: its soles were looked for behind the end of a list.
#[test]
fn soles_of_planar_robots_pass_each_other() {
    let robot = read_robot("seven_link").with_base("fixed", None).unwrap();
    let requests = CLEARANCE_FUNCTIONS.map(FunctionRequest::of_robot);
    let model = ProgramModel::new(robot.compile_only(&requests).unwrap());
    let clearance = Clearance::new(Box::new(model), &feet(&robot.description), 0.02).unwrap();
    assert!(clearance.is_sagittal());
}
