//! `docs/gaits.md`: its example runs and prints what it shows, its gait is the shipped one, all keys stand in it.
use super::{gait, robot};
use crate::cli::bipedc;
use bipedc::gait::{GaitBench, StepOptions};
use bipedc::progress::Silent;
use std::path::Path;

fn page() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/gaits.md")).unwrap()
}

/// The fenced block of this language that has these words.
fn block(page: &str, language: &str, words: &str) -> String {
    // Fences open and close in turn.
    let parts: Vec<&str> = page.split("```").collect();
    let inside = parts.iter().skip(1).step_by(2).filter_map(|part| part.split_once('\n'));
    let found = inside.filter(|(name, _)| *name == language).map(|(_, text)| text.trim_end());
    let mut found = found.filter(|text| text.contains(words));
    found.next().unwrap_or_else(|| panic!("no block with `{words}`")).to_owned()
}

#[test]
fn the_example_prints_what_the_page_shows() {
    let shown = block(&page(), "", "$ bipedc");
    let (command, output) = shown.split_once('\n').unwrap();
    let arguments: Vec<&str> = command.split_whitespace().skip(2).collect();
    assert_eq!(bipedc(&arguments).ok().out.trim_end(), output);
}

#[test]
fn all_commands_of_the_page_run() {
    let commands = block(&page(), "sh", "gait step");
    assert_eq!(commands.lines().count(), 3);
    for command in commands.lines() {
        bipedc(&command.split_whitespace().skip(1).collect::<Vec<_>>()).ok();
    }
}

#[test]
fn the_gait_of_the_page_is_the_shipped_one() {
    let text = block(&page(), "toml", "[[phase]]");
    let shown = GaitBench::parse(&robot("robots/three_link"), Path::new("page.toml"), &text, &Silent);
    let shown = shown.unwrap_or_else(|e| panic!("{e}")).gait;
    let shipped = gait("robots/three_link", "thesis").gait;
    assert_eq!(
        (&shown.phase, &shown.limits, shown.gravity),
        (&shipped.phase, &shipped.limits, shipped.gravity)
    );
    assert_eq!((&shown.parameters, &shown.quantities), (&shipped.parameters, &shipped.quantities));
}

/// Keys are those that the reader lists where one is wrong; numbers are those of the JSON.
#[test]
fn all_keys_stand_on_the_page() {
    let page = page();
    let text = block(&page, "toml", "[[phase]]");
    for (place, wrong) in [
        ("gravity = 9.8", "zzz = 1\ngravity = 9.8"),
        ("unit = \"m\"", "zzz = 1\nunit = \"m\""),
        ("variable =", "zzz = 1\nvariable ="),
        ("controlled =", "zzz = 1\ncontrolled ="),
        ("guard = {", "guard = { zzz = 1,"),
        ("friction = 0.6", "zzz = 1"),
    ] {
        let text = text.replacen(place, wrong, 1);
        let found = GaitBench::parse(&robot("robots/three_link"), Path::new("page.toml"), &text, &Silent);
        let found = found.map(|_| ()).unwrap_err().to_string();
        let listed = found.split("known keys: ").nth(1).unwrap_or_else(|| panic!("{found}"));
        let keys: Vec<&str> = listed.lines().next().unwrap().split('`').skip(1).step_by(2).collect();
        assert!(!keys.is_empty(), "{found}");
        for key in keys {
            let there = [format!("`{key}`"), format!("`[{key}"), format!("`[[{key}")];
            // Outputs belong to their phase.
            assert!(
                key == "output" || there.iter().any(|form| page.contains(form)),
                "no `{key}` on the page"
            );
        }
    }
    let bench = gait("robots/three_link", "thesis");
    let stepped = bench.step(&StepOptions { speed: 1.5, ..StepOptions::default() }).unwrap();
    let json = serde_json::to_value(&stepped).unwrap();
    let (all, margins) = (json.as_object().unwrap(), json["margins"].as_object().unwrap());
    for key in all.keys().filter(|key| *key != "margins").chain(margins.keys()) {
        assert!(page.contains(&format!("`{key}`")), "no `{key}` on the page");
    }
}
