//! The final estimate by Gauss–Newton: all parameters of all effects at once, with everything nonlinear, and error bars.
use super::amended::Amended;
use super::uncertainty::uncertainty;
use super::unknowns::{Unknown, apply, jacobian, largest_move, unknowns, with_nuisances};
use crate::diagnose::engine::equations::block_equations::{BlockEquations, Spread, block_equations};
use crate::diagnose::engine::equations::fit::{Corrections, Fit, NormalEquations, Term, TermProducts, fit};
use crate::experiments::corners::{
    Corners, FARTHEST, NEAR_CORNERS, NEAREST, corners_within, departures, inexactness, landings_in_legs,
    sharpened,
};
use crate::experiments::form::Column;
use crate::experiments::{Channel, Experiment};
use crate::parallel::parallel;
use bipedc_effects::effect::{Effect, Role, Simulation};
use nalgebra::DMatrix;

/// Blocks of time whose scores make the error bars.
pub(crate) const BLOCKS: usize = 24;
/// 97.5 % point of Student's t with 23 degrees of freedom.
pub(crate) const T: f64 = 2.069;
/// Most steps.
const STEPS: usize = 20;
/// Moves of all parameters by less than this part of them are none.
const NEGLIGIBLE: f64 = 1e-4;
/// A move that is no smaller than this part of the one before does not come to rest.
const STALLED: f64 = 0.97;
/// Such moves, one after the other, after which nothing is waited for.
const STAYS: usize = 2;
/// So many steps choose anew which samples lie at corners; afterwards the choice stands, so that the estimate comes to rest.
const SETTLING: usize = 4;

/// Jumps are told from samples so far away from the corners that nothing rings there. Where that leaves so little that scatter is this many times what
/// rings nearer by, an estimate from nearer samples is made too, and the data that judge say which one it is: between two reversals friction is a
/// constant, as much of what free inertias do is.
const STARVED: f64 = 2.0;

/// So often a limit that came to the end of its reach is looked for further on.
const FURTHER: usize = 3;
/// Errors of the data that judge that differ by no more are alike.
const ALIKE: f64 = 1.001;

/// An interval that is so many times as wide as what it is of is none.
const RAN_AWAY: f64 = 1e6;

/// Half widths of 95 % confidence intervals, by effect and parameter.
pub(crate) type HalfWidths = Vec<Vec<(String, f64)>>;

/// Effects with their final parameters.
pub(crate) struct Refined {
    pub effects: Vec<Effect>,
    /// How sure they are.
    pub half_width: HalfWidths,
    /// Inertial corrections as multiples of the spread; empty if there are none.
    pub corrections: Vec<f64>,
    /// Their covariance, effects estimated along: the unit matrix where data tell nothing.
    pub covariance: DMatrix<f64>,
}

/// What estimates are made from.
#[derive(Clone, Copy)]
pub(crate) struct Data<'a> {
    pub experiment: &'a dyn Experiment,
    /// One per row.
    pub weights: &'a [f64],
    /// Whether a sample (of how many) counts.
    pub teaches: &'a (dyn Fn(usize, usize) -> bool + Sync),
    /// The data that judge, of the same rows, and whether a sample (of how many) does.
    pub judge: &'a dyn Experiment,
    pub judges: fn(usize, usize) -> bool,
    /// Parameters that keep their values: of which effect, and names.
    pub held: &'a [(usize, String)],
    /// Samples at corners count as others do, but for those near a rest.
    pub at_corners: bool,
}

impl Data<'_> {
    /// What is estimated of effects.
    fn unknowns(&self, effects: &[Effect]) -> Vec<Unknown> {
        let mut all = unknowns(effects);
        all.retain(|u| !self.held.iter().any(|(effect, name)| *effect == u.effect && *name == u.name));
        all
    }
}

