//! Choosing the parameters of the next step at mid-stance, so that it passes its own mid-stance with a wished speed (thesis 6.23).
//!
//! Parameters are taken at once: see [`super::hop`]. Where a wished speed can be met in one step, the parameters nearest to the usual
//! ones are taken that meet it; else the first step of a shortest way to it over a grid of parameters; else the step that comes closest.
use super::functions::GaitModel;
use super::hop::{Half, Hop, MidStance};
use super::kept::Kept;
use super::reach::Choices;
use super::search::zero;
use super::workers::{Watch, in_parallel};
use serde::Serialize;

/// Ways from the usual parameters on which the wished speed is looked for.
const TRIED: usize = 8;
/// Most steps that a way to a speed is looked for.
const MOST: usize = 10;
/// States that are kept of each choice of parameters: the least and the largest of so many equal parts.
const PARTS: usize = 8;
/// By how much a speed may be missed, as a part of it or of 1.
const MISSED: f64 = 1e-7;

/// What is chosen from, and what is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct ChoiceSettings {
    /// Values of the grid; all between the smallest and the largest may be chosen.
    pub choices: Choices,
    /// Parameters to which others are preferred the less the farther they are away, each relative to its range.
    pub usual: Vec<f64>,
    /// What steps have to keep.
    pub kept: Kept,
}

/// How a choice was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChoiceKind {
    /// The next step meets the wished speed.
    Meets,
    /// It is the first one on a shortest way to it.
    OnTheWay,
    /// No way was found: the next step comes as close as it can.
    Closest,
    /// The same, and what is to be kept is not.
    Unkept,
    /// Whatever is chosen falls: parameters stay.
    None,
}

impl ChoiceKind {
    /// For tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Meets => "meets",
            Self::OnTheWay => "on the way",
            Self::Closest => "closest",
            Self::Unkept => "unkept",
            Self::None => "none",
        }
    }
}

/// Parameters of the next step.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// All of them.
    pub parameters: Vec<f64>,
    /// φ̇ at the next mid-stance, per s.
    pub predicted: Option<f64>,
    /// Steps to the wished speed, as far as they are known.
    pub steps: Option<usize>,
    /// How it was made.
    pub kind: ChoiceKind,
}

/// Chooses parameters of next steps.
pub struct Chooser<'a, 'm> {
    gait: &'m GaitModel<'a>,
    settings: ChoiceSettings,
    /// Steps of the grid after their own kind.
    halves: Vec<Half>,
    /// From each to each; the second one changes fastest.
    hops: Vec<Option<Hop>>,
    /// Pairs of neighbours of the grid, along its diagonals too.
    neighbours: Vec<[usize; 2]>,
}

/// A way from the present mid-stance that was computed as it is.
struct Trial {
    parameters: Vec<f64>,
    hop: Hop,
    /// K at the next dead centre.
    next: f64,
    half: Half,
}

/// What a step on a way leaves.
#[derive(Debug, Clone, Copy)]
struct Reached {
    /// Of the grid.
    node: usize,
    /// K at its dead centre.
    k: f64,
    /// The first step of the way.
    first: usize,
}

impl<'a> GaitModel<'a> {
    /// Computes all steps between the values of the grid; `None`: an end was asked for.
    pub fn chooser(&self, mut settings: ChoiceSettings, watch: &Watch<'_>) -> Option<Chooser<'a, '_>> {
        let nodes = settings.choices.nodes();
        settings.kept.off_stops = self.off_stops(&settings.usual, settings.kept.off_stops);
        let kept = settings.kept;
        let quiet = Watch { advance: &|_| (), stop: watch.stop };
        let mut halves = in_parallel(nodes.len(), &quiet, |job| self.half(&nodes[job], &kept).ok());
        halves.sort_by_key(|(job, _)| *job);
        let complete = halves.len() == nodes.len();
        let halves: Vec<Half> = halves.into_iter().filter_map(|(_, half)| half).collect();
        let mut rows = in_parallel(halves.len(), watch, |job| {
            let hop = |to: &Half| self.hop(halves[job].mid_stance(), to, &kept).ok();
            halves.iter().map(hop).collect::<Vec<_>>()
        });
        rows.sort_by_key(|(job, _)| *job);
        let complete = complete && rows.len() == halves.len();
        let hops = rows.into_iter().flat_map(|(_, row)| row).collect();
        let mut chooser = Chooser { gait: self, settings, halves, hops, neighbours: Vec::new() };
        chooser.neighbours = chooser.pairs();
        complete.then_some(chooser)
    }
}

