//! The falling error as a picture for papers: SVG that stands alone, readable in black and white.
use super::history::Stair;
use super::picture::{by_channel, heading};
use super::words::{day, quantity, rounded};
use std::fmt::Write;

const WIDTH: f64 = 640.0;
const LEFT: f64 = 60.0;
const TOP: f64 = 50.0;
/// Height of the plot itself.
const HEIGHT: f64 = 180.0;
/// Height of one line below it.
const LINE: f64 = 18.0;

/// One panel per kind of channel, below each other.
pub fn staircase(stairs: &[Stair]) -> String {
    let groups = by_channel(stairs);
    let heights: Vec<f64> = groups.iter().map(|g| TOP + HEIGHT + LINE * (g.len() as f64 + 2.0)).collect();
    let total = heights.iter().sum::<f64>().max(TOP);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {total}\" width=\"{WIDTH}\" \
         height=\"{total}\" font-family=\"sans-serif\" font-size=\"12\" role=\"img\">\n\
         <title>Error of the model after each step</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    if groups.is_empty() {
        let _ = writeln!(svg, "<text x=\"10\" y=\"24\">No step with a known error.</text>");
    }
    let mut top = 0.0;
    for (group, height) in groups.iter().zip(heights) {
        panel(&mut svg, group, top);
        top += height;
    }
    svg + "</svg>\n"
}

fn panel(svg: &mut String, group: &[&Stair], top: f64) {
    let largest = group.iter().flat_map(|stair| [stair.before, stair.after]).fold(0.0_f64, f64::max);
    let y = |value: f64| top + TOP + HEIGHT * (1.0 - if largest > 0.0 { value / largest } else { 0.0 });
    let wide = (WIDTH - LEFT - 20.0) / (group.len() as f64 + 1.0);
    let x = |index: usize| LEFT + wide * index as f64;
    let floor = y(0.0);
    let _ = writeln!(
        svg,
        "<text x=\"10\" y=\"{:.1}\" font-weight=\"bold\">{}</text>",
        top + 22.0,
        escaped(&heading(group[0]))
    );
    let _ = writeln!(
        svg,
        "<path d=\"M{LEFT} {:.1}V{floor:.1}H{:.1}\" fill=\"none\" stroke=\"#666\"/>",
        top + TOP - 8.0,
        WIDTH - 20.0
    );
    if let Some(noise) =
        group.iter().map(|stair| stair.noise).rfind(|noise| *noise > 0.0 && *noise <= largest)
    {
        let (right, at) = (WIDTH - 20.0, y(noise));
        let _ =
            writeln!(svg, "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#666\" stroke-dasharray=\"4 4\"/>");
        let _ = writeln!(
            svg,
            "<text x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#444\">noise {}</text>",
            at - 4.0,
            rounded(noise)
        );
    }
    let mut line = format!("M{:.1} {:.1}H{:.1}", x(0), y(group[0].before), x(1));
    let mut labels = number(x(0) + wide / 2.0, y(group[0].before), group[0].before);
    for (index, stair) in group.iter().enumerate() {
        let _ = write!(line, "V{:.1}H{:.1}", y(stair.after), x(index + 2));
        labels += &number(x(index + 1) + wide / 2.0, y(stair.after), stair.after);
        let _ = writeln!(
            labels,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            x(index + 1) + wide / 2.0,
            floor + 14.0,
            index + 1
        );
        let said = format!(
            "{}  {} (step {}, {}): {}",
            index + 1,
            stair.label,
            stair.step,
            day(&stair.date),
            quantity(stair.after, &stair.unit)
        );
        let _ = writeln!(
            labels,
            "<text x=\"{LEFT}\" y=\"{:.1}\">{}</text>",
            floor + 18.0 + LINE * (index as f64 + 1.0),
            escaped(&said)
        );
    }
    let _ = writeln!(svg, "<path d=\"{line}\" fill=\"none\" stroke=\"#0057b7\" stroke-width=\"2.5\"/>");
    svg.push_str(&labels);
}

fn number(x: f64, y: f64, value: f64) -> String {
    format!("<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n", y - 5.0, rounded(value))
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;")
}
