//! `bipedc excite ROBOT --postures N`: static postures on two feet from which first moments can be told.
use super::plot;
use crate::failure::Outcome;
use crate::interruption;
use crate::output::{self, table};
use bipedc::standing::{Root, Standing as Rooted};
use bipedc_analysis::identify::excite::postures::{
    DesignedPostures, PostureRequest, Run, Standing, Tolerance, design_postures,
};
use bipedc_analysis::identify::excite::{Criterion, Scaling};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::exact::Model;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::{Batch, Ledger, Output};
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Robots that are a little different, on which postures must stand too.
const DRAWS: usize = 6;

/// What only postures have.
#[derive(Args)]
#[command(next_help_heading = "Static postures")]
pub struct PostureArguments {
    /// Design so many static postures with both feet flat instead of a trajectory
    #[arg(long, value_name = "N")]
    pub postures: Option<usize>,
    /// Foot placements that the postures share [default: a fifth of the postures]
    #[arg(long, value_name = "K", requires = "postures")]
    placements: Option<usize>,
    /// Foot that stays where it is [default: the right one]
    #[arg(long, value_name = "FOOT", requires = "postures")]
    stance: Option<String>,
    /// Least distance of the expected centre of pressure from the edge of the support, m
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.02)]
    stability: f64,
    /// How wrong the described masses may be, per cent: robots so perturbed must stand too
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, default_value_t = 10.0)]
    mass_error: f64,
    /// How wrong the described centres of mass may be, m
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.01)]
    center_error: f64,
    /// Draw placements and centres of pressure from above
    #[arg(long, value_name = "FILE.svg", requires = "postures")]
    plot: Option<PathBuf>,
}

/// What trajectories and postures share.
pub struct Shared<'a> {
    pub robot: &'a Robot,
    pub out: &'a Path,
    pub margin: f64,
    /// Least distance between the soles, m.
    pub gap: f64,
    pub criterion: Criterion,
    pub seed: u64,
    pub starts: usize,
    pub evaluations: usize,
    pub time_limit: Option<Duration>,
    pub json: bool,
}

/// What was found.
#[derive(Debug, Serialize)]
struct Answer {
    robot: String,
    stance: String,
    file: PathBuf,
    plot: Option<PathBuf>,
    parameters: Vec<String>,
    runs: Vec<Run>,
    best: usize,
    /// x, y (m), yaw (rad) of the other sole.
    placements: Vec<[f64; 3]>,
    postures: usize,
    /// m.
    least_stability: f64,
    least_stability_of_others: f64,
    standing_others: f64,
    least_gap: f64,
    joints: Vec<Joint>,
    margin: f64,
    mass_error: f64,
    center_error: f64,
    seed: u64,
    stopped: bool,
    assumptions: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Joint {
    name: String,
    position: (f64, f64),
    position_limits: (f64, f64),
}

impl PostureArguments {
    /// Notes the drawing among what is written.
    ///
    /// # Errors
    /// It would overwrite an input or another output.
    pub fn note(&self, ledger: &mut Ledger) -> Result<(), Diagnostic> {
        self.plot.as_ref().map_or(Ok(()), |plot| ledger.writes("--plot", plot))
    }

