//! Lengths by their meaning: `NV` instead of 18.
use crate::compile::{CompiledModel, Function};
use bipedc_runtime::Argument;
use std::fmt;

/// A length in emitted code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Size {
    /// As many as `q` has elements.
    Nq,
    /// So many times as many as `v` has elements.
    Nv(usize),
    /// A number of its own.
    Number(usize),
}

impl Size {
    /// Of an argument.
    pub fn of(model: &CompiledModel, argument: Argument) -> Self {
        match argument {
            Argument::Q => Self::Nq,
            Argument::V | Argument::A | Argument::Tau => Self::Nv(1),
            _ => Self::Number(model.argument_length(argument)),
        }
    }

    /// Of rows or columns with these names: equal numbers may mean different things.
    pub fn named(model: &CompiledModel, names: &[String]) -> Self {
        let v = model.tree.row_names();
        // Blocks by q, v and a or τ have names such as `q/left_knee`.
        let of_v = |block: &[String]| {
            let before = block[0].strip_suffix(v[0].as_str());
            before.is_some_and(|before| {
                ["", "q/", "v/", "a/", "tau/"].contains(&before)
                    && v.iter().zip(block).all(|(row, name)| name.strip_prefix(before) == Some(row))
            })
        };
        if v.is_empty() || names.is_empty() {
            Self::Number(names.len())
        } else if names.len().is_multiple_of(v.len()) && names.chunks(v.len()).all(of_v) {
            Self::Nv(names.len() / v.len())
        } else if *names == model.tree.coordinate_names() {
            Self::Nq
        } else {
            Self::Number(names.len())
        }
    }

    /// Rows and columns of a function.
    pub fn of_result(model: &CompiledModel, function: &Function) -> (Self, Self) {
        // On a planar base q and v have the same names.
        let rows = match function.family {
            "relabelled_configuration" => Self::Nq,
            _ => Self::named(model, &function.rows),
        };
        (rows, Self::named(model, &function.columns))
    }

    /// As an argument of a generic type.
    pub fn generic(self) -> String {
        match self {
            Self::Nv(n) if n > 1 => format!("{{ {self} }}"),
            _ => self.to_string(),
        }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nq => f.write_str("NQ"),
            Self::Nv(1) => f.write_str("NV"),
            Self::Nv(n) => write!(f, "{n} * NV"),
            Self::Number(n) => n.fmt(f),
        }
    }
}
