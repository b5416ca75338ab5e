//! From an identification to a proposal: bodies as inertial corrections of their links, friction, offsets and rotors as effects
//! of their joints.
use super::{Proposal, Proposed, Request, is_same};
use crate::robot::link_inertias::about_center;
use bipedc_analysis::identify::{Law, offered};
use bipedc_analysis::measure::DataSource;
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Location, kinds};
use serde::Deserialize;
use std::collections::BTreeMap;

/// 97.5 % point of the normal distribution.
const NORMAL: f64 = 1.96;

/// Smaller changes (kg, m, kg m²) are rounding.
const NOTHING: f64 = 1e-9;
/// A coupling whose sign follows the sum of both speeds, and without a spring.
const NO_COUPLING: [(&str, f64); 5] =
    [("inertia", 0.0), ("damping", 0.0), ("coulomb", 0.0), ("stiffness", 0.0), ("differential", 1.0)];

/// What `bipedc identify --json` prints, as far as a description can state it.
#[derive(Debug, Clone, Deserialize)]
pub struct Identification {
    logs: Vec<LogName>,
    #[serde(default)]
    cutoff_hz: Option<f64>,
    physical: Physical,
    #[serde(default)]
    validation: Option<LogName>,
    /// Of series elastic drives.
    #[serde(default)]
    drives: Option<serde::de::IgnoredAny>,
    /// Of forces of the ground.
    #[serde(default)]
    ground: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Clone, Deserialize)]
struct LogName {
    file: String,
    #[serde(default)]
    samples: usize,
    #[serde(default)]
    hash: String,
}

#[derive(Debug, Clone, Deserialize)]
struct Physical {
    links: Vec<LinkValues>,
    extras: Vec<Extra>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
struct Value {
    value: f64,
    #[serde(default)]
    standard_error: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
struct LinkValues {
    name: String,
    mass: Value,
    center: [Value; 3],
    inertia: [Value; 6],
}

#[derive(Debug, Clone, Deserialize)]
struct Extra {
    name: String,
    #[serde(flatten)]
    value: Value,
}

type Intervals = BTreeMap<String, [f64; 2]>;

impl Identification {
    /// The log that judged, else the first that taught.
    pub fn judge(&self) -> Option<(&str, bool)> {
        let judge = self.validation.as_ref().map(|judge| (judge.file.as_str(), true));
        judge.or(self.logs.first().map(|log| (log.file.as_str(), false)))
    }

    /// The cut-off (Hz) that was asked for.
    pub fn cutoff_hz(&self) -> Option<f64> {
        self.cutoff_hz
    }

    /// Everything that was estimated. Numbers that stand in the description already are replaced: an identification looks at
    /// the rigid robot of the URDF and estimates all of them anew.
    ///
    /// # Errors
    /// Methods whose answer a description cannot state; links or joints that the robot does not have; effects of the
    /// description that the identification did not know of, and that would act beside what it found.
    pub fn propose(&self, robot: &RobotDescription, origin: &str) -> Result<Proposal, Diagnostic> {
        if self.drives.is_some() || self.ground.is_some() {
            let message = "only what joint torques tell can be written into a description";
            return Err(Diagnostic::error(message)
                .help("identify without --method, or use --write-urdf and the tables by hand"));
        }
        let mut effects: Vec<Proposed> = Vec::new();
        for link in &self.physical.links {
            effects.push(correction(link, robot)?);
        }
        for extra in &self.physical.extras {
            add(&mut effects, extra, robot)?;
        }
        unknown_beside(robot, &effects)?;
        // What is nothing and stands nowhere need not be written.
        let stands = |proposed: &Proposed| robot.effects.iter().any(|e| is_same(e, &proposed.effect));
        effects.retain(|proposed| stands(proposed) || proposed.effect.parameters.values().any(|x| *x != 0.0));
        let source = |log: &LogName| DataSource {
            file: log.file.clone(),
            samples: log.samples,
            hash: log.hash.clone(),
        };
        let mut logs = self.logs.iter().map(source);
        let (training, more_training) = (logs.next(), logs.collect());
        let validation = self.validation.as_ref().map(source);
        let origin = origin.to_owned();
        Ok(Proposal { effects, origin, training, more_training, validation, ..Proposal::default() })
    }

