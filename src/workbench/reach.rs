//! How near to a speed gaits are found: from a usual one step by step, each search from the motion before.
use super::Workbench;
use super::optimised::{Asked, OptimisedGait, Violated, described};
use super::search::{FirstGuess, is_found};
use crate::gait::optimise::{Demands, Optimum, Stage, from_nothing, size, solve};
use crate::simulation::Trial;
use bipedc_analysis::nonlinear::Iteration;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use serde::Serialize;
use std::fmt;
use std::time::Instant;

/// A usual speed, over √(g h).
const USUAL: f64 = 0.2;
/// Above this, over √(g h), searches from nothing end nowhere, and those that come from slower walks are tried first.
const FAST: f64 = 0.6;
/// Factor from one speed to the next.
const FACTOR: f64 = 1.3;
/// Speeds that are nearer than this are one.
const CLOSE: f64 = 0.04;
/// Iterations of a search from a motion at a speed nearby, before there is none there.
const BESIDE: usize = 40;
/// Iterations of a search from nothing at least, before none is found.
const PATIENCE: usize = 100;
/// Beginnings near a given gait at most.
const SEEDED: usize = 3;
/// Searches at most.
const MOST: usize = 24;

/// The nearest speed that a gait was found at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reach {
    /// There, m/s.
    pub speed: f64,
    /// The nearest to it at which none was found, m/s.
    pub beyond: f64,
    /// Limits that the motion at `speed` meets and a usual one (`usual`) does not; where there are none, all that it meets.
    pub limits: Vec<String>,
    /// Where the way began, m/s: a usual speed, or with --start the nearest at which a gait was found from there.
    pub usual: f64,
}

/// What a limit may be eased by.
const EASED: [(&str, &str); 6] = [
    ("torque of", "drives with larger efforts ([joint] limits of the URDF)"),
    ("speed of", "faster drives (velocity of the URDF's limits)"),
    ("stop of", "wider limits of joints (lower and upper of the URDF), a smaller --joints"),
    ("friction of", "a larger --friction"),
    ("length of the step", "a larger --longest-step"),
    ("clearance of", "a smaller --clearance"),
];

impl fmt::Display for Reach {
    /// The nearest speed, the limits there, and what eases them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { speed, beyond, limits, usual } = self;
        // Searches end at what lies near their beginning: that none was found is no proof that there is none.
        writeln!(
            f,
            "\nfrom {usual:.3} m/s on, the search came to {speed:.3} m/s; at {beyond:.3} m/s it found no gait, which is no proof that there is none: a --start from a gait at a speed \
             nearby, or another --longest-step, may come further"
        )?;
        if limits.is_empty() {
            return writeln!(f, "no single limit is met there");
        }
        writeln!(f, "limits that are met there, and not at {usual:.3} m/s: {}", limits.join(", "))?;
        let eased = EASED.iter().filter(|(begins, _)| limits.iter().any(|limit| limit.starts_with(begins)));
        let eased: Vec<&str> = eased.map(|(_, by)| *by).collect();
        if eased.is_empty() {
            return Ok(());
        }
        writeln!(f, "what may help: {}; or --speed {:.2}", eased.join("; "), floor(*speed, *usual))
    }
}

/// To two digits behind the point, towards a usual speed.
fn floor(speed: f64, usual: f64) -> f64 {
    let hundredths = 100.0 * speed;
    (if speed > usual { hundredths.floor() } else { hundredths.ceil() }) / 100.0
}

/// Where the way to a speed ends.
pub(super) enum Way {
    /// There.
    Reached(Box<Optimum>),
    /// Before it, with the last motion that was found.
    Ends(Reach, Box<Optimum>),
    /// Not even a usual speed is found, or it was stopped.
    Unknown,
}

/// Whether a speed (m/s) is rather come to from slower walks than searched for from nothing.
pub(super) fn is_fast(asked: &Asked<'_>, speed: f64) -> bool {
    speed > FAST * fall(asked)
}

/// √(g h), m/s.
fn fall(asked: &Asked<'_>) -> f64 {
    let [_, height, gravity] = size(asked.of);
    (gravity * height).sqrt()
}

/// What is told of a speed that was not come to: the nearest motion, and how much slower or faster it is.
fn short_of(asked: &Asked<'_>, last: &Optimum, (speed, reach): (f64, Reach)) -> OptimisedGait {
    let missed = Violated {
        constraint: "walking speed".to_owned(),
        phase: asked.of.phases[0].name.clone(),
        node: None,
        by: reach.speed - speed,
    };
    OptimisedGait {
        feasible: false,
        minimum: false,
        iterations: 0,
        violations: vec![missed],
        reach: Some(reach),
        ..described(asked.of, last, (speed, asked.options.wishes.demands(speed, size(asked.of)).impulse))
    }
}

/// Speeds at which the way to one may begin, m/s: a usual one; what is near a given gait is not known, and tried from the wished one on.
fn beginnings(asked: &Asked<'_>, wished: f64) -> Vec<f64> {
    let usual = USUAL * fall(asked);
    if asked.seed.is_none() {
        return vec![usual];
    }
    let factor = if wished > usual { FACTOR } else { FACTOR.recip() };
    let nearer = std::iter::successors(Some(wished / factor), |speed| Some(speed / factor));
    let nearer = nearer.take_while(|speed| (speed / usual).ln() * factor.ln() > CLOSE * CLOSE);
    nearer.take(SEEDED).chain([usual]).collect()
}

