//! Foot placements and centres of pressure from above.
use bipedc_analysis::identify::excite::postures::{DesignedPostures, StanceModel};
use bipedc_analysis::polygon::Polygon;
use std::fmt::Write as _;

/// Size of a panel and of its margin, px.
const PANEL: f64 = 200.0;
/// Panels side by side.
const ACROSS: usize = 5;
/// Side of what a panel shows, m.
const SIDE: f64 = 0.75;

/// One panel per placement: x forward is up, y left is left; soles, support and centres of pressure.
pub fn from_above(standing: &StanceModel<'_>, found: &DesignedPostures) -> String {
    let count = found.placements.len();
    let (columns, rows) = (count.min(ACROSS), count.div_ceil(ACROSS));
    let (width, height) = (PANEL * columns as f64, PANEL * rows as f64 + 30.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (k, placement) in found.placements.iter().enumerate() {
        svg += &panel(standing, found, (k, placement));
    }
    let scale = PANEL / SIDE * 0.1;
    let base = height - 12.0;
    let _ = writeln!(
        svg,
        "<path d=\"M6 {base} h{scale:.1}\" stroke=\"#345\" stroke-width=\"2\"/><text x=\"{:.1}\" y=\"{:.1}\" fill=\"#345\">0.1 m; forward is up; soles, support, expected centres of pressure</text>",
        12.0 + scale,
        base + 4.0
    );
    svg.push_str("</svg>\n");
    svg
}

/// Soles, support and centres of pressure of one placement.
fn panel(standing: &StanceModel<'_>, found: &DesignedPostures, (k, placement): (usize, &[f64; 3])) -> String {
    let mut svg = String::new();
    let soles = standing.corners(placement);
    let all = soles.concat();
    let corner = [PANEL * (k % ACROSS) as f64, PANEL * (k / ACROSS) as f64];
    let middle = [middle(&all, 0), middle(&all, 1)];
    let at = |p: [f64; 2]| {
        [1, 0].map(|axis| corner[1 - axis] + 0.5 * PANEL - PANEL / SIDE * (p[axis] - middle[axis]))
    };
    let points = |polygon: &Polygon| -> String {
        polygon.corners.iter().map(|p| at(*p)).map(|[x, y]| format!("{x:.1},{y:.1} ")).collect()
    };
    // Writing into strings cannot fail.
    let _ = writeln!(
        svg,
        "<polygon points=\"{}\" fill=\"#eef3f8\" stroke=\"#b8c4d0\"/>",
        points(&Polygon::hull(&all))
    );
    for sole in &soles {
        let _ = writeln!(
            svg,
            "<polygon points=\"{}\" fill=\"none\" stroke=\"#345\"/>",
            points(&Polygon::hull(sole))
        );
    }
    for posture in found.postures.iter().filter(|posture| posture.placement == k) {
        let [x, y] = at(posture.center);
        let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\" fill=\"#c0392b\"/>");
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.0}\" y=\"{:.0}\" fill=\"#345\">{k}</text>",
        corner[0] + 6.0,
        corner[1] + 14.0
    );
    svg
}

/// Between the outermost points along an axis.
fn middle(points: &[[f64; 2]], axis: usize) -> f64 {
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c[axis]), high.max(c[axis])));
    0.5 * (low + high)
}
