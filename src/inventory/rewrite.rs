//! A log written again under our names, in SI units.
use super::pass::Stamp;
use super::{Inventory, Source, joint_state};
use bipedc_analysis::log::{Field, RawRow, RawRows};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::Output;
use std::fmt::Write;
use std::path::Path;

/// What was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rewritten {
    /// Columns, with the leading one.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Rows that no command could use: cut off, without a time, or with one that is not later than that of the row before.
    pub left_out: usize,
}

/// Writes the columns that a file has or, as is proposed, could have, under our names. Numbers that need no factor stay digit
/// by digit; what is no number becomes an empty field.
///
/// # Errors
/// No column with a meaning; a file that cannot be read any more; what the file system refuses.
pub fn rewrite(found: &Inventory, out: &Path) -> Result<Rewritten, Diagnostics> {
    let path = Path::new(&found.file);
    let leads = found.stamp != Stamp::None || found.kind != "time";
    if !leads || found.sources.is_empty() {
        let error = Diagnostic::error("no column of the log has a meaning that could be written");
        let help = "name the robot (--robot), or say in a mapping file (--mapping) what the columns are";
        return Err(error.in_file(path).at(1, 0).help(help).into());
    }
    let joint_names: Option<Vec<String>> =
        (!found.has_header).then(|| found.columns.iter().map(|column| column.name.clone()).collect());
    let mut rows = RawRows::open(path)?;
    let mut output = Output::create(out)?;
    output.put(&header(found))?;
    let mut written =
        Rewritten { columns: found.sources.len() + usize::from(has_clock(found)), rows: 0, left_out: 0 };
    let mut last = f64::NEG_INFINITY;
    let mut line = String::new();
    while let Some(row) = rows.next_row()? {
        let fits = row.width() == found.columns.len()
            && joint_names.as_ref().is_none_or(|names| joint_state::same_joints(names, &row));
        let time = if has_clock(found) { found.stamp.seconds(&row) } else { Some(last + 1.0) };
        match time.filter(|time| fits && (*time > last || !has_clock(found))) {
            Some(time) => {
                if has_clock(found) {
                    last = time;
                }
                line.clear();
                write_row(found, &row, time, &mut line);
                output.put(&line)?;
                written.rows += 1;
            }
            None => written.left_out += 1,
        }
    }
    output.commit()?;
    Ok(written)
}

/// Whether rows are over time; numbers of postures and impacts are columns like others.
fn has_clock(found: &Inventory) -> bool {
    found.stamp != Stamp::None
}

fn header(found: &Inventory) -> String {
    let clock = has_clock(found).then_some("time");
    let names: Vec<&str> =
        clock.into_iter().chain(found.sources.iter().map(|source| source.name.as_str())).collect();
    let quoted = |name: &&str| if name.contains(',') { format!("\"{name}\"") } else { (*name).to_owned() };
    names.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

fn write_row(found: &Inventory, row: &RawRow<'_>, time: f64, line: &mut String) {
    // Writing to a string cannot fail.
    let _ = match found.stamp {
        Stamp::None => Ok(()),
        Stamp::One { field, factor: 1.0, offset: 0.0 } => write!(line, "{}", row.text(field)),
        _ => write!(line, "{time}"),
    };
    for (k, source) in found.sources.iter().enumerate() {
        if k > 0 || has_clock(found) {
            line.push(',');
        }
        let Source { field, factor, offset, .. } = *source;
        if let Field::Number(x) = row.field(field) {
            let _ = if factor == 1.0 && offset == 0.0 {
                write!(line, "{}", row.text(field))
            } else {
                write!(line, "{}", factor * x + offset)
            };
        }
    }
    line.push('\n');
}
