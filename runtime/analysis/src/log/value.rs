//! One field of a table as a number.
use super::header::Column;
use super::names::{may_be_absent, shorten};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::magnitude;

/// A time, whatever its unit, before the unit is known.
const LARGEST_TIME: f64 = 1e30;
/// What exporters write where there is no number, in letters of any size.
const NOTHING: [&str; 6] = ["nan", "n/a", "na", "null", "none", "-"];

/// Whether a field holds no number and does not pretend to.
pub(super) fn is_absent(text: &str) -> bool {
    let unsigned = text.strip_prefix(['+', '-']).filter(|rest| !rest.is_empty()).unwrap_or(text);
    // Nearly all fields are numbers.
    let number = unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    !number && (text.is_empty() || NOTHING.iter().any(|nothing| unsigned.eq_ignore_ascii_case(nothing)))
}

/// Parses one field and applies the mapping.
pub(super) fn parse(text: &str, column: &Column) -> Result<f64, Diagnostic> {
    let name = || shorten(&column.name);
    let raw = match text.parse::<f64>() {
        Ok(raw) => raw,
        Err(_) if may_be_absent(&column.name) && is_absent(text) => return Ok(f64::NAN),
        Err(_) if text.is_empty() => {
            let help = "every row needs a number here: repair the recording, or remove the row";
            return Err(
                Diagnostic::error(format!("`{}`: the field is empty, expected a number", name())).help(help)
            );
        }
        Err(_) => {
            let error = format!("`{}`: expected a number, found `{}`", name(), shorten(text));
            return Err(
                Diagnostic::error(error).help("numbers are written like 12, -0.5 or 1.2e-3, without a unit")
            );
        }
    };
    let value = column.factor * raw + column.offset;
    // Times in nanoseconds are told as such once their steps are known.
    let largest = if column.name == "time" { LARGEST_TIME } else { magnitude::LARGEST };
    if value.abs() <= largest || raw.is_nan() && may_be_absent(&column.name) {
        return Ok(value);
    }
    let what = if raw.is_nan() { "NaN (not a number)" } else { "infinite or too large" };
    let more = if value.is_finite() { format!(" (at most {largest:e})") } else { String::new() };
    Err(Diagnostic::error(format!("`{}`: the value is {what}{more}: `{}`", name(), shorten(text)))
        .help("remove the row or repair the recording"))
}
