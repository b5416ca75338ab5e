//! Other readings of a log: what if a sign, a unit or two columns were mixed up?
use super::{Evidence, SAMPLES};
use nalgebra::{Matrix4, Vector4};
use std::f64::consts::PI;

/// Effects of the library leave the slope of the torque over the model's within this.
const SLOPE: (f64, f64) = (0.3, 3.0);
/// A torque counts as a signal if it varies by so many standard deviations of its noise.
const SIGNAL: f64 = 5.0;
/// Speed below which friction is smeared, rad/s.
const SMOOTHING: f64 = 0.02;

/// One thing that may be mixed up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mixup {
    EffortSign(usize),
    /// The logged effort is this many times too large.
    EffortUnit(usize, f64),
    PositionSign(usize),
    Degrees(usize),
    PositionsSwapped(usize, usize),
    EffortsSwapped(usize, usize),
}

/// Some samples of a log as they are read under a hypothesis.
#[derive(Clone)]
pub(super) struct View {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// Torques of the model, `samples × nv`.
    load: Vec<f64>,
    /// By joint; empty where there is none, or none that exceeds its noise.
    effort: Vec<Vec<f64>>,
}

impl View {
    /// As logged, evenly thinned.
    pub fn new(evidence: &Evidence<'_>) -> Self {
        let r = evidence.recording;
        let stride = r.time.len().div_ceil(SAMPLES).max(1);
        let (nq, nv) = evidence.widths;
        let pick = |values: &[f64], width: usize| -> Vec<f64> {
            values.chunks_exact(width).step_by(stride).flatten().copied().collect()
        };
        let effort = r.effort.iter().zip(&r.noise).map(|(effort, noise)| match effort {
            Some(effort) if spread(effort) > SIGNAL * noise => pick(effort, 1),
            _ => Vec::new(),
        });
        let (q, v, a) = (pick(&r.q, nq), pick(&r.v, nv), pick(&r.a, nv));
        let load = (evidence.torques)(&q, &v, &a);
        Self { q, v, a, load, effort: effort.collect() }
    }

    /// Joints whose torque is more than noise.
    pub fn joints(&self) -> Vec<usize> {
        (0..self.effort.len()).filter(|&joint| !self.effort[joint].is_empty()).collect()
    }

    /// Range of a joint's position.
    pub fn range(&self, evidence: &Evidence<'_>, joint: usize) -> f64 {
        let at = |i: usize| self.q[i * evidence.widths.0 + evidence.offsets.0 + joint];
        let samples = self.q.len() / evidence.widths.0;
        let (low, high) = (0..samples).map(at).fold((f64::MAX, f64::MIN), |(l, h), q| (l.min(q), h.max(q)));
        high - low
    }

    /// The log read again as if this had been mixed up.
    pub fn under(&self, evidence: &Evidence<'_>, mixup: Mixup) -> Self {
        let mut view = self.clone();
        match mixup {
            Mixup::EffortSign(joint) => view.effort[joint].iter_mut().for_each(|u| *u = -*u),
            Mixup::EffortUnit(joint, factor) => view.effort[joint].iter_mut().for_each(|u| *u /= factor),
            Mixup::EffortsSwapped(one, other) => view.effort.swap(one, other),
            Mixup::PositionSign(joint) => view.scale(evidence, joint, -1.0),
            Mixup::Degrees(joint) => view.scale(evidence, joint, PI / 180.0),
            Mixup::PositionsSwapped(one, other) => {
                let (oq, ov) = evidence.offsets;
                view.q.chunks_exact_mut(evidence.widths.0).for_each(|q| q.swap(oq + one, oq + other));
                for values in [&mut view.v, &mut view.a] {
                    values.chunks_exact_mut(evidence.widths.1).for_each(|v| v.swap(ov + one, ov + other));
                }
            }
        }
        if matches!(mixup, Mixup::PositionSign(_) | Mixup::Degrees(_) | Mixup::PositionsSwapped(..)) {
            view.load = (evidence.torques)(&view.q, &view.v, &view.a);
        }
        view
    }

    fn scale(&mut self, evidence: &Evidence<'_>, joint: usize, factor: f64) {
        let ((nq, nv), (oq, ov)) = (evidence.widths, evidence.offsets);
        self.q.iter_mut().skip(oq + joint).step_by(nq).for_each(|q| *q *= factor);
        for values in [&mut self.v, &mut self.a] {
            values.iter_mut().skip(ov + joint).step_by(nv).for_each(|v| *v *= factor);
        }
    }

    /// Part of the variance of each joint's torque that model, friction and bias leave; 0 without a torque.
    pub fn unexplained(&self, evidence: &Evidence<'_>) -> Vec<f64> {
        (0..self.effort.len())
            .map(|joint| if self.effort[joint].is_empty() { 0.0 } else { self.row(evidence, joint) })
            .collect()
    }

    fn row(&self, evidence: &Evidence<'_>, joint: usize) -> f64 {
        let (nv, offset) = (evidence.widths.1, evidence.offsets.1 + joint);
        let regressors = |i: usize| {
            let (load, v) = (self.load[i * nv + offset], self.v[i * nv + offset]);
            Vector4::new(load, (v / SMOOTHING).tanh(), v, 1.0)
        };
        let effort = &self.effort[joint];
        let (mut gram, mut right, mut squares) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
        for (i, u) in effort.iter().enumerate() {
            let x = regressors(i);
            gram += x * x.transpose();
            right += x * *u;
            squares += u * u;
        }
        let mean = right[3] / effort.len() as f64;
        let variance = squares - mean * right[3];
        // A column that is zero throughout must not spoil the others.
        let ridge = Matrix4::from_diagonal(&gram.diagonal().map(|d| 1e-9 * d + 1e-30));
        let solve = |gram: Matrix4<f64>, right: Vector4<f64>| (gram + ridge).lu().solve(&right);
        let Some(free) = solve(gram, right) else { return 1.0 };
        let slope = free[0].clamp(SLOPE.0, SLOPE.1);
        let x = if slope == free[0] {
            free
        } else {
            // The slope is given: the others follow.
            let (mut fixed, mut rest) = (gram, right - gram.column(0) * slope);
            fixed.row_mut(0).fill(0.0);
            fixed.column_mut(0).fill(0.0);
            (fixed[(0, 0)], rest[0]) = (1.0, slope);
            let Some(x) = solve(fixed, rest) else { return 1.0 };
            Vector4::new(slope, x[1], x[2], x[3])
        };
        let left = squares - 2.0 * x.dot(&right) + (gram * x).dot(&x);
        left.max(0.0) / variance.max(f64::MIN_POSITIVE)
    }
}

/// Standard deviation.
fn spread(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}
