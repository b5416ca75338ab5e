//! A regressor: rows that are linear in the inertial parameters, evaluated in any arithmetic.
use super::arithmetic::Arithmetic;
use super::columns::{Column, ParameterList};
use super::evaluate::{Assignment, Evaluator};
use super::states::StateSpace;
use crate::expression::{Expr, Graph, separate};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use std::collections::BTreeMap;

/// How often a state is drawn anew when an equation has no solution in the field.
const DRAWS: usize = 400;

/// Coefficients of the inertial parameters in some rows.
pub struct Regressor<'g> {
    graph: &'g Graph,
    /// Its columns.
    pub columns: Vec<Column>,
    /// The columns in the order in which they are preferred as representatives of their group.
    pub preference: Vec<usize>,
    /// By row: index of the standard parameter and of its coefficient among the outputs.
    rows: Vec<BTreeMap<u32, usize>>,
    outputs: Vec<Expr>,
}

impl<'g> Regressor<'g> {
    /// Separates `rows` (5.1); what does not depend on parameters is left out.
    ///
    /// # Errors
    /// A row that is not linear in the parameters.
    pub fn new(
        graph: &'g Graph,
        rows: &[Expr],
        space: &StateSpace<'_>,
        list: ParameterList,
    ) -> Result<Self, Diagnostic> {
        let forms = separate(graph, rows).map_err(|row| {
            Diagnostic::error(format!("row {row} of the model is not linear in the inertial parameters"))
        })?;
        let mut outputs = Vec::new();
        let mut indexed = Vec::new();
        for form in &forms {
            let first = outputs.len();
            outputs.extend(form.coefficients.values());
            indexed.push(form.coefficients.keys().enumerate().map(|(i, &k)| (k, first + i)).collect());
        }
        let (columns, preference) = (list.columns(space.tree), list.preference(space.tree));
        Ok(Self { graph, columns, preference, rows: indexed, outputs })
    }

    /// Prepares evaluation in one arithmetic.
    ///
    /// # Errors
    /// Expressions that have no exact value.
    pub fn evaluator<A: Arithmetic>(&self, arithmetic: A) -> Result<Evaluator<A>, Diagnostic> {
        Evaluator::new(arithmetic, self.graph, &self.outputs)
            .map_err(|why| Diagnostic::error(format!("the model has no exact values: {why}")))
    }

    /// The rows in one state.
    pub fn rows<A: Arithmetic>(
        &self,
        evaluator: &Evaluator<A>,
        state: &Assignment<A::Value>,
    ) -> Option<Vec<Vec<A::Value>>> {
        let values = evaluator.run(state)?;
        let row = |indices: &BTreeMap<u32, usize>| {
            let standard = indices.iter().map(|(&k, &i)| (k, values[i])).collect();
            self.columns.iter().map(|column| column.entry(&evaluator.arithmetic, &standard)).collect()
        };
        Some(self.rows.iter().map(row).collect())
    }

    /// The rows in a random state.
    ///
    /// # Errors
    /// No state that satisfies the conditions was found.
    pub fn random_rows<A: Arithmetic>(
        &self,
        evaluator: &Evaluator<A>,
        space: &StateSpace<'_>,
        random: &mut Random,
    ) -> Result<Vec<Vec<A::Value>>, Diagnostic> {
        for _ in 0..DRAWS {
            let state = space.sample(&evaluator.arithmetic, evaluator.inputs(), random);
            if let Some(rows) = state.and_then(|state| self.rows(evaluator, &state)) {
                return Ok(rows);
            }
        }
        let what = if space.flat.is_empty() {
            "the model has no value at random states".to_owned()
        } else {
            format!("no posture found in which `{}` is parallel to the ground", space.flat.join("`, `"))
        };
        Err(Diagnostic::error(what).help(
            "a foot is levelled by the last two turning joints before it, whose axes must not be parallel",
        ))
    }
}
