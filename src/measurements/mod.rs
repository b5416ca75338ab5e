//! Measurement files as experiments: what comparisons, diagnoses and estimates work on.
pub mod currents;
mod recordings;

pub use bipedc_analysis::log::Log;
pub use bipedc_analysis::measure::Content;

use self::recordings::Recordings;
use crate::robot::{ProgramTorques, feet, joint_layout_with_stops, link_inertias};
use bipedc_analysis::compare::compare_file;
use bipedc_analysis::experiments::contact_log::{ContactExperiment, ContactRecording, WalkingExperiment};
use bipedc_analysis::experiments::impacts::ImpactExperiment;
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::measure::{DataSource, FIRST, Held, Options, Recording};
use bipedc_analysis::robot::inertial_parameters;
use bipedc_analysis::robot::link_inertias::LinkInertias;
use bipedc_analysis::robot::{Foot, JointLayout, Robot};
use bipedc_compiler::Robot as Described;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::Base;
use bipedc_compiler::tree::BaseKind;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use bipedc_runtime::{Argument, Model, State};

/// Most samples of a log that a diagnosis works on; longer logs are thinned after filtering.
pub(crate) const SAMPLES: usize = 10_000;
/// Cut-off of logs with foot forces unless one is given or a higher one fits better, Hz.
const CONTACT_CUTOFF_HZ: f64 = 5.0;
/// The highest that is chosen, Hz.
const HIGHEST_CONTACT_CUTOFF_HZ: f64 = 40.0;
/// Largest part of a joint's motion that a filter may take away, unless it is as fast as this: friction follows the direction of what is
/// left. Beyond, the noise of accelerations drowns more than that.
const CUT_OFF: f64 = 0.03;
const FAST_ENOUGH_HZ: f64 = 20.0;

/// A robot ready to be held against measurements: the rigid model on a base that can be turned.
pub struct Measured {
    /// Joints and base.
    pub layout: JointLayout,
    link_inertias: LinkInertias,
    feet: Vec<Foot>,
    model: ProgramModel,
    /// Effects that the description has already.
    pub present: Vec<Effect>,
    torques: ProgramTorques,
    /// Whether the description says that something holds its base.
    is_held: bool,
    /// Whether logs with foot forces show the joints' efforts too, beside the rows of the base.
    pub with_joints: bool,
    /// Logs that were read.
    recordings: Recordings,
}

/// A file as an experiment.
pub struct Loaded<'a> {
    /// Its rows, measured minus modelled.
    pub experiment: Box<dyn Experiment + 'a>,
    /// Which file, and how many of its samples count.
    pub source: DataSource,
    /// What is odd about it.
    pub warnings: Vec<Diagnostic>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// Hz; 0 for tables.
    pub cutoff_hz: f64,
    /// What it holds.
    pub content: Content,
}

/// Rows of a file, what is odd about it, what was taken for granted.
type Read<'a> = (Box<dyn Experiment + 'a>, Vec<Diagnostic>, Vec<String>);

impl Measured {
    /// Compiles what is needed. A fixed base becomes a floating one at rest, so that it can be tilted.
    ///
    /// # Errors
    /// A base that no log tells; functions that cannot be derived.
    pub fn new(robot: &Described) -> Result<Self, Diagnostics> {
        let present = robot.description.effects.clone();
        let mut rigid = robot.clone().without_effects();
        let is_held = rigid.tree()?.base == BaseKind::Fixed;
        if is_held {
            rigid = rigid.with_base("floating", None)?;
        }
        let tree = rigid.tree()?;
        let layout = joint_layout_with_stops(&tree, &rigid.description)?;
        let link_inertias = link_inertias(&rigid.description, &tree);
        let compiled = rigid.compile_only(&requests(&rigid))?;
        let torques = ProgramTorques::new(&compiled)?;
        let feet = feet(&rigid.description);
        Ok(Self {
            layout,
            link_inertias,
            feet,
            model: ProgramModel::new(compiled),
            present,
            torques,
            is_held,
            with_joints: false,
            recordings: Recordings::default(),
        })
    }

