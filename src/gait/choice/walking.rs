//! A gait's controller whose parameters are chosen at each mid-stance.
use super::super::ProgramController;
use super::notes::{Notes, Present, StepPart, StepSpeed};
use bipedc_analysis::gait::{ChoiceKind, Chooser, GaitModel};
use bipedc_compiler::compile::GaitPrograms;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};

/// Walks by a gait, and chooses the parameters of the next step at each mid-stance.
///
/// They are taken at once: h_p takes up what they change, so that the foot in the air already goes where the next step begins.
pub struct Choosing<'c> {
    controller: ProgramController,
    model: &'c GaitModel<'c>,
    chooser: &'c Chooser<'c, 'c>,
    notes: Notes<'c>,
    /// φ_m of the present step, while it is still to come.
    dead_centre: Option<f64>,
}

impl<'c> Choosing<'c> {
    /// `values` are the parameters at the beginning, `names` those of all parameters; `wishes` are the speeds of the second step, the
    /// third, …, per s.
    pub fn new(
        controller: ProgramController,
        (model, chooser): (&'c GaitModel<'c>, &'c Chooser<'c, 'c>),
        (names, values): (Vec<String>, &[f64]),
        wishes: &'c [f64],
    ) -> Self {
        let notes = Notes::new((names, values), wishes);
        Self { controller, model, chooser, notes, dead_centre: None }
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

    /// Chooses in the measured state, and takes what was chosen.
    fn choose(&mut self, observed: &Observation<'_, f64>) {
        let (q, v) = (observed.q, observed.v);
        let Some(wished) = self.notes.wish() else { return };
        let choice = self.chooser.choose(q, v, wished, &self.notes.present());
        // What the zero dynamics allow the controller takes; if it does not after all, the step goes on as it is.
        let mut changed = self.controller.clone();
        let asked = choice.parameters.iter().enumerate().try_for_each(|(index, &x)| changed.ask(index, x));
        let taken = choice.kind != ChoiceKind::None && asked.and_then(|()| changed.begin_step(q, v)).is_ok();
        if taken {
            self.controller = changed;
        }
        self.notes.chosen(observed, (wished, choice), taken);
    }

    fn begun(&mut self, observed: &Observation<'_, f64>) {
        self.notes.begun(observed);
        let course = self.model.course_from(&self.notes.present(), observed.q, observed.v);
        self.dead_centre = course.ok().map(|course| course.dead_centre);
    }
}

impl Controller<f64> for Choosing<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        GaitPrograms::command(&mut self.controller, observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        GaitPrograms::begin_phase(&mut self.controller, observed)?;
        self.begun(observed);
        // Where the way down begins with the step, mid-stance is now.
        let start = self.model.phase_at(observed.q, observed.v)[0];
        match self.dead_centre {
            Some(centre) if centre <= start => self.at_event(observed),
            _ => Ok(()),
        }
    }

    fn before_event(&mut self, observed: &Observation<'_, f64>) -> Option<f64> {
        let centre = self.dead_centre?;
        let [phase, rate] = self.model.phase_at(observed.q, observed.v);
        // Until it is there, or does not go on.
        Some(rate.min(centre - phase))
    }

    fn at_event(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        let Some(centre) = self.dead_centre.take() else { return Ok(()) };
        let [phase, rate] = self.model.phase_at(observed.q, observed.v);
        let missing = centre - phase;
        // Of the two that may have fallen through zero it is the one that is nearer to it.
        let rests = (rate.abs() < missing.abs()).then_some(missing);
        self.notes.arrived(observed.time, rate, rests);
        if rests.is_none() {
            self.choose(observed);
        }
        Ok(())
    }
}
