//! Measurement files as experiments: what `diagnose` and `amend` work on.
use crate::failure::Failure;
use bipedc::{ProgramTorques, feet, link_inertias};
use bipedc_analysis::compare::compare_file;
use bipedc_analysis::experiments::contact_log::{ContactExperiment, WalkingExperiment};
use bipedc_analysis::experiments::impacts::ImpactExperiment;
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::log::{Kind, Mapping, Reader};
use bipedc_analysis::measure::{Options, Recording, Source};
use bipedc_analysis::robot;
use bipedc_analysis::robot::link_inertias::LinkInertias;
use bipedc_analysis::robot::{Foot, Joint, JointLayout, Robot};
use bipedc_compiler::Robot as Described;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::Base;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

/// Most samples of a log that a diagnosis works on; longer logs are thinned after filtering.
const SAMPLES: usize = 10_000;
/// Cut-off of logs with foot forces unless one is given, Hz.
const CONTACT_CUTOFF_HZ: f64 = 5.0;

/// A robot ready to be held against measurements: the rigid model on a base that can be turned.
pub struct Measured {
    pub subject: JointLayout,
    link_inertias: LinkInertias,
    feet: Vec<Foot>,
    model: ProgramModel,
    /// Effects that the description has already.
    pub present: Vec<Effect>,
    torques: ProgramTorques,
    /// Whether logs with foot forces show the joints' efforts too, beside the rows of the base.
    pub with_joints: bool,
}

/// A file as an experiment.
pub struct Loaded<'a> {
    pub experiment: Box<dyn Experiment + 'a>,
    pub source: Source,
    pub warnings: Vec<Diagnostic>,
    pub assumptions: Vec<String>,
    /// Hz; 0 for tables.
    pub cutoff_hz: f64,
    pub content: Content,
}

impl Content {
    /// What samples run over.
    pub fn abscissa(self) -> &'static str {
        match self {
            Self::Efforts | Self::Contacts => "time",
            Self::Postures => "posture",
            Self::Impacts => "impact",
        }
    }
}

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Joint torques of a robot whose base rests.
    Efforts,
    /// Motion of the base and forces below the feet.
    Contacts,
    Postures,
    Impacts,
}

impl Measured {
    /// Compiles what is needed. A fixed base becomes a floating one at rest, so that it can be tilted.
    pub fn new(robot: &Described) -> Result<Self, Failure> {
        let present = robot.description.effects.clone();
        let mut rigid = robot.clone().without_effects();
        if rigid.tree()?.base == BaseKind::Fixed {
            rigid = rigid.with_base("floating", None)?;
        }
        let tree = rigid.tree()?;
        let subject = subject(&tree)?;
        let link_inertias = link_inertias(&rigid.description, &tree);
        let compiled = rigid.compile_only(&requests(&rigid))?;
        let torques = ProgramTorques::new(&compiled)?;
        let feet = feet(&rigid.description);
        Ok(Self {
            subject,
            link_inertias,
            feet,
            model: ProgramModel::new(compiled),
            present,
            torques,
            with_joints: false,
        })
    }