    /// Designs, writes, prints.
    pub fn run(&self, postures: usize, shared: &Shared<'_>) -> Outcome {
        let request = self.request(postures, shared)?;
        let rooted = Rooted::new(shared.robot, self.stance.as_deref(), Root::Link)?;
        let regressor = FunctionRequest::of_robot("center_of_mass_regressor");
        let rigid = rooted.robot.clone().without_effects();
        let (model, base) = output::progress("deriving", || {
            let model = ProgramModel::new(rigid.compile_only(&[regressor])?);
            Ok::<_, Diagnostic>((model, rooted.base(Model::CenterOfMass, &["x", "y"], true)?))
        })?;
        let mut assumptions = Vec::new();
        let standing = Standing::new(rooted.parts(&model, &base, &mut assumptions)?)?;
        // Whether the files can be written shows before the search, not after it.
        let mut table = Output::create(shared.out)?;
        let drawing = self.plot.as_deref().map(Output::create).transpose()?;
        let interrupted = interruption::flag();
        let stop = || interrupted.load(Ordering::Relaxed);
        let found =
            output::bar("searching", |progress| design_postures(&standing, &request, progress, &stop))?;
        let mut files = Batch::default();
        table.put(&csv(&standing, &found))?;
        files.add(table);
        if let Some(mut drawing) = drawing {
            drawing.put(&plot::from_above(&standing, &found))?;
            files.add(drawing);
        }
        files.commit()?;
        let answer = Answer {
            robot: shared.robot.description.name.clone(),
            stance: rooted.stance.clone(),
            file: shared.out.to_path_buf(),
            plot: self.plot.clone(),
            parameters: base.names.clone(),
            least_stability: found.postures.iter().map(|p| p.stability).fold(f64::INFINITY, f64::min),
            least_stability_of_others: found.stability_of_others,
            standing_others: found.standing_others,
            least_gap: found.gap,
            joints: joints(&standing, &found),
            margin: request.margin,
            mass_error: request.tolerance.mass,
            center_error: request.tolerance.center,
            seed: request.seed,
            stopped: found.stopped,
            postures,
            runs: found.runs,
            best: found.best,
            placements: found.placements,
            assumptions,
        };
        if shared.json {
            output::print_json(&answer)?;
        } else {
            output::print(&answer.text())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn request(&self, postures: usize, shared: &Shared<'_>) -> Result<PostureRequest, Diagnostic> {
        let lengths =
            [("--stability", self.stability), ("--gap", shared.gap), ("--center-error", self.center_error)];
        for (option, value) in lengths {
            if !(0.0..0.5).contains(&value) {
                return Err(Diagnostic::error(format!("{option} is {value}"))
                    .help("give a length in m, from 0 to 0.5"));
            }
        }
        if !(0.0..=50.0).contains(&self.mass_error) {
            return Err(Diagnostic::error(format!("--mass-error is {}", self.mass_error))
                .help("give 0 to 50 per cent"));
        }
        let mass = self.mass_error / 100.0;
        let draws = if mass > 0.0 || self.center_error > 0.0 { DRAWS } else { 0 };
        Ok(PostureRequest {
            postures,
            placements: self.placements.unwrap_or(postures.div_ceil(5)),
            criterion: shared.criterion,
            scaling: Scaling::Own,
            margin: shared.margin,
            stability: self.stability,
            gap: shared.gap,
            tolerance: Tolerance { mass, center: self.center_error, draws },
            seed: shared.seed,
            starts: shared.starts,
            evaluations: shared.evaluations,
            time_limit: shared.time_limit,
        })
    }
}

/// The postures in the order of their placements, as a table of postures without measurements.
fn csv(standing: &Standing<'_>, found: &DesignedPostures) -> String {
    let mut text = String::from("posture,placement");
    for name in &standing.parts.names {
        let _ = write!(text, ",{name}/position");
    }
    text.push_str(",expected_cop_x,expected_cop_y\n");
    // Adding zero makes -0 a 0.
    let round = |x: f64| (x * 1e9).round() / 1e9 + 0.0;
    for (number, posture) in found.postures.iter().enumerate() {
        let _ = write!(text, "{number},{}", posture.placement);
        for q in &posture.joints {
            let _ = write!(text, ",{:.9}", round(*q));
        }
        let _ = writeln!(text, ",{:.9},{:.9}", round(posture.center[0]), round(posture.center[1]));
    }
    text
}

fn joints(standing: &Standing<'_>, found: &DesignedPostures) -> Vec<Joint> {
    let parts = &standing.parts;
    let joint =
        |(j, (name, place)): (usize, (&String, &bipedc_analysis::identify::excite::postures::JointPlace))| {
            let positions = found.postures.iter().map(|posture| posture.joints[j]);
            let position = positions
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
            Joint { name: name.clone(), position, position_limits: place.limits }
        };
    parts.names.iter().zip(&parts.joints).enumerate().map(joint).collect()
}

impl Answer {
    fn text(&self) -> String {
        let mut out = String::new();
        for assumption in &self.assumptions {
            let _ = writeln!(out, "assumed: {assumption}");
        }
        let _ = writeln!(
            out,
            "{} postures on {} foot placements, standing on `{}`; {} parameters (first moments), columns in m\n",
            self.postures,
            self.placements.len(),
            self.stance,
            self.parameters.len()
        );
        let rows = self.runs.iter().enumerate().map(|(k, run)| {
            vec![
                format!("{}{}", k + 1, if k == self.best { " *" } else { "" }),
                format!("{:.1}", run.before.condition_number),
                format!("{:.1}", run.after.condition_number),
                format!("{:.1}", run.before.log_determinant),
                format!("{:.1}", run.after.log_determinant),
                run.evaluations.to_string(),
            ]
        });
        let head = [
            "start",
            "condition number: feasible",
            "optimised",
            "ln det: feasible",
            "optimised",
            "evaluations",
        ];
        out.push_str(&table(&head, rows.collect(), 1));
        let _ = writeln!(
            out,
            "\ncentre of pressure at least {:.1} mm inside the support; of 200 robots whose masses are up to {:.0} % and centres up to {:.0} mm wrong {:.2} % of the postures stand (least: {:.1} mm)",
            1e3 * self.least_stability,
            100.0 * self.mass_error,
            1e3 * self.center_error,
            100.0 * self.standing_others,
            1e3 * self.least_stability_of_others
        );
        let _ = writeln!(out, "soles at least {:.1} mm apart\n", 1e3 * self.least_gap);
        let rows = self.joints.iter().map(|j| {
            vec![
                j.name.clone(),
                format!("{:.3} … {:.3}", j.position.0, j.position.1),
                format!("{:.3} … {:.3}", j.position_limits.0, j.position_limits.1),
            ]
        });
        out.push_str(&table(&["joint", "position, rad", "limits"], rows.collect(), 1));
        if self.stopped {
            let _ =
                writeln!(out, "\nwarning: the search was ended early: another run may give other postures");
        }
        let _ = writeln!(
            out,
            "\n{} rows in {}; add measured columns cop/x and cop/y for `bipedc identify --method cop`. Only the soles were kept apart: try every posture by hand first",
            self.postures,
            self.file.display()
        );
        out
    }
}
