//! Gaits that `bipedc gait optimise` found: those that are shipped walk with everything checked, and the command finds one from nothing.
use crate::cli::{Run, bipedc, scratch, text};
use serde_json::Value;
use std::path::Path;

/// Twenty steps of a shipped scenario, all assumptions checked, and the smallest vertical impulse on a foot that an impact holds, N s.
fn twenty_steps(robot: &str, scenario: &str) -> f64 {
    let log = scratch(&format!("optimised-{scenario}")).join("run.csv");
    let scenario = format!("{robot}/scenarios/{scenario}.toml");
    let found =
        bipedc(&["simulate", robot, "--scenario", &scenario, "--out", text(&log), "--json"]).ok().json();
    assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(20)), "{found}");
    smallest_impulse(&found)
}

/// Vertical, of all feet that impacts of a walk hold, N s.
fn smallest_impulse(run: &Value) -> f64 {
    let changes = run["changes"].as_array().unwrap().iter();
    let impulses = changes.flat_map(|change| change["impulse"].as_array().unwrap());
    impulses.map(|impulse| impulse["z"].as_f64().unwrap()).fold(f64::INFINITY, f64::min)
}

#[test]
#[ignore = "takes long"]
fn a_five_link_gait_found_from_nothing_walks() {
    twenty_steps("robots/five_link", "collocated");
}

#[test]
#[ignore = "takes long"]
fn a_gait_of_four_phases_found_from_nothing_walks() {
    let smallest = twenty_steps("robots/seven_link_v1", "from_nothing");
    assert!(smallest > 0.1, "{smallest} N s");
}

/// All margins at once, walked from event to event: begun at the shipped gait, whose walk has hardly any impulse on the rear toe, and
/// from nothing. Then twenty steps by what was written.
#[test]
#[ignore = "takes long"]
fn a_gait_of_four_phases_keeps_every_margin_from_a_seed_and_from_nothing() {
    for (name, start) in [("seed", &["--start", "collocated"][..]), ("nothing", &[])] {
        let folder = scratch(&format!("optimised-margins-{name}"));
        let gait = folder.join("walk.toml");
        let asked = ["gait", "optimise", "robots/seven_link_v1", "--gait", "collocated", "--speed", "0.4"];
        let margins = ["--friction", "0.6", "--impulse", "0.1", "--zmp", "0.01", "--clearance", "0.01"];
        let written = ["--out", text(&gait), "--json"];
        let found = bipedc(&[&asked[..], &margins, &written, start].concat()).ok().json();
        let found = &found["gaits"][0];
        let walked = &found["closed_loop"];
        let of = |margin: &str| walked["margins"][margin].as_f64().unwrap();
        assert_eq!(found["lacking"], Value::Array(Vec::new()), "{name}: {found}");
        assert!(of("friction") < 0.6 + 1e-9 && of("impact_friction") <= 0.6, "{name}: {walked}");
        assert!(of("impulse") >= 0.1 && of("zmp") >= 0.01 && of("clearance") >= 0.01, "{name}: {walked}");
        assert!(of("torque") > 0.0 && of("joint") > 0.0, "{name}: {walked}");
        assert!(walked["multiplier"].as_f64().unwrap().abs() < 0.8, "{name}: {walked}");
        assert!(of("velocity") > 0.0, "{name}: {walked}");
        // Steps that repeat themselves are the same ones by either command.
        let cycle = ["gait", "cycle", "robots/seven_link_v1", "--gait", text(&gait), "--json"];
        let cycle = &bipedc(&cycle).ok().json()["cycles"][0]["cycle"];
        for key in ["speed", "multiplier"] {
            let [one, other] = [&walked[key], &cycle[key]].map(|x| x.as_f64().unwrap());
            assert!((one / other - 1.0).abs() < 1e-3, "{name}: {key} {one} {other}");
        }
        let run = steps_by(&folder, "robots/seven_link_v1", &gait, walked["speed"].as_f64().unwrap());
        assert_eq!((run["steps"].as_u64(), &run["verdict"]), (Some(20), &Value::Null), "{name}: {run}");
        assert!(smallest_impulse(&run) >= 0.1, "{name}: {run}");
    }
}

