//! Choosing the parameters of a step of several phases at mid-stance, so that the next mid-stance has a wished speed (6.23).
//!
//! Phases end by their events, so that no energy alone tells the next speed: every step that counts is followed by the whole robot as its
//! model has it. What parameters do to a speed is computed once, from one mid-stance, and only says which steps are worth it.
use super::foresight::{Foresight, Passed};
use bipedc_analysis::gait::{Choice, ChoiceKind, Choices, Watch, in_parallel, zero};
use bipedc_effects::diagnostic::Diagnostic;

/// Combinations that are tried on the other side of a wished speed.
const TRIED: usize = 8;
/// Combinations that are tried where the wished speed itself is not met.
const NEAREST: usize = 24;
/// Further steps that are tried before a step counts as one that leads nowhere.
const FURTHER: usize = 8;
/// By how much a speed may be missed, as a part of it or of 1.
const MISSED: f64 = 1e-7;
/// A speed that misses by so much is worth a step that is followed closely, as a part of the wished one or of 1.
const NEARLY: f64 = 1e-4;
/// Differences of speeds that are large beside what steps followed roughly are off.
const CLEAR: f64 = 1e-5;
/// Steps that are followed on the way to a wished speed.
const ROUNDS: usize = 8;
/// By how much another speed is, to see what is left of a difference after a step.
const FASTER: f64 = 0.03;

/// What is chosen from.
#[derive(Debug, Clone, PartialEq)]
pub struct PhasedChoices {
    /// Values of the grid; all between the smallest and the largest may be chosen.
    pub choices: Choices,
    /// Parameters to which others are preferred the less the farther they are away, each relative to its range.
    pub usual: Vec<f64>,
}

/// Chooses parameters of next steps.
pub struct PhasedChooser<'a, 'f> {
    foresight: &'a Foresight<'f>,
    settings: PhasedChoices,
    /// Combinations of the grid with which a step was made, the nearest to the usual one first, and their next speeds.
    nodes: Vec<(Vec<f64>, f64)>,
    /// That of the usual parameters, at which all steps of the grid began; and what is left of a difference of speeds after a step.
    nominal: [f64; 2],
}

impl<'a, 'f> PhasedChooser<'a, 'f> {
    /// Follows the steps of the grid from a mid-stance at which the robot has the usual parameters; `None`: an end was asked for.
    ///
    /// # Errors
    /// The usual parameters make no step.
    pub fn new(
        foresight: &'a Foresight<'f>,
        settings: PhasedChoices,
        from: &Passed,
        watch: &Watch<'_>,
    ) -> Result<Option<Self>, Diagnostic> {
        let none = |why: String| Diagnostic::error(format!("the usual parameters make no step: {why}"));
        let usual = settings.usual.clone();
        let slow = foresight.ahead(&from.q, &from.v, &usual).map_err(none)?.speed;
        let quick: Vec<f64> = from.v.iter().map(|v| v * (1.0 + FASTER)).collect();
        let left = match foresight.ahead(&from.q, &quick, &usual) {
            Ok(quick) => (quick.speed - slow) / (FASTER * from.speed),
            Err(_) => 1.0,
        };
        let all = settings.choices.nodes();
        let mut nodes = in_parallel(all.len(), watch, |job| {
            let speed = foresight.ahead(&from.q, &from.v, &all[job]).ok()?.speed;
            Some((all[job].clone(), speed - slow))
        });
        let complete = nodes.len() == all.len();
        nodes.sort_by_key(|(job, _)| *job);
        let mut nodes: Vec<_> = nodes.into_iter().filter_map(|(_, node)| node).collect();
        let distance = |node: &[f64]| distance(&settings.choices, node, &usual);
        nodes.sort_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
        let nominal = [slow - left * from.speed, left];
        Ok(complete.then_some(Self { foresight, settings, nodes, nominal }))
    }

    /// The parameters to take at mid-stance in this state (legs named by their roles), to pass the next one with the speed `wished`, per
    /// s. `present`: parameters of the present step.
    pub fn choose(&self, now: &Passed, wished: f64, present: &[f64]) -> Choice {
        let usual = self.roughly(now, &self.settings.usual);
        let expected = self.expected(now.speed);
        // Where the usual step is made it says how far everything is off what was computed once.
        let off = usual.as_ref().map_or(0.0, |usual| usual.speed - expected);
        let reach = |gain: f64| expected + off + gain;
        if let Some(usual) = usual
            && let Some(found) = self.meeting(now, &usual, (wished, &reach), present)
        {
            return found;
        }
        let stays =
            Choice { parameters: present.to_vec(), predicted: None, steps: None, kind: ChoiceKind::None };
        self.closest(now, wished, &reach).unwrap_or(stays)
    }

