//! Torques that are reported later than the motion: behind a filter of their sensor, or by another clock.
//!
//! No drive does that, whose delay has the torque come after its command. A torque that is L late is, to first order, τ − L τ̇, so that what is left goes with
//! the rate of the torque, against its sign.
use super::amended::Amended;
use crate::experiments::{Channel, Experiment};
use std::collections::BTreeMap;

/// Part of what is left of a row's squares beyond its noise that lateness must make, and of all that is left.
const TELLS: f64 = 0.5;
const SHOWS: f64 = 0.15;
/// Steps that are so many times as long as the middle one are gaps.
const GAP: f64 = 1.5;

/// How late the torques of rows are in which that makes most of what is left, s.
pub(super) fn late(judge: &Amended<'_>) -> BTreeMap<String, f64> {
    let efforts = judge.rows().iter().enumerate().filter(|(_, row)| row.channel == Channel::Effort);
    efforts.filter_map(|(row, what)| Some((what.name.clone(), lag(judge, row)?))).collect()
}

fn lag(judge: &Amended<'_>, row: usize) -> Option<f64> {
    let (measured, left, time) = (judge.measured(row)?, judge.residual(row), judge.time());
    let sticks = judge.sticks(row);
    if measured.len() != left.len() || left.len() != time.len() || left.len() < 3 {
        return None;
    }
    let modelled = |i: usize| measured[i] - left[i];
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let usual = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let (mut both, mut rates, mut squares, mut noise) = (0.0, 0.0, 0.0, 0.0);
    for i in 1..left.len() - 1 {
        let step = time[i + 1] - time[i - 1];
        if step > 2.0 * GAP * usual || sticks.get(i).is_some_and(|sticks| *sticks) {
            continue;
        }
        let rate = (modelled(i + 1) - modelled(i - 1)) / step;
        both += rate * left[i];
        rates += rate * rate;
        squares += left[i] * left[i];
        noise += judge.rows()[row].noise.powi(2);
    }
    let made = both * both / rates;
    (both < 0.0 && made > TELLS * (squares - noise) && made > SHOWS * squares).then(|| -both / rates)
}
