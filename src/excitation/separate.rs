//! The motion that best tells two effects apart.
use super::excited::Excited;
use super::motion::{FixedJoint, Joint, family, family_words, last_words};
use super::{Options, written};
use crate::kinds::demand_kind;
use crate::progress::Run;
use crate::robot::{joint_layout, link_inertias};
use crate::table::table;
use bipedc_analysis::identify::excite::separate::{Candidate, Pair, Separating, Separation, separate};
use bipedc_analysis::identify::excite::{Early, Machine};
use bipedc_analysis::identify::joint;
use bipedc_analysis::robot::{JointLayout, LinkInertias};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::suggest;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::{Effect, Kind, Location, Place};
use bipedc_effects::files::Output;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Correlations above this are hardly told from 1.
const HIGH: f64 = 0.99;
/// Fewer standard deviations may be chance.
const FEW: f64 = 3.0;

/// Two effects of the library, where they are and beside what.
#[derive(Debug, Clone)]
pub struct SeparateOptions {
    /// Their kinds.
    pub effects: [String; 2],
    /// Joint of the effects; two joints: of the first and of the second.
    pub joints: Vec<String>,
    /// The joint whose motion causes a coupling.
    pub other_joint: Option<String>,
    /// Link of the effects; two links: of the first and of the second.
    pub links: Vec<String>,
    /// Let the bodies' inertial parameters be free too: what they can do tells nothing.
    pub beside_bodies: bool,
    /// Standard deviation of a measured torque, N m.
    pub noise: f64,
}

/// The robot as the diagnosis sees it.
struct Rigid {
    model: ProgramModel,
    layout: JointLayout,
    link_inertias: LinkInertias,
}

impl Rigid {
    /// On a base that may turn if it has to.
    fn new(robot: &Robot, turning: bool) -> Result<Self, Diagnostic> {
        let mut rigid = robot.clone().without_effects();
        if turning {
            rigid = rigid.with_base("floating", None)?;
        }
        let tree = rigid.tree()?;
        let request = |family: &str| FunctionRequest::of_robot(family);
        let requests = ["inverse_dynamics", "inverse_dynamics_regressor"].map(request);
        Ok(Self {
            layout: joint_layout(&tree)?,
            link_inertias: link_inertias(&rigid.description, &tree),
            model: ProgramModel::new(rigid.compile_only(&requests)?),
        })
    }
}

/// Looks for the motion that best tells two effects apart and writes it to `out`.
///
/// # Errors
/// As [`design_motion`](super::design_motion); kinds and places that do not exist.
pub fn separate_effects(
    robot: &Robot,
    (options, asked): (&Options, &SeparateOptions),
    out: &Path,
    run: &Run<'_>,
) -> Result<SeparatingMotion, Diagnostics> {
    options.check()?;
    let (request, rows, progress) = (&options.request, options.rows(), run.progress);
    let derive = || Excited::new(robot, &options.joints, options.acceleration, options.gap);
    let mut excited = progress.stage("deriving", derive)?;
    let candidates = asked.candidates(&excited.layout)?;
    let turning = candidates.iter().any(Candidate::turns_the_world);
    let rigid = progress.stage("deriving", || Rigid::new(robot, turning))?;
    asked.check_links(&rigid.link_inertias)?;
    let (measured, assumptions) = (excited.measured.clone(), excited.assumptions.clone());
    let machine = excited.machine();
    let pair = Pair {
        model: &rigid.model,
        layout: &rigid.layout,
        link_inertias: &rigid.link_inertias,
        present: &robot.description.effects,
        measured: &measured,
        effects: candidates,
        beside_bodies: asked.beside_bodies,
        noise: asked.noise,
    };
    // Whether the file can be written shows before the search, not after it.
    let file = Output::create(out)?;
    let search = |progress: &dyn Fn(f64)| separate(&machine, &pair, request, progress, run.stop);
    let found = progress.counted("searching", search)?;
    written(file, (&machine, &found.basis, &found.coefficients), rows)?;
    let mut answer = SeparatingMotion {
        robot: robot.description.name.clone(),
        file: out.to_path_buf(),
        assumptions,
        ..SeparatingMotion::new((&machine, &pair), options, &found)
    };
    answer.warn(&found);
    Ok(answer)
}

