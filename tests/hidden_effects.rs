//! The generator of the scoreboard: same bytes every time, physics as stated, formulas that agree with another
//! simulator's numbers.
#[path = "../examples/hidden_effects/generator/mod.rs"]
#[allow(dead_code, unused_imports)]
pub mod generator;
#[path = "../examples/hidden_effects/score/mod.rs"]
#[allow(dead_code, unused_imports)]
pub mod score;

use generator::{Group, Plan, Truth, all, generate};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn plan(name: &str) -> Plan {
    all().into_iter().find(|plan| plan.name == name).unwrap_or_else(|| panic!("no case `{name}`"))
}

pub fn made(name: &str, folder: &str) -> (Truth, PathBuf) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hidden_effects").join(folder).join(name);
    (generate(&plan(name), &root(), &folder).unwrap(), folder)
}

/// A case with the numbers of another draw, as `hidden_effects --seed` makes it.
pub fn drawn(name: &str, seed: u64, folder: &str) -> (Truth, PathBuf) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hidden_effects").join(folder).join(name);
    let mut plan = plan(name);
    plan.seed = format!("{name} {seed}");
    (generate(&plan, &root(), &folder).unwrap(), folder)
}

#[test]
fn cases_are_as_many_as_promised() {
    let plans = all();
    let names: BTreeSet<&str> = plans.iter().map(|plan| plan.name.as_str()).collect();
    assert_eq!(names.len(), plans.len(), "two cases have one name");
    let count = |group: Group| plans.iter().filter(|plan| plan.group == group).count();
    assert!(plans.len() >= 70 && count(Group::Pair) == 21 && count(Group::Clean) >= 5);
    assert_eq!((count(Group::Cad), count(Group::CadAndEffect), count(Group::Outside)), (6, 15, 6));
    let robots: BTreeSet<&str> = plans.iter().map(|plan| plan.robot).collect();
    assert!(robots.len() >= 11, "{robots:?}");
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for part in plans.iter().filter(|plan| plan.group != Group::Outside).flat_map(|plan| &plan.parts) {
        assert!(bipedc_effects::effect::kind(part.kind).is_some(), "no kind `{}`", part.kind);
        *kinds.entry(part.kind).or_default() += 1;
    }
    // Inertial corrections are what CAD errors come out as; they are no cause that is looked for.
    let unseen =
        ["formula", "inertial_correction", "point_feet", "no_impact", "single_mass", "decoupled_planes"];
    for kind in bipedc_effects::effect::KINDS.iter().filter(|kind| !unseen.contains(&kind.name)) {
        let cases = kinds.get(kind.name).copied().unwrap_or(0);
        assert!(cases >= 2, "`{}` is in {cases} cases", kind.name);
    }
}

/// What is hidden acts where something moves.
#[test]
fn few_joints_move_where_few_are_to_move() {
    let few: Vec<Plan> = all().into_iter().filter(|plan| !plan.moving.is_empty()).collect();
    assert!(few.len() >= 8 && few.iter().all(|plan| plan.name.starts_with("few_joints")));
    for plan in &few {
        let robot = generator::model::read(&plan.folder(&root()), true).unwrap();
        let there = |name: &&str| robot.description.joints.iter().any(|joint| joint.name == **name);
        assert!((2..=4).contains(&plan.moving.len()) && plan.moving.iter().all(there), "{}", plan.name);
        let moves = |joint: &String| plan.moving.contains(&joint.as_str());
        assert!(plan.parts.iter().filter_map(|part| part.place.joint.as_ref()).all(moves), "{}", plan.name);
    }
}

#[test]
#[ignore = "takes long"]
fn a_case_is_the_same_every_time() {
    for name in ["impacts_foot_slip-2", "postures_payload-1", "asymmetric_coulomb_friction-2"] {
        let [first, second] = ["first", "second"].map(|folder| made(name, folder).1);
        for file in ["train.csv", "validation.csv", "truth.json"] {
            let read = |folder: &Path| std::fs::read(folder.join(file)).unwrap();
            assert!(read(&first) == read(&second), "{name}: {file} differs");
        }
    }
}

/// Without the effect the residual is far above the noise, with it close to it.
#[test]
#[ignore = "takes long"]
fn hidden_effects_are_all_that_is_hidden() {
    for name in ["viscous_friction-2", "torque_gain-2"] {
        let (truth, _) = made(name, "smooth");
        let floor = (truth.noise.values().map(|s| s * s).sum::<f64>() / truth.noise.len() as f64).sqrt();
        assert!(truth.oracle < 1.03 * floor && truth.nominal > 3.0 * floor, "{name}: {truth:?}");
    }
    let (clean, _) = made("clean_hanging-2", "smooth");
    assert_eq!(clean.nominal, clean.oracle);
    let (impact, _) = made("impacts_impact_restitution-1", "smooth");
    assert!(impact.oracle < 0.03 * impact.nominal, "{impact:?}");
    let (postures, _) = made("postures_com_offset-1", "smooth");
    assert!(postures.oracle < 0.05 * postures.nominal, "{postures:?}");
}