/// Gauss–Newton from the search's estimate, with inertial corrections as far as they spread, if they do. Effects that are
/// `fixed` act and are not estimated.
pub(crate) fn refine(
    data: Data<'_>,
    effects: Vec<Effect>,
    fixed: &[Effect],
    spread: Option<&Spread>,
) -> Refined {
    let wanted = effects.len();
    let mut stated = with_nuisances(data.experiment, effects);
    let mut unknowns = data.unknowns(&stated);
    let own = stated.len();
    stated.extend_from_slice(fixed);
    let mut best = best_estimate(data, &stated, &unknowns, spread);
    for _ in 0..FURTHER {
        let Some((on, next)) = further(data, (&best, &unknowns), own, spread) else { break };
        (unknowns, best) = (on, next);
    }
    while let Some(idle) = idle_term(&unknowns, &best.refined) {
        let Unknown { effect, name, .. } = unknowns.remove(idle);
        stated = best.refined.effects;
        stated[effect].parameters.insert(name, 0.0);
        best = best_estimate(data, &stated, &unknowns, spread);
    }
    best.refined.effects.truncate(wanted);
    best.refined.half_width.truncate(wanted);
    best.refined
}

/// The one of two estimates of the same effects that leaves less of the data that judge.
pub(crate) fn likelier(data: Data<'_>, spread: Option<&Spread>, [one, other]: [Refined; 2]) -> Refined {
    let [of_one, of_other] = [&one, &other].map(|refined| {
        let corners = corners_of(data.judge, &refined.effects, NEAREST);
        judged_error(data, &corners, refined, spread)
    });
    // An estimate that ran away may leave what is no number.
    if of_one <= of_other || !of_other.is_finite() { one } else { other }
}

/// Where a limit came to the end of its reach: the estimate from there, if the data that judge prefer it. `own` effects are estimated.
fn further(
    data: Data<'_>,
    (best, unknowns): (&Estimate, &[Unknown]),
    own: usize,
    spread: Option<&Spread>,
) -> Option<(Vec<Unknown>, Estimate)> {
    let found = &best.refined.effects;
    let stands = |unknown: &Unknown| {
        let effect = &found[unknown.effect];
        let has_reach = effect.kind.parameter(&unknown.name).is_some_and(|p| p.reach.is_some());
        let value = effect.value(&unknown.name);
        has_reach && (value == unknown.bounds.0 || value == unknown.bounds.1)
    };
    unknowns.iter().any(stands).then_some(())?;
    let on = data.unknowns(&found[..own]);
    let next = best_estimate(data, found, &on, spread);
    let corners = corners_of(data.judge, &next.refined.effects, NEAREST);
    let error = |estimate: &Estimate| judged_error(data, &corners, &estimate.refined, spread);
    (error(&next) < ALIKE * error(best)).then_some((on, next))
}

/// A term of a coupling, of several, whose interval holds zero: the one that this data tells least.
fn idle_term(unknowns: &[Unknown], found: &Refined) -> Option<usize> {
    let doubt = |(k, unknown): (usize, &Unknown)| {
        let effect = &found.effects[unknown.effect];
        let is_term = matches!(effect.kind.simulation, Simulation::Coupling { .. });
        let alone = unknowns.iter().filter(|other| other.effect == unknown.effect).count() == 1;
        let (_, half) = found.half_width[unknown.effect].iter().find(|(name, _)| *name == unknown.name)?;
        let doubt = half / effect.value(&unknown.name).abs();
        (is_term && !alone && doubt >= 1.0).then_some((k, doubt))
    };
    unknowns.iter().enumerate().filter_map(doubt).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}

/// The estimate from samples far from corners, or from nearer ones if those that judge prefer it.
fn best_estimate(
    data: Data<'_>,
    stated: &[Effect],
    unknowns: &[Unknown],
    spread: Option<&Spread>,
) -> Estimate {
    let within = |farthest: usize| estimate(data, stated, unknowns, spread, farthest);
    let wide = within(FARTHEST);
    match wide.is_starved {
        true => {
            let near = within(NEAREST);
            let corners = corners_of(data.judge, &near.refined.effects, NEAREST);
            let error = |estimate: &Estimate| judged_error(data, &corners, &estimate.refined, spread);
            if error(&near) < error(&wide) { near } else { wide }
        }
        false => wide,
    }
}

/// An estimate from samples so far away from corners.
struct Estimate {
    refined: Refined,
    /// Whether scatter makes most of the interval of a torque that jumps, so that samples nearer to the corners might tell more than they mislead.
    is_starved: bool,
}

