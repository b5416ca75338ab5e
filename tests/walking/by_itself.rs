//! A robot that walks by itself in time stepping, with the controller that runs on board.
use crate::cli::{bipedc, scratch, text};
use serde_json::Value;

pub const WALK: &str = "\
duration = 6.0
log_step = 0.01
[walking]
velocity = [{ time = 0.3, forward = 0.3 }, { time = 4.0 }]
";

/// What sensors of today do.
pub const SENSORS: &str = "\
[sensors]
position_noise = 1e-4
velocity_noise = 0.01
force_noise = 1.0
[imu]
acceleration_noise = 0.1
angular_velocity_noise = 0.005
acceleration_bias = [0.1, -0.05, 0.1]
angular_velocity_bias = [0.01, -0.01, 0.005]
";

pub fn simulated(name: &str, scenario: &str) -> Value {
    let folder = scratch(&format!("walks-{name}"));
    let [file, log] = ["scenario.toml", "log.csv"].map(|name| folder.join(name));
    std::fs::write(&file, scenario).unwrap();
    let run = bipedc(&["simulate", "robots/tulip", "--scenario", text(&file), "--out", text(&log), "--json"]);
    run.ok().json()
}

/// Six steps or more on its feet, within a fifth of where 3.7 s of 0.3 m/s lead.
pub fn walks(name: &str, scenario: &str) {
    let found = simulated(name, scenario);
    let walk = &found["walk"];
    assert_eq!(walk["fell"], Value::Null, "{name}: {walk}");
    assert!(walk["steps"].as_u64().unwrap() >= 6, "{name}: {walk}");
    let distance = walk["distance"].as_f64().unwrap();
    assert!((distance / 1.11 - 1.0).abs() < 0.2, "{name}: {walk}");
}

#[test]
fn tulip_walks_by_itself() {
    walks("true", WALK);
}

#[test]
fn tulip_walks_by_what_its_sensors_tell() {
    let told = WALK.replace("[walking]", "[walking]\nstate = \"measured\"");
    walks("measured", &(told + SENSORS));
}

/// A push of a quarter of what its weight gives in a second would throw a robot that does not step aside.
#[test]
fn a_push_is_stepped_out() {
    let push = "[[push]]\ntime = 2.5\nimpulse = 4.0\ndirection = 1.5707963\n";
    let [pushed, unpushed] = [push, ""].map(|push| simulated("pushed", &format!("{WALK}{push}")));
    assert_eq!(pushed["walk"]["fell"], Value::Null, "{}", pushed["walk"]);
    // It was felt: for a while the zero moment point is as far out as the sole allows.
    let limited = |found: &Value| found["walk"]["limited"].as_f64().unwrap();
    assert!(limited(&pushed) > limited(&unpushed) + 0.005, "{} {}", pushed["walk"], unpushed["walk"]);
}

/// Away from the foot in the air there is nowhere to step: the step has to last longer, or to end at once. Instants of a step at which TUlip fell before it
/// could choose the time; likewise pushes back.
#[test]
fn pushes_that_need_another_time_are_stepped_out() {
    let walk = "duration = 7.5\nlog_step = 0.1\n[walking]\nvelocity = [{ time = 0.5, forward = 0.2 }]\n";
    let pushes = [(5.0, 3.045, 90.0), (5.0, 3.195, 90.0), (5.0, 4.125, 90.0), (5.0, 3.255, 180.0)];
    for (impulse, time, degrees) in pushes {
        let direction = f64::to_radians(degrees);
        let push = format!("[[push]]\ntime = {time}\nimpulse = {impulse}\ndirection = {direction}\n");
        let found = simulated("timed", &format!("{walk}{push}"));
        assert_eq!(found["walk"]["fell"], Value::Null, "{push}: {}", found["walk"]);
    }
}

