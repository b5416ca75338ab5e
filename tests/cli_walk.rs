//! `bipedc simulate` from event to event: the shipped gaits, what is printed, verdicts, mistakes.
use crate::cli;

use cli::{Run, bipedc, scratch, text};
use std::path::Path;

const GAIT: &str = "robots/five_link/scenarios/gait.toml";

/// The shipped gait of the five-link walker.
fn gait() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(GAIT)).unwrap()
}

fn simulate(folder: &Path, name: &str, scenario: &str, options: &[&str]) -> Run {
    let (file, log) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}.csv")));
    std::fs::write(&file, scenario).unwrap();
    let command = ["simulate", "robots/five_link", "--scenario", text(&file), "--out", text(&log)];
    bipedc(&[&command[..], options].concat())
}

#[test]
fn a_gait_written_with_few_digits_begins_on_the_ground() {
    let folder = scratch("walk_off");
    let exact = simulate(&folder, "exact", &gait(), &["--json"]).ok().json();
    assert_eq!(exact["projected"], serde_json::json!({ "position": 0.0, "velocity": 0.0 }));
    // A thousandth more: the swing foot would begin below the ground and sink.
    let off = gait()
        .replace(
            "left_knee_pitch = { position = 0.0912446381, velocity = 1.3104607502",
            "left_knee_pitch = { position = 0.0922, velocity = 1.30",
        )
        .replace("left_hip_pitch = { position = 0.0262805174", "left_hip_pitch = { position = 0.0253");
    let json = simulate(&folder, "off", &off, &["--json"]).ok().json();
    assert_eq!((json["end"].as_str(), json["steps"].as_u64()), (Some("steps"), Some(10)), "{json}");
    let moved = ["position", "velocity"].map(|part| json["projected"][part].as_f64().unwrap());
    println!("moved by {moved:?}");
    assert!(moved[0] > 1e-5 && moved[0] < 2e-3 && moved[1] < 2e-2, "{moved:?}");
    let told = simulate(&folder, "told", &off, &[]).ok();
    assert!(told.out.contains("was moved onto the contacts of its phase"), "{}", told.out);
}

#[test]
fn a_walk_is_logged_told_and_filmed() {
    let folder = scratch("walk");
    let (page, pictures) = (folder.join("walk.html"), folder.join("pictures"));
    let run = simulate(&folder, "walk", &gait(), &["--report", text(&page), "--svg", text(&pictures)]).ok();
    for words in ["walked 10 steps", "single_support", "left_foot -9.6", "evaluations of the dynamics"] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("walked 10 steps") && html.contains("DOP853") && html.len() < 5_000_000);
    for name in ["side.svg", "front.svg"] {
        let picture = std::fs::read_to_string(pictures.join(name)).unwrap();
        assert_eq!(picture.matches("<g class=\"pose\"").count(), 9, "{name}");
    }
    let json = simulate(&folder, "json", &gait(), &["--json"]).ok().json();
    assert_eq!((json["method"].as_str(), json["end"].as_str()), (Some("event_driven"), Some("steps")));
    assert!(json["verdict"].is_null() && json["steps"] == 10 && json["relative_tolerance"] == 1e-10);
    let changes = json["changes"].as_array().unwrap();
    assert_eq!(changes.len(), 10);
    assert_eq!(changes[1]["impulse"][0]["foot"], "right_foot");
    assert!(["from", "to"].iter().all(|key| changes[0][key] == "single_support"));
    let log = std::fs::read_to_string(folder.join("json.csv")).unwrap();
    assert_eq!(log, std::fs::read_to_string(folder.join("walk.csv")).unwrap(), "filming changes nothing");
    assert_eq!(log.lines().count(), 1 + json["rows"].as_u64().unwrap() as usize);
    // The columns of time stepping, so that everything that reads logs reads these.
    let stepped = simulate(&folder, "stepped", "duration = 0.002\n", &[]);
    stepped.ok();
    let other = std::fs::read_to_string(folder.join("stepped.csv")).unwrap();
    assert_eq!(log.lines().next(), other.lines().next());
    // Legs keep their names in the log: the force is on one foot, then on the other.
    let header: Vec<&str> = log.lines().next().unwrap().split(',').collect();
    let column = |name: &str| {
        let at = header.iter().position(|column| *column == name).unwrap();
        log.lines().skip(1).map(move |row| row.split(',').nth(at).unwrap().parse::<f64>().unwrap())
    };
    let (right, left): (Vec<f64>, Vec<f64>) =
        (column("right_foot/force/z").collect(), column("left_foot/force/z").collect());
    assert!(right[10] > 100.0 && left[10] == 0.0 && right[140] == 0.0 && left[140] > 100.0);
}

