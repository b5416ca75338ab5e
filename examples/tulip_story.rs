//! What TUlip's model lacks throws it when it walks; a slow walk tells what it is; amended, it walks again.
//!
//! `cargo run --release --example tulip_story` prints a Markdown page. For each hidden change of the robot:
//! 1. it walks by itself at 0.3 m/s with a controller that does not know the change;
//! 2. two slow walks with stiff servos, forward and to the side, are logged; `diagnose` learns from the first, the second judges;
//! 3. what was found is written into a copy of the description by `amend`;
//! 4. the same walk, the same changed robot, with the controller of the amended model.
use bipedc::simulation::{FootstepSummary, Options};
use bipedc::walking::{self, Method, Path as Way};
use bipedc::{Diagnostics, Workbench, diagnosis};
use bipedc_analysis::diagnose::FoundEffect;
use std::fs;
use std::path::{Path, PathBuf};

/// A change of the robot that its controller is not told.
struct Change {
    words: &'static str,
    effect: &'static str,
}

const CHANGES: [Change; 4] = [
    Change {
        words: "dry friction of 3 N m at the left knee",
        effect: "kind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 3.0",
    },
    Change {
        words: "2.5 kg more at the torso, 60 mm ahead",
        effect: "kind = \"payload\"\nlink = \"torso\"\nmass = 2.5\nx = 0.06\ny = 0.0\nz = 0.1",
    },
    Change {
        words: "viscous friction of 3 N m s/rad at the right knee",
        effect: "kind = \"viscous_friction\"\njoint = \"right_knee_pitch\"\ndamping = 3.0",
    },
    Change { words: "nothing", effect: "" },
];

const SENSORS: &str =
    "[sensors]\nposition_noise = 1e-5\nvelocity_noise = 0.002\nforce_noise = 0.2\neffort_noise = 0.05\n";
const SECONDS: f64 = 12.0;

fn main() {
    if let Err(errors) = story() {
        eprintln!("{errors}");
        std::process::exit(1);
    }
}

fn story() -> Result<(), Diagnostics> {
    let folder = PathBuf::from("target/tulip_story");
    println!(
        "| hidden | walks | slow walks: error of efforts, before → after | found | walks, amended |\n|---|---|---|---|---|"
    );
    for (k, change) in CHANGES.iter().enumerate() {
        let own = folder.join(k.to_string());
        copied(&own);
        let hidden =
            if change.effect.is_empty() { String::new() } else { format!("[[effect]]\n{}\n", change.effect) };
        let before = walked(&own, "", &hidden)?;
        let (error, found) = explained(&own, &hidden)?;
        let after = walked(&own, "model = \"robot\"\n", &hidden)?;
        println!("| {} | {} | {error} | {found} | {} |", change.words, words(&before), words(&after));
    }
    Ok(())
}

/// A copy of the robot that may be amended.
fn copied(folder: &Path) {
    let robot = folder.join("robot");
    // What an earlier run amended.
    let _ = fs::remove_dir_all(&robot);
    fs::create_dir_all(&robot).expect("target/ can be written");
    for name in ["robot.urdf", "biped.toml", "walking.toml"] {
        fs::copy(Path::new("robots/tulip").join(name), robot.join(name)).expect("the robot can be copied");
    }
}

/// A walk of the changed robot by itself.
fn walked(folder: &Path, model: &str, hidden: &str) -> Result<FootstepSummary, Diagnostics> {
    let file = folder.join("walk.toml");
    let stop = SECONDS - 2.0;
    let text = format!(
        "duration = {SECONDS}\nlog_step = 0.01\n[walking]\n{model}velocity = [{{ time = 0.5, forward = 0.3 }}, {{ time = {stop} }}]\n{hidden}"
    );
    fs::write(&file, text).expect("target/ can be written");
    let robot = Workbench::open("robots/tulip")?;
    let run = robot.simulate(&robot.scene(&file)?, folder.join("walk.csv"), &Options::default())?;
    Ok(run.walk.unwrap_or_default())
}

fn words(walk: &FootstepSummary) -> String {
    let end = walk.fell.map_or(String::new(), |time| format!(", falls at {time:.2} s"));
    let off = 1e3 * walk.divergent_error;
    format!("{} steps, {:.2} m, ξ up to {off:.0} mm off{end}", walk.steps, walk.distance)
}

/// Logs slow walks of the changed robot, finds what the model lacks, writes it into the copy.
fn explained(folder: &Path, hidden: &str) -> Result<(String, String), Diagnostics> {
    let original = Workbench::open("robots/tulip")?;
    let ways = [Way::Forward(None, 3), Way::Sideways(None, 2)];
    let mut logs = Vec::new();
    for (k, path) in ways.into_iter().enumerate() {
        let [plan, file, log] =
            ["plan.csv", "slow.toml", "slow.csv"].map(|name| folder.join(format!("{k}_{name}")));
        let (stated, _) = walking::robots_own(original.robot())?;
        let asked = walking::Options { method: Method::Static, path, stated };
        let planned = walking::plan(original.robot(), &asked, &original.run())?;
        planned.write(&plan)?;
        let text = format!(
            "duration = {}\nlog_step = 0.005\nseed = {k}\n[control]\nstiffness = 6000.0\ndamping = 30.0\nservo = \"drive\"\ntrajectory = \"{k}_plan.csv\"\n{SENSORS}{hidden}",
            planned.duration()
        );
        fs::write(&file, text).expect("target/ can be written");
        original.simulate(&original.scene(&file)?, &log, &Options::default())?;
        logs.push(log);
    }
    let robot = Workbench::open(folder.join("robot"))?;
    let (train, judge) = (robot.log(&logs[0])?, robot.log(&logs[1])?);
    let options = diagnosis::Options { with_joints: true, ..diagnosis::Options::default() };
    let diagnosis = robot.diagnose_with(&train, Some(&judge), &options)?;
    let result = &diagnosis.diagnosis;
    let found: Vec<String> = result.effects.iter().map(named).collect();
    let error = format!("{:.3} → {:.3}", result.rms_before, result.rms_after);
    if !found.is_empty() {
        robot.amend(result)?;
    }
    Ok((error, if found.is_empty() { "nothing".to_owned() } else { found.join("; ") }))
}

/// Kind, place, values.
fn named(found: &FoundEffect) -> String {
    let effect = &found.effect;
    let location = &effect.location;
    let place = [&location.joint, &location.link, &location.sensor].into_iter().flatten().next();
    let place = place.map_or(String::new(), |place| format!(" at {place}"));
    let values =
        effect.kind.parameters.iter().map(|p| format!("{} {:.3} {}", p.name, effect.value(p.name), p.unit));
    format!("{}{place}: {}", effect.kind.name.replace('_', " "), values.collect::<Vec<_>>().join(", "))
}
