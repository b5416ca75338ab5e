//! `docs/gaits.md`: its example runs and prints what it shows, its gait is the shipped one, all keys stand in it.
use super::{gait, robot};
use crate::cli::{bipedc, command, run, scratch};
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
    for words in ["$ bipedc gait step", "$ bipedc gait steps", "$ bipedc gait cycle"] {
        let shown = block(&page(), "", &format!("{words} "));
        let (command, output) = shown.split_once('\n').unwrap();
        let arguments: Vec<&str> = command.split_whitespace().skip(2).collect();
        assert_eq!(bipedc(&arguments).ok().out.trim_end(), output, "{command}");
    }
}

#[test]
#[ignore = "takes long"]
fn all_commands_of_the_page_run() {
    let folder = scratch("gaits_page");
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/");
    let mut count = 0;
    for words in [
        "gait step robots/three_link",
        "gait map robots/seven_link_v1",
        "gait map robots/three_link",
        "gait steps robots/three_link",
        "simulate robots/three_link --scenario robots/three_link/scenarios/speeds",
        "gait cycle robots/three_link",
    ] {
        for line in block(&page(), "sh", words).lines() {
            // Fewer cells are the same commands; files go to a folder of their own.
            let fewer = [(":200", ":12"), (":159", ":9"), (":20 ", ":3 "), ("3:6", "3:2"), ("6:5", "6:2")];
            let line = fewer
                .into_iter()
                .fold(line.replace("robots/", robots), |line, (many, few)| line.replace(many, few))
                .replace("--to 0.525", "--to 0.525 --over push_off=-4:8:3");
            run(command(&line.split_whitespace().skip(1).collect::<Vec<_>>()).current_dir(&folder)).ok();
            count += 1;
        }
    }
    assert_eq!(count, 17);
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

/// Every name in a JSON value, lists by their first entry; what is named by robots and gaits, not by us, is left out.
fn names(json: &serde_json::Value, found: &mut Vec<String>) {
    match json {
        serde_json::Value::Object(table) => {
            for (key, value) in table {
                found.push(key.clone());
                if !["parameters", "from", "counts"].contains(&key.as_str()) {
                    names(value, found);
                }
            }
        }
        serde_json::Value::Array(list) => list.first().into_iter().for_each(|first| names(first, found)),
        _ => {}
    }
}

#[test]
fn keys_and_codes_of_maps_plans_and_cycles_stand_on_the_page() {
    let page = page();
    let fixed = |which: &str, more: &[&str]| {
        let start = ["gait", which, "robots/three_link", "--gait", "thesis", "--json"];
        bipedc(&[&start[..], more].concat()).ok().json()
    };
    let map = ["--speed", "1", "--over", "step_length=0.3:0.6:3", "--over", "torso_lean=-0.6:0:3"];
    let plan = ["--from-speed", "1", "--to", "1.2", "--over", "step_length=0.3:0.6:3"];
    for json in [fixed("map", &map), fixed("steps", &plan), fixed("cycle", &[])] {
        let mut found = Vec::new();
        names(&json, &mut found);
        assert!(found.len() > 10, "{found:?}");
        for key in found {
            assert!(page.contains(&format!("`{key}`")), "no `{key}` on the page");
        }
    }
    for reason in bipedc_analysis::gait::Reason::ALL {
        assert!(page.contains(&format!("`{}`", reason.code())), "no `{}` on the page", reason.code());
    }
}