    /// The next speed of the usual parameters, as far as it is known without following the step.
    fn expected(&self, speed: f64) -> f64 {
        self.nominal[0] + self.nominal[1] * speed
    }

    fn ahead(&self, now: &Passed, values: &[f64]) -> Option<Passed> {
        self.foresight.ahead(&now.q, &now.v, values).ok()
    }

    /// The same, as closely as is needed to know where to look.
    fn roughly(&self, now: &Passed, values: &[f64]) -> Option<Passed> {
        self.foresight.roughly_ahead(&now.q, &now.v, values).ok()
    }

    /// Parameters on the way from the usual ones to a combination on the other side of the wished speed.
    fn meeting(
        &self,
        now: &Passed,
        usual: &Passed,
        (wished, reach): (f64, &dyn Fn(f64) -> f64),
        present: &[f64],
    ) -> Option<Choice> {
        let near = usual.speed - wished;
        if near.abs() <= NEARLY * wished.max(1.0)
            && let Some(usual) = self.ahead(now, &self.settings.usual).filter(|usual| met(usual, wished))
        {
            return self.accepted(&self.settings.usual, &usual);
        }
        if let Some(found) = self.near_present(now, near, wished, present) {
            return Some(found);
        }
        let beyond = |(_, gain): &&(Vec<f64>, f64)| (reach(*gain) < wished) != (near < 0.0);
        self.nodes.iter().filter(beyond).take(TRIED).find_map(|(node, _)| {
            let far = self.roughly(now, node)?.speed - wished;
            ((far < 0.0) != (near < 0.0)).then_some(())?;
            let ends = [(0.0, near), (1.0, far)];
            self.by_secants(now, wished, (&|part| self.toward(node, part), 1.0), ends).or_else(|| {
                let [near, far] = [&self.settings.usual, node].map(|values| self.ahead(now, values));
                self.between(now, (node, [near?.speed - wished, far?.speed - wished]), wished)
            })
        })
    }

    /// From the usual parameters part of the way to others.
    fn toward(&self, node: &[f64], part: f64) -> Vec<f64> {
        self.settings.usual.iter().zip(node).map(|(a, b)| a + part * (b - a)).collect()
    }

    /// The same beside those of the present step, which tell most of it where speeds are wished that change little. With several parameters they need not
    /// lie on the way to the nearest combination.
    fn near_present(&self, now: &Passed, near: f64, wished: f64, present: &[f64]) -> Option<Choice> {
        let [(axis, values)] = &self.settings.choices.axes[..] else { return None };
        let (usual, own) = (self.settings.usual[*axis], present[*axis]);
        let alone = |k: usize| k == *axis || present[k] == self.settings.usual[k];
        if own == usual || !(0..present.len()).all(alone) {
            return None;
        }
        let end = if own > usual { values.last()? } else { values.first()? };
        let miss = self.roughly(now, present)?.speed - wished;
        // Little of what the usual parameters miss: else the way to the other side tells more.
        (miss.abs() <= 0.5 * near.abs()).then_some(())?;
        let most = (end - usual) / (own - usual);
        self.by_secants(now, wished, (&|part| self.toward(present, part), most), [(0.0, near), (1.0, miss)])
    }

    /// The place on a way at which a speed is met, from two places with what they miss it by; roughly at first.
    fn by_secants(
        &self,
        now: &Passed,
        wished: f64,
        (way, most): (&dyn Fn(f64) -> Vec<f64>, f64),
        [before, mut last]: [(f64, f64); 2],
    ) -> Option<Choice> {
        let scale = wished.max(1.0);
        let mut slope = (last.1 - before.1) / (last.0 - before.0);
        for _ in 0..ROUNDS {
            let part = last.0 - last.1 / slope;
            (0.0..=most).contains(&part).then_some(())?;
            let (values, closely) = (way(part), last.1.abs() <= NEARLY * scale);
            let next = if closely { self.ahead(now, &values) } else { self.roughly(now, &values) }?;
            if closely && met(&next, wished) {
                return self.accepted(&values, &next);
            }
            let miss = next.speed - wished;
            if (miss - last.1).abs() > CLEAR * scale {
                slope = (miss - last.1) / (part - last.0);
            }
            last = (part, miss);
        }
        None
    }

