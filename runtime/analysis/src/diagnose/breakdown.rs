//! Where a model fails: the error of each row by what the robot was doing, against the measurement's noise, and what
//! is structured in it, in words.
use super::signature::{self, Feature};
use crate::experiments::jumps::Jumps;
use crate::experiments::moving::moving;
use crate::experiments::noise::noise_of;
use crate::experiments::signals::velocity_of;
use crate::experiments::{Experiment, Row};
use crate::number::counting;
use serde::Serialize;

/// Windows that a log is cut into.
pub const WINDOWS: usize = 8;
/// Below this fraction of its root mean square a speed counts as none.
const SLOW: f64 = 0.1;
/// Speeds below this count as none whatever the rest, rad/s (m/s).
const STILL: f64 = 1e-4;
/// A joint that is slow for longer stands, s; for shorter it reverses or hesitates.
const STANDING_S: f64 = 0.2;
/// Estimates of noise are good to some 5 %; an error within this factor of the noise is nothing but noise.
pub const AT_NOISE: f64 = 1.1;
/// An error in one state that exceeds that in its opposite by this factor is worth a word.
const UNEVEN: f64 = 1.5;

/// The error of a row over some of its samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BreakdownPart {
    /// Such as `reversing`, `velocity > 0` or `double support`.
    pub name: String,
    /// How many.
    pub samples: usize,
    /// Root mean square, unit of the row.
    pub rms: f64,
}

/// The error of a row from one time to another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Window {
    /// First time, s (number of the posture or impact in tables).
    pub from: f64,
    /// Last time.
    pub to: f64,
    /// How many.
    pub samples: usize,
    /// Root mean square, unit of the row.
    pub rms: f64,
}

/// Where one row's error lies. Its JSON keys are its field names and stay.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Breakdown {
    /// Of the row: `left_knee_pitch`, `base/force/z`.
    pub name: String,
    /// Kind of quantity: `effort`, `base_force`, …
    pub kind: &'static str,
    /// Of all errors.
    pub unit: String,
    /// Root mean square of measured minus predicted.
    pub rms: f64,
    /// The same without the samples at which the joint sticks; absent where it never does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_moving: Option<f64>,
    /// The same where nothing jumps by the description's effects and the joint does not stick; absent where nothing does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub away_from_jumps: Option<f64>,
    /// Largest absolute value of it.
    pub max: f64,
    /// Estimated noise of the measurement, one standard deviation.
    pub noise: f64,
    /// Fraction of the squared error (without sticking) beyond the noise.
    pub beyond_noise: f64,
    /// How many.
    pub samples: usize,
    /// `moving`, `reversing`, `standing`; empty for rows without a joint.
    pub motion: Vec<BreakdownPart>,
    /// `velocity > 0`, `velocity < 0`; empty for rows without a joint.
    pub direction: Vec<BreakdownPart>,
    /// Equal stretches of samples, the earliest first.
    pub windows: Vec<Window>,
    /// `left_foot alone`, `double support`, `just after impact`, …; empty where no foot forces tell.
    pub phases: Vec<BreakdownPart>,
    /// What the error goes with, the strongest first.
    pub signature: Vec<Feature>,
    /// All that in sentences.
    pub words: Vec<String>,
}

impl Breakdown {
    /// The error that is held against the noise: where the model says what the torque is, and the filter what the motion is.
    pub fn told(&self) -> f64 {
        self.away_from_jumps.or(self.rms_moving).unwrap_or(self.rms)
    }
}

/// Breaks down the error of every row of the nominal model.
pub fn breakdowns(experiment: &dyn Experiment) -> Vec<Breakdown> {
    let jumps = Jumps::of(experiment, &[]);
    (0..experiment.rows().len()).map(|row| breakdown(experiment, row, &jumps)).collect()
}

