//! Which physical causes the forces of the ground cannot tell apart.
use crate::experiments::{Channel, Experiment};
use bipedc_effects::effect::{Effect, Kind, Location, Size, kinds};
use serde::Serialize;

/// Causes whose marks are more alike than this cannot be told apart.
const ALIKE: f64 = 0.95;
/// Causes that explain less than this part of the squared error alone are not worth a name.
const WORTH: f64 = 0.05;

/// One cause, estimated as if nothing else were wrong.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Kind of effect (robots/README.md).
    pub kind: &'static Kind,
    /// Its parameter.
    pub parameter: &'static str,
    /// Link or joint that it is at.
    pub place: Option<String>,
    /// Rows that it marks.
    pub rows: Vec<String>,
    /// Estimate.
    pub value: f64,
    /// Unit of the estimate.
    pub unit: &'static str,
    /// Part of the squared error (in units of each row's spread) that it explains alone.
    pub explains: f64,
}

/// Two causes that leave the same mark.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// Indices among the causes.
    pub causes: [usize; 2],
    /// Cosine of the angle between their marks: 1 or -1 is the same mark.
    pub likeness: f64,
}

/// Causes that were tried, and those that cannot be told apart.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Confounded {
    /// In the order of how much they explain.
    pub causes: Vec<Cause>,
    /// Pairs of them.
    pub pairs: Vec<Pair>,
    /// Pairs that the force rows alone cannot tell apart, where moments were measured too.
    pub pairs_in_forces: Vec<Pair>,
}

/// A parameter that is tried, with a step that is small against what is usual; at the root link, or everywhere.
struct TriedCause {
    kind: &'static Kind,
    parameter: &'static str,
    step: f64,
    at_root: bool,
}

const fn at_root(kind: &'static Kind, parameter: &'static str, step: f64) -> TriedCause {
    TriedCause { kind, parameter, step, at_root: true }
}

const fn everywhere(kind: &'static Kind, parameter: &'static str, step: f64) -> TriedCause {
    TriedCause { kind, parameter, step, at_root: false }
}

/// What ground forces might show.
static TRIALS: [TriedCause; 9] = [
    at_root(&kinds::PAYLOAD, "mass", 0.01),
    at_root(&kinds::COM_OFFSET, "x", 1e-3),
    at_root(&kinds::COM_OFFSET, "y", 1e-3),
    everywhere(&kinds::GRAVITY_TILT, "roll", 1e-3),
    everywhere(&kinds::GRAVITY_TILT, "pitch", 1e-3),
    everywhere(&kinds::FORCE_SENSOR_GAIN, "gain", 1e-3),
    everywhere(&kinds::FORCE_SENSOR_BIAS, "x", 0.1),
    everywhere(&kinds::FORCE_SENSOR_BIAS, "y", 0.1),
    everywhere(&kinds::FORCE_SENSOR_BIAS, "z", 0.1),
];

impl TriedCause {
    /// Its value where there is no such cause.
    fn neutral(&self) -> f64 {
        match self.kind.parameter(self.parameter).map(|parameter| parameter.size) {
            Some(Size::NothingAt(value)) => value,
            _ => 0.0,
        }
    }

    fn unit(&self) -> &'static str {
        self.kind.parameter(self.parameter).map_or("1", |parameter| parameter.unit)
    }
}

