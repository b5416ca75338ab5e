//! The answer, for people and for programs. Its JSON keys are its field names and stay.
use super::error_fall::{ErrorFall, LEFT, PLAINLY, StepErrors, telling};
use crate::experiments::data_checks::SHORT;
use crate::experiments::{Channel, Experiment};
use crate::measure::DataSource;
use bipedc_effects::effect::{Effect, Kind, Location};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

/// What was found. All errors are on held-out data.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Diagnosis {
    /// Effects that earned their place, most important first.
    pub effects: Vec<FoundEffect>,
    /// Effects that stood from the start ([`Options::standing`](super::Options::standing)), with their new estimates.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub standing: Vec<FoundEffect>,
    /// The same with the values that they stood with, which is how errors are before.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub described: Vec<Effect>,
    /// Masses, centres of mass and inertias that were estimated beside the effects, one `inertial_correction` per link;
    /// all errors hold with them.
    pub inertial_corrections: Vec<FoundEffect>,
    /// Alternatives that this data cannot tell apart; each alternative is a list of effects, the first the one that
    /// stands in `effects`.
    pub indistinguishable: Vec<Vec<Vec<FoundEffect>>>,
    /// Links that stand in `indistinguishable` and are bolted to each other, by body: no experiment tells what they carry apart.
    #[serde(skip)]
    pub bolted: Vec<Vec<String>>,
    /// Whether something structured is left that no kind of the library explains.
    pub unexplained: bool,
    /// Joints (or rows) in which it is left.
    pub suspects: Vec<String>,
    /// How much is left in each suspect, and what it goes with.
    pub unexplained_parts: Vec<Unexplained>,
    /// Joints (or rows) in which each of `effects` and then of `inertial_corrections` makes more than noise; not written.
    #[serde(skip)]
    pub acts_on: Vec<Vec<String>>,
    /// Rows whose torque is reported later than the motion, s; not written by itself.
    #[serde(skip)]
    pub late: BTreeMap<String, f64>,
    /// Of which joints efforts were looked at, and for how long; not written by itself.
    #[serde(skip)]
    pub scope: Scope,
    /// What was tried and did not earn its place.
    pub rejected: Vec<Rejected>,
    /// Root mean square errors by kind of channel: `effort`, `base_force`, `base_moment`, `cop`, `transmission`,
    /// `post_impact_velocity`.
    pub rms: BTreeMap<String, ErrorFall>,
    /// As `rms`, on the training data; empty where nobody asked.
    pub rms_training: BTreeMap<String, ErrorFall>,
    /// As `rows`, on all of the training data; not written by itself.
    #[serde(skip)]
    pub rows_training: BTreeMap<String, ErrorFall>,
    /// Of the kind that the table is about: impacts, else centre of pressure for postures, else effort.
    pub rms_before: f64,
    /// See `rms_before`.
    pub rms_after: f64,
    /// By row, in the order of the model.
    pub rows: BTreeMap<String, ErrorFall>,
    /// The error after each effect, in the order in which they entered.
    pub steps: Vec<Step>,
    /// The errors of all channels as these effects entered, one for each of `steps`; none beside inertial corrections.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub step_errors: Vec<StepErrors>,
    /// The data that parameters were estimated from.
    pub training: DataSource,
    /// The data that judged; `None`: blocks of the training data did.
    pub validation: Option<DataSource>,
    /// What the data could not support, in words.
    pub warnings: Vec<String>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// Cut-off of the filter, Hz; 0 for tables.
    pub cutoff_hz: f64,
    /// Cut-off at which `rms`, `rms_before` and `rms_after` hold, Hz, where it is another: the best with the effects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub judged_at_hz: Option<f64>,
    /// The answer in plain words.
    pub summary: String,
}

/// How much of a robot an answer is of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scope {
    /// So little motion was looked at, s; `None` where it is no little, and of tables.
    pub short_s: Option<f64>,
    /// Joints of the robot, if efforts are compared.
    pub joints: usize,
    /// Those of them whose efforts were not compared.
    pub unseen: Vec<String>,
}