/// Two lengths of first steps end at two motions, of which the cheaper one is kept and written, whatever the threads do; one alone tells of none.
#[test]
#[ignore = "takes long"]
fn of_several_beginnings_the_cheapest_motion_is_kept() {
    let folder = scratch("optimised-beginnings");
    let found = |name: &str, more: &[&str]| {
        let out = folder.join(name);
        let asked = ["gait", "optimise", "robots/seven_link_v1", "--gait", "collocated", "--speed", "0.6"];
        let found = bipedc(&[&asked[..], &["--out", text(&out), "--json"], more].concat()).ok().json();
        (found["gaits"][0].clone(), std::fs::read_to_string(&out).unwrap())
    };
    let (usual, written) = found("usual.toml", &[]);
    let told = usual["beginnings"].as_array().unwrap();
    assert_eq!(told.len(), 2, "{usual}");
    let number = |of: &Value, key: &str| of[key].as_f64().unwrap();
    assert!(number(&told[0], "step") > number(&told[1], "step"), "{usual}");
    let costs = [number(&told[0], "cost"), number(&told[1], "cost")];
    assert!((costs[0] / costs[1] - 1.0).abs() > 0.01, "{usual}");
    for beginning in told {
        let cheapest = number(beginning, "cost") <= costs[0].min(costs[1]);
        assert_eq!(beginning["kept"].as_bool(), Some(cheapest), "{usual}");
    }
    let kept = told.iter().find(|beginning| beginning["kept"] == true).unwrap();
    assert_eq!((&usual["rounds"], &usual["cost_of_transport"]), (&1.into(), &kept["cost_of_transport"]));
    let (_, again) = found("again.toml", &[]);
    assert_eq!(written, again);
    let (one, _) = found("one.toml", &["--beginnings", "1"]);
    assert_eq!(one["beginnings"], Value::Array(Vec::new()));
    let straight = (number(&one, "cost_of_transport"), number(&told[0], "cost_of_transport"));
    assert!((straight.0 / straight.1 - 1.0).abs() < 1e-9, "{straight:?}");
}

/// Twenty steps of a robot by a gait file, from event to event, all assumptions checked.
fn steps_by(folder: &Path, robot: &str, gait: &Path, mid_stance_speed: f64) -> Value {
    let scenario = folder.join("walk-scenario.toml");
    let words = format!(
        "method = \"event_driven\"\nduration = 60.0\nsteps = 20\nlog_step = 0.005\n[assumptions]\nfriction = 0.6\n[initial]\n\
         mid_stance_speed = {mid_stance_speed}\n[control]\ngait = \"{}\"\n",
        text(gait)
    );
    std::fs::write(&scenario, words).unwrap();
    let log = folder.join("run.csv");
    bipedc(&["simulate", robot, "--scenario", text(&scenario), "--out", text(&log), "--json"]).ok().json()
}

/// Wrong numbers, and the gait itself as the output, are refused before anything is computed.
#[test]
fn wrong_use_is_refused() {
    let gait = "robots/five_link/gaits/optimised.toml";
    let before = std::fs::read_to_string(gait).unwrap();
    let asked = |more: &[&str]| {
        let form = ["gait", "optimise", "robots/five_link", "--gait", "optimised"];
        bipedc(&[&form[..], more].concat()).err
    };
    assert!(asked(&["--speed", "0.7", "--out", gait]).contains("optimised.toml"));
    assert_eq!(std::fs::read_to_string(gait).unwrap(), before);
    let out = scratch("optimised-refused").join("new.toml");
    let told = asked(&["--speed", "0", "--friction", "-1", "--joints", "2", "--out", text(&out)]);
    assert!(told.contains("--speed: 0 is not possible") && told.contains("--friction: -1"), "{told}");
    assert!(told.contains("--joints: 2 is not possible"), "{told}");
    assert!(!out.exists());
}

/// What the command says of a gait at a speed.
fn asked(out: &Path, speed: &str, more: &[&str]) -> Run {
    let form = ["gait", "optimise", "robots/five_link", "--gait", "optimised", "--intervals", "12"];
    bipedc(&[&form[..], &["--speed", speed, "--out", text(out), "--json"], more].concat())
}

/// A minimum whose own controller walks with the speed that was asked for.
#[test]
fn the_command_finds_a_gait() {
    let out = scratch("optimised-command").join("new.toml");
    let asked = |speed: &str, more: &[&str]| asked(&out, speed, more);
    let found = asked("0.6", &[]).ok().json();
    let gait = &found["gaits"][0];
    let walks = gait["closed_loop"]["walking_speed"].as_f64().unwrap();
    let multiplier = gait["closed_loop"]["multiplier"].as_f64().unwrap();
    assert!(gait["minimum"] == true && (walks - 0.6).abs() < 1e-3 && multiplier < 0.8, "{found}");
    let written = std::fs::read_to_string(&out).unwrap();
    assert!(written.contains("bezier"), "{written}");
    std::fs::remove_file(&out).unwrap();
    // Nearest to a stop without being asked: 0.02 rad.
    let reserved = asked("0.6", &["--joints", "0.15"]).ok().json();
    let joint = |found: &Value| found["gaits"][0]["closed_loop"]["margins"]["joint"].as_f64().unwrap();
    assert!(joint(&found) < 0.03 && joint(&reserved) > 0.148, "{} {}", joint(&found), joint(&reserved));
}

