//! Experiments that tell parameters and effects well: joint trajectories, static postures.
mod excited;
mod motion;
mod plot;
mod postures;
mod separate;

pub use motion::{DesignedMotion, FixedJoint, Joint, design_motion};
pub use postures::{PostureOptions, PostureSet, design_postures};
pub use separate::{Judged, SeparateOptions, SeparatingMotion, separate_effects};

use bipedc_analysis::identify::excite::{Basis, Machine, Request};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Output;
use std::fmt::Write as _;

/// Which joints move, within which limits beside those of the URDF, and what is looked for.
#[derive(Debug, Clone)]
pub struct Options {
    /// Names; none: all joints with an actuator.
    pub joints: Vec<String>,
    /// Largest acceleration of every joint, rad/s² or m/s².
    pub acceleration: Option<f64>,
    /// Least distance between the soles, m.
    pub gap: f64,
    /// Rows per second of the trajectory's file, Hz.
    pub rate: f64,
    /// Family of trajectories, duration, criterion, effort of the search.
    pub request: Request,
}

/// More rows than this are a mistake.
const ROWS: f64 = 1e7;

impl Options {
    /// Refuses numbers that have no meaning.
    ///
    /// # Errors
    /// Duration, rate or acceleration that are not above zero; more than ten million rows.
    pub fn check(&self) -> Result<(), Diagnostic> {
        let refuse = |what: &str, value: f64, help: &str| {
            Err(Diagnostic::error(format!("{what} is {value}")).help(help.to_owned()))
        };
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        let duration = self.request.duration;
        if !is_positive(duration) {
            return refuse("--duration", duration, "give a time above 0 s; 10 is usual");
        }
        if !is_positive(self.rate) {
            return refuse("--rate", self.rate, "give a frequency above 0 Hz");
        }
        if duration * self.rate > ROWS {
            return refuse("--rate times --duration", duration * self.rate, "give at most ten million rows");
        }
        match self.acceleration.filter(|limit| !is_positive(*limit)) {
            Some(limit) => refuse("--acceleration", limit, "give a number above 0 rad/s²"),
            None => Ok(()),
        }
    }

    /// Of the trajectory's file.
    fn rows(&self) -> usize {
        (self.request.duration * self.rate).round() as usize + 1
    }
}

/// The file with the trajectory in its place.
fn written(
    mut file: Output,
    (machine, basis, coefficients): (&Machine<'_>, &Basis, &[f64]),
    rows: usize,
) -> Result<(), Diagnostic> {
    file.put(&csv(machine, basis, coefficients, rows))?;
    file.commit()
}

/// The trajectory as a log: time and what every joint does.
fn csv(machine: &Machine<'_>, basis: &Basis, coefficients: &[f64], count: usize) -> String {
    let motion = machine.motion(basis, coefficients, count);
    let joints = &machine.layout.joints;
    let mut text = String::from("time");
    for joint in joints {
        let name = &joint.name;
        let _ = write!(text, ",{name}/position,{name}/velocity,{name}/acceleration");
    }
    text.push('\n');
    for i in 0..count {
        let _ = write!(text, "{:.9}", basis.duration() * i as f64 / (count.max(2) - 1) as f64);
        for at in i * joints.len()..(i + 1) * joints.len() {
            // Adding zero makes -0 a 0.
            let [q, v, a] = [motion.q[at], motion.v[at], motion.a[at]].map(|x| (x * 1e9).round() / 1e9 + 0.0);
            let _ = write!(text, ",{q:.9},{v:.9},{a:.9}");
        }
        text.push('\n');
    }
    text
}