impl Chooser<'_, '_> {
    /// The parameters to take at mid-stance in this state (q: nq, v: nv; legs named by their roles), to pass the next one with the
    /// speed `wished`, per s; 0: to come to rest there. `present`: parameters of the present step.
    pub fn choose(&self, q: &[f64], v: &[f64], wished: f64, present: &[f64]) -> Choice {
        let [phase, rate] = self.gait.phase_at(q, v);
        let k = 0.5 * self.gait.momentum(q, v).powi(2);
        let stays =
            Choice { parameters: present.to_vec(), predicted: None, steps: None, kind: ChoiceKind::None };
        if !(rate > 0.0 && k.is_finite()) {
            return stays;
        }
        let now = Now { mid: MidStance { q, v, phase, rate }, k };
        let kept = &self.settings.kept;
        let first: Vec<Option<Hop>> =
            self.halves.iter().map(|to| self.gait.hop(now.mid, to, kept).ok()).collect();
        if let Some(trial) = self.meeting(&now, &first, wished) {
            return trial.chosen(ChoiceKind::Meets, Some(1));
        }
        if let Some((node, steps)) = self.on_the_way(&now, &first, wished) {
            let speed = first[node].and_then(|hop| Some(hop.speed(hop.next(now.k)?)));
            let parameters = self.halves[node].parameters.clone();
            return Choice { parameters, predicted: speed, steps: Some(steps), kind: ChoiceKind::OnTheWay };
        }
        self.closest(&now, &first, wished).unwrap_or(stays)
    }

    /// Parameters with which the next step meets a speed, everything is kept, and a further step is possible.
    fn meeting(&self, now: &Now<'_>, first: &[Option<Hop>], wished: f64) -> Option<Trial> {
        let miss = |hop: &Hop| Some(hop.next(now.k)? - hop.of_speed(wished));
        let usual = self.trial(now, &self.settings.usual).and_then(|trial| {
            let miss = miss(&trial.hop)?;
            Some((self.settings.usual.clone(), miss, trial))
        });
        let nodes = || first.iter().enumerate().filter_map(|(node, hop)| Some((node, hop.as_ref()?)));
        let allowed = || nodes().filter(|(_, hop)| hop.keeps(now.k));
        let from = match usual {
            Some((_, 0.0, trial)) => return self.accepted(now, trial, wished),
            Some((parameters, miss, _)) => (parameters, miss),
            // The nearest one that is possible stands in.
            None => {
                let near = |node: usize| self.distance(&self.settings.usual, &self.halves[node].parameters);
                let (node, hop) = allowed().min_by(|a, b| near(a.0).total_cmp(&near(b.0)))?;
                (self.halves[node].parameters.clone(), miss(hop)?)
            }
        };
        let mut ways: Vec<(f64, usize, f64)> = allowed()
            .filter_map(|(node, hop)| {
                let far = miss(hop)?;
                let other_side = (far < 0.0) != (from.1 < 0.0);
                let part = from.1 / (from.1 - far);
                let distance = part * self.distance(&from.0, &self.halves[node].parameters);
                other_side.then_some((distance, node, far))
            })
            .collect();
        ways.sort_by(|a, b| a.0.total_cmp(&b.0));
        let found = ways.iter().take(TRIED).find_map(|&(_, node, far)| {
            let trial = self.between(now, (&from.0, from.1), (&self.halves[node].parameters, far), wished)?;
            self.accepted(now, trial, wished)
        });
        found.or_else(|| self.meeting_between(now, first, wished))
    }

    /// The same between neighbours of the grid, both of which keep everything.
    fn meeting_between(&self, now: &Now<'_>, first: &[Option<Hop>], wished: f64) -> Option<Trial> {
        let of = |node: usize| &self.halves[node].parameters[..];
        let near = |node| self.distance(&self.settings.usual, of(node));
        let pair = |&[a, b]: &[usize; 2]| {
            let [low, high] = [a, b].map(|node| missing(first[node].as_ref(), now.k, wished));
            let (low, high) = (low?, high?);
            ((low < 0.0) != (high < 0.0)).then(|| (near(a).min(near(b)), (a, low), (b, high)))
        };
        let mut pairs: Vec<_> = self.neighbours.iter().filter_map(pair).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs.iter().take(TRIED).find_map(|&(_, (a, low), (b, high))| {
            self.accepted(now, self.between(now, (of(a), low), (of(b), high), wished)?, wished)
        })
    }