/// Breaks down the error of one row; `jumps` are those of the description's effects.
pub(crate) fn breakdown(experiment: &dyn Experiment, index: usize, jumps: &Jumps) -> Breakdown {
    let phases = &experiment.phases();
    let (row, residual, time) = (&experiment.rows()[index], experiment.residual(index), experiment.time());
    let velocity = row.joint.as_ref().and_then(|_| velocity_of(experiment, index));
    let (motion, direction) = match &velocity {
        Some(velocity) => {
            (parts(residual, &motion_states(velocity, time)), parts(residual, &direction_states(velocity)))
        }
        None => (Vec::new(), Vec::new()),
    };
    let phases = parts(residual, phases).into_iter();
    let noise = noise_of(experiment, index, residual);
    let mut breakdown = Breakdown {
        name: row.name.clone(),
        kind: row.channel.name(),
        unit: row.unit.to_owned(),
        rms: rms(residual.iter()),
        rms_moving: moving(experiment, index, residual, &|_, _| true).map(|moving| moving.rms()),
        away_from_jumps: jumps.away(experiment, index, residual, &|_, _| true),
        max: residual.iter().fold(0.0, |max, r| max.max(r.abs())),
        noise,
        beyond_noise: 0.0,
        samples: residual.len(),
        motion,
        direction,
        windows: windows(residual, time),
        phases: phases.filter(|part| part.samples > 0).collect(),
        signature: Vec::new(),
        words: Vec::new(),
    };
    if breakdown.told() > 0.0 {
        breakdown.beyond_noise = (1.0 - (noise / breakdown.told()).powi(2)).max(0.0);
    }
    if breakdown.told() > AT_NOISE * noise {
        breakdown.signature = signature::screen(experiment, index);
    }
    breakdown.words = sentences(row, &breakdown);
    breakdown
}

fn rms<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), x| (sum + x * x, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

fn part(name: &str, residual: &[f64], chosen: impl Fn(usize) -> bool) -> BreakdownPart {
    let values: Vec<f64> = (0..residual.len()).filter(|i| chosen(*i)).map(|i| residual[i]).collect();
    BreakdownPart { name: name.to_owned(), samples: values.len(), rms: rms(values.iter()) }
}

/// What a joint does at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    Moving,
    Reversing,
    Standing,
}

/// Slow stretches are reversals if the velocity changes sign in them, standing if they last.
fn doings(velocity: &[f64], time: &[f64]) -> Vec<Doing> {
    let slow = (SLOW * rms(velocity.iter())).max(STILL);
    let mut out = vec![Doing::Moving; velocity.len()];
    let mut i = 0;
    while i < velocity.len() {
        if velocity[i].abs() > slow {
            // Between two fast samples of opposite directions lies a reversal, however few samples show it.
            if i > 0 && velocity[i - 1].abs() > slow && velocity[i] * velocity[i - 1] < 0.0 {
                (out[i - 1], out[i]) = (Doing::Reversing, Doing::Reversing);
            }
            i += 1;
            continue;
        }
        let end = (i..velocity.len()).find(|k| velocity[*k].abs() > slow).unwrap_or(velocity.len());
        let turns = i > 0 && end < velocity.len() && velocity[i - 1] * velocity[end] < 0.0;
        let doing = if time[end - 1] - time[i] > STANDING_S {
            Doing::Standing
        } else if turns {
            Doing::Reversing
        } else {
            Doing::Moving
        };
        out[i..end].fill(doing);
        i = end;
    }
    out
}

/// Which samples show a joint moving, reversing, standing; shared by table and report.
pub(crate) fn motion_states(velocity: &[f64], time: &[f64]) -> Vec<(String, Vec<bool>)> {
    let doings = doings(velocity, time);
    let of = |doing: Doing| doings.iter().map(|d| *d == doing).collect();
    let names = [("moving", Doing::Moving), ("reversing", Doing::Reversing), ("standing", Doing::Standing)];
    names.map(|(name, doing)| (name.to_owned(), of(doing))).to_vec()
}

/// Which samples show a joint moving forwards, and which backwards.
pub(crate) fn direction_states(velocity: &[f64]) -> Vec<(String, Vec<bool>)> {
    let slow = (SLOW * rms(velocity.iter())).max(STILL);
    let of = |sign: f64| velocity.iter().map(|v| sign * v > slow).collect();
    vec![("velocity > 0".to_owned(), of(1.0)), ("velocity < 0".to_owned(), of(-1.0))]
}