#[test]
fn the_log_of_a_walk_is_what_the_model_says() {
    let folder = scratch("walk_compare");
    simulate(&folder, "walk", &gait(), &[]).ok();
    let log = folder.join("walk.csv");
    let compared = bipedc(&["compare", "robots/five_link", text(&log), "--json"]).ok().json();
    assert!(!compared["channels"].as_array().unwrap().is_empty());
}

#[test]
fn a_verdict_ends_the_run_with_its_own_exit_code() {
    let folder = scratch("walk_verdict");
    let slippery = gait().replace("friction = 0.6", "friction = 0.2");
    let run = simulate(&folder, "slips", &slippery, &[]);
    assert_eq!(run.code, Some(3), "{}", run.err);
    for words in [
        "in phase `single_support` at 0.",
        "the foot slips",
        "tangential force on right_foot",
        " N, the limit is",
        "slips.toml",
    ] {
        assert!(run.err.contains(words), "no `{words}` in {}", run.err);
    }
    let json = simulate(&folder, "json", &slippery, &["--json"]);
    assert_eq!(json.code, Some(3));
    let json = json.json();
    let verdict = &json["verdict"];
    assert_eq!((json["end"].as_str(), verdict["phase"].as_str()), (Some("verdict"), Some("single_support")));
    assert_eq!(verdict["unit"], "N");
    assert!(verdict["value"].as_f64().unwrap() > verdict["limit"].as_f64().unwrap());
    // The log is whole up to there.
    let time = verdict["time"].as_f64().unwrap();
    let log = std::fs::read_to_string(folder.join("json.csv")).unwrap();
    let columns = log.lines().next().unwrap().split(',').count();
    assert!(log.ends_with('\n') && log.lines().all(|line| line.split(',').count() == columns));
    let last: f64 = log.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(last <= time && time - last <= 0.005, "{last} {time}");
}

#[test]
fn mistakes_are_named_with_their_place() {
    let folder = scratch("walk_mistakes");
    let fails = |name: &str, scenario: &str, words: &[&str]| {
        simulate(&folder, name, scenario, &[]).fails_with(words);
        assert!(!folder.join(format!("{name}.csv")).exists(), "{name} left a log");
        let left = std::fs::read_dir(&folder).unwrap().flatten();
        let left = left.filter(|entry| entry.file_name().to_string_lossy().ends_with("-tmp")).count();
        assert_eq!(left, 0, "{name} left a partial log");
    };
    let events = "method = \"event_driven\"\nduration = 1.0\n";
    fails(
        "method",
        "method = \"event_drivn\"\nduration = 1.0\n",
        &["method.toml:1", "did you mean \"event_driven\"?"],
    );
    fails(
        "step",
        &format!("{events}step = 0.001\n"),
        &["step.toml:3", "`step` has no meaning", "relative_tolerance"],
    );
    fails(
        "ground",
        &format!("{events}[ground]\nfriction = 0.5\n"),
        &["ground.toml:3", "[assumptions] friction"],
    );
    fails("residual", &format!("{events}residual = 1e-9\n"), &["residual.toml:3"]);
    fails("clearance", &format!("{events}[initial]\nclearance = 0.1\n"), &["clearance.toml:4"]);
    fails("steps", "duration = 1.0\nsteps = 4\n", &["steps.toml:2", "event_driven"]);
    fails("zero", &format!("{events}steps = 0\n"), &["zero.toml:3", "`steps` = 0"]);
    fails("assumptions", "duration = 1.0\n[assumptions]\nfriction = 0.5\n", &["assumptions.toml:2"]);
    fails(
        "friction",
        &format!("{events}[assumptions]\nfriction = -1\n"),
        &["friction.toml:4:12", "false: not checked"],
    );
    fails(
        "phase",
        &format!("{events}[initial]\nphase = \"single_suport\"\n"),
        &["phase.toml:4", "single_support"],
    );
    fails(
        "unused",
        "duration = 1.0\n[initial]\nphase = \"single_support\"\n",
        &["unused.toml:3", "no meaning"],
    );
    let effect = "[[effect]]\nkind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 0.4\n";
    fails("effect", &format!("{events}{effect}"), &["effect.toml:3", "from event to event", "time_stepping"]);
    let lifted = "[initial]\nbase_position = [0.0, 2.0]\n";
    fails("lifted", &format!("{events}{lifted}"), &["lifted.toml:3", "right_foot/point_foot", "m high"]);
    let moving = "[initial]\nbase_velocity = [1.0, 0.0]\n";
    fails("moving", &format!("{events}{moving}"), &["moving.toml:3", "begins with 1.0"]);
    // Formulas, with the place inside the text.
    let output = |formula: &str| format!("{events}[[control.output]]\nformula = \"{formula}\"\n");
    fails("formula", &output("right_hip_pitch + * 2"), &["formula.toml:4:30"]);
    fails("name", &output("right_hip_pich"), &["name.toml:4", "did you mean `right_hip_pitch`?"]);
    fails("still", &output("0.5"), &["still.toml:4", "never moves"]);
    let circle = "[control.quantities]\na = \"b + right_hip_pitch\"\nb = \"2 * a\"\n";
    fails("circle", &format!("{events}{circle}[[control.output]]\nformula = \"a\"\n"), &["circle"]);
    let five = "[[control.output]]\nformula = \"right_hip_pitch\"\n".repeat(5);
    fails("five", &format!("{events}{five}"), &["more outputs than actuators", "4 actuators"]);
    let twice = "[[control.output]]\nformula = \"right_hip_pitch\"\n".repeat(2);
    fails("twice", &format!("{events}{twice}"), &["singular", "single_support", "independent"]);
    fails("law", &format!("{events}[control.feedback]\nlaw = \"pd\"\n"), &["law.toml:3", "there are none"]);
    let law = "[control.feedback]\nlaw = \"finite_time\"\nstiffness = 3.0\n";
    fails(
        "mixed",
        &format!("{events}{law}[[control.output]]\nformula = \"right_hip_pitch\"\n"),
        &["mixed.toml:5", "finite_time"],
    );
    simulate(&folder, "fixed", events, &["--base", "fixed"]).fails_with(&["fixed base", "time_stepping"]);
}