    /// Pairs of neighbours of the grid.
    fn pairs(&self) -> Vec<[usize; 2]> {
        let axes = self.settings.choices.axes.iter();
        let diagonal: f64 = axes.map(|(_, values)| (values.len().max(2) as f64 - 1.0).powi(-2)).sum();
        let most = 1.01 * diagonal.sqrt();
        let near = |a: usize, b: usize| {
            self.distance(&self.halves[a].parameters, &self.halves[b].parameters) <= most
        };
        let count = self.halves.len();
        let of = |a: usize| (a + 1..count).filter(move |&b| near(a, b)).map(move |b| [a, b]);
        (0..count).flat_map(of).collect()
    }

    /// Where the speed is met on the straight line between two sets of parameters; each with what it misses.
    fn between(
        &self,
        now: &Now<'_>,
        (a, low): (&[f64], f64),
        (b, high): (&[f64], f64),
        wished: f64,
    ) -> Option<Trial> {
        let place = |part: f64| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| if part == 1.0 { *b } else { a + part * (b - a) }).collect()
        };
        let miss = |part: f64| {
            let trial = self.trial(now, &place(part));
            trial.map_or(f64::NAN, |trial| trial.next - trial.hop.of_speed(wished))
        };
        self.trial(now, &place(zero(miss, (0.0, low), (1.0, high))))
    }

    fn trial(&self, now: &Now<'_>, parameters: &[f64]) -> Option<Trial> {
        let kept = &self.settings.kept;
        let half = self.gait.half(parameters, kept).ok()?;
        let hop = self.gait.hop(now.mid, &half, kept).ok()?;
        Some(Trial { parameters: parameters.to_vec(), next: hop.next(now.k)?, hop, half })
    }

    /// A trial that does what is wished, keeps everything, and does not end in a fall.
    fn accepted(&self, now: &Now<'_>, trial: Trial, wished: f64) -> Option<Trial> {
        let met = (trial.hop.speed(trial.next) - wished).abs() <= MISSED * wished.max(1.0);
        // At rest nothing goes on.
        let at_rest = wished == 0.0;
        let rests = at_rest && trial.next.abs() <= 1e-9 * trial.half.p_max.abs();
        let kept = trial.hop.keeps(now.k);
        let goes_on = || at_rest || self.goes_on(&trial.half, trial.next, true);
        ((met || rests) && kept && goes_on()).then_some(trial)
    }

    /// Whether some further step passes its dead centre after one with K at its own; `keeping`: and keeps everything.
    fn goes_on(&self, half: &Half, k: f64, keeping: bool) -> bool {
        let kept = &self.settings.kept;
        let passes = |hop: Hop| (!keeping || hop.keeps(k)) && hop.next(k).is_some_and(|next| next > 0.0);
        let to = |to: &Half| self.gait.hop(half.mid_stance(), to, kept).is_ok_and(passes);
        to(half) || self.halves.iter().any(to)
    }

    /// The first step of a shortest way to a speed, and how many steps it has: the last one lies between two of the grid.
    fn on_the_way(&self, now: &Now<'_>, first: &[Option<Hop>], wished: f64) -> Option<(usize, usize)> {
        let mut states: Vec<Reached> = Vec::new();
        for (node, hop) in first.iter().enumerate() {
            let Some(hop) = hop.filter(|hop| hop.keeps(now.k)) else { continue };
            states.extend(hop.next(now.k).filter(|k| *k > 0.0).map(|k| Reached { node, k, first: node }));
        }
        for steps in 2..=MOST {
            // Of shortest ways that which goes farthest at once.
            let far = |state: &&Reached| {
                let speed = first[state.first].and_then(|hop| Some(hop.speed(hop.next(now.k)?)));
                speed.map_or(f64::INFINITY, |speed| (speed - wished).abs())
            };
            let meets = states.iter().filter(|state| self.meets(state, wished));
            let best = meets.min_by(|a, b| far(a).total_cmp(&far(b)));
            if let Some(best) = best {
                return Some((best.first, steps));
            }
            states = self.advance(&states);
        }
        None
    }

    fn row(&self, node: usize) -> &[Option<Hop>] {
        &self.hops[node * self.halves.len()..][..self.halves.len()]
    }

    /// Whether steps to neighbours of the grid after this one pass on both sides of a speed.
    fn meets(&self, state: &Reached, wished: f64) -> bool {
        let row = self.row(state.node);
        let misses: Vec<Option<f64>> = row.iter().map(|hop| missing(hop.as_ref(), state.k, wished)).collect();
        let sides = |&[a, b]: &[usize; 2]| {
            misses[a].zip(misses[b]).is_some_and(|(low, high)| (low < 0.0) != (high < 0.0))
        };
        self.neighbours.iter().any(sides)
    }

    fn advance(&self, states: &[Reached]) -> Vec<Reached> {
        let mut found: Vec<Vec<Reached>> = vec![Vec::new(); self.halves.len()];
        for state in states {
            for (node, hop) in self.row(state.node).iter().enumerate() {
                let Some(hop) = hop.filter(|hop| hop.keeps(state.k)) else { continue };
                let next = hop.next(state.k).filter(|k| *k > 0.0);
                found[node].extend(next.map(|k| Reached { node, k, first: state.first }));
            }
        }
        found.iter_mut().flat_map(|states| thinned(states)).collect()
    }

    /// The step whose speed is closest: among those that keep everything and can go on, then among those that can go on, then
    /// among all that pass.
    fn closest(&self, now: &Now<'_>, first: &[Option<Hop>], wished: f64) -> Option<Choice> {
        let passing = || {
            first.iter().enumerate().filter_map(|(node, hop)| {
                let hop = hop.as_ref()?;
                let next = hop.next(now.k).filter(|k| *k > 0.0)?;
                Some((node, hop, next, hop.speed(next)))
            })
        };
        let further = |node: usize, k: f64| {
            self.row(node).iter().flatten().any(|hop| hop.next(k).is_some_and(|next| next > 0.0))
        };
        let further_kept = |node: usize, k: f64| {
            let goes = |hop: &Hop| hop.keeps(k) && hop.next(k).is_some_and(|next| next > 0.0);
            self.row(node).iter().flatten().any(goes)
        };
        let nearest = |which: &dyn Fn(usize, &Hop, f64) -> bool| {
            passing()
                .filter(|(node, hop, next, _)| which(*node, hop, *next))
                .min_by(|a, b| (a.3 - wished).abs().total_cmp(&(b.3 - wished).abs()))
                .map(|(node, .., speed)| (node, speed))
        };
        let of_node = |(node, speed): (usize, f64), kind| {
            let parameters = self.halves[node].parameters.clone();
            Choice { parameters, predicted: Some(speed), steps: None, kind }
        };
        if let Some(kept) = nearest(&|node, hop, k| hop.keeps(now.k) && further_kept(node, k)) {
            return Some(of_node(kept, ChoiceKind::Closest));
        }
        // Where limits cannot be kept, what is far from the usual breaks them by more.
        let usual = self.trial(now, &self.settings.usual).filter(|usual| usual.next > 0.0);
        if let Some(usual) = usual.filter(|usual| self.goes_on(&usual.half, usual.next, false)) {
            return Some(usual.chosen(ChoiceKind::Unkept, None));
        }
        let passing = nearest(&|node, _, k| further(node, k)).or_else(|| nearest(&|_, _, _| true))?;
        Some(of_node(passing, ChoiceKind::Unkept))
    }

    /// Distance of parameters, each relative to its range.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let axes = self.settings.choices.axes.iter();
        let part = |(index, values): &(usize, Vec<f64>)| {
            let range = values.last().zip(values.first()).map_or(1.0, |(high, low)| high - low);
            ((a[*index] - b[*index]) / range).powi(2)
        };
        axes.map(part).sum::<f64>().sqrt()
    }
}

