//! Line plots one above the other, as SVG.
use std::fmt::Write;

/// One plot.
pub struct Panel<'a> {
    pub title: &'a str,
    pub unit: &'a str,
    /// Name and values.
    pub curves: Vec<(&'a str, Vec<f64>)>,
}

const COLOURS: [&str; 4] = ["#1f6fb4", "#c9541c", "#2b8a4b", "#8a4fb0"];
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 150.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 150.0;
/// Above each plot, for its title.
const TOP: f64 = 26.0;
const BELOW: f64 = 34.0;
/// Points of a curve: more are thinned, keeping extremes.
const POINTS: usize = 420;

/// All panels over the same times (s).
pub fn draw(title: &str, time: &[f64], panels: &[Panel<'_>]) -> String {
    let height = 24.0 + panels.len() as f64 * (HEIGHT + TOP) + BELOW;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\" fill=\"#333\" role=\"img\">\n<title>{title}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"{LEFT}\" y=\"18\" font-size=\"14\" font-weight=\"bold\">{title}</text>\n"
    );
    for (index, panel) in panels.iter().enumerate() {
        let top = 24.0 + TOP + index as f64 * (HEIGHT + TOP);
        plot(&mut svg, top, time, panel, index + 1 == panels.len());
    }
    svg + "</svg>\n"
}

fn plot(svg: &mut String, top: f64, time: &[f64], panel: &Panel<'_>, last: bool) {
    let all = panel.curves.iter().flat_map(|(_, values)| values).copied().filter(|x| x.is_finite());
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let margin = if high > low { 0.05 * (high - low) } else { 1.0 };
    let (low, high) = if low <= high { (low - margin, high + margin) } else { (0.0, 1.0) };
    let (from, to) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(1.0));
    let wide = WIDTH - LEFT - RIGHT;
    let x = |t: f64| LEFT + wide * (t - from) / (to - from).max(1e-9);
    let y = |v: f64| top + HEIGHT * (high - v) / (high - low);
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{wide}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#999\"/>\n\
         <text x=\"{LEFT}\" y=\"{:.0}\" font-weight=\"bold\">{}, {}</text>",
        top - 6.0,
        panel.title,
        panel.unit
    );
    for tick in ticks(low, high) {
        let (at, label) = (y(tick), number(tick));
        let _ = writeln!(
            svg,
            "<path d=\"M{LEFT} {at:.1}h{wide}\" stroke=\"#e3e3e3\"/><text x=\"{:.0}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            LEFT - 5.0,
            at + 4.0
        );
    }
    for tick in ticks(from, to) {
        let at = x(tick);
        let _ = writeln!(svg, "<path d=\"M{at:.1} {top}v{HEIGHT}\" stroke=\"#e3e3e3\"/>");
        if last {
            let label = number(tick);
            let _ = writeln!(
                svg,
                "<text x=\"{at:.1}\" y=\"{:.0}\" text-anchor=\"middle\">{label}</text>",
                top + HEIGHT + 14.0
            );
        }
    }
    if last {
        let _ = writeln!(
            svg,
            "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">time, s</text>",
            LEFT + 0.5 * wide,
            top + HEIGHT + 28.0
        );
    }
    for (k, (name, values)) in panel.curves.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let mut path = String::new();
        for i in thinned(values) {
            let _ = write!(
                path,
                "{}{:.1} {:.1}",
                if path.is_empty() { "M" } else { "L" },
                x(time[i]),
                y(values[i])
            );
        }
        let _ = writeln!(
            svg,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\"/>\n\
             <text x=\"{:.0}\" y=\"{:.0}\" fill=\"{colour}\">{name}</text>",
            WIDTH - RIGHT + 8.0,
            top + 14.0 + 16.0 * k as f64
        );
    }
}

/// Indices of the extremes of every stretch.
fn thinned(values: &[f64]) -> Vec<usize> {
    let stretch = (2 * values.len()).div_ceil(POINTS).max(1);
    let mut kept = Vec::new();
    for begin in (0..values.len()).step_by(stretch) {
        let own = (begin..(begin + stretch).min(values.len())).filter(|&i| values[i].is_finite());
        let (low, high) = (
            own.clone().min_by(|&a, &b| values[a].total_cmp(&values[b])),
            own.max_by(|&a, &b| values[a].total_cmp(&values[b])),
        );
        let mut pair: Vec<usize> = low.into_iter().chain(high).collect();
        pair.sort_unstable();
        pair.dedup();
        kept.extend(pair);
    }
    kept
}

/// Round numbers within a range.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let raw = (high - low) / 4.0;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * power).into_iter().find(|step| *step >= raw).unwrap_or(raw);
    let first = (low / step).ceil() as i64;
    (first..=(high / step).floor() as i64).map(|k| k as f64 * step).collect()
}

fn number(x: f64) -> String {
    let text = format!("{:.4}", x + 0.0);
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}