/// The shipped gait with an effect, its log, and what is found in that.
fn diagnosed(name: &str, effect: &str) -> serde_json::Value {
    let folder = scratch(name);
    simulate(&folder, "walk", &format!("{}\n{effect}\n", gait()), &[]).ok();
    bipedc(&["diagnose", "robots/five_link", text(&folder.join("walk.csv")), "--json"]).ok().json()
}

/// Filtered across impacts, five inertias and two frictions were claimed of this log.
#[test]
fn a_walk_with_impacts_as_modelled_is_missing_nothing() {
    let found = diagnosed("walk_clean", "");
    assert!(found["effects"].as_array().unwrap().is_empty(), "{found:#}");
    assert!(found["inertial_corrections"].as_array().is_none_or(Vec::is_empty), "{found:#}");
}

/// Legs change their roles with every step; the effects stay where they are.
#[test]
fn effects_of_one_leg_are_found_in_a_walk_with_impacts() {
    let cases = [
        ("viscous_friction", "joint", "left_knee_pitch", &[("damping", 0.4, 0.01)][..]),
        ("rotor_inertia", "joint", "right_hip_pitch", &[("inertia", 0.08, 0.01)]),
        ("payload", "link", "left_tibia", &[("mass", 0.3, 0.01), ("x", 0.0, 0.002), ("z", -0.2, 0.01)]),
    ];
    for (kind, place, name, parameters) in cases {
        let mut effect = format!("[[effect]]\nkind = \"{kind}\"\n{place} = \"{name}\"\n");
        if kind == "payload" {
            effect += "y = 0.0\n";
        }
        effect.extend(parameters.iter().map(|(name, value, _)| format!("{name} = {value:?}\n")));
        let answer = diagnosed(&format!("walk_{kind}"), &effect);
        let effects = answer["effects"].as_array().unwrap();
        let [found] = effects.as_slice() else { panic!("{kind}: {answer:#}") };
        assert_eq!((found["kind"].as_str(), found[place].as_str()), (Some(kind), Some(name)), "{found:#}");
        for (name, value, tolerance) in parameters {
            let known = found["parameters"][name].as_f64().unwrap();
            assert!((known - value).abs() < *tolerance, "{kind}: {name} is {known}, not {value}");
        }
    }
}
