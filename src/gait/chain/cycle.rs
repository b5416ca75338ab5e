//! Walking in several phases that repeats itself: the speed whose step from mid-stance ends as it began (6.17).
use super::hop::{Hop, MidStance};
use super::{Chain, PhaseEnergy, Refused};
use bipedc_analysis::gait::{Assumptions, Cycle, Reason};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::{Argument, State};

/// Steps after which there is no cycle nearby.
const MOST: usize = 40;
/// Steps that a posture takes to forget where the search began.
const SETTLED: usize = 4;
/// Guesses of a speed from which there is no step, before there is no cycle.
const TURNED: usize = 12;
/// Part of φ̇² that two steps of a cycle differ by at most. Where torques go from limit to limit steps are known to some 1e-7.
const CLOSE: f64 = 1e-6;
/// Parts of the speed by which a cycle is left to see what of it comes back. Of slopes that differ the middle one counts: where torques go from limit to limit one step in some twenty is off by
/// a millionth of the speed, which is a five-hundredth of the slope of the least.
const LEFT: [f64; 3] = [2e-3, 4e-3, 6e-3];
/// Two slopes that differ by less than this part are both good.
const ALIKE: f64 = 2e-4;
/// Steps within which a deviation has to be halved, to count as one that goes away.
const RETURNS: usize = 8;
/// Part of the speed that counts as none.
const NEAR: f64 = 0.02;
/// Factor from one speed to the next that is tried, how many are, and halvings between the last that is good and the first that is not.
const OUTWARD: f64 = 1.25;
const TRIED: usize = 6;
const HALVINGS: usize = 8;
/// Factor from one speed to the next, and how many on either side, where steps are looked for that limits let be made near one speed alone.
const SIDEWAYS: f64 = 1.015;
const ASIDE: i32 = 100;
/// Places at which the way of the first phase is integrated for a first guess.
const PLACES: usize = 64;