    /// Whether an effect that [`Self::propose`] gave may be nothing: it stands nowhere, and all that was estimated of it is zero
    /// within its interval.
    pub fn may_be_nothing(proposed: &Proposed, robot: &RobotDescription) -> bool {
        let stands = robot.effects.iter().any(|effect| is_same(effect, &proposed.effect));
        let zero = |[low, high]: &[f64; 2]| *low <= 0.0 && 0.0 <= *high;
        !stands && !proposed.ci95.is_empty() && proposed.ci95.values().all(zero)
    }
}

fn proposed(effect: Effect, ci95: Intervals) -> Proposed {
    Proposed { effect, ci95, error: None, request: Request::Put }
}

fn interval(value: f64, error: Option<f64>) -> [f64; 2] {
    let half = error.map_or(f64::INFINITY, |error| NORMAL * error);
    [value - half, value + half]
}

/// What a link is more than in the URDF.
fn correction(link: &LinkValues, robot: &RobotDescription) -> Result<Proposed, Diagnostic> {
    let described = robot.links.iter().find(|other| other.name == link.name);
    let Some(inertial) = described.and_then(|other| other.inertial.as_ref()) else {
        return Err(Diagnostic::error(format!("the robot has no link `{}` with mass", link.name))
            .help("the answer belongs to another robot"));
    };
    let about = about_center(inertial);
    let nominal = [
        inertial.mass,
        inertial.origin.xyz[0],
        inertial.origin.xyz[1],
        inertial.origin.xyz[2],
        about[0][0],
        about[0][1],
        about[0][2],
        about[1][1],
        about[1][2],
        about[2][2],
    ];
    let found = [link.mass].into_iter().chain(link.center).chain(link.inertia);
    let (mut values, mut ci95) = (Vec::new(), Intervals::new());
    for ((parameter, found), nominal) in kinds::INERTIAL_CORRECTION.parameters.iter().zip(found).zip(nominal)
    {
        let change = Some(found.value - nominal).filter(|x| x.abs() > NOTHING).unwrap_or(0.0);
        values.push((parameter.name, change));
        ci95.insert(parameter.name.to_owned(), interval(change, found.standard_error));
    }
    Ok(proposed(Effect::new(&kinds::INERTIAL_CORRECTION, Location::link(&link.name), &values), ci95))
}

/// Adds what a joint adds; the terms of a coupling share its effect.
fn add(effects: &mut Vec<Proposed>, extra: &Extra, robot: &RobotDescription) -> Result<(), Diagnostic> {
    let strange = || {
        Diagnostic::error(format!("`{}` means nothing to a description", extra.name))
            .help("the answer is of another version, or belongs to another robot")
    };
    let (place, unknown) = extra.name.rsplit_once('.').ok_or_else(strange)?;
    let is_joint = |name: &str| robot.joints.iter().any(|joint| joint.name == name);
    let range = interval(extra.value.value, extra.value.standard_error);
    if is_joint(place) {
        let kind = offered().find(|(_, identified)| identified.unknown == unknown).ok_or_else(strange)?.0;
        let name = kind.estimated().next().ok_or_else(strange)?.name;
        let effect = Effect::new(kind, Location::joint(place), &[(name, extra.value.value)]);
        effects.push(proposed(effect, Intervals::from([(name.to_owned(), range)])));
        return Ok(());
    }
    let pair = place.split_once('+').filter(|(one, other)| is_joint(one) && is_joint(other));
    let (one, other) = pair.ok_or_else(strange)?;
    let term = Law::coupling_parameter(unknown).ok_or_else(strange)?;
    for (joint, from) in [(one, other), (other, one)] {
        let location = Location { other_joint: Some(from.to_owned()), ..Location::joint(joint) };
        let mut effect = Effect::new(&kinds::COUPLING, location, &[]);
        let known = effects.iter().position(|known| is_same(&known.effect, &effect));
        let at = known.unwrap_or_else(|| {
            effect.parameters.extend(NO_COUPLING.map(|(name, value)| (name.to_owned(), value)));
            effects.push(proposed(effect, Intervals::new()));
            effects.len() - 1
        });
        effects[at].effect.parameters.insert(term.to_owned(), extra.value.value);
        effects[at].ci95.insert(term.to_owned(), range);
    }
    Ok(())
}

/// Refuses where the description has what the identification left out of its model.
fn unknown_beside(robot: &RobotDescription, proposed: &[Proposed]) -> Result<(), Diagnostic> {
    let known = |effect: &&Effect| proposed.iter().any(|other| is_same(&other.effect, effect));
    let others: Vec<String> = robot.effects.iter().filter(|e| !known(e)).map(Effect::to_string).collect();
    if others.is_empty() {
        return Ok(());
    }
    let message = format!(
        "the identification looked at the rigid robot; beside what it found the description's {} would act",
        others.join(", ")
    );
    Err(Diagnostic::error(message)
        .help("take it out first (bipedc amend ROBOT --effect KIND --joint JOINT --remove, or --undo), or write the URDF: bipedc identify --write-urdf"))
}
