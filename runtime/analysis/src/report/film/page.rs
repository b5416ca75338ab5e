//! The film's page.
use super::data::Film;
use super::payload;
use super::strobe::{self, View};
use crate::report::causes::coded;
use crate::report::page::{PageParts, document};
use maud::{Markup, PreEscaped, html};

const STYLE: &str = include_str!("../assets/film.css");
const VIEWS: &str = include_str!("../assets/views.js");
const PLAYER: &str = include_str!("../assets/film.js");

/// The page as one HTML document, below [`crate::report::LARGEST_PAGE`] bytes.
pub fn render(film: &Film) -> String {
    let content = html! {
        (text(film))
        (stage(film))
        (pictures(film))
        (plots(film))
        (glance(film))
        (basis(film))
    };
    let scripts = [VIEWS, PLAYER].concat();
    let parts = PageParts { content, numbers: payload::json(film), style: STYLE, scripts: &scripts };
    document(&film.title, &film.robot, parts)
}

fn text(film: &Film) -> Markup {
    html! {
        section.summary aria-label="Summary" {
            @for paragraph in film.summary.split("\n\n").map(str::trim).filter(|p| !p.is_empty()) { p { (coded(paragraph)) } }
            @if !film.warnings.is_empty() {
                div.warnings { h3 { "Warnings" } ul { @for warning in &film.warnings { li { (coded(warning)) } } } }
            }
        }
    }
}

/// The views and what plays them; the script draws.
fn stage(film: &Film) -> Markup {
    if film.frames.is_empty() {
        return html! {};
    }
    let view = |id: &str, words: &str, hint: &str| {
        html! { figure { canvas id=(id) role="img" aria-label=(format!("{}, {words}", film.robot)) {} figcaption { (words) (hint) } } }
    };
    let tool = |action: &str, sign: &str, words: &str| {
        html! { button type="button" data-film=(action) aria-label=(words) title=(words) { (sign) } }
    };
    let touching = !film.feet.is_empty();
    let balanced = film.frames.iter().any(|frame| frame.balance.is_some());
    html! {
        section #film aria-labelledby="motion" {
            h2 #motion { "The motion" }
            div.views {
                (view("side", "from its right, forward →", ""))
                (view("front", "from the front", ""))
                (view("solid", "in space", ": drag to turn"))
                (view("above", "from above, forward →", ""))
            }
            p.signs {
                span { b.left { "■" } " left leg" } span { b.right { "■" } " right leg" }
                @if touching {
                    span { b.force-sign { "↑" } " force of the ground (a tick on the arrow: shortened)" }
                    span { b.polygon { "▱" } " support polygon" }
                    span { b.mark { "✚" } " centre of pressure = ZMP" }
                }
                @if balanced {
                    span { b.amended { "◆" } " divergent component, " b.amended { "◇" } " as it is wished" }
                    span { b.mark { "□" } " zero moment point that is asked for" }
                    span { "▭ where feet stood" }
                }
                span { b.ink { "◉" } " centre of mass" @if touching { ", ◯ below it on the ground" } @else { " of the links that move" } }
            }
            @if balanced { p #limits aria-live="off" {} }
            div.player {
                div.tools role="toolbar" aria-label="Player" {
                    button #play type="button" aria-keyshortcuts="Space" { "▶ play" }
                    (tool("back", "◂", "one frame back")) (tool("on", "▸", "one frame on"))
                    label { "speed " select #speed aria-label="Speed" {
                        @for (value, name) in SPEEDS { option value=(value) selected[value == "1"] { (name) } }
                    } }
                    output #now for="scrub" aria-live="off" {}
                    span.hint { "keys: space, ← → (Shift: ten), Home, End, < >" }
                }
                @if touching { canvas #strip role="img" aria-label="Which feet are loaded, over time" {} }
                input #scrub type="range" min="0" value="0" step="any" aria-label="Time";
            }
            noscript { p { "The film needs JavaScript; the picture below shows the motion without it." } }
        }
    }
}

fn pictures(film: &Film) -> Markup {
    html! {
        @for picture in &film.pictures {
            section aria-label=(picture.title) {
                h2 { (picture.title) }
                figure.strobe { (PreEscaped(&picture.svg)) }
                p.hint { (picture.caption) }
            }
        }
    }
}

/// Factors of real time.
const SPEEDS: [(&str, &str); 7] = [
    ("0.02", "1/50"),
    ("0.05", "1/20"),
    ("0.1", "1/10"),
    ("0.25", "1/4"),
    ("0.5", "1/2"),
    ("1", "real time"),
    ("2", "2 ×"),
];

fn plots(film: &Film) -> Markup {
    if film.time.len() < 2 || film.plots.is_empty() {
        return html! {};
    }
    let mut joints: Vec<&str> = film.plots.iter().filter_map(|plot| plot.joint.as_deref()).collect();
    joints.dedup();
    html! {
        section aria-labelledby="over-time" {
            h2 #over-time { "Over time" }
            p.hint { "Click into a plot to go there; drag to zoom, double click for all of it." }
            @if !joints.is_empty() {
                div #joints .joints role="group" aria-label="Joints that are plotted" {
                    @for (k, joint) in joints.iter().enumerate() {
                        label { input type="checkbox" value=(joint) checked[k == 0]; " " (joint) }
                    }
                }
            }
            div #film-plots {}
        }
    }
}

/// The stroboscopic picture.
fn glance(film: &Film) -> Markup {
    let Some((picture, (width, height))) = strobe::picture(film, View::Side) else { return html! {} };
    let apart = strobe::moved_apart(film, View::Side);
    html! {
        section aria-labelledby="glance" {
            h2 #glance { "At a glance" }
            figure.strobe {
                svg viewBox=(format!("0 0 {width} {height}")) role="img" aria-label="The robot at equal distances of time, from its right" { (picture) }
            }
            p.hint { "From its right, forward →, at equal distances of time. " @if apart { "Poses are moved apart. " }
                "Dotted: the centre of mass." @if !film.feet.is_empty() { " Arrows: the force of the ground on each foot." } }
        }
    }
}

fn basis(film: &Film) -> Markup {
    if film.facts.is_empty() {
        return html! {};
    }
    html! {
        section aria-labelledby="basis" {
            h2 #basis { "What this rests on" }
            dl.facts { @for fact in &film.facts { div { dt { (fact.name) } dd { (fact.value) } } } }
        }
    }
}
