//! Logs of any length in bounded memory: samples are given up while the log is read.
use crate::log::Log;
use crate::measure::noise::Noise;
use crate::measure::recording::{FEWEST, Recording, too_short};
use crate::measure::{DataSource, Options};
use crate::parallel::parallel;
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostics;

/// Samples of a log that are held at once, at most: with more, every other one goes, again and again. Logs that are
/// not longer are thinned once, at the end, so that nothing of them depends on this number.
pub const HELD: usize = 1 << 18;

/// What is held of a log: all samples, unless there are more than [`HELD`].
#[derive(Debug)]
pub struct Held {
    recording: Recording,
    /// Whether samples had to go while the log was read.
    is_long: bool,
}

impl Held {
    /// Reads a log of any length.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read(log: &Log, layout: &JointLayout, options: &Options) -> Result<Self, Diagnostics> {
        Self::read_if(log, layout, options, true)
    }

    /// The same without what a log tells of its noise, for those who ask for the motion and the efforts alone: all noise is said to be none.
    ///
    /// # Errors
    /// As [`Recording::read`].
    pub fn read_motion(log: &Log, layout: &JointLayout, options: &Options) -> Result<Self, Diagnostics> {
        Self::read_if(log, layout, options, false)
    }

    fn read_if(log: &Log, layout: &JointLayout, options: &Options, hears: bool) -> Result<Self, Diagnostics> {
        let mut thinning = Thinning { hears, ..Thinning::new() };
        let mut visit = |recording: &mut Recording| {
            thinning.take(recording);
            Ok(())
        };
        let mut recording = Recording::each_block(log, layout, options, (None, hears), &mut visit)?;
        if thinning.seen() < FEWEST {
            return Err(too_short(thinning.seen(), log.path()).into());
        }
        recording.source = DataSource { samples: thinning.seen(), ..log.source()? };
        thinning.finish(&mut recording);
        Ok(Self { recording, is_long: thinning.is_long() })
    }

    /// Evenly spaced samples, at most `most` of them (but one for every stretch without gaps).
    pub fn thinned(&self, most: usize) -> Recording {
        self.told(self.recording.thinned(most))
    }

    /// The same where nobody else needs what is held: it is not copied.
    pub fn into_thinned(mut self, most: usize) -> Recording {
        let mut recording = std::mem::take(&mut self.recording);
        recording.thin(most);
        self.told(recording)
    }

    /// Says of samples of a long log that they are not all.
    fn told(&self, mut recording: Recording) -> Recording {
        if self.is_long {
            recording.assumptions.push(format!(
                "the log is long: of its {} samples {} are looked at, evenly spread and after filtering",
                recording.source.samples,
                recording.samples()
            ));
        }
        recording
    }

    /// How many numbers it takes, about.
    pub fn numbers(&self) -> usize {
        let Recording { trajectory, effort, transmission, motors, .. } = &self.recording;
        let of_joints =
            effort.iter().chain(transmission).flatten().count() + 3 * motors.iter().flatten().count();
        trajectory.q.len() + trajectory.v.len() + trajectory.a.len() + of_joints * self.recording.samples()
    }
}

/// Gives up samples of a recording that grows.
pub(super) struct Thinning {
    held: usize,
    /// Every so many-th sample is held.
    stride: usize,
    seen: usize,
    /// Samples of the recording that were looked at already.
    known: usize,
    /// Time of the last sample seen, held or not, s.
    last: f64,
    /// Of each joint's effort.
    noise: Vec<Noise>,
    /// Whether that is asked for.
    hears: bool,
}

impl Thinning {
    pub fn new() -> Self {
        Self::holding(HELD)
    }

    fn holding(held: usize) -> Self {
        Self { held, stride: 1, seen: 0, known: 0, last: f64::NEG_INFINITY, noise: Vec::new(), hears: true }
    }

    /// Number of samples of the log that count.
    pub fn seen(&self) -> usize {
        self.seen
    }

    /// Whether samples had to go while the log was read.
    pub fn is_long(&self) -> bool {
        self.stride > 1
    }

    /// Looks at the samples that came since the last call.
    pub fn take(&mut self, recording: &mut Recording) {
        self.noise.resize_with(recording.effort.len(), Noise::new);
        for (noise, effort) in self.noise.iter_mut().zip(&recording.effort).filter(|_| self.hears) {
            noise.push(effort.as_deref().map_or(&[], |effort| &effort[self.known..]));
        }
        let new = recording.samples() - self.known;
        if self.stride > 1 && new > 0 {
            self.join(recording);
            let first = self.seen.next_multiple_of(self.stride) - self.seen;
            let old = 0..self.known;
            self.last = *recording.time.last().unwrap_or(&self.last);
            let new = (self.known + first..recording.samples()).step_by(self.stride);
            hold(recording, &old.chain(new).collect::<Vec<_>>());
        } else {
            self.last = *recording.time.last().unwrap_or(&self.last);
        }
        self.seen += new;
        while recording.samples() > self.held {
            let even: Vec<usize> = (0..recording.samples()).step_by(2).collect();
            hold(recording, &even);
            self.stride *= 2;
        }
        self.known = recording.samples();
    }

