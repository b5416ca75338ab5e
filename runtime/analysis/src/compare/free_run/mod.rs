//! Free-running prediction: from a measured state the model is integrated ahead under the logged efforts, and the joint
//! positions at which it arrives are held against the measured ones.
//!
//! Errors of inverse dynamics are torques at measured motions; those of a free run add up in time, as they would in a
//! simulation or in a controller that looks ahead. Windows follow one another without overlap, each starts at the
//! measured state, and none crosses a gap of the log.
mod input;
mod report;
mod window;

use crate::measure::Recording;
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect, Law};
use bipedc_runtime::model::Model;
use input::Input;
use report::Sums;
pub use report::{FreeChannel, FreeRun};
use std::ops::Range;
use window::{Outcome, Window};

/// Samples that a window has at least.
pub const FEWEST_SAMPLES: usize = 10;
/// Windows that are integrated at most; of more, this many are taken evenly from the whole log.
pub const MOST_WINDOWS: usize = 1000;

/// Integrates windows of `seconds` and compares positions.
///
/// `model` is the robot on a fixed base, its `forward_dynamics` with the `effects` of the description compiled in;
/// `recording` has position and effort of all its joints. `progress` is told which fraction is done.
///
/// # Errors
/// A length without meaning, shorter than [`FEWEST_SAMPLES`] or longer than all stretches of the log; a joint without an
/// effort; a model without `forward_dynamics` or with other joints.
pub fn free_run(
    model: &dyn Model<f64>,
    layout: &JointLayout,
    recording: &Recording,
    effects: &[Effect],
    seconds: f64,
    progress: &dyn Fn(f64),
) -> Result<FreeRun, Diagnostic> {
    let function = check(model, layout, recording)?;
    let delays = delays(layout, effects);
    let all = windows(recording, seconds, delays.iter().fold(0.0, |most: f64, d| d.max(most)))?;
    // A stretch that is too short for a spline has no window either.
    let inputs: Vec<Option<Input>> =
        recording.segments.iter().map(|segment| Input::new(recording, segment.clone(), &delays)).collect();
    let mut sums = vec![Sums::default(); layout.joints.len()];
    let (mut diverged, mut capped) = (0, 0);
    let taken = spread(&all);
    for (done, place) in taken.iter().enumerate() {
        let too_short = || Diagnostic::error("a stretch of the log has fewer than 8 samples");
        let input = inputs[place.segment].as_ref().ok_or_else(too_short)?;
        let range = place.range.clone();
        let window = Window { model, function, layout, recording, input, range };
        match window.run()? {
            Outcome::Arrived(predicted) => add(&mut sums, recording, &place.range, &predicted),
            Outcome::Diverged => diverged += 1,
            Outcome::Capped => capped += 1,
        }
        progress((done + 1) as f64 / taken.len() as f64);
    }
    let mut assumptions = assumed(effects);
    if taken.len() < all.len() {
        let (some, all) = (taken.len(), all.len());
        assumptions.push(format!("{some} of the log's {all} windows were integrated, evenly spread"));
    }
    Ok(FreeRun::new(layout, &sums, [taken.len(), diverged, capped], seconds, assumptions))
}

/// The model's `forward_dynamics`, if everything fits.
fn check(model: &dyn Model<f64>, layout: &JointLayout, recording: &Recording) -> Result<usize, Diagnostic> {
    let joints = layout.joints.len();
    if (model.nq(), model.nv()) != (joints, joints) {
        return Err(Diagnostic::error("a free run needs a robot whose base is fixed")
            .help("the forces on a moving base are not part of the prediction"));
    }
    let samples = recording.samples();
    let is_whole = |values: &Vec<f64>| values.len() == samples * joints;
    let within = |segment: &Range<usize>| segment.start < segment.end && segment.end <= samples;
    let fits = recording.effort.len() == joints
        && recording.effort.iter().flatten().all(|effort| effort.len() == samples)
        && [&recording.trajectory.q, &recording.trajectory.v].into_iter().all(is_whole)
        && recording.segments.iter().all(within);
    if !fits {
        return Err(Diagnostic::error("the recording is of another robot, or not whole"));
    }
    if let Some(joint) = recording.effort.iter().position(Option::is_none) {
        let name = &layout.joints[joint].name;
        return Err(Diagnostic::error(format!(
            "a free run needs the effort of `{name}`, which the log lacks"
        ))
        .help("log the efforts of all joints"));
    }
    model.function("forward_dynamics").ok_or_else(|| {
        Diagnostic::error("the model has no function `forward_dynamics`")
            .help("add it to what is generated from the description")
    })
}

/// By joint: how much later than logged the effort acts, s.
fn delays(layout: &JointLayout, effects: &[Effect]) -> Vec<f64> {
    let of = |name: &String| {
        let own = effects.iter().filter(|effect| effect.location.joint.as_ref() == Some(name));
        let late = own.filter(|effect| effect.kind.law == Law::Delay);
        late.map(|effect| effect.value("delay")).sum()
    };
    layout.joints.iter().map(|joint| of(&joint.name)).collect()
}

/// What of the description the prediction contains and what not.
fn assumed(effects: &[Effect]) -> Vec<String> {
    let mut list = vec![
        "free run: nothing but the logged efforts acts on the joints; between samples they are a quintic spline"
            .to_owned(),
    ];
    let left_out = |effect: &&Effect| effect.kind.law.acts() == Acts::Transmission;
    for effect in effects.iter().filter(left_out) {
        list.push(format!("free run: without {effect}: motor and link are taken as one"));
    }
    list
}

/// Where a window lies.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Place {
    /// Index of the stretch.
    segment: usize,
    /// Samples, the first one is where it starts.
    range: Range<usize>,
}

