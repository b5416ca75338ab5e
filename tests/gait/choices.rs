//! Parameters chosen at mid-stance for wished speeds, on the whole robot: met as predicted, limits kept, mistakes named.
use super::gait;
use crate::cli::{Run, bipedc, scratch, text};
use bipedc::gait::choice::{ChoiceOptions, chooser};
use bipedc::progress::{Run as Progressing, Silent};
use bipedc_analysis::gait::ChoiceKind;
use bipedc_effects::random::Random;
use serde_json::Value;
use std::path::Path;

fn shipped(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(path)).unwrap()
}

fn run(name: &str, robot: &str, scenario: &str) -> Run {
    let folder = scratch(name);
    let (file, log) = (folder.join("scenario.toml"), folder.join("run.csv"));
    std::fs::write(&file, scenario).unwrap();
    let robot = format!("robots/{robot}");
    bipedc(&["simulate", &robot, "--scenario", text(&file), "--out", text(&log), "--json"])
}

/// The walk came to its end; its steps.
fn steps(found: &Value, count: u64) -> Vec<Value> {
    assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(count)), "{found}");
    found["speeds"]["steps"].as_array().unwrap().clone()
}

fn number(step: &Value, key: &str) -> f64 {
    step[key].as_f64().unwrap_or_else(|| panic!("no {key} in {step}"))
}

/// Thesis 7.3.1, figure 7.8b: 'the biped exactly reaches the desired mid-stance walking speed at each step'. The choice leaves 5 % of the
/// friction over, so that the walk also stands on ground that slips at 95.2 %.
#[test]
fn five_wished_speeds_are_met_and_limits_kept() {
    let scenario = shipped("three_link/scenarios/speeds.toml").replace("friction = 0.6", "friction = 0.571");
    let found = run("choice_three", "three_link", &scenario).ok().json();
    let steps = steps(&found, 6);
    let wished: Vec<f64> = steps[1..6].iter().map(|step| number(step, "wished")).collect();
    assert_eq!(wished, [1.55, 1.6, 1.55, 1.45, 1.4]);
    let off = |key: &str| {
        let each = steps[1..6].iter().map(|step| (number(step, "reached") - number(step, key)).abs());
        each.fold(0.0, f64::max)
    };
    println!(
        "reached within {:.1e} rad/s of what was wished, {:.1e} of what was predicted",
        off("wished"),
        off("predicted")
    );
    assert!(off("wished") < 1e-7 && off("predicted") < 1e-8);
    assert_eq!(found["speeds"]["met"].as_u64(), Some(5));
    // The walk does not look at what scuffs, nor do the choices; they say so.
    assert_eq!(found["speeds"]["keep"], Value::from(["friction", "pull", "torque", "joints"].to_vec()));
}

/// Where a walk ends by a foot that scuffs, a step that scuffs does not meet a wish.
#[test]
fn choices_keep_the_clearance_where_the_walk_does() {
    let bench = gait("robots/five_link", "lifting");
    let kept = |scuffing: bool, keep: Option<Vec<String>>| {
        let parameters = vec![("step_length".to_owned(), None)];
        let options = ChoiceOptions { parameters, scuffing, keep, ..ChoiceOptions::default() };
        bench.choice_settings(&bench.values(&[]).unwrap(), &options).unwrap().kept.assumptions.clearance
    };
    assert!(kept(true, None) && !kept(false, None));
    assert!(kept(false, Some(vec!["clearance".to_owned()])) && !kept(true, Some(Vec::new())));
}

/// Figure 7.8a: K vanishes where P is largest.
#[test]
fn the_robot_comes_to_rest_in_one_step() {
    let found = run("choice_stop", "three_link", &shipped("three_link/scenarios/stop.toml")).ok().json();
    let steps = steps(&found, 1);
    let rests = number(&steps[1], "rests_before");
    println!("rests {rests:.1e} rad before the dead centre at {} s", steps[1]["time"]);
    assert_eq!((number(&steps[1], "reached"), &steps[1]["choice"]), (0.0, &Value::from("meets")));
    assert!((0.0..1e-4).contains(&rests), "{rests:e}");
}

