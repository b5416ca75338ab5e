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

#[test]
fn an_order_that_is_none_is_refused_with_its_place() {
    walk("contacts-order", &scenario(1, "order = \"any\"", "")).fails_with(&[
        "no order \"any\"",
        "order = \"contacts\"",
        "scenario.toml:7",
    ]);
    walk("contacts-light-none", &scenario(1, "light = 0.5", "")).fails_with(&["`light` = 0.5", "0.1"]);
}
