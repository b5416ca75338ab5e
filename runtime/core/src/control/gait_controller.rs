//! Input–output linearisation of a gait (6.2–6.4): the torques that keep a robot on its virtual constraints.
use super::elimination::solve;
use super::slices::{copy, get, set};
use super::step_end::Search;
use super::zero::SAMPLES;
use super::{Controller, Feedback, Gait, GaitLayout, JointCommand, Observation, Refusal};
use crate::model::{Argument, CallError, State};
use crate::real::Scalar;

/// Where the phase variable is, against the step that it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PhasePlace {
    /// φ < φ₊: the robot has gone back behind the beginning of its step. The constraints go on as their formulas do.
    Before,
    /// φ₊ ≤ φ ≤ φ₋.
    #[default]
    Within,
    /// φ > φ₋: the impact is late. h_p stays zero from there on.
    Beyond,
}

/// What a [`GaitController`] has to say of its last command.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct GaitStatus<R> {
    /// φ.
    pub phase: R,
    /// φ̇, per s.
    pub rate: R,
    /// φ₊ and φ₋ of the step.
    pub ends: [R; 2],
    /// Where φ is between these.
    pub place: PhasePlace,
    /// φ̇ < 0: the step is on its way back.
    pub turns_back: bool,
    /// The largest magnitude of an output, rad or m.
    pub error: R,
    /// Joints whose torque was clamped to its limit: bit k for the k-th joint, the last bit for all beyond.
    pub clamped: u32,
    /// The largest torque that was asked for beyond a limit, N m.
    pub excess: R,
    /// Why there is no command, or no step.
    pub refusal: Option<Refusal>,
}

impl<R: Scalar> GaitStatus<R> {
    fn new() -> Self {
        let zero = R::constant(0.0);
        Self {
            phase: zero,
            rate: zero,
            ends: [zero; 2],
            place: PhasePlace::Within,
            turns_back: false,
            error: zero,
            clamped: 0,
            excess: zero,
            refusal: Some(Refusal::NoStep),
        }
    }
}

/// Walks by a gait: `u = (L_g L_f h)⁻¹ (v − L_f² h)` (6.3) with a [`Feedback`] v, clamped to the joints' efforts.
///
/// It is told when a step begins ([`GaitController::begin_step`], which [`Controller::begin_phase`] calls): from the state just after the
/// impact it derives h_p, and takes the parameters that were asked for. In between its answer depends on the state alone. The state is
/// named by the roles of the legs, as the gait's phase does. Every call does a bounded amount of work, allocates nothing and does not panic.
#[derive(Debug, Clone)]
pub struct GaitController<R: Scalar, G: Gait<R>> {
    gait: G,
    feedback: Feedback<R>,
    memory: G::Memory,
    limited: bool,
    /// Whether there is a step, and why not.
    step: Result<(), Refusal>,
    status: GaitStatus<R>,
}

/// The memory, by what stands there.
struct Room<'m, R> {
    /// Of the present step; φ is any.
    arguments: &'m mut [R],
    /// Of the present call.
    present: &'m mut [R],
    /// Gait parameters of the next step.
    asked: &'m mut [R],
    controlled: &'m mut [R],
    wanted: &'m mut [R],
    lie: &'m mut [R],
    torques: &'m mut [R],
    /// For the constraint surface where it has no closed form.
    iteration: &'m mut [R],
}

impl<'m, R> Room<'m, R> {
    fn of(memory: &'m mut [R], layout: &GaitLayout) -> Option<Self> {
        let outputs = layout.outputs;
        let (arguments, rest) = memory.split_at_mut_checked(layout.arguments())?;
        let (present, rest) = rest.split_at_mut_checked(layout.arguments())?;
        let (asked, rest) = rest.split_at_mut_checked(layout.parameters)?;
        let (controlled, rest) = rest.split_at_mut_checked(2 * (1 + outputs))?;
        let (wanted, rest) = rest.split_at_mut_checked(2 * outputs)?;
        let (lie, rest) = rest.split_at_mut_checked(outputs * (3 + outputs))?;
        let (torques, rest) = rest.split_at_mut_checked(outputs)?;
        let (iteration, _) = rest.split_at_mut_checked(layout.iteration())?;
        Some(Self { arguments, present, asked, controlled, wanted, lie, torques, iteration })
    }
}

impl<R: Scalar> Room<'_, R> {
    /// The end of a step that begins at φ₊ = `start` with the parameters of the next one.
    fn search(&mut self, start: R) -> Search<'_, R> {
        let arguments = &mut *self.present;
        arguments.fill(R::constant(0.0));
        set(arguments, GaitLayout::START, start);
        copy(self.asked, arguments.get_mut(GaitLayout::PARAMETERS..).unwrap_or(&mut []));
        Search { arguments, iteration: self.iteration }
    }
}

