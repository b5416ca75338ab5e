//! The robot from the front and from its right, joints coloured by how much of their torque is unexplained.
use super::px;
use crate::experiments::plotted::Row;
use crate::number::percent;
use crate::report::data::{Bone, Drawing, Hull, Report};
use maud::{Markup, html};

/// Limits between the degrees of [`degree`], as fractions.
const LIMITS: [f64; 5] = [0.02, 0.04, 0.08, 0.15, 0.3];
/// Radius of a joint with nothing unexplained, px; each degree adds [`GROWTH`]. The style sheet repeats both.
const RADIUS: f64 = 10.0;
/// See [`RADIUS`].
const GROWTH: f64 = 0.8;
/// Size of one view, px.
const VIEW: (f64, f64) = (240.0, 400.0);

/// How bad: 0 to 5.
pub(in crate::report) fn degree(unexplained: f64) -> usize {
    LIMITS.iter().filter(|limit| unexplained >= **limit).count()
}

/// From where.
#[derive(Clone, Copy, PartialEq)]
enum View {
    /// The robot's left is right in the picture.
    Front,
    /// Forward is right; what lies further away (left) is drawn a little higher and to the right.
    Right,
}

impl View {
    /// World (m) to right and up (m).
    fn project(self, [x, y, z]: [f64; 3]) -> [f64; 2] {
        match self {
            Self::Front => [y, z],
            Self::Right => [x + 0.45 * y, z + 0.22 * y],
        }
    }
    fn caption(self) -> &'static str {
        match self {
            Self::Front => "from the front",
            Self::Right => "from its right, forward →",
        }
    }
}

/// World to picture of one view.
struct Canvas {
    view: View,
    left: f64,
    scale: f64,
    middle: [f64; 2],
}

impl Canvas {
    fn at(&self, point: [f64; 3]) -> [f64; 2] {
        let [x, y] = self.view.project(point);
        [
            self.left + VIEW.0 / 2.0 + (x - self.middle[0]) * self.scale,
            20.0 + VIEW.1 / 2.0 - (y - self.middle[1]) * self.scale,
        ]
    }
}

/// Both views; the front view alone of what has no depth, the side view alone of what has no width.
pub(in crate::report) fn robot(report: &Report) -> Option<(Markup, (f64, f64))> {
    let drawing = report.drawing.as_ref().filter(|d| !d.joints.is_empty() && finite(d))?;
    let spread = |axis: usize| {
        let range = points(drawing).fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        range.1 - range.0
    };
    let size = spread(0).max(spread(1)).max(spread(2)).max(1e-6);
    let views: &[View] = if spread(1) < 1e-3 * size { &[View::Right] } else { &[View::Front, View::Right] };
    let canvases = canvases(drawing, views);
    let width = VIEW.0 * views.len() as f64;
    let content = html! { @for canvas in &canvases { (picture(report, drawing, canvas)) } };
    Some((content, (width, VIEW.1 + 44.0)))
}

fn points(drawing: &Drawing) -> impl Iterator<Item = [f64; 3]> + '_ {
    let joints = drawing.joints.iter().map(|j| j.position);
    let bones = drawing.bones.iter().flat_map(|b| [b.from, b.to]);
    joints.chain(bones).chain(drawing.hulls.iter().flat_map(|h| h.points.iter().copied()))
}

fn finite(drawing: &Drawing) -> bool {
    points(drawing).flatten().all(f64::is_finite)
}

