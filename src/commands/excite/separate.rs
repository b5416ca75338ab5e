//! `bipedc excite ROBOT --separate A B`: the motion that best tells two effects apart.
use super::csv;
use super::say::{Held, Joint, family, family_words, last_words};
use super::subject::Excited;
use crate::commands::amend::demand_kind;
use crate::failure::{Failure, Outcome};
use crate::interruption;
use crate::measurements::subject;
use crate::output::{self, table};
use bipedc::link_inertias;
use bipedc_analysis::identify::excite::Request;
use bipedc_analysis::identify::excite::separate::{Candidate, Pair, Separating, Separation, separate};
use bipedc_analysis::identify::joint;
use bipedc_analysis::robot::{JointLayout, LinkInertias};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::suggest;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Kind, Location, Place};
use bipedc_effects::files::Output;
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;

/// Correlations above this are hardly told from 1.
const HIGH: f64 = 0.99;
/// Fewer standard deviations may be chance.
const FEW: f64 = 3.0;

/// What only the separation of effects has.
#[derive(Args)]
#[command(next_help_heading = "Telling effects apart")]
pub struct SeparateArguments {
    /// Look for the motion that best tells two effects apart (bipedc effects lists them)
    #[arg(long, value_names = ["EFFECT_A", "EFFECT_B"], num_args = 2, conflicts_with = "postures")]
    separate: Vec<String>,
    /// Joint of the effects; two joints: of the first and of the second
    #[arg(long, value_name = "J", value_delimiter = ',', requires = "separate")]
    joint: Vec<String>,
    /// The joint whose motion causes a coupling
    #[arg(long, value_name = "K", requires = "separate")]
    other_joint: Option<String>,
    /// Link of the effects; two links: of the first and of the second
    #[arg(long, value_name = "LINK", value_delimiter = ',', requires = "separate")]
    link: Vec<String>,
    /// Let the bodies' inertial parameters be free too: what they can do tells nothing
    #[arg(long, requires = "separate")]
    beside_bodies: bool,
    /// Standard deviation of a measured torque, N m
    #[arg(long, value_name = "NM", allow_negative_numbers = true, default_value_t = 0.1)]
    noise: f64,
}

/// The robot as the diagnosis sees it.
struct Rigid {
    model: ProgramModel,
    subject: JointLayout,
    link_inertias: LinkInertias,
}

impl Rigid {
    /// On a base that may turn if it has to.
    fn new(robot: &Robot, turning: bool) -> Result<Self, Failure> {
        let mut rigid = robot.clone().without_effects();
        if turning {
            rigid = rigid.with_base("floating", None)?;
        }
        let tree = rigid.tree()?;
        let request = |family: &str| FunctionRequest::of_robot(family);
        let requests = ["inverse_dynamics", "inverse_dynamics_regressor"].map(request);
        Ok(Self {
            subject: subject(&tree)?,
            link_inertias: link_inertias(&rigid.description, &tree),
            model: ProgramModel::new(rigid.compile_only(&requests)?),
        })
    }
}

impl SeparateArguments {
    /// Whether two effects were named.
    pub fn wanted(&self) -> bool {
        !self.separate.is_empty()
    }