impl From<CallError> for Refusal {
    fn from(_: CallError) -> Self {
        Self::WrongLength
    }
}

impl<R: Scalar, G: Gait<R>> GaitController<R, G> {
    /// With the gait's own parameters; no step has begun.
    pub fn new(gait: G, feedback: Feedback<R>) -> Self {
        let mut memory = gait.memory();
        if let Some(room) = Room::of(memory.as_mut(), &gait.layout()) {
            for (index, value) in room.asked.iter_mut().enumerate() {
                *value = R::constant(gait.parameter(index).map_or(0.0, |parameter| parameter.default));
            }
        }
        Self { gait, feedback, memory, limited: true, step: Err(Refusal::NoStep), status: GaitStatus::new() }
    }

    /// The same without limits of torques.
    #[must_use]
    pub fn unlimited(self) -> Self {
        Self { limited: false, ..self }
    }

    /// The gait.
    pub fn gait(&self) -> &G {
        &self.gait
    }

    /// Of the last command, or of the last begin of a step.
    pub fn status(&self) -> GaitStatus<R> {
        self.status
    }

    /// Asks for a gait parameter from the next step on.
    ///
    /// # Errors
    /// There is no such parameter, or the value is not finite; the one of before stays.
    pub fn ask(&mut self, index: usize, value: R) -> Result<(), Refusal> {
        if !value.is_finite() {
            return Err(Refusal::NotFinite);
        }
        let layout = self.gait.layout();
        let room = Room::of(self.memory.as_mut(), &layout).ok_or(Refusal::WrongLength)?;
        *room.asked.get_mut(index).ok_or(Refusal::WrongLength)? = value;
        Ok(())
    }

    /// Arguments of the gait's functions in the present step: φ (any), φ₊, φ₋, parameters, value and slope of each output's h_p.
    pub fn arguments(&self) -> &[R] {
        self.memory.as_ref().get(..self.gait.layout().arguments()).unwrap_or(&[])
    }

    /// φ₋ of a step that begins at φ₊ = `start`, with the parameters that were asked for; `None`: no phase ends it.
    pub fn step_end(&mut self, start: R) -> Option<R> {
        let layout = self.gait.layout();
        Room::of(self.memory.as_mut(), &layout)?.search(start).phase_end(&self.gait, &layout)
    }

    /// The guard before any step ends: at the smallest phase where it is looked for and there is a posture, on the constraint surface, with the
    /// parameters that were asked for. Its sign is that before the end.
    pub fn guard_before(&mut self) -> Option<R> {
        let layout = self.gait.layout();
        let [low, high] = layout.between.map(R::constant);
        let mut room = Room::of(self.memory.as_mut(), &layout)?;
        let mut search = room.search(low);
        let told = |guard: &R| guard.is_finite() && *guard != R::constant(0.0);
        (0..=SAMPLES).find_map(|k| {
            let part = R::constant(k as f64 / SAMPLES as f64);
            search.guard(&self.gait, &layout, R::fused(high - low, part, low)).filter(told)
        })
    }

    /// A step begins in this state (q: nq, v: nv), just after the impact and with legs exchanged: φ₊ is where it is, φ₋ where the guard
    /// will vanish, and h_p takes up what is left of the outputs and their rates (below 6.2).
    ///
    /// # Errors
    /// φ does not grow, or the step has no end or no room; until a step has begun there are no commands.
    pub fn begin_step(&mut self, q: &[R], v: &[R]) -> Result<(), Refusal> {
        self.step = self.step_from(q, v);
        self.status.refusal = self.step.err();
        self.step
    }

