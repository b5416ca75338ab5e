//! What is wrong with a gait file and is only seen in numbers.
use super::GaitBench;
use super::parameters::Parametrised;
use bipedc_compiler::derive::dependence::dependent_row;
use bipedc_compiler::description::gait::{FilePlace, GaitOutput};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::{Argument, Model, State};

/// Configurations that are looked at: what depends in all of them does so by what the formulas say, not by chance.
const LOOKS: usize = 3;

/// Configurations of no special kind, the same ones every time.
pub(super) fn configurations(size: usize) -> impl Iterator<Item = Vec<f64>> {
    (0..LOOKS)
        .map(move |look| (0..size).map(|k| 0.4 * (2.3 * k as f64 + 1.7 * look as f64 + 0.6).sin()).collect())
}

/// The row that says nothing new in each of several matrices; none: there is a matrix without one, or they differ.
pub(super) fn dependent_in_all(mut matrices: impl Iterator<Item = Vec<Vec<f64>>>) -> Option<usize> {
    let first = dependent_row(&matrices.next()?)?;
    matrices.all(|rows| dependent_row(&rows) == Some(first)).then_some(first)
}

/// That an output does not fix what others leave open.
pub(super) fn says_nothing_new(output: &GaitOutput, others: &str) -> Diagnostic {
    let FilePlace { line, column } = output.at;
    let message =
        format!("the output `{}` says nothing new beside {others}: the joints are not fixed", output.name);
    let help = "each [[phase.output]] controls something that contacts, the others and the phase variable leave open";
    Diagnostic::error(message).at(line, column).help(help)
}

impl GaitBench {
    /// That outputs fix the joints, and that φ grows.
    pub(super) fn checked(&self) -> Result<(), Diagnostic> {
        if let Some(output) = self.dependent_output() {
            return Err(says_nothing_new(output, "the outputs before it and the phase variable"));
        }
        let Some([phase, momentum]) = self.model()?.falling_phase(&self.defaults()) else { return Ok(()) };
        let FilePlace { line, column } = self.gait.phase.variable_at;
        let message = format!(
            "the phase variable decreases as the robot goes forward: where it is {phase:.6} it falls with the angular momentum about the foot that stands \
             ({momentum:.6} kg m² of it)"
        );
        let help = "write it with the other sign, `phase` of what is wanted too, and `between` of the guard: φ grows along the step";
        Err(Diagnostic::error(message).at(line, column).help(help))
    }

    /// An output that says what those before it and φ say, whatever the posture.
    fn dependent_output(&self) -> Option<&GaitOutput> {
        let jacobian = Model::<f64>::function(&self.model, "virtual_constraints_jacobian")?;
        let (n, count) = (Model::<f64>::nq(&self.model), self.gait.phase.outputs.len());
        let arguments = vec![0.0; Model::<f64>::argument_length(&self.model, Argument::Parameters)];
        let matrix = |q: Vec<f64>| {
            let state = State::new().with(Argument::Q, &q).with(Argument::Parameters, &arguments);
            let mut columns = vec![f64::NAN; n * (count + 3)];
            // What cannot be computed is no number, and told elsewhere.
            let _ = self.model.evaluate(jacobian, &state, &mut columns);
            let row = |row: usize| columns.iter().skip(row).step_by(count + 3).copied().collect();
            // The foot, φ, then the outputs.
            [0, 1, count + 2].into_iter().chain(2..count + 2).map(row).collect::<Vec<Vec<f64>>>()
        };
        let row = dependent_in_all(configurations(n).map(matrix))?;
        self.gait.phase.outputs.get(row.checked_sub(3)?)
    }
}