impl Scope {
    /// Of a log that teaches and one that judges.
    pub fn of(train: &dyn Experiment, judge: &dyn Experiment) -> Self {
        let shorter = [train, judge].into_iter().filter_map(Experiment::duration).min_by(f64::total_cmp);
        let efforts = || train.rows().iter().filter(|row| row.channel == Channel::Effort);
        // Without efforts the answer is of the base: no joint is missed.
        let joints = if efforts().next().is_some() { train.joints() } else { Vec::new() };
        let unseen = joints.iter().filter(|joint| !efforts().any(|row| row.name == **joint));
        Self {
            short_s: shorter.filter(|seconds| *seconds < SHORT),
            joints: joints.len(),
            unseen: unseen.map(|joint| (*joint).to_owned()).collect(),
        }
    }
}

impl Diagnosis {
    /// How the warning begins that there may be more effects.
    pub(super) const AS_MANY: &str = "as many effects were found as are looked for";

    /// Whether as many effects were found as are looked for.
    pub fn is_full(&self) -> bool {
        self.warnings.iter().any(|warning| warning.starts_with(Self::AS_MANY))
    }

    /// The kind of channel in which the error fell: the one that `rms_before` is about, unless it stays there and falls
    /// elsewhere.
    pub fn telling_channel(&self) -> Option<&str> {
        let (main, _) = self.rms.iter().find(|(_, fall)| fall.before == self.rms_before)?;
        let falls = self.rms.iter().map(|(name, fall)| (name.as_str(), fall.before, fall.after));
        Some(telling(falls, main))
    }

    /// Whether something is left of which more was seen than that it is above the noise.
    pub fn leaves_structure(&self) -> bool {
        self.unexplained && (self.structured().next().is_some() || self.unexplained_parts.is_empty())
    }

    /// The row, or the kind of channel, of which the log that teaches has more left above its noise than the log of another motion that
    /// judges, the former's error, and how many times its noise that is: the judge hardly tells what acts there. `None` without such a log.
    pub fn unseen_by_judge(&self) -> Option<(&str, &ErrorFall, f64)> {
        self.validation.as_ref()?;
        let most = |[teaches, judges]: [&'_ BTreeMap<String, ErrorFall>; 2], least: f64| {
            let more = |(name, fall): (&'_ String, &'_ ErrorFall)| {
                let judged = judges.get(name).and_then(ErrorFall::noises)?;
                fall.above_noise().filter(|own| *own > least && *own > least * judged)
            };
            let all = teaches.iter().filter_map(|pair| Some((pair.0, more(pair)?)));
            all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, times)| (name.clone(), times))
        };
        let row = most([&self.rows_training, &self.rows], PLAINLY);
        let (name, times) = row.or_else(|| most([&self.rms_training, &self.rms], LEFT))?;
        let (name, fall) =
            self.rows_training.get_key_value(&name).or_else(|| self.rms_training.get_key_value(&name))?;
        Some((name, fall, times))
    }

    /// Rows of which more than the noise is left only around the samples at which something jumps, which a filter smears.
    pub fn left_at_jumps(&self) -> impl Iterator<Item = (&String, &ErrorFall)> {
        self.rows.iter().filter(|(_, fall)| {
            let around = fall.after_moving.unwrap_or(fall.after);
            let is_known = fall.noise > 0.0 && fall.above_noise().is_none();
            let is_motion = fall.behind_both.is_some() || fall.gone_at_hz.is_some();
            is_known
                && !is_motion
                && fall.away_from_jumps.is_some()
                && around > LEFT * fall.noise.max(fall.resolution)
        })
    }

    /// What is left of which more was seen than that it is above the noise.
    pub fn structured(&self) -> impl Iterator<Item = &Unexplained> {
        self.unexplained_parts.iter().filter(|part| part.seen != Seen::Excess)
    }

    /// Says of every row whose error is above the noise that it is unexplained, by the errors as they stand now.
    pub fn conclude(&mut self) {
        if self.unexplained && self.unexplained_parts.is_empty() {
            // Nothing could be estimated.
            return;
        }
        self.unexplained_parts.retain(|part| part.seen != Seen::Excess);
        let known: Vec<String> = self.unexplained_parts.iter().map(|part| part.joint.clone()).collect();
        let excess = self.rows.iter().filter(|(row, _)| !known.contains(row)).filter_map(|(row, fall)| {
            let share = 1.0 - fall.above_noise()?.powi(-2);
            let (joint, signals) = (row.clone(), Vec::new());
            Some(Unexplained { joint, share, signals, seen: Seen::Excess, late_s: None })
        });
        let mut excess: Vec<Unexplained> = excess.collect();
        excess.sort_by(|a, b| b.share.total_cmp(&a.share));
        self.unexplained_parts.extend(excess);
        self.unexplained = !self.unexplained_parts.is_empty();
        self.suspects = self.unexplained_parts.iter().map(|part| part.joint.clone()).collect();
        for part in &mut self.unexplained_parts {
            part.late_s = self.late.get(&part.joint).copied();
        }
        self.doubt();
    }

    /// Doubts every effect and every correction that acts where something is left.
    fn doubt(&mut self) {
        const PART: &str = "this one may stand for a part of it";
        let structured: Vec<String> = self.structured().map(|part| part.joint.clone()).collect();
        let all = self.effects.iter_mut().chain(&mut self.inertial_corrections);
        for (found, rows) in all.zip(&self.acts_on) {
            found.doubts.retain(|doubt| !doubt.ends_with(PART));
            let here = self.suspects.iter().filter(|joint| rows.contains(joint));
            let (seen, merely): (Vec<&str>, Vec<&str>) =
                here.map(String::as_str).partition(|joint| structured.iter().any(|known| known == joint));
            if !seen.is_empty() {
                let at = seen.join(", ");
                found.doubts.push(format!("something is left at {at} that no effect explains: {PART}"));
            } else if !merely.is_empty() {
                let at = merely.join(", ");
                found.doubts.push(format!(
                    "what is left at {at} is above the noise as neighbouring readings tell it: if it is not noise of a slow filter, {PART}"
                ));
            }
        }
    }

    /// All that was estimated, in the order in which it acts: effects of the description, those that were found as they
    /// entered, and inertial corrections.
    pub fn estimated(&self) -> impl Iterator<Item = &Effect> {
        let standing = self.standing.iter().map(|found| &found.effect);
        let corrections = self.inertial_corrections.iter().map(|found| &found.effect);
        standing.chain(self.steps.iter().map(|step| &step.effect)).chain(corrections)
    }
}