/// What an estimate leaves of the data that judge, all rows weighted, away from their corners: a weighted sum of squares.
fn judged_error(data: Data<'_>, corners: &[Corners], refined: &Refined, spread: Option<&Spread>) -> f64 {
    let judge = data.judge;
    let sharp = sharpened(judge, &refined.effects, |row| corners[row].reach.is_some());
    let mut amended = Amended::new(judge, &sharp);
    if let Some(spread) = spread.filter(|_| !refined.corrections.is_empty()) {
        amended.correct(&spread.change(&refined.corrections));
    }
    let of_row = |row: usize| {
        let (residual, sticks) = (amended.residual(row), judge.sticks(row));
        let told = |i: &usize| {
            let is_silent = corners[row].hold(*i) || sticks.get(*i).is_some_and(|sticks| *sticks);
            (data.judges)(*i, residual.len()) && !is_silent
        };
        (0..residual.len()).filter(told).map(|i| residual[i] * residual[i]).sum::<f64>()
    };
    (0..judge.rows().len()).map(|row| data.weights[row] * of_row(row)).sum()
}

/// From samples no nearer to corners than that, where enough are left: `farthest` in halves of a period of the filter's cut-off.
fn estimate(
    data: Data<'_>,
    stated: &[Effect],
    unknowns: &[Unknown],
    spread: Option<&Spread>,
    farthest: usize,
) -> Estimate {
    let (effects, corners, last) = converged(data, (stated, farthest), unknowns, spread);
    let (sigmas, corrections, covariance) = match last {
        Some((equations, corrections)) => {
            let (all, covariance) = uncertainty(&equations, data, unknowns.len(), &corrections);
            (all, corrections, covariance)
        }
        None => (vec![f64::INFINITY; unknowns.len()], Vec::new(), DMatrix::zeros(0, 0)),
    };
    let (mut half_width, mut is_starved) = (vec![Vec::new(); effects.len()], false);
    for (unknown, sigma) in unknowns.iter().zip(sigmas) {
        let effect = &effects[unknown.effect];
        let value = effect.value(&unknown.name);
        let limit = inexactness(data.experiment, effect, (&effects, &corners)) * value;
        let half = (T * sigma).hypot(limit);
        if matches!(effect.kind.simulation, Simulation::Dry(_) | Simulation::Coupling { .. }) {
            is_starved |= half > STARVED * NEAR_CORNERS * value.abs();
        }
        // So wide an interval tells nothing: its end is where the estimate ran away to.
        let known = half < RAN_AWAY * value.abs().max(unknown.step);
        half_width[unknown.effect].push((unknown.name.clone(), if known { half } else { f64::INFINITY }));
    }
    Estimate { refined: Refined { effects, half_width, corrections, covariance }, is_starved }
}

/// The normal equations of a last step, by row, and its inertial corrections.
type LastStep = (Vec<BlockEquations>, Vec<f64>);

/// Steps until they are negligible.
fn converged(
    data: Data<'_>,
    (stated, farthest): (&[Effect], usize),
    unknowns: &[Unknown],
    spread: Option<&Spread>,
) -> (Vec<Effect>, Vec<Corners>, Option<LastStep>) {
    let Data { experiment, weights, teaches, .. } = data;
    let corners_of = |effects: &[Effect]| match data.at_corners {
        true => (0..experiment.rows().len())
            .map(|row| Corners { left_out: departures(experiment, row), reach: None })
            .collect(),
        false => corners_of(experiment, effects, farthest),
    };
    let mut corners = corners_of(stated);
    let is_crossed = !landings_in_legs(experiment, stated).is_empty();
    let mut current = sharpened(experiment, stated, |row| corners[row].reach.is_some());
    let nothing = Spread::none();
    let (corrected, spread) = (spread.is_some(), spread.unwrap_or(&nothing));
    let mut error = f64::INFINITY;
    let (mut moves, mut stays) = (f64::INFINITY, 0);
    let mut last = None;
    for step_number in 0..STEPS {
        let amended = Amended::new(experiment, &current);
        let jacobian = jacobian(experiment, &current, &amended, unknowns);
        let counts =
            |row: usize, sample: usize, count: usize| teaches(sample, count) && !corners[row].hold(sample);
        let equations = equations(&amended, (spread, is_crossed), &jacobian, &counts);
        let all: Vec<usize> = (0..BLOCKS).collect();
        let sums = NormalEquations::of(&equations, &all);
        let here: f64 = sums.rows.iter().zip(weights).map(|(row, w)| w * row.squares()).sum();
        let corrections = corrected.then(|| Corrections::new(&sums, weights, spread.len()));
        let terms: Vec<Term> = (0..unknowns.len()).map(Term::Data).collect();
        let Some(step) = step(&sums, weights, corrections.as_ref(), &terms) else { break };
        let moved = apply(&current, unknowns, &step.coefficients);
        let largest = largest_move(unknowns, [&current, &moved]);
        // A limit may be pushed to and fro for ever, a sample less or more beyond it.
        stays = if largest > STALLED * moves && step_number > SETTLING { stays + 1 } else { 0 };
        moves = largest;
        last = Some((equations, step.corrections.clone()));
        if largest <= NEGLIGIBLE || stays == STAYS || (step_number > 3 && !corrected && here >= error) {
            break;
        }
        error = here;
        current = moved;
        if step_number < SETTLING {
            // A limit that moves takes its corner along.
            corners = corners_of(&as_stated(&current, stated));
        }
    }
    (as_stated(&current, stated), corners, last)
}