/// Nominal and true errors of logs that another simulator made, as it states them.
#[test]
#[ignore = "takes long"]
fn our_formulas_agree_with_the_examples() {
    for (name, tolerance) in [("coulomb", 0.01), ("rotor_inertia", 0.01)] {
        let folder = root().join("tests/data/examples").join(name);
        let (truth, _) = score::example_truth(&folder.join("truth.json"), name).unwrap();
        let robot = root().join("robots").join(&truth.robot);
        let log = folder.join("validation.csv.gz");
        let error = |effects| score::error_with(&robot, &log, effects, false).unwrap();
        let (nominal, oracle) = (error(&[]), error(&truth.effects));
        assert!((nominal / truth.nominal - 1.0).abs() < tolerance, "{name}: {nominal} {}", truth.nominal);
        assert!((oracle / truth.oracle - 1.0).abs() < tolerance, "{name}: {oracle} {}", truth.oracle);
    }
}

/// What the command says about a case, and what was hidden.
fn diagnosed(name: &str) -> (serde_json::Value, Truth) {
    let (truth, folder) = made(name, "diagnosed");
    (asked(name, &folder), truth)
}

/// The same of the case that another seed draws.
fn diagnosed_of_seed(name: &str, seed: u64) -> (serde_json::Value, Truth) {
    // Tests of the same case with other seeds run at the same time.
    let folder = format!("hidden_effects/seeds/{seed}/{name}");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    let plan = Plan { seed: format!("{name} {seed}"), ..plan(name) };
    let truth = generate(&plan, &root(), &folder).unwrap();
    (asked(name, &folder), truth)
}

fn asked(name: &str, folder: &Path) -> serde_json::Value {
    asked_with(name, folder, &[])
}

