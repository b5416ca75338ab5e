//! Walks of a robot with feet that is not its model: feet that are let go under no load, contacts out of the order of the phases; and steps
//! that have to keep margins.
use super::WALKER;
use crate::cli::{Run, bipedc, scratch, text};
use serde_json::Value;

/// A walk by the shipped gait `adjustable`; `checks` go into [assumptions], `more` at the end.
fn scenario(steps: usize, checks: &str, more: &str) -> String {
    format!(
        "method = \"event_driven\"\nduration = 20.0\nsteps = {steps}\nlog_step = 0.01\n[assumptions]\nfriction = 0.8\n{checks}\n\
         [initial]\nmid_stance_speed = 0.4\n[control]\ngait = \"adjustable\"\n{more}"
    )
}

fn walk(name: &str, scenario: &str) -> Run {
    let folder = scratch(name);
    let (file, log) = (folder.join("scenario.toml"), folder.join("run.csv"));
    std::fs::write(&file, scenario).unwrap();
    bipedc(&["simulate", WALKER, "--scenario", text(&file), "--out", text(&log), "--json"])
}

fn ankle_friction(damping: f64) -> String {
    format!("[[effect]]\nkind = \"viscous_friction\"\njoint = \"right_ankle_pitch\"\ndamping = {damping}\n")
}

/// With friction in an ankle that the controller does not know, the rear toe needs more than its friction where it carries almost nothing any more.
#[test]
fn a_foot_that_is_let_go_is_not_asked_for_friction_at_no_load() {
    let found = walk("contacts-light", &scenario(2, "", &ankle_friction(0.1))).ok().json();
    assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(2)), "{found}");
    assert_eq!(found["unplanned"].as_u64(), Some(0));
    // A foot that carries much is judged as ever.
    let strict = scenario(2, "", "").replace("friction = 0.8", "friction = 0.3");
    let slips = walk("contacts-strict", &strict);
    assert!(slips.code == Some(3) && slips.err.contains("the foot slips"), "{}", slips.err);
}

/// So much friction that no phase holds: what stands lets go as soon as it stands. That is a verdict on the walk, not an error of the scenario.
#[test]
fn phases_that_do_not_hold_are_a_verdict() {
    let hidden = ankle_friction(1.0).replace("right_ankle", "left_ankle");
    let scenario = scenario(4, "", &format!("speeds = [0.4, 0.4, 0.4]\n{hidden}"));
    let found = walk("contacts-chatter", &scenario.replace("\"adjustable\"", "\"firm\""));
    assert_eq!(found.code, Some(3), "{}", found.err);
    let verdict = &found.json()["verdict"];
    assert!(verdict["meaning"].as_str().unwrap().contains("no phase holds"), "{verdict}");
    assert!(verdict["time"].as_f64().unwrap() > 0.1 && verdict["phase"].is_string(), "{verdict}");
}

/// Footholds that nobody told the controller of: the knee in front, which is nearly stretched, is controlled where both feet stand, so that a foot
/// may come down lower than it is meant to.
#[test]
fn footholds_of_unknown_height_are_walked_over() {
    let firm = |footholds: &str| {
        let all = scenario(6, "", "").replace("\"adjustable\"", "\"firm\"");
        format!("footholds = {footholds}\n{all}")
    };
    let level = walk("footholds-level", &firm("[]")).ok().json();
    let uneven = walk("footholds-uneven", &firm("[0.0, -0.01, -0.005, 0.01, 0.003, -0.01]")).ok().json();
    for found in [&level, &uneven] {
        assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(6)), "{found}");
    }
    // A heel that comes down elsewhere comes down at another time.
    let landing = |found: &Value, number: usize| {
        let changes = found["changes"].as_array().unwrap().iter();
        let times = changes
            .filter(|change| change["to"] == "touch_down")
            .map(|change| change["time"].as_f64().unwrap());
        times.collect::<Vec<_>>()[number]
    };
    assert!((landing(&level, 0) - landing(&uneven, 0)).abs() < 1e-9);
    assert!(landing(&uneven, 1) > landing(&level, 1) + 1e-3, "10 mm lower: later");
    let low = walk("footholds-low", &firm("[0.0, -0.2]"));
    assert_eq!(low.code, Some(3), "{}{}", low.out, low.err);
}

#[test]
fn footholds_where_there_are_none_are_refused() {
    walk("footholds-high", &format!("footholds = [0.0, 3.0]\n{}", scenario(1, "", "")))
        .fails_with(&["a foothold of 3 m", "scenario.toml:1"]);
    let folder = scratch("footholds-stepping");
    let file = folder.join("scenario.toml");
    std::fs::write(&file, "duration = 0.1\nfootholds = [0.001]\n").unwrap();
    bipedc(&["simulate", WALKER, "--scenario", text(&file), "--out", text(&folder.join("run.csv"))])
        .fails_with(&["`footholds`", "event_driven", "scenario.toml:2"]);
}

#[test]
fn an_order_that_is_none_is_refused_with_its_place() {
    walk("contacts-order", &scenario(1, "order = \"any\"", "")).fails_with(&[
        "no order \"any\"",
        "order = \"contacts\"",
        "scenario.toml:7",
    ]);
    walk("contacts-light-none", &scenario(1, "light = 0.5", "")).fails_with(&["`light` = 0.5", "0.1"]);
}
