//! Footprints, balance and the first violated limit as seen from above.
use super::Plan;
use bipedc_analysis::walking::Point;
use std::fmt::Write;

/// Largest width and height, px.
const SIZE: [f64; 2] = [900.0, 500.0];
/// Around it, px.
const ROOM: f64 = 24.0;
/// Colours of right and left soles, and of the three lines.
const SOLES: [&str; 2] = ["#c2410c", "#1d4ed8"];
const LINES: [(&str, &str); 3] =
    [("centre of mass", "#111827"), ("zero moment point", "#be185d"), ("divergent component", "#15803d")];

impl Plan {
    /// The picture as SVG text, forward to the right.
    pub fn picture(&self) -> String {
        let start = (0..2).map(|k| (k, self.start.soles[k]));
        let steps = self.footsteps.iter().map(|step| (step.foot, step.sole));
        let prints: Vec<(usize, Vec<Point>)> =
            start.chain(steps).map(|(k, sole)| (k, self.legs.footprint(k, sole.place, sole.yaw))).collect();
        let all = || prints.iter().flat_map(|(_, outline)| outline.iter());
        let low = [0, 1].map(|i| all().map(|p| p[i]).fold(f64::MAX, f64::min));
        let high = [0, 1].map(|i| all().map(|p| p[i]).fold(f64::MIN, f64::max));
        let scale =
            (0..2).map(|i| (SIZE[i] - 2.0 * ROOM) / (high[i] - low[i]).max(0.1)).fold(f64::MAX, f64::min);
        let at = |[x, y]: Point| [ROOM + (x - low[0]) * scale, ROOM + (high[1] - y) * scale];
        let points = |line: &mut dyn Iterator<Item = Point>| {
            line.map(at).map(|[x, y]| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
        };
        let size = [0, 1].map(|i| 2.0 * ROOM + (high[i] - low[i]) * scale);
        let mut svg = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {:.0} {:.0}" font-family="sans-serif" font-size="13" role="img" aria-label="Footprints from above">"#,
            size[0].max(560.0),
            size[1] + 24.0
        );
        // White also where the page is dark.
        svg += r#"<rect width="100%" height="100%" fill="white"/>"#;
        // Writing to a string cannot fail.
        for (foot, outline) in &prints {
            let colour = SOLES[*foot];
            let _ = write!(
                svg,
                r#"<polygon points="{}" fill="{colour}" fill-opacity="0.13" stroke="{colour}"/>"#,
                points(&mut outline.iter().copied())
            );
        }
        let every = self.rows.len().div_ceil(1500).max(1);
        for (k, (name, colour)) in LINES.iter().enumerate() {
            let of = |row: &super::Row| match k {
                0 => [row.center[0][0], row.center[1][0]],
                1 => row.zmp,
                _ => row.divergent,
            };
            let line = points(&mut self.rows.iter().step_by(every).map(of));
            let _ = write!(
                svg,
                r#"<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.3"/>"#
            );
            let x = ROOM + 180.0 * k as f64;
            let _ = write!(svg, r#"<text x="{x}" y="{:.0}" fill="{colour}">— {name}</text>"#, size[1] + 14.0);
        }
        if let Some(first) = &self.violation {
            let row = &self.rows[first.row];
            let _ = write!(
                svg,
                r##"<polygon points="{}" fill="none" stroke="#dc2626" stroke-width="2" stroke-dasharray="5 3"/>"##,
                points(&mut row.support.iter().copied())
            );
            let [x, y] = at(row.zmp);
            let _ = write!(
                svg,
                r##"<circle cx="{x:.1}" cy="{y:.1}" r="7" fill="none" stroke="#dc2626" stroke-width="2"/>"##
            );
            let words = format!("{} at {:.3} s", first.quantity.words(), first.time);
            let _ = write!(svg, r##"<text x="{ROOM}" y="16" fill="#dc2626">{words}</text>"##);
        }
        svg + "</svg>"
    }
}
