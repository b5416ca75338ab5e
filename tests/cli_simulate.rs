//! `bipedc simulate`: scenarios, logs, interruption, and whether `diagnose` finds what was hidden.
use crate::cli;
#[path = "cli_simulate/bounds.rs"]
mod bounds;
#[path = "cli_simulate/falls.rs"]
mod falls;
#[cfg(unix)]
#[path = "cli_simulate/outputs.rs"]
mod outputs;

use cli::{Run, bipedc, command, piped, scratch, text};
use std::path::Path;

/// A double pendulum's worth of robot: fixed base, four joints.
const SWING: &str = "duration = 8.0
step = 0.0005
log_step = 0.005
seed = 3
[control]
stiffness = 300.0
damping = 5.0
[joint]
right_hip_pitch = { position = -0.2, sines = [[0.3, 0.5, 0.0], [0.1, 1.1, 1.0]] }
right_knee_pitch = { position = 0.6, sines = [[0.3, 0.4, 0.2], [0.1, 0.9, 0.5]] }
left_hip_pitch = { position = -0.2, sines = [[0.25, 0.45, 0.3], [0.1, 1.3, 0.0]] }
left_knee_pitch = { position = 0.6, sines = [[0.3, 0.55, 0.7], [0.12, 1.2, 0.0]] }
[sensors]
encoder_counts = 200000
effort_noise = 0.03
";

const STAND: &str = "duration = 0.4
[control]
stiffness = 500.0
damping = 3.0
";

fn simulate(robot: &str, folder: &Path, name: &str, scenario: &str, options: &[&str]) -> Run {
    let (file, log) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}.csv")));
    std::fs::write(&file, scenario).unwrap();
    bipedc(&[&["simulate", robot, "--scenario", text(&file), "--out", text(&log)], options].concat())
}

/// A robot on both feet that squats, faster than its feet keep all corners loaded evenly.
const SQUAT: &str = "duration = 6.0
step = 0.0005
log_step = 0.005
seed = 5
[control]
stiffness = 1500.0
damping = 15.0
servo = \"drive\"
[joint]
right_hip_pitch = { position = -0.3, sines = [[0.10, 0.8, 0.0]] }
right_knee_pitch = { position = 0.6, sines = [[-0.20, 0.8, 0.0]] }
right_ankle_pitch = { position = -0.3, sines = [[0.10, 0.8, 0.0]] }
left_hip_pitch = { position = -0.3, sines = [[0.10, 0.8, 0.0]] }
left_knee_pitch = { position = 0.6, sines = [[-0.20, 0.8, 0.0]] }
left_ankle_pitch = { position = -0.3, sines = [[0.10, 0.8, 0.0]] }
[sensors]
position_noise = 1e-4
force_noise = 0.3
effort_noise = 0.05
";

/// Rows of a comparison with error and noise.
fn rows(run: &serde_json::Value) -> Vec<(String, f64, f64)> {
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap();
    let channels = run["channels"].as_array().unwrap().iter();
    channels.map(|row| (row["name"].to_string(), number(row, "rms"), number(row, "noise"))).collect()
}

/// Of single steps' forces the log said that the ground pushed by 3 times the noise more or less than it did.
#[test]
fn a_clean_log_on_feet_leaves_nothing_but_noise() {
    let folder = scratch("simulate_squat");
    simulate("robots/tulip", &folder, "squat", SQUAT, &[]).ok();
    let run = bipedc(&["compare", "robots/tulip", text(&folder.join("squat.csv")), "--json"]).ok().json();
    let rows = rows(&run);
    assert!(rows.len() > 16, "{rows:?}");
    // 167 samples behind a filter tell a root mean square to a tenth.
    assert!(rows.iter().all(|(_, rms, noise)| *rms < 1.35 * noise), "{rows:?}");
}

/// Noise of the encoders is twice differentiated, and most of what a faultless joint leaves.
#[test]
fn a_clean_log_with_noisy_encoders_leaves_nothing_but_noise() {
    let folder = scratch("simulate_noisy_encoders");
    // Away from the knees' stops, which a servo without feed-forward meets.
    let noisy = SWING.replace("encoder_counts = 200000", "position_noise = 3e-4");
    let noisy = noisy.replace("position = 0.6", "position = 0.9");
    simulate("robots/five_link", &folder, "noisy", &noisy, &["--base", "fixed"]).ok();
    let log = folder.join("noisy.csv");
    let asked =
        ["robots/five_link", text(&log), "--base", "fixed", "--cutoff", "10", "--from", "1", "--json"];
    let run = bipedc(&[&["compare"], &asked[..]].concat()).ok().json();
    for (name, rms, noise) in rows(&run) {
        assert!(noise > 0.1 && (0.8..1.25).contains(&(rms / noise)), "{name}: {rms} N m, noise {noise} N m");
    }
    let found = bipedc(&[&["diagnose"], &asked[..]].concat()).ok().json();
    assert_eq!(
        (&found["effects"], &found["unexplained"]),
        (&serde_json::json!([]), &false.into()),
        "{found:#}"
    );
}