/// Tries every cause on the rows of these kinds; `root` is the link that carries the base.
///
/// Each row counts in units of its own spread about zero, so that forces and moments weigh alike. An effect's response
/// is taken as linear about nothing: what is asked is which marks are alike, not what is missing.
pub fn confounded(experiment: &dyn Experiment, channels: &[Channel], root: &str) -> Confounded {
    let rows: Vec<usize> =
        (0..experiment.rows().len()).filter(|&r| channels.contains(&experiment.rows()[r].channel)).collect();
    let weights: Vec<f64> = rows.iter().map(|&r| 1.0 / spread(experiment.residual(r))).collect();
    let residual: Vec<f64> = rows
        .iter()
        .zip(&weights)
        .flat_map(|(&r, w)| experiment.residual(r).iter().map(move |x| w * x))
        .collect();
    let total = dot(&residual, &residual);
    let mut found: Vec<(Cause, Vec<f64>)> = Vec::new();
    for trial in &TRIALS {
        let mark = mark(experiment, trial, root, (&rows, &weights));
        let size = dot(&mark, &mark);
        if !(size > 0.0 && size.is_finite() && total > 0.0) {
            continue;
        }
        let value = dot(&mark, &residual) / size;
        let cause = Cause {
            kind: trial.kind,
            parameter: trial.parameter,
            place: trial.at_root.then(|| root.to_owned()),
            rows: marked(experiment, &rows, &mark),
            value: trial.neutral() + value,
            unit: trial.unit(),
            explains: value * value * size / total,
        };
        if cause.explains >= WORTH {
            found.push((cause, mark));
        }
    }
    found.sort_by(|a, b| b.0.explains.total_cmp(&a.0.explains));
    let marks: Vec<&[f64]> = found.iter().map(|(_, mark)| mark.as_slice()).collect();
    let count = experiment.time().len().max(1);
    let is_force = |row: usize| experiment.rows()[row].channel == Channel::BaseForce;
    let forces = |mark: &[f64]| -> Vec<f64> {
        let parts = mark.chunks_exact(count).zip(&rows).filter(|(_, row)| is_force(**row));
        parts.flat_map(|(part, _)| part.to_vec()).collect()
    };
    let mixed = rows.iter().any(|row| is_force(*row)) && !rows.iter().all(|row| is_force(*row));
    let of_forces: Vec<Vec<f64>> = marks.iter().filter(|_| mixed).map(|mark| forces(mark)).collect();
    let of_forces: Vec<&[f64]> = of_forces.iter().map(Vec::as_slice).collect();
    let (pairs, pairs_in_forces) = (alike(&marks), alike(&of_forces));
    Confounded { pairs, pairs_in_forces, causes: found.into_iter().map(|(cause, _)| cause).collect() }
}

/// Pairs of marks that differ by a factor, nearly.
fn alike(marks: &[&[f64]]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, a) in marks.iter().enumerate() {
        for (j, b) in marks.iter().enumerate().skip(i + 1) {
            let likeness = dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
            // A cause that leaves no mark here is like nothing (the likeness is no number then).
            if likeness.abs() > ALIKE {
                pairs.push(Pair { causes: [i, j], likeness });
            }
        }
    }
    pairs
}

/// How the rows change with a unit of a cause, in units of their spread.
fn mark(
    experiment: &dyn Experiment,
    trial: &TriedCause,
    root: &str,
    (rows, weights): (&[usize], &[f64]),
) -> Vec<f64> {
    let place = if trial.at_root { Location::link(root) } else { Location::default() };
    let effect = Effect::new(trial.kind, place, &[(trial.parameter, trial.neutral() + trial.step)]);
    let response = experiment.response(&[effect]);
    let count = experiment.time().len();
    rows.iter()
        .zip(weights)
        .flat_map(|(row, weight)| {
            let own = response.iter().find(|(r, _)| r == row).map(|(_, values)| values);
            (0..count).map(move |i| own.map_or(0.0, |values| weight * values[i] / trial.step))
        })
        .collect()
}

/// Rows that carry most of a mark.
fn marked(experiment: &dyn Experiment, rows: &[usize], mark: &[f64]) -> Vec<String> {
    let count = experiment.time().len().max(1);
    let sizes: Vec<f64> = mark.chunks_exact(count).map(|part| dot(part, part)).collect();
    let most = sizes.iter().copied().fold(0.0, f64::max);
    let named = rows.iter().zip(&sizes).filter(|(_, size)| **size > 0.1 * most);
    named.map(|(&row, _)| experiment.rows()[row].name.clone()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn spread(values: &[f64]) -> f64 {
    (dot(values, values) / values.len().max(1) as f64).sqrt().max(f64::MIN_POSITIVE.sqrt())
}

impl Cause {
    /// `gravity_tilt pitch 0.093 rad`.
    pub fn words(&self) -> String {
        let place = self.place.as_ref().map_or_else(String::new, |place| format!(" at {place}"));
        format!("{} {}{place} {:.4} {}", self.kind, self.parameter, self.value, self.unit)
    }
}