    /// What experiments know of the robot.
    pub fn robot(&self) -> Robot<'_> {
        Robot {
            model: &self.model,
            subject: &self.subject,
            link_inertias: &self.link_inertias,
            feet: &self.feet,
            effects: &self.present,
        }
    }

    /// What a file holds, from its header.
    pub fn content(&self, file: &Path, mapping: &Mapping) -> Result<Content, Diagnostics> {
        content(&self.subject, file, mapping)
    }

    /// A log with forces at the feet as an experiment, whatever else it holds.
    pub fn contacts(
        &self,
        file: &Path,
        mapping: &Mapping,
        options: &Options,
    ) -> Result<Loaded<'_>, Diagnostics> {
        let experiment = ContactExperiment::read(self.robot(), file, mapping, options)?;
        let mut source = Source::of(file, 0).map_err(|e| Diagnostics(vec![e]))?;
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
        let mut q = vec![0.0; model.nq()];
        let first = q.len().saturating_sub(joints.len());
        if self.subject.base == robot::BaseKind::Floating {
            q[6] = 1.0;
        }
        q[first..].copy_from_slice(joints);
        let mut columns = vec![0.0; 3 * parameters.len()];
        let function = model.function("center_of_mass_regressor");
        let state = State::new().with(Argument::Q, &q);
        if function.is_none_or(|f| model.evaluate(f, &state, &mut columns).is_err()) {
            return [f64::NAN; 3];
        }
        let mass: f64 = parameters.iter().step_by(10).sum();
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
    pub fn efforts(
        &self,
        file: &Path,
        mapping: &Mapping,
        options: &Options,
        most: usize,
    ) -> Result<MotionExperiment<'_>, Diagnostics> {
        let recording = if most == usize::MAX {
            Recording::read(file, mapping, &self.subject, options)?
        } else {
            Recording::read_thinned(file, mapping, &self.subject, options, most)?
        };
        MotionExperiment::new(&self.model, &self.subject, &self.link_inertias, recording, &self.present)
            .map_err(|e| Diagnostics(vec![e.in_file(file)]))
    }

    /// The cut-off for a file: the given one, else the one at which most channels fit best.
    pub fn cutoff(&mut self, file: &Path, mapping: &Mapping, options: &Options) -> Result<f64, Diagnostics> {
        match (options.cutoff_hz, self.content(file, mapping)?) {
            (Some(cutoff), _) => Ok(cutoff),
            (None, Content::Contacts) => Ok(CONTACT_CUTOFF_HZ),
            (None, Content::Postures | Content::Impacts) => Ok(0.0),
            (None, Content::Efforts) => {
                let comparison = compare_file(&mut self.torques, &self.subject, file, mapping, options)?;
                Ok(comparison.quietest_cutoff())
            }
        }
    }

    /// A file as an experiment, at the cut-off in `options`. `foot` is the stance foot of postures or the striking
    /// foot of impacts.
    pub fn load<'m>(
        &'m self,
        file: &Path,
        mapping: &Mapping,
        options: &Options,
        foot: Option<&str>,
    ) -> Result<Loaded<'m>, Diagnostics> {
        let cutoff_hz = options.cutoff_hz.unwrap_or(0.0);
        let mut source = Source::of(file, 0).map_err(|e| Diagnostics(vec![e]))?;
        let content = self.content(file, mapping)?;
        let mut loaded = |experiment: Box<dyn Experiment + 'm>, warnings, assumptions| {
            source.samples = experiment.time().len();
            let source = std::mem::take(&mut source);
            Loaded { experiment, source, warnings, assumptions, cutoff_hz, content }
        };
        Ok(match content {
            Content::Efforts => {
                let experiment = self.efforts(file, mapping, options, SAMPLES)?;
                let recording = experiment.recording();
                let (warnings, assumptions) = (recording.warnings.clone(), recording.assumptions.clone());
                loaded(Box::new(experiment), warnings, assumptions)
            }
            Content::Contacts => {
                let experiment = ContactExperiment::read(self.robot(), file, mapping, options)?;
                let recording = experiment.recording();
                let (warnings, mut assumptions) = (recording.warnings.clone(), recording.assumptions.clone());
                if !(self.with_joints && recording.has_efforts()) {
                    return Ok(loaded(Box::new(experiment), warnings, assumptions));
                }
                let in_file = |e: Diagnostic| Diagnostics(vec![e.in_file(file)]);
                let experiment = WalkingExperiment::new(experiment).map_err(in_file)?;
                let left_out = experiment.missing.iter();
                assumptions.extend(left_out.map(|m| format!("`{}` is not compared: {}", m.name, m.reason)));
                loaded(Box::new(experiment), warnings, assumptions)
            }
            Content::Postures => {
                let experiment = PostureExperiment::read(self.robot(), file, mapping, foot)?;
                let assumptions = experiment.assumptions.clone();
                loaded(Box::new(experiment), Vec::new(), assumptions)
            }
            Content::Impacts => {
                let experiment = ImpactExperiment::read(self.robot(), file, mapping, foot)?;
                let assumptions = experiment.assumptions.clone();
                loaded(Box::new(experiment), Vec::new(), assumptions)
            }
        })
    }
}

/// What a file holds for this robot, from its header.
pub fn content(subject: &JointLayout, file: &Path, mapping: &Mapping) -> Result<Content, Diagnostics> {
    let reader = Reader::open(file, mapping)?;
    let has = |part: &str| reader.columns().any(|column| column.name.contains(part));
    let moves = subject.base != robot::BaseKind::Fixed && has("base/position");
    Ok(match reader.kind() {
        Kind::Posture => Content::Postures,
        Kind::Impact => Content::Impacts,
        Kind::Time if moves && has("/force/") => Content::Contacts,
        Kind::Time => Content::Efforts,
    })
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

/// What a comparison has to know of the robot.
pub fn subject(tree: &Tree) -> Result<JointLayout, Diagnostic> {
    let base = match tree.base {
        BaseKind::Floating => robot::BaseKind::Floating,
        BaseKind::Planar => robot::BaseKind::Planar,
        BaseKind::Fixed => robot::BaseKind::Fixed,
        BaseKind::Pivot => {
            return Err(Diagnostic::error("a log does not tell the angle of a pivot")
                .help("choose another base with --base floating|planar|fixed"));
        }
    };
    let joints = tree.joints.iter();
    let joints = joints.map(|joint| Joint { name: joint.name.clone(), prismatic: joint.prismatic }).collect();
    Ok(JointLayout { joints, base })
}
