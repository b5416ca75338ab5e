//! Springs and play behind motors' encoders: which effects are left once the motion of their links is computed exactly.
//!
//! Where the motor's angle alone is measured, a spring moves the whole chain behind it. The search draws a straight line from the
//! stiffness at which it looked, and whatever that leaves other effects make up for: in one log 80 N m/rad at a knee and an offset for
//! a hip whose spring has 103 N m/rad instead of the 128 at which it was sought. Estimated all at once they keep each other
//! where they are. So the effects that were found stand in line once more, each estimated exactly beside those before it.
use super::amended::Amended;
use super::estimates::{data, estimates, spread};
use super::refinement::refine;
use super::regression::Regression;
use super::search::{Outcome, mistimes};
use super::significance::without_sticking;
use crate::experiments::corners::landings_in_legs;
use crate::experiments::{Channel, Experiment};
use bipedc_effects::effect::{Acts, Effect};

/// Beside play in a leg on the ground errors beyond so many times the noise count by their size, and not by its square: beside a stop that was
/// met otherwise, a link is half a gap or more away from where it is taken to be.
const FORGIVEN: f64 = 3.0;

/// Leaves those effects in `outcome` that lower the exact held-out error by more than they cost, beginning with what lies behind a
/// motor. Others are as they were.
pub(super) fn stand_in_line(
    regression: &Regression<'_>,
    outcome: &mut Outcome,
    teaches: &(dyn Fn(usize, usize) -> bool + Sync),
) {
    let standing = regression.standing.len();
    let found: Vec<usize> = (standing..outcome.active.len()).collect();
    let hidden: Vec<usize> =
        found.iter().copied().filter(|&k| is_behind_motor(regression, outcome.active[k])).collect();
    if hidden.is_empty() || found.len() < 2 {
        return;
    }
    let starts = estimates(regression, outcome);
    let always: Vec<usize> = (0..standing).collect();
    // How a link meets its stops no law tells: nothing is to stand for that.
    let jumps = landings_in_legs(regression.judge, &starts);
    let cost = |kept: &[usize]| exact_cost(regression, outcome, (&starts, kept), (teaches, &jumps));
    let cheapest = |tried: &[usize], beside: &[usize]| {
        let with = |k: usize| [beside, &[k]].concat();
        let costs = tried.iter().map(|&k| (with(k), cost(&with(k))));
        costs.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let Some((mut kept, mut least)) = cheapest(&hidden, &always) else { return };
    let confused = |a: usize, b: usize| mistimes(regression, outcome.active[a], outcome.active[b]);
    loop {
        let may_stand = |k: &usize| !kept.contains(k) && !kept.iter().any(|&stands| confused(stands, *k));
        let others: Vec<usize> = found.iter().copied().filter(may_stand).collect();
        let Some((more, lower)) = cheapest(&others, &kept).filter(|(_, lower)| *lower < least) else { break };
        (kept, least) = (more, lower);
    }
    kept.sort_unstable();
    let active: Vec<usize> = kept.iter().map(|&k| outcome.active[k]).collect();
    if active.len() == outcome.active.len() {
        return;
    }
    // As good as all of them, or the line was the wrong one.
    let all: Vec<usize> = (0..outcome.active.len()).collect();
    let is_confused = all.iter().any(|&a| all.iter().any(|&b| confused(a, b)));
    if !is_confused && least >= cost(&all) {
        return;
    }
    if let Some(scored) = regression.scored_fit(&active, outcome.corrected) {
        (outcome.active, outcome.scored) = (active, scored);
    }
}

/// The square of an error, which grows with its size beyond a limit, as Huber's.
fn forgiving_square(error: f64, limit: f64) -> f64 {
    let size = error.abs();
    if size > limit { limit * (2.0 * size - limit) } else { size * size }
}

/// Whether a candidate lies between a motor and a link of which nobody measured the angle: its torque shows it.
pub(super) fn is_behind_motor(regression: &Regression<'_>, c: usize) -> bool {
    let candidate = &regression.candidates[c];
    candidate.form.kind.law.acts() == Acts::Transmission
        && candidate.rows.iter().all(|&row| regression.train.rows()[row].channel != Channel::Transmission)
}

/// Weighted held-out squares of the `kept` ones of the effects, estimated exactly, and what they cost.
fn exact_cost(
    regression: &Regression<'_>,
    outcome: &Outcome,
    (starts, kept): (&[Effect], &[usize]),
    (teaches, jumps): (&(dyn Fn(usize, usize) -> bool + Sync), &[bool]),
) -> f64 {
    let effects = kept.iter().map(|&k| starts[k].clone()).collect();
    let active: Vec<usize> = kept.iter().map(|&k| outcome.active[k]).collect();
    exact_deviance(regression, outcome.corrected, effects, (teaches, jumps))
        + regression.complexity_penalty(&active)
}

/// Weighted held-out squares of effects that are estimated exactly, with the prior of what is corrected beside them; samples where links meet
/// their stops (`jumps`) do not count.
pub(super) fn exact_deviance(
    regression: &Regression<'_>,
    corrected: bool,
    effects: Vec<Effect>,
    (teaches, jumps): (&(dyn Fn(usize, usize) -> bool + Sync), &[bool]),
) -> f64 {
    let refined = refine(data(regression, teaches), effects, &[], spread(regression, corrected));
    let mut amended = Amended::new(regression.judge, &refined.effects);
    let change = regression.spread.change(&refined.corrections);
    if !change.is_empty() {
        amended.correct(&change);
    }
    let squares = |row: usize| -> f64 {
        let away = |i: usize| !jumps.get(i).is_some_and(|jumps| *jumps);
        let told = without_sticking(regression.judge, row, amended.residual(row), away);
        let limit =
            if jumps.is_empty() { f64::INFINITY } else { FORGIVEN * regression.judge.rows()[row].noise };
        told.map(|x| forgiving_square(x, limit)).sum::<f64>() * regression.weights[row]
    };
    let prior: f64 = refined.corrections.iter().map(|x| x * x).sum();
    (0..regression.judge.rows().len()).map(squares).sum::<f64>() + prior
}
