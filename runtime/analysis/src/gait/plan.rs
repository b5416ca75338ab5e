//! Plans: the parameters of each step on the shortest way to a speed.
use super::reach::{Reach, State, Transition, Unreached};
use super::search::zero;
use super::step::Refusal;

/// Ends of a plan on either side of the speed that are tried.
const TRIED: usize = 8;
/// Parts of a speed by which a stage must go beyond the one before, or nothing new is reached any more.
const GROWS: f64 = 1e-7;

/// One step of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedStep {
    /// Its parameters.
    pub parameters: Vec<f64>,
    /// φ̇_m, per s.
    pub speed: f64,
    /// E, (kg m²/s)².
    pub energy: f64,
}

/// The shortest way to a speed, or why there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Step after step, or why there is no way.
    pub steps: Result<Vec<PlannedStep>, Unreached>,
    /// Lowest and highest speed after one step, after two, …, up to the last number that was looked at, per s.
    pub reach: Vec<[f64; 2]>,
}

/// A way over nodes, and by how much it misses the wished speed at its end.
#[derive(Debug, Clone)]
struct Way {
    nodes: Vec<usize>,
    miss: f64,
}

impl Reach<'_, '_> {
    /// The fewest steps from mid-stance with the speed `from` to mid-stance with the speed `to`, both per s; at most `most`.
    ///
    /// Ways over the nodes bound what so many steps can reach. Where the wished speed lies between two of them, the way on the
    /// straight line between both that leads to it is found: every step of a plan is computed as it is, not interpolated.
    pub fn plan(&self, from: f64, to: f64, most: usize) -> Plan {
        if from == to {
            return Plan { steps: Ok(Vec::new()), reach: Vec::new() };
        }
        let first = self.first_energy(from);
        let (mut stages, mut reach): (Vec<Vec<State>>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
        let mut between = false;
        for count in 1..=most {
            let (ways, ends) = self.last_steps(&stages, first, to);
            let Some(ends) = ends else {
                return Plan { steps: Err(Unreached::after(count - 1, &self.kept)), reach };
            };
            reach.push(ends);
            if let Some(steps) = self.connect(&ways, from, to) {
                return Plan { steps: Ok(steps), reach };
            }
            between |= ways.iter().all(|side| !side.is_empty());
            if settled(&reach) {
                break;
            }
            let next = self.advance(stages.last().map(Vec::as_slice), first);
            stages.push(next);
        }
        let steps = Err(self.unreached(&reach, to, between));
        Plan { steps, reach }
    }

    fn unreached(&self, reach: &[[f64; 2]], to: f64, between: bool) -> Unreached {
        let low = reach.iter().map(|ends| ends[0]).fold(f64::INFINITY, f64::min);
        let high = reach.iter().map(|ends| ends[1]).fold(f64::NEG_INFINITY, f64::max);
        match (to > high, to < low && !between) {
            (true, _) => Unreached::TooFast(high),
            (_, true) => Unreached::TooSlow(low),
            _ => Unreached::NoWay,
        }
    }

    /// Ways whose last step comes closest to a speed from below and from above; lowest and highest speed of all that do not fall.
    /// Those from below may lack energy in their last step.
    fn last_steps(&self, stages: &[Vec<State>], first: f64, to: f64) -> ([Vec<Way>; 2], Option<[f64; 2]>) {
        let present = [State { energy: first, node: usize::MAX, before: usize::MAX }];
        let states = stages.last().map_or(&present[..], Vec::as_slice);
        let mut sides: [Vec<(f64, usize, usize)>; 2] = Default::default();
        let mut ends: Option<[f64; 2]> = None;
        for (k, state) in states.iter().enumerate() {
            let from = (!stages.is_empty()).then_some(state.node);
            for node in 0..self.nodes.len() {
                let Some(step) = self.step(from, node) else { continue };
                if !step.may_end(state.energy) {
                    continue;
                }
                let speed = step.signed_speed(state.energy);
                if speed > 0.0 {
                    let [low, high] = ends.unwrap_or([speed; 2]);
                    ends = Some([low.min(speed), high.max(speed)]);
                }
                let miss = speed - to;
                for (side, wanted) in sides.iter_mut().zip([miss <= 0.0, miss >= 0.0]) {
                    if wanted {
                        closest(side, (miss, k, node));
                    }
                }
            }
        }
        let way = |&(miss, k, node): &(f64, usize, usize)| Way { nodes: trace(stages, k, node), miss };
        (sides.map(|side| side.iter().map(way).collect()), ends)
    }

    /// A plan between a way that is too slow and one that is too fast.
    fn connect(&self, [slow, fast]: &[Vec<Way>; 2], from: f64, to: f64) -> Option<Vec<PlannedStep>> {
        let mut pairs: Vec<(&Way, &Way)> =
            slow.iter().flat_map(|slow| fast.iter().map(move |fast| (slow, fast))).collect();
        // Ways that differ in few steps have the best prospects to be possible in between, too.
        let apart =
            |(slow, fast): &(&Way, &Way)| slow.nodes.iter().zip(&fast.nodes).filter(|(a, b)| a != b).count();
        pairs.sort_by(|a, b| {
            apart(a).cmp(&apart(b)).then((a.1.miss - a.0.miss).total_cmp(&(b.1.miss - b.0.miss)))
        });
        pairs.into_iter().find_map(|(slow, fast)| self.between(&slow.nodes, &fast.nodes, from, to))
    }

    /// The plan on the line between two ways that ends with the wished speed.
    fn between(&self, slow: &[usize], fast: &[usize], from: f64, to: f64) -> Option<Vec<PlannedStep>> {
        let chain = |part: f64| -> Vec<Vec<f64>> {
            let mixed = |(&a, &b): (&usize, &usize)| {
                let pair = self.nodes[a].iter().zip(&self.nodes[b]);
                // Exactly the node at both ends, and where both agree.
                pair.map(|(a, b)| if part == 1.0 { *b } else { a + part * (b - a) }).collect()
            };
            slow.iter().zip(fast).map(mixed).collect()
        };
        let miss = |part: f64| self.walk(&chain(part), from).map_or(f64::NAN, |walked| walked.miss(to));
        let (low, high) = (miss(0.0), miss(1.0));
        if !(low <= 0.0 && high >= 0.0) {
            return None;
        }
        let mut part = zero(miss, (0.0, low), (1.0, high));
        // The last step has to pass: on the fast side by the least that counts.
        if !self.walk(&chain(part), from).is_ok_and(|walked| walked.passes()) {
            let nudged = (1..=50).rev().map(|k| part + (1.0 - part) * 0.5f64.powi(k)).chain([1.0]);
            part = nudged.into_iter().find(|part| miss(*part) >= 0.0)?;
        }
        let walked = self.walk(&chain(part), from).ok().filter(Walked::passes)?;
        let reached = (walked.steps.last()?.speed - to).abs() <= 1e-6 * to.max(1.0);
        reached.then_some(walked.steps)
    }

    /// All steps of a way as they are; the last one may lack energy.
    ///
    /// # Errors
    /// Why another one is not made.
    fn walk(&self, chain: &[Vec<f64>], from: f64) -> Result<Walked, Refusal> {
        let (mut landing, mut energy) = (self.now.landing.clone(), self.first_energy(from));
        let mut steps = Vec::with_capacity(chain.len());
        let mut last = None;
        for parameters in chain {
            let course = self.gait.course(parameters, &landing)?;
            let step =
                Transition::of(&course, &landing, &self.kept).ok_or(Refusal::Singular(course.start))?;
            steps.push(PlannedStep {
                parameters: parameters.clone(),
                speed: step.signed_speed(energy),
                energy,
            });
            last = Some((step, energy));
            if steps.len() < chain.len() {
                let falls = Refusal::FallsBack { energy, needed: step.p_max };
                energy = step.next(energy).ok_or(falls)?;
            }
            landing = course.landing;
        }
        let (step, energy) = last.ok_or(Refusal::NoSteadyStart)?;
        Ok(Walked { steps, last: step, energy })
    }
}

/// A way that was walked.
struct Walked {
    steps: Vec<PlannedStep>,
    last: Transition,
    /// Of the last step.
    energy: f64,
}

impl Walked {
    fn miss(&self, speed: f64) -> f64 {
        self.last.miss(self.energy, speed)
    }

    fn passes(&self) -> bool {
        self.last.passes(self.energy)
    }
}

/// Keeps the closest few.
fn closest(side: &mut Vec<(f64, usize, usize)>, new: (f64, usize, usize)) {
    if side.len() == TRIED && side.last().is_some_and(|last| last.0.abs() <= new.0.abs()) {
        return;
    }
    let place = side.partition_point(|old| old.0.abs() <= new.0.abs());
    side.insert(place, new);
    side.truncate(TRIED);
}

/// The nodes that led to a state, and one more.
fn trace(stages: &[Vec<State>], mut state: usize, node: usize) -> Vec<usize> {
    let mut nodes = vec![node];
    for stage in stages.iter().rev() {
        nodes.push(stage[state].node);
        state = stage[state].before;
    }
    nodes.reverse();
    nodes
}

/// Two stages brought nothing new.
fn settled(reach: &[[f64; 2]]) -> bool {
    let [.., a, b, c] = reach else { return false };
    let grows = |old: &[f64; 2], new: &[f64; 2]| {
        let least = GROWS * old[1].abs();
        new[1] > old[1] + least || new[0] < old[0] - least
    };
    !grows(a, b) && !grows(b, c)
}
