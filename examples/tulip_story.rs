//! What TUlip's model lacks throws it when it walks; a slow walk tells what it is; amended, it walks again.
//!
//! `cargo run --release --example tulip_story` prints Markdown tables and writes pages. For each hidden change of the robot:
//! 1. it walks by itself at 0.3 m/s, by what its sensors say, with a controller that does not know the change;
//! 2. two slow walks with stiff servos, forward and to the side, are logged; `diagnose` learns from the first, the second judges;
//! 3. what was found is written into a copy of the description by `amend`;
//! 4. the same walk, the same changed robot, with the controller of the amended model.
//!
//! Errors are those of `compare` on the log that judges: of the description, of what was amended, and of the true model.
use bipedc::simulation::{FootstepSummary, Options, Simulated};
use bipedc::walking::{self, Method, Path as Way};
use bipedc::{Diagnostic, Diagnostics, Log, Workbench, comparison, diagnosis};
use bipedc_analysis::diagnose::FoundEffect;
use bipedc_analysis::measure;
use bipedc_analysis::report::{write, write_film};
use std::fs;
use std::path::{Path, PathBuf};

/// A change of the robot that its controller is not told.
struct Change {
    words: &'static str,
    /// As a scenario and a description state them.
    effects: &'static [&'static str],
    /// Whether the controller learns what it carries while it walks.
    learns: bool,
}

const CHANGES: [Change; 6] = [
    Change {
        words: "dry friction of 3 N m at the left knee",
        effects: &["kind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 3.0"],
        learns: false,
    },
    Change {
        words: "a battery of 1 kg in the torso moved forward by 0.2 m",
        // Of 10.2 kg.
        effects: &["kind = \"com_offset\"\nlink = \"torso\"\nx = 0.0196\ny = 0.0\nz = 0.0"],
        learns: false,
    },
    Change {
        words: "2.5 kg more at the torso, 60 mm ahead",
        effects: &["kind = \"payload\"\nlink = \"torso\"\nmass = 2.5\nx = 0.06\ny = 0.0\nz = 0.1"],
        learns: false,
    },
    Change {
        words: "left ankle gone soft: 100 N m/rad before a motor of 0.025 kg m²",
        effects: &[
            "kind = \"series_elasticity\"\njoint = \"left_ankle_pitch\"\nstiffness = 100.0",
            "kind = \"rotor_inertia\"\njoint = \"left_ankle_pitch\"\ninertia = 0.025",
        ],
        learns: false,
    },
    Change {
        words: "the left foot's sensor reports 70 % (the controller learns payloads)",
        effects: &["kind = \"force_sensor_gain\"\nsensor = \"left_foot\"\ngain = 0.7"],
        learns: true,
    },
    Change { words: "nothing", effects: &[], learns: true },
];

/// Of the walks.
const SENSORS: &str = "\
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
/// Of the logs.
const QUIET: &str =
    "[sensors]\nposition_noise = 1e-5\nvelocity_noise = 0.002\nforce_noise = 0.2\neffort_noise = 0.05\n";
const SECONDS: f64 = 12.0;

fn main() {
    if let Err(errors) = story() {
        eprintln!("{errors}");
        std::process::exit(1);
    }
}

fn story() -> Result<(), Diagnostics> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("target/tulip_story");
    let mut walks = "| hidden | walks | walks, amended |\n|---|---|---|\n".to_owned();
    println!("| hidden | found | error of slow walks: described → amended (true model) |\n|---|---|---|");
    for (k, change) in CHANGES.iter().enumerate() {
        let story = Story { robot: root.join("robots/tulip"), folder: folder.join(k.to_string()), change };
        let (description, truth) = (story.copied("robot", "")?, story.copied("true", &story.hidden())?);
        let before = story.walked("before", "")?;
        let (found, errors) = story.explained(&description, &truth)?;
        let after = story.walked("after", "model = \"robot\"\n")?;
        println!("| {} | {found} | {errors} |", change.words);
        walks += &format!("| {} | {} | {} |\n", change.words, words(&before), words(&after));
    }
    println!("\n{walks}\nPages of walks and diagnoses: {}", folder.display());
    Ok(())
}

/// One change, and where its files go.
struct Story<'a> {
    robot: PathBuf,
    folder: PathBuf,
    change: &'a Change,
}

/// Says which file could not be written.
fn put(file: &Path, text: &str) -> Result<(), Diagnostic> {
    fs::write(file, text).map_err(|error| Diagnostic::error(error.to_string()).in_file(file))
}