/// What the filter smears where friction turns about is no news once the friction stands in the description.
#[test]
fn an_amended_robot_is_judged_as_it_was() {
    let folder = scratch("simulate_amended");
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(Path::new("robots/five_link").join(file), folder.join(file)).unwrap();
    }
    let quiet = SWING.replace("effort_noise = 0.03", "effort_noise = 0.01");
    let quiet = quiet.replace("position = 0.6", "position = 0.9");
    let dry = |joint: &str, torque: f64| {
        format!("[[effect]]\nkind = \"coulomb_friction\"\njoint = \"{joint}\"\ntorque = {torque}\n")
    };
    let hidden = format!("{quiet}{}{}", dry("left_knee_pitch", 0.8), dry("left_hip_pitch", 1.2));
    simulate("robots/five_link", &folder, "log", &hidden, &["--base", "fixed"]).ok();
    let (log, answer) = (folder.join("log.csv"), folder.join("found.json"));
    let ask =
        || bipedc(&["diagnose", text(&folder), text(&log), "--base", "fixed", "--from", "1", "--json"]).ok();
    let before = ask();
    std::fs::write(&answer, &before.out).unwrap();
    let before = before.json();
    assert_eq!(before["effects"].as_array().unwrap().len(), 2, "{before:#}");
    bipedc(&["amend", text(&folder), "--from", text(&answer)]).ok();
    let after = ask().json();
    assert_eq!(after["effects"], serde_json::json!([]), "{after:#}");
    assert_eq!((&before["unexplained"], &after["unexplained"]), (&false.into(), &false.into()), "{after:#}");
    // The comparison of the amended robot holds the same errors against the same noise.
    let compared =
        bipedc(&["compare", text(&folder), text(&log), "--base", "fixed", "--from", "1", "--json"]);
    for row in compared.ok().json()["channels"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64();
        let told = number("away_from_jumps").or(number("rms_moving")).or(number("rms")).unwrap();
        // The factor beyond which a diagnosis calls a row unexplained.
        assert!(told < 1.4 * number("noise").unwrap(), "{row:#}");
    }
}

#[test]
fn diagnose_finds_what_simulate_hid() {
    let folder = scratch("simulate_hidden");
    let hidden = "[[effect]]\nkind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 0.8\n";
    let truth = folder.join("truth.json");
    let options = ["--base", "fixed", "--truth", text(&truth), "--json"];
    let run =
        simulate("robots/five_link", &folder, "train", &format!("{SWING}{hidden}"), &options).ok().json();
    assert_eq!(run["rows"], 1600);
    let written: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&truth).unwrap()).unwrap();
    assert_eq!(written["effects"][0]["kind"], "coulomb_friction");
    assert_eq!(written["effects"][0]["parameters"]["torque"], 0.8);
    let log = folder.join("train.csv");
    let found = bipedc(&[
        "diagnose",
        "robots/five_link",
        text(&log),
        "--base",
        "fixed",
        "--inertial",
        "none",
        "--json",
    ]);
    let found = found.ok().json();
    let steps = found["steps"].as_array().unwrap();
    let kinds: Vec<&str> = steps.iter().filter_map(|step| step["effect"]["kind"].as_str()).collect();
    assert_eq!(kinds, ["coulomb_friction"], "{found}");
    assert_eq!(steps[0]["effect"]["joint"], "left_knee_pitch");
    let torque = steps[0]["effect"]["parameters"]["torque"].as_f64().unwrap();
    println!("hidden 0.8 N m, found {torque} N m");
    assert!((torque - 0.8).abs() < 0.03, "{torque}");
}