    /// What experiments know of the robot.
    pub fn robot(&self) -> Robot<'_> {
        Robot {
            model: &self.model,
            layout: &self.layout,
            link_inertias: &self.link_inertias,
            feet: &self.feet,
            effects: &self.present,
        }
    }

    /// What a file holds for this robot.
    pub fn content(&self, log: &Log) -> Content {
        log.content(&self.layout)
    }

    /// A log with forces at the feet as an experiment, whatever else it holds.
    ///
    /// # Errors
    /// Unreadable files, columns that are missing.
    pub fn contacts(&self, log: &Log, options: &Options) -> Result<Loaded<'_>, Diagnostics> {
        let experiment = ContactExperiment::read(self.robot(), log, options)?;
        let mut source = log.source()?;
        source.samples = experiment.time().len();
        let recording = experiment.recording();
        let (warnings, assumptions) = (recording.warnings.clone(), recording.assumptions.clone());
        let cutoff_hz = recording.cutoff_hz;
        let content = Content::Contacts;
        Ok(Loaded { experiment: Box::new(experiment), source, warnings, assumptions, cutoff_hz, content })
    }

    /// Centre of mass in the root's frame for inertial parameters (ten per body), m.
    pub fn center(&self, joints: &[f64], parameters: &[f64]) -> [f64; 3] {
        let model: &dyn Model<f64> = &self.model;
        let q = [self.layout.base.rest(), joints].concat();
        let mut columns = vec![0.0; 3 * parameters.len()];
        let function = model.function("center_of_mass_regressor");
        let state = State::new().with(Argument::Q, &q);
        if function.is_none_or(|f| model.evaluate(f, &state, &mut columns).is_err()) {
            return [f64::NAN; 3];
        }
        let mass = inertial_parameters::mass(parameters);
        std::array::from_fn(|axis| {
            columns.chunks_exact(3).zip(parameters).map(|(column, p)| column[axis] * p).sum::<f64>() / mass
        })
    }

    /// The link that carries the base.
    pub fn root_link(&self, robot: &Described) -> String {
        let root = match &robot.description.base {
            Base::Floating { root } | Base::Planar { root } => root,
            Base::Fixed { link } => link,
            Base::Pivot { about } => about,
        };
        match self.link_inertias.link(root) {
            Some(link) => link.name.clone(),
            None => robot.description.root_link.clone(),
        }
    }

    /// A log of efforts as an experiment, thinned to so many samples at most.
    ///
    /// # Errors
    /// Unreadable files, no joint with an effort.
    pub fn efforts(
        &self,
        log: &Log,
        options: &Options,
        most: usize,
    ) -> Result<MotionExperiment<'_>, Diagnostics> {
        let recording = if most == usize::MAX {
            Recording::read(log, &self.layout, options)?
        } else {
            match self.recordings.get(log, options) {
                Some(held) => held.thinned(most),
                None => {
                    let held = Held::read(log, &self.layout, options)?;
                    self.recordings.thinned(log, options, held, most)
                }
            }
        };
        self.motion(log, recording)
    }

    /// The same without anything of noise: what is left of efforts alone is of use.
    ///
    /// # Errors
    /// As [`Self::efforts`].
    pub(crate) fn efforts_alone(
        &self,
        log: &Log,
        options: &Options,
        most: usize,
    ) -> Result<MotionExperiment<'_>, Diagnostics> {
        let recording = match self.recordings.get(log, options) {
            Some(held) => held.thinned(most),
            None => Held::read_motion(log, &self.layout, options)?.into_thinned(most),
        };
        self.motion(log, recording)
    }

    fn motion(&self, log: &Log, mut recording: Recording) -> Result<MotionExperiment<'_>, Diagnostics> {
        recording.is_held = self.is_held;
        MotionExperiment::new(&self.model, &self.layout, &self.link_inertias, recording, &self.present)
            .map_err(|e| e.in_file(log.path()).into())
    }

    /// The cut-off for a first look at a file, Hz: the given one, else the one at which most channels fit best; 0 for tables.
    ///
    /// # Errors
    /// Unreadable files, nothing to compare.
    pub fn cutoff(&mut self, log: &Log, options: &Options) -> Result<f64, Diagnostics> {
        match (options.cutoff_hz, self.content(log)) {
            (Some(cutoff), _) => Ok(cutoff),
            (None, Content::Contacts) => self.contact_cutoff(&self.present, log, options, self.with_joints),
            (None, Content::Postures | Content::Impacts) => Ok(0.0),
            (None, Content::Efforts) => {
                let (torques, layout) = (&mut self.torques, &self.layout);
                let first = Options { candidates: FIRST.to_vec(), ..options.clone() };
                // Logs of a few samples per second have slow filters alone.
                let compared = compare_file(torques, layout, log, &first)
                    .or_else(|_| compare_file(torques, layout, log, options))?;
                Ok(compared.cutoff_hz)
            }
        }
    }

    /// The cut-off at which a comparison of a log with forces at the feet judges a robot that has these effects beside its own, Hz.
    ///
    /// # Errors
    /// Unreadable files, nothing to compare.
    pub fn compared_at(&self, log: &Log, options: &Options, effects: &[Effect]) -> Result<f64, Diagnostics> {
        let all: Vec<Effect> = self.present.iter().chain(effects).cloned().collect();
        self.contact_cutoff(&all, log, options, true)
    }

    /// The cut-off at which the rows of the base fit best, Hz: doubled as long as their errors fall, or as long as it takes away motion of
    /// joints whose efforts count. Slow motions are behind a low one, where noise is least; the limbs of a fast walk are not.
    fn contact_cutoff(
        &self,
        effects: &[Effect],
        log: &Log,
        options: &Options,
        with_joints: bool,
    ) -> Result<f64, Diagnostics> {
        let look = |cutoff: f64| -> Result<(f64, Vec<[f64; 2]>), Diagnostics> {
            let options = Options { cutoff_hz: Some(cutoff), ..options.clone() };
            let found = ContactExperiment::read(Robot { effects, ..self.robot() }, log, &options)?;
            let joints = with_joints && found.recording().has_efforts();
            Ok((found.misfit(), if joints { found.recording().motion() } else { Vec::new() }))
        };
        let mut best = CONTACT_CUTOFF_HZ;
        let mut here = look(best);
        while best < HIGHEST_CONTACT_CUTOFF_HZ {
            let next = look(2.0 * best);
            match (&here, &next) {
                // Short steps leave nothing of a slow filter.
                (Err(_), Ok(_)) => {}
                (Ok((least, _)), Ok((next, _))) if next < least => {}
                (Ok((_, slow)), Ok((_, fast))) if best < FAST_ENOUGH_HZ && cut_off(slow, fast) > CUT_OFF => {}
                // Too high for the log's rate.
                _ => break,
            }
            (best, here) = (2.0 * best, next);
        }
        here.map(|_| best)
    }

    /// A log with forces at the feet, with the joints' efforts if they are wanted and logged.
    fn in_contact(&self, log: &Log, options: &Options) -> Result<Read<'_>, Diagnostics> {
        let told = |recording: &ContactRecording| (recording.warnings.clone(), recording.assumptions.clone());
        let has_efforts = self.layout.joints.iter().any(|joint| log.has(&format!("{}/effort", joint.name)));
        if !(self.with_joints && has_efforts) {
            let experiment = ContactExperiment::read(self.robot(), log, options)?;
            let (warnings, assumptions) = told(experiment.recording());
            return Ok((Box::new(experiment), warnings, assumptions));
        }
        let experiment = WalkingExperiment::read(self.robot(), log, options)?;
        let (warnings, mut assumptions) = told(experiment.base().recording());
        assumptions.extend(experiment.at_stops());
        let left_out = experiment.missing.iter();
        assumptions.extend(left_out.map(|m| format!("`{}` is not compared: {}", m.name, m.reason)));
        Ok((Box::new(experiment), warnings, assumptions))
    }

    /// A file as an experiment, at the cut-off in `options`. `foot` is the stance foot of postures or the striking
    /// foot of impacts.
    ///
    /// # Errors
    /// Unreadable files, columns that are missing, feet that do not exist.
    pub fn load<'m>(
        &'m self,
        log: &Log,
        options: &Options,
        foot: Option<&str>,
    ) -> Result<Loaded<'m>, Diagnostics> {
        let cutoff_hz = options.cutoff_hz.unwrap_or(0.0);
        let content = self.content(log);
        let (experiment, warnings, assumptions): Read<'m> = match content {
            Content::Efforts => {
                let experiment = self.efforts(log, options, SAMPLES)?;
                let recording = experiment.recording();
                let (warnings, mut assumptions) = (recording.warnings.clone(), recording.assumptions.clone());
                let not_seen = recording.missing.iter();
                assumptions.extend(not_seen.map(|m| format!("`{}` is not compared: {}", m.name, m.reason)));
                assumptions.extend(experiment.set_aside());
                (Box::new(experiment), warnings, assumptions)
            }
            Content::Contacts => self.in_contact(log, options)?,
            Content::Postures => {
                let experiment = PostureExperiment::read(self.robot(), log, foot)?;
                let assumptions = experiment.assumptions.clone();
                (Box::new(experiment), Vec::new(), assumptions)
            }
            Content::Impacts => {
                let experiment = ImpactExperiment::read(self.robot(), log, foot)?;
                let assumptions = experiment.assumptions.clone();
                (Box::new(experiment), Vec::new(), assumptions)
            }
        };
        // The hash is known now that the rows were read.
        let source = DataSource { samples: experiment.time().len(), ..log.source()? };
        Ok(Loaded { experiment, source, warnings, assumptions, cutoff_hz, content })
    }
}

