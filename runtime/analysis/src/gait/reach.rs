//! The fewest steps from one mid-stance speed to another (thesis 6.23, 7.2.1): which energies can be reached, step after step.
//!
//! Parameters are chosen anew for each step. What one step leaves to all others is its own parameters, which fix the impact, and the
//! energy of the next one: more energy at the same parameters never makes a later step slower, but it may make one possible or too
//! fast. So whole sets of energies are kept for each choice of parameters.
use super::course::Course;
use super::functions::GaitModel;
use super::kept::{Between, Kept};
use super::landing::Landing;
use super::reason::Reason;
use super::step::Refusal;
use super::workers::{Watch, in_parallel};

/// Energies that are kept for each choice: the least and the largest of so many equal parts of what can be reached.
const PARTS: usize = 24;

/// Values that a plan may choose from for each step.
#[derive(Debug, Clone, PartialEq)]
pub struct Choices {
    /// Values of all parameters; those of the axes are replaced.
    pub values: Vec<f64>,
    /// Parameters (index) with their values.
    pub axes: Vec<(usize, Vec<f64>)>,
}

impl Choices {
    /// All combinations; the last axis changes fastest.
    pub fn nodes(&self) -> Vec<Vec<f64>> {
        self.axes.iter().fold(vec![self.values.clone()], |nodes, (index, values)| {
            let each = |node: &Vec<f64>| {
                let with = |&value: &f64| {
                    let mut node = node.clone();
                    node[*index] = value;
                    node
                };
                values.iter().map(with).collect::<Vec<_>>()
            };
            nodes.iter().flat_map(each).collect()
        })
    }
}

/// What a step is that follows another one, for any energy.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transition {
    pub p_minus: f64,
    pub p_max: f64,
    pub alpha_m: f64,
    /// δ of the impact at its end.
    pub delta: f64,
    /// E with which everything is kept that is assumed, the impact before it included.
    pub kept: Between,
}

impl Transition {
    /// `after`: the landing before it.
    pub fn of(course: &Course<'_, '_>, after: &Landing, kept: &Kept) -> Option<Self> {
        let Landing { delta, eta, momentum_after, .. } = course.landing;
        let goes_on = eta > 0.0 && momentum_after > 0.0 && course.singular().is_none();
        goes_on.then_some(Self {
            p_minus: course.p_minus,
            p_max: course.p_max,
            alpha_m: course.alpha_m,
            delta,
            kept: course.gait.keeps(course, after, kept),
        })
    }

    /// Energy of the step after this one; `None`: this one falls back, or breaks what is assumed.
    pub fn next(&self, energy: f64) -> Option<f64> {
        self.passes(energy).then_some(self.delta * (energy - self.p_minus))
    }

    /// Whether the dead centre is passed and everything kept.
    pub fn passes(&self, energy: f64) -> bool {
        energy > self.p_max && Kept::allows(self.kept, energy)
    }

    /// Whether what lacks is energy, if anything.
    pub fn may_end(&self, energy: f64) -> bool {
        energy <= self.p_max || self.passes(energy)
    }

    /// By how much kinetic energy at the dead centre differs from that of a speed: smooth where the speed itself is not.
    pub fn miss(&self, energy: f64, speed: f64) -> f64 {
        energy - self.p_max - 0.5 * (self.alpha_m * speed).powi(2)
    }

    /// φ̇_m; negative where the step falls back, the more the more energy it lacks.
    pub fn signed_speed(&self, energy: f64) -> f64 {
        let kinetic = energy - self.p_max;
        (2.0 * kinetic.abs()).sqrt().copysign(kinetic) / self.alpha_m
    }
}

/// All steps between all choices, for plans from any speed.
#[derive(Clone)]
pub struct Reach<'a, 'm> {
    pub(super) gait: &'m GaitModel<'a>,
    pub(super) nodes: Vec<Vec<f64>>,
    /// The step in which the robot is: one among its own kind.
    pub(super) now: Course<'a, 'm>,
    /// What is assumed of each step.
    pub(super) kept: Kept,
    /// From the present step to each node.
    first: Vec<Option<Transition>>,
    /// From node to node; the second one changes fastest.
    between: Vec<Option<Transition>>,
}

/// What a step may leave: its choice, the energy of the next one, and where it came from.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub energy: f64,
    pub node: usize,
    /// Index in the stage before.
    pub before: usize,
}