/// By how much K misses that of a speed after a step that keeps everything.
fn missing(hop: Option<&Hop>, k: f64, wished: f64) -> Option<f64> {
    let hop = hop.filter(|hop| hop.keeps(k))?;
    Some(hop.next(k)? - hop.of_speed(wished))
}

/// The present mid-stance.
struct Now<'q> {
    mid: MidStance<'q>,
    /// K there.
    k: f64,
}

impl Trial {
    fn chosen(self, kind: ChoiceKind, steps: Option<usize>) -> Choice {
        let predicted = Some(self.hop.speed(self.next).max(0.0));
        Choice { parameters: self.parameters, predicted, steps, kind }
    }
}

/// Of states the first and the last one of each part of what they reach.
fn thinned(states: &mut [Reached]) -> Vec<Reached> {
    states.sort_by(|a, b| a.k.total_cmp(&b.k));
    let (Some(low), Some(high)) = (states.first(), states.last()) else { return Vec::new() };
    let width = (high.k - low.k) / PARTS as f64;
    let part = |state: &Reached| if width > 0.0 { ((state.k - low.k) / width) as usize } else { 0 };
    let mut kept = Vec::new();
    for (index, state) in states.iter().enumerate() {
        let begins = index == 0 || part(&states[index - 1]) != part(state);
        let ends = states.get(index + 1).is_none_or(|next| part(next) != part(state));
        if begins || ends {
            kept.push(*state);
        }
    }
    kept
}
