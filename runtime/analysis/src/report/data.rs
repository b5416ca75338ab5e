//! What a report shows. All quantities in SI units, world axes x forward, y left, z up.
use crate::diagnose::{Diagnosis, ErrorFall};
use crate::experiments::plotted::Row;

/// Everything on the page; what is empty is left out of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Such as `tulip: comparison with validation.csv.gz`.
    pub title: String,
    /// Name of the robot.
    pub robot: String,
    /// Name of the log that the rows are of; may be empty.
    pub log: String,
    /// The answer in plain words; empty lines separate paragraphs. If empty, [`Diagnosis::summary`] stands in.
    pub summary: String,
    /// Commands that go on from here.
    pub next: Vec<NextStep>,
    /// The robot's shape.
    pub drawing: Option<Drawing>,
    /// What the samples run over: time, or numbers of postures or impacts.
    pub abscissa: Abscissa,
    /// One per measured scalar, those of one unit together: the page numbers and shows them in this order.
    pub rows: Vec<Row>,
    /// Ranked causes.
    pub diagnosis: Option<Diagnosis>,
    /// Estimated numbers with their errors.
    pub estimates: Vec<Estimated>,
    /// Every change of the model so far, the oldest first. If empty, [`Diagnosis::steps`] make the staircase.
    pub history: Vec<HistoryStep>,
    /// Everything that was done to the description, the oldest first.
    pub changes: Vec<ChangeLine>,
    /// What the data could not support, besides [`Diagnosis::warnings`].
    pub warnings: Vec<String>,
    /// What was taken for granted, besides [`Diagnosis::assumptions`].
    pub assumptions: Vec<String>,
    /// Preprocessing and provenance: cut-off, samples, hashes of the logs.
    pub facts: Vec<Fact>,
}

/// A command that goes on from a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NextStep {
    /// What it is for.
    pub why: String,
    /// As it is typed.
    pub command: String,
}

/// A number that was estimated.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// Such as `left_knee.coulomb_friction`.
    pub name: String,
    /// Of all its numbers.
    pub unit: String,
    /// Estimate.
    pub value: f64,
    /// One standard deviation.
    pub standard_error: f64,
    /// 95 %.
    pub interval: [f64; 2],
    /// Of the description.
    pub described: f64,
}

/// What samples run over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Abscissa {
    /// `time`, `posture`, `impact`.
    pub name: String,
    /// `s`; empty for numbers.
    pub unit: String,
}

impl Default for Abscissa {
    fn default() -> Self {
        Self { name: "time".to_owned(), unit: "s".to_owned() }
    }
}

/// A name and what it is: `cut-off`, `16 Hz`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// A noun.
    pub name: String,
    /// With its unit.
    pub value: String,
}

impl Fact {
    /// A fact.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

/// The robot's shape in one posture, world axes, m. `bipedc::report::drawing` makes it from a tree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawing {
    /// In the order of the model.
    pub joints: Vec<DrawnJoint>,
    /// Links as straight lines between joints.
    pub bones: Vec<Bone>,
    /// Solid parts, such as soles, by their corners.
    pub hulls: Vec<Hull>,
}

/// A joint of the drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnJoint {
    /// As in the description.
    pub name: String,
    /// Of its frame, m.
    pub position: [f64; 3],
    /// Unit vector.
    pub axis: [f64; 3],
    /// Slides instead of turning.
    pub prismatic: bool,
    /// Index of the joint whose link carries it; `None`: the base does.
    pub parent: Option<usize>,
}

/// A link as a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bone {
    /// One end, m.
    pub from: [f64; 3],
    /// The other.
    pub to: [f64; 3],
    /// Of the link, kg: heavier links are drawn wider.
    pub mass: f64,
}

/// A solid part, drawn as the convex outline of its corners.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Such as `left_foot`.
    pub name: String,
    /// Corners, m.
    pub points: Vec<[f64; 3]>,
}

/// What became of an effect of the description, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChangeLine {
    /// Number of the step.
    pub step: usize,
    /// As noted, ISO 8601.
    pub date: String,
    /// Such as `added`.
    pub action: String,
    /// Such as `Coulomb friction at left_knee_pitch`.
    pub effect: String,
    /// Name and value with its unit and 95 % interval, each.
    pub parameters: Vec<String>,
}

/// A change of the model and what it did to the error.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryStep {
    /// Such as `Coulomb friction at left_knee_pitch`.
    pub label: String,
    /// As noted, ISO 8601; may be empty.
    pub date: String,
    /// On the data that it was estimated from.
    pub training: Option<ErrorFall>,
    /// On held-out data.
    pub held_out: Option<ErrorFall>,
}
