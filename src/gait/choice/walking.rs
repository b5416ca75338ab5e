//! A gait's controller whose parameters are chosen at each mid-stance.
use super::super::ProgramController;
use bipedc_analysis::gait::{ChoiceKind, Chooser, GaitModel};
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use serde::Serialize;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// A step as it was walked, and how its speed was wished and predicted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepSpeed {
    /// 0 for the step at the beginning.
    pub step: usize,
    /// When its mid-stance was passed, s; `None`: it never was.
    pub time: Option<f64>,
    /// φ̇ at mid-stance that was wished, per s; `None` for the first step, and behind the last wish.
    pub wished: Option<f64>,
    /// What was predicted at the mid-stance before.
    pub predicted: Option<f64>,
    /// φ̇ at mid-stance, per s; 0: it came to rest before.
    pub reached: Option<f64>,
    /// How far before φ_m it came to rest, in the unit of φ.
    pub rests_before: Option<f64>,
    /// How its parameters were chosen.
    pub choice: Option<ChoiceKind>,
    /// To the wished speed, as they were planned, this one included.
    pub steps_to_wished: Option<usize>,
    /// Its parameters, taken at the mid-stance before.
    pub parameters: BTreeMap<String, f64>,
}

/// From here on the robot walked with these parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct StepPart {
    /// Of the step it belongs to.
    pub step: usize,
    /// s
    pub time: f64,
    /// All of them.
    pub parameters: Vec<f64>,
    /// q at its beginning, legs named by their roles.
    pub q: Vec<f64>,
    /// v there.
    pub v: Vec<f64>,
}

/// Parameters that hold now, shared with what ends a step.
pub type Present = Rc<RefCell<Vec<f64>>>;

/// What was chosen at the last mid-stance.
#[derive(Debug, Clone, Copy)]
struct Chosen {
    wished: f64,
    predicted: Option<f64>,
    kind: ChoiceKind,
    steps: Option<usize>,
}

/// Walks by a gait, and chooses the parameters of the next step at each mid-stance.
///
/// They are taken at once: h_p takes up what they change, so that the foot in the air already goes where the next step begins.
pub struct Choosing<'c> {
    controller: ProgramController,
    model: &'c GaitModel<'c>,
    chooser: &'c Chooser<'c, 'c>,
    names: Vec<String>,
    wishes: &'c [f64],
    present: Present,
    chosen: Option<Chosen>,
    /// φ_m of the present step, while it is still to come.
    dead_centre: Option<f64>,
    steps: Vec<StepSpeed>,
    parts: Vec<StepPart>,
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
        let present = Rc::new(RefCell::new(values.to_vec()));
        let (chosen, dead_centre, steps, parts) = (None, None, Vec::new(), Vec::new());
        Self { controller, model, chooser, names, wishes, present, chosen, dead_centre, steps, parts }
    }

    /// Parameters that hold now.
    pub fn present(&self) -> Present {
        Rc::clone(&self.present)
    }

    /// Parts of steps with their parameters, in order of time.
    pub fn take_parts(&mut self) -> Vec<StepPart> {
        std::mem::take(&mut self.parts)
    }

    /// Step after step; the last one may have been chosen without having begun.
    pub fn steps(mut self) -> Vec<StepSpeed> {
        if self.chosen.is_some() {
            self.note();
        }
        self.steps
    }

    /// Chooses in the measured state, and takes what was chosen.
    fn choose(&mut self, observed: &Observation<'_, f64>) {
        let (q, v) = (observed.q, observed.v);
        let wished = self.steps.len().checked_sub(1).and_then(|index| self.wishes.get(index));
        let Some(&wished) = wished else {
            self.chosen = None;
            return;
        };
        let present = self.present.borrow().clone();
        let choice = self.chooser.choose(q, v, wished, &present);
        let mut kind = choice.kind;
        // What the zero dynamics allow the controller takes; if it does not after all, the step goes on as it is.
        let mut changed = self.controller.clone();
        let asked = choice.parameters.iter().enumerate().try_for_each(|(index, &x)| changed.ask(index, x));
        if kind != ChoiceKind::None && asked.and_then(|()| changed.begin_step(q, v)).is_ok() {
            self.controller = changed;
            *self.present.borrow_mut() = choice.parameters;
            self.part(self.steps.len().saturating_sub(1), observed);
        } else {
            kind = ChoiceKind::None;
        }
        self.chosen = Some(Chosen { wished, predicted: choice.predicted, kind, steps: choice.steps });
    }

    /// Notes a step with the parameters that hold now.
    fn note(&mut self) {
        let values = self.present.borrow().clone();
        let named = self.names.iter().cloned().zip(values.iter().copied()).collect();
        let chosen = self.chosen.take();
        self.steps.push(StepSpeed {
            step: self.steps.len(),
            time: None,
            wished: chosen.map(|chosen| chosen.wished),
            predicted: chosen.and_then(|chosen| chosen.predicted),
            reached: None,
            rests_before: None,
            choice: chosen.map(|chosen| chosen.kind),
            steps_to_wished: chosen.and_then(|chosen| chosen.steps),
            parameters: named,
        });
    }

    fn part(&mut self, step: usize, observed: &Observation<'_, f64>) {
        let (q, v) = (observed.q.to_vec(), observed.v.to_vec());
        let parameters = self.present.borrow().clone();
        self.parts.push(StepPart { step, time: observed.time, parameters, q, v });
    }

    fn begun(&mut self, observed: &Observation<'_, f64>) {
        self.note();
        self.part(self.steps.len() - 1, observed);
        let values = self.present.borrow().clone();
        let course = self.model.course_from(&values, observed.q, observed.v);
        self.dead_centre = course.ok().map(|course| course.dead_centre);
    }
}

impl Controller<f64> for Choosing<'_> {
    fn command(
        &mut self,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        self.controller.command(observed, commands)
    }

    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        self.controller.begin_phase(observed)?;
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
        let rests = rate.abs() < missing.abs();
        if let Some(step) = self.steps.last_mut() {
            step.time = Some(observed.time);
            step.reached = Some(if rests { 0.0 } else { rate });
            step.rests_before = rests.then_some(missing);
        }
        if !rests {
            self.choose(observed);
        }
        Ok(())
    }
}
