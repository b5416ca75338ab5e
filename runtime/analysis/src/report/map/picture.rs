//! Maps as one picture: a panel for each speed, one scale and one legend for all.
use super::contour::contour;
use super::data::{MapFigure, MapPanel};
use super::raster::{colour, hex, raster, shade};
use crate::number::significant;
use crate::report::svg::chart::{Axis, Chart};
use crate::report::svg::{px, standalone};
use maud::{Markup, html};

/// Width and height of a panel's plot, px.
const PLOT: [f64; 2] = [250.0, 210.0];
/// Room left of a plot, above, right of it and below, px.
const ROOM: [f64; 4] = [66.0, 30.0, 14.0, 46.0];
/// Height of a line of the legend, px.
const LINE: f64 = 20.0;

/// All maps with their legend as an SVG file.
pub fn map_svg(figure: &MapFigure) -> String {
    let across = match figure.panels.len() {
        0 | 1 => 1,
        2 | 4 => 2,
        _ => 3,
    };
    let (size, lines) = (panel_size(), figure.panels.len().div_ceil(across));
    let width = across as f64 * size.0;
    let (legend, height) = legend(figure, width);
    let place = |k: usize| ((k % across) as f64 * size.0, 26.0 + (k / across) as f64 * size.1);
    let content = html! {
        text class="label" x="12" y="18" font-weight="600" { (figure.title) ", " (figure.robot) }
        @for (k, panel) in figure.panels.iter().enumerate() { (one(figure, panel, place(k))) }
        g transform=(format!("translate(0 {})", px(26.0 + lines as f64 * size.1))) { (legend) }
    };
    standalone(&figure.title, (width, 26.0 + lines as f64 * size.1 + height), &content)
}

/// Width and height of a panel with its labels, px.
pub(super) fn panel_size() -> (f64, f64) {
    (ROOM[0] + PLOT[0] + ROOM[2], ROOM[1] + PLOT[1] + ROOM[3])
}

/// What stands above a panel.
pub(super) fn caption(figure: &MapFigure, panel: &MapPanel) -> String {
    format!("from {} {}", panel.speed, figure.unit)
}

/// A panel at a place of a picture.
pub(super) fn one(figure: &MapFigure, panel: &MapPanel, (left, top): (f64, f64)) -> Markup {
    let [x, y] = &figure.axes;
    let axis = |of: &super::MapAxisFigure| {
        let [low, high] = of.ends();
        Axis::exact(of.label(), low, high)
    };
    let [width, height] = PLOT;
    let (left, top) = (left + ROOM[0], top + ROOM[1]);
    let chart = Chart { left, top, width, height, x: axis(x), y: axis(y), x_ticks: true };
    let picture = raster(&panel.values, &panel.reasons, x.values.len(), figure.span());
    html! {
        (chart.axes())
        text class="value" x=(px(left + width / 2.0)) y=(px(top - 9.0)) text-anchor="middle" { (caption(figure, panel)) }
        image class="raster" x=(px(left)) y=(px(top)) width=(px(width)) height=(px(height)) preserveAspectRatio="none" href=(picture) {}
        (bounds(figure, &chart))
        (isocline(figure, panel, &chart))
        @if let Some(at) = panel.fastest { (mark("fastest", chart.x(at[0]), chart.y(at[1]))) }
        @if let Some(at) = panel.slowest { (mark("slowest", chart.x(at[0]), chart.y(at[1]))) }
        rect class="frame" x=(px(left)) y=(px(top)) width=(px(width)) height=(px(height)) {}
    }
}

/// The bounds as far as they lie within the plot.
fn bounds(figure: &MapFigure, chart: &Chart) -> Markup {
    let [x, y] = figure.axes.each_ref().map(|axis| {
        let [low, high] = axis.ends();
        axis.bounds.map(|bound| bound.clamp(low, high))
    });
    let (left, right, top, bottom) = (chart.x(x[0]), chart.x(x[1]), chart.y(y[1]), chart.y(y[0]));
    if right <= left || bottom <= top {
        return html! {};
    }
    html! { rect class="bounds" x=(px(left)) y=(px(top)) width=(px(right - left)) height=(px(bottom - top)) {} }
}

