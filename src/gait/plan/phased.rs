//! Plans of gaits of several phases: as the thesis makes them (7.2.2), going as far as possible in each step.
//!
//! Each step takes its parameters at mid-stance and is followed as it is, from the posture that the one before has left; with `alike` from that of
//! a step of its own kind. A faster mid-stance makes a faster next one, so that the farthest step is best as far as speed is what it leaves.
use super::{MOST_STEPS, PlanOptions, Planning, Plans};
use crate::gait::chain::Chains;
use crate::gait::{Hop, MidStance, PhasedBench, Refused};
use crate::progress::Run;
use bipedc_analysis::gait::{Plan, PlannedStep, Reason, Unreached, Watch, in_parallel, zero};
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Pairs of values on either side of the wished speed between which it is looked for.
const TRIED: usize = 4;
/// A plan ends so close to the wished speed, as a part of it: as exactly as steps at their limits are known.
const MEETS: f64 = 1e-6;
/// A step that comes to rest passes its dead centre with so little speed, per s.
const RESTS: f64 = 1e-3;
/// Part of a speed by which a step must come closer, or no further one does.
const CLOSER: f64 = 1e-6;

impl PhasedBench {
    /// The fewest steps from each speed to the wished one; `specs` are the phases of the robot's description.
    ///
    /// # Errors
    /// Parameters that the gait does not have, ranges and speeds that are none, too many choices; a present step that is none.
    pub fn plans(
        &self,
        specs: &[PhaseSpec],
        options: &PlanOptions,
        run: &Run<'_>,
    ) -> Result<Plans, Diagnostics> {
        let (choices, now) = self.choices(options)?;
        let chains = Chains::new(self, specs)
            .map_err(|error| error.or_in_file(&self.file))?
            .assuming(options.assume)?;
        let present = chains.ask(|chain| chain.mid_stance(&now, 1.0)).map_err(|why| {
            Diagnostic::error(format!("the present step is none: {why}"))
                .help("name other parameters of the present step by --from")
        })?;
        let ways = Ways { chains, nodes: choices.nodes(), alike: options.alike };
        let most = options.most.clamp(1, MOST_STEPS);
        let plans =
            self.each_plan(options, run, |speed| ways.plan(&present.at(speed), options.to, (most, run.stop)));
        Ok(self.planned(options, (&choices, &now), plans))
    }
}

/// Steps with all combinations of values.
struct Ways<'b> {
    chains: Chains<'b>,
    nodes: Vec<Vec<f64>>,
    alike: bool,
}

/// Whether an end is asked for.
type Stop<'s> = &'s dyn Fn() -> bool;

/// A step with the parameters of a node; speeds that fall back are negative.
struct Reached {
    node: usize,
    speed: f64,
    next: Option<MidStance>,
}