/// The scenario is read for the run, for the truth and for the page.
#[cfg(unix)]
#[test]
fn a_scenario_may_come_through_a_pipe() {
    let folder = scratch("simulate_pipe");
    let scenario = STAND.replace("0.4", "0.02");
    std::fs::write(folder.join("stand.toml"), &scenario).unwrap();
    let run = |name: &str, file: &str, input: &[u8]| {
        let paths = ["csv", "json", "html"].map(|kind| folder.join(format!("{name}.{kind}")));
        let [out, truth, page] = paths.each_ref().map(|path| text(path));
        let arguments = ["simulate", "robots/five_link", "--scenario", file, "--out", out, "--truth", truth];
        piped(&[&arguments[..], &["--report", page]].concat(), input).ok();
        [out, truth].map(|file| std::fs::read_to_string(file).unwrap())
    };
    let file = folder.join("stand.toml");
    assert_eq!(run("pipe", "/dev/stdin", scenario.as_bytes()), run("file", text(&file), b""));
}

#[test]
fn equal_seeds_give_equal_bytes() {
    let folder = scratch("simulate_seeds");
    let noise = "[sensors]\nposition_noise = 1e-4\nforce_noise = 0.5\nbase_orientation_noise = 1e-3\n";
    let log = |name: &str, seed: u64| {
        let scenario = format!("seed = {seed}\n{STAND}{noise}");
        simulate("robots/seven_link", &folder, name, &scenario, &[]).ok();
        std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap()
    };
    let (a, b, c) = (log("a", 1), log("b", 1), log("c", 2));
    assert_eq!(a, b);
    assert_ne!(a, c);
    let header = a.lines().next().unwrap();
    for column in
        ["time", "right_knee_pitch/effort", "right_foot/force/z", "left_foot/toe/force/z", "right_foot/cop/x"]
    {
        assert!(header.split(',').any(|name| name == column), "no {column} in {header}");
    }
    assert!(
        header.ends_with("base/linear_velocity/x,base/linear_velocity/z,base/angular_velocity/y"),
        "{header}"
    );
    assert_eq!(a.lines().count(), 401);
}

#[test]
fn a_standing_log_is_read_by_compare() {
    let folder = scratch("simulate_stand");
    simulate("robots/tulip", &folder, "stand", &STAND.replace("0.4", "2.0"), &[]).ok();
    let log = folder.join("stand.csv");
    let compared = bipedc(&["compare", "robots/tulip", text(&log), "--json"]).ok().json();
    let channels = compared["channels"].as_array().unwrap();
    assert!(!channels.is_empty(), "{compared}");
    for channel in channels {
        // Nothing is hidden: what is left is what the filter of 5 Hz takes away, and the landing by rounding.
        let rms = channel["rms"].as_f64().unwrap();
        assert!(rms < 1.0, "{channel}");
    }
}

#[test]
fn a_film_and_pictures_are_written() {
    let folder = scratch("simulate_film");
    let (page, pictures) = (folder.join("stand.html"), folder.join("pictures"));
    let options = ["--report", text(&page), "--svg", text(&pictures)];
    simulate("robots/seven_link", &folder, "stand", STAND, &options).ok();
    let plain = folder.join("plain.csv");
    let scenario = folder.join("stand.toml");
    bipedc(&["simulate", "robots/seven_link", "--scenario", text(&scenario), "--out", text(&plain)]).ok();
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    assert_eq!(read(&folder.join("stand.csv")), read(&plain), "filming changes nothing");
    let html = read(&page);
    assert!(html.contains("seven_link: simulation of stand.toml") && html.contains("stand.toml, FNV-1a"));
    assert!(html.len() < 5_000_000 && !html.contains("src=\"http"), "{} bytes", html.len());
    for name in ["side.svg", "front.svg"] {
        let picture = read(&pictures.join(name));
        assert_eq!(picture.matches("<g class=\"pose\"").count(), 9, "{name}");
    }
    // On a stand nothing touches the ground.
    let options = ["--base", "fixed", "--report", text(&page)];
    simulate("robots/five_link", &folder, "swing", &SWING.replace("8.0", "0.5"), &options).ok();
    let html = read(&page);
    assert!(html.contains("of the links that move") && !html.contains("id=\"strip\""));
}

