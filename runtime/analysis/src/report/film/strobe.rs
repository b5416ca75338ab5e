//! The robot at equal distances of time in one picture.
use super::data::{Film, FilmPart, Form, Frame};
use super::payload::side_name;
use crate::number::significant;
use crate::report::svg::{outline, px};
use maud::{Markup, html};

/// Poses of a picture.
const POSES: usize = 9;
/// Height of the drawn space, px.
const HEIGHT: f64 = 300.0;
/// Widest picture, px.
const WIDTH: f64 = 1400.0;
/// Room around it, px.
const MARGIN: f64 = 26.0;
/// Length of an arrow of the robot's weight, as a part of the height of what is drawn.
const ARROW: f64 = 0.35;
/// Length of the longest arrow, as a part of that height.
const LONGEST: f64 = 0.9;
/// Part of the weight below which no force is drawn.
const LEAST: f64 = 0.02;

/// From where.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum View {
    /// From the robot's right: forward is right.
    Side,
    /// The robot's left is right in the picture.
    Front,
}

impl View {
    pub fn name(self) -> &'static str {
        match self {
            Self::Side => "side",
            Self::Front => "front",
        }
    }
    /// World (m) to right and up (m).
    fn project(self, p: [f64; 3]) -> [f64; 2] {
        [if self == Self::Side { p[0] } else { p[1] }, p[2]]
    }
    /// Larger is nearer.
    fn depth(self, p: [f64; 3]) -> f64 {
        if self == Self::Side { -p[1] } else { p[0] }
    }
}

/// Where poses stand in the picture.
struct Layout {
    view: View,
    scale: f64,
    /// Right edge and left edge of the drawn space, lowest and highest point, m.
    low: [f64; 2],
    high: [f64; 2],
    /// By which each pose is moved to the right of the one before it, m; 0: all stand where they were.
    shift: f64,
}

impl Layout {
    fn at(&self, index: usize, point: [f64; 3]) -> [f64; 2] {
        let [x, z] = self.view.project(point);
        let x = x + self.shift * index as f64;
        [MARGIN + (x - self.low[0]) * self.scale, MARGIN + (self.high[1] - z) * self.scale]
    }
}

/// The picture and its size, px; `None` without frames or parts.
pub(super) fn picture(film: &Film, view: View) -> Option<(Markup, (f64, f64))> {
    let frames = chosen(film);
    let layout = layout(film, &frames, view)?;
    let size = [0, 1].map(|k| 2.0 * MARGIN + (layout.high[k] - layout.low[k]) * layout.scale);
    let ground = layout.at(0, [0.0; 3])[1];
    let path: Vec<String> = frames
        .iter()
        .enumerate()
        .map(|(i, frame)| layout.at(i, frame.center_of_mass))
        .filter(|p| p.iter().all(|x| x.is_finite()))
        .map(|p| format!("{},{}", px(p[0]), px(p[1])))
        .collect();
    let content = html! {
        // A robot on a stand has no ground.
        @if !film.feet.is_empty() { line class="ground-line" x1="0" x2=(px(size[0])) y1=(px(ground)) y2=(px(ground)) {} }
        @for (i, frame) in frames.iter().enumerate() {
            g.pose { (pose(film, frame, &layout, i)) }
        }
        polyline class="center-path" points=(path.join(" ")) {}
        @for (i, frame) in frames.iter().enumerate() { (time(frame, &layout, i, size[1])) }
    };
    Some((content, (size[0], size[1] + 34.0)))
}

/// At equal distances of time, first and last among them.
fn chosen(film: &Film) -> Vec<&Frame> {
    let finite = |f: &&Frame| f.poses.iter().all(|p| p.position.iter().all(|x| x.is_finite()));
    let frames: Vec<&Frame> = film.frames.iter().filter(finite).collect();
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return Vec::new() };
    let count = POSES.min(frames.len());
    let wanted = |k: usize| first.time + (last.time - first.time) * k as f64 / (count - 1).max(1) as f64;
    let nearest = |t: f64| {
        frames
            .iter()
            .copied()
            .min_by(|a, b| (a.time - t).abs().total_cmp(&(b.time - t).abs()))
            .unwrap_or(first)
    };
    (0..count).map(|k| nearest(wanted(k))).collect()
}

