//! Curves as one picture.
use super::{Curve, CurveFigure, CurveKind};
use crate::report::svg::chart::{Axis, Chart};
use crate::report::svg::{keys, standalone};
use maud::{Markup, html};

/// Width and height of the picture, px.
pub(super) const SIZE: (f64, f64) = (640.0, 360.0);

/// All curves as an SVG file.
pub fn curves_svg(figure: &CurveFigure) -> String {
    let content = html! {
        text class="label" x="12" y="18" font-weight="600" { (figure.title) ", " (figure.robot) }
        (picture(figure))
    };
    standalone(&figure.title, SIZE, &content)
}

/// Frame, curves and legend.
pub(super) fn picture(figure: &CurveFigure) -> Markup {
    let all =
        |k: usize| figure.curves.iter().flat_map(move |curve| curve.points.iter().map(move |point| point[k]));
    let chart = Chart {
        left: 70.0,
        top: 48.0,
        width: SIZE.0 - 90.0,
        height: SIZE.1 - 100.0,
        x: Axis::around(figure.x.clone(), all(0), false).counted(figure.counted[0]),
        y: Axis::around(figure.y.clone(), all(1), figure.from_zero).counted(figure.counted[1]),
        x_ticks: true,
    };
    let entries: Vec<(&str, &str)> = figure
        .curves
        .iter()
        .filter(|curve| !curve.words.is_empty())
        .map(|curve| (curve.kind.class(), curve.words.as_str()))
        .collect();
    html! {
        (chart.axes())
        @for curve in &figure.curves { (drawn(curve, &chart)) }
        (keys(70.0, 36.0, &entries))
    }
}

fn drawn(curve: &Curve, chart: &Chart) -> Markup {
    let points = || curve.points.iter().map(|[x, y]| (*x, *y));
    let class = curve.kind.class();
    html! {
        @if curve.kind != CurveKind::Dots { (chart.line(class, points())) }
        @if matches!(curve.kind, CurveKind::Main | CurveKind::Dots) { (chart.dots(&format!("{class} places"), points())) }
    }
}
