//! The falling error as a picture for papers: SVG that stands alone, readable in black and white.
use super::comments::{day, quantity, rounded};
use super::history::Stair;
use super::picture::{by_channel, heading};
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
        let largest = group.iter().flat_map(|stair| [stair.before, stair.after]).fold(0.0_f64, f64::max);
        Panel { group, top, largest }.draw(&mut svg);
        top += height;
    }
    svg + "</svg>\n"
}

/// Where the numbers of one panel are drawn.
struct Panel<'a> {
    group: &'a [&'a Stair],
    top: f64,
    largest: f64,
}

impl Panel<'_> {
    fn x(&self, index: usize) -> f64 {
        LEFT + self.wide() * index as f64
    }

    fn y(&self, value: f64) -> f64 {
        let part = if self.largest > 0.0 { value / self.largest } else { 0.0 };
        self.top + TOP + HEIGHT * (1.0 - part)
    }

    fn wide(&self) -> f64 {
        (WIDTH - LEFT - 20.0) / (self.group.len() as f64 + 1.0)
    }

    /// A dashed line with its label below, where no stair is; above where the numbers of the axis are below.
    fn noise(&self, svg: &mut String) {
        let known = self.group.iter().map(|stair| stair.noise);
        let Some(noise) = known.rev().find(|noise| *noise > 0.0 && *noise <= self.largest) else { return };
        let (right, at) = (WIDTH - 20.0, self.y(noise));
        let label = if at + 16.0 < self.y(0.0) { at + 13.0 } else { at - 4.0 };
        let _ =
            writeln!(svg, "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#666\" stroke-dasharray=\"4 4\"/>");
        let _ = writeln!(
            svg,
            "<text x=\"{right}\" y=\"{label:.1}\" text-anchor=\"end\" fill=\"#444\">noise {}</text>",
            rounded(noise)
        );
    }

    /// Number below the axis and line of the legend of one step.
    fn step(&self, svg: &mut String, index: usize, stair: &Stair) {
        let floor = self.y(0.0);
        let at = self.x(index + 1) + self.wide() / 2.0;
        svg.push_str(&number(at, self.y(stair.after), stair.after));
        let number = index + 1;
        let below = floor + 14.0;
        let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{number}</text>");
        let (label, date) = (&stair.label, day(&stair.date));
        let after = quantity(stair.after, &stair.unit);
        let said = escaped(&format!("{number}  {label} (step {}, {date}): {after}", stair.step));
        let line = floor + 18.0 + LINE * number as f64;
        let _ = writeln!(svg, "<text x=\"{LEFT}\" y=\"{line:.1}\">{said}</text>");
    }

    fn draw(&self, svg: &mut String) {
        let first = self.group[0];
        let title = escaped(&heading(first));
        let _ =
            writeln!(svg, "<text x=\"10\" y=\"{:.1}\" font-weight=\"bold\">{title}</text>", self.top + 22.0);
        let _ = writeln!(
            svg,
            "<path d=\"M{LEFT} {:.1}V{:.1}H{:.1}\" fill=\"none\" stroke=\"#666\"/>",
            self.top + TOP - 8.0,
            self.y(0.0),
            WIDTH - 20.0
        );
        self.noise(svg);
        let mut line = format!("M{:.1} {:.1}H{:.1}", self.x(0), self.y(first.before), self.x(1));
        for (index, stair) in self.group.iter().enumerate() {
            let _ = write!(line, "V{:.1}H{:.1}", self.y(stair.after), self.x(index + 2));
        }
        let _ = writeln!(svg, "<path d=\"{line}\" fill=\"none\" stroke=\"#0057b7\" stroke-width=\"2.5\"/>");
        svg.push_str(&number(self.x(0) + self.wide() / 2.0, self.y(first.before), first.before));
        self.group.iter().enumerate().for_each(|(index, stair)| self.step(svg, index, stair));
    }
}

fn number(x: f64, y: f64, value: f64) -> String {
    format!("<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n", y - 5.0, rounded(value))
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;")
}
