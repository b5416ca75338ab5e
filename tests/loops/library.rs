//! Whether the library says what the command says, step by step.
use super::explain::explain;
use crate::loops::cli::{bipedc, scratch, text};
use bipedc::progress::Progress;
use bipedc::{Workbench, comparison, excitation, identification};
use bipedc_analysis::diagnose::{Diagnosis, FoundEffect};
use bipedc_analysis::identify::excite::{Criterion, Family, Request, Scaling};
use bipedc_effects::effect::{Effect, Location, kinds};
use flate2::read::GzDecoder;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

const TRAIN: &str = "tests/data/examples/coulomb/train.csv.gz";
const JUDGE: &str = "tests/data/examples/coulomb/validation.csv.gz";

/// A copy of a robot that may be amended.
fn robot(name: &str) -> PathBuf {
    let folder = scratch(name);
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(Path::new("robots/tulip").join(file), folder.join(file)).unwrap();
    }
    folder
}

/// The first rows of a log.
fn first_rows(log: &str, rows: usize, path: &Path) -> String {
    let mut all = String::new();
    GzDecoder::new(std::fs::File::open(log).unwrap()).read_to_string(&mut all).unwrap();
    let kept: String = all.split_inclusive('\n').take(rows + 1).collect();
    std::fs::write(path, kept).unwrap();
    text(path).to_string()
}

/// As commands print it.
fn json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).unwrap() + "\n"
}

#[test]
#[ignore = "takes long"]
fn the_example_says_what_the_commands_say() {
    let folder = robot("library_example");
    let before = std::fs::read(folder.join("biped.toml")).unwrap();
    let train = first_rows(TRAIN, 1500, &folder.join("train.csv"));
    let by_library = explain([text(&folder), &train, JUDGE]).unwrap();
    assert_eq!(std::fs::read(folder.join("biped.toml")).unwrap(), before, "only in memory");
    assert!(!folder.join("history.json").exists());

    let compare = || bipedc(&["compare", text(&folder), JUDGE]).ok().out;
    let diagnose = |more: &[&str]| {
        let arguments = [&["diagnose", text(&folder), &train, "--validate", JUDGE], more].concat();
        bipedc(&arguments).ok().out
    };
    let (first, words) = (compare(), diagnose(&[]));
    let file = folder.join("diagnosis.json");
    std::fs::write(&file, diagnose(&["--json"])).unwrap();
    bipedc(&["amend", text(&folder), "--from", text(&file)]).ok();
    assert_ne!(first, compare());
    assert_eq!(by_library, format!("{first}\n{words}\n{}", compare()));

    let found: Diagnosis = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    assert_eq!(json(&found), std::fs::read_to_string(&file).unwrap());
}

#[test]
fn a_comparison_is_the_json_that_the_command_prints() {
    let bench = Workbench::open("robots/tulip").unwrap();
    let options = comparison::Options { places: true, free_run: Some(0.5), ..Default::default() };
    let compared = bench.compare_with(&bench.log(JUDGE).unwrap(), &options).unwrap();
    let command = bipedc(&["compare", "robots/tulip", JUDGE, "--where", "--free-run", "0.5", "--json"]);
    assert_eq!(json(&compared), command.ok().out);
}

/// A diagnosis of one effect.
fn diagnosis(joint: &str, torque: f64) -> Diagnosis {
    let effect = Effect::new(&kinds::COULOMB_FRICTION, Location::joint(joint), &[("torque", torque)]);
    let found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.5, doubts: Vec::new() };
    Diagnosis { effects: vec![found], ..Diagnosis::default() }
}

#[test]
fn what_is_amended_in_memory_is_what_is_amended_on_disk() {
    let folder = robot("library_amend");
    let before = std::fs::read(folder.join("biped.toml")).unwrap();
    let bench = Workbench::open(&folder).unwrap();
    let knee = diagnosis("left_knee_pitch", 0.43);
    let in_memory = bench.amended(&knee).unwrap();
    assert_eq!(std::fs::read(folder.join("biped.toml")).unwrap(), before);
    // A second step stands on the first.
    let both = in_memory.amended(&diagnosis("right_knee_pitch", 0.2)).unwrap();
    assert_eq!(both.robot().description.effects.len(), 2);

    let on_disk = bench.amend(&knee).unwrap();
    assert_eq!(on_disk.robot().description, in_memory.robot().description);
    assert_eq!(on_disk.history().unwrap().steps.len(), 1);
    assert_eq!(bench.reopened().unwrap().robot(), on_disk.robot());
    on_disk.undo(false).unwrap();
    assert_eq!(std::fs::read(folder.join("biped.toml")).unwrap(), before);
    // Nothing found is nothing to write.
    assert!(bench.amend(&Diagnosis::default()).unwrap().robot().description.effects.is_empty());
}

#[derive(Default)]
struct Heard {
    stages: Mutex<Vec<String>>,
    /// Of every open stage, the innermost last: the part that is done.
    parts: Mutex<Vec<f64>>,
    advances: AtomicUsize,
}

