//! `[[control.output]]`: virtual constraints as formulas.
use super::JointServo;
use super::file::{Control, Law};
use super::reading::{NOT_NEGATIVE, POSITIVE, Reading};
use crate::simulate::Plant;
use crate::simulate::control::{Feedback, Outputs, PhaseOutputs, Program, Signal, Step, signals};
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::spelling::suggest;
use std::collections::BTreeMap;
use toml::Spanned;

/// Quantities that refer to each other deeper than this go in a circle.
const DEPTH: usize = 64;

/// What names in formulas mean.
struct Names<'f> {
    signals: Vec<(String, Signal)>,
    parameters: BTreeMap<&'f str, f64>,
    quantities: &'f BTreeMap<String, Spanned<String>>,
    /// Signals in use, in the order in which the programs number them.
    used: Vec<Signal>,
}

/// The program of a phase, and the places of quantities that are in it already.
#[derive(Default)]
struct Draft {
    program: Program,
    quantities: BTreeMap<String, usize>,
}

impl Reading<'_> {
    /// The controller of `[control]`, if it has outputs.
    pub(super) fn outputs(
        &mut self,
        control: &Control,
        plant: &Plant,
        servos: &[JointServo],
    ) -> Option<Outputs> {
        if control.output.is_empty() {
            self.unused(control);
            return None;
        }
        let feedback = self.feedback(control.feedback.as_ref());
        let mut names = Names {
            signals: signals(plant),
            parameters: control.parameters.iter().map(|(k, v)| (k.as_str(), *v.get_ref())).collect(),
            quantities: &control.quantities,
            used: Vec::new(),
        };
        self.distinct(control, &names);
        let mut drafts: Vec<Option<Draft>> = plant.phases.iter().map(|_| None).collect();
        if plant.phases.is_empty() {
            let at = control.output[0].span().start;
            self.wrong::<()>(at, "the robot has no phases", "add [[phase]] tables to biped.toml");
        }
        for output in &control.output {
            let phases = match &output.get_ref().phase {
                Some(named) => self.phase(plant, named).map_or(0..0, |phase| phase..phase + 1),
                None => 0..drafts.len(),
            };
            for phase in phases {
                let draft = drafts[phase].get_or_insert_default();
                let Some(root) = self.compile(&output.get_ref().formula, &mut names, draft, 0) else { break };
                let program = &mut draft.program;
                program.output(root);
                let at = output.get_ref().formula.span().start;
                let last = program.outputs() - 1;
                if !program.moves(last) {
                    let help = "an output depends on joints, the base or contact points";
                    self.wrong::<()>(at, "this output never moves", help);
                    break;
                }
                if program.outputs() > plant.actuated.len() {
                    let message = format!("phase `{}` has more outputs than actuators", plant.phases[phase]);
                    let help = format!("the robot has {} actuators: see [actuation]", plant.actuated.len());
                    self.wrong::<()>(at, message, help);
                    break;
                }
            }
        }
        let done = |draft: Option<Draft>| draft.map(|d| PhaseOutputs { program: d.program, feedback });
        Some(Outputs {
            signals: names.used,
            phases: drafts.into_iter().map(done).collect(),
            actuated: plant.actuated.clone(),
            limits: servos.iter().map(|servo| servo.limit).collect(),
        })
    }

    /// Keys that mean something only with outputs.
    fn unused(&mut self, control: &Control) {
        let feedback = control.feedback.as_ref().map(|law| law.span().start);
        let parameter = control.parameters.values().next().map(|value| value.span().start);
        let quantity = control.quantities.values().next().map(|value| value.span().start);
        if let Some(at) = feedback.or(parameter).or(quantity) {
            let message =
                "feedback, parameters and quantities of [control] belong to outputs; there are none";
            self.wrong::<()>(at, message, "add [[control.output]] or `gait`, or leave them out");
        }
    }

    /// Parameters and quantities may not take the name of something else.
    fn distinct(&mut self, control: &Control, names: &Names<'_>) {
        let known = |name: &str| names.signals.iter().any(|(other, _)| other == name);
        let parameters = control.parameters.iter().map(|(name, value)| (name, value.span().start));
        let quantities = control.quantities.iter().map(|(name, text)| (name, text.span().start));
        for (name, at) in parameters.chain(quantities) {
            if known(name) {
                let message = format!("`{name}` is the robot's already");
                self.wrong::<()>(at, message, "choose another name");
            }
        }
        for (name, text) in &control.quantities {
            if control.parameters.contains_key(name) {
                self.wrong::<()>(text.span().start, format!("`{name}` is a parameter already"), "rename one");
            }
        }
        for (name, value) in &control.parameters {
            if !value.get_ref().is_finite() {
                self.wrong::<()>(value.span().start, format!("`{name}` is not finite"), "write a number");
            }
        }
    }

    /// A formula into a program; the place of its result.
    fn compile(
        &mut self,
        text: &Spanned<String>,
        names: &mut Names<'_>,
        draft: &mut Draft,
        depth: usize,
    ) -> Option<usize> {
        let formula = match Formula::parse(text.get_ref()) {
            Ok(formula) => formula,
            Err(error) => {
                // The quotation mark stands before the text.
                let at = text.span().start + 1 + bytes(text.get_ref(), error.at);
                return self.wrong(at, error.message, error.help);
            }
        };
        if depth > DEPTH {
            let help = "a quantity may not depend on itself";
            return self.wrong(text.span().start, "these quantities go in a circle", help);
        }
        let mut places = Vec::with_capacity(formula.names().len());
        for name in formula.names() {
            places.push(self.name(name, text, names, draft, depth)?);
        }
        Some(draft.program.term(formula.root(), &places))
    }

    fn name(
        &mut self,
        name: &str,
        text: &Spanned<String>,
        names: &mut Names<'_>,
        draft: &mut Draft,
        depth: usize,
    ) -> Option<usize> {
        if let Some((_, signal)) = names.signals.iter().find(|(other, _)| other == name) {
            let signal = *signal;
            let index = names.used.iter().position(|other| *other == signal).unwrap_or_else(|| {
                names.used.push(signal);
                names.used.len() - 1
            });
            return Some(draft.program.step(Step::Signal(index)));
        }
        if let Some(value) = names.parameters.get(name) {
            return Some(draft.program.step(Step::Number(*value)));
        }
        let quantities = names.quantities;
        if let Some(place) = draft.quantities.get(name) {
            return Some(*place);
        }
        if let Some(quantity) = quantities.get(name) {
            let place = self.compile(quantity, names, draft, depth + 1)?;
            draft.quantities.insert(name.to_owned(), place);
            return Some(place);
        }
        let known: Vec<&str> = names
            .signals
            .iter()
            .map(|(name, _)| name.as_str())
            .chain(names.parameters.keys().copied())
            .chain(quantities.keys().map(String::as_str))
            .collect();
        let help = suggest(name, known.iter().copied(), || format!("known are: {}", known.join(", ")));
        self.wrong(text.span().start, format!("`{name}` is nothing that a formula can speak of"), help)
    }

    pub(super) fn feedback(&mut self, law: Option<&Spanned<Law>>) -> Feedback {
        let Some(spanned) = law else { return Feedback::default() };
        let law = spanned.get_ref();
        let linear = [law.stiffness.as_ref(), law.damping.as_ref()];
        let finite = [law.exponent.as_ref(), law.time_scale.as_ref()];
        let (wanted, foreign) = match law.law.as_ref().map(|law| (law.get_ref().as_str(), law.span().start)) {
            None | Some(("pd", _)) => ("pd", finite),
            Some(("finite_time", _)) => ("finite_time", linear),
            Some((other, at)) => {
                let message = format!("there is no feedback \"{other}\"");
                self.wrong::<()>(at, message, "write law = \"pd\" or \"finite_time\"");
                return Feedback::default();
            }
        };
        if let Some(key) = foreign.into_iter().flatten().next() {
            let help = "\"pd\" has `stiffness` (1/s²) and `damping` (1/s), \"finite_time\" `exponent` and `time_scale` (s)";
            self.wrong::<()>(
                key.span().start,
                format!("this key has no meaning with law = \"{wanted}\""),
                help,
            );
        }
        if wanted == "pd" {
            return Feedback::Linear {
                stiffness: self.number("stiffness", linear[0], 400.0, POSITIVE, "1/s²"),
                damping: self.number("damping", linear[1], 40.0, NOT_NEGATIVE, "1/s"),
            };
        }
        Feedback::FiniteTime {
            exponent: self.number("exponent", finite[0], 0.9, (0.01, 0.999), "1"),
            time_scale: self.number("time_scale", finite[1], 0.1, (1e-4, 1e4), "s"),
        }
    }
}

/// Bytes before the character of this index.
fn bytes(text: &str, character: usize) -> usize {
    text.chars().take(character).map(char::len_utf8).sum()
}
