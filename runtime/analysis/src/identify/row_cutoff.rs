//! How slow a low-pass the rows of a regression pass: as slow as the motion allows.
//!
//! An encoder's noise, differentiated twice, grows with the 2.5th power of the frequency up to which it passes. Behind the filter of the
//! signals it may be as large as the accelerations of a slow motion; least squares, which takes regressors as exact, then shrinks inertias
//! and says nothing of it in its error bars. A low-pass over regressor and torque together takes that noise off, and takes off
//! motion without making anything wrong: what is lost is only what that motion would have told.
use super::row_filter::RowFilter;
use super::survey::Survey;
use crate::experiments::data_checks::SHORT;
use crate::measure::Recording;
use crate::measure::filtered::acceleration_response;
use crate::signal::Butterworth;

/// A log is looked at in stretches of so many lengths of the slowest filter at least.
const STRETCH: usize = 12;
/// Cut-offs that are tried, Hz.
const TRIED: [f64; 11] = [0.63, 1.0, 1.6, 2.5, 4.0, 6.3, 10.0, 16.0, 25.0, 40.0, 63.0];
/// A filter of the rows has to be slower than that of the signals by this factor to be worth it.
const SLOWER: f64 = 0.8;
/// The part of its samples that a log may lose at its ends and gaps.
const LOST: f64 = 0.15;
/// Periods of a cut-off that a stretch of motion has at least, one of those that are left out in turn for error bars: what a filter makes of noise
/// lasts as long as it, and must not reach from most of a stretch into the next.
const PERIODS: f64 = 1.7;
/// A channel has at least so many rows per unknown.
const ROWS: f64 = 4.0;
/// A standard error that is usual for an inertia, as part of it: what noise may take off it is held against this.
const USUAL_ERROR: f64 = 0.003;
/// How much more variance a slower filter may cost than the best one, as part of the usual one: what the noise is not known to do.
const SLACK: f64 = 0.1;
/// The filter of the signals is faster than that of the rows by this factor, so that it takes nothing off the motion that rows show:
/// torques are no linear functions of the motion, so what it takes off would be missed on one side alone.
const FASTER: f64 = 2.0;
/// The slowest filter of the signals, Hz: the ends of a log are left out only as far as it reaches; and the fastest, beyond which
/// machines shake.
const SIGNALS: (f64, f64) = (4.0, 30.0);
/// Cut-off of the signals' filter behind which a cut-off is looked for, Hz.
pub const LOOKING: f64 = 40.0;
/// Accelerations of which less than this part of the noise is motion tell no more than that.
const NOTHING: f64 = 0.05;

/// Accelerations that are not noisier than this (rad/s² or m/s²) were computed.
const EXACT: f64 = 1e-7;

/// What of a log's accelerations passes low-passes of its rows: of motion and of noise.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AccelerationSpectrum {
    /// By cut-off tried, and last without one.
    passed: Vec<Passed>,
    /// Noise of the encoders in the accelerations behind the filter of the signals, one standard deviation by joint.
    noise: Vec<f64>,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Passed {
    filter: Option<RowFilter>,
    /// Sums of squares by joint.
    squares: Vec<f64>,
    rows: usize,
    /// The part of the noise's variance that passes.
    part: f64,
}

impl AccelerationSpectrum {
    /// Goes on with the samples of a recording.
    pub(super) fn hear(&mut self, recording: &Recording) {
        let joints = recording.effort.len();
        if self.passed.is_empty() {
            let filter = |cutoff: &f64| Some(RowFilter::smooth(*cutoff, recording.step));
            let empty = |filter| Passed { filter, squares: vec![0.0; joints], ..Passed::default() };
            self.passed = TRIED.iter().map(filter).chain([None]).map(empty).collect();
        }
        for joint in 0..joints {
            let all: Vec<f64> = recording.trajectory.accelerations(joint).collect();
            for stretch in &recording.segments {
                self.passed.iter_mut().for_each(|passed| passed.hear(joint, &all[stretch.clone()]));
            }
        }
    }

    /// Samples of which a log's rows are to be looked at together.
    pub(super) fn stretch(step: f64) -> usize {
        STRETCH * RowFilter::smooth(TRIED[0], step).length()
    }

    /// The log was read to its end.
    pub(super) fn finish(&mut self, recording: &Recording) {
        self.noise.clone_from(&recording.acceleration_noise);
        let Ok(filter) = Butterworth::new(recording.cutoff_hz, 1.0 / recording.step) else { return };
        let response = acceleration_response(&filter, recording.step);
        for passed in &mut self.passed {
            passed.part = passed.filter.as_ref().map_or(1.0, |filter| filter.part_of_noise(&response));
        }
    }

    /// The part of the noise's variance that a filter of the rows lets pass, by joint in (rad/s²)² or (m/s²)².
    pub(super) fn noise_behind(&self, survey: &Survey, filter: Option<&RowFilter>) -> Vec<f64> {
        let butterworth = Butterworth::new(survey.cutoff_hz, 1.0 / survey.step).ok();
        let response = butterworth.map(|b| acceleration_response(&b, survey.step)).unwrap_or_default();
        let part = filter.map_or(1.0, |filter| filter.part_of_noise(&response));
        self.noise.iter().map(|noise| part * noise * noise).collect()
    }
}

