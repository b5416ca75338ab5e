//! A gait that was just found, walked from event to event: what its ground and its joints have to bear under its own controller.
use super::gait::begin_at;
use super::walking::figure;
use super::{Walker, plant, walker};
use crate::gait::optimise::weight;
use crate::gait::{AnyBench, Chain, light};
use bipedc_analysis::gait::Margins;
use bipedc_analysis::simulate::phases::{WalkEnd, WalkSummary, Walking};
use bipedc_analysis::simulate::{Plant, Run, Sample, Scenario};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::Collocation;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::model::{Argument, Model, State};
use serde::Serialize;
use std::path::Path;

/// Steps that are walked.
const STEPS: usize = 5;
/// Samples of a step.
const SAMPLES: f64 = 1600.0;

/// The whole robot under its own controller: smallest distances from limits over whole steps, not at nodes alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WalkedMargins {
    /// Steps that were made of those that were wished.
    pub steps: usize,
    /// The assumption of a walk that did not hold: slipping, pulling, tipping, scuffing, joint stops, a second impact.
    pub verdict: Option<String>,
    /// Mean over the last step, m/s.
    pub walking_speed: Option<f64>,
    /// Largest \|F_x\|/F_z on a foot that carries more than a hundredth of the weight.
    pub friction: f64,
    /// The same of impulses.
    pub impact_friction: Option<f64>,
    /// Smallest vertical impulse on a foot that an impact holds, N s.
    pub impulse: Option<f64>,
    /// Smallest distance of a centre of pressure from an end of the sole over which the phase does not end, m.
    pub zmp: Option<f64>,
    /// Lowest height of a foot in the air over the middle four fifths of each phase, before one of its points lands, m.
    pub clearance: Option<f64>,
    /// Smallest distance of a torque from its limit, N m.
    pub torque: Option<f64>,
    /// Smallest distance of a joint from its limits, rad or m.
    pub joint: Option<f64>,
    /// Smallest distance of a joint's speed from its limit, rad/s or m/s.
    pub velocity: Option<f64>,
}

impl WalkedMargins {
    /// Takes what a step's margins are smaller in; `friction`: the coefficient that these were held against.
    pub(crate) fn no_better_than(&mut self, step: &Margins, friction: Option<f64>) {
        if let Some((coefficient, margin)) = friction.zip(step.friction) {
            self.friction = self.friction.max(coefficient - margin);
        }
        let pairs = [
            (&mut self.impulse, step.impact_pull),
            (&mut self.zmp, step.zmp),
            (&mut self.clearance, step.clearance),
            (&mut self.torque, step.torque),
            (&mut self.joint, step.joint),
            (&mut self.velocity, step.velocity),
        ];
        for (own, margin) in pairs {
            if let Some(margin) = margin.filter(|margin| margin.is_finite()) {
                lower(own, margin);
            }
        }
    }
}

/// A robot whose gaits are tried.
pub struct Trial {
    robot: Robot,
    walker: Walker,
    plant: Plant,
}

/// A moment of a walk.
struct Moment {
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    effort: Vec<f64>,
    forces: Vec<[f64; 3]>,
}

impl Trial {
    /// The robot in the world of the gait.
    ///
    /// # Errors
    /// As [`walker`].
    pub fn new(robot: &Robot, of: &Collocation) -> Result<Self, Diagnostic> {
        let mut robot = robot.clone();
        robot.description = of.description.clone();
        let plant = plant(&robot.description, &robot.tree()?)?;
        Ok(Self { walker: walker(&robot)?, plant, robot })
    }

    /// Its phases.
    pub fn walker(&self) -> &Walker {
        &self.walker
    }

    /// Walks a few steps from a speed φ̇ at the dead centre, each of about this duration (s).
    ///
    /// # Errors
    /// There is no such step; the controller refuses a state.
    pub fn walk(
        &self,
        (bench, of): (&AnyBench, &Collocation),
        (speed, duration): (f64, f64),
        (friction, gait): (f64, &Path),
    ) -> Result<WalkedMargins, Diagnostics> {
        let text = format!(
            "method = \"event_driven\"\nduration = {:?}\nsteps = {STEPS}\nlog_step = {:?}\n[assumptions]\nfriction = {friction:?}\n[initial]\n\
             mid_stance_speed = {speed:?}\n[control]\ngait = \"found\"\n",
            (STEPS as f64 + 2.0) * duration,
            duration / SAMPLES
        );
        let mut scenario = Scenario::parse(gait, &text, &self.plant)?;
        let mut moments: Vec<Moment> = Vec::new();
        let mut watch = |sample: &Sample| {
            moments.push(Moment {
                time: sample.time,
                q: sample.q.clone(),
                v: sample.v.clone(),
                effort: sample.effort.clone(),
                forces: sample.forces.clone(),
            });
        };
        let mut row = |_: &[f64]| Ok(());
        let mut run = Run { row: &mut row, progress: &|_| (), stop: &|| false };
        let summary = match bench {
            AnyBench::OnePhase(bench) => {
                begin_at(&mut scenario, bench.beginning(&bench.values(&[])?, speed)?, (0, 0));
                let controller = bench.controller(Default::default(), &[])?;
                self.walking(&scenario).run_with(controller, &mut run, &mut watch)?
            }
            AnyBench::Phased(bench) => {
                let controller = bench.controller(None, &[])?;
                let chain = Chain::new(bench, &self.walker.phases, controller.clone())?;
                begin_at(&mut scenario, chain.beginning(&bench.values(&[])?, speed)?, (0, 0));
                scenario.phase = chain.first()?;
                self.walking(&scenario).run_with(controller, &mut run, &mut watch)?
            }
        };
        Ok(self.judged(of, &moments, &summary))
    }