/// Figure 7.9a: in as many steps as were planned to a higher speed, then steps that repeat themselves.
#[test]
#[ignore = "takes long"]
fn a_higher_speed_is_reached_in_the_planned_number_of_steps() {
    let found = run("choice_five", "five_link", &shipped("five_link/scenarios/speeds.toml")).ok().json();
    let steps = steps(&found, 9);
    let planned = steps[1]["steps_to_wished"].as_u64().unwrap() as usize;
    assert!(planned > 1, "{planned}");
    for (index, step) in steps.iter().enumerate().take(9).skip(1) {
        let met = (number(step, "reached") - 1.05).abs() < 1e-7;
        assert_eq!(met, index >= planned, "{step}");
    }
    let of = |step: &Value, name: &str| step["parameters"][name].as_f64().unwrap();
    let last = |name: &str| (of(&steps[8], name) - of(&steps[7], name)).abs();
    println!(
        "{planned} steps; parameters still change by {:.1e} m and {:.1e} rad",
        last("step_length"),
        last("torso_lean")
    );
    assert!(last("step_length") < 5e-3 && last("torso_lean") < 5e-3);
}

/// Figure 7.9b: 'decelerating is easier than accelerating'.
#[test]
#[ignore = "takes long"]
fn decelerations_are_followed_and_accelerations_limited() {
    let found = run("choice_hundred", "five_link", &shipped("five_link/scenarios/hundred.toml")).ok().json();
    let steps = steps(&found, 101);
    let missed: Vec<&Value> = steps[1..101]
        .iter()
        .filter(|step| (number(step, "reached") - number(step, "wished")).abs() > 1e-6)
        .collect();
    println!("{} of 100 steps miss their speed", missed.len());
    assert!(!missed.is_empty());
    assert!(missed.iter().all(|step| number(step, "reached") < number(step, "wished")), "{missed:?}");
}

#[test]
#[ignore = "takes long"]
fn a_thousand_random_speeds_do_not_make_it_fall() {
    for robot in ["three_link", "five_link"] {
        random_speeds_do_not_make_it_fall(robot, "thousand", 1000);
    }
    random_speeds_do_not_make_it_fall("five_link", "thousand_lifting", 1000);
}

#[test]
#[ignore = "takes long"]
fn a_hundred_random_speeds_do_not_make_it_fall() {
    for robot in ["three_link", "five_link"] {
        random_speeds_do_not_make_it_fall(robot, "thousand", 100);
    }
}

/// Nothing is left out of what is checked: the swing foot is lifted.
#[test]
fn random_speeds_are_met_with_every_assumption_checked() {
    let scenario = shipped("five_link/scenarios/thousand_lifting.toml");
    assert!(!scenario.contains("false"), "{scenario}");
    random_speeds_do_not_make_it_fall("five_link", "thousand_lifting", 20);
}

fn random_speeds_do_not_make_it_fall(robot: &str, name: &str, count: usize) {
    let scenario = shipped(&format!("{robot}/scenarios/{name}.toml"));
    let fewer = scenario.replace("steps = 1000", &format!("steps = {count}"));
    assert!(fewer.contains(&format!("steps = {count} }}")), "{scenario}");
    let found = run(&format!("choice_{name}_{count}"), robot, &fewer).ok().json();
    let steps = steps(&found, count as u64 + 1);
    let speeds = &found["speeds"];
    println!(
        "{robot}: {} of {} speeds met, off by {} from predictions",
        speeds["met"], speeds["wished"], speeds["largest_surprise"]
    );
    assert_eq!((speeds["wished"].as_u64(), &found["end"]), (Some(count as u64), &Value::from("steps")));
    assert!(speeds["largest_surprise"].as_f64().unwrap() < 1e-6);
    assert!(
        steps[1..=count]
            .iter()
            .all(|step| ["meets", "on_the_way", "closest"].iter().any(|known| step["choice"] == *known))
    );
}

