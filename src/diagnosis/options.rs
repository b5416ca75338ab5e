//! What a diagnosis is asked, and what it answers.
use super::text;
use bipedc_analysis::diagnose::{self, Diagnosis};
use bipedc_analysis::measure;
use bipedc_analysis::report::Report;
use bipedc_analysis::robot::link_inertias::CadError;
use bipedc_effects::diagnostic::Diagnostic;
use serde::{Serialize, Serializer};
use std::fmt;
use std::ops::Deref;

/// How a diagnosis is made. By default: of the whole log, at the filter that fits best, all kinds of rows, masses and
/// inertias as far off as CAD data usually are.
#[derive(Debug, Clone)]
pub struct Options {
    /// Times between which samples of the first log count, and the filter.
    pub reading: measure::Options,
    /// Stance foot of postures, striking foot of impacts; by default the right one.
    pub foot: Option<String>,
    /// Logs with foot forces: also the joints' efforts, if they are logged.
    pub with_joints: bool,
    /// Kinds of rows that count, as in JSON: `effort`, `base_force`, …; none: all.
    pub channels: Vec<String>,
    /// What may happen to masses, centres of mass and inertias.
    pub inertial: Inertial,
    /// Most effects that are looked for; `None`: twelve, or two for every joint and two more, at most 24.
    pub most: Option<usize>,
    /// Go on although channels are mixed up.
    pub anyway: bool,
    /// Estimate the effects of the description again, beside what is found.
    pub refit: bool,
    /// Also fill a report.
    pub report: bool,
}

/// How far inertial parameters may move while effects are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Inertial {
    /// As far as CAD data usually are off: 2 % of mass, 2 % of a link's size, 4 % of inertia.
    #[default]
    Prior,
    /// Not at all.
    Known,
    /// As far as the data say.
    Free,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            reading: measure::Options::default(),
            foot: None,
            with_joints: true,
            channels: Vec::new(),
            inertial: Inertial::Prior,
            most: None,
            anyway: false,
            refit: false,
            report: false,
        }
    }
}

impl Options {
    /// In the words of the search.
    pub(super) fn search(&self) -> diagnose::Options {
        diagnose::Options {
            cad: if self.inertial == Inertial::Known { CadError::NONE } else { CadError::default() },
            widening: if self.inertial == Inertial::Free { 50.0 } else { 1.0 },
            most: self.most,
            standing: Vec::new(),
            barred: Vec::new(),
        }
    }
}

/// A diagnosis, and what goes with it. As text and as JSON it is what `bipedc diagnose` prints.
#[derive(Debug, Clone)]
pub struct Diagnosed {
    /// What is missing.
    pub diagnosis: Diagnosis,
    /// What is odd about the logs, with its place.
    pub warnings: Vec<Diagnostic>,
    /// The measurements that judged, with the diagnosis, if it was wanted.
    pub report: Option<Report>,
}

impl Deref for Diagnosed {
    type Target = Diagnosis;
    fn deref(&self) -> &Diagnosis {
        &self.diagnosis
    }
}

impl fmt::Display for Diagnosed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text(&self.diagnosis))
    }
}

impl Serialize for Diagnosed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.diagnosis.serialize(serializer)
    }
}