#[test]
fn the_energy_balance_closes() {
    let folder = scratch("simulate_energy");
    let scenario = "duration = 0.5
step = 0.0001
log_step = 0.001
[initial]
clearance = 0.02
[control]
stiffness = 300.0
damping = 3.0
[joint.left_knee_pitch]
sines = [[0.3, 2.0, 0.0]]
[ground]
restitution = 0.2
[[effect]]
kind = \"viscous_friction\"
joint = \"left_knee_pitch\"
damping = 0.4
[[effect]]
kind = \"coulomb_friction\"
joint = \"right_knee_pitch\"
torque = 0.5
[[effect]]
kind = \"rotor_inertia\"
joint = \"left_knee_pitch\"
inertia = 0.05
[[effect]]
kind = \"parallel_spring\"
joint = \"left_hip_pitch\"
stiffness = 10.0
rest_angle = 0.2
";
    let summary =
        simulate("robots/seven_link", &folder, "hop", scenario, &["--energy", "--json"]).ok().json();
    let energy = &summary["energy"];
    let number = |key: &str| energy[key].as_f64().unwrap_or_else(|| panic!("no {key} in {energy}"));
    let change = |key: &str| energy[key][1].as_f64().unwrap() - energy[key][0].as_f64().unwrap();
    let losses = ["viscous_friction", "dry_friction", "stops", "impacts", "sliding", "ground_dampers"];
    let lost: f64 = losses.iter().map(|key| number(key)).sum();
    assert!((lost - number("lost")).abs() < 1e-12 && lost > 0.1, "{energy}");
    for (key, sign) in [("viscous_friction", 1.0), ("dry_friction", 1.0), ("impacts", 1.0)] {
        assert!(sign * number(key) > 1e-3, "{key} of {energy}");
    }
    assert!(number("laws").abs() > 1e-3 && energy["rotors"][1].as_f64().unwrap() > 0.0, "{energy}");
    let stored: f64 =
        ["kinetic", "potential", "rotors", "ground_springs"].iter().map(|key| change(key)).sum();
    let unexplained = stored - number("drives") - number("laws") + lost;
    assert!((unexplained - number("remainder")).abs() < 1e-9, "{energy}");
    assert!(unexplained.abs() < 1e-3 * lost, "{unexplained} of {energy}");
    let words = simulate("robots/seven_link", &folder, "hop", scenario, &["--energy"]).ok().out;
    assert!(words.contains("impacts of feet") && words.contains("not explained by these"), "{words}");
}

#[test]
fn mistakes_are_named_with_their_place() {
    let folder = scratch("simulate_mistakes");
    let fails = |name: &str, scenario: &str, words: &[&str]| {
        simulate("robots/tulip", &folder, name, scenario, &[]).fails_with(words);
        assert!(!folder.join(format!("{name}.csv")).exists(), "{name} left a log");
        assert!(temporary(&folder).is_none(), "{name} left a partial log");
    };
    fails("key", "duration = 1.0\nstepp = 0.1\n", &["key.toml:2", "stepp"]);
    fails("type", "duration = \"long\"\n", &["type.toml:1"]);
    fails("negative", "duration = 1.0\nstep = -0.1\n", &["negative.toml:2:8", "`step` = -0.1"]);
    fails(
        "joint",
        "duration = 1.0\n[joint.left_kne_pitch]\nposition = 0.1\n",
        &["joint.toml:2", "left_knee_pitch"],
    );
    let twice = "duration = 1.0\n[joint]\nleft_knee_pitch = { position = 0.1 }\nleft_knee_pitch = { position = 0.2 }\n";
    fails("twice", twice, &["twice.toml:4", "duplicate key"]);
    let limits = "duration = 1.0\n[joint.left_knee_pitch]\nposition = 9.0\n";
    fails("limits", limits, &["limits.toml:3:12", "beyond its limits"]);
    let sunk = "duration = 1.0\n\n[initial]\nbase_position = [0.0, 0.0, 0.5]\n";
    fails("sunk", sunk, &["sunk.toml:3", "below the ground", "clearance"]);
    let base = "duration = 1.0\n[initial]\nbase_position = [0.0, 0.5]\n";
    fails("base", base, &["base.toml:3", "[x, y, z]"]);
    let effect = "duration = 1.0\n[[effect]]\nkind = \"coulomb_frictoin\"\n";
    fails("effect", effect, &["effect.toml:2", "coulomb_friction"]);
    let place = "duration = 1.0\n[[effect]]\nkind = \"payload\"\nlink = \"torsoo\"\nmass = 1.0\n";
    fails("place", place, &["place.toml:4", "torso"]);
    let bounds =
        "duration = 1.0\n[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_hip_roll\"\ndamping = -1\n";
    fails("bounds", bounds, &["bounds.toml:5", "damping"]);
    fails(
        "elastic",
        "duration = 1.0\n[[effect]]\nkind = \"backlash\"\njoint = \"left_hip_roll\"\ngap = 0.01\n",
        &["elastic.toml", "motor's inertia", "[motor.left_hip_roll]"],
    );
    fails("log", "duration = 1.0\nstep = 0.001\nlog_step = 0.0015\n", &["log.toml:3", "multiple"]);
    fails(
        "long",
        "duration = 0.1\nstep = 0.5\n",
        &["long.toml:2:8", "longer than the whole run", "shorten `step`"],
    );
    fails("short", "duration = 0.0005\n", &["short.toml:1:12", "step of 0.001 s"]);
    let missing = folder.join("nothing.toml");
    let out = folder.join("nothing.csv");
    bipedc(&["simulate", "robots/tulip", "--scenario", text(&missing), "--out", text(&out)])
        .fails_with(&["nothing.toml", "cannot read the scenario"]);
}

