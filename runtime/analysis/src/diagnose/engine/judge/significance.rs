//! Significance: effects that do not survive the exact estimate.
use crate::diagnose::engine::equations::regression::Regression;
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::engine::refine::refinement::Refined;
use crate::diagnose::engine::search::entry::{LEAST, is_settling, least};
use crate::diagnose::engine::search::forward::Outcome;
use crate::diagnose::engine::search::impossible::MOST;
use crate::experiments::form::Reach;
use crate::experiments::jumps::Jumps;
use crate::experiments::{Channel, Experiment, Row};
use bipedc_effects::effect::{Effect, Law, Location, Role, Size, kinds};

/// An effect that does not stay.
pub(crate) struct Insignificant {
    /// Its index among the refined ones.
    pub effect: usize,
    /// It cannot be so; otherwise it explains next to nothing.
    pub impossible: bool,
}

/// The effect that removes least from the judging data once everything is estimated exactly, if that is next to
/// nothing.
pub(crate) fn insignificant(
    regression: &Regression<'_>,
    outcome: &Outcome,
    refined: &Refined,
) -> Option<Insignificant> {
    let judged = regression.standing.len()..refined.effects.len();
    let several = refined.effects.len() > 1;
    let doubtful = judged.clone().find(|&k| {
        !is_reachable(regression, refined, k)
            || !saturates(regression, refined, k)
            || limits_all(refined, k)
            || is_less_at_rest(&refined.effects[k])
            || (several && is_cancelled(regression, &refined.effects[k]) && !is_well_told(refined, k))
    });
    if let Some(effect) = doubtful {
        return Some(Insignificant { effect, impossible: true });
    }
    // What settles nothing but noise settles nothing.
    let fall = |k: usize| match fall_of(regression, refined, k) {
        small if small.is_finite() && small < 0.5 * LEAST && is_settling(regression, outcome, k) => {
            f64::INFINITY
        }
        fall => fall,
    };
    let fall = |k: usize| if uncertain(refined, k) { f64::NEG_INFINITY } else { fall(k) };
    let (effect, fall) = judged.map(|k| (k, fall(k))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    (fall < 0.5 * LEAST).then_some(Insignificant { effect, impossible: false })
}

/// Whether the log holds values that an effect's parameters stand for, or may stand for by their intervals.
fn is_reachable(regression: &Regression<'_>, refined: &Refined, k: usize) -> bool {
    let effect = &refined.effects[k];
    let reach = Reach::of(regression.judge, &effect.location);
    let half = |name: &str| {
        let mut widths = refined.half_width[k].iter().filter(|(n, half)| n == name && half.is_finite());
        let (low, high) = effect.plausible(name);
        widths.next().map_or(0.0, |(_, half)| half.min(high - low))
    };
    let holds = |name: &str, value: f64| {
        let parts = [0.0, -0.5, 0.5, -1.0, 1.0];
        parts.iter().any(|part| reach.holds(effect, name, value + part * half(name)))
    };
    effect.parameters.iter().all(|(name, value)| {
        let parameter = effect.kind.parameter(name);
        parameter.is_none_or(|p| matches!(p.role, Role::Setting(_)) || holds(name, *value))
    })
}

/// Largest relative fall of a row's squared error by the `k`-th effect, where the others jump and away from there.
fn fall_of(regression: &Regression<'_>, refined: &Refined, k: usize) -> f64 {
    let mut fewer = refined.effects.clone();
    fewer.remove(k);
    // Also without corrections an effect must explain something, unless nothing can be said without them.
    let change = if regression.free { regression.spread.change(&refined.corrections) } else { Vec::new() };
    let play = fewer.iter().filter(|effect| effect.kind.law == Law::Backlash);
    let play: Vec<&Location> = play.map(|effect| &effect.location).collect();
    let fall = |jumps: Option<&Jumps>| {
        let [with, without] =
            [&refined.effects, &fewer].map(|e| judged_errors(regression, e, &change, jumps));
        let relative = without.iter().zip(&with).enumerate().filter_map(|(row, (was, is))| {
            let part = (was.squares - is.squares) / was.squares.max(f64::MIN_POSITIVE);
            // What only lowers noise lowers nothing, unless it lowers so much that no chance would.
            let lowers = part > NO_TRACE && part * was.independent > 2.0 * NO_CHANCE;
            let counts = !was.is_noise || lowers;
            counts.then(|| part * LEAST / least(regression, row, refined.effects[k].kind, &play))
        });
        relative.fold(f64::NEG_INFINITY, f64::max)
    };
    let everywhere = fall(None);
    // Where the others jump the filter knows little of the motion: what an effect explains there alone it does not explain.
    let jumps = Jumps::of(regression.judge, &fewer);
    if jumps.are_some() && jumps.leave_enough() { everywhere.min(fall(Some(&jumps))) } else { everywhere }
}

/// What is left of a row where nothing sticks.
pub(crate) struct JudgedError {
    /// Sum of squares; of magnitudes where play is crossed, because the angle is anywhere then and squares would be its alone.
    squares: f64,
    /// Not more than the noise of measurement and motion.
    is_noise: bool,
    /// How many independent samples tell it.
    independent: f64,
}

impl JudgedError {
    /// Whether it is not more than the noise of measurement and motion.
    pub fn is_noise(&self) -> bool {
        self.is_noise
    }

    /// Whether the squares are more than so many times another fit's, noise or not.
    pub fn is_larger_than(&self, other: &Self, times: f64) -> bool {
        self.squares > times * other.squares
    }

    /// Whether the squares are more than noise and more than so many times another fit's.
    pub fn is_worse_than(&self, other: &Self, times: f64) -> bool {
        !self.is_noise && self.is_larger_than(other, times)
    }

    /// How much more deviance this is than what another fit leaves, which is taken for noise.
    pub fn deviance_above(&self, other: &Self) -> f64 {
        (self.squares / other.squares.max(f64::MIN_POSITIVE) - 1.0) * other.independent
    }
}

/// No chance lowers what other data leave by so much deviance,
pub(crate) const NO_CHANCE: f64 = 30.0;
/// and what stops and jumps of other joints leave in a row is less than so much of its noise's squares.
const NO_TRACE: f64 = 0.1;

/// What effects and a change of inertial parameters leave of each judging row, away from jumps.
pub(crate) fn judged_errors(
    regression: &Regression<'_>,
    effects: &[Effect],
    change: &[f64],
    jumps: Option<&Jumps>,
) -> Vec<JudgedError> {
    let mut amended = Amended::new(regression.judge, effects);
    if !change.is_empty() {
        amended.correct(change);
    }
    let away = |i: usize| !jumps.is_some_and(|jumps| jumps.hold(i));
    let rows = regression.judge.rows().iter().enumerate();
    let of_row = |(row, what): (usize, &Row)| {
        let crosses = what.channel == Channel::Transmission;
        let told = without_sticking(regression.judge, row, amended.residual(row), away);
        let add = |(sum, n): (f64, usize), x: f64| (sum + if crosses { x.abs() } else { x * x }, n + 1);
        let (squares, count) = told.fold((0.0, 0), add);
        let independent = count as f64 / regression.noise_floors[row].1;
        let is_noise = !crosses && regression.is_noise(row, squares, count);
        JudgedError { squares, is_noise, independent }
    };
    rows.map(of_row).collect()
}

/// Values of a row at samples that count, but those where its joint sticks.
pub(crate) fn without_sticking<'v>(
    experiment: &'v dyn Experiment,
    row: usize,
    values: &'v [f64],
    counts: impl Fn(usize) -> bool,
) -> impl Iterator<Item = f64> {
    let sticks = experiment.sticks(row);
    let told = move |i: usize| counts(i) && !sticks.get(i).is_some_and(|sticks| *sticks);
    values.iter().enumerate().filter(move |(i, _)| told(*i)).map(|(_, x)| *x)
}

