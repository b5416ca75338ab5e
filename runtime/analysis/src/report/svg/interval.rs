//! Values with their confidence.
use super::px;
use crate::diagnose::FoundEffect;
use crate::number::{joined, percent, with_interval};
use crate::report::causes::ordered;
use maud::{Markup, html};

/// A value on the scale of its plausible range: range as a bar, 95 % interval as a line, value as a diamond.
///
/// `None` where nothing finite could set the scale.
pub(in crate::report) fn interval(value: f64, ci: Option<[f64; 2]>, plausible: (f64, f64)) -> Option<Markup> {
    let [low, high] = ci.unwrap_or([value; 2]);
    if !(value.is_finite() && low.is_finite() && high.is_finite()) {
        return None;
    }
    // Around the interval and zero, not the whole plausible range: that may be a hundred times wider.
    let reach = (high - low).max(0.15 * value.abs()).max(1e-12);
    let (from, to) = ((low - 0.6 * reach).min(0.0), (high + 0.6 * reach).max(0.0));
    let x = |v: f64| 6.0 + 208.0 * ((v - from) / (to - from)).clamp(0.0, 1.0);
    let likely = (x(plausible.0.max(from)), x(plausible.1.min(to)));
    Some(html! {
        svg class="interval" viewBox="0 0 220 22" width="220" height="22" aria-hidden="true" {
            @if likely.1 > likely.0 {
                rect class="plausible" x=(px(likely.0)) y="7" width=(px(likely.1 - likely.0)) height="8" rx="2" {}
            }
            line class="zero" x1=(px(x(0.0))) x2=(px(x(0.0))) y1="3" y2="19" {}
            line class="whisker" x1=(px(x(low))) x2=(px(x(high))) y1="11" y2="11" {}
            line class="whisker" x1=(px(x(low))) x2=(px(x(low))) y1="6" y2="16" {}
            line class="whisker" x1=(px(x(high))) x2=(px(x(high))) y1="6" y2="16" {}
            path class="diamond" d=(format!("M{} 5l6 6l-6 6l-6 -6z", px(x(value)))) {}
        }
    })
}

/// The ranked causes as bars of their share, with values and intervals in words; `None` without causes.
pub(in crate::report) fn causes(effects: &[FoundEffect]) -> Option<(Markup, (f64, f64))> {
    if effects.is_empty() {
        return None;
    }
    let mut y = 20.0;
    let mut placed = Vec::new();
    for found in effects {
        placed.push((y, found));
        y += 44.0 + 15.0 * found.effect.parameters.len() as f64;
    }
    let content = html! {
        @for (rank, (y, found)) in placed.iter().enumerate() {
            text class="value" x="12" y=(px(*y)) { (rank + 1) ". " (found.effect) }
            rect class="track" x="12" y=(px(y + 8.0)) width="360" height="10" rx="2" {}
            rect class="share" x="12" y=(px(y + 8.0)) width=(px(360.0 * found.share.clamp(0.0, 1.0))) height="10" rx="2" {}
            text class="tick" x="380" y=(px(y + 17.0)) { (percent(found.share)) " of the held-out squared error" }
            @for (k, (name, value)) in ordered(&found.effect).into_iter().enumerate() {
                text class="tick" x="24" y=(px(y + 33.0 + 15.0 * k as f64)) { (stated(found, name, value)) }
            }
        }
    };
    Some((content, (600.0, y - 10.0)))
}

/// Such as `torque 0.402 N m (95 %: 0.397 to 0.408)`.
fn stated(found: &FoundEffect, name: &str, value: f64) -> String {
    let unit = found.effect.unit(name);
    let (text, ci) = with_interval(value, found.ci95.get(name).copied());
    let ci = ci.map_or_else(String::new, |[low, high]| format!(" (95 %: {low} to {high})"));
    format!("{name} {}{ci}", joined(text, unit))
}
