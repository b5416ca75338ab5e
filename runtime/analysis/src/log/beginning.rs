//! Jolts with which a log begins: the first samples of a simulation whose feet sink in, or of a drive that is switched on. A filter would
//! spread them over the samples behind them.
use super::names::shorten;
use super::reader::{Reader, Row};
use bipedc_effects::diagnostic::Diagnostic;
use std::collections::VecDeque;

/// What begins with a jolt leaves it within so many samples.
const LONGEST: usize = 3;
/// Of the largest load that comes later.
const TIMES: f64 = 10.0;
/// Rows that must follow to say so.
const ENOUGH: usize = 100;

/// Takes the jolt away with which these rows (the time first) begin, and says so.
pub(super) fn without_jolt(reader: &Reader, rows: &mut VecDeque<(Row, Vec<f64>)>) -> Option<Diagnostic> {
    if rows.len() < LONGEST + ENOUGH {
        return None;
    }
    let columns: Vec<(usize, String)> =
        reader.selected_names().enumerate().filter(|(_, name)| is_load(name)).collect();
    let largest =
        |column: usize| rows.iter().skip(LONGEST).map(|(_, row)| row[column].abs()).fold(0.0, f64::max);
    let jolt = |(column, name): &(usize, String)| {
        let bound = TIMES * largest(*column);
        let last = (0..LONGEST).rev().find(|&i| bound > 0.0 && rows[i].1[*column].abs() > bound)?;
        Some((last, TIMES * rows[last].1[*column].abs() / bound, *column, shorten(name).to_owned()))
    };
    // The one that lasts longest, of several that which is largest beside what follows.
    let jolts = columns.iter().filter_map(jolt);
    let (last, _, column, name) = jolts.max_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
    let message = format!(
        "the log begins with a jolt: `{name}` is {} there, and below {:.4} in all of the next {} rows",
        rows[last].1[column],
        largest(column),
        rows.len() - LONGEST
    );
    let (first, count) = (rows[0].0, last + 1);
    rows.drain(..count);
    let left_out = if count == 1 {
        "its first row is left out".to_owned()
    } else {
        format!("its first {count} rows are left out")
    };
    Some(Diagnostic::warning(message).in_file(reader.file()).at(first.line, 0).help(left_out))
}

/// Whether a column is a force, a torque or a current, which may jump; motion does not.
fn is_load(name: &str) -> bool {
    ["effort", "force", "moment", "torque", "current"].iter().any(|word| name.contains(word))
}