fn corners<'a>(film: &'a Film, frame: &'a Frame) -> impl Iterator<Item = [f64; 3]> + 'a {
    film.parts.iter().flat_map(|part| part.form.corners().iter().map(|c| frame.at(part.body, *c)))
}

/// Poses that hide each other are moved apart.
fn layout(film: &Film, frames: &[&Frame], view: View) -> Option<Layout> {
    let mut widest = 0.0f64;
    let (mut low, mut high) = ([f64::MAX, 0.0], [f64::MIN, 0.1]);
    let mut spans = Vec::new();
    for frame in frames {
        let points: Vec<[f64; 2]> = corners(film, frame).map(|p| view.project(p)).collect();
        let span = points.iter().fold([f64::MAX, f64::MIN], |s, p| [s[0].min(p[0]), s[1].max(p[0])]);
        widest = widest.max(span[1] - span[0]);
        spans.push(span);
        for p in points {
            (low[1], high[1]) = (low[1].min(p[1]), high[1].max(p[1]));
        }
    }
    let (first, last) = (spans.first()?, spans.last()?);
    if !(widest.is_finite() && high[1].is_finite() && low[1].is_finite()) || film.parts.is_empty() {
        return None;
    }
    let steps = (spans.len() - 1).max(1) as f64;
    let travel = (last[0] + last[1] - first[0] - first[1]) / 2.0;
    // Walking backwards, poses are not moved against the walk: they overlap then.
    let shift =
        if travel.abs() > 0.4 * widest * steps { 0.0 } else { (1.08 * widest - travel / steps).max(0.0) };
    for (i, span) in spans.iter().enumerate() {
        let moved = span.map(|x| x + shift * i as f64);
        (low[0], high[0]) = (low[0].min(moved[0]), high[0].max(moved[1]));
    }
    let room = |k: usize| (high[k] - low[k]).max(1e-3);
    let scale = (HEIGHT / room(1)).min((WIDTH - 2.0 * MARGIN) / room(0));
    Some(Layout { view, scale, low, high, shift })
}

/// Parts from far to near, then forces and the centre of mass.
fn pose(film: &Film, frame: &Frame, layout: &Layout, index: usize) -> Markup {
    let depth = |part: &&FilmPart| {
        let corners = part.form.corners();
        let sum: f64 = corners.iter().map(|c| layout.view.depth(frame.at(part.body, *c))).sum();
        sum / corners.len().max(1) as f64
    };
    let mut parts: Vec<&FilmPart> = film.parts.iter().collect();
    parts.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    let place = |part: &FilmPart, corner: [f64; 3]| layout.at(index, frame.at(part.body, corner));
    let center = layout.at(index, frame.center_of_mass);
    html! {
        @for part in parts {
            @let class = format!("part {}", side_name(part.side));
            @match &part.form {
                Form::Solid { corners, .. } => polygon class=(class) points=(list(outline(corners.iter().map(|c| place(part, *c)).collect()))) {},
                Form::Bone { ends, width } => line class=(format!("{class} bone-line")) x1=(px(place(part, ends[0])[0])) y1=(px(place(part, ends[0])[1]))
                    x2=(px(place(part, ends[1])[0])) y2=(px(place(part, ends[1])[1])) stroke-width=(px((width * layout.scale).max(1.5))) {},
            }
        }
        (forces(film, frame, layout, index))
        @if center.iter().all(|x| x.is_finite()) { circle class="center" cx=(px(center[0])) cy=(px(center[1])) r="3.5" {} }
    }
}

fn list(points: Vec<[f64; 2]>) -> String {
    let words: Vec<String> = points.iter().map(|p| format!("{},{}", px(p[0]), px(p[1]))).collect();
    words.join(" ")
}