impl Chain<'_> {
    /// Walking with these parameters in every step.
    ///
    /// # Errors
    /// Why there is none.
    pub(in crate::gait) fn cycle(&self, values: &[f64]) -> Result<Cycle, Refused> {
        let (start, multiplier) = self.repeating(values, None)?;
        if multiplier.is_nan() || multiplier.abs() >= 1.0 {
            let why = format!("deviations grow: the multiplier is {multiplier:.6}");
            return Err(Refused::new(Reason::FallsBack, why));
        }
        let Worked { net, whole, begun, duration, step_length } = self.worked(&start, values)?;
        let kinetic = |speed: f64| 0.5 * speed * speed;
        let [slowest, fastest] =
            limits(start.speed, |speed| self.kept_hop(&start.at(speed), values).is_some());
        Ok(Cycle {
            speed: start.speed,
            multiplier,
            duration,
            step_length,
            walking_speed: step_length / duration,
            work: whole,
            net_work: net,
            cost_of_transport: whole / (self.weight(&start.q)? * step_length),
            energy: kinetic(begun),
            k_min: slowest.map(kinetic),
            k_max: fastest.map(kinetic),
            basin: limits(start.speed, |speed| self.returns(&start, speed, values)),
        })
    }

    /// ∫ Σ \|τ q̇\| dt over weight and distance of a step from this mid-stance, 1.
    ///
    /// # Errors
    /// Why there is no step.
    pub(crate) fn cost_of_transport(&self, start: &MidStance, values: &[f64]) -> Result<f64, Refused> {
        let Worked { whole, step_length, .. } = self.worked(start, values)?;
        Ok(whole / (self.weight(&start.q)? * step_length))
    }

    fn worked(&self, start: &MidStance, values: &[f64]) -> Result<Worked, Refused> {
        let mut work = Work { chain: self, last: None, sum: [0.0; 2], begun: f64::NAN, refused: None };
        let hop =
            self.hop_watched(start, values, &mut |phase, time, x, begins| work.look(phase, time, x, begins));
        let Work { sum: [net, whole], begun, refused, .. } = work;
        if let Some(refused) = refused {
            return Err(refused);
        }
        let step_length = hop.next?.q[0] - start.q[0];
        Ok(Worked { net, whole, begun, duration: hop.duration, step_length })
    }

    /// The mid-stance that comes back, begun `near` a speed (per s) if one is known, and the multiplier there.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn repeating(&self, values: &[f64], near: Option<f64>) -> Result<(MidStance, f64), Refused> {
        let begin = match near {
            Some(speed) => self.mid_stance(values, speed)?,
            None => self.first_guess(values)?,
        };
        let start = self.settled(begin.clone(), values).or_else(|why| {
            let beside = if why.reason == Reason::FallsBack { None } else { self.beside(&begin, values) };
            beside.map_or(Err(why), |begin| self.settled(begin, values))
        })?;
        let multiplier = self.multiplier(&start, values)?;
        Ok((start, multiplier))
    }

    /// Secants on φ̇_m², from posture to posture.
    fn settled(&self, begin: MidStance, values: &[f64]) -> Result<MidStance, Refused> {
        let mut now = begin;
        let mut before: Option<[f64; 2]> = None;
        let (mut good, mut turned) = (f64::NAN, 0);
        for count in 0..MOST {
            let hop = self.hop(&now, values);
            let (square, gain) = (now.speed * now.speed, hop.square - now.speed * now.speed);
            let next = match hop.next {
                Ok(next) => next,
                // Too slow or too fast to begin with; later it is the gait that lets the robot fall.
                Err(why) if before.is_none() && count < MOST / 2 => {
                    now = now.at(if why.reason == Reason::FallsBack { 1.3 } else { 0.8 } * now.speed);
                    continue;
                }
                // A guess went too far: half of the way back to the last speed with a step.
                Err(_) if good.is_finite() && turned < TURNED => {
                    turned += 1;
                    now = now.at(0.5 * (now.speed + good));
                    continue;
                }
                Err(why) => return Err(slower(&why)),
            };
            good = now.speed;
            if gain.abs() <= CLOSE * square && count >= SETTLED {
                return Ok(next.at(now.speed));
            }
            let slope = match before {
                Some([x, y]) if (square - x).abs() > 1e-6 * square => ((gain - y) / (square - x)).min(-0.05),
                _ => -0.4,
            };
            before = Some([square, gain]);
            let wanted = square - gain / slope;
            if wanted.is_nan() || wanted <= 0.0 {
                let why = "each step is slower than the one before, until one falls back";
                return Err(Refused::new(Reason::FallsBack, why));
            }
            now = next.at(wanted.sqrt());
        }
        Err(Refused::new(
            Reason::PhaseWithoutEnd,
            "steps with these parameters do not come to repeat themselves",
        ))
    }

    /// The mid-stance of the speed nearest to that of another one from which a step is made.
    fn beside(&self, begin: &MidStance, values: &[f64]) -> Option<MidStance> {
        let tried =
            (1..=ASIDE).flat_map(|count| [1.0, -1.0].map(|sign| SIDEWAYS.powf(sign * f64::from(count))));
        let mut tried = tried.map(|factor| begin.at(factor * begin.speed));
        tried.find(|start| self.hop(start, values).next.is_ok())
    }

    /// Mid-stance at half the speed that the fall through the first phase alone gives.
    fn first_guess(&self, values: &[f64]) -> Result<MidStance, Refused> {
        let start = self.mid_stance(values, 1.0)?;
        let (first, end) = (self.first()?, self.end_of_present());
        let energy = PhaseEnergy::new(self, first, [start.phi, end], PLACES)?;
        Ok(start.at((-0.5 * energy.p_minus()).max(1e-4).sqrt()))
    }

    /// A step that keeps what is assumed: friction where the gait has a coefficient, feet that push, torques, stops.
    fn kept_hop(&self, from: &MidStance, values: &[f64]) -> Option<MidStance> {
        let friction = self.bench.gait.limits.friction.is_some();
        let assume = Assumptions {
            friction,
            pull: true,
            clearance: false,
            torque: true,
            joints: true,
            velocity: false,
        };
        let (hop, margins) = self.hop_with_margins(from, values, 0);
        hop.next.ok().filter(|_| Hop::violated(assume, &margins).is_none())
    }

    /// Whether steps from the cycle's posture at another speed come back to it.
    fn returns(&self, cycle: &MidStance, speed: f64, values: &[f64]) -> bool {
        let (mut now, off) = (cycle.at(speed), (speed - cycle.speed).abs());
        for _ in 0..RETURNS {
            let Some(next) = self.kept_hop(&now, values) else { return false };
            let left = (next.speed - cycle.speed).abs();
            if left <= NEAR * cycle.speed || left < 0.5 * off {
                return true;
            }
            now = next;
        }
        false
    }

    /// Of a small deviation of the speed, what the second step leaves of what the first has left.
    fn multiplier(&self, cycle: &MidStance, values: &[f64]) -> Result<f64, Refused> {
        let follow = |left: f64| -> Result<[f64; 2], Refused> {
            let Hop { next, .. } = self.hop(&cycle.at(cycle.speed * (1.0 + left)), values);
            let first = next?;
            let second = self.hop(&first, values).next?;
            Ok([first.speed, second.speed])
        };
        let slope = |left: f64| -> Result<f64, Refused> {
            let (above, below) = (follow(left)?, follow(-left)?);
            Ok((above[1] - below[1]) / (above[0] - below[0]))
        };
        let first = slope(LEFT[0])?;
        // Near the fastest step there may be none a little faster.
        let Ok(second) = slope(LEFT[1]) else { return Ok(first) };
        if (second / first - 1.0).abs() < ALIKE {
            return Ok(first);
        }
        Ok(slope(LEFT[2]).map_or(first, |third| first.clamp(second.min(third), second.max(third))))
    }

    /// M g, N: what holds the robot at rest.
    pub(super) fn weight(&self, q: &[f64]) -> Result<f64, Diagnostic> {
        let need = || Diagnostic::error("the gait has no function `inverse_dynamics`");
        let function =
            bipedc_runtime::Model::<f64>::function(&self.model, "inverse_dynamics").ok_or_else(need)?;
        let rest = vec![0.0; q.len()];
        let state = State::new().with(Argument::Q, q).with(Argument::V, &rest).with(Argument::A, &rest);
        Ok(self.call(function, &state).get(1).copied().unwrap_or(f64::NAN))
    }
}

