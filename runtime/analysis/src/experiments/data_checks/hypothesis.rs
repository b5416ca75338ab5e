//! Other readings of a log: what if a sign, a unit or two columns were mixed up?
use super::{Evidence, SAMPLES};
use crate::robot::Trajectory;
use nalgebra::{Matrix4, Vector4};
use std::f64::consts::{FRAC_PI_2, PI};

/// Effects of the library leave the slope of the torque over the model's within this.
const SLOPE: (f64, f64) = (0.3, 3.0);
/// A torque counts as a signal if it varies by so many standard deviations of its noise.
const SIGNAL: f64 = 5.0;
/// Speed below which friction is smeared, rad/s.
pub(super) const SMOOTHING: f64 = 0.02;

/// A torque of which more than this part of the variance is left is not explained.
const EXPLAINED: f64 = 0.5;

/// How well a joint's torque is explained.
struct Row {
    /// Part of its variance that is left.
    left: f64,
    /// Of the torque over the model's, whether or not effects can make it so.
    slope: f64,
}

/// One thing that may be mixed up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mixup {
    EffortSign(usize),
    /// The logged effort is this many times too large.
    EffortUnit(usize, f64),
    PositionSign(usize),
    /// Position and effort count the other way round.
    Direction(usize),
    Degrees(usize),
    /// The logged position is this many times too large.
    Geared(usize, f64),
    /// The logged position is this many times too large, and the logged effort as much too small.
    Motor(usize, f64),
    /// The logged position is larger by so many quarters of a turn.
    Quarters(usize, i8),
    PositionsSwapped(usize, usize),
    /// Positions and efforts.
    JointsSwapped(usize, usize),
    EffortsSwapped(usize, usize),
    /// Of all joints.
    EffortSigns,
    /// All logged efforts are this many times too large.
    EffortUnits(f64),
    /// All joints that turn.
    AllDegrees,
}

impl Mixup {
    /// Whether it is about a sign or a zero, which something that a link carries looks like.
    pub fn is_of_sign_or_zero(self) -> bool {
        matches!(self, Self::PositionSign(_) | Self::EffortSign(_) | Self::Direction(_) | Self::Quarters(..))
    }

    /// Whether both are about the scale of the same position, and of the same efforts.
    pub fn scales_as(self, other: Self) -> bool {
        let of = |mixup: Self| match mixup {
            Self::Degrees(joint) | Self::Geared(joint, _) => Some((joint, false)),
            Self::Motor(joint, _) => Some((joint, true)),
            _ => None,
        };
        of(self).is_some() && of(self) == of(other)
    }

    /// Whether the motion is what it was.
    fn is_of_efforts(self) -> bool {
        matches!(
            self,
            Self::EffortSign(_)
                | Self::EffortUnit(..)
                | Self::EffortsSwapped(..)
                | Self::EffortSigns
                | Self::EffortUnits(_)
        )
    }
}

/// Some samples of a log as they are read under a hypothesis.
#[derive(Clone)]
pub(super) struct View {
    pub(super) motion: Trajectory,
    /// Torques of the model, `samples × nv`.
    pub(super) load: Vec<f64>,
    /// By joint; empty where there is none, or none that exceeds its noise.
    pub(super) effort: Vec<Vec<f64>>,
}

impl View {
    /// As logged, evenly thinned.
    pub fn new(evidence: &Evidence<'_>) -> Self {
        let r = evidence.recording;
        let stride = r.time.len().div_ceil(SAMPLES).max(1);
        let kept: Vec<usize> = (0..r.time.len()).step_by(stride).collect();
        let effort = r.effort.iter().zip(&r.noise).map(|(effort, noise)| match effort {
            Some(effort) if spread(effort) > SIGNAL * noise => kept.iter().map(|&i| effort[i]).collect(),
            _ => Vec::new(),
        });
        let effort = effort.collect();
        let mut motion = r.trajectory.clone();
        motion.retain(&kept);
        let load = (evidence.torques)(&motion);
        Self { motion, load, effort }
    }

    /// Joints whose torque is more than noise.
    pub fn joints(&self) -> Vec<usize> {
        (0..self.effort.len()).filter(|&joint| !self.effort[joint].is_empty()).collect()
    }

    /// Range of a joint's position.
    pub fn range(&self, joint: usize) -> f64 {
        let positions = self.motion.positions(joint);
        let (low, high) = positions.fold((f64::MAX, f64::MIN), |(l, h), q| (l.min(q), h.max(q)));
        high - low
    }

