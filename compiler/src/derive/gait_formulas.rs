//! Formulas of a gait as expressions: of q, of φ and its ends, and of the gait parameters.
use super::curve::{bezier, splines};
use super::model::RobotModel;
use super::virtual_constraints::{GaitArguments, configuration_names};
use crate::description::gait::{
    Curve, Feedforward, FilePlace, GaitOutput, GaitParameter, PHASE, PHASE_END, PHASE_START,
};
use crate::expression::{Sloped, Sym, ValuedFormula};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::formula::Formula;
use bipedc_runtime::Argument;
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Names of formulas as expressions.
pub(super) struct Reader<'g, 'a> {
    names: RefCell<BTreeMap<String, Sym<'g>>>,
    quantities: &'a BTreeMap<String, Formula>,
    /// A node of the graph, for constants.
    some: Sym<'g>,
}

impl<'g> Reader<'g, '_> {
    pub fn of(&self, what: &str, formula: &Formula) -> Result<Sym<'g>, Diagnostic> {
        self.value(formula).map_err(|problem| {
            Diagnostic::error(format!("{what} has no value: {problem}"))
                .help("that is so whatever the state and the gait's parameters are: correct the formula")
        })
    }

    /// Circles were refused when the file was read.
    fn value(&self, formula: &Formula) -> Result<Sym<'g>, String> {
        let mut variables = vec![("", Sloped::constant(self.some, 0))];
        for name in formula.names() {
            let known = self.names.borrow().get(name).copied();
            let value = match (known, self.quantities.get(name)) {
                (Some(value), _) => value,
                (None, Some(quantity)) => {
                    let value = self.value(quantity)?;
                    // Once each: quantities may be named by many others.
                    self.names.borrow_mut().insert(name.clone(), value);
                    value
                }
                (None, None) => return Err(format!("nothing is called `{name}`")),
            };
            variables.push((name, Sloped::constant(value, 0)));
        }
        let formula = ValuedFormula { formula: formula.clone(), parameters: BTreeMap::new() };
        formula.of(&variables).map(|found| found.value)
    }
}

/// What formulas of a gait may name, on `model`; `points` are its contact points.
pub(super) fn reader<'g, 'a>(
    model: &RobotModel<'g, '_>,
    points: &[[Sym<'g>; 2]],
    (parameters, quantities): (&[GaitParameter], &'a BTreeMap<String, Formula>),
    arguments: GaitArguments,
) -> Reader<'g, 'a> {
    let argument = |index: usize| model.input(Argument::Parameters, index);
    let mut names = configuration_names(model, points);
    names.extend([PHASE, PHASE_START, PHASE_END].into_iter().map(str::to_owned).zip((0..3).map(argument)));
    for (index, parameter) in parameters.iter().enumerate() {
        names.insert(parameter.name.clone(), argument(arguments.parameter(index)));
    }
    Reader { names: RefCell::new(names), quantities, some: model.constant(0.0) }
}

impl<'g> Reader<'g, '_> {
    /// φ(q), written at `at`.
    pub fn variable(&self, formula: &Formula, at: FilePlace) -> Result<Sym<'g>, Diagnostic> {
        self.of("the phase variable", formula).map_err(|error| placed(error, at))
    }

    /// h₀ of outputs.
    pub fn controlled(&self, outputs: &[GaitOutput]) -> Result<Vec<Sym<'g>>, Diagnostic> {
        let value = |output: &GaitOutput| self.of(&about(output), &output.controlled);
        outputs.iter().map(|output| value(output).map_err(|error| placed(error, output.at))).collect()
    }

    /// h_d of outputs.
    pub fn wanted(&self, outputs: &[GaitOutput], phase: Sym<'g>) -> Result<Vec<Sym<'g>>, Diagnostic> {
        let value = |output: &GaitOutput| match &output.wanted {
            Curve::Formula(formula) => self.of(&about(output), formula),
            Curve::Bezier { coefficients, over, along, plus } => {
                let what = about(output);
                let place = self.along(&what, along.as_ref(), phase)?;
                self.plus(&what, bezier(place, coefficients, *over), plus.as_ref())
            }
        };
        outputs.iter().map(|output| value(output).map_err(|error| placed(error, output.at))).collect()
    }
}

/// What moves curves and torques with the gait parameters.
impl<'g> Reader<'g, '_> {
    fn along(&self, what: &str, along: Option<&Formula>, phase: Sym<'g>) -> Result<Sym<'g>, Diagnostic> {
        along.map_or(Ok(phase), |formula| self.of(what, formula))
    }

    fn plus(&self, what: &str, curve: Sym<'g>, plus: Option<&Formula>) -> Result<Sym<'g>, Diagnostic> {
        plus.map_or(Ok(curve), |formula| Ok(curve + self.of(what, formula)?))
    }

    /// Torques by joint at φ.
    pub fn feedforward(
        &self,
        model: &RobotModel<'g, '_>,
        of: Option<&Feedforward>,
        phase: Sym<'g>,
    ) -> Result<Vec<Sym<'g>>, Diagnostic> {
        const WHAT: &str = "the feed-forward";
        let mut torques = vec![model.constant(0.0); model.tree.joints.len()];
        let Some(of) = of else { return Ok(torques) };
        let place = self.along(WHAT, of.along.as_ref(), phase)?;
        let values: Vec<&[f64]> = of.torques.values().map(Vec::as_slice).collect();
        let splines = splines(place, &of.at, &values).unwrap_or_default();
        let of_joint = |name: &String| model.tree.joints.iter().position(|joint| joint.name == *name);
        for (name, spline) in of.torques.keys().zip(splines) {
            if let Some(joint) = of_joint(name) {
                torques[joint] = spline;
            }
        }
        for (name, formula) in &of.plus {
            if let Some(joint) = of_joint(name) {
                torques[joint] = self.plus(WHAT, torques[joint], Some(formula))?;
            }
        }
        Ok(torques)
    }
}

/// A message about what stands there.
pub(super) fn placed(error: Diagnostic, at: FilePlace) -> Diagnostic {
    error.at(at.line, at.column)
}

fn about(output: &GaitOutput) -> String {
    format!("the output `{}`", output.name)
}
