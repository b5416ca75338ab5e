//! What is lost where forces, lever arms and motions pass a filter one by one.
//!
//! `D(q) q̈ + H(q, q̇) − Jᵀ(q) w` is made of products, and a filtered product is not the product of what was filtered: while a foot
//! tips or lands, the force changes within the filter's reach, and so does its arm. So the whole sum is computed once more, from
//! signals that a faster filter passed, and filtered as a whole; the difference belongs to the filtered samples.
//!
//! Inertia and ground are taken together: at an impact each of them is large, and only their sum is not.
use super::ContactRecording;
use super::foot::SIGNALS;
use super::forces::mapped;
use super::passing::Passing;
use crate::log::Block;
use crate::measure::trajectory::{Even, States, Unusable};
use crate::robot::Robot;
use crate::robot::calls::ModelCalls;
use crate::robot::feet::{FootCalls, Sole};
use crate::signal::Butterworth;
use bipedc_effects::diagnostic::Diagnostic;

/// Cut-off of the faster filter, as a multiple of the filter's own.
const FASTER: f64 = 4.0;
/// It must be so many times as fast at least.
const LEAST: f64 = 2.0;
/// The highest cut-off, as part of the sampling rate.
const HIGHEST: f64 = 0.4;
/// Samples per period of the faster cut-off at which the sum is computed.
const PER_PERIOD: f64 = 6.0;

/// Computes the sum from signals behind the faster filter.
pub(super) struct Products<'r> {
    calls: ModelCalls<'r>,
    feet: Vec<FootCalls>,
    inverse_dynamics: usize,
    faster: Butterworth,
    /// The filter of the log for every `thin`-th sample.
    slower: Butterworth,
    thin: usize,
    /// Samples at the ends of a stretch where the faster filter has only one side to look at.
    ends: usize,
}

impl<'r> Products<'r> {
    /// `None` where the log is too slow for a faster filter. Every `stride`-th sample is wanted.
    ///
    /// # Errors
    /// A model that lacks functions.
    pub fn new(
        robot: &Robot<'r>,
        cutoff_hz: f64,
        step: f64,
        stride: usize,
    ) -> Result<Option<Self>, Diagnostic> {
        let fast = (FASTER * cutoff_hz).min(HIGHEST / step);
        if fast < LEAST * cutoff_hz {
            return Ok(None);
        }
        let most = (1.0 / (step * PER_PERIOD * fast)) as usize;
        // The samples that are wanted must be among those that are computed.
        let thin = (1..=most.max(1)).rev().find(|thin| stride.is_multiple_of(*thin)).unwrap_or(1);
        let filters =
            (Butterworth::new(fast, 1.0 / step), Butterworth::new(cutoff_hz, 1.0 / (step * thin as f64)));
        let (Ok(faster), Ok(slower)) = filters else { return Ok(None) };
        let calls = ModelCalls::new(robot.model);
        let feet = robot.feet.iter().map(|foot| FootCalls::new(&calls, foot)).collect::<Result<_, _>>()?;
        let inverse_dynamics = calls.find("inverse_dynamics")?;
        let ends = (1.0 / (fast * step)).ceil() as usize;
        Ok(Some(Self { calls, feet, inverse_dynamics, faster, slower, thin, ends }))
    }