    /// The step on the line from the usual parameters to others that has the wished speed.
    fn between(&self, now: &Passed, (node, ends): (&[f64], [f64; 2]), wished: f64) -> Option<Choice> {
        ((ends[0] < 0.0) != (ends[1] < 0.0)).then_some(())?;
        // What is met is a zero: every further place would cost a step.
        let mut meets = None;
        let miss = |part: f64| match self.ahead(now, &self.toward(node, part)) {
            Some(next) if met(&next, wished) => {
                meets = Some((self.toward(node, part), next));
                0.0
            }
            next => next.map_or(f64::NAN, |next| next.speed) - wished,
        };
        let values = self.toward(node, zero(miss, (0.0, ends[0]), (1.0, ends[1])));
        let again =
            || self.ahead(now, &values).filter(|next| met(next, wished)).map(|next| (values.clone(), next));
        let (values, next) = meets.or_else(again)?;
        self.accepted(&values, &next)
    }

    /// A step that meets its wish, and does not end in a fall.
    fn accepted(&self, values: &[f64], next: &Passed) -> Option<Choice> {
        self.goes_on(next).then(|| Choice {
            parameters: values.to_vec(),
            predicted: Some(next.speed),
            steps: Some(1),
            kind: ChoiceKind::Meets,
        })
    }

    /// Whether some further step is possible: first those are tried that come back to the speed of the usual parameters.
    fn goes_on(&self, next: &Passed) -> bool {
        let usual = &self.settings.usual;
        if self.roughly(next, usual).is_some() {
            return true;
        }
        let settled = self.nominal[0] / (1.0 - self.nominal[1]).max(0.1);
        let expected = self.expected(next.speed);
        let nodes = self.by_miss(|gain| expected + gain - settled);
        nodes.into_iter().take(FURTHER).any(|node| self.roughly(next, node).is_some())
    }

    /// The step that comes closest and can go on, else one that is made at all.
    fn closest(&self, now: &Passed, wished: f64, reach: &dyn Fn(f64) -> f64) -> Option<Choice> {
        let nodes = self.by_miss(|gain| reach(gain) - wished);
        let tried = nodes.into_iter().take(NEAREST);
        let mut made: Vec<(&Vec<f64>, Passed)> =
            tried.filter_map(|node| Some((node, self.roughly(now, node)?))).collect();
        made.sort_by(|a, b| (a.1.speed - wished).abs().total_cmp(&(b.1.speed - wished).abs()));
        let on = made.iter().find(|(_, next)| self.goes_on(next));
        let kind = if on.is_some() { ChoiceKind::Closest } else { ChoiceKind::Unkept };
        let (node, next) = on.or(made.first())?;
        let speed = self.ahead(now, node).map_or(next.speed, |next| next.speed);
        Some(Choice { parameters: (*node).clone(), predicted: Some(speed), steps: None, kind })
    }

    /// Combinations in the order of how much they miss.
    fn by_miss(&self, miss: impl Fn(f64) -> f64) -> Vec<&Vec<f64>> {
        let mut nodes: Vec<&(Vec<f64>, f64)> = self.nodes.iter().collect();
        nodes.sort_by(|a, b| miss(a.1).abs().total_cmp(&miss(b.1).abs()));
        nodes.into_iter().map(|(node, _)| node).collect()
    }
}

/// Whether a step has the speed that is wished.
fn met(next: &Passed, wished: f64) -> bool {
    (next.speed - wished).abs() <= MISSED * wished.max(1.0)
}

/// Distance of parameters, each relative to its range.
fn distance(choices: &Choices, a: &[f64], b: &[f64]) -> f64 {
    let part = |(index, values): &(usize, Vec<f64>)| {
        let range = values.last().zip(values.first()).map_or(1.0, |(high, low)| high - low);
        ((a[*index] - b[*index]) / range).powi(2)
    };
    choices.axes.iter().map(part).sum::<f64>().sqrt()
}
