//! The numbers that the page's script plots, as JSON.
use super::data::{Abscissa, Report};
use super::thin::thin;
use crate::experiments::plotted::{Row, RowPart};
use serde::Serialize;

/// Most samples of one row; more cannot be seen.
const MOST_SAMPLES: usize = 6000;
/// Fewest, however many rows there are.
const FEWEST_SAMPLES: usize = 50;
/// Bytes of all numbers together: leaves room for the page itself.
const MOST_BYTES: usize = 4_400_000;
/// Bytes of one number, about.
const BYTES: usize = 8;

#[derive(Serialize)]
struct Payload<'a> {
    abscissa: &'a str,
    abscissa_unit: &'a str,
    rows: Vec<PlottedRow<'a>>,
}

#[derive(Serialize)]
struct PlottedRow<'a> {
    name: &'a str,
    unit: &'a str,
    joint: Option<&'a str>,
    noise: f64,
    note: &'a str,
    parts: Vec<PlottedPart<'a>>,
    /// Samples before thinning.
    total: usize,
    time: Vec<f64>,
    measured: Vec<f64>,
    /// Measured minus nominal.
    before: Vec<f64>,
    /// Measured minus amended.
    after: Option<Vec<f64>>,
    /// What the amended model is called.
    label: &'a str,
    signals: Vec<PlottedSignal<'a>>,
    /// Indices of the samples for scatter plots; `None`: all of them.
    fair: Option<Vec<usize>>,
}

#[derive(Serialize)]
struct PlottedPart<'a> {
    name: &'a str,
    samples: usize,
    before: f64,
    after: Option<f64>,
}

#[derive(Serialize)]
struct PlottedSignal<'a> {
    name: &'a str,
    unit: &'a str,
    values: Vec<f64>,
}

/// JSON that may stand inside a `<script>` element.
pub(super) fn json(report: &Report) -> String {
    let numbers: usize = report.rows.iter().map(|r| 4 + r.series.signals.len()).sum();
    let mut most = (MOST_BYTES / BYTES / numbers.max(1)).clamp(FEWEST_SAMPLES, MOST_SAMPLES);
    loop {
        let rows = report.rows.iter().map(|row| plotted(row, most)).collect();
        let Abscissa { name, unit } = &report.abscissa;
        let payload = Payload { abscissa: name, abscissa_unit: unit, rows };
        // Text and finite or null numbers: nothing that JSON could refuse.
        let text = serde_json::to_string(&payload).unwrap_or_else(|_| r#"{"rows":[]}"#.to_owned());
        if text.len() <= MOST_BYTES || most == FEWEST_SAMPLES {
            return harmless(&text);
        }
        most = (most * 3 / 4).max(FEWEST_SAMPLES);
    }
}

/// No character of it can end the element or start a comment.
pub(super) fn harmless(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            _ => out.push(c),
        }
    }
    out
}

fn plotted(row: &Row, most: usize) -> PlottedRow<'_> {
    let series = &row.series;
    let count = series.len();
    let before: Vec<f64> = series.residual().take(count).collect();
    let after: Option<Vec<f64>> =
        series.amended.as_ref().map(|_| series.residual_after().take(count).collect());
    // A sample without a time has no place.
    let placed: Vec<usize> = (0..count).filter(|&i| series.time[i].is_finite()).collect();
    let track = |values: &[f64]| placed.iter().map(|&i| values[i]).collect();
    let thinned = thin(placed.len(), &[track(&before), track(&series.measured)], most);
    let pick =
        |values: &[f64], digits| rounded(thinned.kept.iter().map(|&k| values[placed[k]]).collect(), digits);
    PlottedRow {
        name: &row.name,
        unit: &row.unit,
        joint: row.joint.as_deref(),
        noise: row.noise,
        note: &row.note,
        parts: row.parts.iter().map(plotted_part).collect(),
        total: count,
        time: pick(&series.time, 8),
        measured: pick(&series.measured, 5),
        before: pick(&before, 5),
        after: after.map(|values| pick(&values, 5)),
        label: series.after(),
        signals: series
            .signals
            .iter()
            .map(|s| PlottedSignal { name: &s.name, unit: &s.unit, values: pick(&s.values, 5) })
            .collect(),
        fair: (thinned.fair.len() < thinned.kept.len()).then_some(thinned.fair),
    }
}

fn plotted_part(part: &RowPart) -> PlottedPart<'_> {
    PlottedPart { name: &part.name, samples: part.samples, before: part.rms_before, after: part.rms_after }
}

/// Rounded to so many digits of the largest value: short in JSON, and finer than a screen.
pub(super) fn rounded(mut values: Vec<f64>, digits: i32) -> Vec<f64> {
    let largest = values.iter().filter(|x| x.is_finite()).fold(0.0f64, |m, x| m.max(x.abs()));
    if largest == 0.0 {
        return values;
    }
    let decimals = digits - 1 - largest.log10().floor() as i32;
    // Powers of ten up to 22 are exact: the quotient is the number nearest to the short decimal.
    if !(-22..=22).contains(&decimals) {
        return values;
    }
    let scale = 10f64.powi(decimals.abs());
    for x in &mut values {
        *x = if decimals >= 0 { (*x * scale).round() / scale } else { (*x / scale).round() * scale };
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::Channel;
    use crate::report::Series;

    #[test]
    fn numbers_are_short_and_gaps_are_null() {
        let series = Series {
            time: vec![0.0, 0.1, 0.2],
            measured: vec![1.0 / 3.0, f64::NAN, 200.0],
            nominal: vec![0.0, 0.0, f64::INFINITY],
            ..Series::default()
        };
        let rows = vec![Row::new("a</script>", Channel::Effort, "N m", 0.0, series)];
        let text = json(&Report { rows, ..Report::default() });
        assert!(text.contains("[0.33,null,200.0]"), "{text}");
        assert!(text.contains("[0.33333,null,null]"), "{text}");
        assert!(!text.contains('<'), "{text}");
    }

    #[test]
    fn long_logs_fit() {
        let n = 40_000;
        let wave = |f: f64| (0..n).map(|i| (f * f64::from(i)).sin() * 3.3).collect::<Vec<_>>();
        let series = Series {
            time: (0..n).map(|i| 0.001 * f64::from(i)).collect(),
            measured: wave(0.01),
            nominal: wave(0.0101),
            amended: Some(wave(0.01001)),
            ..Series::default()
        };
        let series = series.with("velocity", "rad/s", wave(0.02)).with("load", "N m", wave(0.03));
        let rows = (0..40).map(|i| Row::new(format!("j{i}"), Channel::Effort, "N m", 0.1, series.clone()));
        let text = json(&Report { rows: rows.collect(), ..Report::default() });
        assert!(text.len() <= MOST_BYTES && text.len() > MOST_BYTES / 3, "{}", text.len());
    }
}