    /// The sum behind the filter at these samples of a block, whose distance is the stride; `at × nv`. `known`: the sum of what was
    /// filtered one by one, there.
    fn filtered(
        &self,
        passing: &Passing<'_, '_>,
        recording: &ContactRecording,
        (even, block): (&Even, &Block<'_>),
        (at, known): (&[usize], &[Vec<f64>]),
    ) -> Result<Vec<f64>, Unusable> {
        let (plan, count) = (&passing.columns.plan, block.time.len());
        let first = at.first().map_or(0, |at| at % self.thin);
        let wanted: Vec<usize> = (first..count).step_by(self.thin).collect();
        let states = even.states(plan, passing.robot.layout, &self.faster, block.time, 0..count)?;
        let mut feet = Vec::with_capacity(recording.feet.len());
        for (foot, record) in passing.robot.feet.iter().zip(&recording.feet) {
            feet.push(if record.is_logged {
                record.filtered(passing, &self.faster, block, foot, &wanted)?
            } else {
                Vec::new()
            });
        }
        let sums = wanted.iter().enumerate().map(|(k, i)| {
            if *i < self.ends || *i + self.ends >= count {
                return known[nearest(at, *i)].clone();
            }
            let wrench = |foot: usize| feet[foot].get(k).copied().unwrap_or([0.0; SIGNALS]);
            self.sum(passing.robot, recording, state(&states, *i), wrench)
        });
        let sums: Vec<Vec<f64>> = sums.collect();
        let nv = self.calls.nv;
        let mut out = vec![0.0; at.len() * nv];
        for row in 0..nv {
            let column: Vec<f64> = sums.iter().map(|sum| sum[row]).collect();
            let smooth = self.slower.zero_phase(&column);
            let picked = at.iter().map(|i| smooth[(i - first) / self.thin]);
            out.iter_mut().skip(row).step_by(nv).zip(picked).for_each(|(out, value)| *out = value);
        }
        Ok(out)
    }

    /// What the motion needs beyond what the ground gives, nv values.
    fn sum(
        &self,
        robot: &Robot<'_>,
        recording: &ContactRecording,
        [q, v, a]: [&[f64]; 3],
        signals: impl Fn(usize) -> [f64; SIGNALS],
    ) -> Vec<f64> {
        let mut sum = vec![0.0; self.calls.nv];
        self.calls.moving(self.inverse_dynamics, q, v, a, &mut sum);
        let wrench = |foot: usize, sole: &Sole| recording.feet[foot].wrench(sole, &signals(foot));
        let ground = mapped(robot, &self.calls, &self.feet, q, &recording.logged(), wrench);
        sum.iter_mut().zip(ground).for_each(|(sum, ground)| *sum -= ground);
        sum
    }
}

/// Index of the sample that is nearest to `i`.
fn nearest(at: &[usize], i: usize) -> usize {
    let after = at.partition_point(|at| *at < i).min(at.len() - 1);
    let before = after.saturating_sub(1);
    if at[before].abs_diff(i) < at[after].abs_diff(i) { before } else { after }
}

/// One of the states.
fn state(states: &States, i: usize) -> [&[f64]; 3] {
    let of = |values: &'_ [f64]| {
        let width = values.len() / states.count;
        i * width..(i + 1) * width
    };
    [&states.q[of(&states.q)], &states.v[of(&states.v)], &states.a[of(&states.a)]]
}

impl ContactRecording {
    /// Inertia, lever arms and forces as they passed the filter one by one, as most published figures are made.
    pub fn leave_out_products(&mut self) {
        self.products.fill(0.0);
    }

    /// Adds what was lost at the last samples of the recording, which are these samples of the block.
    pub(super) fn add_products(
        &mut self,
        passing: &Passing<'_, '_>,
        source: (&Even, &Block<'_>),
        at: &[usize],
    ) -> Result<(), Unusable> {
        let Some(products) = passing.products.as_ref().filter(|_| !at.is_empty()) else {
            self.products.resize(self.time.len() * passing.robot.model.nv(), 0.0);
            return Ok(());
        };
        let known = (self.time.len() - at.len()..self.time.len()).map(|i| {
            let part = self.trajectory.part(i..i + 1);
            products.sum(passing.robot, self, [part.q, part.v, part.a], |foot| self.feet[foot].signals[i])
        });
        let known: Vec<Vec<f64>> = known.collect();
        let whole = products.filtered(passing, self, source, (at, &known))?;
        self.products.extend(whole.iter().zip(known.iter().flatten()).map(|(whole, known)| whole - known));
        Ok(())
    }
}