/// Of some hundred candidates a few lie beyond their 95 % intervals by chance; beyond so many times as much, three standard
/// deviations, hardly one does.
const BY_CHANCE: f64 = 1.5;

/// Whether all that an effect might be includes that it is nothing.
pub(crate) fn uncertain(refined: &Refined, k: usize) -> bool {
    let effect = &refined.effects[k];
    let size = |name: &str| effect.kind.parameter(name).map_or(Size::NothingAt(0.0), |p| p.size);
    let sizes: Vec<(&String, &f64, Size)> = refined.half_width[k]
        .iter()
        .map(|(name, half)| (name, half, size(name)))
        .filter(|(.., size)| *size != Size::Place)
        .collect();
    let nothing = |(name, half, size): &(&String, &f64, Size)| match size {
        Size::NothingAt(nothing) => (effect.value(name) - nothing).abs() < BY_CHANCE * **half,
        // It may be anything: so may what it does, as the others tell.
        Size::NeverNothing => half.is_infinite(),
        Size::Place => true,
    };
    sizes.iter().any(|(.., size)| matches!(size, Size::NothingAt(_))) && sizes.iter().all(nothing)
}

/// Whether friction at rest may be no more than at speed, or that of one direction no more than that of the other, by their intervals: then
/// the kind says no more than dry friction.
pub(crate) fn says_no_more(refined: &Refined, k: usize) -> bool {
    let effect = &refined.effects[k];
    let half =
        |name: &str| refined.half_width[k].iter().find(|(n, _)| n == name).map_or(0.0, |(_, half)| *half);
    let exceeds = |more: f64, [one, other]: [&str; 2]| more >= half(one).hypot(half(other));
    let difference = |[one, other]: [&str; 2]| effect.value(one) - effect.value(other);
    let (at_rest, directions) = (["static", "coulomb"], ["positive", "negative"]);
    match effect.kind {
        kind if kind == &kinds::STRIBECK_FRICTION => !exceeds(difference(at_rest), at_rest),
        kind if kind == &kinds::ASYMMETRIC_COULOMB_FRICTION => {
            !exceeds(difference(directions).abs(), directions)
        }
        _ => false,
    }
}