/// Where the next step is as fast as this one.
fn isocline(figure: &MapFigure, panel: &MapPanel, chart: &Chart) -> Markup {
    let shown: Vec<f64> = panel.shown().collect();
    let [x, y] = &figure.axes;
    let place = |axis: &super::MapAxisFigure, at: f64| {
        let below = (at as usize).min(axis.values.len().saturating_sub(2));
        let step = axis.values.get(below + 1).zip(axis.values.get(below)).map_or(0.0, |(b, a)| b - a);
        axis.values.get(below).copied().unwrap_or(0.0) + (at - below as f64) * step
    };
    let mut path = String::new();
    for [from, to] in contour(&shown, x.values.len(), panel.speed) {
        let [a, b] =
            [from, to].map(|[column, row]| [px(chart.x(place(x, column))), px(chart.y(place(y, row)))]);
        // Pieces that are shorter than a hundredth of a pixel.
        if a != b {
            path.push_str(&format!("M{} {}L{} {}", a[0], a[1], b[0], b[1]));
        }
    }
    html! { path class="line isocline" d=(path) {} }
}

/// A triangle: upwards for the fastest step, downwards for the slowest.
pub(super) fn mark(class: &str, x: f64, y: f64) -> Markup {
    let tip = if class == "fastest" { -7.0 } else { 7.0 };
    let path = format!("M{} {}l-6.5 {}h13z", px(x), px(y + tip), px(-1.7 * tip));
    html! { path class=(format!("mark {class}")) d=(path) {} }
}

/// Scale, lines, marks and reasons; with its height.
fn legend(figure: &MapFigure, width: f64) -> (Markup, f64) {
    let scale = 190.0;
    let [low, high] = figure.span();
    let words = format!("next speed ({})", figure.unit);
    let mut items: Vec<(Markup, String)> = vec![
        (html! { path class="line isocline" d="M0 -4h24" {} }, "as fast as before".to_owned()),
        (html! { rect class="bounds" x="1" y="-10" width="22" height="11" {} }, "bounds".to_owned()),
        (html! { (mark("fastest", 12.0, -3.0)) }, "fastest within bounds".to_owned()),
        (html! { (mark("slowest", 12.0, -5.0)) }, "slowest within bounds".to_owned()),
    ];
    for reason in figure.reasons() {
        let fill = hex(colour(reason));
        items.push((
            html! { rect class="reason" x="1" y="-10" width="22" height="11" fill=(fill) {} },
            reason.words().to_owned(),
        ));
    }
    let (mut x, mut y, mut placed) = (16.0, 46.0, Vec::new());
    for (symbol, words) in items {
        let long = 44.0 + 6.1 * words.chars().count() as f64;
        if x > 16.0 && x + long > width {
            (x, y) = (16.0, y + LINE);
        }
        placed.push((x, y, symbol, words));
        x += long;
    }
    let stops = (0..=16).map(|k| (format!("{}%", 6.25 * f64::from(k)), hex(shade(f64::from(k) / 16.0))));
    let markup = html! {
        defs { linearGradient id="speeds" { @for (offset, colour) in stops { stop offset=(offset) stop-color=(colour) {} } } }
        text class="tick" x="16" y="18" { (words) }
        text class="tick" x="178" y="18" text-anchor="end" { (significant(low, 3)) }
        rect x="184" y="8" width=(px(scale)) height="12" fill="url(#speeds)" {}
        text class="tick" x=(px(190.0 + scale)) y="18" { (significant(high, 3)) }
        @for (x, y, symbol, words) in placed {
            g transform=(format!("translate({} {})", px(x), px(y))) { (symbol) text class="tick" x="30" y="0" { (words) } }
        }
    };
    (markup, y + 14.0)
}
