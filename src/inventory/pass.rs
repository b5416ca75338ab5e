//! One pass over all rows.
use super::plan::Plan;
use super::statistics::{Clock, Values};
use super::{joint_state, proposal};
use bipedc_analysis::log::{Field, Kind, RawRow, RawRows};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::Path;

/// Where the time of a row stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stamp {
    /// Nowhere.
    None,
    /// In a field, in units of so many seconds, and a shift in seconds.
    One { field: usize, factor: f64, offset: f64 },
    /// Seconds and nanoseconds; counted from this second on, so that no digit is lost.
    Two { from: f64 },
}

pub(super) fn stamp_of(plans: &[Plan], kind: Kind, has_header: bool) -> Stamp {
    if kind != Kind::Time {
        return Stamp::None;
    }
    if !has_header {
        return Stamp::Two { from: 0.0 };
    }
    let known =
        plans.iter().find_map(|plan| plan.taken.as_ref().filter(|t| t.name == "time").map(|t| (plan, t)));
    match (known, proposal::clock(plans)) {
        (Some((plan, taken)), _) => {
            Stamp::One { field: plan.field, factor: taken.factor, offset: taken.offset }
        }
        (None, Some(field)) => Stamp::One { field, factor: 1.0, offset: 0.0 },
        (None, None) => Stamp::None,
    }
}

impl Stamp {
    /// The time of a row in the file's own unit; of joint states in seconds.
    fn of(&self, row: &RawRow<'_>) -> Option<f64> {
        match *self {
            Self::None => None,
            Self::One { field, .. } => match row.field(field) {
                Field::Number(time) => Some(time),
                _ => None,
            },
            Self::Two { from } => match (row.field(0), row.field(1)) {
                (Field::Number(seconds), Field::Number(nanoseconds)) => {
                    Some(seconds - from + 1e-9 * nanoseconds)
                }
                _ => None,
            },
        }
    }

    /// The same in seconds.
    pub fn seconds(&self, row: &RawRow<'_>) -> Option<f64> {
        let time = self.of(row)?;
        Some(if let Self::One { factor, offset, .. } = *self { factor * time + offset } else { time })
    }
}

/// What a pass over the rows has seen.
pub(super) struct Seen {
    pub rows: usize,
    pub clock: Clock,
    pub values: Vec<Values>,
    /// Rows with another number of fields, and the first such line.
    pub ragged: (usize, usize),
    /// Rows of joint states with other joints than the first, and the first such line.
    pub other_joints: (usize, usize),
    /// The line of the last row.
    pub last_line: usize,
    /// Where the clock began, of stamps in two columns.
    pub began: f64,
}

/// Reads all rows; `joints` are the columns of joint states without a header.
pub(super) fn read(
    path: &Path,
    width: usize,
    mut stamp: Stamp,
    joints: Option<&Vec<String>>,
) -> Result<Seen, Diagnostics> {
    let mut rows = RawRows::open(path)?;
    let mut seen = Seen::of(width);
    while let Some(row) = rows.next_row()? {
        if let (Stamp::Two { from }, 0, Field::Number(second)) = (&mut stamp, seen.rows, row.field(0)) {
            (*from, seen.began) = (second, second);
        }
        seen.rows += 1;
        seen.last_line = row.line;
        if row.width() != width {
            note(&mut seen.ragged, row.line);
        } else if joints.is_some_and(|names| !joint_state::same_joints(names, &row)) {
            note(&mut seen.other_joints, row.line);
        } else {
            seen.take(&row, stamp);
        }
    }
    let nothing = |message: &str, line: usize, help: &str| {
        Err(Diagnostic::error(message).in_file(path).at(line, 0).help(help).into())
    };
    match seen.rows {
        0 => nothing(
            "the file has a header but no rows",
            1,
            "was the recording stopped before its first sample, or the file cut off?",
        ),
        1 if stamp != Stamp::None => nothing(
            "the log has only one row",
            seen.last_line,
            "velocities and accelerations need at least a second of samples",
        ),
        _ => Ok(seen),
    }
}

/// One more, and the line of the first.
fn note(counter: &mut (usize, usize), line: usize) {
    *counter = (counter.0 + 1, if counter.0 == 0 { line } else { counter.1 });
}

impl Seen {
    fn of(width: usize) -> Self {
        Self {
            rows: 0,
            clock: Clock::new(),
            values: vec![Values::new(); width],
            ragged: (0, 0),
            other_joints: (0, 0),
            last_line: 0,
            began: 0.0,
        }
    }

    fn take(&mut self, row: &RawRow<'_>, stamp: Stamp) {
        self.clock.take(stamp.of(row), row.line);
        let time = if let Stamp::One { field, .. } = stamp { Some(field) } else { None };
        for (field, values) in self.values.iter_mut().enumerate() {
            // Times in nanoseconds are larger than anything else may be.
            values.take(row.field(field), row.text(field), row.line, Some(field) != time);
        }
    }
}