/// Windows of this length within the stretches; the first of a stretch begins when all efforts that act have been logged.
fn windows(recording: &Recording, seconds: f64, delay: f64) -> Result<Vec<Place>, Diagnostic> {
    let (step, time) = (recording.step, &recording.time);
    let positive = seconds > 0.0 && seconds.is_finite();
    if !positive || (seconds / step) + 1e-6 < FEWEST_SAMPLES as f64 {
        let message =
            format!("a free run of {seconds} s is shorter than {FEWEST_SAMPLES} samples of {step:.6} s each");
        return Err(Diagnostic::error(message)
            .help(format!("choose a window of at least {:.4} s", FEWEST_SAMPLES as f64 * step)));
    }
    let mut places = Vec::new();
    for (segment, samples) in recording.segments.iter().enumerate() {
        let ready = time[samples.start] + delay - 1e-6 * step;
        let mut first = samples.start + time[samples.clone()].partition_point(|t| *t < ready);
        while first < samples.end {
            let until = time[first] + seconds;
            let count = time[first..samples.end].partition_point(|t| *t <= until + 1e-3 * step);
            let last = first + count - 1;
            // What is left at the end of a stretch may be too short.
            if last + 1 == samples.end && time[last] < until - 0.75 * step {
                break;
            }
            // An uneven clock may leave a window without samples.
            if count <= FEWEST_SAMPLES / 2 {
                first += 1;
                continue;
            }
            places.push(Place { segment, range: first..last + 1 });
            first = last;
        }
    }
    if places.is_empty() {
        let longest = recording.segments.iter().map(|s| time[s.end - 1] - time[s.start]).fold(0.0, f64::max);
        let message = format!(
            "a window of {seconds} s does not fit: the longest stretch of the log that counts lasts {longest:.3} s"
        );
        return Err(Diagnostic::error(message)
            .help("choose a shorter window, or record longer; --trim is left out at both ends"));
    }
    Ok(places)
}

/// At most [`MOST_WINDOWS`] of them, evenly spread.
fn spread(all: &[Place]) -> Vec<&Place> {
    let count = all.len().min(MOST_WINDOWS);
    (0..count).map(|k| &all[k * all.len() / count]).collect()
}

/// Adds the errors of a window, whose start is none. `predicted` has the positions of all samples after it.
fn add(sums: &mut [Sums], recording: &Recording, range: &Range<usize>, predicted: &[f64]) {
    let nq = sums.len();
    let at = |sample: usize| recording.trajectory.joints_at(sample)[0];
    let start = at(range.start);
    for (k, predicted) in predicted.chunks_exact(nq).enumerate() {
        let sample = range.start + 1 + k;
        for (joint, sums) in sums.iter_mut().enumerate() {
            let measured = at(sample)[joint];
            sums.add(measured - predicted[joint], measured - start[joint], sample + 1 == range.end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(samples: &[Range<usize>]) -> Recording {
        let last = samples.last().map_or(0, |s| s.end);
        let time = (0..last).map(|i| 0.01 * i as f64).collect();
        Recording { time, step: 0.01, segments: samples.to_vec(), ..Recording::default() }
    }

    #[test]
    fn windows_follow_one_another_and_cross_no_gap() {
        let places = windows(&recording(&[0..45, 45..120]), 0.2, 0.0).unwrap();
        let ranges: Vec<_> = places.iter().map(|p| (p.segment, p.range.clone())).collect();
        assert_eq!(ranges, [(0, 0..21), (0, 20..41), (1, 45..66), (1, 65..86), (1, 85..106)]);
        let late = windows(&recording(&[0..45, 45..120]), 0.2, 0.055).unwrap();
        assert_eq!(late[0].range, 6..27);
    }

    /// A clock that now and then is one and a half steps late.
    #[test]
    fn uneven_samples_have_windows_as_well() {
        let mut uneven = recording(&[0..200, 200..201]);
        let mut late = 0.0;
        for (i, t) in uneven.time.iter_mut().enumerate() {
            late += if i % 7 == 3 { 0.005 } else { 0.0 };
            *t += late;
        }
        let places = windows(&uneven, 0.2, 0.0).unwrap();
        let length = uneven.time[199] - uneven.time[0];
        assert!(places.len() as f64 >= (length / 0.2).floor(), "{} in {length} s", places.len());
        assert!(places.windows(2).all(|w| w[0].range.end == w[1].range.start + 1));
        for place in &places {
            let length = uneven.time[place.range.end - 1] - uneven.time[place.range.start];
            assert!((0.2 - 0.0151..=0.2 + 1e-5).contains(&length), "{length}");
        }
    }

    #[test]
    fn lengths_without_meaning_are_refused() {
        let of = |seconds| windows(&recording(&[0..45, 45..100]), seconds, 0.0).unwrap_err().to_string();
        for seconds in [0.09, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(of(seconds).contains("shorter than 10 samples"), "{}", of(seconds));
        }
        assert!(of(0.6).contains("lasts 0.540 s"), "{}", of(0.6));
        assert!(windows(&recording(&[0..45, 45..46]), 0.1, 0.0).is_ok());
    }

    #[test]
    fn many_windows_are_spread_over_the_whole_log() {
        let all = windows(&recording(&[0..25_000, 25_000..25_001]), 0.1, 0.0).unwrap();
        let taken = spread(&all);
        assert_eq!((all.len(), taken.len()), (2499, MOST_WINDOWS));
        assert!(taken.windows(2).all(|w| w[0].range.end <= w[1].range.start + 1));
        assert!(taken[MOST_WINDOWS - 1].range.end > 24_900);
    }
}