    fn walking<'a>(&'a self, scenario: &'a Scenario) -> Walking<'a> {
        self.walker.walking(&self.plant, scenario)
    }

    fn judged(&self, of: &Collocation, moments: &[Moment], summary: &WalkSummary) -> WalkedMargins {
        let verdict = summary.verdict.as_ref().map(|found| {
            format!(
                "in phase `{}` {}: {} is {} {}, the limit is {}",
                found.phase,
                found.meaning,
                found.quantity,
                figure(found.value),
                found.unit,
                figure(found.limit)
            )
        });
        let ended = || "the walk ended before its steps were made".to_owned();
        let verdict = verdict.or_else(|| (summary.end != WalkEnd::Steps).then(ended));
        let mut found = WalkedMargins {
            steps: summary.steps,
            verdict,
            walking_speed: last_speed(moments, summary, of.phases.len()),
            friction: 0.0,
            impact_friction: None,
            impulse: None,
            zmp: None,
            clearance: None,
            torque: None,
            joint: None,
            velocity: None,
        };
        for impulse in summary.changes.iter().flat_map(|change| &change.impulse) {
            lower(&mut found.impulse, impulse.z);
            let needed = impulse.x.abs() / impulse.z.max(1e-12);
            found.impact_friction = Some(found.impact_friction.unwrap_or(0.0).max(needed));
        }
        let first = of.phases.first().map_or("", |phase| phase.name.as_str());
        let (mut begin, mut name, mut swapped, mut next) = (0.0, first, false, 0);
        for change in summary.changes.iter().map(Some).chain([None]) {
            let end = change.map_or(summary.time, |change| change.time);
            let until = next + moments[next..].iter().take_while(|moment| moment.time < end).count();
            if let Some(p) = of.phases.iter().position(|phase| phase.name == name) {
                for moment in &moments[next..until] {
                    // A phase that was cut off has no middle.
                    let part = change.map(|_| (moment.time - begin) / (end - begin));
                    self.moment(&mut found, (of, p, swapped), moment, part);
                }
                swapped ^= of.changes[p].relabel;
            }
            (begin, next) = (end, until);
            name = change.map_or("", |change| change.to.as_str());
        }
        found
    }

    fn moment(
        &self,
        found: &mut WalkedMargins,
        (of, p, swapped): (&Collocation, usize, bool),
        moment: &Moment,
        part: Option<f64>,
    ) {
        let weight = weight(of);
        let phase = &of.phases[p];
        let feet = &self.robot.description.feet;
        let role = |foot: usize| if swapped && feet.len() == 2 { 1 - foot } else { foot };
        let state = State::new().with(Argument::Q, &moment.q);
        let heights = self.heights(&state, moment.forces.len());
        let mut point = 0;
        for (index, foot) in feet.iter().enumerate() {
            let own = point..point + foot.points.len();
            point = own.end;
            let name = &feet[role(index)].name;
            let stands = phase.forces.iter().position(|force| force.split('/').next() == Some(name));
            let forces = &moment.forces[own.clone()];
            let sum = |axis: usize| forces.iter().map(|force| force[axis]).sum::<f64>();
            match stands {
                Some(first) => {
                    if sum(2) > light() * weight {
                        found.friction = found.friction.max(sum(0).abs() / sum(2));
                    }
                    let held = phase.feet.iter().flatten().find(|foot| foot.force[0] == first);
                    let Some(held) = held.filter(|held| held.holds && held.moment.is_some()) else {
                        continue;
                    };
                    let middle: f64 =
                        foot.points.iter().map(|p| p.position[0]).sum::<f64>() / forces.len() as f64;
                    let moments = foot.points.iter().zip(forces);
                    let centre = moments.map(|(p, f)| (p.position[0] - middle) * f[2]).sum::<f64>() / sum(2);
                    for side in (0..2).filter(|&side| held.level[side]) {
                        lower(&mut found.zmp, [-1.0, 1.0][side] * (held.sole[side] - centre));
                    }
                }
                None => {
                    let point = of.tree.points.iter().position(|p| p.name.split('/').next() == Some(name));
                    let swings = point.is_some_and(|point| of.swings(p, point));
                    if swings && part.is_some_and(|part| (0.1..=0.9).contains(&part)) {
                        heights[own].iter().for_each(|&height| lower(&mut found.clearance, height));
                    }
                }
            }
        }
        self.joints(found, moment);
    }