/// An effect with its error bars.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundEffect {
    /// Kind, place and parameters.
    #[serde(flatten)]
    pub effect: Effect,
    /// 95 % confidence intervals by parameter.
    #[serde(default, deserialize_with = "intervals")]
    pub ci95: BTreeMap<String, [f64; 2]>,
    /// Fraction of the held-out squared error that it removed when it entered: beside what inertial corrections remove, or, where these would
    /// mimic it, with nothing corrected.
    #[serde(default)]
    pub share: f64,
    /// Reasons to doubt it: values outside the plausible range.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
}

/// A candidate that did not earn its place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rejected {
    /// Of the effect.
    pub kind: &'static Kind,
    /// Where it was tried.
    pub place: Location,
    /// Why it does not stand.
    pub why: String,
}

/// What remains in a row although nothing of the library explains it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Joint or row.
    pub joint: String,
    /// Fraction of the remaining squared error that is no noise, as `seen` says.
    pub share: f64,
    /// Signals that it goes with, the strongest first.
    pub signals: Vec<String>,
    /// In what it was seen.
    #[serde(default)]
    pub seen: Seen,
    /// Where most of it is that the torque is reported later than the motion: by how much, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
}

/// In what it is seen that something remains.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Seen {
    /// A smooth function of the signals would still remove it.
    #[default]
    Motion,
    /// It varies slowly, whatever it goes with.
    Slowness,
    /// It is larger than the noise; the rows are too few to see what it goes with.
    Size,
    /// It is larger than the noise; what it goes with was not found.
    Excess,
}

impl Seen {
    /// In few words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Motion => "the motion",
            Self::Slowness => "slow changes",
            Self::Size => "its size",
            Self::Excess => "its size, above the noise; what it goes with was not found",
        }
    }
}

