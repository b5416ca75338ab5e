//! A controller of a gait of several phases whose parameters are chosen at each mid-stance.
use super::foresight::Passed;
use super::notes::{Notes, Present, StepPart, StepSpeed};
use super::phased::PhasedChooser;
use super::stance::{Event, Stance};
use crate::gait::{Chain, PhasedProgramController, Refused};
use bipedc_analysis::gait::ChoiceKind;
use bipedc_compiler::compile::PhasePrograms;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};

/// Walks by a gait of several phases, and chooses the parameters of the next step at each mid-stance, where they are taken at once.
pub struct PhasedChoosing<'c, 'f> {
    controller: PhasedProgramController,
    chooser: &'c PhasedChooser<'c, 'f>,
    stance: Stance<'c>,
    notes: Notes<'c>,
}

impl<'c, 'f> PhasedChoosing<'c, 'f> {
    /// `values` are the parameters at the beginning, `names` those of all parameters; `wishes` are the speeds of the second step, the
    /// third, …, per s.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn new(
        controller: PhasedProgramController,
        (chain, chooser): (&'c Chain<'c>, &'c PhasedChooser<'c, 'f>),
        named: (Vec<String>, &[f64]),
        wishes: &'c [f64],
    ) -> Result<Self, Refused> {
        Ok(Self { controller, chooser, stance: Stance::new(chain)?, notes: Notes::new(named, wishes) })
    }

    /// Parameters that hold now.
    pub fn present(&self) -> Present {
        self.notes.shared()
    }

    /// Parts of steps with their parameters, in order of time.
    pub fn take_parts(&mut self) -> Vec<StepPart> {
        self.notes.take_parts()
    }

    /// Step after step; the last one may have been chosen without having begun.
    pub fn steps(self) -> Vec<StepSpeed> {
        self.notes.steps()
    }

    /// At mid-stance: chooses in the measured state, and takes what was chosen.
    fn passed(&mut self, observed: &Observation<'_, f64>, speed: f64) {
        self.notes.arrived(observed.time, speed, None);
        let Some(wished) = self.notes.wish() else { return };
        let now = Passed { q: observed.q.to_vec(), v: observed.v.to_vec(), speed };
        let choice = self.chooser.choose(&now, wished, &self.notes.present());
        let mut changed = self.controller.clone();
        let asked = choice.parameters.iter().enumerate().try_for_each(|(index, &x)| changed.ask(index, x));
        let begun = asked.and_then(|()| changed.begin(observed.phase, observed.q, observed.v));
        // What was foreseen the controller takes; if it does not after all, the step goes on as it is.
        let taken = choice.kind != ChoiceKind::None && begun.is_ok();
        if taken {
            self.controller = changed;
        }
        self.notes.chosen(observed, (wished, choice), taken);
    }
}

impl Controller<f64> for PhasedChoosing<'_, '_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        PhasePrograms::command(&mut self.controller, observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        PhasePrograms::begin_phase(&mut self.controller, observed)?;
        if self.stance.begins_step(observed.phase) {
            self.notes.begun(observed);
            // A step without a dead centre goes on with the parameters that it has.
            if let Ok(Some(rate)) = self.stance.begin(&self.notes.present(), observed) {
                self.passed(observed, rate);
            }
        }
        Ok(())
    }

    fn before_event(&mut self, observed: &Observation<'_, f64>) -> Option<f64> {
        self.stance.before(observed)
    }

    fn at_event(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        match self.stance.event(observed) {
            Some(Event::Passed(rate)) => self.passed(observed, rate),
            Some(Event::Rests(Some(missing))) => self.notes.arrived(observed.time, 0.0, Some(missing)),
            Some(Event::Rests(None)) | None => {}
        }
        Ok(())
    }
}
