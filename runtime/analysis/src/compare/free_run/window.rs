//! One window: the model on its own from a measured state.
use super::input::Input;
use crate::measure::Recording;
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};
use ivp::dense::StepInterpolant;
use ivp::methods::{DOP853, Tolerance};
use ivp::prelude::{ControlFlag, FirstOrderSystem};
use ivp::solout::SolOut;
use ivp::status::Status;
use std::cell::Cell;
use std::ops::Range;

/// Error per step, relative to each component and of what is smaller than one; far below what any encoder resolves.
const TOLERANCE: f64 = 1e-9;
/// Steps that a second of prediction may take: smoothed friction on light links is stiff.
const MOST_STEPS: f64 = 5_000.0;
/// A revolute joint that is farther off than this has left the measurement, rad.
const FARTHEST_TURN: f64 = std::f64::consts::PI;
/// The same for a sliding joint, m.
const FARTHEST_WAY: f64 = 1.0;

/// A stretch of the log that is predicted from its first sample.
pub(super) struct Window<'a> {
    pub model: &'a dyn Model<f64>,
    /// `forward_dynamics`
    pub function: usize,
    pub layout: &'a JointLayout,
    pub recording: &'a Recording,
    pub input: &'a Input,
    pub range: Range<usize>,
}

/// How it went.
pub(super) enum Outcome {
    /// Predicted positions of all samples but the first, one after the other.
    Arrived(Vec<f64>),
    Diverged,
    Capped,
}

impl Window<'_> {
    /// Integrates to the last sample.
    pub fn run(&self) -> Result<Outcome, Diagnostic> {
        let joints = self.layout.joints.len();
        let time = &self.recording.time[self.range.clone()];
        let length = time[time.len() - 1] - time[0];
        let start = self.recording.trajectory.joints_at(self.range.start).concat();
        let mut watch = Watch {
            window: self,
            start: time[0],
            next: 1,
            x: vec![0.0; 2 * joints],
            positions: Vec::with_capacity((time.len() - 1) * joints),
            left: false,
        };
        let most = (MOST_STEPS * length.max(0.1)) as usize;
        let method = DOP853 {
            max_step: Some(2.0 * self.recording.step),
            max_steps: most,
            // The limit on steps says enough about stiffness.
            stiff_test: most + 1,
            ..DOP853::default()
        };
        let tolerance = || Tolerance::Scalar(TOLERANCE);
        let motion = FreeMotion { window: self, start: time[0], broken: Cell::new(false) };
        let result = method.solve(&motion, 0.0, &start, length, tolerance(), tolerance(), Some(&mut watch));
        let status =
            result.map_err(|error| Diagnostic::error(format!("the integration failed: {error:?}")))?.status;
        Ok(match status {
            _ if watch.left => Outcome::Diverged,
            Status::NeedLargerNMax if !motion.broken.get() => Outcome::Capped,
            _ if watch.next == time.len() => Outcome::Arrived(watch.positions),
            _ => Outcome::Diverged,
        })
    }

    fn is_far(&self, sample: usize, predicted: &[f64]) -> bool {
        let [measured, _] = self.recording.trajectory.joints_at(sample);
        self.layout.joints.iter().zip(measured).zip(predicted).any(|((joint, measured), predicted)| {
            let farthest = if joint.prismatic { FARTHEST_WAY } else { FARTHEST_TURN };
            let error = (measured - predicted).abs();
            error.is_nan() || error > farthest
        })
    }
}

/// x = (q, v)
struct FreeMotion<'w> {
    window: &'w Window<'w>,
    start: f64,
    /// Whether an acceleration was not finite: steps have no length from then on.
    broken: Cell<bool>,
}

impl FirstOrderSystem for FreeMotion<'_> {
    fn derivative(&self, time: f64, x: &[f64], out: &mut [f64]) {
        let (q, v) = x.split_at(x.len() / 2);
        let (rate, acceleration) = out.split_at_mut(q.len());
        rate.copy_from_slice(v);
        let tau = self.window.input.at(self.start + time);
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::Tau, &tau);
        let refused = self.window.model.evaluate(self.window.function, &state, acceleration).is_err();
        if refused || !acceleration.iter().all(|a| a.is_finite()) {
            self.broken.set(true);
        }
    }
}

/// Takes down positions at the samples.
struct Watch<'w> {
    window: &'w Window<'w>,
    start: f64,
    /// Sample of the window that comes next.
    next: usize,
    x: Vec<f64>,
    positions: Vec<f64>,
    left: bool,
}

impl SolOut for Watch<'_> {
    fn solout(
        &mut self,
        from: f64,
        to: &mut f64,
        _: &mut [f64],
        interpolant: Option<&StepInterpolant<'_>>,
    ) -> ControlFlag {
        let Some(dense) = interpolant.filter(|_| *to > from) else { return ControlFlag::Continue };
        let window = self.window;
        let joints = window.layout.joints.len();
        while let Some(time) = window.recording.time[window.range.clone()].get(self.next) {
            // The last sample is the end of the last step but for rounding.
            if time - self.start > *to + 1e-9 * window.recording.step {
                break;
            }
            dense.interpolate(time - self.start, &mut self.x);
            if window.is_far(window.range.start + self.next, &self.x[..joints]) {
                self.left = true;
                return ControlFlag::Interrupt;
            }
            self.positions.extend_from_slice(&self.x[..joints]);
            self.next += 1;
        }
        ControlFlag::Continue
    }
}
