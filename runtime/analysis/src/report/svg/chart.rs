//! A plot with two axes.
use super::px;
use crate::number::significant;
use maud::{Markup, html};

/// What one axis says and spans.
#[derive(Debug, Clone)]
pub(in crate::report) struct Axis {
    /// With the unit.
    pub label: String,
    pub low: f64,
    pub high: f64,
    /// Ticks are at least so far apart: 1 for what is counted.
    pub least: f64,
}

impl Axis {
    /// Spans all finite values and a little more; `zero`: from zero on.
    pub fn around(label: String, values: impl Iterator<Item = f64>, zero: bool) -> Self {
        let finite = values.filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if low > high {
            return Self { label, low: 0.0, high: 1.0, least: 0.0 };
        }
        let low = if zero { low.min(0.0) } else { low };
        let width = if high > low { high - low } else { high.abs().max(1e-9) };
        let below = if zero && low == 0.0 { 0.0 } else { 0.04 * width };
        Self { label, low: low - below, high: high + if zero { 0.12 } else { 0.04 } * width, least: 0.0 }
    }

    /// Spans exactly.
    pub fn exact(label: String, low: f64, high: f64) -> Self {
        Self { label, low, high: if high > low { high } else { low + 1.0 }, least: 0.0 }
    }

    /// The same for what is counted.
    pub fn counted(self, counted: bool) -> Self {
        Self { least: if counted { 1.0 } else { self.least }, ..self }
    }

    /// Round numbers within, about `wanted` of them.
    fn ticks(&self, wanted: f64) -> Vec<f64> {
        let rough = ((self.high - self.low) / wanted).max(self.least);
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough * 0.999);
        let step = step.unwrap_or(rough);
        let first = (self.low / step).ceil();
        let count = ((self.high / step).floor() - first) as i64;
        (0..=count.clamp(0, 50)).map(|i| (first + i as f64) * step).collect()
    }
}

/// The frame of a plot within a picture; its methods give parts of an `svg` element.
pub(in crate::report) struct Chart {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    pub x: Axis,
    pub y: Axis,
    /// Ticks below the x axis; not for categories.
    pub x_ticks: bool,
}

impl Chart {
    pub fn x(&self, value: f64) -> f64 {
        self.left + (value - self.x.low) / (self.x.high - self.x.low) * self.width
    }
    pub fn y(&self, value: f64) -> f64 {
        self.top + (self.y.high - value) / (self.y.high - self.y.low) * self.height
    }

    /// Grid, ticks, labels.
    pub fn axes(&self) -> Markup {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        let x_ticks = if self.x_ticks { self.x.ticks(self.width / 80.0) } else { Vec::new() };
        html! {
            g class="axes" {
                @for tick in x_ticks {
                    line class="grid" x1=(px(self.x(tick))) x2=(px(self.x(tick))) y1=(px(self.top)) y2=(px(bottom)) {}
                    text class="tick" x=(px(self.x(tick))) y=(px(bottom + 16.0)) text-anchor="middle" { (tidy(tick)) }
                }
                @for tick in self.y.ticks((self.height / 40.0).max(2.0)) {
                    line class="grid" x1=(px(self.left)) x2=(px(right)) y1=(px(self.y(tick))) y2=(px(self.y(tick))) {}
                    text class="tick" x=(px(self.left - 6.0)) y=(px(self.y(tick) + 4.0)) text-anchor="end" { (tidy(tick)) }
                }
                rect class="frame" x=(px(self.left)) y=(px(self.top)) width=(px(self.width)) height=(px(self.height)) {}
                @if !self.x.label.is_empty() {
                    text class="label" x=(px(self.left + self.width / 2.0)) y=(px(bottom + 34.0)) text-anchor="middle" { (self.x.label) }
                }
                @if !self.y.label.is_empty() {
                    @let (x, y) = (self.left - 48.0, self.top + self.height / 2.0);
                    text class="label" transform=(format!("translate({} {}) rotate(-90)", px(x), px(y))) text-anchor="middle" { (self.y.label) }
                }
            }
        }
    }

    /// A line; broken where a value is not finite. Points that nobody could see apart from the one before are left out: small files.
    pub fn line(&self, class: &str, points: impl Iterator<Item = (f64, f64)>) -> Markup {
        let mut path = String::new();
        // What is drawn last, and what was left out behind it.
        let (mut drawn, mut left_out) = (None::<[f64; 2]>, None::<[f64; 2]>);
        for (x, y) in points {
            if !(x.is_finite() && y.is_finite()) {
                left_out.take().into_iter().for_each(|to| stroke(&mut path, true, to));
                drawn = None;
                continue;
            }
            let to = [self.x(x), self.y(y)];
            if drawn.is_some_and(|[x, y]| (to[0] - x).abs().max((to[1] - y).abs()) < LINE_STEP) {
                left_out = Some(to);
                continue;
            }
            // From where the line stood before it leapt.
            left_out.take().into_iter().for_each(|to| stroke(&mut path, true, to));
            stroke(&mut path, drawn.is_some(), to);
            drawn = Some(to);
        }
        left_out.into_iter().for_each(|to| stroke(&mut path, true, to));
        html! { path class=(format!("line {class}")) d=(path) {} }
    }

    /// Dots, as one path of short strokes with round ends: small files.
    pub fn dots(&self, class: &str, points: impl Iterator<Item = (f64, f64)>) -> Markup {
        let mut path = String::new();
        for (x, y) in points.filter(|(x, y)| x.is_finite() && y.is_finite()) {
            path.push_str(&format!("M{} {}h0", px(self.x(x)), px(self.y(y))));
        }
        html! { path class=(format!("dots {class}")) d=(path) {} }
    }

    /// A band between two heights over the whole width, cut to the plot.
    pub fn band(&self, class: &str, low: f64, high: f64) -> Markup {
        let inside = |y: f64| self.y(y).clamp(self.top, self.top + self.height);
        let (top, bottom) = (inside(high), inside(low));
        html! { rect class=(class) x=(px(self.left)) y=(px(top)) width=(px(self.width)) height=(px(bottom - top)) {} }
    }
}

/// Points of a line that are nearer to each other are not all drawn, px.
const LINE_STEP: f64 = 0.3;

/// A line's next point: drawn to, or where its pen is set down.
fn stroke(path: &mut String, drawn: bool, [x, y]: [f64; 2]) {
    path.push_str(&format!("{}{} {}", if drawn { "L" } else { "M" }, px(x), px(y)));
}

/// A tick's number.
fn tidy(tick: f64) -> String {
    if tick.abs() < 1e-12 {
        return "0".to_owned();
    }
    let text = significant(tick, 4);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis::exact(String::new(), -0.13, 0.71);
        let ticks: Vec<String> = axis.ticks(4.0).into_iter().map(tidy).collect();
        assert_eq!(ticks, ["0", "0.5"]);
        let steps = Axis::exact(String::new(), 0.0, 2.2).counted(true);
        assert_eq!(steps.ticks(6.0), [0.0, 1.0, 2.0]);
        let axis = Axis::around(String::new(), [3.0, f64::NAN, 3.0].into_iter(), true);
        assert!(axis.low == 0.0 && axis.high > 3.0);
        assert!(Axis::around(String::new(), std::iter::empty(), false).ticks(5.0).len() > 2);
    }
}
