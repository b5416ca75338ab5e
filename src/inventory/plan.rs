//! What the columns of a file are before any row is read.
use super::joint_state;
use bipedc_analysis::log::{Kind, Mapping, RawRows, names};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::Path;

/// A column before its values were seen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    pub field: usize,
    pub name: String,
    pub taken: Option<Taken>,
}

/// A column of ours, and how its values come from the file's.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Taken {
    pub name: String,
    pub factor: f64,
    pub offset: f64,
    /// Whether a mapping file says so.
    pub mapped: bool,
}

/// Names of the columns, and whether they stand in the file.
pub(super) fn column_names(path: &Path) -> Result<(Vec<String>, bool), Diagnostics> {
    let mut rows = RawRows::open(path)?;
    if let Some(names) = rows.names() {
        return Ok((names.to_vec(), true));
    }
    let first = rows.next_row()?;
    let recognised = first.and_then(|row| joint_state::columns(&row));
    recognised.map(|names| (names, false)).ok_or_else(|| {
        Diagnostic::error("no header row: the first line begins with a number")
            .in_file(path)
            .at(1, 1)
            .help(
                "put the names of the columns into the first line, such as `time,left_knee/position`; of files without \
                 names only joint states as `ros2 topic echo --csv` prints them are known",
            )
            .into()
    })
}

/// What each column is by its own name or by the mapping.
pub(super) fn plans(path: &Path, names: &[String], mapping: &Mapping) -> Result<Vec<Plan>, Diagnostics> {
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    let mapping = mapping.of_columns(&all).map_err(Diagnostics)?;
    let mut errors = Vec::new();
    let mut plans: Vec<Plan> = Vec::new();
    for (field, name) in names.iter().enumerate() {
        let hidden = mapping.hides(name);
        let own = !hidden && names::is_known_form(name) && !is_misplaced(name, field);
        let taken = own.then(|| Taken { name: name.clone(), factor: 1.0, offset: 0.0, mapped: false });
        plans.push(Plan { field, name: name.clone(), taken });
    }
    for (name, source) in &mapping.columns {
        let wanted = source.column.as_ref().unwrap_or(name);
        match plans.iter_mut().find(|plan| plan.name == *wanted) {
            Some(plan) => {
                let (factor, offset) = (source.factor, source.offset);
                plan.taken = Some(Taken { name: name.clone(), factor, offset, mapped: true });
            }
            None => {
                let (line, column) = source.position;
                let file = mapping.file.as_deref().unwrap_or(path);
                let help =
                    format!("columns of the log: {}", names::list(names.iter().map(String::as_str), 12));
                let message = format!("the log has no column `{}`", names::shorten(wanted));
                errors.push(Diagnostic::error(message).in_file(file).at(line, column).help(help));
            }
        }
    }
    if errors.is_empty() { Ok(plans) } else { Err(Diagnostics(errors)) }
}

/// The leading column counts only in front.
fn is_misplaced(name: &str, field: usize) -> bool {
    field > 0 && Kind::ALL.iter().any(|kind| kind.column() == name)
}

pub(super) fn kind_of(plans: &[Plan]) -> Kind {
    let leads = |kind: &Kind| {
        plans.iter().any(|plan| plan.taken.as_ref().is_some_and(|taken| taken.name == kind.column()))
    };
    Kind::ALL.into_iter().find(leads).unwrap_or(Kind::Time)
}