/// Each mistake with its line and column.
#[test]
fn mistakes_are_named_with_their_place() {
    let scenario = shipped("three_link/scenarios/speeds.toml");
    let speeds = "speeds = [1.55, 1.6, 1.55, 1.45, 1.4]";
    let cases = [
        (scenario.replace(speeds, "speeds = [1.5, -1.0]"), "`speeds` is not possible", ":18:10"),
        (
            scenario.replace(speeds, "speeds = { random = 1, between = [1.0, 2.0] }"),
            "`speeds` is not possible",
            ":18:10",
        ),
        (
            scenario.replace("gait = \"thesis\"", ""),
            "`speeds` is about the steps of a gait; there is none",
            ":18:10",
        ),
        (
            scenario.replace(speeds, &format!("{speeds}\n[control.choice.parameters]\ntorso_leen = true")),
            "the gait `thesis` has no parameter `torso_leen`",
            ":20:14",
        ),
        (
            scenario
                .replace(speeds, &format!("{speeds}\n[control.choice.parameters]\ntorso_lean = [0.5, -0.5]")),
            "`torso_lean` is no range",
            ":20:14",
        ),
        (
            scenario.replace(speeds, &format!("{speeds}\n[control.choice]\nkeep = [\"frictoin\"]")),
            "`frictoin` is nothing that a choice can keep",
            ":20:9",
        ),
        (
            scenario.replace(speeds, "[control.choice]\nvalues = 7"),
            "there are no speeds to choose parameters for",
            ":18:1",
        ),
        (
            scenario.replace("gait = \"thesis\"", "gait = \"published\""),
            "cannot be chosen at mid-stance",
            ":18:10",
        ),
    ];
    for (number, (scenario, message, place)) in cases.iter().enumerate() {
        run(&format!("choice_wrong_{number}"), "three_link", scenario).fails_with(&[message, place]);
    }
}

/// Walks under disturbances: those that are none succeed, those that are too much do not, both ways; equal seeds are equal.
#[test]
#[ignore = "takes long"]
fn robustness_is_counted_and_repeats_itself() {
    let scenario = scratch("robust").join("scenario.toml");
    let text_of = shipped("five_link/scenarios/robust.toml")
        .replace("steps = 9", "steps = 2")
        .replace("true", "[0.1, 0.3]\n");
    std::fs::write(&scenario, text_of.replace("[control.choice]", "[control.choice]\nvalues = 3")).unwrap();
    let run = || {
        let asked = [
            "--disturb",
            "push=0",
            "--disturb",
            "push=300",
            "--disturb",
            "height=0.002",
            "--trials",
            "3",
            "--json",
        ];
        let mut arguments = vec!["gait", "robust", "robots/five_link", "--scenario", text(&scenario)];
        arguments.extend(asked);
        bipedc(&arguments).ok().json()
    };
    let found = run();
    let tried = found["tried"].as_array().unwrap();
    for way in ["fixed", "chosen"] {
        let successes: Vec<u64> = tried.iter().map(|one| one[way]["successes"].as_u64().unwrap()).collect();
        assert_eq!(successes, [3, 0, 3], "{found}");
        assert!(
            (tried[0][way]["interval"][0].as_f64().unwrap() - 3.0 / (3.0 + 3.841_458_820_694_124)).abs()
                < 1e-12
        );
        let failures = tried[1][way]["failures"].as_object().unwrap().values();
        assert_eq!(failures.map(|count| count.as_u64().unwrap()).sum::<u64>(), 3);
    }
    assert_eq!(run(), found);
}

#[test]
fn wrong_robustness_is_named() {
    let cases: [(&[&str], &str); 3] = [
        (&["--scenario", "robots/three_link/scenarios/thesis.toml"], "no wished speeds"),
        (
            &["--scenario", "robots/three_link/scenarios/robust.toml", "--trials", "0"],
            "0 trials are not possible",
        ),
        (
            &["--scenario", "robots/three_link/scenarios/robust.toml", "--disturb", "height"],
            "whatever the height of the ground",
        ),
    ];
    for (arguments, words) in cases {
        let all: Vec<&str> =
            ["gait", "robust", "robots/three_link"].iter().chain(arguments).copied().collect();
        bipedc(&all).fails_with(&[words]);
    }
    let run = bipedc(&["gait", "robust", "robots/three_link", "--scenario", "x.toml", "--disturb", "wind=3"]);
    assert!(run.code == Some(2) && run.err.contains("there is no disturbance `wind`"), "{}", run.err);
}