impl Progress for Heard {
    fn begin(&self, stage: &str, _counted: bool) {
        self.stages.lock().unwrap().push(format!("+{stage}"));
        self.parts.lock().unwrap().push(0.0);
    }
    fn advance(&self, part: f64) {
        let mut parts = self.parts.lock().unwrap();
        let last = parts.last_mut().unwrap();
        assert!((*last..=1.0).contains(&part), "back from {last} to {part}");
        *last = part;
        self.advances.fetch_add(1, Ordering::Relaxed);
    }
    fn end(&self) {
        self.stages.lock().unwrap().push("-".to_owned());
        self.parts.lock().unwrap().pop().unwrap();
    }
}

#[test]
fn errors_name_their_place_and_progress_is_told() {
    let heard = Arc::new(Heard::default());
    let bench = Workbench::open("robots/tulip").unwrap().watched(heard.clone());
    let errors = bench.log("no/such.csv").unwrap_err();
    assert_eq!(errors.0[0].file.as_deref(), Some(Path::new("no/such.csv")));
    assert!(Workbench::open("no/such").is_err());
    bench.compare(&bench.log(JUDGE).unwrap()).unwrap();
    let stages = ["deriving", "reading and comparing", "looking where joints stick"];
    let expected: Vec<String> =
        stages.iter().flat_map(|stage| [format!("+{stage}"), "-".to_owned()]).collect();
    assert_eq!(*heard.stages.lock().unwrap(), expected);
    bench.diagnose(&bench.log(TRAIN).unwrap(), Some(&bench.log(JUDGE).unwrap())).unwrap();
    assert!(heard.advances.load(Ordering::Relaxed) > 2 && heard.parts.lock().unwrap().is_empty());
}

/// What the command's arguments never are, the library's options may be.
#[test]
fn options_without_meaning_are_errors() {
    let bench = Workbench::open("robots/tulip").unwrap();
    let errors = bench.identify(&[], None).unwrap_err();
    assert!(errors.to_string().contains("no log was given"), "{errors}");
    let log = bench.log(TRAIN).unwrap();
    for (cutoff_hz, slow, weight) in [(f64::NAN, 0.0, 1.0), (10.0, 0.7, 1.0), (10.0, 0.0, -1.0)] {
        let mut options = identification::Options::default();
        options.reading.cutoff_hz = Some(cutoff_hz);
        (options.slow, options.weight) = (Some(slow), Some(weight));
        assert!(bench.identify_with(&[&log], None, &options).is_err(), "{options:?}");
    }
    let request = Request {
        family: Family::Fourier(3),
        duration: 10.0,
        margin: 0.05,
        scaling: Scaling::Unit,
        criterion: Criterion::Condition,
        seed: 1,
        starts: 1,
        evaluations: 1,
        time_limit: None,
    };
    for (rate, acceleration) in [(f64::INFINITY, 1.0), (1e12, 1.0), (200.0, -1.0)] {
        let (joints, acceleration) = (Vec::new(), Some(acceleration));
        let options = excitation::Options { joints, acceleration, gap: 0.02, rate, request };
        assert!(bench.design_motion(&options, "/nowhere/at/all.csv").is_err(), "{options:?}");
    }
    for cutoff in [f64::NAN, -1.0, 0.0] {
        let mut options = comparison::Options { free_run: Some(cutoff), ..Default::default() };
        options.reading.cutoff_hz = Some(cutoff);
        assert!(bench.compare_with(&log, &options).is_err(), "{options:?}");
    }
}

/// Where the knee of the released leg is at the end of a log, rad.
fn last_knee(log: &Path) -> f64 {
    let text = std::fs::read_to_string(log).unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name == "right_knee_pitch/position");
    text.lines().last().unwrap().split(',').nth(column.unwrap()).unwrap().parse().unwrap()
}

#[test]
fn a_controller_made_of_generated_code_carries_the_leg() {
    let folder = scratch("own_controller");
    let (carried, fallen) = (folder.join("carried.csv"), folder.join("fallen.csv"));
    super::controller::simulate(&carried).unwrap_or_else(|e| panic!("{e}"));
    let leg = Workbench::open("robots/tulip_v1_leg").unwrap();
    let scene = leg.scene("robots/tulip_v1_leg/scenarios/released.toml").unwrap();
    leg.simulate(&scene, &fallen, &Default::default()).unwrap();
    let (carried, fallen) = (last_knee(&carried), last_knee(&fallen));
    assert!((carried - 0.9).abs() < 1e-6 && (fallen - 0.9).abs() > 0.1, "{carried} {fallen}");
    let (docs, example) =
        (include_str!("../../docs/simulation.md"), include_str!("../../examples/controller.rs"));
    let section =
        docs.split("\n## ").find(|section| section.starts_with("A controller of one's own\n")).unwrap();
    let block = section.split("```").nth(1).unwrap().strip_prefix("rust\n").unwrap();
    assert!(example.contains(block), "{block}");
}

#[test]
fn the_readme_shows_the_example() {
    let (readme, example) = (include_str!("../../README.md"), include_str!("../../examples/explain.rs"));
    let section = readme.split("\n## ").find(|section| section.starts_with("As a library\n")).unwrap();
    let block = section.split("```").nth(1).unwrap().strip_prefix("rust\n").unwrap();
    assert!(example.contains(block), "{block}");
    assert!(example.lines().count() <= 40);
}
