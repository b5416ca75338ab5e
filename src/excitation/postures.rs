//! Static postures on two feet from which first moments can be told (thesis 5.24).
use super::plot;
use crate::identification::standing::{Root, StandingRobot};
use crate::progress::Run;
use crate::table::table;
use bipedc_analysis::identify::excite::postures::{
    self, DesignedPostures, JointPlace, PostureRequest, StanceModel, Tolerance,
};
use bipedc_analysis::identify::excite::{Criterion, Scaling};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::exact::Model;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::{Batch, Output};
use serde::Serialize;
use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Robots that are a little different, on which postures must stand too.
const DRAWS: usize = 6;

/// Which postures are looked for.
#[derive(Debug, Clone)]
pub struct PostureOptions {
    /// How many.
    pub postures: usize,
    /// Foot placements that they share; by default a fifth of them.
    pub placements: Option<usize>,
    /// Foot that stays where it is; by default the right one.
    pub stance: Option<String>,
    /// Least distance of the expected centre of pressure from the edge of the support, m.
    pub stability: f64,
    /// How wrong the described masses may be, per cent: robots so perturbed must stand too.
    pub mass_error: f64,
    /// How wrong the described centres of mass may be, m.
    pub center_error: f64,
    /// Part of every joint's limits left unused.
    pub margin: f64,
    /// Least distance between the soles, m.
    pub gap: f64,
    /// What is made small.
    pub criterion: Criterion,
    /// Of the random starts.
    pub seed: u64,
    /// Random starts.
    pub starts: usize,
    /// Most evaluations of the cost in one start.
    pub evaluations: usize,
    /// After this the best so far is taken.
    pub time_limit: Option<Duration>,
    /// Where placements and centres of pressure are drawn from above, as SVG.
    pub plot: Option<PathBuf>,
}

/// Postures that were designed and written. As text and as JSON it is what `bipedc excite --postures` prints.
#[derive(Debug, Serialize)]
pub struct PostureSet {
    robot: String,
    stance: String,
    file: PathBuf,
    plot: Option<PathBuf>,
    parameters: Vec<String>,
    /// Condition numbers and determinants of every start.
    pub runs: Vec<postures::Run>,
    /// Which of `runs` was written.
    pub best: usize,
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

/// Looks for postures with both feet flat from which first moments are told well, and writes them to `out` as a table without
/// measurements.
///
/// # Errors
/// Lengths and errors that have no meaning; robots that do not stand on two feet in three dimensions; files that cannot be written.
pub fn design_postures(
    robot: &Robot,
    options: &PostureOptions,
    out: &Path,
    run: &Run<'_>,
) -> Result<PostureSet, Diagnostics> {
    let request = options.request()?;
    let rooted = StandingRobot::new(robot, options.stance.as_deref(), Root::Link)?;
    let regressor = FunctionRequest::of_robot("center_of_mass_regressor");
    let rigid = rooted.robot.clone().without_effects();
    let (model, base) = run.progress.stage("deriving", || {
        let model = ProgramModel::new(rigid.compile_only(&[regressor])?);
        Ok::<_, Diagnostic>((model, rooted.base(Model::CenterOfMass, &["x", "y"], true)?))
    })?;
    let mut assumptions = Vec::new();
    let standing = StanceModel::new(rooted.parts(&model, &base, &mut assumptions)?)?;
    // Whether the files can be written shows before the search, not after it.
    let table = Output::create(out)?;
    let drawing = options.plot.as_deref().map(Output::create).transpose()?;
    let search = |progress: &dyn Fn(f64)| postures::design_postures(&standing, &request, progress, run.stop);
    let found = run.progress.counted("searching", search)?;
    write((table, drawing), &standing, &found)?;
    Ok(PostureSet {
        robot: robot.description.name.clone(),
        stance: rooted.stance.clone(),
        file: out.to_path_buf(),
        plot: options.plot.clone(),
        parameters: base.names.clone(),
        assumptions,
        ..PostureSet::new(&standing, &request, found)
    })
}

/// The table and the drawing, both or none.
fn write(
    (mut table, drawing): (Output, Option<Output>),
    standing: &StanceModel<'_>,
    found: &DesignedPostures,
) -> Result<(), Diagnostic> {
    let mut files = Batch::default();
    table.put(&csv(standing, found))?;
    files.add(table);
    if let Some(mut drawing) = drawing {
        drawing.put(&plot::from_above(standing, found))?;
        files.add(drawing);
    }
    files.commit()
}

impl PostureOptions {
    fn request(&self) -> Result<PostureRequest, Diagnostic> {
        let lengths =
            [("--stability", self.stability), ("--gap", self.gap), ("--center-error", self.center_error)];
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
            postures: self.postures,
            placements: self.placements.unwrap_or(self.postures.div_ceil(5)),
            criterion: self.criterion,
            scaling: Scaling::Own,
            margin: self.margin,
            stability: self.stability,
            gap: self.gap,
            tolerance: Tolerance { mass, center: self.center_error, draws },
            seed: self.seed,
            starts: self.starts,
            evaluations: self.evaluations,
            time_limit: self.time_limit,
        })
    }
}

/// The postures in the order of their placements, as a table of postures without measurements.
fn csv(standing: &StanceModel<'_>, found: &DesignedPostures) -> String {
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

fn joints(standing: &StanceModel<'_>, found: &DesignedPostures) -> Vec<Joint> {
    let parts = &standing.parts;
    let joint = |(j, (name, place)): (usize, (&String, &JointPlace))| {
        let positions = found.postures.iter().map(|posture| posture.joints[j]);
        let position =
            positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
        Joint { name: name.clone(), position, position_limits: place.limits }
    };
    parts.names.iter().zip(&parts.joints).enumerate().map(joint).collect()
}

impl fmt::Display for PostureSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text())
    }
}

impl PostureSet {
    /// Without robot, files and assumptions.
    fn new(standing: &StanceModel<'_>, request: &PostureRequest, found: DesignedPostures) -> Self {
        Self {
            robot: String::new(),
            stance: String::new(),
            file: PathBuf::new(),
            plot: None,
            parameters: Vec::new(),
            least_stability: found.postures.iter().map(|p| p.stability).fold(f64::INFINITY, f64::min),
            least_stability_of_others: found.stability_of_others,
            standing_others: found.standing_others,
            least_gap: found.gap,
            joints: joints(standing, &found),
            margin: request.margin,
            mass_error: request.tolerance.mass,
            center_error: request.tolerance.center,
            seed: request.seed,
            stopped: found.stopped,
            postures: request.postures,
            runs: found.runs,
            best: found.best,
            placements: found.placements,
            assumptions: Vec::new(),
        }
    }

    /// One row for each start.
    fn starts(&self) -> String {
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
        table(&head, rows.collect(), 1)
    }

    /// One row for each joint.
    fn ranges(&self) -> String {
        let rows = self.joints.iter().map(|j| {
            vec![
                j.name.clone(),
                format!("{:.3} … {:.3}", j.position.0, j.position.1),
                format!("{:.3} … {:.3}", j.position_limits.0, j.position_limits.1),
            ]
        });
        table(&["joint", "position, rad", "limits"], rows.collect(), 1)
    }

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
        out.push_str(&self.starts());
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
        out.push_str(&self.ranges());
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
