//! Survival as a picture: a dot with its interval for each disturbance, with fixed and with chosen parameters.
use super::{Robust, Survival};
use std::fmt::Write;

/// Of the picture, in its own units.
const WIDTH: f64 = 720.0;
const LEFT: f64 = 170.0;
const RIGHT: f64 = 690.0;
const ROW: f64 = 46.0;
const TOP: f64 = 70.0;
/// Fixed, chosen.
const COLOURS: [&str; 2] = ["#8a8f98", "#0b6e99"];

impl Robust {
    /// The picture.
    pub fn svg(&self) -> String {
        let height = TOP + ROW * self.tried.len() as f64 + 50.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <text x=\"16\" y=\"26\" font-size=\"16\">{}: walks of {} steps that succeed, 95 % intervals</text>\n",
            escaped(&self.robot),
            self.steps
        );
        for (index, words) in ["fixed parameters", "chosen anew at mid-stance"].iter().enumerate() {
            let x = LEFT + 190.0 * index as f64;
            // Writing to a string cannot fail.
            let _ = writeln!(
                svg,
                "<circle cx=\"{x}\" cy=\"46\" r=\"5\" fill=\"{}\"/><text x=\"{}\" y=\"50\">{words}</text>",
                COLOURS[index],
                x + 10.0
            );
        }
        let bottom = TOP + ROW * self.tried.len() as f64;
        for k in 0..=5 {
            let x = place(0.2 * f64::from(k));
            let _ = writeln!(
                svg,
                "<line x1=\"{x}\" x2=\"{x}\" y1=\"{TOP}\" y2=\"{bottom}\" stroke=\"#dddddd\"/>\
                 <text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{} %</text>",
                bottom + 20.0,
                20 * k
            );
        }
        for (index, tried) in self.tried.iter().enumerate() {
            let y = TOP + ROW * (index as f64 + 0.5);
            let kind = tried.disturbance.kind;
            let words = format!("{} {} {}", kind.name(), tried.disturbance.size, kind.unit());
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{words}</text>",
                LEFT - 14.0,
                y + 4.0
            );
            svg.push_str(&whisker(&tried.fixed, y - 7.0, COLOURS[0]));
            svg.push_str(&whisker(&tried.chosen, y + 7.0, COLOURS[1]));
        }
        svg.push_str("</svg>\n");
        svg
    }
}

fn place(rate: f64) -> f64 {
    LEFT + (RIGHT - LEFT) * rate
}

fn whisker(survival: &Survival, y: f64, colour: &str) -> String {
    let [low, high] = survival.interval.map(place);
    let dot = place(if survival.rate.is_finite() { survival.rate } else { 0.0 });
    format!(
        "<line x1=\"{low:.2}\" x2=\"{high:.2}\" y1=\"{y}\" y2=\"{y}\" stroke=\"{colour}\" stroke-width=\"2.5\"/>\
         <circle cx=\"{dot:.2}\" cy=\"{y}\" r=\"5\" fill=\"{colour}\"/>\n"
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