/// What a slow filter takes away counts from so many times the noise on that a faster one lets through: of coarse encoders that move slowly it is
/// several times what it is taken for.
const HEARD: f64 = 5.0;

/// The part of what a joint moves, by mean squares of speeds, that the slower of two filters takes away; of the joint that loses most.
fn cut_off(slow: &[[f64; 2]], fast: &[[f64; 2]]) -> f64 {
    let pairs = slow.iter().zip(fast).filter(|([slow, _], [fast, noise])| fast - slow > HEARD * noise);
    pairs.map(|([slow, _], [fast, _])| 1.0 - slow / fast).fold(0.0, f64::max)
}

/// All functions that experiments may call.
fn requests(robot: &Described) -> Vec<FunctionRequest> {
    let of_robot =
        ["inverse_dynamics", "inverse_dynamics_regressor", "center_of_mass", "center_of_mass_regressor"];
    let mut requests: Vec<FunctionRequest> = of_robot.map(FunctionRequest::of_robot).to_vec();
    requests.push(FunctionRequest::of_robot("center_of_mass_jacobian"));
    for foot in &robot.description.feet {
        for family in ["position", "rotation", "jacobian"] {
            let request = FunctionRequest { family: family.to_owned(), subject: Some(foot.link.clone()) };
            // Two feet on one link are about the same functions.
            if !requests.contains(&request) {
                requests.push(request);
            }
        }
    }
    requests
}
