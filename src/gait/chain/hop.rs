//! From mid-stance to mid-stance: where a robot passes the dead centre of its first phase it takes the parameters of the step, and all
//! phases follow to the next such place. What maps, plans and cycles know of a step is this.
use super::known::Followed;
use super::near::Recent;
use super::{Chain, PhaseEnergy, Refused};
use bipedc_analysis::gait::Reason;
use bipedc_analysis::simulate::phases::{End, Order, Precision, Start, walk};

/// A step that takes longer than this does not come to its end, s.
const LONGEST: f64 = 20.0;
/// Places at which P is integrated to find a dead centre; φ̇² is stationary there.
const PLACES: usize = 64;
pub(super) const PRECISION: Precision = Precision {
    relative: 1e-11,
    absolute: 1e-11,
    largest_step: 0.02,
    largest_look: 0.01,
    shortest_look: 0.0,
    most_steps: 10_000,
    order: Order::Eighth,
};
/// Of cells between which a map is interpolated to some 1e-3: this leaves 2e-6 of it in the middle, 5e-4 at most. Torques go from limit to limit on the way, where a method of low order loses
/// fewer evaluations to steps that are rejected. Its steps are short: looks are no farther apart than in the longest ones of the other method.
pub(super) const ROUGH: Precision =
    Precision { relative: 3e-9, absolute: 3e-9, shortest_look: 0.005, order: Order::Fifth, ..PRECISION };

/// The robot where it passes the dead centre of a step's first phase.
#[derive(Debug, Clone, PartialEq)]
pub struct MidStance {
    /// Posture.
    pub q: Vec<f64>,
    /// q̇ per φ̇.
    pub slope: Vec<f64>,
    /// φ_m
    pub phi: f64,
    /// φ̇_m, per s.
    pub speed: f64,
}

impl MidStance {
    /// q̇
    pub fn velocity(&self) -> Vec<f64> {
        self.slope.iter().map(|slope| slope * self.speed).collect()
    }

    /// The same posture at another speed.
    #[must_use]
    pub fn at(&self, speed: f64) -> Self {
        Self { speed, ..self.clone() }
    }
}

/// What comes of a step from mid-stance.
#[derive(Debug, Clone, PartialEq)]
pub struct Hop {
    /// The next mid-stance, or why it is not reached.
    pub next: Result<MidStance, Refused>,
    /// φ̇_m² of the next step; negative by what it lacks where it falls back in its first phase, not a number where it does not begin.
    pub square: f64,
    /// s, to the next mid-stance or as far as it got.
    pub duration: f64,
    /// Torques were held to a limit on the way.
    pub limited: bool,
}

/// Is shown phase, time since the hop began, φ and φ̇: where a phase begins (`true`), and at every accepted step of the integration.
pub(super) type Look<'l> = &'l mut dyn FnMut(usize, f64, [f64; 2], bool);

/// A phase of the description, and φ and φ̇ where it begins.
pub(super) type Beginning = (usize, [f64; 2]);
/// A phase to its end, and where the next begins; the time goes on by what it takes.
type Follow<'f> = &'f mut dyn FnMut(Beginning, &mut f64) -> Result<Beginning, Refused>;