impl SeparateOptions {
    /// The two effects at their places.
    fn candidates(&self, layout: &JointLayout) -> Result<[Candidate; 2], Diagnostic> {
        for (option, count) in [("--joint", self.joints.len()), ("--link", self.links.len())] {
            if count > 2 {
                return Err(Diagnostic::error(format!("{option} names {count} places for two effects"))
                    .help("give one for both, or one for each"));
            }
        }
        for name in self.joints.iter().chain(&self.other_joint) {
            joint(layout, name)?;
        }
        let [first, second] = [0, 1].map(|k| {
            let kind = demand_kind(&self.effects[k])?;
            Candidate::new(kind.name, self.location(kind, k)).map(|candidate| (kind.place, candidate))
        });
        let (first, second) = (first?, second?);
        let uses = |places: &[Place]| [first.0, second.0].iter().any(|place| places.contains(place));
        let unused = [
            ("--joint", !self.joints.is_empty() && !uses(&[Place::Joint, Place::JointPair])),
            ("--other-joint", self.other_joint.is_some() && !uses(&[Place::JointPair])),
            ("--link", !self.links.is_empty() && !uses(&[Place::Link])),
        ];
        if let Some((option, _)) = unused.iter().find(|(_, unused)| *unused) {
            return Err(Diagnostic::error(format!("neither effect is at such a place: {option}"))
                .help(format!("leave {option} out; bipedc effects says where kinds belong")));
        }
        Ok([first.1, second.1])
    }

    fn location(&self, kind: &Kind, which: usize) -> Location {
        let pick = |names: &[String]| names.get(which).or(names.last()).cloned();
        match kind.place {
            Place::Joint => Location { joint: pick(&self.joints), ..Location::default() },
            Place::JointPair => Location {
                joint: pick(&self.joints),
                other_joint: self.other_joint.clone(),
                ..Location::default()
            },
            Place::Link => Location { link: pick(&self.links), ..Location::default() },
            Place::Sensor | Place::Robot => Location::default(),
        }
    }

    fn check_links(&self, link_inertias: &LinkInertias) -> Result<(), Diagnostic> {
        match self.links.iter().find(|name| link_inertias.link(name).is_none()) {
            Some(name) => {
                let links = link_inertias.links.iter().map(|link| link.name.as_str());
                Err(Diagnostic::error(format!("the robot has no link `{name}` that moves"))
                    .help(suggest(name, links, "links")))
            }
            None => Ok(()),
        }
    }
}

/// A motion's worth, with what the noise leaves of it.
#[derive(Debug, Serialize)]
pub struct Judged {
    /// How well the two are told apart.
    #[serde(flatten)]
    pub separation: Separation,
    /// Standard deviations of white noise by which each effect at usual values stands out against the other one.
    pub deviations: [f64; 2],
}

impl Judged {
    fn new(separation: Separation, pair: &Pair<'_>, rows: usize) -> Self {
        let samples = (pair.measured.len() * rows) as f64;
        Self { deviations: separation.rests.map(|rest| rest * samples.sqrt() / pair.noise), separation }
    }
}

/// A motion that was designed and written. As text and as JSON it is what `bipedc excite --separate` prints.
#[derive(Debug, Serialize)]
pub struct SeparatingMotion {
    robot: String,
    file: PathBuf,
    rows: usize,
    trajectory: &'static str,
    order: usize,
    duration: f64,
    /// With usual values.
    effects: [Effect; 2],
    columns: [usize; 2],
    body_columns: usize,
    common: usize,
    noise: f64,
    /// The best random start.
    pub before: Judged,
    /// The motion that was written.
    pub after: Judged,
    joints: Vec<Joint>,
    held: Vec<FixedJoint>,
    /// m.
    feet_distance: Option<f64>,
    margin: f64,
    seed: u64,
    starts: usize,
    evaluations: usize,
    out_of_time: bool,
    interrupted: bool,
    assumptions: Vec<String>,
    /// Why the two may not be told apart all the same.
    pub warnings: Vec<String>,
}

