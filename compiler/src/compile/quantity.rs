//! A derived vector or matrix with names and units.
use crate::expression::{Sym, Vector3};

/// Expressions with their shape, names and units.
#[derive(Debug, Clone)]
pub struct Quantity<'g> {
    /// Column by column.
    pub columns: Vec<Vec<Sym<'g>>>,
    /// One per row.
    pub row_names: Vec<String>,
    /// One per column.
    pub column_names: Vec<String>,
    /// One per row.
    pub row_units: Vec<String>,
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|s| (*s).to_owned()).collect()
}

impl<'g> Quantity<'g> {
    /// One number.
    pub fn scalar(name: &str, unit: &str, x: Sym<'g>) -> Self {
        Self::vector(&[name], unit, vec![x])
    }

    /// A vector with one unit.
    pub fn vector(names: &[&str], unit: &str, values: Vec<Sym<'g>>) -> Self {
        Self::named(owned(names), vec![unit.to_owned(); names.len()], values)
    }

    /// A vector with x, y, z.
    pub fn xyz(unit: &str, v: Vector3<'g>) -> Self {
        Self::vector(&["x", "y", "z"], unit, v.0.to_vec())
    }

    /// A vector with all names and units.
    pub fn named(row_names: Vec<String>, row_units: Vec<String>, values: Vec<Sym<'g>>) -> Self {
        Self { columns: vec![values], row_names, column_names: vec!["value".to_owned()], row_units }
    }

    /// Linear and angular part.
    pub fn pair(units: [&str; 2], linear: Vector3<'g>, angular: Vector3<'g>) -> Self {
        let names = ["linear/x", "linear/y", "linear/z", "angular/x", "angular/y", "angular/z"];
        let units = [[units[0]; 3], [units[1]; 3]].concat();
        let values = linear.0.into_iter().chain(angular.0).collect();
        Self::named(owned(&names), owned(&units), values)
    }

    /// A matrix, given by columns.
    pub fn matrix(
        row_names: Vec<String>,
        row_units: Vec<String>,
        column_names: Vec<String>,
        columns: Vec<Vec<Sym<'g>>>,
    ) -> Self {
        Self { columns, row_names, column_names, row_units }
    }
}
