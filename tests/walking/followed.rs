//! A plan is a reference that `bipedc simulate` follows.
use crate::cli::{bipedc, scratch, text};

/// Two steps straight ahead on the simulated ground, the joints held by stiff servos with the plan's angles as they are.
#[test]
#[ignore = "takes long"]
fn a_planned_walk_is_walked_in_simulation() {
    let folder = scratch("walking-followed");
    let [plan, scenario, log] = ["plan.csv", "scenario.toml", "log.csv"].map(|name| folder.join(name));
    let asked =
        ["gait", "plan", "robots/tulip", "--gait", "forward", "--count", "2", "--out", text(&plan), "--json"];
    let duration = bipedc(&asked).ok().json()["duration"].as_f64().unwrap();
    let servos =
        "[control]\nstiffness = 6000.0\ndamping = 30.0\nservo = \"drive\"\ntrajectory = \"plan.csv\"\n";
    std::fs::write(&scenario, format!("duration = {duration}\nstep = 0.001\nlog_step = 0.01\n{servos}"))
        .unwrap();
    bipedc(&["simulate", "robots/tulip", "--scenario", text(&scenario), "--out", text(&log)]).ok();
    let last = |path: &std::path::Path, name: &str| -> f64 {
        let table = std::fs::read_to_string(path).unwrap();
        let column = table.lines().next().unwrap().split(',').position(|other| other == name).unwrap();
        table.lines().last().unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    for (axis, within) in [("x", 0.02), ("y", 0.02), ("z", 0.01)] {
        let name = format!("base/position/{axis}");
        let (wished, here) = (last(&plan, &name), last(&log, &name));
        // The log begins where the scenario puts the root, above the origin.
        let start = if axis == "x" { first(&plan, &name) - first(&log, &name) } else { 0.0 };
        assert!((here + start - wished).abs() < within, "{name}: {here} but {wished}");
    }
}

fn first(path: &std::path::Path, name: &str) -> f64 {
    let table = std::fs::read_to_string(path).unwrap();
    let column = table.lines().next().unwrap().split(',').position(|other| other == name).unwrap();
    table.lines().nth(1).unwrap().split(',').nth(column).unwrap().parse().unwrap()
}
