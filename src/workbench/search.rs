//! One search for a gait: near another one, from a given one, or from nothing with several beginnings at once.
use super::Workbench;
use super::optimised::Asked;
use crate::gait::optimise::{
    Demands, Optimum, Stage, first_step, from_gait, from_landing, from_neighbour, from_nothing,
};
use bipedc_analysis::nonlinear::{Ending, Iteration};
use bipedc_analysis::parallel::parallel;
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;
use std::ops::Range;
use std::sync::Mutex;

/// Where a search begins that has no neighbour.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum FirstGuess {
    /// Feet on straight lines with these lengths of the first steps, by their numbers, or the gait to begin from.
    Straight(Range<usize>),
    /// With a posture in which the landing of the toe pushes on all feet.
    Landing,
}

/// One of several beginnings of a search, and what it came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Beginning {
    /// Of the first steps, m.
    pub step: f64,
    /// Whether a motion was found that keeps everything.
    pub feasible: bool,
    /// What is made small, see [`Optimum::cost`].
    pub cost: f64,
    /// Of the motion, 1.
    pub cost_of_transport: f64,
    /// Whether the search goes on from there.
    pub kept: bool,
}

/// What a search came to.
pub(super) struct Searched {
    pub optimum: Optimum,
    /// Of all beginnings.
    pub iterations: usize,
    /// Empty where there was one alone.
    pub beginnings: Vec<Beginning>,
    /// Motions that were found from the others, with the numbers of their beginnings, the one that costs least last.
    pub others: Vec<(usize, Optimum)>,
}

impl From<Optimum> for Searched {
    fn from(optimum: Optimum) -> Self {
        Self { iterations: optimum.iterations, optimum, beginnings: Vec::new(), others: Vec::new() }
    }
}

/// Costs that are nearer than this part of them are those of one motion.
const SAME: f64 = 1e-3;

pub(super) fn is_found(optimum: &Optimum) -> bool {
    optimum.violations.is_empty() && matches!(optimum.ending, Ending::Minimum | Ending::Feasible)
}

/// The part of a search that is done.
fn part_done(stage: Stage, at: &Iteration) -> f64 {
    // From a barrier of 0.1 to one of 1e-7.
    let part = ((0.1 / at.barrier).log10() / 6.0).clamp(0.0, 1.0);
    if stage == Stage::Motion { 0.4 * part } else { 0.4 + 0.6 * part }
}

impl Workbench {
    /// One search, of which one may see how far it is, and which may be stopped.
    ///
    /// # Errors
    /// What is wrong with a given gait.
    pub(super) fn search(
        &self,
        asked: &Asked<'_>,
        demands: &Demands,
        near: Option<&Optimum>,
        guess: &FirstGuess,
    ) -> Result<Searched, Diagnostic> {
        let stage = format!("optimising for {} m/s", demands.speed);
        if near.is_none()
            && asked.seed.is_none()
            && let FirstGuess::Straight(beginnings) = guess
            && beginnings.len() > 1
        {
            return Ok(self.best_of(asked, demands, beginnings, &stage));
        }
        self.progress.counted(&stage, |advance| {
            let mut watch = |stage: Stage, at: &Iteration| {
                advance(part_done(stage, at));
                !(self.stop)()
            };
            if let Some(near) = near {
                return Ok(from_neighbour(asked.of, demands, near, &mut watch).into());
            }
            if *guess == FirstGuess::Landing
                && let Some(found) = from_landing(asked.of, demands, &mut watch)
            {
                return Ok(found.into());
            }
            match asked.seed {
                Some((gait, seed)) => {
                    from_gait(asked.of, demands, (gait, seed), &mut watch).map(Searched::from)
                }
                None => Ok(from_nothing(asked.of, demands, 0, &mut watch).into()),
            }
        })
    }

    /// Searches with several lengths of the first steps, on all cores; of those that found a motion the one that costs least, of equal ones the first.
    fn best_of(
        &self,
        asked: &Asked<'_>,
        demands: &Demands,
        beginnings: &Range<usize>,
        stage: &str,
    ) -> Searched {
        let count = beginnings.len();
        let parts = Mutex::new(vec![0.0_f64; count]);
        // Told under the lock, and never less than before: threads tell it in turn.
        let tell = |index: usize, part: f64| {
            let Ok(mut parts) = parts.lock() else { return };
            if part > parts[index] {
                parts[index] = part;
                self.progress.advance(parts.iter().sum::<f64>() / count as f64);
            }
        };
        self.progress.begin(stage, true);
        let found = parallel(count, |index| {
            from_nothing(asked.of, demands, beginnings.start + index, &mut |stage, at| {
                tell(index, part_done(stage, at));
                !(self.stop)()
            })
        });
        self.progress.end();
        chosen(asked, demands, found, beginnings.start)
    }
}

/// Of searches from several beginnings the one to go on from.
fn chosen(asked: &Asked<'_>, demands: &Demands, found: Vec<Optimum>, first: usize) -> Searched {
    let mut best = 0;
    for (index, other) in found.iter().enumerate() {
        let better = match (is_found(other), is_found(&found[best])) {
            (true, true) => other.cost < found[best].cost * (1.0 - SAME),
            (other, best) => other && !best,
        };
        best = if better { index } else { best };
    }
    let told = |(index, optimum): (usize, &Optimum)| Beginning {
        step: first_step(asked.of, demands, first + index),
        feasible: is_found(optimum),
        cost: optimum.cost,
        cost_of_transport: optimum.cost_of_transport(asked.of),
        kept: index == best && is_found(optimum),
    };
    let beginnings = found.iter().enumerate().map(told).collect();
    let iterations = found.iter().map(|optimum| optimum.iterations).sum();
    let mut others: Vec<(usize, Optimum)> = found.into_iter().enumerate().collect();
    let (_, optimum) = others.remove(best);
    let another = |cost: f64| (cost - optimum.cost).abs() > SAME * optimum.cost;
    others.retain(|(_, other)| is_found(other) && another(other.cost));
    others.sort_by(|a, b| b.1.cost.total_cmp(&a.1.cost));
    Searched { optimum, iterations, beginnings, others }
}