/// Samples of each row at the corners of what acts there.
fn corners_of(experiment: &dyn Experiment, effects: &[Effect], farthest: usize) -> Vec<Corners> {
    let landings = landings_in_legs(experiment, effects);
    let of_row = |row: usize| corners_within(experiment, row, effects, farthest).beside(landings.clone());
    parallel(experiment.rows().len(), of_row)
}

/// The effects with the settings that were stated.
fn as_stated(effects: &[Effect], stated: &[Effect]) -> Vec<Effect> {
    let mut all = effects.to_vec();
    for (effect, stated) in all.iter_mut().zip(stated) {
        let of_kind = effect.kind.parameters.iter().filter(|p| matches!(p.role, Role::Setting(_)));
        for setting in of_kind {
            match stated.parameters.get(setting.name) {
                Some(value) => effect.parameters.insert(setting.name.to_owned(), *value),
                None => effect.parameters.remove(setting.name),
            };
        }
    }
    all
}

/// One step of all unknowns and corrections.
fn step(
    sums: &NormalEquations,
    weights: &[f64],
    corrections: Option<&Corrections>,
    terms: &[Term],
) -> Option<Fit> {
    let products = parallel(terms.len(), |k| TermProducts::new(sums, weights, corrections, &terms[k]));
    fit(corrections, &products.iter().collect::<Vec<_>>())
}

fn equations(
    experiment: &dyn Experiment,
    (spread, is_crossed): (&Spread, bool),
    columns: &[Column],
    teaches: &(dyn Fn(usize, usize, usize) -> bool + Sync),
) -> Vec<BlockEquations> {
    let flat: Vec<(usize, &Column)> = columns.iter().enumerate().collect();
    parallel(experiment.rows().len(), |row| {
        // Play is on one side or the other, or being crossed: absolute values, not squares. Within the noise squares nevertheless: of angles
        // that an encoder counts in steps the median is one of the steps, wherever the truth lies between them.
        let what = &experiment.rows()[row];
        let mut emphasis = match what.channel {
            Channel::Transmission => forgiveness(experiment.residual(row), 0.1, 3.0 * what.noise),
            _ if is_crossed => forgiveness(experiment.residual(row), 0.1, 3.0 * what.noise),
            _ => forgiveness(experiment.residual(row), 2.0, 0.0),
        };
        let count = emphasis.len();
        let sticks = experiment.sticks(row);
        let silent = |i: usize| !teaches(row, i, count) || sticks.get(i).is_some_and(|sticks| *sticks);
        emphasis.iter_mut().enumerate().filter(|(i, _)| silent(*i)).for_each(|(_, e)| *e = 0.0);
        block_equations(experiment, row, spread, &flat, BLOCKS, Some(&emphasis))
    })
}

/// Square roots of Huber's weights: errors beyond so many standard deviations, but at least beyond `least`, such as those where
/// friction turns or play is crossed, count by their size and not by its square.
fn forgiveness(residual: &[f64], deviations: f64, least: f64) -> Vec<f64> {
    let limit = (deviations * middle_size(residual) / 0.6745).max(least);
    residual.iter().map(|r| if r.abs() > limit { (limit / r.abs()).sqrt() } else { 1.0 }).collect()
}

/// The median of the absolute values.
pub(crate) fn middle_size(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|x| x.abs()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    sizes.select_nth_unstable_by(middle, f64::total_cmp).1.max(1e-300)
}