impl Workbench {
    /// A gait at one of the speeds, or the nearest speed that there is one at; none: stopped.
    pub(super) fn found_at(
        &self,
        asked: &Asked<'_>,
        trial: &Trial,
        index: usize,
        near: Option<&Optimum>,
    ) -> Result<Option<(OptimisedGait, Optimum)>, Diagnostics> {
        let begin = Instant::now();
        let speed = asked.options.speeds[index];
        let demands = asked.options.wishes.demands(speed, size(asked.of)).with_reserve();
        let mut iterations = 0;
        let first = match near.is_none() && asked.seed.is_none() && is_fast(asked, speed) {
            true => None,
            false => {
                let found = self.found_from(asked, trial, index, near)?;
                match found {
                    Some((ref gait, _)) if !gait.feasible => found,
                    _ => return Ok(found),
                }
            }
        };
        let found = match (self.way_to(asked, &demands, &mut iterations)?, first) {
            (Way::Reached(near), _) => self.found_from(asked, trial, index, Some(&near))?,
            (Way::Ends(reach, last), None) => Some((short_of(asked, &last, (speed, reach)), *last)),
            (Way::Ends(reach, _), Some((gait, last))) => {
                Some((OptimisedGait { reach: Some(reach), ..gait }, last))
            }
            (Way::Unknown, Some(first)) => return Ok(Some(first).filter(|_| !(self.stop)())),
            (Way::Unknown, None) => self.found_from(asked, trial, index, None)?,
        };
        Ok(found.map(|(gait, optimum)| {
            let (iterations, seconds) = (iterations + gait.iterations, begin.elapsed().as_secs_f64());
            (OptimisedGait { iterations, seconds, ..gait }, optimum)
        }))
    }

    /// From a usual speed towards that of `demands` by steps that get shorter where none is found; `iterations` counts on.
    ///
    /// # Errors
    /// As the first search.
    pub(super) fn way_to(
        &self,
        asked: &Asked<'_>,
        demands: &Demands,
        iterations: &mut usize,
    ) -> Result<Way, Diagnostic> {
        let at = |speed: f64| Demands { speed, ..demands.clone() };
        let mut begun = None;
        for speed in beginnings(asked, demands.speed) {
            let first = self.search(asked, &at(speed), None, &FirstGuess::Straight(0..1))?.optimum;
            *iterations += first.iterations;
            if is_found(&first) {
                begun = Some((speed, first));
                break;
            }
        }
        let Some((usual, first)) = begun else { return Ok(Way::Unknown) };
        let patience = PATIENCE.max(3 * first.iterations / 2);
        let begun = first.limits_met(asked.of, &at(usual));
        let whole = (demands.speed / usual).ln();
        let (mut now, mut done, mut step) = (first, 0.0, FACTOR.ln().copysign(whole));
        let mut beyond = demands.speed;
        for _ in 0..MOST {
            if (self.stop)() {
                return Ok(Way::Unknown);
            }
            let next = if (done + step).abs() < whole.abs() { done + step } else { whole };
            let speed = if next == whole { demands.speed } else { usual * next.exp() };
            let tried = self.near_by(asked, &at(speed), (&now, patience))?;
            *iterations += tried.iterations;
            if is_found(&tried) {
                (now, done) = (tried, next);
                if next == whole {
                    return Ok(Way::Reached(Box::new(now)));
                }
                continue;
            }
            beyond = speed;
            step = 0.5 * (next - done);
            if step.abs() < CLOSE {
                break;
            }
        }
        let speed = usual * done.exp();
        let met = now.limits_met(asked.of, &at(speed));
        let new: Vec<String> = met.iter().filter(|limit| !begun.contains(limit)).cloned().collect();
        let limits = if new.is_empty() { met } else { new };
        Ok(Way::Ends(Reach { speed, beyond, limits, usual }, Box::new(now)))
    }

    /// A search from a motion at another speed: with its multipliers some ten iterations do, or there is none nearby; then one from nothing, of `most`
    /// iterations, for what is near a slower walk may be in the way of a faster one.
    fn near_by(
        &self,
        asked: &Asked<'_>,
        demands: &Demands,
        (near, most): (&Optimum, usize),
    ) -> Result<Optimum, Diagnostic> {
        self.progress.counted(&format!("coming to {:.3} m/s", demands.speed), |advance| {
            let mut left = BESIDE;
            let watch = |left: &mut usize, at: &Iteration| {
                advance(((0.1 / at.barrier).log10() / 6.0).clamp(0.0, 1.0));
                *left = left.saturating_sub(1);
                *left > 0 && !(self.stop)()
            };
            let near = near.towards(demands.speed);
            let beside = solve(asked.of, demands, &near, Stage::Gait, &mut |_, at| watch(&mut left, at));
            if is_found(&beside) || (self.stop)() {
                return Ok(beside);
            }
            left = most;
            let mut anew = from_nothing(asked.of, demands, 0, &mut |_, at| watch(&mut left, at));
            anew.iterations += beside.iterations;
            Ok(anew)
        })
    }
}