/// One scale for all views, each centred.
fn canvases(drawing: &Drawing, views: &[View]) -> Vec<Canvas> {
    let mut scale = f64::INFINITY;
    let mut canvases = Vec::new();
    for (i, &view) in views.iter().enumerate() {
        let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
        for point in points(drawing) {
            let p = view.project(point);
            for k in 0..2 {
                (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
            }
        }
        let room = [VIEW.0 - 70.0, VIEW.1 - 40.0];
        for k in 0..2 {
            scale = scale.min(room[k] / (high[k] - low[k]).max(1e-6));
        }
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        canvases.push(Canvas { view, left: VIEW.0 * i as f64, scale: 0.0, middle });
    }
    for canvas in &mut canvases {
        canvas.scale = scale;
    }
    canvases
}

fn picture(report: &Report, drawing: &Drawing, canvas: &Canvas) -> Markup {
    let true_places: Vec<[f64; 2]> = drawing.joints.iter().map(|j| canvas.at(j.position)).collect();
    let places = apart(&true_places, canvas.left);
    let heaviest = drawing.bones.iter().map(|b| b.mass).fold(1e-9, f64::max);
    let mut bones: Vec<&Bone> = drawing.bones.iter().collect();
    // What is far away first: small x from the front, large y from the right.
    let depth = |p: [f64; 3]| if canvas.view == View::Front { p[0] } else { -p[1] };
    bones.sort_by(|a, b| (depth(a.from) + depth(a.to)).total_cmp(&(depth(b.from) + depth(b.to))));
    html! {
        @for hull in &drawing.hulls { (sole(hull, canvas)) }
        @for bone in bones {
            @let (a, b) = (canvas.at(bone.from), canvas.at(bone.to));
            line class="bone" x1=(px(a[0])) y1=(px(a[1])) x2=(px(b[0])) y2=(px(b[1]))
                stroke-width=(px(3.0 + 9.0 * (bone.mass.max(0.0) / heaviest).cbrt())) {}
        }
        @for (from, to) in true_places.iter().zip(&places) {
            line class="leader" x1=(px(from[0])) y1=(px(from[1])) x2=(px(to[0])) y2=(px(to[1])) {}
            circle class="pivot" cx=(px(from[0])) cy=(px(from[1])) r="2" {}
        }
        @for (index, place) in places.iter().enumerate() { (joint(report, drawing, index, *place)) }
        text class="label" x=(px(canvas.left + VIEW.0 / 2.0)) y=(px(VIEW.1 + 36.0)) text-anchor="middle" { (canvas.view.caption()) }
    }
}

/// A joint: a numbered disc that grows with what is unexplained. The page's script makes it a button.
fn joint(report: &Report, drawing: &Drawing, index: usize, place: [f64; 2]) -> Markup {
    let name = &drawing.joints[index].name;
    let row = report.rows.iter().position(|row| row.joint.as_ref() == Some(name));
    let found: Option<&Row> = row.map(|r| &report.rows[r]);
    let share = found.map(|r| r.unexplained_before);
    let after = found.map(|r| degree(r.unexplained_after.unwrap_or(r.unexplained_before)));
    let class = share.map_or_else(|| "joint unmeasured".to_owned(), |s| format!("joint u{}", degree(s)));
    let words = share.map_or_else(|| "not measured".to_owned(), |s| format!("{} unexplained", percent(s)));
    html! {
        g class=(class) data-row=[row] data-before=[share.map(degree)] data-after=[after]
            transform=(format!("translate({} {})", px(place[0]), px(place[1]))) {
            title { (name) ": " (words) }
            circle class="halo" r=(px(RADIUS + 5.0 * GROWTH + 3.0)) {}
            circle class="disc" r=(px(RADIUS + GROWTH * share.map_or(0, degree) as f64)) {}
            text class="number" y="4" text-anchor="middle" { @if let Some(row) = row { (row + 1) } @else { "–" } }
        }
    }
}

/// A part's convex outline.
fn sole(hull: &Hull, canvas: &Canvas) -> Markup {
    let corners = outline(hull.points.iter().map(|p| canvas.at(*p)).collect());
    let path: Vec<String> = corners.iter().map(|p| format!("{},{}", px(p[0]), px(p[1]))).collect();
    html! { polygon class="sole" points=(path.join(" ")) {} }
}

/// Convex hull by Andrew's monotone chain.
pub(in crate::report) fn outline(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn =
        |o: [f64; 2], a: [f64; 2], b: [f64; 2]| (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., o, a] = chain[..]
                && turn(o, a, p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    if lower.is_empty() { points } else { lower }
}

/// Moves discs apart until none hides another: hips have three joints in one place.
fn apart(places: &[[f64; 2]], left: f64) -> Vec<[f64; 2]> {
    let least = 2.0 * (RADIUS + 5.0 * GROWTH);
    let mut moved = places.to_vec();
    for _ in 0..400 {
        let mut still = true;
        for i in 0..moved.len() {
            for j in i + 1..moved.len() {
                let d = [moved[j][0] - moved[i][0], moved[j][1] - moved[i][1]];
                let distance = d[0].hypot(d[1]);
                if distance >= least {
                    continue;
                }
                still = false;
                // Coincident ones part in directions that depend on their numbers alone.
                let angle = 2.4 * (i * 7 + j) as f64;
                let way = if distance > 1e-3 { d.map(|x| x / distance) } else { [angle.cos(), angle.sin()] };
                let push = 0.5 * (least - distance) + 0.05;
                for k in 0..2 {
                    moved[i][k] -= push * way[k];
                    moved[j][k] += push * way[k];
                }
            }
        }
        for place in &mut moved {
            place[0] = place[0].clamp(left + RADIUS + 4.0, left + VIEW.0 - RADIUS - 4.0);
            place[1] = place[1].clamp(RADIUS + 4.0, VIEW.1 + 12.0);
        }
        if still {
            break;
        }
    }
    moved
}

/// The robot with a list of its joints: a picture that stands alone.
pub(in crate::report) fn named_robot(report: &Report) -> Option<(Markup, (f64, f64))> {
    let (picture, (width, height)) = robot(report)?;
    let measured = report.rows.iter().enumerate().filter(|(_, row)| row.joint.is_some());
    let line = |index: usize| 26.0 + 22.0 * index as f64;
    let lines = measured.clone().count();
    let content = html! {
        (picture)
        text class="tick" x=(px(width + 10.0)) y="14" { "unexplained share of the measured torque" }
        @for (k, (index, row)) in measured.enumerate() {
            g class=(format!("joint u{}", degree(row.unexplained_before))) transform=(format!("translate({} {})", px(width + 20.0), px(line(k) + 8.0))) {
                circle class="disc" r="9" {}
                text class="number" y="4" text-anchor="middle" { (index + 1) }
                text class="label" x="16" y="4" { (row.name) }
                text class="value" x="250" y="4" text-anchor="end" { (percent(row.unexplained_before)) }
            }
        }
    };
    Some((content, (width + 290.0, height.max(line(lines) + 10.0))))
}

/// What the colours mean.
pub(in crate::report) fn legend() -> Markup {
    let edges: Vec<String> = LIMITS.iter().map(|l| format!("{:.0}", 100.0 * l)).collect();
    let words = |k: usize| match k {
        0 => format!("below {} %", edges[0]),
        5 => format!("above {} %", edges[4]),
        _ => format!("{}–{} %", edges[k - 1], edges[k]),
    };
    html! {
        @for k in 0..=LIMITS.len() { span class=(format!("key u{k}")) { span class="swatch" aria-hidden="true" {} (words(k)) } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_part() {
        let moved = apart(&[[100.0, 100.0]; 6], 0.0);
        for (i, a) in moved.iter().enumerate() {
            for b in &moved[..i] {
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) > 2.0 * RADIUS, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn outlines_are_convex_and_degrees_grow() {
        let square = vec![[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(outline(square).len(), 4);
        assert_eq!([0.0, 0.02, 0.2, 9.0].map(degree), [0, 1, 4, 5]);
    }
}