/// Forces and torques along the chosen steps, from the efforts of the motion itself at many phases: with a fifth left over of each limit. The
/// predicted speed is that of the courses.
#[test]
fn chosen_steps_keep_their_limits_with_the_reserve() {
    let bench = gait("robots/three_link", "thesis");
    let (model, values) = (bench.model().unwrap(), bench.values(&[]).unwrap());
    // So much that limits count.
    let options = ChoiceOptions { reserve: Some(0.2), ..ChoiceOptions::default() };
    let settings = bench.choice_settings(&values, &options).unwrap();
    let quiet = Progressing { progress: &Silent, stop: &|| false };
    let chooser = chooser(&model, settings, &quiet).unwrap();
    let usual = model.steady_course(&values).unwrap();
    let point = usual.surface(usual.dead_centre).unwrap();
    let mut random = Random::new(11);
    let (mut met, mut tightest) = (0, [f64::INFINITY; 3]);
    for _ in 0..40 {
        let [speed, change] = [1.4 + 0.5 * random.symmetric(), 0.25 * random.symmetric()];
        let v: Vec<f64> = point.slope.iter().map(|slope| slope * speed).collect();
        let choice = chooser.choose(&point.q, &v, speed + change, &values);
        if choice.kind != ChoiceKind::Meets {
            continue;
        }
        met += 1;
        let rest = model.course_from(&choice.parameters, &point.q, &v).unwrap();
        let k = 0.5 * model.momentum(&point.q, &v).powi(2);
        let next = model.course(&choice.parameters, &rest.landing).unwrap();
        let energy = rest.landing.delta * (k - rest.p_minus);
        assert!((next.speed(energy).unwrap() - speed - change).abs() < 1e-6);
        let [tangential, normal] = rest.landing.impulse;
        tightest[0] = tightest[0].min(0.8 * 0.6 - tangential.abs() / normal);
        for (course, energy, end) in [(&rest, k, rest.landing.end), (&next, energy, next.dead_centre)] {
            for part in 0..=200 {
                let phase = course.start + (end - course.start) * f64::from(part) / 200.0;
                let efforts = model.efforts(course, phase, energy).unwrap();
                let largest = efforts[3..].iter().fold(0.0_f64, |most, torque| most.max(torque.abs()));
                tightest[0] = tightest[0].min(0.8 * 0.6 - efforts[0].abs() / efforts[1]);
                tightest[1] = tightest[1].min(efforts[1]);
                tightest[2] = tightest[2].min(0.8 * 150.0 - largest);
            }
        }
    }
    println!("{met} of 40 met; left of friction, push, torque beyond the reserve: {tightest:.3?}");
    // Between the phases that are looked at limits may be touched a little more closely.
    assert!(met > 10 && tightest[0] > -1e-3 && tightest[1] > 0.0 && tightest[2] > -0.1, "{met} {tightest:?}");
}

/// A gait found with joints 0.02 rad off their stops, with a lean and a reach added, on steps 5.9 mm high or low: what is chosen keeps off the stops as the usual
/// parameters do, and where nothing does these stay. Without, 32 of 200 walks (2 of these 12) end at a stop.
#[test]
fn chosen_steps_keep_off_stops_on_uneven_ground() {
    let strider = "tests/data/planar/strider";
    let scenario = format!("{strider}/uneven.toml");
    let of =
        ["gait", "robust", strider, "--scenario", &scenario, "--disturb", "height=0.0059", "--trials", "12"];
    let found = bipedc(&[&of[..], &["--seed", "1", "--json"]].concat()).ok().json();
    let row = &found["tried"][0];
    assert_eq!([&row["fixed"]["successes"], &row["chosen"]["successes"]], [12, 12], "{row}");
}
