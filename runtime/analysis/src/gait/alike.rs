//! Plans as the thesis makes them (7.2.1): every step is taken as one among its own kind, so that its speed is all that it leaves.
//!
//! Then v[k+1]² is affine in v[k]² with the slope δ > 0: a faster step is never worse on the way to a high speed, nor a slower one on the
//! way to a low one. What one step reaches from a speed is an interval, and to go as far as possible in each step is optimal.
use super::functions::GaitModel;
use super::kept::Kept;
use super::plan::{Plan, PlannedStep};
use super::reach::{Choices, Transition, Unreached};
use super::search::zero;
use super::workers::{Watch, in_parallel};

/// Parts of a speed by which a step must come closer, or no further one does.
const CLOSER: f64 = 1e-9;

/// All steps that follow their own kind.
#[derive(Clone)]
pub struct Alike<'a, 'm> {
    gait: &'m GaitModel<'a>,
    nodes: Vec<Vec<f64>>,
    steps: Vec<Option<Transition>>,
    kept: Kept,
}

impl<'a> GaitModel<'a> {
    /// All choices as steps that follow their own kind, each of which keeps what is assumed; `None`: an end was asked for.
    pub fn alike(&self, choices: &Choices, kept: Kept, watch: &Watch<'_>) -> Option<Alike<'a, '_>> {
        let nodes = choices.nodes();
        let mut found = in_parallel(nodes.len(), watch, |job| self.alike_step(&nodes[job], &kept));
        if found.len() < nodes.len() {
            return None;
        }
        found.sort_by_key(|(job, _)| *job);
        let steps = found.into_iter().map(|(_, step)| step).collect();
        Some(Alike { gait: self, steps, nodes, kept })
    }

    fn alike_step(&self, parameters: &[f64], kept: &Kept) -> Option<Transition> {
        let course = self.steady_course(parameters).ok()?;
        Transition::of(&course, &course.landing, kept)
    }
}

impl Alike<'_, '_> {
    /// The fewest steps from mid-stance with the speed `from` to mid-stance with the speed `to`, both per s; at most `most`.
    pub fn plan(&self, from: f64, to: f64, most: usize) -> Plan {
        let (mut steps, mut reach, mut speed): (Vec<PlannedStep>, Vec<[f64; 2]>, f64) =
            (Vec::new(), Vec::new(), from);
        if from == to {
            return Plan { steps: Ok(steps), reach };
        }
        while reach.len() < most {
            let speeds = self.speeds(speed);
            let Some([slow, fast]) = ends(&speeds) else {
                return Plan { steps: Err(Unreached::after(steps.len(), &self.kept)), reach };
            };
            // Between a step that falls back and one that does not lies one that comes to rest.
            let falls = speeds.iter().flatten().any(|speed| *speed <= 0.0);
            reach.push([if falls { 0.0 } else { speeds[slow].unwrap_or(0.0) }, speeds[fast].unwrap_or(0.0)]);
            if let Some(last) = self.last_step(&speeds, speed, to) {
                steps.push(last);
                return Plan { steps: Ok(steps), reach };
            }
            let best = if reach.last().is_some_and(|ends| to > ends[1]) { fast } else { slow };
            let next = speeds[best].unwrap_or(0.0);
            if (next - to).abs() >= (speed - to).abs() * (1.0 - CLOSER) && !steps.is_empty() {
                break;
            }
            steps.push(self.planned(&self.nodes[best], speed, next));
            speed = next;
        }
        let high = reach.iter().map(|ends| ends[1]).fold(0.0, f64::max);
        let low = reach.iter().map(|ends| ends[0]).fold(f64::INFINITY, f64::min);
        let why = match (to > high, to < low) {
            (true, _) => Unreached::TooFast(high),
            (_, true) => Unreached::TooSlow(low),
            _ => Unreached::NoWay,
        };
        Plan { steps: Err(why), reach }
    }

    /// The next speed of each node, negative where the step falls back; none where it breaks what is assumed.
    fn speeds(&self, speed: f64) -> Vec<Option<f64>> {
        self.steps
            .iter()
            .map(|step| {
                let (step, energy) = step.as_ref().map(|step| (step, step.alike_energy(speed)))?;
                step.may_end(energy).then(|| step.signed_speed(energy))
            })
            .collect()
    }

    fn planned(&self, parameters: &[f64], before: f64, speed: f64) -> PlannedStep {
        let step = self.gait.alike_step(parameters, &self.kept);
        let energy = step.map_or(f64::NAN, |step| step.alike_energy(before));
        PlannedStep { parameters: parameters.to_vec(), speed, energy }
    }

    /// The step that ends with the wished speed itself, on the line between two nodes.
    fn last_step(&self, speeds: &[Option<f64>], speed: f64, to: f64) -> Option<PlannedStep> {
        let closest = |wanted: fn(f64) -> bool| {
            let misses = speeds.iter().enumerate().filter_map(|(k, speed)| Some((k, (*speed)? - to)));
            misses.filter(|(_, miss)| wanted(*miss)).min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        };
        let (slow, _) = closest(|miss| miss <= 0.0)?;
        let (fast, _) = closest(|miss| miss >= 0.0)?;
        let place = |part: f64| -> Vec<f64> {
            let pairs = self.nodes[slow].iter().zip(&self.nodes[fast]);
            pairs.map(|(a, b)| if part == 1.0 { *b } else { a + part * (b - a) }).collect()
        };
        let miss = |part: f64| {
            let step = self.gait.alike_step(&place(part), &self.kept);
            step.map_or(f64::NAN, |step| step.miss(step.alike_energy(speed), to))
        };
        let (low, high) = (miss(0.0), miss(1.0));
        let part = zero(miss, (0.0, low), (1.0, high));
        // On the fast side by the least that counts.
        let nudged = (1..=50).rev().map(|k| part + (1.0 - part) * 0.5f64.powi(k));
        let mut passing = std::iter::once(part).chain(nudged).chain([1.0]).map(|part| {
            let parameters = place(part);
            let step = self.gait.alike_step(&parameters, &self.kept)?;
            let energy = step.alike_energy(speed);
            let next = step.signed_speed(energy);
            (next > 0.0 && step.passes(energy)).then(|| self.planned(&parameters, speed, next))
        });
        passing.find_map(|step| step).filter(|step| (step.speed - to).abs() <= 1e-6 * to.max(1.0))
    }
}

impl Transition {
    /// E of a step that follows one with its own parameters and this speed, per s.
    fn alike_energy(&self, speed: f64) -> f64 {
        self.delta * (0.5 * (self.alpha_m * speed).powi(2) + self.p_max - self.p_minus)
    }
}

/// The slowest and the fastest step that do not fall back.
fn ends(speeds: &[Option<f64>]) -> Option<[usize; 2]> {
    let passing =
        || speeds.iter().enumerate().filter_map(|(k, speed)| Some((k, (*speed).filter(|x| *x > 0.0)?)));
    let slow = passing().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let fast = passing().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some([slow.0, fast.0])
}