/// Slowest and fastest speed around one for which something holds; the fastest is none where it held for all that were tried, both where it does
/// not hold for that one.
fn limits(speed: f64, holds: impl Fn(f64) -> bool) -> [Option<f64>; 2] {
    if !holds(speed) {
        return [None; 2];
    }
    let edge = |factor: f64| {
        let mut good = speed;
        let mut bad = (0..TRIED).find_map(|_| {
            let next = good * factor;
            if !holds(next) {
                return Some(next);
            }
            good = next;
            None
        })?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if holds(middle) { good = middle } else { bad = middle }
        }
        Some(good)
    };
    // As slow as was tried is as good as at rest.
    [Some(edge(1.0 / OUTWARD).unwrap_or(0.0)), edge(OUTWARD)]
}

fn slower(why: &Refused) -> Refused {
    match why.reason {
        Reason::FallsBack => {
            Refused::new(Reason::FallsBack, "each step is slower than the one before, until one falls back")
        }
        _ => why.clone(),
    }
}

/// A step with the work of all joints.
struct Worked {
    /// Driving less braking, J.
    net: f64,
    /// Both as positive, J.
    whole: f64,
    /// φ̇ where the step's first phase begins, per s.
    begun: f64,
    /// s
    duration: f64,
    /// m
    step_length: f64,
}

/// Work of all joints over time: Simpson's rule between accepted steps.
struct Work<'c, 'b> {
    chain: &'c Chain<'b>,
    /// Time, φ and φ̇, φ̈ and powers.
    last: Option<(f64, [f64; 2], f64, [f64; 2])>,
    /// Driving less braking; both as positive. J.
    sum: [f64; 2],
    /// φ̇ where the last phase began that was a step's first.
    begun: f64,
    refused: Option<Refused>,
}

impl Work<'_, '_> {
    fn look(&mut self, phase: usize, time: f64, x: [f64; 2], begins: bool) {
        if begins && self.chain.first().is_ok_and(|first| first == phase) {
            self.begun = x[1];
        }
        if let Err(why) = self.add(phase, time, x, begins) {
            self.refused.get_or_insert(why);
        }
    }

    fn add(&mut self, phase: usize, time: f64, x: [f64; 2], begins: bool) -> Result<(), Refused> {
        let now = self.chain.motion(phase, x)?;
        if let Some((before, from, acceleration, power)) = self.last.filter(|_| !begins) {
            let h = time - before;
            // The cubic with φ, φ̇ and φ̈ of both ends.
            let middle = [
                0.5 * (from[0] + x[0]) + h / 8.0 * (from[1] - x[1]),
                0.5 * (from[1] + x[1]) + h / 8.0 * (acceleration - now.acceleration),
            ];
            let between = self.chain.motion(phase, middle)?.power;
            for k in 0..2 {
                self.sum[k] += h / 6.0 * (power[k] + 4.0 * between[k] + now.power[k]);
            }
        }
        self.last = Some((time, x, now.acceleration, now.power));
        Ok(())
    }
}