impl Passed {
    fn hear(&mut self, joint: usize, accelerations: &[f64]) {
        let rows = match &self.filter {
            Some(filter) => filter.column(accelerations),
            None => accelerations.to_vec(),
        };
        // Joints have the same rows.
        self.rows += if joint == 0 { rows.len() } else { 0 };
        self.squares[joint] += rows.iter().map(|x| x * x).sum::<f64>();
    }
}

/// The cut-off (Hz) for the rows of logs whose channels have up to `unknowns` unknowns, and which are cut into stretches of `stretch` (s); none: noise
/// is too little for one.
///
/// The bias of an inertia is the part N/A that noise has beside motion in accelerations, the variance of its estimate goes as 1/A: chosen is
/// where the sum of what both cost is least, over all joints.
pub(super) fn chosen(surveys: &[Survey], unknowns: usize, stretch: f64) -> Option<f64> {
    TRIED.get(best(surveys, unknowns, stretch)?).copied()
}

/// The cut-off (Hz) for positions and efforts of logs that were looked at behind a filter of [`LOOKING`]; none: there is no noise, or
/// logs are too short to tell: what a machine does beyond all models would pass for its motion.
pub fn signal_cutoff(surveys: &[Survey]) -> Option<f64> {
    let duration: f64 = surveys.iter().map(|survey| survey.samples as f64 * survey.step).sum();
    if duration < SHORT {
        return None;
    }
    let rows = TRIED.get(best(surveys, 0, f64::INFINITY)?).copied().unwrap_or(f64::INFINITY);
    Some((FASTER * rows).clamp(SIGNALS.0, SIGNALS.1))
}

/// Index of a cut-off among those tried, that of none being the last; none without noise.
fn best(surveys: &[Survey], unknowns: usize, stretch: f64) -> Option<usize> {
    let spectra: Vec<&AccelerationSpectrum> = surveys.iter().map(|survey| &survey.accelerations).collect();
    let joints = spectra.first()?.noise.len();
    if spectra.iter().any(|s| s.passed.is_empty() || s.noise.len() != joints) {
        return None;
    }
    let fastest = surveys.iter().map(|survey| survey.cutoff_hz).fold(f64::INFINITY, f64::min);
    let is_short = |k: usize| TRIED[k] < SLOWER * fastest && TRIED[k] * stretch >= PERIODS;
    let usable = |k: &usize| *k == TRIED.len() || is_short(*k) && enough(surveys, *k, unknowns);
    let candidates: Vec<usize> = (0..=TRIED.len()).filter(usable).collect();
    let mut costs = vec![0.0; candidates.len()];
    // Numbers that were computed have no noise, and pass no filter.
    let noisy = spectra.iter().any(|s| s.noise.iter().any(|noise| *noise > EXACT));
    for joint in 0..joints {
        let of = |k: &usize| motion_and_noise(&spectra, *k, joint);
        let all: Vec<[f64; 2]> = candidates.iter().map(of).collect();
        // A joint that nobody can see accelerate tells nothing about filters.
        if !all.iter().any(|[motion, noise]| *motion > *noise && *motion > 0.0) {
            continue;
        }
        let most = all.iter().map(|[motion, _]| *motion).fold(0.0, f64::max);
        for (cost, [motion, noise]) in costs.iter_mut().zip(&all) {
            let motion = motion.max(NOTHING * noise).max(f64::MIN_POSITIVE);
            *cost += (noise / motion).powi(2) + USUAL_ERROR.powi(2) * most / motion;
        }
    }
    let limit =
        costs.iter().copied().fold(f64::INFINITY, f64::min) + joints as f64 * SLACK * USUAL_ERROR.powi(2);
    let slowest = costs.iter().zip(&candidates).find(|(cost, _)| **cost <= limit).map(|(_, k)| *k);
    slowest.filter(|_| noisy)
}

/// Mean squares of a joint's acceleration behind a filter: of the motion and of the noise.
fn motion_and_noise(spectra: &[&AccelerationSpectrum], k: usize, joint: usize) -> [f64; 2] {
    let (mut squares, mut noise, mut rows) = (0.0, 0.0, 0.0);
    for spectrum in spectra {
        let passed = &spectrum.passed[k];
        let stride = passed.filter.as_ref().map_or(1, RowFilter::stride) as f64;
        squares += stride * passed.squares[joint];
        noise += stride * passed.rows as f64 * passed.part * spectrum.noise[joint].powi(2);
        rows += stride * passed.rows as f64;
    }
    let rows = f64::max(rows, 1.0);
    [(squares - noise) / rows, noise / rows]
}

/// Whether enough is left behind a filter of all logs.
fn enough(surveys: &[Survey], k: usize, unknowns: usize) -> bool {
    let rows: usize = surveys.iter().map(|survey| survey.accelerations.passed[k].rows).sum();
    let whole = |survey: &Survey| {
        let passed = &survey.accelerations.passed[k];
        let stride = passed.filter.as_ref().map_or(1, RowFilter::stride);
        (stride * passed.rows) as f64 >= (1.0 - LOST) * survey.samples as f64
    };
    rows as f64 >= ROWS * unknowns as f64 && surveys.iter().all(whole)
}
