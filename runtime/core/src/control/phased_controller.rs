//! Walking by a gait of several phases (6.25–6.29): torques that keep a robot on the virtual constraints of its phase, with those that are
//! left over nearest to the feed-forward that keeps the limits of ground and drives.
use super::gait_controller::PhasePlace;
use super::ground_limits::Limit;
use super::phased::{PhaseLayout, PhasedGait, PhasedLayout};
use super::phased_torques::{Asked, GaveWay, Room};
use super::slices::{copy, get, set};
use super::{Controller, Feedback, JointCommand, Observation, Refusal};
use crate::model::{Argument, State};
use crate::real::Scalar;

/// What a [`PhasedController`] has to say of its last command.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PhasedStatus<R> {
    /// Which of the gait's phases it is in.
    pub index: usize,
    /// φ.
    pub phase: R,
    /// φ̇, per s.
    pub rate: R,
    /// φ₊, and φ₋ where h_p has vanished.
    pub ends: [R; 2],
    /// Where φ is between these.
    pub place: PhasePlace,
    /// φ̇ < 0: the phase is on its way back.
    pub turns_back: bool,
    /// The largest magnitude of an output, rad or m.
    pub error: R,
    /// A limit that torques were held to, if any was: the last one that was met.
    pub limit: Option<Limit>,
    /// How many limits torques were held to.
    pub limits: usize,
    /// What could not be met.
    pub gave_way: GaveWay,
    /// Why there is no command, or no phase.
    pub refusal: Option<Refusal>,
}

impl<R: Scalar> PhasedStatus<R> {
    fn new() -> Self {
        let zero = R::constant(0.0);
        Self {
            index: 0,
            phase: zero,
            rate: zero,
            ends: [zero; 2],
            place: PhasePlace::Within,
            turns_back: false,
            error: zero,
            limit: None,
            limits: 0,
            gave_way: GaveWay::Nothing,
            refusal: Some(Refusal::NoStep),
        }
    }

    /// φ and φ̇ of a new command; nothing else is known of it yet.
    fn see(&mut self, phase: R, rate: R) {
        let [start, end] = self.ends;
        let zero = R::constant(0.0);
        (self.phase, self.rate, self.turns_back, self.error) = (phase, rate, rate < zero, zero);
        self.place = match () {
            () if phase > end => PhasePlace::Beyond,
            () if phase < start => PhasePlace::Before,
            () => PhasePlace::Within,
        };
        (self.limit, self.limits, self.gave_way) = (None, 0, GaveWay::Nothing);
    }
}

/// Walks by a gait of several phases.
///
/// It is told when a phase begins ([`Controller::begin_phase`]): from the state there, just after any impact, it derives h_p, and where it is
/// the gait's first phase takes the parameters that were asked for. In between its answer depends on the state alone. Torques are
/// the least change of the feed-forward for which the outputs have the accelerations of the [`Feedback`] and the limits hold: the
/// drives' largest torques; feet push, do not slip and do not tip, but for what ends the phase. Where that is not possible its status says what
/// gave way. Every call does a bounded amount of work, allocates nothing and does not panic.
#[derive(Debug, Clone)]
pub struct PhasedController<R: Scalar, G: PhasedGait<R>> {
    gait: G,
    /// Of phases without their own, or of all.
    feedback: Feedback<R>,
    everywhere: bool,
    memory: G::Memory,
    limited: bool,
    grounded: bool,
    /// The present phase, or why there is none.
    phase: Result<PhaseLayout, Refusal>,
    status: PhasedStatus<R>,
}

impl<R: Scalar, G: PhasedGait<R>> PhasedController<R, G> {
    /// With the gait's own parameters and feedback; no phase has begun.
    pub fn new(gait: G) -> Self {
        let mut memory = gait.memory();
        if let Some(room) = Room::of(memory.as_mut(), &gait.layout()) {
            for (index, value) in room.asked.iter_mut().enumerate() {
                *value = R::constant(gait.parameter(index).map_or(0.0, |parameter| parameter.default));
            }
        }
        Self {
            gait,
            feedback: Feedback::default(),
            everywhere: false,
            memory,
            limited: true,
            grounded: true,
            phase: Err(Refusal::NoStep),
            status: PhasedStatus::new(),
        }
    }