fn asked_with(name: &str, folder: &Path, options: &[&str]) -> serde_json::Value {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_bipedc"))
        .args(["diagnose", "--json"])
        .args([plan(name).folder(&root()), folder.join("train.csv")])
        .arg("--validate")
        .arg(folder.join("validation.csv"))
        .args(options)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The one effect that was found is of this kind, and its parameter within 15 %.
fn is_found(answer: &serde_json::Value, truth: &Truth, kind: &str, parameter: &str) {
    let effects = answer["effects"].as_array().unwrap();
    assert_eq!((effects.len(), &effects[0]["kind"]), (1, &kind.into()), "{effects:?}");
    let found = effects[0]["parameters"][parameter].as_f64().unwrap();
    let wanted = truth.effects[0].value(parameter);
    assert!((found / wanted - 1.0).abs() < 0.15, "{found} for {wanted}");
}

/// The ground's compliance shows in no force: base and joints tell how deep the soles lie.
#[test]
#[ignore = "takes long"]
fn soft_ground_is_found_from_sinking_soles() {
    let (answer, truth) = diagnosed("swaying_ground_compliance-1");
    is_found(&answer, &truth, "ground_compliance", "stiffness");
    // Corner heights fall to the noise of base and joints.
    let sole = &answer["rms"]["sole"];
    let [before, after] = ["before", "after"].map(|key| sole[key].as_f64().unwrap());
    assert!(after < 0.1 * before, "{before} m to {after} m");
}

#[test]
#[ignore = "takes long"]
fn a_spinning_foot_is_found_from_flat_impacts() {
    let (answer, truth) = diagnosed("flatimpacts_spin_friction-1");
    is_found(&answer, &truth, "spin_friction", "radius");
    let after = answer["rms_after"].as_f64().unwrap();
    assert!(after < 1.1 * truth.oracle && truth.oracle < 0.2 * truth.nominal, "{after} {truth:?}");
}

/// Few of these feet slip, and little: of any two starts of the search one leaves half of it, the other twice as much or all.
#[test]
fn slip_of_few_feet_is_found() {
    let (answer, truth) = diagnosed_of_seed("impacts_foot_slip-2", 611263);
    is_found(&answer, &truth, "foot_slip", "friction");
    let after = answer["rms_after"].as_f64().unwrap();
    assert!(after < 1.1 * truth.oracle && truth.oracle < 0.05 * truth.nominal, "{after} {truth:?}");
}

/// The rise of friction towards rest is over within a few degrees of a reversal. From samples far away from those dry friction was found behind 16 Hz, and
/// something left; samples nearer to them tell it.
#[test]
#[ignore = "takes long"]
fn friction_that_rises_towards_rest_is_seen_near_reversals() {
    let (answer, truth) = diagnosed_of_seed("stribeck_friction-1", 60101);
    is_found(&answer, &truth, "stribeck_friction", "static");
    let [low, high] = [0, 1].map(|end| answer["effects"][0]["ci95"]["static"][end].as_f64().unwrap());
    let wanted = truth.effects[0].value("static");
    assert!(low <= wanted && wanted <= high && high - low < 0.15, "{low} to {high} for {wanted}");
    // What steps of the simulation leave at a hip, at twice its small noise, is spoken of, and nothing at the joint.
    let joint = truth.effects[0].location.joint.clone().unwrap();
    assert!(!answer["suspects"].to_string().contains(&joint), "{}", answer["summary"]);
}

/// The first look is behind 10 Hz; what it leaves is looked at with a faster filter, unless one is given.
#[test]
#[ignore = "takes long"]
fn a_faster_filter_has_a_second_look() {
    let (answer, truth) = diagnosed_of_seed("stribeck_friction-2", 737373);
    is_found(&answer, &truth, "stribeck_friction", "static");
    assert!(answer["cutoff_hz"].as_f64().unwrap() > 10.0, "{}", answer["cutoff_hz"]);
    assert!(
        answer["summary"].as_str().unwrap().contains("both behind a filter of 10 Hz"),
        "{}",
        answer["summary"]
    );
    let folder =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join("hidden_effects/seeds/737373/stribeck_friction-2");
    let given = asked_with("stribeck_friction-2", &folder, &["--cutoff", "10"]);
    assert_eq!(given["cutoff_hz"], 10.0, "{}", given["summary"]);
}

/// Encoders of this arm are so coarse that behind 10 Hz noise of accelerations is fourteen times that of the torque.
#[test]
#[ignore = "takes long"]
fn a_slower_filter_has_a_second_look() {
    let (answer, truth) = diagnosed_of_seed("arm_stribeck_friction-1", 60101);
    is_found(&answer, &truth, "stribeck_friction", "coulomb");
    assert!(answer["cutoff_hz"].as_f64().unwrap() < 10.0, "{}", answer["cutoff_hz"]);
    let row = &answer["rows"]["turn"];
    let [after, noise] = ["after_moving", "noise"].map(|key| row[key].as_f64().unwrap());
    assert!(after < 4.0 * noise, "{after} N m, noise {noise} N m");
}

/// All samples with the smoothed sign gave friction 1 % large and an inertia that is not there, outside its interval.
#[test]
#[ignore = "takes long"]
fn what_rubs_in_two_joints_is_that_of_a_sharp_sign() {
    let (answer, truth) = diagnosed("coupling-2");
    let [found] = &answer["effects"].as_array().unwrap()[..] else { panic!("{answer:#}") };
    assert_eq!(found["kind"], "coupling", "{found:#}");
    assert!(found["ci95"].get("stiffness").is_none(), "a term that is not there: {found:#}");
    for parameter in ["coulomb", "damping"] {
        let [low, high] = [0, 1].map(|end| found["ci95"][parameter][end].as_f64().unwrap());
        let wanted = truth.effects[0].value(parameter);
        assert!(low <= wanted && wanted <= high, "{parameter}: {low} to {high} for {wanted}");
    }
    let coulomb = found["parameters"]["coulomb"].as_f64().unwrap();
    assert!((coulomb / truth.effects[0].value("coulomb") - 1.0).abs() < 0.005, "{found:#}");
}

/// CAD errors scale with the robot: centres of mass that are off by millimetres are a cause in a robot of 2 kg.
#[test]
#[ignore = "takes long"]
fn small_robots_keep_their_causes() {
    let (answer, truth) = diagnosed("small_biped_com_offset-1");
    let hidden = &truth.effects[0];
    let found = &answer["effects"].as_array().unwrap()[..];
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (&found[0]["kind"], found[0]["link"].as_str()),
        (&"com_offset".into(), hidden.location.link.as_deref())
    );
    assert_eq!(answer["inertial_corrections"].as_array().unwrap().len(), 0);
    let axes = ["x", "y", "z"];
    let off = |axis: &&str| found[0]["parameters"][axis].as_f64().unwrap() - hidden.value(axis);
    let distance = |of: &dyn Fn(&&str) -> f64| axes.iter().map(|axis| of(axis).powi(2)).sum::<f64>().sqrt();
    assert!(distance(&off) < 0.15 * distance(&|axis| hidden.value(axis)), "{found:?} for {hidden:?}");
}

