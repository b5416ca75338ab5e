//! What the page's script plays, as JSON: frames as whole numbers, plots thinned.
use super::data::{Film, Form, Frame, Plot};
use crate::report::payload::{harmless, rounded};
use crate::report::thin::thin;
use crate::robot::Side;
use serde::Serialize;

/// Frames per metre of resolution: tenths of millimetres.
const PER_METRE: f64 = 1e4;
/// Quaternions are whole numbers of this fraction.
const PER_UNIT: f64 = 1e4;
/// Forces are tenths of newtons.
const PER_NEWTON: f64 = 10.0;
/// Bytes of all frames together.
const MOST_FRAME_BYTES: usize = 2_300_000;
/// Bytes of all plots together.
const MOST_PLOT_BYTES: usize = 1_700_000;
/// Most samples of a plot; more cannot be seen.
const MOST_SAMPLES: usize = 3000;
/// Fewest, however many plots there are.
const FEWEST_SAMPLES: usize = 40;
/// Bytes of one number of a plot, about.
const BYTES: usize = 8;
/// Part of the weight above which a foot counts as loaded.
pub(super) const LOADED: f64 = 0.01;
/// Part of the time below which an interruption of the load is not seen.
const BLINK: f64 = 1.0 / 4000.0;

#[derive(Serialize)]
struct Payload<'a> {
    per_metre: f64,
    per_unit: f64,
    per_newton: f64,
    weight: f64,
    feet: Vec<PlayedFoot<'a>>,
    points: Vec<PlayedPoint>,
    parts: Vec<PlayedPart>,
    times: Vec<f64>,
    /// Seven numbers per body: position, quaternion.
    poses: Vec<Vec<i64>>,
    /// Three per contact point.
    forces: Vec<Vec<i64>>,
    centers: Vec<Vec<i64>>,
    /// Centres of pressure; empty in the air.
    pressures: Vec<Vec<i64>>,
    /// Divergent component, as it is wished, zero moment point that is asked for; nothing at all where no controller tells.
    balance: Vec<Vec<i64>>,
    /// What the controller does and what limits it: places in `words`.
    said: Vec<Vec<usize>>,
    words: Vec<&'a str>,
    plots: Vec<Plotted<'a>>,
}

#[derive(Serialize)]
struct PlayedFoot<'a> {
    name: &'a str,
    side: &'static str,
    /// Stretches of time in which it is loaded, s.
    loaded: Vec<[f64; 2]>,
}

#[derive(Serialize)]
struct PlayedPoint {
    foot: usize,
    body: Option<usize>,
    place: [f64; 3],
}

#[derive(Serialize)]
struct PlayedPart {
    body: Option<usize>,
    side: &'static str,
    corners: Vec<[f64; 3]>,
    /// None: a line.
    faces: Vec<Vec<usize>>,
    width: f64,
}

#[derive(Serialize)]
struct Plotted<'a> {
    title: &'a str,
    joint: Option<&'a str>,
    unit: &'a str,
    names: Vec<&'a str>,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
}

/// JSON that may stand inside a `<script>` element.
pub(super) fn json(film: &Film) -> String {
    let numbers: usize = film.plots.iter().map(|plot| 1 + plot.curves.len()).sum();
    let most = (MOST_PLOT_BYTES / BYTES / numbers.max(1)).clamp(FEWEST_SAMPLES, MOST_SAMPLES);
    let frames = shown(film);
    let (said, words) = said(&frames);
    let payload = Payload {
        per_metre: PER_METRE,
        per_unit: PER_UNIT,
        per_newton: PER_NEWTON,
        weight: if film.weight > 0.0 { film.weight } else { 1.0 },
        feet: feet(film),
        points: film
            .points
            .iter()
            .map(|p| PlayedPoint { foot: p.foot, body: p.body, place: p.place.map(short) })
            .collect(),
        parts: film.parts.iter().map(|part| played(part.body, part.side, &part.form)).collect(),
        times: frames.iter().map(|frame| (frame.time * 1e5).round() / 1e5).collect(),
        poses: frames.iter().map(|frame| poses(frame)).collect(),
        forces: frames
            .iter()
            .map(|f| f.forces.iter().flatten().map(|x| whole(x * PER_NEWTON)).collect())
            .collect(),
        centers: frames
            .iter()
            .map(|f| f.center_of_mass.iter().map(|x| whole(x * PER_METRE)).collect())
            .collect(),
        pressures: frames
            .iter()
            .map(|f| f.center_of_pressure.iter().flatten().map(|x| whole(x * PER_METRE)).collect())
            .collect(),
        balance: frames.iter().filter(|_| !words.is_empty()).map(|frame| balance(frame)).collect(),
        said,
        words,
        plots: film.plots.iter().map(|plot| plotted(plot, &film.time, most)).collect(),
    };
    // Text and finite or null numbers: nothing that JSON could refuse.
    harmless(&serde_json::to_string(&payload).unwrap_or_else(|_| "{}".to_owned()))
}

fn balance(frame: &Frame) -> Vec<i64> {
    let points = frame.balance.iter().flat_map(|b| b.divergent.into_iter().chain([b.zero_moment_point]));
    points.flatten().map(|x| whole(x * PER_METRE)).collect()
}

/// What controllers say in each frame as places among different words; nothing where none says anything.
fn said<'a>(frames: &[&'a Frame]) -> (Vec<Vec<usize>>, Vec<&'a str>) {
    let mut words: Vec<&str> = Vec::new();
    let mut place = |said: &'a String| {
        words.iter().position(|word| word == said).unwrap_or_else(|| {
            words.push(said);
            words.len() - 1
        })
    };
    let of = |frame: &&'a Frame| {
        let all = frame.balance.iter().flat_map(|b| std::iter::once(&b.phase).chain(&b.limits));
        all.map(&mut place).collect::<Vec<_>>()
    };
    let said: Vec<_> = frames.iter().map(of).collect();
    (if words.is_empty() { Vec::new() } else { said }, words)
}