    fn step_from(&mut self, q: &[R], v: &[R]) -> Result<(), Refusal> {
        let Self { gait, memory, status, .. } = self;
        let layout = gait.layout();
        let mut room = Room::of(memory.as_mut(), &layout).ok_or(Refusal::WrongLength)?;
        let outputs = layout.outputs;
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        gait.evaluate(layout.controlled, &state, room.controlled)?;
        let (start, rate) = (get(room.controlled, 0), get(room.controlled, 1 + outputs));
        (status.phase, status.rate) = (start, rate);
        if !room.controlled.iter().all(|x| x.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        if rate <= R::constant(0.0) {
            return Err(Refusal::PhaseTurnsBack);
        }
        let end = room.search(start).phase_end(gait, &layout).ok_or(Refusal::NoEnd)?;
        status.ends = [start, end];
        if start >= end {
            return Err(Refusal::NoPhaseLeft);
        }
        let arguments = room.arguments;
        arguments.fill(R::constant(0.0));
        copy(&[start, start, end], arguments);
        copy(room.asked, arguments.get_mut(GaitLayout::PARAMETERS..).unwrap_or(&mut []));
        if layout.impact_matching {
            let state = State::new().with(Argument::Parameters, arguments);
            gait.evaluate(layout.wanted, &state, room.wanted)?;
            match_impact(&layout, (room.controlled, room.wanted), arguments);
        }
        if arguments.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Refusal::NotFinite) }
    }

    /// Torques of the joints, into the memory's last numbers; what there is to say of them, into the status.
    fn solve(&mut self, q: &[R], v: &[R]) -> Result<(), Refusal> {
        let Self { gait, feedback, memory, status, .. } = self;
        let layout = gait.layout();
        let room = Room::of(memory.as_mut(), &layout).ok_or(Refusal::WrongLength)?;
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        gait.evaluate(layout.controlled, &state, room.controlled)?;
        status.see(get(room.controlled, 0), get(room.controlled, 1 + layout.outputs));
        copy(room.arguments, room.present);
        if status.place == PhasePlace::Beyond {
            let matching = GaitLayout::PARAMETERS + layout.parameters;
            room.present.get_mut(matching..).unwrap_or(&mut []).fill(R::constant(0.0));
        }
        let state = state.with(Argument::Parameters, room.present);
        gait.evaluate(layout.lie_derivatives, &state, room.lie)?;
        status.error = R::constant(0.0);
        for (output, torque) in room.torques.iter_mut().enumerate() {
            let of = |column: usize| get(room.lie, column * layout.outputs + output);
            status.error = status.error.larger(of(0).abs());
            *torque = feedback.at(of(0), of(1)) - of(2);
        }
        // What the state itself spoils is not the matrix's fault.
        if !room.lie.iter().chain(room.torques.iter()).all(|x| x.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let matrix = room.lie.get_mut(3 * layout.outputs..).ok_or(Refusal::WrongLength)?;
        if !solve(matrix, room.torques) {
            return Err(Refusal::SingularOutputs);
        }
        if room.torques.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Refusal::NotFinite) }
    }

    /// The torques as commands, none beyond its limit.
    fn give(&mut self, commands: &mut [JointCommand<R>]) -> Result<(), Refusal> {
        let Self { gait, memory, limited, status, .. } = self;
        let layout = gait.layout();
        let room = Room::of(memory.as_mut(), &layout).ok_or(Refusal::WrongLength)?;
        if commands.len() != layout.outputs {
            return Err(Refusal::WrongLength);
        }
        for (joint, (command, torque)) in commands.iter_mut().zip(room.torques.iter()).enumerate() {
            let limit = gait.effort_limit(joint).filter(|_| *limited).map(R::constant);
            *command = JointCommand::Torque(match limit {
                Some(limit) if torque.abs() > limit => {
                    status.clamped |= 1 << joint.min(31);
                    status.excess = status.excess.larger(torque.abs() - limit);
                    torque.sign() * limit
                }
                _ => *torque,
            });
        }
        Ok(())
    }
}

impl<R: Scalar> GaitStatus<R> {
    /// φ and φ̇ of a new command; nothing else is known of it yet.
    fn see(&mut self, phase: R, rate: R) {
        let [start, end] = self.ends;
        let zero = R::constant(0.0);
        (self.phase, self.rate, self.turns_back) = (phase, rate, rate < zero);
        self.place = match () {
            () if phase < start => PhasePlace::Before,
            () if phase > end => PhasePlace::Beyond,
            () => PhasePlace::Within,
        };
        (self.error, self.clamped, self.excess) = (zero, 0, zero);
    }
}

/// Value and slope of h_p at φ₊: what is left of the outputs and their rates there.
fn match_impact<R: Scalar>(layout: &GaitLayout, (controlled, wanted): (&[R], &[R]), arguments: &mut [R]) {
    let outputs = layout.outputs;
    let rate = get(controlled, 1 + outputs);
    for output in 0..outputs {
        let [value, speed] = [1 + output, 2 + outputs + output].map(|k| get(controlled, k));
        let [goal, slope] = [output, outputs + output].map(|k| get(wanted, k));
        let first = GaitLayout::PARAMETERS + layout.parameters + 2 * output;
        set(arguments, first, value - goal);
        set(arguments, first + 1, speed / rate - slope);
    }
}

impl<R: Scalar, G: Gait<R>> Controller<R> for GaitController<R, G> {
    fn command(
        &mut self,
        observed: &Observation<'_, R>,
        commands: &mut [JointCommand<R>],
    ) -> Result<(), Refusal> {
        let solved = self.step.and_then(|()| self.solve(observed.q, observed.v));
        let given = solved.and_then(|()| self.give(commands));
        self.status.refusal = given.err();
        given
    }

    fn begin_phase(&mut self, observed: &Observation<'_, R>) -> Result<(), Refusal> {
        self.begin_step(observed.q, observed.v)
    }
}