/// Ground that falls by 3° where nobody said so, by what sensors tell: gravity seems to pull along it.
#[test]
fn an_unknown_slope_is_walked_on() {
    let told = WALK.replace("[walking]", "[walking]\nstate = \"measured\"").replace("6.0", "12.0");
    let told = told.replace("time = 4.0", "time = 11.0");
    for tilt in ["roll = 0.0\npitch = 0.0524", "roll = 0.0524\npitch = 0.0"] {
        let slope = format!("[[effect]]\nkind = \"ground_slope\"\n{tilt}\n");
        let found = simulated("slope", &format!("{told}{SENSORS}{slope}"));
        assert_eq!(found["walk"]["fell"], Value::Null, "{tilt}: {}", found["walk"]);
        assert!(found["walk"]["distance"].as_f64().unwrap() > 2.4, "{tilt}: {}", found["walk"]);
    }
}

/// Footholds up to 10 mm higher or lower than the plane, of which nobody knows: feet land early and late, and the estimator does not take them for level.
#[test]
fn unknown_steps_in_the_ground_are_walked_on() {
    let told = WALK.replace("[walking]", "[walking]\nstate = \"measured\"").replace("6.0", "12.0");
    let told = told.replace("time = 4.0", "time = 11.0");
    let ground = "[ground.heights]\nlist = [0.01, -0.01]\n";
    let found = simulated("steps", &format!("{told}{SENSORS}{ground}"));
    assert_eq!(found["walk"]["fell"], Value::Null, "{}", found["walk"]);
    let error = |name: &str| found["walk"]["estimated"][name].as_f64().unwrap();
    assert!(error("tilt") < f64::to_radians(0.5) && error("along_ground") < 0.02, "{}", found["walk"]);
}

/// Which way is north makes no difference.
#[test]
fn a_robot_that_looks_elsewhere_walks_there() {
    let turned = format!("{WALK}[initial]\nbase_rotation = [0.0, 0.0, 2.5]\n");
    let [there, here] = [("turned", turned.as_str()), ("ahead", WALK)].map(|(name, scenario)| {
        walks(name, scenario);
        simulated(name, scenario)["walk"].clone()
    });
    assert_eq!(there["steps"], here["steps"]);
    let distance = |walk: &Value| walk["distance"].as_f64().unwrap();
    assert!((distance(&there) - distance(&here)).abs() < 0.02, "{there} {here}");
}

fn refused(scenario: &str, words: &str) {
    let folder = scratch("walks-refused");
    let [file, log] = ["scenario.toml", "log.csv"].map(|name| folder.join(name));
    std::fs::write(&file, scenario).unwrap();
    let run = bipedc(&["simulate", "robots/tulip", "--scenario", text(&file), "--out", text(&log)]);
    assert!(run.code == Some(1) && run.err.contains(words), "{words}: {}", run.err);
    assert!(!log.exists());
}

#[test]
fn scenarios_without_meaning_are_refused() {
    let walking = |more: &str| format!("duration = 1.0\n[walking]\n{more}\n");
    refused(&walking("state = \"measured\""), "needs an inertial unit");
    refused(&walking("state = \"believed\""), "there is no state");
    refused(&walking("velocity = [{ time = 1.0 }, { time = 0.5, forward = 0.1 }]"), "order of time");
    refused(&walking("velocity = [{ time = 0.0, forward = 1e30 }]"), "1e30");
    refused(&walking("model = \"nowhere\""), "nowhere");
    refused(&walking("settings = \"nothing.toml\""), "nothing.toml");
    refused(&walking("speed = 1.0"), "unknown key `speed`");
    refused(&walking("delay = 0.0015"), "no multiple of the step");
    let ground = |more: &str| format!("duration = 1.0\n[ground.heights]\n{more}\n");
    refused(&ground("kind = \"waves\""), "`height` is missing");
    refused(&ground("kind = \"tiles\"\nheight = 0.01\nlist = [0.01]"), "footholds alone");
    refused(&ground("kind = \"holes\"\nheight = 0.01"), "there is no kind");
    refused("duration = 1.0\nmethod = \"event_driven\"\n[walking]\n", "something else does too");
}
