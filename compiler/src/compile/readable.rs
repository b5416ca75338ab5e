//! Functions as formulas that people read.
use super::{Context, FunctionRequest, Solvable, entry};
use crate::derive::effects::JointLaws;
use crate::description::model::RobotDescription;
use crate::expression::{Expr, Graph, Input, write_infix};
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::Argument;

/// A function as formulas.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Readable {
    /// Shared subexpressions, each before its first use: (name, formula).
    pub shared: Vec<(String, String)>,
    /// Elements that are not identically zero: (row, column, formula).
    pub elements: Vec<(usize, usize, String)>,
}

/// The formulas of one function, with joint names instead of indices: `sin(left_hip)`, `left_hip'` (velocity),
/// `left_hip''` (acceleration).
///
/// # Errors
/// Unknown functions and subjects.
pub fn readable(
    description: &RobotDescription,
    tree: &Tree,
    request: &FunctionRequest,
) -> Result<Readable, Diagnostic> {
    let graph = Graph::new();
    let laws = JointLaws::new(tree, description)?;
    let solvable = Solvable::new(description, tree, &laws);
    let refusal = laws
        .refusal(&request.family)
        .or_else(|| solvable.refusal(&request.family, request.subject.as_deref()));
    if let Some(refusal) = refusal {
        return Err(refusal);
    }
    let context = Context::new(&graph, description, tree, None, &laws);
    let quantity = entry(&request.family)?.derive(&context, request.subject.as_deref())?;
    super::without_poles(&graph, &request.family)?;
    let mut places = Vec::new();
    let mut outputs: Vec<Expr> = Vec::new();
    for (column, values) in quantity.columns.iter().enumerate() {
        for (row, value) in values.iter().enumerate().filter(|(_, value)| !value.is_zero()) {
            places.push((row, column));
            outputs.push(value.expr);
        }
    }
    let written = write_infix(&graph, &outputs, &|input| input_name(tree, input));
    let mut elements: Vec<_> =
        places.into_iter().zip(written.outputs).map(|((row, column), text)| (row, column, text)).collect();
    elements.sort_by_key(|&(row, column, _)| (row, column));
    Ok(Readable { shared: written.shared, elements })
}

/// A run-time value by the names of the robot.
fn input_name(tree: &Tree, input: Input) -> String {
    let index = input.index as usize;
    let row = |k: usize| tree.row_names().get(k).cloned().unwrap_or_else(|| format!("v{k}"));
    let joint = |k: usize| tree.joints.get(k).map_or_else(|| format!("{k}"), |joint| joint.name.clone());
    match input.argument {
        Argument::Q => coordinate(tree, index),
        Argument::V => format!("{}'", row(index)),
        // A twist has no coordinate of which it is the derivative: `base/linear/x'` is its rate of change.
        Argument::A => format!("{}''", row(index)),
        Argument::Tau => format!("tau[{}]", row(index)),
        Argument::Forces => {
            let point = tree.points.get(index / 3).map_or("?", |point| point.name.as_str());
            format!("force[{point}/{}]", ["x", "y", "z"][index % 3])
        }
        Argument::Parameters => format!("parameter[{index}]"),
        Argument::MotorQ => format!("motor[{}]", joint(index)),
        Argument::MotorV => format!("motor[{}]'", joint(index)),
        Argument::MotorA => format!("motor[{}]''", joint(index)),
    }
}

fn coordinate(tree: &Tree, index: usize) -> String {
    const FLOATING: [&str; 7] = [
        "base/x",
        "base/y",
        "base/z",
        "base/quaternion/x",
        "base/quaternion/y",
        "base/quaternion/z",
        "base/quaternion/w",
    ];
    let names = tree.row_names();
    let name = match (tree.base, index) {
        (BaseKind::Floating, 0..7) => return FLOATING[index].to_owned(),
        (BaseKind::Floating, _) => names.get(index - 1),
        _ => names.get(index),
    };
    name.cloned().unwrap_or_else(|| format!("q{index}"))
}
