//! What is noted of steps whose parameters are chosen while they are walked.
use bipedc_analysis::gait::{Choice, ChoiceKind};
use bipedc_runtime::control::Observation;
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

/// Steps, their wishes and their parameters.
pub(super) struct Notes<'c> {
    names: Vec<String>,
    wishes: &'c [f64],
    present: Present,
    chosen: Option<Chosen>,
    steps: Vec<StepSpeed>,
    parts: Vec<StepPart>,
}

impl<'c> Notes<'c> {
    /// `values` are the parameters at the beginning; `wishes` are the speeds of the second step, the third, …, per s.
    pub fn new((names, values): (Vec<String>, &[f64]), wishes: &'c [f64]) -> Self {
        let present = Rc::new(RefCell::new(values.to_vec()));
        Self { names, wishes, present, chosen: None, steps: Vec::new(), parts: Vec::new() }
    }

    /// Parameters that hold now, shared.
    pub fn shared(&self) -> Present {
        Rc::clone(&self.present)
    }

    /// A copy of them.
    pub fn present(&self) -> Vec<f64> {
        self.present.borrow().clone()
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

    /// What is wished of the next step; nothing was chosen yet.
    pub fn wish(&mut self) -> Option<f64> {
        self.chosen = None;
        let index = self.steps.len().checked_sub(1)?;
        self.wishes.get(index).copied()
    }

    /// A step begins in this state.
    pub fn begun(&mut self, observed: &Observation<'_, f64>) {
        self.note();
        self.part(observed);
    }

    /// The present step is at its mid-stance, or comes to rest so far before it.
    pub fn arrived(&mut self, time: f64, rate: f64, rests_before: Option<f64>) {
        let Some(step) = self.steps.last_mut() else { return };
        step.time = Some(time);
        step.reached = Some(if rests_before.is_some() { 0.0 } else { rate });
        step.rests_before = rests_before;
    }

    /// What was chosen for the next step; its parameters hold from here on if they were `taken`.
    pub fn chosen(&mut self, observed: &Observation<'_, f64>, (wished, choice): (f64, Choice), taken: bool) {
        let Choice { parameters, predicted, steps, kind } = choice;
        if taken {
            *self.present.borrow_mut() = parameters;
            self.part(observed);
        }
        let kind = if taken { kind } else { ChoiceKind::None };
        self.chosen = Some(Chosen { wished, predicted, kind, steps });
    }

    /// Notes a step with the parameters that hold now.
    fn note(&mut self) {
        let values = self.present();
        let named = self.names.iter().cloned().zip(values).collect();
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

    fn part(&mut self, observed: &Observation<'_, f64>) {
        let (q, v) = (observed.q.to_vec(), observed.v.to_vec());
        let step = self.steps.len().saturating_sub(1);
        self.parts.push(StepPart { step, time: observed.time, parameters: self.present(), q, v });
    }
}