fn poses(frame: &Frame) -> Vec<i64> {
    let of = |pose: &super::data::Pose| {
        let place = pose.position.map(|x| whole(x * PER_METRE));
        let turn = pose.orientation.map(|x| whole(x * PER_UNIT));
        place.into_iter().chain(turn)
    };
    frame.poses.iter().flat_map(of).collect()
}

/// Every n-th frame, so that they fit; all of them finite.
fn shown(film: &Film) -> Vec<&Frame> {
    let finite =
        |f: &&Frame| f.poses.iter().all(|p| p.position.iter().chain(&p.orientation).all(|x| x.is_finite()));
    let frames: Vec<&Frame> = film.frames.iter().filter(finite).collect();
    let Some(first) = frames.first() else { return frames };
    // A position has about five digits, sign and comma included six characters.
    let balance = if first.balance.is_some() { 10 } else { 0 };
    let each = 6 * (7 * first.poses.len() + 3 * first.forces.len() + 5 + balance) + 10;
    let every = (frames.len() * each).div_ceil(MOST_FRAME_BYTES).max(1);
    frames.into_iter().step_by(every).collect()
}

fn whole(x: f64) -> i64 {
    x.round() as i64
}

/// A length of a shape with a hundredth of a millimetre.
fn short(x: f64) -> f64 {
    (x * 1e5).round() / 1e5
}

pub(super) fn side_name(side: Option<Side>) -> &'static str {
    match side {
        Some(Side::Left) => "left",
        Some(Side::Right) => "right",
        None => "middle",
    }
}

fn played(body: Option<usize>, side: Option<Side>, form: &Form) -> PlayedPart {
    let corners = form.corners().iter().map(|corner| corner.map(short)).collect();
    let (faces, width) = match form {
        Form::Solid { faces, .. } => (faces.clone(), 0.0),
        Form::Bone { width, .. } => (Vec::new(), *width),
    };
    PlayedPart { body, side: side_name(side), corners, faces, width }
}

fn feet(film: &Film) -> Vec<PlayedFoot<'_>> {
    let feet = film.feet.iter().enumerate();
    feet.map(|(index, foot)| PlayedFoot {
        name: &foot.name,
        side: side_name(foot.side),
        loaded: film
            .loads
            .get(index)
            .map_or(Vec::new(), |loads| loaded(&film.time, loads, LOADED * film.weight)),
    })
    .collect()
}

/// Stretches of time in which the load is above a limit.
fn loaded(time: &[f64], load: &[f64], limit: f64) -> Vec<[f64; 2]> {
    let blink = BLINK * time.last().copied().unwrap_or(0.0);
    let mut stretches: Vec<[f64; 2]> = Vec::new();
    for (i, &t) in time.iter().enumerate().take(load.len()).filter(|(i, _)| load[*i] > limit) {
        let until = time.get(i + 1).copied().unwrap_or(t);
        match stretches.last_mut() {
            Some(last) if t <= last[1] + blink => last[1] = until,
            _ => stretches.push([t, until]),
        }
    }
    stretches.iter().map(|s| s.map(|t| (t * 1e5).round() / 1e5)).collect()
}

fn plotted<'a>(plot: &'a Plot, time: &[f64], most: usize) -> Plotted<'a> {
    let tracks: Vec<Vec<f64>> = plot.curves.iter().map(|curve| curve.values.clone()).collect();
    let count = tracks.iter().map(Vec::len).chain([time.len()]).min().unwrap_or(0);
    let kept = thin(count, &tracks, most).kept;
    let pick = |values: &[f64], digits| rounded(kept.iter().map(|&i| values[i]).collect(), digits);
    Plotted {
        title: &plot.title,
        joint: plot.joint.as_deref(),
        unit: &plot.unit,
        names: plot.curves.iter().map(|curve| curve.name.as_str()).collect(),
        time: pick(time, 7),
        values: tracks.iter().map(|values| pick(values, 5)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::film::data::{Curve, Pose};

    #[test]
    fn loads_become_stretches() {
        let time: Vec<f64> = (0..10).map(f64::from).collect();
        let load = [0.0, 5.0, 5.0, 0.0, 0.0, 5.0, 0.5, 0.0, 5.0, 5.0];
        assert_eq!(loaded(&time, &load, 1.0), [[1.0, 3.0], [5.0, 6.0], [8.0, 9.0]]);
    }

    #[test]
    fn long_films_fit() {
        let pose = Pose { position: [-1.23456; 3], orientation: [-0.5; 4] };
        let frames = (0..3000).map(|i| Frame {
            time: 0.2 * f64::from(i),
            poses: vec![pose; 30],
            forces: vec![[-123.4; 3]; 16],
            ..Frame::default()
        });
        let time: Vec<f64> = (0..40_000).map(|i| 0.001 * f64::from(i)).collect();
        let wave: Vec<f64> = time.iter().map(|t| t.sin() * 3.3).collect();
        let curve = |name: &str| Curve { name: name.to_owned(), values: wave.clone() };
        let plot =
            Plot { title: "</script>".to_owned(), curves: vec![curve("a"), curve("b")], ..Plot::default() };
        let film = Film { frames: frames.collect(), time, plots: vec![plot; 60], ..Film::default() };
        let text = json(&film);
        assert!(text.len() < MOST_FRAME_BYTES + MOST_PLOT_BYTES + 200_000, "{}", text.len());
        assert!(text.len() > 2_000_000, "{}", text.len());
        assert!(!text.contains('<'));
    }
}