/// Where a joint sticks its friction is anything between its bounds: what those samples seem to say of delays and of friction at
/// low speed is not so.
#[test]
#[ignore = "takes long"]
fn sticking_joints_have_no_delay() {
    for name in ["scara_stribeck_friction-1", "stribeck_friction-2"] {
        let (answer, truth) = diagnosed(name);
        let found = answer["effects"].as_array().unwrap();
        assert_eq!(found.len(), 1, "{name}: {found:?}");
        for parameter in ["coulomb", "static"] {
            is_found(&answer, &truth, "stribeck_friction", parameter);
        }
        let joint = truth.effects[0].location.joint.as_deref().unwrap();
        let told = answer["assumptions"].as_array().unwrap().iter().filter_map(|line| line.as_str());
        let line =
            told.filter(|line| line.contains("in or next to a part of their samples")).collect::<Vec<_>>();
        assert!(line.len() == 1 && line[0].contains(&format!("{joint} ")), "{line:?}");
    }
}

/// An exact estimate may put friction at rest below that at speed, where a joint hardly ever is that slow: dry friction is all that is there.
#[test]
#[ignore = "takes long"]
fn friction_is_no_less_at_rest() {
    let (answer, truth) = diagnosed_of_seed("standing_coulomb_friction-1", 918_273);
    is_found(&answer, &truth, "coulomb_friction", "torque");
}

/// Sliding joints have newtons and metres per second, and the sign of their friction changes within their own speeds.
#[test]
#[ignore = "takes long"]
fn sliding_joints_have_their_own_units() {
    let name = "gantry_asymmetric_coulomb_friction-1";
    let (answer, truth) = diagnosed(name);
    for parameter in ["positive", "negative"] {
        is_found(&answer, &truth, "asymmetric_coulomb_friction", parameter);
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sliding");
    std::fs::create_dir_all(&folder).unwrap();
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(plan(name).folder(&root()).join(file), folder.join(file)).unwrap();
    }
    let _ = std::fs::remove_file(folder.join("history.json"));
    let found = folder.join("found.json");
    std::fs::write(&found, answer.to_string()).unwrap();
    let amended = std::process::Command::new(env!("CARGO_BIN_EXE_bipedc"))
        .arg("amend")
        .args([&folder, Path::new("--from"), &found])
        .output()
        .unwrap();
    assert!(amended.status.success(), "{}", String::from_utf8_lossy(&amended.stderr));
    let text = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    let line =
        |key: &str| text.lines().find(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{text}"));
    assert!(line("positive = ").contains("# N,"), "{text}");
    assert!(line("smoothing = ").contains("# m/s"), "{text}");
    let width: f64 = line("smoothing = ").split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!(width < 0.02, "{text}");
}

/// A position controller whose drive is too weak asks for a hundred times what it gets, and the noise of what it asks for is nearly as large as the limit.
#[test]
fn a_limit_is_found_where_commands_run_away_from_it() {
    let (answer, _) = diagnosed_of_seed("arm_torque_saturation-1", 554433);
    assert_eq!(answer["effects"][0]["kind"], "torque_saturation", "{}", answer["effects"]);
    assert_eq!(answer["effects"][0]["joint"], "elbow");
    let [before, after] = ["rms_before", "rms_after"].map(|key| answer[key].as_f64().unwrap());
    assert!(after < 0.02 * before, "{before} {after}");
}

/// Drives that are at their limit nearly all the time: noise of the command is twice the limit of one; filters leave seven newtons at the corners of
/// another's, which is less than a hundredth of what its limit cuts off.
#[test]
fn limits_of_drives_that_are_at_them_nearly_always_are_found() {
    for (name, joint) in [("arm_torque_saturation-1", "elbow"), ("gantry_torque_saturation-1", "bridge")] {
        let (answer, truth) = diagnosed_of_seed(name, 20_261_128);
        is_found(&answer, &truth, "torque_saturation", "limit");
        assert_eq!(answer["effects"][0]["joint"], joint);
        let [before, after] = ["rms_before", "rms_after"].map(|key| answer[key].as_f64().unwrap());
        assert!(after < 0.04 * before, "{before} {after}");
    }
}

/// The log that was to judge meets the limit so seldom that it is explained without it.
#[test]
fn blocks_judge_where_the_other_log_does_not_show_what_acts() {
    let (answer, truth) = diagnosed_of_seed("arm_torque_saturation-1", 90_210);
    is_found(&answer, &truth, "torque_saturation", "limit");
    let said = answer["summary"].as_str().unwrap();
    assert!(said.starts_with("validation.csv hardly shows what acts in train.csv"), "{said}");
    assert!(said.contains("Blocks of train.csv judge instead."), "{said}");
    assert!(answer["validation"].is_null(), "{}", answer["validation"]);
}