/// One effect entering.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// What entered.
    pub effect: Effect,
    /// Held-out error before it entered, unit of [`Diagnosis::rms_before`].
    pub before: f64,
    /// And after.
    pub after: f64,
}

/// Intervals by name whose ends may be `null`: what the data do not determine. JSON has no infinity.
///
/// # Errors
/// As the deserialiser's.
pub fn intervals<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<String, [f64; 2]>, D::Error> {
    let read = BTreeMap::<String, [Option<f64>; 2]>::deserialize(from)?;
    let ends =
        |[low, high]: [Option<f64>; 2]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)];
    Ok(read.into_iter().map(|(name, interval)| (name, ends(interval))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_determined_is_written_and_read() {
        let effect = Effect::new(&bipedc_effects::effect::kinds::PAYLOAD, Location::link("shin"), &[]);
        let mut found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.5, doubts: Vec::new() };
        found.ci95.insert("mass".to_owned(), [0.25, 0.75]);
        found.ci95.insert("y".to_owned(), [f64::NEG_INFINITY, f64::INFINITY]);
        let text = serde_json::to_string(&found).unwrap();
        assert!(text.contains(r#""mass":[0.25,0.75],"y":[null,null]"#), "{text}");
        assert_eq!(serde_json::from_str::<FoundEffect>(&text).unwrap(), found);
    }

    #[test]
    fn rows_that_are_missed_around_reversals_alone_are_named() {
        let fall = |away: f64, noise: f64| ErrorFall {
            after: 0.25,
            away_from_jumps: Some(away),
            noise,
            ..ErrorFall::default()
        };
        let rows = [("knee", fall(0.12, 0.1)), ("hip", fall(0.2, 0.1)), ("ankle", fall(0.12, 0.2))];
        let rows = rows.map(|(name, fall)| (name.to_owned(), fall)).into();
        let diagnosis = Diagnosis { rows, ..Diagnosis::default() };
        let named: Vec<&str> = diagnosis.left_at_jumps().map(|(row, _)| row.as_str()).collect();
        assert_eq!(named, ["knee"]);
    }

    /// Where a row is merely above its noise nobody knows that anything is left.
    #[test]
    fn a_row_above_its_noise_is_doubted_in_other_words_than_one_with_structure() {
        let effect = Effect::new(&bipedc_effects::effect::kinds::TORQUE_BIAS, Location::joint("knee"), &[]);
        let found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.5, doubts: Vec::new() };
        let fall = ErrorFall { before: 2.0, after: 0.2, noise: 0.1, ..ErrorFall::default() };
        let corrected = |link: &str| {
            let kind = &bipedc_effects::effect::kinds::INERTIAL_CORRECTION;
            FoundEffect { effect: Effect::new(kind, Location::link(link), &[]), ..found.clone() }
        };
        let mut diagnosis = Diagnosis {
            rows: BTreeMap::from([("knee".to_owned(), fall)]),
            inertial_corrections: vec![corrected("shank"), corrected("hand")],
            acts_on: ["knee", "knee", "elbow"].map(|joint| vec![joint.to_owned()]).into(),
            effects: vec![found],
            ..Diagnosis::default()
        };
        diagnosis.conclude();
        assert!(!diagnosis.leaves_structure());
        let [doubt] = &diagnosis.effects[0].doubts[..] else { panic!("{:?}", diagnosis.effects[0].doubts) };
        assert!(doubt.contains("noise of a slow filter") && !doubt.contains("no effect explains"), "{doubt}");
        let (joint, signals) = ("knee".to_owned(), Vec::new());
        let seen = Unexplained { joint, share: 0.9, signals, seen: Seen::Motion, late_s: None };
        diagnosis.unexplained_parts = vec![seen];
        diagnosis.conclude();
        let [doubt] = &diagnosis.effects[0].doubts[..] else { panic!("{:?}", diagnosis.effects[0].doubts) };
        assert!(doubt.contains("no effect explains"), "{doubt}");
        // Corrections of masses that act there are as doubtful.
        let [shank, hand] = &diagnosis.inertial_corrections[..] else { panic!() };
        assert_eq!((shank.doubts.last(), hand.doubts.len()), (Some(doubt), 0));
    }
}