/// Whether friction would be smaller at rest than at speed, which no search takes: an exact estimate of what hardly shows may come out so.
fn is_less_at_rest(effect: &Effect) -> bool {
    effect.kind == &kinds::STRIBECK_FRICTION && effect.value("static") < effect.value("coulomb")
}

/// Whether all that one of an effect's parameters might be includes that it is nothing.
pub(crate) fn is_vague(refined: &Refined, k: usize) -> bool {
    let effect = &refined.effects[k];
    refined.half_width[k].iter().any(|(name, half)| match effect.kind.parameter(name).map(|p| p.size) {
        Some(Size::NothingAt(nothing)) => (effect.value(name) - nothing).abs() < *half,
        Some(Size::NeverNothing) => effect.value(name).abs() < *half,
        Some(Size::Place) | None => false,
    })
}

/// Whether the limit of a drive may as well be nothing: all torque then lies beyond it. With inertias free nothing but the limit says how large torques are, and
/// the smaller all of them the smaller what is left.
pub(crate) fn limits_all(refined: &Refined, k: usize) -> bool {
    let effect = &refined.effects[k];
    let mut halves = refined.half_width[k].iter().filter(|(name, _)| *name == "limit");
    effect.kind == &kinds::TORQUE_SATURATION
        && halves.any(|(name, half)| effect.value(name).abs() < BY_CHANCE * half)
}

/// Whether an effect makes far more than there is to explain, so that another one takes it back.
fn is_cancelled(regression: &Regression<'_>, effect: &Effect) -> bool {
    let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let (mut made, mut wanted) = (0.0, 0.0);
    for (row, response) in regression.train.response(std::slice::from_ref(effect)) {
        made += regression.weights[row] * squares(&response);
        wanted += regression.weights[row] * squares(regression.train.residual(row));
    }
    made > MOST * wanted
}

/// Whether intervals are narrow beside the sizes that they are of: data tell it from what takes it back.
fn is_well_told(refined: &Refined, k: usize) -> bool {
    /// Half of an interval, as a part of its size.
    const NARROW: f64 = 0.2;
    let effect = &refined.effects[k];
    let is_size =
        |name: &str| matches!(effect.kind.parameter(name).map(|p| p.size), Some(Size::NothingAt(_)));
    let mut halves = refined.half_width[k].iter().filter(|(name, _)| is_size(name)).peekable();
    halves.peek().is_some() && halves.all(|(name, half)| *half < NARROW * effect.value(name).abs())
}

/// A limit that cuts off less than so many times the noise, root mean square of what it cuts, trims peaks of the noise: those of a torque that
/// just reaches it are as large as the noise.
const PEAKS: f64 = 1.5;

/// Part of the squares that a limit cuts off which may be left where it cuts: of commands that run away filters leave that much at the corners.
const NEXT_TO_NOTHING: f64 = 0.01;

/// Where more of the readings than this part lie beyond a limit, it must cut off so large a part of their squares, as of commands that run away: a limit below most readings
/// otherwise takes the sign of the torque for all of it, and the noise away.
const MOSTLY: f64 = 0.7;
const AWAY: f64 = 0.5;

