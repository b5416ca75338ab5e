//! From logs to masses, centres of mass and inertias, with error bars.
mod base_parameters;
mod cop;
mod elastic;
mod ground;
mod logs;
mod options;
pub mod standing;
mod text;
mod torque;
mod zmp;

pub use base_parameters::{base_regressor, observed_base, standing_base};
pub use ground::{Center, Ground, InMetres, Mass, ModelErrors};
pub use options::{Estimator, Method, Options, Rotors};

use crate::measurements::Log;
use crate::progress::Progress;
use crate::report::of_identification;
use bipedc_analysis::identify::elastic::DriveSummary;
use bipedc_analysis::identify::physical::Inertia;
use bipedc_analysis::identify::{self, Identification, IdentificationResult};
use bipedc_analysis::measure;
use bipedc_analysis::report::{Report, Row};
use bipedc_compiler::Robot;
use bipedc_compiler::description::model::{Inertial, Pose};
use bipedc_compiler::description::with_inertials;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::effect::{Effect, Law, kinds};
use serde::Serialize;
use std::fmt;

/// What logs say of a robot's parameters. As text and as JSON it is what `bipedc identify` prints.
#[derive(Debug, Clone, Serialize)]
pub struct Identified {
    /// Parameters with their errors, and what they are worth.
    #[serde(flatten)]
    pub identification: Identification,
    /// Friction and springs of series elastic drives ([`Method::Elastic`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drives: Option<DriveSummary>,
    /// What the ground's forces tell of the whole robot ([`Method::Cop`], [`Method::Zmp`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<Ground>,
    /// Physically possible mass, centre of mass and inertia of each link, by name, in the link's frame.
    #[serde(skip)]
    pub links: Vec<(String, Inertia)>,
    /// What is odd about the logs, with its place.
    #[serde(skip)]
    pub warnings: Vec<Diagnostic>,
    /// Torques by description and estimate, and all parameters, to look at; if it was wanted.
    #[serde(skip)]
    pub report: Option<Report>,
}

impl fmt::Display for Identified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(drives) = &self.drives {
            writeln!(f, "{}", text::drives(drives))?;
        }
        f.write_str(&text::text(&self.identification))?;
        f.write_str(&self.ground.as_ref().map(Ground::text).unwrap_or_default())
    }
}

impl Identified {
    /// Without pictures and warnings.
    fn new(answer: IdentificationResult, ground: Option<Ground>) -> (Self, Vec<Row>) {
        let IdentificationResult { identification, links, pictures } = answer;
        let (warnings, drives, report) = (Vec::new(), None, None);
        (Self { identification, drives, ground, links, warnings, report }, pictures)
    }

    /// The robot's URDF with the physically possible parameters in the place of its own; all else stays.
    ///
    /// # Errors
    /// A URDF in which a link is not found.
    pub fn urdf(&self, robot: &Robot) -> Result<String, Diagnostic> {
        let inertial = |inertia: &Inertia| {
            let i = &inertia.inertia;
            Inertial {
                mass: inertia.mass,
                origin: Pose { xyz: inertia.center.into(), rpy: [0.0; 3] },
                inertia: [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]],
            }
        };
        let links: Vec<(String, Inertial)> =
            self.links.iter().map(|(name, inertia)| (name.clone(), inertial(inertia))).collect();
        with_inertials(&robot.sources.urdf_text, &robot.sources.urdf_path, &links)
    }
}

/// One run of an estimation: the robot, its logs, what is asked of them, what was odd so far.
struct Job<'a> {
    robot: &'a Robot,
    logs: &'a [&'a Log],
    judge: Option<&'a Log>,
    options: &'a Options,
    progress: &'a dyn Progress,
    warnings: Vec<Diagnostic>,
    /// Whether the cut-off of `options` is no more than the usual one.
    any_cutoff: bool,
}