    /// Searches, writes, prints.
    pub fn run(
        &self,
        robot: &Robot,
        mut excited: Excited,
        request: &Request,
        out: &Path,
        rows: usize,
        json: bool,
    ) -> Outcome {
        let candidates = self.candidates(&excited.subject)?;
        let turning = candidates.iter().any(Candidate::turns_the_world);
        let rigid = output::progress("deriving", || Rigid::new(robot, turning))?;
        self.check_links(&rigid.link_inertias)?;
        let (measured, assumptions) = (excited.measured.clone(), excited.assumptions.clone());
        let machine = excited.machine();
        let pair = Pair {
            model: &rigid.model,
            subject: &rigid.subject,
            link_inertias: &rigid.link_inertias,
            present: &robot.description.effects,
            measured: &measured,
            effects: candidates,
            beside_bodies: self.beside_bodies,
            noise: self.noise,
        };
        // Whether the file can be written shows before the search, not after it.
        let mut file = Output::create(out)?;
        let interrupted = interruption::flag();
        let stop = || interrupted.load(Ordering::Relaxed);
        let found = output::bar("searching", |progress| separate(&machine, &pair, request, progress, &stop))?;
        file.put(&csv(&machine, &found.basis, &found.coefficients, rows))?;
        file.commit()?;
        let (trajectory, order) = family(request.family);
        let judged = |separation: Separation| Judged::new(separation, &pair, rows);
        let mut answer = Answer {
            robot: robot.description.name.clone(),
            file: out.to_path_buf(),
            rows,
            trajectory,
            order,
            duration: request.duration,
            effects: pair.effects.each_ref().map(|effect| effect.usual.clone()),
            columns: found.columns,
            body_columns: found.body_columns,
            common: found.common,
            noise: self.noise,
            before: judged(found.before),
            after: judged(found.after),
            joints: Joint::all(&machine, &found.peaks),
            held: Held::all(&machine),
            feet_distance: found.feet_distance,
            margin: request.margin,
            seed: request.seed,
            starts: found.starts,
            evaluations: found.evaluations,
            out_of_time: found.out_of_time,
            assumptions,
            warnings: Vec::new(),
        };
        answer.warn(&found);
        if json {
            output::print_json(&answer)?
        } else {
            output::print(&answer.to_string())?
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The two effects at their places.
    fn candidates(&self, subject: &JointLayout) -> Result<[Candidate; 2], Diagnostic> {
        for (option, count) in [("--joint", self.joint.len()), ("--link", self.link.len())] {
            if count > 2 {
                return Err(Diagnostic::error(format!("{option} names {count} places for two effects"))
                    .help("give one for both, or one for each"));
            }
        }
        for name in self.joint.iter().chain(&self.other_joint) {
            joint(subject, name)?;
        }
        let [first, second] = [0, 1].map(|k| {
            let kind = demand_kind(&self.separate[k])?;
            Candidate::new(kind.name, self.location(kind, k)).map(|candidate| (kind.place, candidate))
        });
        let (first, second) = (first?, second?);
        let uses = |places: &[Place]| [first.0, second.0].iter().any(|place| places.contains(place));
        let unused = [
            ("--joint", !self.joint.is_empty() && !uses(&[Place::Joint, Place::JointPair])),
            ("--other-joint", self.other_joint.is_some() && !uses(&[Place::JointPair])),
            ("--link", !self.link.is_empty() && !uses(&[Place::Link])),
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
            Place::Joint => Location { joint: pick(&self.joint), ..Location::default() },
            Place::JointPair => Location {
                joint: pick(&self.joint),
                other_joint: self.other_joint.clone(),
                ..Location::default()
            },
            Place::Link => Location { link: pick(&self.link), ..Location::default() },
            Place::Sensor | Place::Robot => Location::default(),
        }
    }

    fn check_links(&self, link_inertias: &LinkInertias) -> Result<(), Diagnostic> {
        match self.link.iter().find(|name| link_inertias.link(name).is_none()) {
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
struct Judged {
    #[serde(flatten)]
    separation: Separation,
    /// Standard deviations of white noise by which each effect at usual values stands out against the other one.
    deviations: [f64; 2],
}

impl Judged {
    fn new(separation: Separation, pair: &Pair<'_>, rows: usize) -> Self {
        let samples = (pair.measured.len() * rows) as f64;
        Self { deviations: separation.rests.map(|rest| rest * samples.sqrt() / pair.noise), separation }
    }
}

/// What was found.
#[derive(Debug, Serialize)]
struct Answer {
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
    before: Judged,
    after: Judged,
    joints: Vec<Joint>,
    held: Vec<Held>,
    /// m.
    feet_distance: Option<f64>,
    margin: f64,
    seed: u64,
    starts: usize,
    evaluations: usize,
    out_of_time: bool,
    assumptions: Vec<String>,
    warnings: Vec<String>,
}

impl Answer {
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
        if self.out_of_time {
            self.warnings.push("time ran out: another run with this seed may give another motion".to_owned());
        }
    }
}

impl std::fmt::Display for Answer {
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
        text.push_str(&table(&head, vec![row(0), row(1)], 2));
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