    /// The same with another feedback, in all phases.
    #[must_use]
    pub fn with_feedback(self, feedback: Feedback<R>) -> Self {
        Self { feedback, everywhere: true, ..self }
    }

    /// The same without limits of torques.
    #[must_use]
    pub fn unlimited(self) -> Self {
        Self { limited: false, ..self }
    }

    /// The same without limits of the ground: torques are what the outputs ask for.
    #[must_use]
    pub fn ungrounded(self) -> Self {
        Self { grounded: false, ..self }
    }

    /// From now on with or without limits of the drives and of the ground; what was before.
    pub fn keep_limits(&mut self, [drives, ground]: [bool; 2]) -> [bool; 2] {
        let before = [self.limited, self.grounded];
        [self.limited, self.grounded] = [drives, ground];
        before
    }

    /// The gait.
    pub fn gait(&self) -> &G {
        &self.gait
    }

    /// Of the last command, or of the last begin of a phase.
    pub fn status(&self) -> PhasedStatus<R> {
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

    /// Arguments of the gait's functions in the present phase: φ (any), φ₊, φ₋, parameters, value and slope of each output's h_p.
    pub fn arguments(&self) -> &[R] {
        self.memory.as_ref().get(..self.gait.layout().arguments()).unwrap_or(&[])
    }

    /// A phase of the description (by index) begins in this state (q: nq, v: nv), just after any impact and with legs exchanged: φ₊ is
    /// where it is, and h_p takes up what is left of the outputs and their rates (below 6.27).
    ///
    /// # Errors
    /// The gait does not have the phase, or φ does not grow; until a phase has begun there are no commands.
    pub fn begin(&mut self, phase: usize, q: &[R], v: &[R]) -> Result<(), Refusal> {
        self.phase = self.begun(phase, q, v);
        self.status.refusal = self.phase.err();
        self.phase.map(|_| ())
    }

    fn begun(&mut self, phase: usize, q: &[R], v: &[R]) -> Result<PhaseLayout, Refusal> {
        let fresh = self.phase == Err(Refusal::NoStep);
        let Self { gait, memory, status, .. } = self;
        let layout = gait.layout();
        let found = (0..layout.phases).find(|&k| gait.phase(k).is_some_and(|known| known.phase == phase));
        let index = found.ok_or(Refusal::Because("the gait does not have this phase"))?;
        let of = gait.phase(index).ok_or(Refusal::WrongLength)?;
        let room = Room::of(memory.as_mut(), &layout).and_then(|room| room.cut(&layout, &of));
        let room = room.ok_or(Refusal::WrongLength)?;
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        gait.evaluate(of.controlled, &state, room.controlled)?;
        let (start, rate) = (get(room.controlled, 0), get(room.controlled, 1 + of.outputs));
        (status.index, status.phase, status.rate) = (index, start, rate);
        if !room.controlled.iter().all(|x| x.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        if rate <= R::constant(0.0) {
            return Err(Refusal::PhaseTurnsBack);
        }
        let arguments = room.arguments;
        if index == 0 || fresh {
            copy(room.asked, arguments.get_mut(3..).unwrap_or(&mut []));
        }
        arguments.get_mut(layout.matching()..).unwrap_or(&mut []).fill(R::constant(0.0));
        let mut end = [start];
        gait.evaluate(of.end, &State::new().with(Argument::Parameters, arguments), &mut end)?;
        status.ends = [start, end[0]];
        copy(&[start, start, end[0]], arguments);
        // What begins behind its end has no h_p.
        if of.impact_matching && start < end[0] {
            gait.evaluate(of.wanted, &State::new().with(Argument::Parameters, arguments), room.wanted)?;
            match_beginning((&layout, &of), (room.controlled, room.wanted), arguments);
        }
        if arguments.iter().all(|x| x.is_finite()) { Ok(of) } else { Err(Refusal::NotFinite) }
    }

    /// Torques of the joints into the memory; what there is to say of them into the status.
    fn solve(&mut self, q: &[R], v: &[R]) -> Result<(), Refusal> {
        let of = self.phase?;
        let Self { gait, memory, status, .. } = self;
        let layout = gait.layout();
        let room = Room::of(memory.as_mut(), &layout).and_then(|room| room.cut(&layout, &of));
        let room = room.ok_or(Refusal::WrongLength)?;
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        gait.evaluate(of.controlled, &state, room.controlled)?;
        let phase = get(room.controlled, 0);
        status.see(phase, get(room.controlled, 1 + of.outputs));
        copy(room.arguments, room.present);
        set(room.present, 0, phase);
        if status.place == PhasePlace::Beyond {
            room.present.get_mut(layout.matching()..).unwrap_or(&mut []).fill(R::constant(0.0));
        }
        let arguments = State::new().with(Argument::Parameters, room.present);
        gait.evaluate(of.feedforward, &arguments, room.feedforward)?;
        gait.evaluate(of.lie_derivatives, &state.with(Argument::Parameters, room.present), room.lie)?;
        if !room.lie.iter().chain(room.feedforward.iter()).all(|x| x.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let asked = Asked {
            layout: &layout,
            phase: &of,
            feedback: self.feedback_in(&of),
            grounded: self.grounded,
            limited: self.limited,
        };
        let Self { gait, memory, status, .. } = self;
        let room = Room::of(memory.as_mut(), &layout).and_then(|room| room.cut(&layout, &of));
        let chosen = room.ok_or(Refusal::WrongLength)?.choose(&asked, |joint| gait.effort_limit(joint))?;
        (status.error, status.limit) = (chosen.error, chosen.limit);
        (status.limits, status.gave_way) = (chosen.limits, chosen.gave_way);
        Ok(())
    }

    fn feedback_in(&self, phase: &PhaseLayout) -> Feedback<R> {
        match phase.feedback.filter(|_| !self.everywhere) {
            Some([stiffness, damping]) => {
                Feedback::Linear { stiffness: R::constant(stiffness), damping: R::constant(damping) }
            }
            None => self.feedback,
        }
    }

    fn give(&mut self, commands: &mut [JointCommand<R>]) -> Result<(), Refusal> {
        let layout = self.gait.layout();
        let room = Room::of(self.memory.as_mut(), &layout).ok_or(Refusal::WrongLength)?;
        if commands.len() != layout.joints {
            return Err(Refusal::WrongLength);
        }
        let given = commands.iter_mut().zip(room.torques.iter());
        given.for_each(|(command, torque)| *command = JointCommand::Torque(*torque));
        Ok(())
    }
}

/// Value and slope of h_p at φ₊: what is left of the outputs and their rates there.
fn match_beginning<R: Scalar>(
    (layout, phase): (&PhasedLayout, &PhaseLayout),
    (controlled, wanted): (&[R], &[R]),
    arguments: &mut [R],
) {
    let outputs = phase.outputs;
    let rate = get(controlled, 1 + outputs);
    for output in 0..outputs {
        let [value, speed] = [1 + output, 2 + outputs + output].map(|k| get(controlled, k));
        let [goal, slope] = [output, outputs + output].map(|k| get(wanted, k));
        let first = layout.matching() + 2 * output;
        set(arguments, first, value - goal);
        set(arguments, first + 1, speed / rate - slope);
    }
}

impl<R: Scalar, G: PhasedGait<R>> Controller<R> for PhasedController<R, G> {
    fn command(
        &mut self,
        observed: &Observation<'_, R>,
        commands: &mut [JointCommand<R>],
    ) -> Result<(), Refusal> {
        let given = self.solve(observed.q, observed.v).and_then(|()| self.give(commands));
        self.status.refusal = given.err();
        given
    }

    fn begin_phase(&mut self, observed: &Observation<'_, R>) -> Result<(), Refusal> {
        self.begin(observed.phase, observed.q, observed.v)
    }
}
