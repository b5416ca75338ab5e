//! An effect of a certain robot: a kind at a place with numbers.
use super::kind::{Kind, Law, Role};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Where an effect acts. Names are those of the description.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Location {
    /// The joint whose torque changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// The joint whose motion causes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_joint: Option<String>,
    /// The link whose inertia changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// `foot` or `foot/corner`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<String>,
}

impl Location {
    /// At a joint.
    pub fn joint(name: impl Into<String>) -> Self {
        Self { joint: Some(name.into()), ..Self::default() }
    }
    /// What the motion of `other` does to `joint`.
    pub fn pair(joint: impl Into<String>, other: impl Into<String>) -> Self {
        Self { joint: Some(joint.into()), other_joint: Some(other.into()), ..Self::default() }
    }
    /// On a link.
    pub fn link(name: impl Into<String>) -> Self {
        Self { link: Some(name.into()), ..Self::default() }
    }
    /// In a foot force sensor.
    pub fn sensor(name: impl Into<String>) -> Self {
        Self { sensor: Some(name.into()), ..Self::default() }
    }
}

impl fmt::Display for Location {
    /// Such as `left_knee_pitch` or `wrist_roll from wrist_pitch`; `the robot` if it has no place.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.joint, &self.other_joint, &self.link, &self.sensor) {
            (Some(joint), Some(other), ..) => write!(f, "{joint} from {other}"),
            (Some(place), ..) | (_, _, Some(place), _) | (_, _, _, Some(place)) => f.write_str(place),
            _ => f.write_str("the robot"),
        }
    }
}

/// What is known of a parameter that a formula's author named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OwnParameter {
    /// SI unit; `1` if it has none.
    pub unit: String,
    /// The smallest value that the estimator may find.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// The largest one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// An effect with numbers. As JSON: `{"kind": …, "joint": …, "parameters": {name: value}}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// What it is; by its name in files.
    pub kind: &'static Kind,
    /// The user's name for an effect of kind `formula`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Where.
    #[serde(flatten)]
    pub location: Location,
    /// By name, SI units.
    pub parameters: BTreeMap<String, f64>,
    /// The text of an effect of kind `formula`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<String>,
    /// Units and bounds of the parameters of an effect of kind `formula`, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub own: BTreeMap<String, OwnParameter>,
    /// Whether its joint slides: m and N instead of rad and N m. The robot says so; answers keep it for those who read them
    /// without the robot.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub sliding: bool,
}

impl Effect {
    /// An effect of the library.
    pub fn new(kind: &'static Kind, location: Location, parameters: &[(&str, f64)]) -> Self {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        Self { kind, name: None, location, parameters, torque: None, own: BTreeMap::new(), sliding: false }
    }

    /// A parameter: the stated value, else the default of a setting, else 0.
    pub fn value(&self, name: &str) -> f64 {
        self.parameters.get(name).copied().unwrap_or_else(|| {
            match self.kind.parameter(name).map(|p| p.role) {
                Some(Role::Setting(default)) => default * self.scale(name),
                _ => 0.0,
            }
        })
    }

    /// What is usual of a parameter at its joint for the value 1 at a turning one.
    fn scale(&self, name: &str) -> f64 {
        self.kind.parameter(name).filter(|_| self.sliding).map_or(1.0, |p| p.at_sliding().1)
    }

    /// Usual values of a parameter of the library; anything for a formula's own.
    pub fn plausible(&self, name: &str) -> (f64, f64) {
        let range = self.kind.parameter(name).map(|p| p.plausible);
        let (low, high) = range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let scale = self.scale(name);
        (scale * low, scale * high)
    }

    /// A parameter that the kind or the author of the formula knows, as [`Effect::value`]; `None` for other names.
    pub fn known(&self, name: &str) -> Option<f64> {
        let known = self.parameters.contains_key(name) || self.kind.parameter(name).is_some();
        known.then(|| self.value(name))
    }

    /// Unit of a parameter: of the library, or as the author of the formula says; `1` if nobody says.
    pub fn unit(&self, name: &str) -> &str {
        let own = || self.own.get(name).map(|own| own.unit.as_str());
        let library = self.kind.parameter(name).map(|_| self.kind.unit(name, self.sliding));
        library.or_else(own).unwrap_or("1")
    }

    /// Possible values of a parameter; infinite where nobody bounds it.
    pub fn bounds(&self, name: &str) -> (f64, f64) {
        if let Some(parameter) = self.kind.parameter(name) {
            return parameter.bounds;
        }
        let own = self.own.get(name);
        (
            own.and_then(|own| own.min).unwrap_or(f64::NEG_INFINITY),
            own.and_then(|own| own.max).unwrap_or(f64::INFINITY),
        )
    }

    /// The text of its law: that of the library for [`Law::Torque`], [`Law::Reading`] and [`Law::TrueTorque`],
    /// the author's for a formula, none for effects that no formula describes.
    pub fn law_text(&self) -> Option<&str> {
        match self.kind.law {
            Law::Formula => self.torque.as_deref(),
            _ => self.kind.formula(),
        }
    }
}

impl fmt::Display for Effect {
    /// Such as `Coulomb friction at left_knee_pitch`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let title = self.name.as_deref().unwrap_or(self.kind.title);
        write!(f, "{title} at {}", self.location)
    }
}