    /// The log read again as if this had been mixed up.
    pub fn under(&self, evidence: &Evidence<'_>, mixup: Mixup) -> Self {
        let mut view = self.clone();
        match mixup {
            Mixup::EffortSign(joint) => view.effort[joint].iter_mut().for_each(|u| *u = -*u),
            Mixup::EffortUnit(joint, factor) => view.effort[joint].iter_mut().for_each(|u| *u /= factor),
            Mixup::EffortsSwapped(one, other) => view.effort.swap(one, other),
            Mixup::PositionSign(joint) => view.scale(joint, -1.0),
            Mixup::Direction(joint) => {
                view.scale(joint, -1.0);
                view.effort[joint].iter_mut().for_each(|u| *u = -*u);
            }
            Mixup::Degrees(joint) => view.scale(joint, PI / 180.0),
            Mixup::Geared(joint, factor) => view.scale(joint, factor.recip()),
            Mixup::Motor(joint, factor) => {
                view.scale(joint, factor.recip());
                view.effort[joint].iter_mut().for_each(|u| *u *= factor);
            }
            Mixup::Quarters(joint, quarters) => {
                let offset = FRAC_PI_2 * f64::from(quarters);
                view.motion.joint_mut(0, joint).for_each(|x| *x -= offset);
            }
            Mixup::PositionsSwapped(one, other) => view.motion.swap(one, other),
            Mixup::JointsSwapped(one, other) => {
                view.motion.swap(one, other);
                view.effort.swap(one, other);
            }
            Mixup::EffortSigns => view.effort.iter_mut().flatten().for_each(|u| *u = -*u),
            Mixup::EffortUnits(factor) => view.effort.iter_mut().flatten().for_each(|u| *u /= factor),
            Mixup::AllDegrees => {
                let turning = (0..evidence.joints.len()).filter(|&joint| !evidence.joints[joint].1);
                turning.for_each(|joint| view.scale(joint, PI / 180.0));
            }
        }
        if !mixup.is_of_efforts() {
            view.load = (evidence.torques)(&view.motion);
        }
        view
    }

    fn scale(&mut self, joint: usize, factor: f64) {
        (0..3).for_each(|order| self.motion.joint_mut(order, joint).for_each(|x| *x *= factor));
    }

    /// Part of the variance of each joint's torque that model, friction and bias leave; 0 without a torque.
    pub fn unexplained(&self) -> Vec<f64> {
        (0..self.effort.len())
            .map(|joint| if self.effort[joint].is_empty() { 0.0 } else { self.row(joint).left })
            .collect()
    }

    /// Whether model, friction and bias explain a joint's torque, the model by about what it expects.
    pub fn explains(&self, joint: usize) -> bool {
        let row = self.row(joint);
        row.left < EXPLAINED && (SLOPE.0..=SLOPE.1).contains(&row.slope)
    }

    fn row(&self, joint: usize) -> Row {
        let states = self.motion.of_joint(&self.load, joint).zip(self.motion.velocities(joint));
        let regressors = states.map(|(load, v)| Vector4::new(load, (v / SMOOTHING).tanh(), v, 1.0));
        let effort = &self.effort[joint];
        let (mut gram, mut right, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
        for (x, u) in regressors.zip(effort) {
            gram += x * x.transpose();
            right += x * *u;
            squares += u * u;
        }
        let mean = right[3] / effort.len() as f64;
        let variance = squares - mean * right[3];
        // A column that is zero throughout must not spoil the others.
        let ridge = Matrix4::from_diagonal(&gram.diagonal().map(|d| 1e-9 * d + 1e-30));
        let solve = |gram: Matrix4<f64>, right: Vector4<f64>| (gram + ridge).lu().solve(&right);
        let Some(free) = solve(gram, right) else { return Row { left: 1.0, slope: 0.0 } };
        let slope = free[0].clamp(SLOPE.0, SLOPE.1);
        let x = if slope == free[0] {
            free
        } else {
            // The slope is given: the others follow.
            let (mut fixed, mut rest) = (gram, right - gram.column(0) * slope);
            fixed.row_mut(0).fill(0.0);
            fixed.column_mut(0).fill(0.0);
            (fixed[(0, 0)], rest[0]) = (1.0, slope);
            let Some(x) = solve(fixed, rest) else { return Row { left: 1.0, slope: 0.0 } };
            Vector4::new(slope, x[1], x[2], x[3])
        };
        let left = squares - 2.0 * x.dot(&right) + (gram * x).dot(&x);
        Row { left: left.max(0.0) / variance.max(f64::MIN_POSITIVE), slope: free[0] }
    }
}

/// Standard deviation.
pub(super) fn spread(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}
