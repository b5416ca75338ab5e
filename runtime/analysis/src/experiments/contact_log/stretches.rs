//! The stretches of a log between impacts, and which of their samples count.
use super::ContactRecording;
use super::forces::SHORTEST;
use super::passing::Passing;
use super::strikes::{between, impacts};
use crate::log::Block;
use crate::measure::Options;
use crate::measure::trajectory::Unusable;

/// Periods of the cut-off that are left out before and after an impact, where the filter has only one side to look at: as
/// many as leave enough samples. Of a walking robot's torques (no noise, cut-off at 20 Hz) 0.4, 0.9 and 2 % are wrong beyond.
const BESIDE_IMPACTS: [f64; 3] = [2.0, 1.5, 1.0];
/// Part of the samples that must be left.
const LEFT: f64 = 0.4;
/// Periods of the cut-off over which an impact is still felt in what the filter leaves.
const FELT: f64 = 4.0;

impl ContactRecording {
    /// Adds a block, between impacts: nothing is filtered across one.
    pub(super) fn add(&mut self, passing: &Passing<'_, '_>, block: Block<'_>) -> Result<(), Unusable> {
        let impacts = if passing.cut { impacts(passing, &block, &self.feet) } else { Vec::new() };
        if impacts.is_empty() {
            return self.add_stretch(passing, &block, [false; 2]);
        }
        let count = block.time.len();
        for (range, ends) in between(&impacts, count) {
            let core = range.start.max(block.core.start)..range.end.min(block.core.end);
            if core.is_empty() || range.len() < SHORTEST {
                continue;
            }
            let columns: Vec<Vec<f64>> = block.columns.iter().map(|c| c[range.clone()].to_vec()).collect();
            let stretch = Block {
                time: &block.time[range.clone()],
                columns: &columns,
                core: core.start - range.start..core.end - range.start,
                ..block
            };
            // What began before the core was begun by the block before.
            self.add_stretch(passing, &stretch, [ends[0] && range.start >= block.core.start, ends[1]])?;
        }
        Ok(())
    }

    /// Chooses the samples that count: those beside impacts do not, as far as enough others are left.
    pub(super) fn keep(&mut self, options: &Options, stride: usize) {
        let wanted = self.kept_beside(options, stride, 0.0).len() as f64 * LEFT;
        let [far @ .., nearest] = BESIDE_IMPACTS;
        let mut each = far.iter().map(|periods| self.kept_beside(options, stride, *periods));
        let enough = each.find(|kept| kept.len() as f64 >= wanted);
        self.kept = enough.unwrap_or_else(|| self.kept_beside(options, stride, nearest));
    }

    /// From one sample that counts to the next, samples.
    pub(super) fn spacing(&self) -> usize {
        self.kept.windows(2).map(|pair| pair[1] - pair[0]).min().unwrap_or(1).max(1)
    }

    /// How long the samples are of that count: after falls and cuts, s.
    pub(super) fn duration(&self) -> f64 {
        (self.kept.len() * self.spacing()) as f64 * self.step
    }

    /// Whether the motion is cut at impacts.
    pub(super) fn is_cut_at_impacts(&self) -> bool {
        self.at_impacts.as_flattened().contains(&true)
    }

    /// Part of the samples that count which lie where an impact is still felt.
    pub(super) fn beside_impacts(&self) -> f64 {
        let reach = FELT / self.cutoff_hz;
        let is_felt = |i: usize| {
            let here = self.segments.iter().zip(&self.at_impacts).find(|(segment, _)| segment.contains(&i));
            here.is_some_and(|(segment, [begin, end])| {
                let to = |other: usize| (self.time[i] - self.time[other]).abs() < reach;
                (*begin && to(segment.start)) || (*end && to(segment.end - 1))
            })
        };
        let felt = self.kept.iter().filter(|i| is_felt(**i)).count();
        felt as f64 / self.kept.len().max(1) as f64
    }

    /// The samples that count, with so many periods of the cut-off left out on either side of impacts.
    fn kept_beside(&self, options: &Options, stride: usize, periods: f64) -> Vec<usize> {
        let slack = 0.5 * self.step;
        let mut kept = Vec::new();
        for (segment, impacts) in self.segments.iter().zip(&self.at_impacts) {
            let Some(last) = segment.end.checked_sub(1).filter(|last| *last >= segment.start) else {
                continue;
            };
            let [begin, end] = impacts.map(|at| if at { periods / self.cutoff_hz } else { options.trim_s });
            let from =
                options.from_s.unwrap_or(f64::NEG_INFINITY).max(self.time[segment.start] + begin - slack);
            let to = options.to_s.unwrap_or(f64::INFINITY).min(self.time[last] - end + slack);
            let inside = segment.clone().filter(|i| self.time[*i] >= from && self.time[*i] <= to);
            kept.extend(inside.step_by(stride));
        }
        kept
    }
}
