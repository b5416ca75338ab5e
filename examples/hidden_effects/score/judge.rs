//! An answer against the truth.
use super::answer::Answer;
use super::parameters::{TOLERANCE, error};
use crate::generator::{Group, Truth};
use bipedc_effects::effect::{Effect, Kind};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// One parameter of a hidden effect that was found where it is, and its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Of the effect.
    pub kind: String,
    /// Name of it.
    pub parameter: String,
    /// How far the truth is from the interval's middle, in half widths: at most 1 is within.
    pub off: f64,
}

/// The score of one case.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Scored {
    /// Of the case.
    pub name: String,
    /// Why it is there; `None` for the examples.
    pub group: Option<Group>,
    /// Why there is no answer.
    pub failed: Option<String>,
    /// What was hidden, in words.
    pub hidden: String,
    /// What was found, in words.
    pub found: String,
    /// Every hidden kind was found.
    pub kinds: bool,
    /// Every hidden effect was found where it is.
    pub places: bool,
    /// Largest relative error of the parameters of what was found.
    pub parameter_error: Option<f64>,
    /// What its parameters' intervals are worth; those that the data determine.
    #[serde(default)]
    pub intervals: Vec<Interval>,
    /// The case is shown but does not count.
    pub not_judged: bool,
    /// All of it right: for outsiders, unexplained at the right joint; for clean logs, nothing found.
    pub right: bool,
    /// What was hidden is named as an alternative that the data cannot tell from what was found.
    pub named_as_alternative: bool,
    /// Found effects that are not there.
    pub spurious: usize,
    /// Inertial corrections.
    pub corrections: usize,
    /// Whether something is called unexplained, and where.
    pub unexplained: Option<Vec<String>>,
    /// Which error the following three are.
    pub metric: String,
    /// Of the URDF as it is.
    pub nominal: f64,
    /// Of the model with the true effects.
    pub oracle: f64,
    /// Of the model with what was found.
    pub after: Option<f64>,
    /// For the diagnosis.
    pub seconds: f64,
}

impl Scored {
    /// Error after by error of the true model.
    pub fn ratio(&self) -> Option<f64> {
        self.after.filter(|_| self.oracle > 0.0).map(|after| after / self.oracle)
    }
}

/// Effects in words.
pub fn words(effects: &[Effect]) -> String {
    let all = effects.iter().map(|effect| {
        let settings = ["smoothing"];
        let numbers = effect.parameters.iter().filter(|(name, _)| !settings.contains(&name.as_str()));
        let numbers: Vec<String> = numbers.map(|(name, value)| format!("{name} {}", short(*value))).collect();
        format!("{} at {}: {}", effect.kind, effect.location, numbers.join(", "))
    });
    all.collect::<Vec<_>>().join("; ")
}

/// Three digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = (2.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}

/// Which found effect is which expected one: kind and place agree.
fn matches(expected: &[Effect], found: &[Effect]) -> Vec<Option<usize>> {
    let mut taken = vec![false; found.len()];
    let find = |effect: &Effect| {
        let same = |f: &Effect| f.kind == effect.kind && f.location == effect.location;
        let index = (0..found.len()).find(|&i| !taken[i] && same(&found[i]));
        index.inspect(|&i| taken[i] = true)
    };
    expected.iter().map(find).collect()
}

/// Judges kinds, places, parameters, spurious effects. The errors are filled in by the caller.
pub fn judge(truth: &Truth, answer: &Answer) -> Scored {
    let explanations = std::iter::once(&truth.effects).chain(truth.alternatives.iter().map(|a| &a.effects));
    let scores = explanations.map(|expected| against(truth, expected, answer));
    let best =
        scores.reduce(|a, b| if (b.right, b.places, b.kinds) > (a.right, a.places, a.kinds) { b } else { a });
    let mut score = best.unwrap_or_default();
    score.name.clone_from(&truth.name);
    score.group = Some(truth.group);
    score.hidden = words(&[&truth.effects[..], &truth.outsiders].concat());
    score.found = words(&answer.effects);
    score.corrections = answer.inertial_corrections.len();
    score.unexplained = answer.unexplained.then(|| answer.suspects.clone());
    score.named_as_alternative = !truth.effects.is_empty() && !score.places && named(truth, answer);
    score.metric.clone_from(&truth.metric);
    (score.nominal, score.oracle) = (truth.nominal, truth.oracle);
    if truth.group == Group::Outside {
        let joints: Vec<_> =
            truth.outsiders.iter().filter_map(|outsider| outsider.location.joint.as_ref()).collect();
        score.kinds = answer.unexplained;
        score.places = joints.iter().all(|joint| answer.suspects.contains(joint));
        score.right = score.kinds && score.places;
    }
    score
}

fn against(truth: &Truth, expected: &[Effect], answer: &Answer) -> Scored {
    let found = &answer.effects;
    let pairs = matches(expected, found);
    let count = |list: &[Effect], kind: &Kind| list.iter().filter(|effect| effect.kind == kind).count();
    let kinds = expected.iter().all(|effect| count(found, effect.kind) >= count(expected, effect.kind));
    let places = pairs.iter().all(Option::is_some);
    let errors =
        expected.iter().zip(&pairs).filter_map(|(e, i)| i.map(|i| error(e, &found[i], &truth.scales)));
    let parameter_error = errors.fold(None, |worst: Option<f64>, e| Some(worst.map_or(e, |w| w.max(e))));
    let also = matches(&truth.also_present, found);
    let beside = truth.also_present.iter().zip(&also);
    let sure = expected.iter().zip(&pairs).chain(beside).filter_map(|(e, i)| Some((e, (*i)?)));
    let intervals = sure.flat_map(|(e, i)| intervals(e, answer, i)).collect();
    // What approaches an outsider with means of the library is no error, if it is where the outsider is.
    let there = |effect: &Effect| {
        truth.outsiders.iter().any(|outsider| outsider.location.joint == effect.location.joint)
    };
    let known = |i: usize| pairs.contains(&Some(i)) || also.contains(&Some(i)) || there(&found[i]);
    let spurious = (0..found.len()).filter(|&i| !known(i)).count();
    let near = parameter_error.is_none_or(|e| e <= TOLERANCE);
    let nothing = expected.is_empty() && spurious > 0;
    Scored {
        kinds,
        places,
        parameter_error,
        right: places && near && !nothing,
        spurious,
        intervals,
        ..Scored::default()
    }
}

/// Where the truth lies in the intervals of a found effect.
fn intervals(truth: &Effect, answer: &Answer, found: usize) -> Vec<Interval> {
    let Some(stated) = answer.intervals.get(found) else { return Vec::new() };
    let of = |(name, [low, high]): (&String, &[f64; 2])| {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut off = truth.value(name) - middle;
        if name == "phase" {
            off -= TAU * (off / TAU).round();
        }
        let interval =
            Interval { kind: truth.kind.name.to_owned(), parameter: name.clone(), off: off.abs() / half };
        (half.is_finite() && half > 0.0).then_some(interval)
    };
    stated.iter().filter_map(of).collect()
}

/// Whether the truth stands among the alternatives to what was found.
fn named(truth: &Truth, answer: &Answer) -> bool {
    truth.effects.iter().all(|effect| {
        let same = |f: &Effect| f.kind == effect.kind && f.location == effect.location;
        let alternatives = answer.indistinguishable.iter().flatten().flatten();
        answer.effects.iter().chain(alternatives).any(same)
    })
}
