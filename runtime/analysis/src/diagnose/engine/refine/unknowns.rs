//! What a final estimate moves: the parameters of its effects, how a step changes them, and what each of them changes in the rows.
use super::amended::Amended;
use crate::experiments::Experiment;
use crate::experiments::form::Column;
use crate::parallel::parallel;
use bipedc_effects::effect::{Effect, Law, Role};

/// One parameter of one effect.
pub(crate) struct Unknown {
    pub effect: usize,
    pub name: String,
    pub bounds: (f64, f64),
    pub step: f64,
    /// Whether rows are linear in its reciprocal and not in itself: steps are then taken there.
    by_reciprocal: bool,
}

impl Unknown {
    /// The value after a step of Gauss–Newton.
    fn moved(&self, value: f64, step: f64) -> f64 {
        let moved = match self.by_reciprocal {
            // 1/value − step/value²: the step of the reciprocal that has this slope.
            true if step < value => value / (1.0 - step / value),
            true => 10.0 * value,
            false => value + step,
        };
        moved.clamp(self.bounds.0, self.bounds.1)
    }
}

/// The largest move of a parameter, as a part of its value. One that a bound stops does not move.
pub(crate) fn largest_move(unknowns: &[Unknown], [from, to]: [&[Effect]; 2]) -> f64 {
    let part = |unknown: &Unknown| {
        let [from, to] = [from, to].map(|effects| effects[unknown.effect].value(&unknown.name));
        (to - from).abs() / from.abs().max(unknown.step)
    };
    unknowns.iter().map(part).fold(0.0, f64::max)
}

/// The effects and what is estimated beside them without being reported.
pub(crate) fn with_nuisances(experiment: &dyn Experiment, mut effects: Vec<Effect>) -> Vec<Effect> {
    for effect in effects.clone() {
        let Some((beside, start)) = effect.kind.nuisance() else { continue };
        let place = effect.location;
        let possible = experiment.candidates().iter().any(|(kind, at)| *kind == beside && *at == place);
        if possible && !effects.iter().any(|other| other.kind == beside && other.location == place) {
            effects.push(Effect::new(beside, place, start));
        }
    }
    effects
}

pub(crate) fn unknowns(effects: &[Effect]) -> Vec<Unknown> {
    let mut list = Vec::new();
    for (index, effect) in effects.iter().enumerate() {
        for (name, value) in &effect.parameters {
            let parameter = effect.kind.parameter(name);
            if parameter.is_some_and(|p| matches!(p.role, Role::Setting(_))) {
                continue;
            }
            let bounds = match parameter.and_then(|p| p.reach) {
                Some((low, high)) => (low * value, high * value),
                None => effect.bounds(name),
            };
            let step = 1e-4 * value.abs().max(1e-2);
            let by_reciprocal = match effect.kind.law {
                Law::SeriesElasticity => true,
                Law::GroundCompliance => name == "stiffness",
                _ => false,
            };
            list.push(Unknown { effect: index, name: name.clone(), bounds, step, by_reciprocal });
        }
    }
    list
}

pub(crate) fn apply(effects: &[Effect], unknowns: &[Unknown], steps: &[f64]) -> Vec<Effect> {
    let mut moved = effects.to_vec();
    for (unknown, step) in unknowns.iter().zip(steps) {
        let value = unknown.moved(effects[unknown.effect].value(&unknown.name), *step);
        moved[unknown.effect].parameters.insert(unknown.name.clone(), value);
    }
    for (index, load) in moved.iter_mut().enumerate().filter(|(_, effect)| effect.kind.law == Law::Payload) {
        by_moments(&effects[index], load);
    }
    moved
}

/// Rows are linear in a payload's mass and in mass times position, not in its position: the step is taken there. A mass that vanished would have no place any more.
fn by_moments(from: &Effect, to: &mut Effect) {
    /// To no less than this part of itself a mass falls in a step.
    const LEAST: f64 = 0.1;
    let mass = from.value("mass");
    let moved = to.value("mass").max(LEAST * mass);
    if mass > 0.0 && moved > 0.0 {
        to.parameters.insert("mass".to_owned(), moved);
        for axis in ["x", "y", "z"] {
            let Some((at, there)) = from.parameters.get(axis).zip(to.parameters.get_mut(axis)) else {
                continue;
            };
            *there = at + (*there - at) * mass / moved;
        }
    }
}

/// One column per unknown: the slope of the response.
pub(crate) fn jacobian(
    experiment: &dyn Experiment,
    effects: &[Effect],
    amended: &Amended<'_>,
    unknowns: &[Unknown],
) -> Vec<Column> {
    parallel(unknowns.len(), |u| {
        let unknown = &unknowns[u];
        let value = effects[unknown.effect].value(&unknown.name);
        // One-sided at a bound.
        let step = if value + unknown.step > unknown.bounds.1 { -unknown.step } else { unknown.step };
        let mut moved = effects.to_vec();
        moved[unknown.effect].parameters.insert(unknown.name.clone(), value + step);
        let mut column: Column = Vec::new();
        for (row, response) in experiment.response(&moved) {
            let (nominal, now) = (experiment.residual(row), amended.residual(row));
            let slope: Vec<f64> = response
                .iter()
                .zip(nominal.iter().zip(now))
                .map(|(r, (n, a))| (r - (n - a)) / step)
                .collect();
            if slope.iter().any(|s| s.abs() > 1e-9) {
                column.push((row, slope));
            }
        }
        column
    })
}

#[cfg(test)]
mod tests {
    use super::Unknown;

    /// A stiffness six times too large: a step of Gauss–Newton in the stiffness itself would make it negative.
    #[test]
    fn a_stiffness_is_found_by_its_reciprocal_in_one_step() {
        let bounds = (1e-3, f64::INFINITY);
        let stiffness =
            Unknown { effect: 0, name: "stiffness".to_owned(), bounds, step: 1.0, by_reciprocal: true };
        let (truth, start) = (4000.0, 24_814.0);
        // The compliance that is left over its slope by the stiffness, −1 / stiffness².
        let step = (1.0 / truth - 1.0 / start) * -(start * start);
        assert!((stiffness.moved(start, step) - truth).abs() < 1e-9 * truth);
        assert!(stiffness.moved(start, 2.0 * start) > start, "a compliance below nothing is a stiff joint");
    }
}