/// Estimates a robot's parameters from logs; `judge` is a log of another motion, that only judges.
///
/// # Errors
/// Logs that cannot be read, do not fit together or cannot carry an estimate; channels that are mixed up; bounds that contradict
/// each other.
pub fn identify(
    robot: &Robot,
    logs: &[&Log],
    judge: Option<&Log>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Identified, Diagnostics> {
    options.check()?;
    if logs.is_empty() {
        return Err(Diagnostic::error("no log was given").help("give at least one that teaches").into());
    }
    for log in logs.iter().copied().chain(judge) {
        measure::has_filter(log, &options.reading)?;
    }
    let asked_hz = options.reading.cutoff_hz;
    let any_cutoff = asked_hz.is_none();
    let options = &options.clone().with_cutoff();
    let mut job = Job { robot, logs, judge, options, progress, warnings: Vec::new(), any_cutoff };
    let found = match options.method {
        Method::Torque => torque::run(&mut job),
        Method::Elastic => elastic::run(&mut job),
        Method::Cop => cop::run(&mut job),
        Method::Zmp => zmp::run(&mut job),
    };
    let mut warnings = job.warnings;
    let (mut found, rows) = match found {
        Ok(found) => found,
        Err(error) => {
            // What was odd may be why.
            warnings.extend(error.0);
            return Err(Diagnostics(warnings));
        }
    };
    note_sources(&mut found.identification, logs, judge)?;
    found.identification.cutoff_hz = asked_hz;
    if options.report {
        found.report = Some(of_identification(robot, &found.identification, found.drives.as_ref(), rows)?);
    }
    warnings.extend(left_out(robot, options));
    found.warnings = warnings;
    Ok(found)
}

/// What the description has beside the rigid robot and is not estimated anew: it is not looked at here, and bends what is.
fn left_out(robot: &Robot, options: &Options) -> Option<Diagnostic> {
    let anew = |effect: &&Effect| {
        options.friction.contains(&effect.kind)
            || (effect.kind == &kinds::ROTOR_INERTIA && options.rotors != Rotors::None)
            || (effect.kind == &kinds::COUPLING && !options.coupled.is_empty())
            || (effect.kind.law == Law::SeriesElasticity && options.method == Method::Elastic)
    };
    let others: Vec<String> =
        robot.description.effects.iter().filter(|e| !anew(e)).map(Effect::to_string).collect();
    if others.is_empty() {
        return None;
    }
    let message = format!(
        "the identification looks at the rigid robot: effects of the description are left out ({}), and what they do comes out as masses, friction or offsets",
        others.join(", ")
    );
    let help = "`bipedc diagnose --inertial free` estimates masses beside them; identify logs in which they do nothing, or put them right before";
    Some(Diagnostic::warning(message).help(help))
}

/// Which bytes were read.
fn note_sources(found: &mut Identification, logs: &[&Log], judge: Option<&Log>) -> Result<(), Diagnostic> {
    for (summary, log) in found.logs.iter_mut().zip(logs) {
        summary.hash = log.source()?.hash;
    }
    if let (Some(validation), Some(log)) = (&mut found.validation, judge) {
        validation.hash = log.source()?.hash;
    }
    Ok(())
}

impl<'a> Job<'a> {
    /// The logs that teach, and the one that judges, as the estimators read them.
    fn read(&self) -> (Vec<identify::Reading<'a>>, Vec<identify::Reading<'a>>) {
        self.read_as(&self.options.reading)
    }

    /// The same, read in another way.
    fn read_as(
        &self,
        reading: &measure::Options,
    ) -> (Vec<identify::Reading<'a>>, Vec<identify::Reading<'a>>) {
        let read =
            |log: &'a Log, options: &measure::Options| identify::Reading { log, options: options.clone() };
        // The judge is another recording: its clock has nothing to do with the times of the others.
        let whole = measure::Options { from_s: None, to_s: None, ..reading.clone() };
        let logs = self.logs.iter().map(|log| read(log, reading)).collect();
        (logs, self.judge.iter().map(|log| read(log, &whole)).collect())
    }

    /// Notes what is odd; gives up on errors unless told to go on.
    fn pass(&mut self, mut found: Vec<Diagnostic>) -> Result<(), Diagnostics> {
        if self.options.anyway {
            found.iter_mut().for_each(|diagnostic| diagnostic.severity = Severity::Warning);
        }
        if found.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
            return Err(Diagnostics(found));
        }
        self.warnings.extend(found);
        Ok(())
    }
}