impl<'a> GaitModel<'a> {
    /// All steps between choices for a robot that walks with parameters `now`, each of which keeps what is assumed; `None`: an end was asked for.
    ///
    /// # Errors
    /// There is no such walking, whatever its speed.
    pub fn reach(
        &self,
        now: &[f64],
        choices: &Choices,
        kept: Kept,
        watch: &Watch<'_>,
    ) -> Result<Option<Reach<'a, '_>>, Refusal> {
        let now = self.steady_course(now)?;
        if let Some(phase) = now.singular() {
            return Err(Refusal::Singular(phase));
        }
        let Landing { eta, momentum_after, .. } = now.landing;
        if !(eta > 0.0 && momentum_after > 0.0) {
            return Err(Refusal::TurnsBack(eta));
        }
        let nodes = choices.nodes();
        let landings: Vec<Option<Landing>> =
            nodes.iter().map(|node| self.steady_landing(node).ok()).collect();
        // The first row is that of the present step.
        let present = now.landing.clone();
        let mut rows = in_parallel(nodes.len() + 1, watch, |job| {
            let after = if job == 0 { Some(&present) } else { landings[job - 1].as_ref() };
            let step = |(node, own): (&Vec<f64>, &Option<Landing>)| {
                let course = self.course_to(node, after?.beginning(), own.clone()?).ok()?;
                Transition::of(&course, after?, &kept)
            };
            nodes.iter().zip(&landings).map(step).collect::<Vec<_>>()
        });
        if rows.len() <= nodes.len() {
            return Ok(None);
        }
        rows.sort_by_key(|(job, _)| *job);
        let mut rows = rows.into_iter().map(|(_, row)| row);
        let first = rows.next().unwrap_or_default();
        Ok(Some(Reach { gait: self, nodes, now, kept, first, between: rows.flatten().collect() }))
    }
}

impl Reach<'_, '_> {
    /// Energy of the first step after the present one, which passes its dead centre with `speed`, per s.
    pub(super) fn first_energy(&self, speed: f64) -> f64 {
        self.now.landing.delta * (self.now.energy(speed) - self.now.p_minus)
    }

    /// The step to a node after a state; `None` for the state: after the present step.
    pub(super) fn step(&self, from: Option<usize>, to: usize) -> Option<&Transition> {
        match from {
            None => self.first[to].as_ref(),
            Some(node) => self.between[node * self.nodes.len() + to].as_ref(),
        }
    }

    /// What one more step may leave after these states; none of them: after the present step, with this energy.
    pub(super) fn advance(&self, states: Option<&[State]>, first: f64) -> Vec<State> {
        let mut found = Vec::new();
        for node in 0..self.nodes.len() {
            let candidate = |from: Option<usize>, energy: f64, before: usize| {
                let energy = self.step(from, node)?.next(energy)?;
                Some(State { energy, node, before })
            };
            let mut all: Vec<State> = match states {
                None => candidate(None, first, 0).into_iter().collect(),
                Some(states) => {
                    let each = states.iter().enumerate();
                    each.filter_map(|(k, state)| candidate(Some(state.node), state.energy, k)).collect()
                }
            };
            all.sort_by(|a, b| a.energy.total_cmp(&b.energy));
            keep(&all, &mut found);
        }
        found
    }
}

/// Of sorted states the first and the last one of each part.
fn keep(sorted: &[State], kept: &mut Vec<State>) {
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return };
    let width = (last.energy - first.energy) / PARTS as f64;
    let part = |state: &State| if width > 0.0 { ((state.energy - first.energy) / width) as usize } else { 0 };
    for (k, state) in sorted.iter().enumerate() {
        let begins = k == 0 || part(&sorted[k - 1]) != part(state);
        let ends = sorted.get(k + 1).is_none_or(|next| part(next) != part(state));
        if begins || ends {
            kept.push(*state);
        }
    }
}

impl Unreached {
    /// After so many steps no further one is made.
    pub(super) fn after(count: usize, kept: &Kept) -> Self {
        if kept.assumptions.any() { Self::NotKept(count) } else { Self::Falls(count) }
    }
}

/// Why a speed is not reached.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreached {
    /// After so many steps every further one falls back, or is none.
    Falls(usize),
    /// The same where something is assumed: every further one falls back or breaks it.
    NotKept(usize),
    /// After so many steps no further one is made, and not because each falls back: why, in one word and in words, the first of them is not.
    NotMade(usize, Reason, String),
    /// This is the highest speed that any number of steps leads to, per s.
    TooFast(f64),
    /// This is the lowest one.
    TooSlow(f64),
    /// Speeds on both sides can be reached, but no way between them was found on which every step is possible.
    NoWay,
}

impl Unreached {
    /// As files have it.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Falls(_) => Reason::FallsBack.code(),
            Self::NotKept(_) => "not_kept",
            Self::NotMade(_, reason, _) => reason.code(),
            Self::TooFast(_) => "too_fast",
            Self::TooSlow(_) => "too_slow",
            Self::NoWay => "no_way",
        }
    }
}