impl SeparatingMotion {
    /// Without robot and file, assumptions and warnings.
    fn new((machine, pair): (&Machine<'_>, &Pair<'_>), options: &Options, found: &Separating) -> Self {
        let (request, rows) = (&options.request, options.rows());
        let (trajectory, order) = family(request.family);
        Self {
            robot: String::new(),
            file: PathBuf::new(),
            rows,
            trajectory,
            order,
            duration: request.duration,
            effects: pair.effects.each_ref().map(|effect| effect.usual.clone()),
            columns: found.columns,
            body_columns: found.body_columns,
            common: found.common,
            noise: pair.noise,
            before: Judged::new(found.before, pair, rows),
            after: Judged::new(found.after, pair, rows),
            joints: Joint::all(machine, &found.peaks),
            held: FixedJoint::all(machine),
            feet_distance: found.feet_distance,
            margin: request.margin,
            seed: request.seed,
            starts: found.starts,
            evaluations: found.evaluations,
            out_of_time: found.early == Some(Early::OutOfTime),
            interrupted: found.early == Some(Early::Interrupted),
            assumptions: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// One row for each effect.
    fn table(&self) -> String {
        let (before, after) = (&self.before, &self.after);
        let row = |k: usize| {
            let values: Vec<String> =
                self.effects[k].parameters.iter().map(|(name, value)| format!("{name} {value}")).collect();
            vec![
                self.effects[k].to_string(),
                values.join(", "),
                format!("{:.3} ({:.3})", after.separation.sizes[k], before.separation.sizes[k]),
                format!("{:.3} ({:.3})", after.separation.rests[k], before.separation.rests[k]),
                format!("{:.1} ({:.1})", after.deviations[k], before.deviations[k]),
            ]
        };
        let head = [
            "effect",
            "usual values, SI",
            "its torque, N m",
            "that the other cannot make, N m",
            "in standard deviations",
        ];
        table(&head, vec![row(0), row(1)], 2)
    }

    fn warn(&mut self, found: &Separating) {
        let [first, second] = self.effects.each_ref().map(ToString::to_string);
        if found.common > 0 {
            self.warnings.push(format!(
                "{} of the ways in which {first} and {second} change torques are the same along every motion of these joints; the correlation is that of the others",
                found.common
            ));
        }
        if found.after.correlation > HIGH {
            self.warnings.push(format!(
                "the two can hardly be told apart by any motion of these joints: a correlation of {:.4} is left; other joints, loads or measurements may help",
                found.after.correlation
            ));
        }
        for (k, name) in [first, second].iter().enumerate() {
            let (size, deviations) = (found.after.sizes[k], self.after.deviations[k]);
            if size < self.noise {
                self.warnings.push(format!(
                    "{name} at usual values makes {size:.2e} N m, less than the noise of {} N m",
                    self.noise
                ));
            }
            if deviations < FEW {
                self.warnings.push(format!(
                    "{name} at usual values would stand out by {deviations:.1} standard deviations only: run the motion several times, or measure better"
                ));
            }
        }
        if let Some(early) = found.early {
            self.warnings.push(format!("{early}: another run with this seed may give another motion"));
        }
    }
}

impl std::fmt::Display for SeparatingMotion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = String::new();
        for assumption in &self.assumptions {
            writeln!(text, "assumed: {assumption}")?;
        }
        for held in &self.held {
            writeln!(text, "{held}")?;
        }
        writeln!(text, "{} s of {}", self.duration, family_words(self.trajectory, self.order))?;
        let bodies = match self.body_columns {
            0 => String::new(),
            count => format!(", beside {count} combinations of the bodies' inertial parameters"),
        };
        writeln!(
            text,
            "canonical correlation {:.4} (random start: {:.4}), angle {:.3} rad ({:.3}){bodies}",
            self.after.separation.correlation,
            self.before.separation.correlation,
            self.after.separation.angle,
            self.before.separation.angle
        )?;
        writeln!(text, "{} starts, {} evaluations, seed {}\n", self.starts, self.evaluations, self.seed)?;
        text.push_str(&self.table());
        writeln!(
            text,
            "torques: root mean square over measured joints and time (random start); noise {} N m\n",
            self.noise
        )?;
        text.push_str(&Joint::table(&self.joints));
        for warning in &self.warnings {
            writeln!(text, "\nwarning: {warning}")?;
        }
        writeln!(text, "\n{}", last_words(self.rows, &self.file, self.feet_distance))?;
        f.write_str(&text)
    }
}
