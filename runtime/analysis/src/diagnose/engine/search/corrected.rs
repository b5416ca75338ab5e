//! Effects alone, or effects beside inertial corrections: which of two searches is the answer.
use super::entry::LEAST;
use super::forward::Outcome;
use crate::diagnose::engine::equations::regression::{Regression, ScoredFit};
use crate::robot::link_inertias::CadError;
use bipedc_effects::effect::kinds;

/// Parameters of effects that compete with inertial corrections as the simpler explanation.
const FEW: usize = 4;
/// CAD data are off by more than so many of their standard deviations in one of twenty numbers.
const USUAL: f64 = 2.0;
/// The same where one link stands for what several are off by.
const USUAL_TOGETHER: f64 = 4.0;
/// So many links are changed by errors of the description alone: what is hidden in a robot is in one link, or two.
const MANY: usize = 4;

/// One answer is about as likely as another if it costs at most so much more: e³, a twentieth of its probability.
const AS_LIKELY: f64 = 6.0;

/// Whether a search with corrections is likelier than one without: they lower the held-out error by more than chance and cost less, and few
/// effects do not say as much.
pub(crate) fn is_corrected_likelier(
    regression: &Regression<'_>,
    plain: &Outcome,
    corrected: &Outcome,
) -> bool {
    let is_cheaper = || {
        whole_cost(regression, corrected) < whole_cost(regression, plain)
            && (only_cad_errors(regression, plain, corrected) || !as_good(regression, plain, corrected))
    };
    corrections_earn(regression, &corrected.active, &corrected.scored)
        && (are_many(regression, plain, corrected) || is_cheaper())
}

/// Whether effects alone put as many links a little elsewhere as only errors of the description do: what each of them says of its link is no
/// more than CAD data usually are off, and that is what corrections are for.
fn are_many(regression: &Regression<'_>, plain: &Outcome, corrected: &Outcome) -> bool {
    let is_link = |k: &usize| regression.candidates[plain.active[*k]].form.location.link.is_some();
    own(regression, plain, corrected).filter(is_link).filter(|&k| is_usual(regression, plain, k)).count()
        >= MANY
}

/// Places of the effects that a search without corrections found and one with them did not.
fn own<'o>(
    regression: &Regression<'_>,
    plain: &'o Outcome,
    corrected: &'o Outcome,
) -> impl Iterator<Item = usize> + 'o {
    (regression.standing.len()..plain.active.len()).filter(|&k| !corrected.active.contains(&plain.active[k]))
}

/// Whether an effect of a search is of the size by which CAD data usually are off.
fn is_usual(regression: &Regression<'_>, plain: &Outcome, k: usize) -> bool {
    let candidate = &regression.candidates[plain.active[k]];
    let coefficients = regression.coefficients(&plain.active, &plain.scored, k);
    if candidate.form.kind == &kinds::TORQUE_GAIN {
        let gain = candidate.form.effect(coefficients).value("gain");
        return (gain - 1.0).abs() <= USUAL * CadError::default().mass;
    }
    candidate.deviations(coefficients).is_some_and(|deviations| deviations <= USUAL_TOGETHER)
}

/// Whether corrections say in other words what effects alone say, and are about as likely: the rows do not tell which it is.
pub(crate) fn is_corrected_as_likely(
    regression: &Regression<'_>,
    plain: &Outcome,
    corrected: &Outcome,
) -> bool {
    let judged = &plain.active[regression.standing.len()..];
    judged.iter().any(|c| !corrected.active.contains(c))
        && whole_cost(regression, corrected) < whole_cost(regression, plain) + AS_LIKELY
}

/// Weighted squares of a search's errors.
fn deviance(regression: &Regression<'_>, outcome: &Outcome) -> f64 {
    outcome.scored.errors.iter().zip(&regression.weights).map(|(e, w)| e * w).sum()
}

/// What a search's answer costs if all of its error counts: corrections of many links lower errors that are below what the
/// estimate of noise may be off by, and such errors are the same for both answers.
fn whole_cost(regression: &Regression<'_>, outcome: &Outcome) -> f64 {
    regression.whole_cost(&outcome.active, &outcome.scored)
}

/// Whether few effects alone explain as much as corrections of many links do, whatever the latter's prior says: what has
/// fewer parameters is the likelier cause.
fn as_good(regression: &Regression<'_>, plain: &Outcome, corrected: &Outcome) -> bool {
    let parameters = |outcome: &Outcome| -> usize {
        let judged = &outcome.active[regression.standing.len()..];
        judged.iter().map(|&c| regression.candidates[c].parameters).sum()
    };
    let more = parameters(plain).saturating_sub(parameters(corrected));
    let excess = deviance(regression, plain) - deviance(regression, corrected);
    let chance =
        regression.scatter(&corrected.scored, &corrected.active, &plain.scored, &plain.active).max(4.0);
    !plain.active.is_empty() && more <= FEW && excess <= chance
}

/// Whether all that few effects have beyond the others is of the size by which CAD data usually are off: masses and centres of mass of
/// links, and gains, which are masses where a joint carries one body. Then corrections of these links say the same and no more.
fn only_cad_errors(regression: &Regression<'_>, plain: &Outcome, corrected: &Outcome) -> bool {
    let mut more = own(regression, plain, corrected).peekable();
    more.peek().is_some() && more.all(|k| is_usual(regression, plain, k))
}

/// Whether inertial corrections lower the held-out error by more than chance.
fn corrections_earn(regression: &Regression<'_>, active: &[usize], corrected: &ScoredFit) -> bool {
    let Some(plain) = regression.scored_fit(active, false) else { return true };
    let (with, without) =
        (regression.block_errors(corrected, active), regression.block_errors(&plain, active));
    (0..corrected.errors.len()).any(|row| {
        let falls: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a[row] - b[row]).collect();
        let mean = falls.iter().sum::<f64>() / falls.len() as f64;
        let variance =
            falls.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / (falls.len() - 1).max(1) as f64;
        let total = mean * falls.len() as f64;
        total > LEAST * plain.errors[row] && mean > 2.5 * (variance / falls.len() as f64).sqrt()
    })
}
