//! The experiments of `tests/data/examples`: made by another simulator, with truths in another vocabulary.
use super::Context;
use super::answer::{Answer, ask};
use super::case::explained;
use super::judge::{Scored, judge};
use crate::generator::{Experiment, Failure, Group, Truth, failure};
use bipedc_effects::effect::{Effect, Location};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Scores them all.
///
/// # Errors
/// Truths that cannot be read. A diagnosis that fails is a score.
pub fn examples(context: &Context, only: &str) -> Result<Vec<Scored>, Failure> {
    let folder = context.root.join("tests/data/examples");
    let entries = std::fs::read_dir(&folder).map_err(|e| failure(format!("{}: {e}", folder.display())))?;
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok().filter(|e| e.path().is_dir()))
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.contains(only))
        .collect();
    names.sort_unstable();
    names.iter().map(|name| example(context, &folder.join(name), name)).collect()
}

fn example(context: &Context, folder: &Path, name: &str) -> Result<Scored, Failure> {
    let (truth, drive_train) = read(&folder.join("truth.json"), name)?;
    let robot = context.root.join("robots").join(&truth.robot);
    let logs = ["train.csv.gz", "validation.csv.gz"].map(|file| folder.join(file));
    let mut score = match ask(context, &robot, [&logs[0], &logs[1]], &context.folder.join(name)) {
        Ok((answer, seconds)) => {
            let score = judge(&truth, &answer);
            let own = matches!(truth.metric.as_str(), "effort" | "transmission");
            let after = if own {
                explained(&robot, &logs[1], &answer, truth.metric == "transmission").ok()
            } else {
                answer.rms.get(&truth.metric).map(|fall| fall.after)
            };
            Scored { seconds, after, ..score }
        }
        Err(error) => {
            let mut score = judge(&truth, &Answer::default());
            (score.right, score.kinds, score.places) = (false, false, false);
            Scored { failed: Some(error.to_string()), ..score }
        }
    };
    if drive_train {
        // Its truth is a table of motor constants: not a question of which kind is missing.
        score.hidden = "motor-side friction and springs of five drives (not judged)".to_owned();
        score.not_judged = true;
    }
    score.group = None;
    Ok(score)
}

/// The truth in our words, and whether it is about a drive train.
pub fn read(path: &Path, name: &str) -> Result<(Truth, bool), Failure> {
    let error = |what: String| failure(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| error(e.to_string()))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| error(e.to_string()))?;
    let list = |key: &str| value[key].as_array().cloned().unwrap_or_default();
    let drive_train = list("effects").iter().any(|effect| effect["kind"] == "drive_train");
    let effects = |key: &str| list(key).iter().filter_map(translated).collect::<Vec<Effect>>();
    let (metric, nominal, oracle) = errors(&value, name);
    let robot = match value["robot"].as_str() {
        Some("tulip_v3") => "tulip",
        Some(robot) => robot,
        None => return Err(error("no `robot`".to_owned())),
    };
    let truth = Truth {
        name: name.to_owned(),
        group: if list("effects").is_empty() { Group::Clean } else { Group::Single },
        robot: robot.to_owned(),
        experiment: Experiment::Hanging,
        effects: effects("effects"),
        alternatives: Vec::new(),
        also_present: effects("also_present"),
        outsiders: Vec::new(),
        cad_errors: false,
        rate_hz: value["sampling_hz"].as_f64().unwrap_or(0.0),
        noise: BTreeMap::new(),
        size: BTreeMap::new(),
        scales: BTreeMap::new(),
        nominal,
        oracle,
        metric: metric.to_owned(),
    };
    Ok((truth, drive_train))
}

/// An effect in our words; `None` for drive trains.
fn translated(value: &Value) -> Option<Effect> {
    let kind = match value["kind"].as_str()? {
        "coulomb" => "coulomb_friction",
        "payload_mass" => "payload",
        "restitution" => "impact_restitution",
        "drive_train" => return None,
        same => same,
    };
    let parameters: Vec<(&str, f64)> = value["parameters"]
        .as_object()?
        .iter()
        .filter_map(|(name, value)| {
            let ours = match name.as_str() {
                "dx" => "x",
                "dy" => "y",
                "dz" => "z",
                same => same,
            };
            value.as_f64().map(|value| (ours, value))
        })
        .collect();
    let place = |key: &str| value[key].as_str().map(str::to_owned);
    let location = Location { joint: place("joint"), link: place("link"), ..Location::default() };
    Some(Effect::new(bipedc_effects::effect::kind(kind)?, location, &parameters))
}

/// Which error the truth states, of the URDF and of the true model.
fn errors(value: &Value, name: &str) -> (&'static str, f64, f64) {
    let pair = |key: &str| {
        let number = |who: &str| value[who][key].as_f64().unwrap_or(0.0);
        (number("nominal"), number("oracle"))
    };
    let joints = value["transmission"].as_object().and_then(|all| all.values().next());
    if let Some(joint) = joints {
        let number = |key: &str| joint[key].as_f64().unwrap_or(0.0);
        return ("transmission", number("nominal_rms"), number("oracle_rms"));
    }
    let (metric, key) = match name {
        "postures" => ("cop", "rms"),
        "swaying" => ("base_force", "force_rms_N"),
        "impacts" => ("post_impact_velocity", "rms"),
        _ => ("effort", "rms"),
    };
    let (nominal, oracle) = pair(key);
    (metric, nominal, oracle)
}