    /// What follows at the usual step is no new stretch, though the sample before it went.
    fn join(&self, recording: &mut Recording) {
        let Some(new) = recording.segments.iter().position(|s| s.start == self.known) else { return };
        if new > 0 && recording.time[self.known] - self.last < 1.5 * recording.step {
            recording.segments[new - 1].end = recording.segments[new].end;
            recording.segments.remove(new);
        }
    }

    /// Noise and step of what is left.
    pub fn finish(&self, recording: &mut Recording) {
        recording.step *= self.stride as f64;
        let level =
            |joint: usize| recording.effort[joint].as_ref().map_or(0.0, |_| self.noise[joint].level());
        recording.noise = parallel(recording.effort.len(), level);
    }
}

/// Keeps these samples, increasing; stretches of which none is left vanish.
fn hold(recording: &mut Recording, kept: &[usize]) {
    let place = |sample: usize| kept.partition_point(|k| *k < sample);
    let segments = recording.segments.iter().map(|s| place(s.start)..place(s.end));
    let segments: Vec<_> = segments.filter(|s| !s.is_empty()).collect();
    recording.retain(kept);
    recording.segments = segments;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Trajectory;

    /// Pieces as blocks bring them; a joint on a planar base whose numbers all tell the sample.
    fn thinned(held: usize, pieces: &[(f64, usize)]) -> (Recording, Thinning) {
        let mut thinning = Thinning::holding(held);
        let mut recording = Recording {
            step: 0.001,
            trajectory: Trajectory::with_widths(4, 4, 1),
            effort: vec![Some(Vec::new())],
            ..Recording::default()
        };
        for &(start, count) in pieces {
            let first = recording.samples();
            let time: Vec<f64> = (0..count).map(|i| start + 0.001 * i as f64).collect();
            let follows = recording.time.last().is_some_and(|last| start - last < 0.0015);
            recording.time.extend(&time);
            let all: Vec<f64> = time.iter().flat_map(|t| [*t; 4]).collect();
            recording.trajectory.extend([&all, &all, &all]);
            recording.effort[0].get_or_insert_default().extend(&time);
            match recording.segments.last_mut() {
                Some(last) if follows => last.end = recording.time.len(),
                _ => recording.segments.push(first..recording.time.len()),
            }
            thinning.take(&mut recording);
        }
        thinning.finish(&mut recording);
        (recording, thinning)
    }

    #[test]
    fn a_short_log_stays_as_it_is() {
        let (recording, thinning) = thinned(1000, &[(0.0, 300), (0.3, 500), (2.0, 200)]);
        assert_eq!((recording.samples(), thinning.seen(), thinning.is_long()), (1000, 1000, false));
        assert_eq!(recording.segments, [0..800, 800..1000]);
        assert_eq!(recording.step, 0.001);
    }

    #[test]
    fn a_long_log_keeps_evenly_spread_samples_of_its_stretches() {
        let pieces: Vec<(f64, usize)> = (0..10).map(|k| (0.333 * f64::from(k), 333)).collect();
        let gap = [(5.0, 4001), (9.001, 777)];
        let (recording, thinning) = thinned(1000, &[pieces.as_slice(), &gap].concat());
        let count = recording.samples();
        assert_eq!((thinning.seen(), thinning.is_long()), (3330 + 4778, true));
        assert!((500..=1000).contains(&count), "{count}");
        assert_eq!(recording.segments.len(), 2, "{:?}", recording.segments);
        assert_eq!(recording.segments[1].end, count);
        for segment in &recording.segments {
            for pair in recording.time[segment.clone()].windows(2) {
                assert!((pair[1] - pair[0] - recording.step).abs() < 1e-9, "{pair:?}");
            }
        }
        let Trajectory { q, v, a, .. } = &recording.trajectory;
        assert_eq!((q.len(), v.len(), a.len()), (4 * count, 4 * count, 4 * count));
        assert!(recording.trajectory.positions(0).eq(recording.time.iter().copied()));
    }

    #[test]
    fn a_log_of_nothing_but_gaps_is_held_as_well() {
        let pieces: Vec<(f64, usize)> = (0..3000).map(|k| (f64::from(k), 1)).collect();
        let (recording, thinning) = thinned(1000, &pieces);
        assert_eq!(thinning.seen(), 3000);
        assert!(recording.samples() <= 1000 && recording.segments.len() == recording.samples());
    }
}