/// Where a drive saturates, the true torque is the limit: what is left there must be no more than elsewhere, or next to nothing of what
/// the limit cuts off. Otherwise it only hides that the model is wrong where torques are large; and what it cuts off must be more than
/// noise. True for all other kinds.
fn saturates(regression: &Regression<'_>, refined: &Refined, k: usize) -> bool {
    let effect = &refined.effects[k];
    if !matches!(effect.kind.law, Law::TrueTorque(_)) {
        return true;
    }
    let experiment = regression.train;
    let amended = Amended::new(experiment, &refined.effects);
    experiment.response(std::slice::from_ref(effect)).iter().all(|(row, response)| {
        let left = amended.residual(*row);
        let mean = |inside: bool| {
            let picked = left.iter().zip(response).filter(|(_, clipped)| (**clipped != 0.0) == inside);
            let (sum, n) = picked.fold((0.0, 0.0_f64), |(sum, n), (x, _)| (sum + x * x, n + 1.0));
            (sum / n.max(1.0), n)
        };
        let ((inside, count), (outside, _)) = (mean(true), mean(false));
        let cut: f64 = response.iter().map(|x| x * x).sum();
        let cuts_more_than_noise = cut > count * (PEAKS * regression.resolutions[*row]).powi(2);
        let is_seldom = count <= MOSTLY * left.len() as f64;
        let runs_away = || {
            let reading = experiment.measured(*row).unwrap_or_default();
            cut > AWAY * reading.iter().map(|x| x * x).sum::<f64>()
        };
        count > 5.0
            && (is_seldom || runs_away())
            && (inside < 4.0 * outside || count * inside < NEXT_TO_NOTHING * cut)
            && cuts_more_than_noise
            && is_pressed(regression, refined, k, (*row, cut))
    })
}

/// Part of the squares that a limit cuts off which the mean excess of readings must make where the model is at the limit.
const PRESSED: f64 = 0.05;

/// Other effects that alone make squares so many times as large only make room for a limit.
const WORSE: f64 = 2.0;

/// Whether readings exceed the model where the model is at the limit. Those that are chosen by their own size do so in any noise,
/// the more so where it is larger at times: to cut them off lowers the error, and is no limit. Nor is it one below the model which another
/// effect lowers that alone only makes the error larger.
fn is_pressed(regression: &Regression<'_>, refined: &Refined, k: usize, (row, cut): (usize, f64)) -> bool {
    let mut others = refined.effects.clone();
    let limit = others.remove(k).value("limit");
    let amended = Amended::new(regression.train, &others);
    let described = Amended::new(regression.train, &refined.effects[..regression.standing.len()]);
    let (beside, alone) = (amended.residual(row), described.residual(row));
    let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
    let left = if squares(beside) <= WORSE * squares(alone) { beside } else { alone };
    let Some(reading) = amended.measured(row) else { return true };
    let least = limit - 2.0 * regression.resolutions[row];
    let pairs = left.iter().zip(reading);
    let at_limit = pairs.filter(|(left, reading)| (reading - **left).abs() >= least);
    let (sum, n) = at_limit
        .fold((0.0, 0.0_f64), |(sum, n), (left, reading)| (sum + left * (reading - left).signum(), n + 1.0));
    sum * sum / n.max(1.0) >= PRESSED * cut
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::Kind;
    use nalgebra::DMatrix;

    /// Friction with these values and half widths.
    fn estimated(kind: &'static Kind, values: [(&str, f64, f64); 2]) -> Refined {
        let location = Location { joint: Some("knee".to_owned()), ..Location::default() };
        let effect = Effect::new(kind, location, &values.map(|(name, value, _)| (name, value)));
        let half_width = vec![values.iter().map(|(name, _, half)| ((*name).to_owned(), *half)).collect()];
        Refined {
            effects: vec![effect],
            half_width,
            corrections: Vec::new(),
            covariance: DMatrix::zeros(0, 0),
        }
    }

    #[test]
    fn friction_alike_in_both_directions_is_dry_friction() {
        let both = |positive, half| {
            let values = [("positive", positive, half), ("negative", 2.9885, half)];
            says_no_more(&estimated(&kinds::ASYMMETRIC_COULOMB_FRICTION, values), 0)
        };
        assert!(both(2.9886, 0.0376) && both(2.95, 0.0376));
        assert!(!both(2.9, 0.0376) && !both(3.1, 0.0376) && !both(2.9886, 0.0));
    }

    #[test]
    fn friction_that_is_no_larger_at_rest_is_dry_friction() {
        let at_rest = |value| {
            let values = [("static", value, 0.1), ("coulomb", 1.0, 0.05)];
            says_no_more(&estimated(&kinds::STRIBECK_FRICTION, values), 0)
        };
        assert!(at_rest(1.1) && !at_rest(1.2));
    }
}
