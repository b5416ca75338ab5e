//! Joint trajectories from which parameters can be identified well (thesis 5.16).
use super::excited::Excited;
use super::{Options, written};
use crate::progress::Run;
use crate::table::table;
use bipedc_analysis::identify::excite::{
    Designed, Early, Family, Limits, Machine, MotionQuality, Peaks, Request, design,
};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::files::Output;
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// A trajectory that was designed and written. As text and as JSON it is what `bipedc excite` prints.
#[derive(Debug, Serialize)]
pub struct DesignedMotion {
    robot: String,
    file: PathBuf,
    rows: usize,
    trajectory: &'static str,
    /// Harmonics or degree.
    order: usize,
    duration: f64,
    base_parameters: usize,
    /// Of the best random start.
    pub before: MotionQuality,
    /// Of the trajectory: condition numbers, information.
    pub after: MotionQuality,
    joints: Vec<Joint>,
    /// Positions of joints that do not move.
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
}

/// How near a joint comes to its limits.
#[derive(Debug, Serialize)]
pub struct Joint {
    name: String,
    position: (f64, f64),
    position_limits: (f64, f64),
    velocity: f64,
    velocity_limit: Option<f64>,
    acceleration: f64,
    acceleration_limit: Option<f64>,
    effort: f64,
    effort_limit: Option<f64>,
    effort_unit: &'static str,
}

/// A joint that does not move.
#[derive(Debug, Serialize)]
pub struct FixedJoint {
    name: String,
    position: f64,
}

/// Looks for the trajectory of the moving joints whose regressor has the smallest condition number and writes it to `out`.
///
/// # Errors
/// A robot whose base is not fixed, joints without limits that they need, limits that leave nothing.
pub fn design_motion(
    robot: &Robot,
    options: &Options,
    out: &Path,
    run: &Run<'_>,
) -> Result<DesignedMotion, Diagnostics> {
    options.check()?;
    let derive = || Excited::new(robot, &options.joints, options.acceleration, options.gap);
    let mut excited = run.progress.stage("deriving", derive)?;
    let assumptions = excited.assumptions.clone();
    let machine = excited.machine();
    // Whether the file can be written shows before the search, not after it.
    let file = Output::create(out)?;
    let request = &options.request;
    let search = |progress: &dyn Fn(f64)| design(&machine, request, progress, run.stop);
    let found = run.progress.counted("searching", search)?;
    let rows = options.rows();
    written(file, (&machine, &found.basis, &found.coefficients), rows)?;
    let name = &robot.description.name;
    Ok(DesignedMotion::new(name, &machine, request, &found, &assumptions).with_file(out, rows))
}

impl DesignedMotion {
    /// Without the file.
    fn new(
        robot: &str,
        machine: &Machine<'_>,
        request: &Request,
        found: &Designed,
        assumed: &[String],
    ) -> Self {
        let (trajectory, order) = family(request.family);
        Self {
            robot: robot.to_owned(),
            file: PathBuf::new(),
            rows: 0,
            trajectory,
            order,
            duration: request.duration,
            base_parameters: found.unknowns,
            before: found.before,
            after: found.after,
            joints: Joint::all(machine, &found.peaks),
            held: FixedJoint::all(machine),
            feet_distance: found.feet_distance,
            margin: request.margin,
            seed: request.seed,
            starts: found.starts,
            evaluations: found.evaluations,
            out_of_time: found.early == Some(Early::OutOfTime),
            interrupted: found.early == Some(Early::Interrupted),
            assumptions: assumed.to_vec(),
        }
    }

    /// Where the trajectory went.
    fn with_file(mut self, file: &Path, rows: usize) -> Self {
        (self.file, self.rows) = (file.to_path_buf(), rows);
        self
    }
}

impl fmt::Display for DesignedMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for assumption in &self.assumptions {
            writeln!(f, "assumed: {assumption}")?;
        }
        for held in &self.held {
            writeln!(f, "{held}")?;
        }
        let kind = family_words(self.trajectory, self.order);
        writeln!(f, "{} s of {kind}; {} base parameters", self.duration, self.base_parameters)?;
        writeln!(
            f,
            "condition number {:.1} (random start: {:.1}), in SI units {:.1} ({:.1}); ln det of the information {:.1} ({:.1})",
            self.after.condition_number,
            self.before.condition_number,
            self.after.unscaled_condition_number,
            self.before.unscaled_condition_number,
            self.after.log_determinant,
            self.before.log_determinant
        )?;
        writeln!(f, "{} starts, {} evaluations, seed {}\n", self.starts, self.evaluations, self.seed)?;
        f.write_str(&Joint::table(&self.joints))?;
        for (ended, early) in [(self.out_of_time, Early::OutOfTime), (self.interrupted, Early::Interrupted)] {
            if ended {
                writeln!(f, "\nwarning: {early}: another run with this seed may give another motion")?;
            }
        }
        writeln!(f, "\n{}", last_words(self.rows, &self.file, self.feet_distance))
    }
}