    fn heights(&self, state: &State<'_, f64>, points: usize) -> Vec<f64> {
        let model = &self.walker.model;
        let mut heights = vec![f64::NAN; points];
        let function = Model::<f64>::function(model, "contact_distances");
        if function.is_none_or(|function| model.evaluate(function, state, &mut heights).is_err()) {
            heights.fill(f64::NAN);
        }
        heights
    }

    fn joints(&self, found: &mut WalkedMargins, moment: &Moment) {
        let first = moment.q.len() - moment.effort.len();
        for (joint, effort) in moment.effort.iter().enumerate() {
            if let Some(limit) = self.plant.effort_limits[joint] {
                lower(&mut found.torque, limit - effort.abs());
            }
            if let Some([low, high]) = self.plant.position_limits[joint] {
                let q = moment.q[first + joint];
                lower(&mut found.joint, (q - low).min(high - q));
            }
            if let Some(limit) = self.plant.velocity_limits[joint] {
                lower(&mut found.velocity, limit - moment.v[first + joint].abs());
            }
        }
    }
}

fn lower(of: &mut Option<f64>, by: f64) {
    *of = Some(of.map_or(by, |x| x.min(by)));
}

/// Mean speed of the base over the last whole step of so many phases, m/s: from the same change of phases one step before to the last one. A walk may end with
/// a landing in the middle of a step.
fn last_speed(moments: &[Moment], summary: &WalkSummary, phases: usize) -> Option<f64> {
    let last = summary.changes.last()?;
    let before = summary.changes.len().checked_sub(phases + 1).and_then(|k| summary.changes.get(k))?;
    let place = |time: f64| {
        // Velocities jump at changes: a place is read from what the phase before went through.
        let began =
            summary.changes.iter().map(|change| change.time).rfind(|&change| change < time).unwrap_or(0.0);
        let mut through: Vec<&Moment> =
            moments.iter().filter(|moment| (began..=time).contains(&moment.time)).collect();
        through.dedup_by(|a, b| a.time <= b.time);
        extrapolated(&through[through.len().saturating_sub(3)..], time)
    };
    Some((place(last.time)? - place(before.time)?) / (last.time - before.time))
}

/// Of the base along x at a time, m, by the polynomial through some moments; one alone tells no speed.
fn extrapolated(through: &[&Moment], time: f64) -> Option<f64> {
    let term = |k: usize| -> f64 {
        let others = through.iter().enumerate().filter(|(other, _)| *other != k);
        others.fold(through[k].q[0], |term, (_, other)| {
            term * (time - other.time) / (through[k].time - other.time)
        })
    };
    (through.len() > 1).then(|| (0..through.len()).map(term).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_analysis::simulate::phases::{Effort, PhaseChange, Projected};

    /// Two phases, fast and slow in turn; the walk ends with the fast one.
    #[test]
    fn a_walk_that_ends_inside_a_step_has_the_speed_of_a_whole_one() {
        let times = [0.1, 0.4, 0.5, 0.8, 0.9];
        let speeds = [1.0, 0.2];
        let place = |time: f64| {
            let (whole, part) = ((time / 0.4 + 1e-9).floor(), time - 0.4 * (time / 0.4 + 1e-9).floor());
            whole * (0.1 * speeds[0] + 0.3 * speeds[1])
                + part.min(0.1) * speeds[0]
                + (part - 0.1).max(0.0) * speeds[1]
        };
        let moment = |k: usize| {
            let time = k as f64 * 0.01;
            Moment { time, q: vec![place(time)], v: Vec::new(), effort: Vec::new(), forces: Vec::new() }
        };
        let moments: Vec<Moment> = (0..90).map(moment).collect();
        let change = |time: f64| PhaseChange {
            time,
            from: String::new(),
            to: String::new(),
            impulse: Vec::new(),
            planned: true,
        };
        let summary = WalkSummary {
            rows: 0,
            time: 0.9,
            steps: 3,
            end: WalkEnd::Steps,
            verdict: None,
            changes: times.map(change).into(),
            unplanned: 0,
            projected: Projected::default(),
            integration: Effort::default(),
            fastest: None,
        };
        let found = last_speed(&moments, &summary, 2).unwrap();
        assert!((found - 0.4).abs() < 1e-9, "{found}");
    }
}
