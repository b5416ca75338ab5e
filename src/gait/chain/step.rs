//! One step of several phases, and what its energies say of the next (6.35–6.37).
use super::hop::Beginning;
use super::known::{Ended, key};
use super::near::Recent;
use super::surface::SurfacePoint;
use super::{Chain, ChainPhase, PhaseEnergy, Refused};
use crate::gait::{Assignment, Parametrised, PhasedBench, impossible_speed};
use bipedc_analysis::gait::{Margins, Reason};
use bipedc_analysis::simulate::phases::{Ending, PhaseSpec};
use bipedc_compiler::description::gait::GaitParameter;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::magnitude;
use bipedc_runtime::control::PhaseLayout;
use bipedc_runtime::{Argument, State};
use serde::Serialize;

/// Places between two steps of the integration at which a step's margins are looked at: torques and forces have peaks and kinks there.
const BETWEEN: usize = 4;
/// Steps of the quadrature of energies that are shown.
const STEPS: usize = 512;
/// Places at which the end of a phase is looked for.
const LOOKS: usize = 60;

/// What step is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChainOptions {
    /// Speed φ̇_m at the dead centre of the first phase, per s.
    pub speed: f64,
    /// Parameters that are not the gait's own.
    pub set: Vec<Assignment>,
    /// Parameters until mid-stance, where they are others: those of the step then are taken there.
    pub from: Vec<Assignment>,
}

/// A phase of a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainedPhase {
    /// As the gait calls it.
    pub name: String,
    /// φ₊
    pub phi_start: f64,
    /// φ₋
    pub phi_end: f64,
    /// φ̇₊, per s.
    pub speed_start: f64,
    /// φ̇₋, per s.
    pub speed_end: f64,
    /// s
    pub duration: f64,
    /// ν = K₊ of the next phase over K₋ of this one (6.35).
    pub nu: f64,
    /// P₋, (unit of φ/s)².
    pub p_minus: f64,
    /// Torques were held to a limit on the way: what (6.32) says of ν and P₋ holds without.
    pub limited: bool,
    /// Limits do not let outputs be met, in this phase or in one before: from there on phases are followed without limits, and such a step is not feasible.
    pub without_limits: bool,
}

/// A step with what comes of it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ChainStep {
    /// φ̇_m of this step, per s.
    pub speed: f64,
    /// φ̇_m of the next step, per s; none if it is not passed.
    pub next_speed: Option<f64>,
    /// φ_m; none where there is no such step.
    pub phi_m: Option<f64>,
    /// δ of the step: product of all ν (6.37).
    pub delta: Option<f64>,
    /// P₋ of the step (6.37), (unit of φ/s)².
    pub p_minus: Option<f64>,
    /// P(φ_m) of the next step, (unit of φ/s)²: 2 P has to be below φ̇₊² there; none where it does not begin.
    pub p_max: Option<f64>,
    /// φ̇_m after many steps, as a step of one phase has it; none: no energy tells it, [`PhasedBench::cycles`] follows steps to it.
    pub limit_speed: Option<f64>,
    /// E = φ̇₊²/2 where the step begins, (unit of φ/s)².
    pub energy: Option<f64>,
    /// The same of the next step.
    pub next_energy: Option<f64>,
    /// s
    pub duration: Option<f64>,
    /// Whether all phases come to their ends and the next step passes its dead centre.
    pub feasible: bool,
    /// Why not.
    pub reason: Option<String>,
    /// The same in one word, as in maps.
    pub reason_code: Option<Reason>,
    /// From this mid-stance to the next, at all accepted steps of the integration; negative: violated.
    pub margins: Margins,
    /// In order.
    pub phases: Vec<ChainedPhase>,
    /// Unit of φ.
    #[serde(skip)]
    pub unit: String,
    /// Parameters of the gait.
    #[serde(skip)]
    pub parameters: Vec<GaitParameter>,
    /// Their values from mid-stance on, and until there.
    #[serde(skip)]
    pub values: [Vec<f64>; 2],
}

impl ChainStep {
    /// A step of which nothing is known but that it is not made.
    fn refused(speed: f64, why: &Refused) -> Self {
        Self { speed, reason: Some(why.to_string()), reason_code: Some(why.reason), ..Self::default() }
    }