/// The ground's force on each foot, at its centre of pressure.
fn forces(film: &Film, frame: &Frame, layout: &Layout, index: usize) -> Markup {
    let size = ARROW * (layout.high[1] - layout.low[1]) / film.weight.max(1e-9);
    let arrows = (0..film.feet.len()).filter_map(|foot| {
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for (point, own) in film.points.iter().zip(&frame.forces).filter(|(point, _)| point.foot == foot) {
            let place = frame.at(point.body, point.place);
            force = [0, 1, 2].map(|k| force[k] + own[k]);
            moment = [0, 1, 2].map(|k| moment[k] + own[2] * place[k]);
        }
        if force[2].is_nan() || force[2] <= LEAST * film.weight {
            return None;
        }
        let from = moment.map(|m| m / force[2]);
        // An impact would leave the picture.
        let length = force.iter().map(|x| x * x).sum::<f64>().sqrt() * size;
        let shorter = (LONGEST * (layout.high[1] - layout.low[1]) / length).min(1.0) * size;
        let to = [0, 1, 2].map(|k| from[k] + shorter * force[k]);
        Some((layout.at(index, from), layout.at(index, to)))
    });
    html! { @for (from, to) in arrows { (arrow(from, to)) } }
}

fn arrow(from: [f64; 2], to: [f64; 2]) -> Markup {
    let d = [to[0] - from[0], to[1] - from[1]];
    let length = d[0].hypot(d[1]).max(1e-9);
    let (e, head) = (d.map(|x| x / length), 7.0f64.min(length));
    let neck = [0, 1].map(|k| to[k] - head * e[k]);
    let side = |sign: f64| [neck[0] - sign * 0.45 * head * e[1], neck[1] + sign * 0.45 * head * e[0]];
    html! {
        line class="force" x1=(px(from[0])) y1=(px(from[1])) x2=(px(neck[0])) y2=(px(neck[1])) {}
        polygon class="force-head" points=(list(vec![to, side(1.0), side(-1.0)])) {}
    }
}

fn time(frame: &Frame, layout: &Layout, index: usize, bottom: f64) -> Markup {
    let middle = frame.poses.first().map_or([0.0; 3], |pose| pose.position);
    let middle = if frame.center_of_mass[0].is_finite() { frame.center_of_mass } else { middle };
    let x = layout.at(index, middle)[0];
    html! { text class="label" x=(px(x)) y=(px(bottom + 12.0)) text-anchor="middle" { (significant(frame.time, 3)) "\u{a0}s" } }
}

/// Whether poses were moved apart.
pub(super) fn moved_apart(film: &Film, view: View) -> bool {
    layout(film, &chosen(film), view).is_some_and(|layout| layout.shift > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::film::data::{FilmFoot, FilmPoint, Pose};

    /// A cube of 20 cm that slides forward.
    pub(super) fn slide(speed: f64) -> Film {
        let corner = |bit: usize| [0, 1, 2].map(|k| if bit >> k & 1 == 1 { 0.1 } else { -0.1 });
        let form = Form::Solid { corners: (0..8).map(corner).collect(), faces: Vec::new() };
        let frame = |i: i32| Frame {
            time: 0.1 * f64::from(i),
            poses: vec![Pose {
                position: [speed * 0.1 * f64::from(i), 0.0, 0.1],
                orientation: [0.0, 0.0, 0.0, 1.0],
            }],
            forces: vec![[0.0, 0.0, 10.0]],
            ..Frame::default()
        };
        Film {
            weight: 10.0,
            feet: vec![FilmFoot { name: "sole".to_owned(), side: None }],
            points: vec![FilmPoint { foot: 0, body: Some(0), place: [0.0, 0.0, -0.1] }],
            parts: vec![FilmPart { body: Some(0), side: None, form }],
            frames: (0..=16).map(frame).collect(),
            ..Film::default()
        }
    }

    #[test]
    fn poses_stand_where_they_were_or_are_moved_apart() {
        // 0.2 s between poses.
        for (speed, apart) in [(0.0, true), (0.1, true), (2.0, false), (-2.0, false)] {
            let film = slide(speed);
            assert_eq!(moved_apart(&film, View::Side), apart, "{speed}");
            assert!(moved_apart(&film, View::Front));
            let (picture, size) = picture(&film, View::Side).unwrap();
            assert!(size.0 <= WIDTH + 1.0 && size.1 < HEIGHT + 100.0);
            let text = picture.into_string();
            assert_eq!(text.matches("<polygon class=\"part").count(), POSES, "{speed}");
            assert_eq!(text.matches("<polygon class=\"force-head").count(), POSES, "{speed}");
        }
        assert!(picture(&Film::default(), View::Side).is_none());
    }
}