/// A speed that no such robot reaches, of which nothing is left behind.
#[test]
#[ignore = "takes long"]
fn the_command_says_what_contradicts_itself() {
    let out = scratch("optimised-contradiction").join("new.toml");
    let told = asked(&out, "9", &[]).json();
    let gait = &told["gaits"][0];
    let violation = &gait["violations"][0];
    assert!(violation["constraint"] == "walking speed" && violation["phase"].is_string(), "{told}");
    assert!(!out.exists(), "nothing is written of what was not found");
    // The nearest speed that there is a gait at, and what stands in the way of more.
    let [nearest, beyond] = ["speed", "beyond"].map(|key| gait["reach"][key].as_f64().unwrap());
    println!("{nearest} m/s, not {beyond}, {} iterations", gait["iterations"]);
    assert!(nearest > 1.5 && nearest < beyond && beyond < 1.1 * nearest, "{told}");
    assert!((violation["by"].as_f64().unwrap() - (nearest - 9.0)).abs() < 1e-9, "{told}");
    let limits: Vec<&str> =
        gait["reach"]["limits"].as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
    assert!(limits.iter().any(|limit| limit.starts_with("torque of")), "{limits:?}");
    assert!(gait["iterations"].as_u64().unwrap() < 1600, "{told}");
    let there = asked(&out, &nearest.to_string(), &[]).json();
    assert!(there["gaits"][0]["feasible"] == true, "{there}");
}

/// The same gait for the least work costs less of it than for the least torques, and more squared torque; walked, as well as at the nodes.
#[test]
fn a_gait_for_the_least_work_takes_less_of_it() {
    let folder = scratch("optimised_cost");
    let found = |cost: &str| {
        let out = folder.join(format!("{cost}.toml"));
        let run = [
            "gait",
            "optimise",
            "robots/five_link",
            "--gait",
            "optimised",
            "--speed",
            "0.7",
            "--out",
            text(&out),
        ];
        let json = bipedc(&[&run[..], &["--intervals", "12", "--cost", cost, "--json"]].concat()).ok().json();
        let written = std::fs::read_to_string(&out).unwrap();
        assert_eq!(written.contains("--cost transport"), cost == "transport", "{written}");
        let one = json["gaits"][0].clone();
        [&one["cost_of_transport"], &one["closed_loop"]["cost_of_transport"]].map(|x| x.as_f64().unwrap())
    };
    let (torque, transport) = (found("torque"), found("transport"));
    println!("{torque:?} {transport:?}");
    for k in 0..2 {
        assert!(transport[k] < 0.95 * torque[k] && transport[k] > 0.0, "{transport:?} {torque:?}");
    }
    // What is told is not smoothed: the walk's own integral says the same.
    assert!((transport[0] / transport[1] - 1.0).abs() < 0.02, "{transport:?}");
    let unknown =
        ["gait", "optimise", "robots/five_link", "--gait", "optimised", "--speed", "0.7", "--out", "x"];
    assert_eq!(bipedc(&[&unknown[..], &["--cost", "time"]].concat()).code, Some(2));
}

/// It was searched for minutes, and ended in residuals.
#[test]
fn a_phase_variable_that_falls_is_refused_at_its_line() {
    let folder = scratch("falling_phase");
    let form = std::fs::read_to_string("robots/five_link/gaits/optimised.toml").unwrap();
    let falls = form.replace("variable = \"direction\"", "variable = \"-direction\"");
    assert_ne!(form, falls);
    let [file, out] = ["falls.toml", "new.toml"].map(|name| folder.join(name));
    std::fs::write(&file, falls).unwrap();
    let asked = ["gait", "optimise", "robots/five_link", "--gait", text(&file), "--speed", "0.7"];
    let run = bipedc(&[&asked[..], &["--out", text(&out)]].concat());
    run.fails_with(&["the phase variable", "falls as the robot goes forward", "falls.toml:21:"]);
    assert!(!out.exists());
}

/// Parameters that were written into a found gait by hand, as docs/gaits.md says, and a file of a version without the hash.
#[test]
fn gaits_that_were_changed_by_hand_are_kept() {
    let out = scratch("edited_file").join("walk.toml");
    let asked = ["gait", "optimise", "robots/five_link", "--gait", "optimised", "--speed", "0.7"];
    let search = || bipedc(&[&asked[..], &["--out", text(&out)]].concat());
    search().ok();
    let found = std::fs::read_to_string(&out).unwrap();
    let edited = format!("{found}\n[parameters.lean]\nunit = \"rad\"\ndefault = 0.0\nbounds = [-0.2, 0.2]\n");
    std::fs::write(&out, &edited).unwrap();
    search().fails_with(&["walk.toml", "changed since, or cut off", "move it away"]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), edited);
    let (head, rest) = found.split_once('\n').unwrap();
    let (before, _) = head.split_once(", rest ").expect("the hash of what follows");
    std::fs::write(&out, format!("{before} by\n{rest}")).unwrap();
    search().ok();
    assert_eq!(std::fs::read_to_string(&out).unwrap(), found, "the same search, the same bytes");
}

#[test]
fn files_that_no_search_wrote_are_kept() {
    let out = scratch("kept_file").join("mine.toml");
    std::fs::write(&out, "duration = 6.0\n").unwrap();
    let asked = ["gait", "optimise", "robots/five_link", "--gait", "optimised", "--speed", "0.7"];
    let run = bipedc(&[&asked[..], &["--out", text(&out)]].concat());
    run.fails_with(&["no gait that a search wrote", "mine.toml", "give --out another name"]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "duration = 6.0\n");
}
