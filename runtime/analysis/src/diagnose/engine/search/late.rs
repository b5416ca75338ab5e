//! Torques that are reported later than the motion: behind a filter of their sensor, or by another clock.
//!
//! That is a delay of less than nothing: a drive's has the torque come after its command. A torque that is L late is, to first order, τ − L τ̇, so that what is left goes with
//! the rate of the torque, against its sign.
use crate::diagnose::Diagnosis;
use crate::diagnose::engine::refine::amended::Amended;
use crate::experiments::{Channel, Experiment};
use crate::number::counting;
use bipedc_effects::effect::{Effect, Law};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const WHY: &str = "behind a filter of its sensor, or by another clock";

/// Of what is left of a torque that is reported late, s.
pub(crate) fn later(late: f64) -> String {
    let late = counting(1e3 * late, 2);
    format!(" Most of it is what a torque leaves that is reported {late} ms later than the motion: {WHY}.")
}

/// What delays of less than nothing are, if there are any.
pub(crate) fn reported_late(d: &Diagnosis) -> String {
    let is_early = |effect: &&Effect| effect.kind.law == Law::Delay && effect.value("delay") < 0.0;
    let early: Vec<&Effect> = d.effects.iter().map(|found| &found.effect).filter(is_early).collect();
    let mut out = String::new();
    if !early.is_empty() {
        let places: Vec<String> = early.iter().map(|effect| effect.location.to_string()).collect();
        let lags = || early.iter().map(|effect| -1e3 * effect.value("delay"));
        let (least, most) = (lags().fold(f64::INFINITY, f64::min), lags().fold(0.0, f64::max));
        let (least, most) = (counting(least, 2), counting(most, 2));
        let lags = if least == most { most } else { format!("{least} to {most}") };
        let _ = writeln!(
            out,
            "A negative delay: the torque of {} is reported {lags} ms later than it acts, {WHY}.",
            places.join(", ")
        );
    }
    out
}

/// Part of what is left of a row's squares beyond its noise that lateness must make, and of all that is left.
const TELLS: f64 = 0.5;
const SHOWS: f64 = 0.15;
/// Steps that are so many times as long as the middle one are gaps.
const GAP: f64 = 1.5;

/// How late the torques of rows are in which that makes most of what is left, s.
pub(crate) fn late(judge: &Amended<'_>) -> BTreeMap<String, f64> {
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