impl Ways<'_> {
    fn plan(&self, from: &MidStance, to: f64, (most, stop): (usize, Stop<'_>)) -> Option<Plan> {
        let (mut steps, mut reach): (Vec<PlannedStep>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
        if from.speed == to {
            return Some(Plan { steps: Ok(steps), reach });
        }
        let mut now = from.clone();
        while reach.len() < most {
            let (reached, refused) = self.reached(&now, stop)?;
            let passing = || reached.iter().filter(|step| step.next.is_some());
            let slow = passing().min_by(|a, b| a.speed.total_cmp(&b.speed));
            let fast = passing().max_by(|a, b| a.speed.total_cmp(&b.speed));
            let (Some(slow), Some(fast)) = (slow, fast) else {
                return Some(Plan { steps: Err(not_made(steps.len(), refused)), reach });
            };
            // Between a step that falls back and one that does not lies one that comes to rest.
            let falls = reached.iter().any(|step| step.speed < 0.0);
            reach.push([if falls { 0.0 } else { slow.speed }, fast.speed]);
            if let Some(last) = self.last_step(&reached, &now, to) {
                steps.push(last);
                return Some(Plan { steps: Ok(steps), reach });
            }
            let best = if to > fast.speed { fast } else { slow };
            if (best.speed - to).abs() >= (now.speed - to).abs() * (1.0 - CLOSER) && !steps.is_empty() {
                break;
            }
            steps.push(planned(&self.nodes[best.node], best.speed));
            now = best.next.clone()?;
        }
        Some(Plan { steps: Err(unreached(&reach, to)), reach })
    }

    /// The steps with all nodes, and why those that are not made are not; `None`: an end was asked for.
    fn reached(&self, now: &MidStance, stop: Stop<'_>) -> Option<(Vec<Reached>, Vec<Refused>)> {
        let watch = Watch { advance: &|_| {}, stop };
        let mut found = in_parallel(self.nodes.len(), &watch, |job| self.hop(now, &self.nodes[job]));
        if found.len() < self.nodes.len() {
            return None;
        }
        found.sort_by_key(|(job, _)| *job);
        let (mut reached, mut refused) = (Vec::new(), Vec::new());
        for (node, hop) in found {
            let next = hop.map(|hop| (hop.square.abs().sqrt().copysign(hop.square), hop.next));
            let (speed, next) = next.unwrap_or_else(|why| (f64::NAN, Err(why)));
            refused.extend(next.as_ref().err().cloned());
            if !speed.is_nan() {
                reached.push(Reached { node, speed, next: next.ok() });
            }
        }
        Some((reached, refused))
    }

    fn hop(&self, now: &MidStance, values: &[f64]) -> Result<Hop, Refused> {
        match self.alike {
            true => self.chains.hop(values, values, now.speed),
            false => self.chains.onward(now, values),
        }
    }

    /// The step that ends with the wished speed itself, on the line between two nodes.
    fn last_step(&self, reached: &[Reached], now: &MidStance, to: f64) -> Option<PlannedStep> {
        let side = |wanted: fn(&Reached, f64) -> bool| {
            let mut all: Vec<&Reached> = reached.iter().filter(|step| wanted(step, to)).collect();
            all.sort_by(|a, b| (a.speed - to).abs().total_cmp(&(b.speed - to).abs()));
            all
        };
        let slow = side(|step, to| step.speed <= to);
        let fast = side(|step, to| step.speed >= to && step.next.is_some());
        slow.iter().zip(&fast).take(TRIED).find_map(|(slow, fast)| self.between([slow, fast], now, to))
    }

    fn between(&self, [slow, fast]: [&Reached; 2], now: &MidStance, to: f64) -> Option<PlannedStep> {
        let place = |part: f64| -> Vec<f64> {
            let pairs = self.nodes[slow.node].iter().zip(&self.nodes[fast.node]);
            pairs.map(|(a, b)| if part == 1.0 { *b } else { a + part * (b - a) }).collect()
        };
        let square = |speed: f64| speed * speed.abs();
        // Near enough is met: every place costs a step.
        let enough = if to > 0.0 { [-MEETS * to * to, MEETS * to * to] } else { [0.0, 0.1 * RESTS * RESTS] };
        let miss = |part: f64| {
            let miss = self.hop(now, &place(part)).map_or(f64::NAN, |hop| hop.square - to * to);
            if (enough[0]..=enough[1]).contains(&miss) { 0.0 } else { miss }
        };
        let ends = [square(slow.speed) - to * to, square(fast.speed) - to * to];
        let part = zero(miss, (0.0, ends[0]), (1.0, ends[1]));
        // On the fast side by the least that counts.
        let nudged = (1..=50).rev().map(|k| part + (1.0 - part) * 0.5f64.powi(k));
        let close = if to > 0.0 { MEETS * to } else { RESTS };
        let meets = |part: f64| {
            let values = place(part);
            let speed = self.hop(now, &values).ok()?.next.ok()?.speed;
            ((speed - to).abs() <= close).then(|| planned(&values, speed))
        };
        std::iter::once(part).chain(nudged).find_map(meets)
    }
}

fn planned(parameters: &[f64], speed: f64) -> PlannedStep {
    PlannedStep { parameters: parameters.to_vec(), speed, energy: 0.5 * speed * speed }
}

/// Why no step goes on after so many; the first that does not fall back tells more than those that do.
fn not_made(count: usize, refused: Vec<Refused>) -> Unreached {
    match refused.into_iter().find(|refused| refused.reason != Reason::FallsBack) {
        Some(first) => Unreached::NotMade(count, first.reason, first.to_string()),
        None => Unreached::Falls(count),
    }
}

fn unreached(reach: &[[f64; 2]], to: f64) -> Unreached {
    let high = reach.iter().map(|ends| ends[1]).fold(0.0, f64::max);
    let low = reach.iter().map(|ends| ends[0]).fold(f64::INFINITY, f64::min);
    match (to > high, to < low) {
        (true, _) => Unreached::TooFast(high),
        (_, true) => Unreached::TooSlow(low),
        _ => Unreached::NoWay,
    }
}