    /// δ and P₋ of the step (6.37), its duration, and the energy of the next one, which begins at a rate.
    fn sum(&mut self, rate: f64) {
        let (mut delta, mut p_minus) = (1.0, 0.0);
        for phase in &self.phases {
            p_minus += phase.p_minus / delta;
            delta *= phase.nu;
        }
        (self.delta, self.p_minus) = (Some(delta), Some(p_minus));
        self.next_energy = Some(0.5 * rate * rate);
        self.duration = Some(self.phases.iter().map(|phase| phase.duration).sum());
    }
}

impl PhasedBench {
    /// A step that follows one which ended as its own formulas say, and passes the dead centre of its first phase at a speed; `specs`
    /// are the phases of the robot's description.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none.
    pub fn step(&self, specs: &[PhaseSpec], options: &ChainOptions) -> Result<ChainStep, Diagnostics> {
        let speed = options.speed;
        if !(speed > 0.0 && speed <= magnitude::LARGEST) {
            let help = "write the speed at mid-stance, above 0, in the unit of the phase variable per second";
            return Err(Diagnostic::error(impossible_speed(speed)).help(help).into());
        }
        let to = self.values(&options.set)?;
        let from = self.with(&to, &options.from)?;
        let at = |error: Diagnostic| error.or_in_file(&self.file);
        let chain = Chain::new(self, specs, self.controller(None, &options.set)?).map_err(at)?;
        let found = chain.step(&from, &to, speed).unwrap_or_else(|why| ChainStep::refused(speed, &why));
        let parameters = self.parameters().to_vec();
        Ok(ChainStep { unit: self.phase_unit().to_owned(), parameters, values: [to, from], ..found })
    }
}

