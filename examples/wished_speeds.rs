//! A robot that is other than its model misses the speeds it is asked for; its walking log tells what the model lacks; amended, it meets them again.
//!
//! `cargo run --release --example wished_speeds [PICTURE.svg]` prints a Markdown table. For each hidden change, of the robot with feet in four phases or of the five-link robot:
//! 1. it walks with wished speeds; at each mid-stance the parameters of the next step are chosen by a model that does not know the change;
//! 2. `diagnose` is given the log of that walk, and what it finds is written into a copy of the description by `amend`;
//! 3. the same changed robot walks for the same speeds, with the gait's controller and the choice of the amended model.
//!
//! The picture shows the speeds of the first change.
use bipedc::simulation::{Options, WalkedSpeeds};
use bipedc::{Diagnostic, Diagnostics, Workbench};
use bipedc_analysis::diagnose::FoundEffect;
use bipedc_analysis::report::{CurveFigure, CurveKind, PlottedCurve, curves_svg};
use std::fs;
use std::path::{Path, PathBuf};

/// What the model is not told.
struct Change {
    words: &'static str,
    /// A folder in robots/.
    robot: &'static str,
    /// The walk with its wished speeds, up to [control], and what else stands there.
    walk: [&'static str; 2],
    hidden: &'static str,
}

const CHANGES: [Change; 4] = [
    Change {
        words: "viscous friction of 0.05 N m s/rad in both ankles",
        robot: "seven_link_v1",
        walk: [FEET, ""],
        hidden: "[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_ankle_pitch\"\ndamping = 0.05\n\
            [[effect]]\nkind = \"viscous_friction\"\njoint = \"right_ankle_pitch\"\ndamping = 0.05\n",
    },
    Change {
        words: "viscous friction of 1 N m s/rad in both knees",
        robot: "five_link",
        walk: [POINTS, CHOICE],
        hidden: "[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 1.0\n\
            [[effect]]\nkind = \"viscous_friction\"\njoint = \"right_knee_pitch\"\ndamping = 1.0\n",
    },
    Change {
        words: "2 kg more on the torso, 0.3 m above the hips",
        robot: "five_link",
        walk: [POINTS, CHOICE],
        hidden: "[[effect]]\nkind = \"payload\"\nlink = \"torso\"\nmass = 2.0\nx = 0.0\ny = 0.0\nz = 0.3\n",
    },
    Change { words: "nothing", robot: "five_link", walk: [POINTS, CHOICE], hidden: "" },
];

const POINTS: &str = "method = \"event_driven\"\nduration = 60.0\nlog_step = 0.002\n\
    [assumptions]\nfriction = 0.8\n\
    [initial]\nmid_stance_speed = 0.7109\n\
    [control]\ngait = \"lifting\"\n\
    speeds = { random = 5, between = [0.66, 0.78], change = 0.03, steps = 24 }\n";

const CHOICE: &str = "[control.parameters]\nknee = 0.3\nlift = 0.6\n\
    [control.choice]\nkeep = [\"friction\", \"pull\", \"torque\", \"clearance\"]\n\
    [control.choice.parameters]\nstep_length = [0.25, 0.55]\ntorso_lean = true\n";

const FEET: &str = "method = \"event_driven\"\nduration = 60.0\nlog_step = 0.002\n\
    [assumptions]\nfriction = 0.8\n\
    [initial]\nmid_stance_speed = 0.42\n\
    [control]\ngait = \"adjustable\"\n\
    speeds = { random = 5, between = [0.38, 0.48], change = 0.03, steps = 12 }\n";

fn main() {
    let picture = std::env::args().nth(1).map(PathBuf::from);
    match story(Path::new("target/wished_speeds"), picture.as_deref()) {
        Ok(rows) => print!("{}", table(&rows)),
        Err(errors) => {
            eprintln!("{errors}");
            std::process::exit(1);
        }
    }
}

/// A line of the table.
pub struct Row {
    /// What the model is not told.
    pub hidden: &'static str,
    /// Root mean square of what wished speeds are missed by, over the mean of these speeds: before, and with the amended model.
    pub missed: [f64; 2],
    /// What the log of the first walk says.
    pub found: String,
}

/// All changes; walks and logs go into a folder.
pub fn story(folder: &Path, picture: Option<&Path>) -> Result<Vec<Row>, Diagnostics> {
    let mut rows = Vec::new();
    for (k, change) in CHANGES.into_iter().enumerate() {
        let (folder, words) = (folder.join(k.to_string()), change.words);
        copied(&folder, change.robot);
        let before = walked(&folder, ("before", ""), &change)?;
        let found = explained(&folder)?;
        let after = walked(&folder, ("after", "model = \"robot\"\n"), &change)?;
        rows.push(Row { hidden: words, missed: [missed(&before), missed(&after)], found });
        if let (0, Some(picture)) = (k, picture) {
            fs::write(picture, curves_svg(&drawn(&change, &before, &after)))
                .expect("the picture can be written");
        }
    }
    Ok(rows)
}

fn table(rows: &[Row]) -> String {
    let head = "| hidden | speeds missed by, of their mean | found in the log of that walk | amended, speeds missed by |\n|---|---|---|---|\n";
    let line = |Row { hidden, missed: [before, after], found }: &Row| {
        format!("| {hidden} | {before:.1e} | {found} | {after:.1e} |\n")
    };
    head.to_owned() + &rows.iter().map(line).collect::<String>()
}

/// A copy of the robot that may be amended.
fn copied(folder: &Path, of: &str) {
    let robot = folder.join("robot");
    // What an earlier run amended.
    let _ = fs::remove_dir_all(&robot);
    fs::create_dir_all(&robot).expect("target/ can be written");
    for name in ["robot.urdf", "biped.toml"] {
        fs::copy(Path::new("robots").join(of).join(name), robot.join(name)).expect("the robot can be copied");
    }
}

/// A walk of the changed robot for wished speeds.
fn walked(folder: &Path, (name, model): (&str, &str), change: &Change) -> Result<WalkedSpeeds, Diagnostics> {
    let Change { robot, walk: [scenario, choice], hidden, .. } = change;
    let file = folder.join(format!("{name}.toml"));
    fs::write(&file, format!("{scenario}{model}{choice}{hidden}")).expect("target/ can be written");
    let robot = Workbench::open(Path::new("robots").join(robot))?;
    let log = folder.join(format!("{name}.csv"));
    let run = robot.simulate(&robot.scene(&file)?, log, &Options::default())?;
    match run.speeds() {
        Some(speeds) if !run.is_refuted() => Ok(speeds.clone()),
        _ => Err(run.messages.first().cloned().unwrap_or_else(|| Diagnostic::error("no speeds")).into()),
    }
}

/// What the log of the first walk says, written into the copy.
fn explained(folder: &Path) -> Result<String, Diagnostics> {
    let robot = Workbench::open(folder.join("robot"))?;
    let log = robot.log(folder.join("before.csv"))?;
    let diagnosis = robot.diagnose(&log, None)?.diagnosis;
    if diagnosis.effects.is_empty() {
        return Ok("nothing".to_owned());
    }
    robot.amend(&diagnosis)?;
    Ok(diagnosis.effects.iter().map(named).collect::<Vec<_>>().join("; "))
}

/// Kind, place, values.
fn named(found: &FoundEffect) -> String {
    let effect = &found.effect;
    let place = [&effect.location.joint, &effect.location.link].into_iter().flatten().next();
    let place = place.map_or(String::new(), |place| format!(" at {place}"));
    let values =
        effect.kind.parameters.iter().map(|p| format!("{} {:.4} {}", p.name, effect.value(p.name), p.unit));
    format!("{}{place}: {}", effect.kind.name.replace('_', " "), values.collect::<Vec<_>>().join(", "))
}

/// The root mean square of what wished speeds are missed by.
fn missed(walk: &WalkedSpeeds) -> f64 {
    let off = walk.steps.iter().filter_map(|step| Some((step.wished? - step.reached?).powi(2)));
    let wished: f64 = walk.steps.iter().filter_map(|step| step.wished).sum();
    (off.sum::<f64>() * walk.wished.max(1) as f64).sqrt() / wished
}

fn drawn(change: &Change, before: &WalkedSpeeds, after: &WalkedSpeeds) -> CurveFigure {
    let curve = |kind, words: &str, walk: &WalkedSpeeds, wished: bool| {
        let point = |step: &bipedc::gait::choice::StepSpeed| {
            Some([
                step.step as f64,
                if wished { step.wished? } else { step.reached.filter(|_| step.wished.is_some())? },
            ])
        };
        PlottedCurve { kind, words: words.to_owned(), points: walk.steps.iter().filter_map(point).collect() }
    };
    CurveFigure {
        title: format!("wished speeds with {}", change.words),
        robot: change.robot.to_owned(),
        x: "step".to_owned(),
        y: format!("speed at mid-stance ({})", before.unit),
        counted: [true, false],
        curves: vec![
            curve(CurveKind::Wish, "wished", before, true),
            curve(CurveKind::Other, "model as described", before, false),
            curve(CurveKind::Third, "model amended by the walk's log", after, false),
        ],
        ..CurveFigure::default()
    }
}
