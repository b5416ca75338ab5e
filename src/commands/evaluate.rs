//! `bipedc evaluate`: any function at states from a file.
use crate::terminal::arguments::{RobotArguments, SubjectArguments};
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use crate::terminal::progress::spin;
use bipedc::table::table;
use bipedc_compiler::compile::Function;
use bipedc_compiler::program::Evaluator;
use bipedc_compiler::states::{Coordinates, read_states};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::input;
use bipedc_runtime::Argument;
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc evaluate robots/tulip inverse_dynamics --states states.json
  bipedc evaluate robots/tulip position --point right_foot/heel_left --states states.json --json
  bipedc evaluate robots/rabbit bias --base floating --states states.json

A state (the file holds one, or an array of them; whatever is missing is zero):
  {\"base\": {\"position\": [x, y, z], \"orientation\": [x, y, z, w],
            \"linear_velocity\": […], \"angular_velocity\": […],
            \"linear_acceleration\": […], \"angular_acceleration\": […],
            \"force\": […], \"torque\": […]},
   \"position\": {\"joint\": rad}, \"velocity\": {…}, \"acceleration\": {…}, \"effort\": {…},
   \"forces\": {\"foot/point\": [x, y, z]}}
Base rates, force and torque are in the base's axes; its accelerations are the time derivatives of those twist \
components. `forces` are at the contact points, world axes, N. A key `expected` is ignored.
--json: {\"function\", \"rows\", \"columns\", \"row_units\", \"values\": one array, or array of rows, per state}.
`bipedc inspect ROBOT` lists the functions.
JSON: {\"function\", \"rows\", \"columns\", \"row_units\", \"values\": [one for each state, row by row]}.";

/// Evaluate a derived function at states from a JSON file
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Evaluate {
    #[command(flatten)]
    robot: RobotArguments,
    /// Name of the function, such as `inverse_dynamics`
    #[arg(value_name = "FUNCTION")]
    function: String,
    /// JSON file with one state or an array of states
    #[arg(long, value_name = "FILE.json")]
    states: PathBuf,
    #[command(flatten)]
    subject: SubjectArguments,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Evaluated<'a> {
    function: &'a str,
    rows: &'a [String],
    columns: &'a [String],
    row_units: &'a [String],
    values: Vec<Value>,
}

impl Evaluate {
    /// Compiles the one function and runs it at all states.
    pub fn run(self) -> Outcome {
        let robot = self.robot.read()?;
        let request = self.subject.request(&self.function, &robot)?;
        let text = input::read_to_string(&self.states).map_err(|error| {
            Diagnostic::error(format!("cannot read the states: {error}")).in_file(&self.states)
        })?;
        let states = read_states(&text, &self.states, &robot.tree()?)?;
        let compiled = spin("deriving", || {
            let compiled = robot.compile_only(std::slice::from_ref(&request))?;
            bipedc_compiler::self_check(&robot.description, &compiled)?;
            Ok::<_, Diagnostic>(compiled)
        })?;
        let function = &compiled.functions[0];
        if function.program.arguments().any(|argument| argument == Argument::Parameters) {
            return Err(Diagnostic::error(format!(
                "`{}` takes parameters, which a state does not have",
                request.family
            ))
            .into());
        }
        let values = evaluate(function, &states);
        if values.iter().flatten().any(|x| !x.is_finite()) {
            output::diagnostics(&[Diagnostic::warning(format!(
                "`{}` is not finite at some state",
                request.family
            ))
            .help("null in JSON; a singular mass matrix, or no force on the ground")]);
        }
        self.print(function, &values)?;
        Ok(ExitCode::SUCCESS)
    }

    fn print(&self, function: &Function, values: &[Vec<f64>]) -> std::io::Result<()> {
        if !self.json {
            return output::print(&tables(function, values));
        }
        output::print_json(&Evaluated {
            function: &self.function,
            rows: &function.rows,
            columns: &function.columns,
            row_units: &function.row_units,
            values: values.iter().map(|column_major| nested(function, column_major)).collect(),
        })
    }
}

/// Column-major results of all states, with one workspace.
fn evaluate(function: &Function, states: &[Coordinates]) -> Vec<Vec<f64>> {
    let evaluator = Evaluator::new(&function.program);
    let mut workspace = evaluator.workspace();
    let run = |state: &Coordinates| {
        let mut output = vec![0.0; evaluator.outputs()];
        evaluator.run(&state.state(), &mut workspace, &mut output);
        output
    };
    states.iter().map(run).collect()
}

/// Vectors have the one column `value`.
fn is_vector(function: &Function) -> bool {
    matches!(function.columns.as_slice(), [only] if only == "value")
}

/// One array for a vector, an array of rows for a matrix.
fn nested(function: &Function, column_major: &[f64]) -> Value {
    if is_vector(function) {
        return json!(column_major);
    }
    let rows = function.rows.len();
    let row = |r: usize| column_major.iter().skip(r).step_by(rows).copied().collect::<Vec<f64>>();
    (0..rows).map(row).collect()
}

fn tables(function: &Function, values: &[Vec<f64>]) -> String {
    let mut out = String::new();
    let heads = function.columns.iter().map(String::as_str);
    let head: Vec<&str> = ["row", "unit"].into_iter().chain(heads).collect();
    for (index, column_major) in values.iter().enumerate() {
        if values.len() > 1 {
            let _ = writeln!(out, "state {}", index + 1);
        }
        let rows = function.rows.len();
        let row = |r: usize| {
            let numbers = column_major.iter().skip(r).step_by(rows).map(|x| format!("{x:.9}"));
            [function.rows[r].clone(), function.row_units[r].clone()].into_iter().chain(numbers).collect()
        };
        out += &table(&head, (0..rows).map(row).collect(), 2);
    }
    out
}