/// Where the motion went, and what was not looked at.
pub fn last_words(rows: usize, file: &Path, feet_distance: Option<f64>) -> String {
    let checked = feet_distance.map_or_else(
        || "collisions were not checked".to_owned(),
        |distance| {
            format!("soles at least {:.1} mm apart, other collisions were not checked", 1e3 * distance)
        },
    );
    format!("{rows} rows in {}; {checked}: try it slowly first", file.display())
}

/// As in JSON, with its order.
pub fn family(family: Family) -> (&'static str, usize) {
    match family {
        Family::Polynomial(degree) => ("polynomial", degree),
        Family::RestingPolynomial(degree) => ("resting_polynomial", degree),
        Family::Fourier(harmonics) => ("fourier", harmonics),
    }
}

/// The same for people.
pub fn family_words(trajectory: &str, order: usize) -> String {
    match trajectory {
        "fourier" => format!("Fourier series with {order} harmonics, at rest at both ends"),
        "resting_polynomial" => format!("polynomials of degree {order}, at rest at both ends"),
        _ => format!("polynomials of degree {order}, in motion at both ends"),
    }
}

impl FixedJoint {
    /// Those that do not move.
    pub fn all(machine: &Machine<'_>) -> Vec<Self> {
        let described = &machine.layout.joints;
        let held = (0..described.len()).filter(|joint| !machine.moving.contains(joint));
        held.map(|k| Self { name: described[k].name.clone(), position: machine.posture[k] }).collect()
    }
}

impl fmt::Display for FixedJoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "held: `{}` at {:.4}", self.name, self.position)
    }
}

impl Joint {
    /// Those that move.
    pub fn all(machine: &Machine<'_>, peaks: &[Peaks]) -> Vec<Self> {
        let finite = |limit: f64| Some(limit).filter(|limit| limit.is_finite());
        let described = &machine.layout.joints;
        let joint = |((&joint, limits), peaks): ((&usize, &Limits), &Peaks)| Self {
            name: described[joint].name.clone(),
            position: peaks.position,
            position_limits: limits.position,
            velocity: peaks.velocity,
            velocity_limit: finite(limits.velocity),
            acceleration: peaks.acceleration,
            acceleration_limit: finite(limits.acceleration),
            effort: peaks.effort,
            effort_limit: finite(limits.effort),
            effort_unit: described[joint].unit(),
        };
        machine.moving.iter().zip(machine.limits).zip(peaks).map(joint).collect()
    }

    /// One row each.
    pub fn table(joints: &[Self]) -> String {
        let head = [
            "joint",
            "position, rad",
            "limits",
            "velocity, rad/s",
            "limit",
            "acceleration, rad/s²",
            "limit",
            "effort, N m",
            "limit",
            "used",
        ];
        let mut text = table(&head, joints.iter().map(Self::row).collect(), 1);
        if joints.iter().any(|joint| joint.effort_unit == "N") {
            text.push_str("joints that slide: m, m/s, m/s², N\n");
        }
        text
    }

    fn row(&self) -> Vec<String> {
        let limit = |limit: Option<f64>| limit.map_or_else(|| "-".to_owned(), |limit| format!("{limit:.2}"));
        vec![
            self.name.clone(),
            format!("{:.3} … {:.3}", self.position.0, self.position.1),
            format!("{:.3} … {:.3}", self.position_limits.0, self.position_limits.1),
            format!("{:.2}", self.velocity),
            limit(self.velocity_limit),
            format!("{:.2}", self.acceleration),
            limit(self.acceleration_limit),
            format!("{:.2}", self.effort),
            limit(self.effort_limit),
            format!("{:.0} %", 100.0 * self.used()),
        ]
    }

    /// The part of the nearest limit that is used.
    fn used(&self) -> f64 {
        let (low, high) = self.position_limits;
        let (center, room) = (0.5 * (low + high), 0.5 * (high - low));
        let position = (self.position.1 - center).max(center - self.position.0) / room;
        let part = |peak: f64, limit: Option<f64>| limit.map_or(0.0, |limit| peak / limit);
        position
            .max(part(self.velocity, self.velocity_limit))
            .max(part(self.acceleration, self.acceleration_limit))
            .max(part(self.effort, self.effort_limit))
    }
}