impl Chain<'_> {
    /// q and q̇ (of a step's whole robot, at this φ̇_m) where a step begins that follows one which ended as its own formulas say.
    ///
    /// # Errors
    /// There is no such posture.
    pub fn beginning(&self, values: &[f64], speed: f64) -> Result<[Vec<f64>; 2], Refused> {
        let [q, direction] = self.nominal(values)?;
        let rate = self.first_rate((&q, &direction), speed)?;
        Ok([q, direction.iter().map(|slope| slope * rate).collect()])
    }

    /// φ̇₊ of the step that begins at q along a direction (per φ̇) and passes its dead centre at a speed.
    fn first_rate(&self, (q, direction): (&[f64], &[f64]), speed: f64) -> Result<f64, Refused> {
        let first = self.first()?;
        let [start, _] = self.begin(first, q, direction)?;
        let end = self.end_of_present();
        let [_, psi, potential] = PhaseEnergy::new(self, first, [start, end], STEPS)?.dead_centre();
        // φ̇² = ψ (φ̇₊² − 2 P)
        Ok((speed * speed / psi + 2.0 * potential).sqrt())
    }

    /// Index of the step's first phase in the description.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn first(&self) -> Result<usize, Diagnostic> {
        self.bench.compiled.phase(&self.bench.gait, 0).map(|layout| layout.phase)
    }

    /// The step that takes parameters `to` at the mid-stance of one with parameters `from`, and what its phases are. A step among its
    /// own kind is shown from its beginning.
    fn step(&self, from: &[f64], to: &[f64], speed: f64) -> Result<ChainStep, Refused> {
        let start = self.mid_stance(from, speed)?;
        let (hop, _) = self.hop_with_margins(&start, to, 0);
        // Once more: a look between two steps moves where searches for postures begin, and with it the last digits of what follows.
        let margins = self.hop_with_margins(&start, to, BETWEEN).1;
        let first = self.first()?;
        let begun = if from == to {
            self.beginning(to, speed).and_then(|[q, v]| self.begin(first, &q, &v))
        } else {
            self.begin(first, &start.q, &start.velocity())
        };
        let mut found = ChainStep {
            speed,
            next_speed: hop.next.as_ref().ok().map(|next| next.speed),
            phi_m: Some(start.phi),
            energy: begun.as_ref().ok().map(|x| 0.5 * x[1] * x[1]).filter(|energy| energy.is_finite()),
            feasible: hop.next.is_ok(),
            reason_code: hop.next.as_ref().err().map(|why| why.reason),
            reason: hop.next.err().map(|why| why.to_string()),
            margins,
            ..ChainStep::default()
        };
        // Why a phase is not made is what the hop says.
        let Ok(x) = begun else { return Ok(found) };
        let own = self.present.borrow().clone();
        let next = self.phases_from((first, x), &mut found.phases);
        if let Ok((phase, [start, rate])) = next {
            found.sum(rate);
            found.p_max = self.dead_centre(phase, start).ok().map(|[.., potential]| potential);
        }
        self.present.replace(own);
        Ok(found)
    }

    /// All phases of a step, as far as they are made, and where the next step begins. Behind the place where limits do not let outputs be met they are followed without, as all that energies
    /// say is.
    fn phases_from(&self, mut now: Beginning, found: &mut Vec<ChainedPhase>) -> Result<Beginning, Refused> {
        let mut without_limits = false;
        for _ in 0..self.bench.gait.phases.len() {
            let own = self.present.borrow().clone();
            let mut made = self.one_phase(now);
            let missed = made.as_ref().is_err_and(|why| why.reason == Reason::OutputsMissed);
            if missed && !without_limits {
                without_limits = true;
                self.present.replace(own);
                self.leave_limits();
                made = self.one_phase(now);
            }
            let (phase, next) = made?;
            found.push(ChainedPhase { without_limits, ..phase });
            now = next;
        }
        Ok(now)
    }

    /// Torques from here on are what outputs ask for, whatever drives and the ground can do.
    fn leave_limits(&self) {
        let present = &mut *self.present.borrow_mut();
        (present.points, present.motions) = (Recent::new(), Recent::new());
        present.controller.keep_limits([false; 2]);
    }

    /// A phase to its end, and the beginning of the next.
    fn one_phase(&self, (phase, x): Beginning) -> Result<(ChainedPhase, Beginning), Refused> {
        {
            // What an earlier step missed is not missed here.
            let present = &mut *self.present.borrow_mut();
            (present.limited, present.missed) = (false, false);
        }
        let own = self.present.borrow().clone();
        let (mut time, mut last) = (0.0, x);
        let next = self.phase_to_its_end((phase, x), &mut time, &mut |_, _, x, _| last = x)?;
        // The energies are those of the phase that has ended.
        let limited = self.present.borrow().limited;
        let begun = self.present.replace(own);
        let energy = PhaseEnergy::new(self, phase, [x[0], last[0]], STEPS);
        self.present.replace(begun);
        let energy = energy?;
        let eta = next.1[1] / last[1];
        let found = ChainedPhase {
            name: self.phase(phase)?.spec.name.clone(),
            phi_start: x[0],
            phi_end: last[0],
            speed_start: x[1],
            speed_end: last[1],
            duration: time,
            nu: eta * eta * energy.psi(),
            p_minus: energy.p_minus(),
            limited,
            without_limits: false,
        };
        Ok((found, next))
    }

    /// φ̈ = a + b φ̇² without limits, at φ in the present phase.
    pub(super) fn law(&self, phase: usize, phi: f64) -> Result<[f64; 2], Refused> {
        let point = self.point(phase, phi)?;
        let limits = |kept: [bool; 2]| self.present.borrow_mut().controller.keep_limits(kept);
        let before = limits([false; 2]);
        let pair = [0.0, 1.0].map(|rate| self.moved(phase, &point, rate));
        limits(before);
        let [rest, moving] = pair;
        let rest = rest?.acceleration;
        Ok([rest, moving?.acceleration - rest])
    }

    /// q, and q̇ per φ̇, where a step begins after one that ended as its own formulas say: all phases are followed from end to end without h_p.
    pub(super) fn nominal(&self, values: &[f64]) -> Result<[Vec<f64>; 2], Refused> {
        let mut q = self.bench.posture();
        let mut direction = Vec::new();
        for index in 0..self.bench.gait.phases.len() {
            let layout = self.bench.compiled.phase(&self.bench.gait, index)?;
            let key = key(index, [&q, &[]], values, &self.phase(layout.phase)?.read.shape);
            let known = self.known.ended.get(&key);
            let found = known.unwrap_or_else(|| {
                let found = self.after_nominal_end(&layout, index == 0, values, &q);
                self.known.ended.keep(key, found.clone());
                found
            });
            [q, direction] = found?;
        }
        // Per φ̇ of the phase that begins.
        let first = self.bench.compiled.phase(&self.bench.gait, 0)?;
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &direction);
        let rate = self.call(first.controlled, &state)[1 + first.outputs];
        direction.iter_mut().for_each(|slope| *slope /= rate);
        Ok([q, direction])
    }

    /// Posture and direction where the next phase begins after one that ended so.
    fn after_nominal_end(&self, layout: &PhaseLayout, first: bool, values: &[f64], q: &[f64]) -> Ended {
        let of = self.phase(layout.phase)?;
        let SurfacePoint { q, slope, .. } = self.nominal_end(of, (layout, first), values, q)?;
        let mut direction = slope;
        if let Some(impact) = of.impact {
            let state = State::new().with(Argument::Q, &q).with(Argument::V, &direction);
            direction = self.call(impact, &state);
            direction.truncate(q.len());
        }
        Ok(if of.spec.relabel { self.relabelled(&q, &direction) } else { [q, direction] })
    }

    /// The end of a phase that begins at q, without h_p; `first`: q is a guess, and the phase is not followed.
    fn nominal_end(
        &self,
        of: &ChainPhase,
        (layout, first): (&PhaseLayout, bool),
        values: &[f64],
        q: &[f64],
    ) -> Result<SurfacePoint, Refused> {
        let mut arguments = vec![0.0; self.bench.compiled.arguments.len()];
        arguments[3..3 + values.len()].copy_from_slice(values);
        let end = self.call(layout.end, &State::new().with(Argument::Parameters, &arguments))[0];
        let mut held = of.surface.held(&self.model, q);
        if first {
            of.surface.put_on_the_ground(&mut held);
        }
        let phase_at = |q: &[f64]| {
            let still = vec![0.0; q.len()];
            self.call(layout.controlled, &State::new().with(Argument::Q, q).with(Argument::V, &still))[0]
        };
        // A phase has some length, whatever it is: there is no h_p.
        (arguments[1], arguments[2]) = (end - 1.0, end);
        let mut q = q.to_vec();
        let mut from = if first { end } else { phase_at(&q) };
        if first && of.spec.relabel {
            // The only phase begins where it ended, the other leg in front.
            arguments[0] = end;
            let ended = of.surface.at(&self.model, (&arguments, &held), &q)?;
            [q, _] = self.relabelled(&ended.q, &ended.slope);
            from = phase_at(&q);
            held = of.surface.held(&self.model, &q);
            of.surface.put_on_the_ground(&mut held);
        }
        if !first || of.spec.relabel {
            arguments[1] = from;
        }
        let mut at = |part: f64, near: &[f64]| {
            arguments[0] = from + (end - from) * part;
            of.surface.at(&self.model, (&arguments, &held), near)
        };
        let point = at(0.0, &q)?;
        let Ending::Touch(points) = &of.spec.ending else {
            let next = |point: SurfacePoint, k: usize| at(k as f64 / LOOKS as f64, &point.q);
            return (1..=LOOKS).try_fold(point, next);
        };
        let height = |q: &[f64]| {
            let heights = self.heights(q);
            points.iter().map(|&point| heights[point]).fold(f64::INFINITY, f64::min)
        };
        touched(at, point, height)?.ok_or_else(|| {
            let message = format!("phase `{}` does not come to the ground near its `end`", of.spec.name);
            let help = "`end` is φ where the phase is meant to end: what lands is on the ground there";
            Refused { reason: Reason::GuardNotReached, why: Diagnostic::error(message).help(help) }
        })
    }
}

/// Where a height falls through zero on the way from the beginning to a fifth beyond the end; `at` is the surface at a part of that way.
fn touched(
    mut at: impl FnMut(f64, &[f64]) -> Result<SurfacePoint, Refused>,
    mut point: SurfacePoint,
    height: impl Fn(&[f64]) -> f64,
) -> Result<Option<SurfacePoint>, Refused> {
    let part = |k: usize| k as f64 / LOOKS as f64;
    let mut above = height(&point.q) > 0.0;
    for k in 1..=LOOKS + LOOKS / 5 {
        let mut next = at(part(k), &point.q)?;
        if above && height(&next.q) <= 0.0 {
            let (mut low, mut high) = (part(k - 1), part(k));
            for _ in 0..60 {
                let middle = at(0.5 * (low + high), &point.q)?;
                if height(&middle.q) > 0.0 {
                    (low, point) = (0.5 * (low + high), middle);
                } else {
                    (high, next) = (0.5 * (low + high), middle);
                }
            }
            return Ok(Some(next));
        }
        above = height(&next.q) > 0.0;
        point = next;
    }
    Ok(None)
}