impl Chain<'_> {
    /// The parameters of the next step.
    ///
    /// # Errors
    /// The gait does not have so many, or numbers that are none.
    pub fn ask(&self, values: &[f64]) -> Result<(), Refused> {
        let controller = &mut self.present.borrow_mut().controller;
        let ask = |(index, &value)| controller.ask(index, value);
        values.iter().enumerate().try_for_each(ask).map_err(|refusal| Refused::of_controller("", refusal))
    }

    /// The dead centre of a step with these parameters that follows one which ended as its own formulas say.
    ///
    /// # Errors
    /// There is no such step.
    pub fn mid_stance(&self, values: &[f64], speed: f64) -> Result<MidStance, Refused> {
        self.ask(values)?;
        let [q, direction] = self.nominal(values)?;
        let first = self.first()?;
        let [start, _] = self.begin(first, &q, &direction)?;
        let [phi, ..] = self.dead_centre(first, start)?;
        let point = self.point(first, phi)?;
        Ok(MidStance { q: point.q.clone(), slope: point.slope.clone(), phi, speed })
    }

    /// φ_m of a step with these parameters that begins in this state of the whole robot.
    ///
    /// # Errors
    /// There is no such step.
    pub fn dead_centre_from(&self, values: &[f64], q: &[f64], v: &[f64]) -> Result<f64, Refused> {
        self.ask(values)?;
        let first = self.first()?;
        let [start, _] = self.begin(first, q, v)?;
        self.dead_centre(first, start).map(|[phi, ..]| phi)
    }

    /// φ_m, ψ(φ₊, φ_m) and P(φ_m) of the present phase, which begins at `start`.
    pub(super) fn dead_centre(&self, phase: usize, start: f64) -> Result<[f64; 3], Refused> {
        let end = self.end_of_present();
        if start >= end {
            let name = &self.phase(phase)?.spec.name;
            let why = format!("phase `{name}` begins at φ = {start:.6}, behind its end at {end:.6}");
            return Err(Refused::new(Reason::NoPhaseLeft, why));
        }
        let key = self.key_of_present(phase)?;
        let known = self.known.centres.get(&key);
        let (found, near) = match known {
            Some(known) => known,
            None => {
                let found = PhaseEnergy::new(self, phase, [start, end], PLACES)?.dead_centre();
                let known = (found, self.present.borrow().near.clone());
                self.known.centres.keep(key, known.clone());
                known
            }
        };
        // What follows goes on from the same postures, whether this was known or not.
        let present = &mut *self.present.borrow_mut();
        (present.near, present.points) = (near, Recent::new());
        Ok(found)
    }

    /// The step that takes these parameters at mid-stance.
    pub fn hop(&self, from: &MidStance, values: &[f64]) -> Hop {
        self.hop_by(from, values, &mut |now, time| self.phase_known(now, time))
    }

    /// The same, watched: every phase is followed.
    pub(super) fn hop_watched(&self, from: &MidStance, values: &[f64], look: Look<'_>) -> Hop {
        self.hop_by(from, values, &mut |now, time| self.phase_to_its_end(now, time, look))
    }

    fn hop_by(&self, from: &MidStance, values: &[f64], follow: Follow<'_>) -> Hop {
        let mut found = Hop {
            next: Err(Refused::new(Reason::NotFinite, "the step was not begun")),
            square: f64::NAN,
            duration: 0.0,
            limited: false,
        };
        self.present.borrow_mut().until = None;
        found.next = self.followed(from, values, &mut found.square, &mut found.duration, follow);
        let present = self.present.borrow();
        found.limited = present.limited;
        found
    }

    fn followed(
        &self,
        from: &MidStance,
        values: &[f64],
        square: &mut f64,
        time: &mut f64,
        follow: Follow<'_>,
    ) -> Result<MidStance, Refused> {
        self.ask(values)?;
        let first = self.first()?;
        let mut now = (first, self.begin(first, &from.q, &from.velocity())?);
        {
            let present = &mut *self.present.borrow_mut();
            (present.limited, present.missed) = (false, false);
        }
        for _ in 0..self.bench.gait.phases.len() {
            now = follow(now, time)?;
        }
        self.to_mid_stance(now, square, time, follow)
    }

    /// The first phase of the next step to its dead centre.
    fn to_mid_stance(
        &self,
        (phase, [start, rate]): Beginning,
        square: &mut f64,
        time: &mut f64,
        follow: Follow<'_>,
    ) -> Result<MidStance, Refused> {
        let [phi, psi, potential] = self.dead_centre(phase, start)?;
        *square = psi * (rate * rate - 2.0 * potential);
        let mut speed = rate;
        if phi > start {
            self.present.borrow_mut().until = Some(phi);
            let arrived = follow((phase, [start, rate]), time);
            self.present.borrow_mut().until = None;
            let reached;
            [reached, speed] = match arrived {
                Ok((_, state)) => state,
                Err(why) => {
                    // What the quadrature takes for a little more than nothing is a fall all the same.
                    let falls = why.reason == Reason::FallsBack;
                    *square = if falls { square.min(-f64::MIN_POSITIVE) } else { f64::NAN };
                    return Err(why);
                }
            };
            if reached < phi - 1e-9 {
                let why = "the first phase of the next step ends before its dead centre";
                return Err(Refused::new(Reason::NoPhaseLeft, why));
            }
        }
        *square = speed * speed;
        let point = self.point(phase, phi)?;
        Ok(MidStance { q: point.q.clone(), slope: point.slope.clone(), phi, speed })
    }

    /// The same as [`Chain::phase_to_its_end`], of a phase that may be known already.
    fn phase_known(&self, (phase, x): Beginning, time: &mut f64) -> Result<Beginning, Refused> {
        let nobody: Look<'_> = &mut |_, _, _, _| {};
        if self.present.borrow().until.is_some() {
            return self.phase_to_its_end((phase, x), time, nobody);
        }
        let key = self.key_of_present(phase)?;
        let known = self.known.followed.get(&key);
        if let Some(Followed { duration, limited, missed, next }) = known {
            *time += duration;
            {
                let present = &mut *self.present.borrow_mut();
                (present.limited, present.missed) = (present.limited | limited, present.missed | missed);
            }
            let (next, state) = next?;
            let (q, v) = state.split_at(state.len() / 2);
            return Ok((next, self.begin(next, q, v)?));
        }
        let limited = std::mem::take(&mut self.present.borrow_mut().limited);
        let mut duration = 0.0;
        let next = self.phase_to_its_end((phase, x), &mut duration, nobody);
        let present = &mut *self.present.borrow_mut();
        let state = next.clone().map(|(next, _)| (next, present.begun.clone()));
        let (own, missed) = (present.limited, present.missed);
        let followed = Followed { duration, limited: own, missed, next: state };
        self.known.followed.keep(key, followed);
        present.limited |= limited;
        *time += duration;
        next
    }

    /// A phase to its end, and where the next begins.
    pub(super) fn phase_to_its_end(
        &self,
        (phase, x): Beginning,
        time: &mut f64,
        look: Look<'_>,
    ) -> Result<Beginning, Refused> {
        let begun = *time;
        look(phase, begun, x, true);
        let start = Start { time: 0.0, phase, x: x.to_vec() };
        let walked = walk(self, start, LONGEST, 1, &self.precision, &mut |time, phase, x| {
            look(phase, begun + time, [x[0], x[1]], false);
        });
        if let Some(refusal) = self.refusal() {
            return Err(refusal);
        }
        let name = &self.phase(phase)?.spec.name;
        let walked = walked.map_err(|why| Refused { reason: Reason::PhaseWithoutEnd, why })?;
        *time = begun + walked.last.time;
        if self.present.borrow().missed {
            let why = format!("in phase `{name}` limits of ground and joints do not let the outputs be met");
            return Err(Refused::new(Reason::OutputsMissed, why));
        }
        match (walked.changes.first(), walked.end) {
            (Some(change), _) => Ok((change.passage.to, [change.after[0], change.after[1]])),
            (None, End::Violated(found)) => {
                Err(Refused::new(Reason::FallsBack, format!("in phase `{}` {}", found.phase, found.meaning)))
            }
            (None, _) => {
                let why = format!("phase `{name}` does not end within {LONGEST} s");
                Err(Refused::new(Reason::PhaseWithoutEnd, why))
            }
        }
    }
}
