//! Where searches for saturated drives and ripples begin.
use super::experiment::MotionExperiment;
use super::{limit, ripple};
use crate::experiments::Experiment;

/// Signals that other effects are functions of.
const SMOOTH: [&str; 4] = ["position", "velocity", "load", "acceleration"];

impl MotionExperiment<'_> {
    /// Torques at which a joint's drive may saturate.
    pub(super) fn limits(&self, joint: usize) -> Vec<f64> {
        let Some(effort) = &self.recording.effort[joint] else { return Vec::new() };
        let mut sizes: Vec<f64> = effort.iter().map(|u| u.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let quantile = |part: f64| sizes[((sizes.len() - 1) as f64 * part) as usize];
        let noise = self.recording.noise[joint];
        // A limit within the noise would pass the measurement off as the prediction.
        let low = [0.02, 0.05, 0.1, 0.15, 0.22, 0.3].map(quantile);
        let limits = [0.4, 0.5, 0.6, 0.68, 0.75, 0.81, 0.86, 0.9, 0.94, 0.97, 0.99].map(quantile);
        let best = self.effort_row(joint).and_then(|row| {
            let signals = self.smooth_signals(row);
            let others: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
            limit::best(effort, self.residual(row), &others)
        });
        let load = self.of_load(joint);
        let stays = |limit: &f64| limit::stays(effort, load, *limit);
        let low = low.into_iter().filter(|limit| limit::rests_at(effort, load, (*limit, noise)));
        // Of commands that run away from a limit far more is cut off than noise could make.
        let runs_away = |limit: f64, times: f64| {
            let beyond: Vec<f64> = sizes.iter().map(|u| u - limit).filter(|beyond| *beyond > 0.0).collect();
            let squares: f64 = beyond.iter().map(|x| x * x).sum();
            squares > beyond.len() as f64 * (times * noise).powi(2)
        };
        let told = |limit: &f64| *limit > 4.0 * noise || (*limit > noise && runs_away(*limit, 10.0));
        // Where the load itself says that it rests there, noise need not be next to nothing.
        let rested = limit::rested_at(effort, load, noise).filter(|limit| runs_away(*limit, 4.0));
        low.chain(limits).chain(best).filter(told).filter(stays).chain(rested).collect()
    }

    /// Periods per turn with which a joint's residual may repeat.
    pub(super) fn lines(&self, joint: usize) -> Vec<f64> {
        let Some(row) = self.effort_row(joint) else { return Vec::new() };
        let signals = self.smooth_signals(row);
        let others: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
        ripple::seeds(self.residual(row), &signals[0], &others)
    }

    /// What the joint's other effects are functions of: angle, velocity, acceleration, load, sign of velocity.
    fn smooth_signals(&self, row: usize) -> Vec<Vec<f64>> {
        let mut signals: Vec<Vec<f64>> = SMOOTH.iter().filter_map(|name| self.signal(row, name)).collect();
        let joint = self.joint_of[row];
        let slides = self.layout.joints[joint].prismatic;
        let smoothing = if slides { self.reversal_speed(joint) } else { 0.02 };
        let sign = signals[1].iter().map(|v| (v / smoothing).tanh()).collect();
        signals.push(sign);
        signals
    }
}
