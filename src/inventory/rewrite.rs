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
    /// Rows that no command could use: cut off, of other joints, or without a time.
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
    let mut line = String::new();
    while let Some(row) = rows.next_row()? {
        let fits = row.width() == found.columns.len()
            && joint_names.as_ref().is_none_or(|names| joint_state::same_joints(names, &row));
        // Rows that come late stay where they stand: whoever reads the file sorts them in, and says so.
        let time = if has_clock(found) { found.stamp.seconds(&row) } else { Some(0.0) };
        match time.filter(|_| fits) {
            Some(time) => {
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
        Stamp::One { field, factor, offset } => {
            write!(line, "{}", scaled(row.text(field), factor, offset).unwrap_or_else(|| time.to_string()))
        }
        Stamp::Two { .. } => write!(line, "{time}"),
    };
    for (k, source) in found.sources.iter().enumerate() {
        if k > 0 || has_clock(found) {
            line.push(',');
        }
        let Source { field, factor, offset, .. } = *source;
        if let Field::Number(x) = row.field(field) {
            let value = || (factor * x + offset).to_string();
            line.push_str(&scaled(row.text(field), factor, offset).unwrap_or_else(value));
        }
    }
    line.push('\n');
}

/// A number times a power of ten: the digits that stand there, with the point elsewhere. `None` of other factors, and of numbers
/// with an exponent.
fn scaled(text: &str, factor: f64, offset: f64) -> Option<String> {
    let factors = [1.0, 1e-3, 1e-6, 1e-9];
    let places = factors.iter().position(|power| *power == factor).filter(|_| offset == 0.0)? * 3;
    if places == 0 {
        return Some(text.to_owned());
    }
    let (sign, digits) = match text.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", text.strip_prefix('+').unwrap_or(text)),
    };
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    if !(whole.bytes().chain(part.bytes())).all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let whole = format!("{whole:0>width$}", width = places + 1);
    let (before, behind) = whole.split_at(whole.len() - places);
    let number = format!("{sign}{before}.{behind}{part}");
    Some(number.trim_end_matches('0').trim_end_matches('.').to_owned())
}

#[cfg(test)]
mod tests {
    use super::scaled;

    #[test]
    fn powers_of_ten_move_the_point() {
        let cases = [
            ("1764000000123", 1e-3, "1764000000.123"),
            ("1764000000123456789", 1e-9, "1764000000.123456789"),
            ("-12.5", 1e-3, "-0.0125"),
            ("7", 1e-6, "0.000007"),
            ("5000", 1e-3, "5"),
            ("0.10", 1.0, "0.10"),
        ];
        for (text, factor, expected) in cases {
            assert_eq!(scaled(text, factor, 0.0).as_deref(), Some(expected));
        }
        assert_eq!(
            (scaled("1e3", 1e-3, 0.0), scaled("1", 0.5, 0.0), scaled("1", 1e-3, 0.1)),
            (None, None, None)
        );
    }
}
