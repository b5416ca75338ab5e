//! `bipedc inspect`: functions, their work and their formulas.
use super::base_parameters::BaseParametersArguments;
use crate::terminal::arguments::{RobotArguments, SubjectArguments};
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use crate::terminal::progress::spin;
use bipedc::table::table;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{Entry, Function, FunctionRequest, Readable, readable};
use bipedc_compiler::program::Operations;
use bipedc_effects::diagnostic::Diagnostic;
use clap::Args;
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc inspect robots/tulip                        all functions, counted
  bipedc inspect robots/three_link potential_energy  formulas if it is small
  bipedc inspect robots/five_link position --point right_foot/point_foot
  bipedc inspect robots/tulip base-parameters --of com --root right_foot --rows x,y

Operations: additions, multiplications, divisions and square roots count 1, fused multiply-adds 2; sines and \
cosines are listed apart. In formulas `knee` is a joint's position (rad), `knee'` its velocity, `knee''` its \
acceleration.
JSON: {\"robot\", \"functions\": [{\"name\", \"function\", \"subject\", \"arguments\", \"shape\", \"rows\", \"columns\", \"row_units\", \"operations\"}]}; of one function \
its entry with \"shared\": [{\"name\", \"formula\"}] and \"formulas\": [{\"row\", \"column\", \"formula\"}]; of base parameters {\"rank\", \"columns\", \
\"parameters\": [{\"leading\", \"combination\", \"text\", \"unit\", \"value\"}], \"unidentifiable\", \"assumed_right_angles\", \"primes\"}.";

/// Formulas are shown up to so many operations; longer ones nobody reads.
const READABLE: usize = 60;

/// Show functions, their operation counts, formulas and base parameters
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Inspect {
    #[command(flatten)]
    robot: RobotArguments,
    /// A function, or `base-parameters`; without it, a table of all functions
    #[arg(value_name = "FUNCTION")]
    function: Option<String>,
    #[command(flatten)]
    subject: SubjectArguments,
    #[command(flatten)]
    base_parameters: BaseParametersArguments,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

impl Inspect {
    /// Compiles and shows.
    pub fn run(self) -> Outcome {
        match self.function.as_deref() {
            Some("base-parameters") => self.base_parameters.run(&self.robot, self.json),
            Some(name) => {
                self.base_parameters.refuse()?;
                let robot = self.robot.read()?;
                one(&robot, &self.subject.request(name, &robot)?, self.json)
            }
            None => {
                self.base_parameters.refuse()?;
                all(&self.robot.read()?, self.json)
            }
        }
    }
}

#[derive(Serialize)]
struct Summary<'a> {
    name: &'a str,
    function: &'a str,
    subject: Option<&'a str>,
    shape: [usize; 2],
    rows: &'a [String],
    columns: &'a [String],
    row_units: &'a [String],
    arguments: Vec<&'static str>,
    operations: Counts,
}

#[derive(Serialize)]
struct Counts {
    additions: usize,
    multiplications: usize,
    fused: usize,
    divisions: usize,
    square_roots: usize,
    sin_cos: usize,
    functions: usize,
    total: usize,
}

impl From<Operations> for Counts {
    fn from(o: Operations) -> Self {
        let total = o.total();
        let Operations { additions, multiplications, fused, divisions, square_roots, sin_cos, functions } = o;
        Self { additions, multiplications, fused, divisions, square_roots, sin_cos, functions, total }
    }
}

fn summary(f: &Function) -> Summary<'_> {
    Summary {
        name: &f.name,
        function: f.family,
        subject: f.subject.as_deref(),
        shape: [f.rows.len(), f.columns.len()],
        rows: &f.rows,
        columns: &f.columns,
        row_units: &f.row_units,
        arguments: f.program.arguments().map(|argument| argument.name()).collect(),
        operations: f.operations.into(),
    }
}

fn all(robot: &Robot, as_json: bool) -> Outcome {
    output::diagnostics(&robot.without_inertia()?);
    let compiled = spin("deriving", || robot.compile())?;
    if as_json {
        let functions: Vec<_> = compiled.functions.iter().map(summary).collect();
        output::print_json(&json!({"robot": compiled.name, "functions": functions}))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut head =
        vec!["function", "arguments", "unit", "shape", "add", "mul", "fused", "div", "sqrt", "sin_cos"];
    // Only the laws of effects need them.
    let others = compiled.functions.iter().any(|f| f.operations.functions > 0);
    head.extend(others.then_some("functions"));
    head.push("total");
    let row = |f: &Function| {
        let o = f.operations;
        let mut counts =
            vec![o.additions, o.multiplications, o.fused, o.divisions, o.square_roots, o.sin_cos];
        counts.extend(others.then_some(o.functions));
        counts.push(o.total());
        let shape = format!("{} × {}", f.rows.len(), f.columns.len());
        let names: Vec<&str> = f.program.arguments().map(|argument| argument.name()).collect();
        let texts = [f.name.clone(), names.join(", "), units(f), shape];
        texts.into_iter().chain(counts.iter().map(ToString::to_string)).collect()
    };
    let table = table(&head, compiled.functions.iter().map(row).collect(), 3);
    output::print(&format!(
        "robot `{}`: nq {}, nv {}\n\n{table}{}",
        compiled.name,
        compiled.tree.nq,
        compiled.tree.nv,
        on_demand(robot, &compiled.functions)?
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// What is derived for whoever names it, beside these functions.
fn on_demand(robot: &Robot, there: &[Function]) -> Result<String, Diagnostic> {
    let entries = robot.on_demand()?;
    let missing = |entry: &&&Entry| there.iter().all(|f| f.family != entry.name);
    let words = |entry: &&Entry| vec![entry.name.to_owned(), entry.summary.to_owned()];
    let rows: Vec<Vec<String>> = entries.iter().filter(missing).map(words).collect();
    if rows.is_empty() {
        return Ok(String::new());
    }
    Ok(format!("\n{}", table(&["on demand: named here, or in `functions` of [generate]", ""], rows, 2)))
}

/// Each unit of the rows once.
fn units(f: &Function) -> String {
    let mut units: Vec<&str> = Vec::new();
    for unit in f.row_units.iter().flat_map(|units| units.split(", ")) {
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    units.join(", ")
}

fn one(robot: &Robot, request: &FunctionRequest, as_json: bool) -> Outcome {
    let compiled = spin("deriving", || robot.compile_only(std::slice::from_ref(request)))?;
    let function = &compiled.functions[0];
    let work = function.operations.total() + function.operations.sin_cos;
    let formulas =
        if work < READABLE { Some(readable(&robot.description, &compiled.tree, request)?) } else { None };
    if as_json {
        output::print_json(&with_formulas(function, formulas.as_ref())?)?;
    } else {
        output::print(&(description(function) + "\n" + &formula_text(function, formulas.as_ref())))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn with_formulas(f: &Function, formulas: Option<&Readable>) -> std::io::Result<Value> {
    let mut value = serde_json::to_value(summary(f))?;
    if let Some(formulas) = formulas {
        let shared = formulas.shared.iter().map(|(name, formula)| json!({"name": name, "formula": formula}));
        let element = |(row, column, formula): &(usize, usize, String)| json!({"row": f.rows[*row], "column": f.columns[*column], "formula": formula});
        value["shared"] = shared.collect();
        value["formulas"] = formulas.elements.iter().map(element).collect();
    }
    Ok(value)
}

fn formula_text(f: &Function, formulas: Option<&Readable>) -> String {
    let Some(formulas) = formulas else { return format!("formulas are shown below {READABLE} operations\n") };
    let mut text = String::new();
    for (name, formula) in &formulas.shared {
        let _ = writeln!(text, "{name} = {formula}");
    }
    for (row, column, formula) in &formulas.elements {
        let _ = writeln!(text, "{} = {formula}", label(f, *row, *column));
    }
    if formulas.elements.len() < f.rows.len() * f.columns.len() {
        text.push_str("everything else is 0\n");
    }
    text
}

fn label(f: &Function, row: usize, column: usize) -> String {
    if f.columns.len() == 1 {
        f.rows[row].clone()
    } else {
        format!("[{}, {}]", f.rows[row], f.columns[column])
    }
}

fn description(f: &Function) -> String {
    let names: Vec<&str> = f.program.arguments().map(|argument| argument.name()).collect();
    let mut text = format!("{}({})\n{}\n", f.name, names.join(", "), f.summary);
    let _ = writeln!(text, "source:     {}", f.source);
    let _ = writeln!(text, "shape:      {} × {}", f.rows.len(), f.columns.len());
    let rows: Vec<String> =
        f.rows.iter().zip(&f.row_units).map(|(row, unit)| format!("{row} ({unit})")).collect();
    let _ = writeln!(text, "rows:       {}", rows.join(", "));
    let _ = writeln!(text, "columns:    {}", f.columns.join(", "));
    let _ = writeln!(text, "work:       {}", f.operations);
    text
}
