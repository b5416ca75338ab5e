//! Numbers for people: in plain text, and set for pages with real minus signs.

/// Four decimals as long as they show something and are no crowd.
pub fn four_decimals(x: f64) -> String {
    if x == 0.0 || (0.01..1e7).contains(&x.abs()) { format!("{x:.4}") } else { format!("{x:.2e}") }
}

/// Rows for people: the largest error first. Errors of different units cannot be compared: rows of one unit stay together, in the
/// order in which units first stand.
pub fn worst_first<T>(rows: &mut [T], unit: impl Fn(&T) -> String, error: impl Fn(&T) -> f64) {
    let mut units: Vec<String> = Vec::new();
    for row in rows.iter() {
        let unit = unit(row);
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    let place = |row: &T| units.iter().position(|known| *known == unit(row));
    let size = |row: &T| if error(row).is_nan() { f64::NEG_INFINITY } else { error(row) };
    rows.sort_by(|a, b| place(a).cmp(&place(b)).then(size(b).total_cmp(&size(a))));
}

/// So many digits that count, in plain text, at most nine decimals and no exponent.
pub fn counting(x: f64, digits: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let decimals = (digits - 1 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{x:.decimals$}")
}

/// For pages: about `digits` significant digits, without an exponent where that is readable; `–` if not finite.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..=6).contains(&magnitude) {
        return signed(format!("{value:.*e}", (digits - 1).max(0) as usize));
    }
    signed(format!("{value:.*}", (digits - 1 - magnitude).max(0) as usize))
}

/// Three significant digits and the unit; the unit `1` is not shown.
pub(crate) fn with_unit(value: f64, unit: &str) -> String {
    joined(significant(value, 3), unit)
}

/// A number as text and its unit.
pub(crate) fn joined(number: String, unit: &str) -> String {
    if unit.is_empty() || unit == "1" {
        return number;
    }
    // Never a line end between a number and its unit.
    format!("{number}\u{a0}{}", unit.replace(' ', "\u{a0}"))
}

/// A value and its interval with as many digits as the interval's width deserves.
pub(crate) fn with_interval(value: f64, interval: Option<[f64; 2]>) -> (String, Option<[String; 2]>) {
    let Some([low, high]) = interval else { return (significant(value, 3), None) };
    let width = (high - low).abs() / 2.0;
    if !(width.is_finite() && width > 0.0) {
        return (significant(value, 4), Some([low, high].map(|x| significant(x, 4))));
    }
    // Two digits of the half-width, at most six after the point.
    let decimals = (1 - width.log10().floor() as i32).clamp(0, 6) as usize;
    if width < 1e-6 {
        return (significant(value, 4), Some([low, high].map(|x| significant(x, 4))));
    }
    let text = |x: f64| {
        if x.is_finite() { signed(unsigned_zero(format!("{x:.decimals$}"))) } else { "–".to_owned() }
    };
    (text(value), Some([text(low), text(high)]))
}

/// A fraction as per cent; `–` if not finite.
pub(crate) fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    if !percent.is_finite() {
        "–".to_owned()
    } else if percent > 0.0 && percent < 0.05 {
        "<\u{a0}0.1\u{a0}%".to_owned()
    } else if percent != 0.0 && percent.abs() < 9.95 {
        format!("{}\u{a0}%", signed(format!("{percent:.1}")))
    } else {
        format!("{}\u{a0}%", signed(format!("{percent:.0}")))
    }
}

/// Units behind numbers in sentences; a unit's beginning stands behind it.
const UNITS: [&str; 22] = [
    "N m s²/rad²",
    "N m s/rad",
    "N m/rad",
    "N m",
    "N s/m",
    "N/m",
    "N",
    "kg m²",
    "kg",
    "rad/s²",
    "rad/s",
    "rad",
    "m/s²",
    "m/s",
    "mm",
    "ms",
    "m",
    "s",
    "Hz",
    "degrees",
    "kW",
    "W",
];

/// A sentence for pages: no line ends between a number and its unit or per cent, and numbers have real minus signs.
pub(crate) fn set(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 8);
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let last = out.chars().next_back();
        let behind = &rest[c.len_utf8()..];
        let ends = |unit: &str| {
            !behind[unit.len()..].starts_with(|c: char| c.is_alphanumeric() || "²/_".contains(c))
        };
        let units = || UNITS.iter().chain(&["%"]).find(|unit| behind.starts_with(**unit) && ends(unit));
        let is_number = last.is_some_and(|c| c.is_ascii_digit());
        if let Some(unit) = (c == ' ' && is_number).then(units).flatten() {
            out += "\u{a0}";
            out += &unit.replace(' ', "\u{a0}");
            rest = &behind[unit.len()..];
            continue;
        }
        let opens = last.is_none_or(|c| c.is_whitespace() || "([".contains(c));
        let is_sign = c == '-' && behind.starts_with(|c: char| c.is_ascii_digit());
        let of_power = last == Some('e') && out.chars().rev().nth(1).is_some_and(|c| c.is_ascii_digit());
        out.push(if is_sign && (opens || of_power) { '−' } else { c });
        rest = behind;
    }
    out
}

/// What is rounded to nothing has no sign.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// A real minus sign.
fn signed(text: String) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_numbers_show_something() {
        assert_eq!(
            [0.0, 0.012_34, 0.001_234, -3.0].map(four_decimals),
            ["0.0000", "0.0123", "1.23e-3", "-3.0000"]
        );
        assert_eq!([0.0, 0.012_345, 12_345.6].map(|x| counting(x, 4)), ["0", "0.01235", "12346"]);
        assert_eq!([1e-12, f64::INFINITY].map(|x| counting(x, 3)), ["0.000000000", "inf"]);
    }

    #[test]
    fn sentences_are_set() {
        let plain = "z -0.0226 m (95 %: -1.2e-3 to 3 N m s/rad), at 9 Hz, 3 sines, joint-4, 2-3, 5 mmm";
        let page = "z −0.0226\u{a0}m (95\u{a0}%: −1.2e−3 to 3\u{a0}N\u{a0}m\u{a0}s/rad), at 9\u{a0}Hz, 3 sines, joint-4, 2-3, 5 mmm";
        assert_eq!(set(plain), page);
    }

    #[test]
    fn units_stay_apart() {
        let mut rows = [("N", 1.0), ("m", 0.1), ("N", f64::NAN), ("N", 3.0), ("m", 5.0)];
        worst_first(&mut rows, |row| row.0.to_owned(), |row| row.1);
        let order: Vec<String> = rows.iter().map(|row| format!("{} {}", row.1, row.0)).collect();
        assert_eq!(order, ["3 N", "1 N", "NaN N", "5 m", "0.1 m"]);
    }

    #[test]
    fn digits_are_those_that_matter() {
        assert_eq!(significant(0.05234, 3), "0.0523");
        assert_eq!(significant(-1234.6, 3), "−1235");
        assert_eq!(significant(0.00000012, 3), "1.20e−7");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(with_unit(0.0, "1"), "0");
        assert_eq!(with_interval(0.40216, Some([0.3971, 0.4072])).0, "0.4022");
        assert_eq!(with_interval(12.345, Some([11.0, 13.5])).1, Some(["11.0".to_owned(), "13.5".to_owned()]));
        assert_eq!(with_interval(-0.0048, Some([-0.403, 0.393])).0, "0.00");
        assert_eq!(percent(0.000_03), "<\u{a0}0.1\u{a0}%");
        assert_eq!(percent(0.1753), "18\u{a0}%");
        assert_eq!(percent(0.0132), "1.3\u{a0}%");
    }
}