impl Story<'_> {
    fn hidden(&self) -> String {
        self.change.effects.iter().map(|effect| format!("\n[[effect]]\n{effect}\n")).collect()
    }

    /// A copy of the robot, which may be amended, with more in its description.
    fn copied(&self, name: &str, more: &str) -> Result<PathBuf, Diagnostic> {
        let copy = self.folder.join(name);
        // What an earlier run amended.
        let _ = fs::remove_dir_all(&copy);
        fs::create_dir_all(&copy).map_err(|error| Diagnostic::error(error.to_string()).in_file(&copy))?;
        for file in ["robot.urdf", "biped.toml", "walking.toml"] {
            let from = self.robot.join(file);
            let text = fs::read_to_string(&from)
                .map_err(|error| Diagnostic::error(error.to_string()).in_file(&from))?;
            put(&copy.join(file), &if file == "biped.toml" { text + more } else { text })?;
        }
        Ok(copy)
    }

    /// A walk of the changed robot by itself.
    fn walked(&self, name: &str, model: &str) -> Result<FootstepSummary, Diagnostics> {
        let file = self.folder.join(format!("{name}.toml"));
        let (stop, learns, hidden) = (SECONDS - 2.0, self.change.learns, self.hidden());
        put(
            &file,
            &format!(
                "duration = {SECONDS}\nlog_step = 0.01\n[walking]\n{model}state = \"measured\"\nlearn_payload = {learns}\n\
                 velocity = [{{ time = 0.5, forward = 0.3 }}, {{ time = {stop} }}]\n{SENSORS}{hidden}"
            ),
        )?;
        let run = self.simulated(&file, &self.folder.join(format!("{name}.csv")), true)?;
        if let Some(film) = &run.film {
            write_film(film, &self.folder.join(format!("{name}.html")))?;
        }
        let fell = run.fell();
        Ok(FootstepSummary { fell, ..run.walk.unwrap_or_default() })
    }

    fn simulated(&self, scenario: &Path, log: &Path, film: bool) -> Result<Simulated, Diagnostics> {
        let robot = Workbench::open(&self.robot)?;
        robot.simulate(&robot.scene(scenario)?, log, &Options { film, ..Options::default() })
    }

    /// Logs slow walks of the changed robot, finds what the description lacks, writes it there: what it is, and errors.
    fn explained(&self, description: &Path, truth: &Path) -> Result<(String, String), Diagnostics> {
        let logs = [Way::Forward(None, 3), Way::Sideways(None, 2)]
            .into_iter()
            .enumerate()
            .map(|(k, way)| self.logged(k, way))
            .collect::<Result<Vec<_>, _>>()?;
        let robot = Workbench::open(description)?;
        let (train, judge) = (robot.log(&logs[0])?, robot.log(&logs[1])?);
        let options = diagnosis::Options { report: true, ..diagnosis::Options::default() };
        let found = robot.diagnose_with(&train, Some(&judge), &options)?;
        if let Some(report) = &found.report {
            write(report, &self.folder.join("diagnosis.html"))?;
        }
        let result = &found.diagnosis;
        let amended =
            if result.estimated().next().is_some() { robot.amend(result)? } else { robot.reopened()? };
        let cutoff = result.judged_at_hz.unwrap_or(result.cutoff_hz);
        let errors = errors([&robot, &amended, &Workbench::open(truth)?], &judge, cutoff)?;
        let named: Vec<String> = result.effects.iter().map(named).collect();
        Ok((if named.is_empty() { "nothing".to_owned() } else { named.join("; ") }, errors))
    }

    /// The log of a slow walk with stiff servos.
    fn logged(&self, k: usize, path: Way) -> Result<PathBuf, Diagnostics> {
        let original = Workbench::open(&self.robot)?;
        let [plan, file, log] =
            ["plan.csv", "slow.toml", "slow.csv"].map(|name| self.folder.join(format!("{k}_{name}")));
        let (stated, _) = walking::robots_own(original.robot())?;
        let asked = walking::Options { method: Method::Static, path, stated };
        let planned = walking::plan(original.robot(), &asked, &original.run())?;
        planned.write(&plan)?;
        let (duration, hidden) = (planned.duration(), self.hidden());
        put(
            &file,
            &format!(
                "duration = {duration}\nlog_step = 0.005\nseed = {k}\n[control]\nstiffness = 6000.0\ndamping = 30.0\n\
                 servo = \"drive\"\ntrajectory = \"{k}_plan.csv\"\n{QUIET}{hidden}"
            ),
        )?;
        self.simulated(&file, &log, false)?;
        Ok(log)
    }
}

/// Errors of the models in which anything changes by more than a hundredth, by kind of channel.
fn errors(models: [&Workbench; 3], judge: &Log, cutoff: f64) -> Result<String, Diagnostics> {
    let reading = measure::Options { cutoff_hz: Some(cutoff), ..measure::Options::default() };
    let options = comparison::Options { reading, ..comparison::Options::default() };
    let mut compared = Vec::new();
    for model in models {
        compared.push(model.compare_with(judge, &options)?.comparison.kinds);
    }
    let mut shown = Vec::new();
    for (kind, described) in &compared[0] {
        let [amended, truth] = [1, 2].map(|k| compared[k].get(kind).map_or(f64::NAN, |error| error.rms));
        if *kind == "effort" || (described.rms - truth).abs() > 0.01 * described.rms {
            let kind = kind.replace('_', " ");
            shown.push(format!("{kind} {:.3} → {amended:.3} ({truth:.3}) {}", described.rms, described.unit));
        }
    }
    Ok(shown.join("; "))
}

fn words(walk: &FootstepSummary) -> String {
    let end = walk.fell.map_or(String::new(), |time| format!(", falls at {time:.2} s"));
    let off = 1e3 * walk.divergent_error;
    format!("{} steps, {:.2} m, ξ up to {off:.0} mm off{end}", walk.steps, walk.distance)
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