fn parts(residual: &[f64], states: &[(String, Vec<bool>)]) -> Vec<BreakdownPart> {
    states.iter().map(|(name, chosen)| part(name, residual, |i| chosen[i])).collect()
}

fn windows(residual: &[f64], time: &[f64]) -> Vec<Window> {
    let count = residual.len();
    let limits = (0..WINDOWS).map(|w| (w * count / WINDOWS, (w + 1) * count / WINDOWS));
    let window = |(first, last): (usize, usize)| Window {
        from: time[first],
        to: time[last - 1],
        samples: last - first,
        rms: rms(residual[first..last].iter()),
    };
    limits.filter(|(first, last)| last > first).map(window).collect()
}

/// Sentences about one row, the most important first.
fn sentences(row: &Row, b: &Breakdown) -> Vec<String> {
    let name = &row.name;
    if b.rms <= AT_NOISE * b.noise {
        return vec![format!("{name}: nothing but noise is left")];
    }
    let mut words: Vec<String> = b.signature.iter().map(|feature| feature.sentence(name, row.unit)).collect();
    if let (Some(worst), true) =
        (b.windows.iter().max_by(|x, y| x.rms.total_cmp(&y.rms)), b.windows.len() > 1)
        && worst.rms > UNEVEN * median(b.windows.iter().map(|w| w.rms))
        && worst.rms > AT_NOISE * b.noise
    {
        words.push(format!(
            "{name}: the error is largest from {:.3} to {:.3}: {} {}",
            worst.from,
            worst.to,
            short(worst.rms),
            b.unit
        ));
    }
    for parts in [&b.direction, &b.motion, &b.phases] {
        words.extend(uneven(name, parts, b));
    }
    if words.is_empty() {
        words.push(format!(
            "{name}: the error is {} times the noise, without a structure that this screen knows",
            short(b.rms / b.noise)
        ));
    }
    words
}

/// The part with the largest error, if it is much larger than the smallest one.
fn uneven(name: &str, parts: &[BreakdownPart], b: &Breakdown) -> Option<String> {
    // Few samples have any error by chance.
    let few = (b.samples / 50).max(20);
    let counted = || parts.iter().filter(|part| part.samples >= few);
    let most = counted().max_by(|x, y| x.rms.total_cmp(&y.rms))?;
    let least = counted().min_by(|x, y| x.rms.total_cmp(&y.rms))?;
    let telling = most.rms > UNEVEN * least.rms && most.rms > AT_NOISE * b.noise;
    telling.then(|| {
        format!(
            "{name}: {} {} ({}), {} {} ({})",
            short(most.rms),
            b.unit,
            most.name,
            short(least.rms),
            b.unit,
            least.name
        )
    })
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Three digits that count.
pub(super) fn short(value: f64) -> String {
    counting(value, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_stretches_are_told_apart() {
        let time: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.02).collect();
        let mut velocity = vec![1.0; 100];
        velocity[20..24].copy_from_slice(&[0.05, 0.0, -0.01, -0.05]);
        velocity[24..40].fill(-1.0);
        velocity[40..70].fill(0.0);
        velocity[80] = 0.02;
        velocity[90..].fill(-1.0);
        let doings = doings(&velocity, &time);
        assert!(doings[20..24].iter().all(|d| *d == Doing::Reversing));
        assert!(doings[40..70].iter().all(|d| *d == Doing::Standing));
        assert_eq!(doings[80], Doing::Moving, "a hesitation is no reversal");
        assert_eq!(doings[89..91], [Doing::Reversing; 2], "a jump is one");
    }

    #[test]
    fn windows_cover_everything_once() {
        let residual: Vec<f64> = (0..21).map(f64::from).collect();
        let windows = windows(&residual, &residual);
        assert_eq!(windows.iter().map(|w| w.samples).sum::<usize>(), 21);
        assert_eq!((windows[0].from, windows[7].to), (0.0, 20.0));
        assert!(super::windows(&[1.0, 2.0], &[0.0, 1.0]).len() == 2);
    }
}
