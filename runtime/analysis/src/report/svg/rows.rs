//! One row over time, and its residual against a signal: for papers. The page draws these with uPlot.
use super::chart::{Axis, Chart};
use crate::experiments::plotted::{Row, Series, Signal};
use crate::report::data::Abscissa;
use crate::report::thin::thin;
use maud::{Markup, html};

/// Samples of a printed curve.
const PRINTED: usize = 2500;

/// Measured, nominal and amended above; residuals below.
pub(in crate::report) fn torque_and_residual(row: &Row, abscissa: &Abscissa) -> (Markup, (f64, f64)) {
    let series = &row.series;
    let count = series.len();
    let before: Vec<f64> = series.residual().take(count).collect();
    let kept = thin(count, &[before, series.measured[..count].to_vec()], PRINTED).kept;
    let content = html! {
        (signals(row, &kept))
        (residuals(row, &kept, labelled(&abscissa.name, &abscissa.unit)))
    };
    (content, (710.0, 434.0))
}

/// A plot over the time that the samples span.
fn over_time(series: &Series, (top, height): (f64, f64), label: String, y: Axis) -> Chart {
    let time = || series.time[..series.len()].iter().copied().filter(|t| t.is_finite());
    let x = Axis::exact(label, time().next().unwrap_or(0.0), time().next_back().unwrap_or(1.0));
    Chart { left: 70.0, top, width: 620.0, height, x, y, x_ticks: true }
}

/// The kept samples of a curve.
fn curve(chart: &Chart, class: &str, series: &Series, kept: &[usize], values: &[f64]) -> Markup {
    chart.line(class, kept.iter().map(|&i| (series.time[i], values.get(i).copied().unwrap_or(f64::NAN))))
}

fn signals(row: &Row, kept: &[usize]) -> Markup {
    let series = &row.series;
    let all = series.measured.iter().chain(&series.nominal).chain(series.amended.iter().flatten());
    let y = Axis::around(labelled(&row.name, &row.unit), all.copied(), false);
    let chart = over_time(series, (30.0, 190.0), String::new(), y);
    let mut entries = vec![("measured", "measured"), ("nominal", "nominal model")];
    entries.extend(series.amended.as_ref().map(|_| ("amended", series.after())));
    html! {
        (chart.axes())
        (curve(&chart, "measured", series, kept, &series.measured))
        (curve(&chart, "nominal", series, kept, &series.nominal))
        @if let Some(amended) = &series.amended { (curve(&chart, "amended", series, kept, amended)) }
        (keys(70.0, 16.0, &entries))
    }
}

fn residuals(row: &Row, kept: &[usize], label: String) -> Markup {
    let series = &row.series;
    let (before, after): (Vec<f64>, Vec<f64>) =
        (series.residual().collect(), series.residual_after().collect());
    let all = before.iter().chain(&after).copied().chain([0.0]);
    let chart =
        over_time(series, (268.0, 120.0), label, Axis::around(labelled("residual", &row.unit), all, false));
    let after_name = format!("measured − {}", series.after());
    let mut entries = vec![("before", "measured − nominal")];
    entries.extend(series.amended.as_ref().map(|_| ("after", after_name.as_str())));
    html! {
        @if row.noise > 0.0 { (chart.band("noise", -2.0 * row.noise, 2.0 * row.noise)) }
        (chart.axes())
        (curve(&chart, "before", series, kept, &before))
        @if series.amended.is_some() { (curve(&chart, "after", series, kept, &after)) }
        (keys(70.0, 258.0, &entries))
    }
}

/// Residual over a signal, and what the effects explain of it.
pub(in crate::report) fn against(row: &Row, signal: &Signal) -> (Markup, (f64, f64)) {
    let series: &Series = &row.series;
    let count = series.len();
    let thinned = thin(count, &[], PRINTED);
    let fair = || thinned.fair.iter().map(|&k| thinned.kept[k]);
    let before: Vec<f64> = series.residual().take(count).collect();
    let explained: Option<Vec<f64>> =
        series.amended.as_ref().map(|a| a.iter().zip(&series.nominal).map(|(a, n)| a - n).collect());
    let chart = Chart {
        left: 70.0,
        top: 30.0,
        width: 330.0,
        height: 230.0,
        x: Axis::around(labelled(&signal.name, &signal.unit), signal.values.iter().copied(), false),
        y: Axis::around(labelled("residual", &row.unit), before.iter().copied().chain([0.0]), false),
        x_ticks: true,
    };
    let content = html! {
        @if row.noise > 0.0 { (chart.band("noise", -2.0 * row.noise, 2.0 * row.noise)) }
        (chart.axes())
        (chart.dots("before", fair().map(|i| (signal.values[i], before[i]))))
        @if let Some(explained) = &explained {
            (chart.dots("explained", fair().map(|i| (signal.values[i], explained[i]))))
        }
        (keys(70.0, 16.0, &[("before", "measured − nominal"), ("explained", if series.amended_name.is_empty() { "what the effects explain" } else { "what the estimate explains" })][..if explained.is_some() { 2 } else { 1 }]))
    };
    (content, (420.0, 306.0))
}

/// Such as `load (N m)`.
fn labelled(name: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { name.to_owned() } else { format!("{name} ({unit})") }
}

/// A legend in one line.
pub(in crate::report) fn keys(left: f64, y: f64, entries: &[(&str, &str)]) -> Markup {
    let mut x = left;
    let placed: Vec<(f64, &str, &str)> = entries
        .iter()
        .map(|(class, text)| {
            let here = x;
            x += 40.0 + 6.6 * text.chars().count() as f64;
            (here, *class, *text)
        })
        .collect();
    html! {
        @for (x, class, text) in placed {
            path class=(format!("line {class}")) d=(format!("M{x} {}h20", y - 4.0)) {}
            text class="tick" x=(x + 25.0) y=(y) { (text) }
        }
    }
}