#[test]
fn unstable_gains_are_said() {
    let folder = scratch("simulate_unstable");
    let wild = "duration = 1.0\n[control]\nstiffness = 1e9\neffort_limits = false\njoint_stops = false\n[joint.left_knee_pitch]\nposition = 0.1\nreference = 0.5\n";
    simulate("robots/tulip", &folder, "wild", wild, &["--base", "fixed"])
        .fails_with(&["no longer finite", "gains"]);
    assert!(!folder.join("wild.csv").exists());
    // Light ankles under a damping that is held over a step; and a spring that is held too long.
    let damped = "duration = 1.0\n[control]\nstiffness = 300.0\ndamping = 5.0\n[joint.left_knee_pitch]\nposition = 0.4\nsines = [[0.2, 0.5, 0.0]]\n";
    let words = ["ankle", "damping = 5 N m s/rad", "0.001 s", "servo = \"drive\""];
    simulate("robots/tulip", &folder, "damped", damped, &["--base", "fixed"]).fails_with(&words);
    let inside = damped.replace("[joint", "servo = \"drive\"\n[joint");
    simulate("robots/tulip", &folder, "inside", &inside, &["--base", "fixed"]).ok();
    let sprung = damped.replace("300.0", "3000.0").replace("= 5.0", "= 0.1");
    simulate("robots/tulip", &folder, "sprung", &sprung, &["--base", "fixed"])
        .fails_with(&["stiffness = 3000 N m/rad", "raise the damping"]);
}

#[test]
fn trajectories_name_joints_of_the_robot() {
    let folder = scratch("simulate_trajectory");
    let scenario = "duration = 0.1\n[control]\ntrajectory = \"t.csv\"\n";
    let said = |table: &str, words: &[&str]| {
        std::fs::write(folder.join("t.csv"), table).unwrap();
        simulate("robots/tulip", &folder, "t", scenario, &["--base", "fixed"]).fails_with(words);
    };
    said("time,left_knee/position\n0,0.1\n1,0.2\n", &["t.toml:3", "no joint `left_knee`", "left_knee_pitch"]);
    said("time,left_knee_pitch/velocity\n0,0.1\n1,0.2\n", &["no column `<joint>/position`"]);
}

#[test]
fn steps_that_take_feet_through_the_ground_are_said() {
    let folder = scratch("simulate_sunk");
    // Without restitution a step looks ahead to the ground.
    let long = "duration = 1.0\nstep = 0.2\n[initial]\nclearance = 0.3\n[ground]\nrestitution = 0.1\n";
    simulate("robots/tulip", &folder, "long", long, &[]).fails_with(&[
        "_foot/",
        "below hard ground",
        "the step of 0.2 s is too long",
    ]);
    assert!(!folder.join("long.csv").exists());
}

/// The file of a log that is being written.
fn temporary(folder: &Path) -> Option<std::fs::DirEntry> {
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    entries.into_iter().find(|entry| entry.file_name().to_string_lossy().ends_with("-tmp"))
}

/// Waits until rows of a log have reached the disk.
#[cfg(unix)]
fn grows(folder: &Path) -> bool {
    (0..600).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(100));
        temporary(folder).and_then(|file| file.metadata().ok()).is_some_and(|file| file.len() > 20_000)
    })
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_its_log() {
    let folder = scratch("simulate_interrupted");
    let (file, log) = (folder.join("long.toml"), folder.join("long.csv"));
    std::fs::write(&file, STAND.replace("0.4", "100000.0")).unwrap();
    let mut run = command(&["simulate", "robots/seven_link", "--scenario", text(&file), "--out", text(&log)]);
    let mut child =
        run.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap();
    assert!(grows(&folder), "no temporary file");
    // Ctrl-C (INT) is ignored by what a shell starts in the background, such as these tests.
    let kill = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(temporary(&folder).is_none());
    let written = std::fs::read_to_string(&log).unwrap();
    let columns = written.lines().next().unwrap().split(',').count();
    assert!(written.ends_with('\n') && written.lines().count() > 10);
    assert!(written.lines().all(|line| line.split(',').count() == columns));
}
