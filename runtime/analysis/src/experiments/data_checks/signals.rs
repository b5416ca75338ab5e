//! Channels that stop telling: clipped torques, encoders that are stuck.
use super::{Evidence, list};
use crate::measure::Recording;
use bipedc_effects::diagnostic::Diagnostic;
use std::ops::Range;

/// Part of the samples that must lie at the limit.
const PILE: f64 = 0.01;
/// The limit must be so much more frequent than the next value: quantised signals have many of each.
const STEEPER: f64 = 4.0;
/// A joint that reads the same for so long is not measured, s.
const STUCK: f64 = 0.5;

/// Warnings about clipped and stuck channels.
pub(super) fn check(evidence: &Evidence<'_>) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (joint, (name, _)) in evidence.joints.iter().enumerate() {
        let limits: Vec<f64> = match &evidence.recording.effort[joint] {
            Some(effort) => limits(effort).collect(),
            None => Vec::new(),
        };
        if !limits.is_empty() {
            let values: Vec<String> = limits.iter().map(|l| format!("{l}")).collect();
            let message = format!(
                "the effort of `{name}` is clipped at {}: beyond it the log does not tell the torque",
                values.join(" and ")
            );
            let help = "log with a wider range, or move with less torque";
            found.push(Diagnostic::warning(message).help(help));
        }
    }
    found.extend(constant(evidence));
    found.extend(stuck(evidence));
    found
}

/// Most of the samples that a clipped effort may lie at its limits.
const SELDOM: f64 = 0.4;

/// Samples at which an effort is clipped, one flag each; empty where none is, or so many are that the limits are all that it has.
pub(crate) fn clipped(effort: &[f64]) -> Vec<bool> {
    let limits: Vec<f64> = limits(effort).collect();
    if limits.is_empty() {
        return Vec::new();
    }
    // On the other side too, where too few samples lie to be seen.
    let flags: Vec<bool> = effort.iter().map(|u| limits.iter().any(|l| is_at(u.abs(), l.abs()))).collect();
    let count = flags.iter().filter(|clipped| **clipped).count();
    if count as f64 > SELDOM * effort.len() as f64 { Vec::new() } else { flags }
}

/// Values at which an effort piles up on one side or the other.
fn limits(effort: &[f64]) -> impl Iterator<Item = f64> {
    [1.0, -1.0].into_iter().filter_map(|sign| limit(effort, sign))
}

/// Whether a value is a limit but for rounding.
fn is_at(value: f64, limit: f64) -> bool {
    (value - limit).abs() <= 1e-9 * limit.abs().max(1e-12)
}

/// Efforts that never change while their joints move: nothing was measured. An error if there are no others.
fn constant(evidence: &Evidence<'_>) -> Option<Diagnostic> {
    let efforts =
        || evidence.recording.effort.iter().enumerate().filter_map(|(j, of)| Some((j, of.as_ref()?)));
    let moves = |joint: usize| size(&evidence.velocity(joint).collect::<Vec<_>>()) > 0.0;
    let same = |values: &[f64]| values.iter().all(|x| *x == values[0]);
    let silent: Vec<&str> = efforts()
        .filter(|(joint, effort)| moves(*joint) && same(effort))
        .map(|(joint, _)| evidence.joints[joint].0)
        .collect();
    let columns = list(
        silent.iter().map(|name| format!("{name}/effort")).collect::<Vec<_>>().iter().map(String::as_str),
    );
    let help =
        "were the torques not logged, or by another name? leave the columns out, or give a mapping file";
    match silent.len() {
        0 => None,
        n if n == efforts().count() => Some(
            Diagnostic::error(format!("no effort changes ({columns}): the log tells nothing of torques"))
                .help(help),
        ),
        _ => Some(Diagnostic::warning(format!("never change while their joints move: {columns}")).help(help)),
    }
}

/// One warning for all encoders that are stuck.
fn stuck(evidence: &Evidence<'_>) -> Option<Diagnostic> {
    let usual: Vec<f64> =
        (0..evidence.joints.len()).map(|joint| size(&evidence.velocity(joint).collect::<Vec<_>>())).collect();
    let of_joint =
        |joint| stretch(evidence, &usual, joint).map(|(from, to)| (evidence.joints[joint].0, from, to));
    let found: Vec<(&str, f64, f64)> = (0..usual.len()).filter_map(of_joint).collect();
    let when = |(_, from, to): &(&str, f64, f64)| format!("from {from:.2} s to {to:.2} s");
    let message = match found.as_slice() {
        [] => return None,
        [one] => format!(
            "the position of {} does not change at all {} while others move",
            list([one.0]),
            when(one)
        ),
        many => {
            let each =
                many.iter().map(|one| format!("`{}` {}", one.0, when(one))).collect::<Vec<_>>().join(", ");
            format!("the positions of {} joints do not change at all while others move: {each}", many.len())
        }
    };
    let help = "is an encoder stuck, or were its messages lost? leave the stretch out with --from, --to";
    Some(Diagnostic::warning(message).help(help))
}

/// Root mean square.
fn size(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// The value at which a signal ends on one side, if it piles up there.
fn limit(values: &[f64], sign: f64) -> Option<f64> {
    let signed = |v: &f64| sign * v;
    let top = values.iter().map(signed).fold(f64::NEG_INFINITY, f64::max);
    let near = |level: f64| values.iter().map(signed).filter(move |v| is_at(*v, level)).count() as f64;
    let count = near(top);
    if top == 0.0 || count < (PILE * values.len() as f64).max(10.0) {
        return None;
    }
    let below = values.iter().map(signed).filter(|v| *v < top * (1.0 - 1e-9 * top.signum()));
    let next = below.fold(f64::NEG_INFINITY, f64::max);
    (next.is_finite() && count > STEEPER * near(next)).then_some(sign * top)
}

/// The longest stretch in which a joint's position is exactly constant while most of the others move as they usually do: where
/// joints move one at a time, all but one rest by design, and one that lies at its stop is held by it. `usual` are their speeds.
fn stretch(evidence: &Evidence<'_>, usual: &[f64], joint: usize) -> Option<(f64, f64)> {
    let v: Vec<f64> = evidence.velocity(joint).collect();
    let usual_here = usual[joint];
    if usual_here < 1e-3 {
        return None;
    }
    // The filter spreads the rest over some samples, so that not every one is exactly still.
    let Recording { stops, time, cutoff_hz, .. } = evidence.recording;
    let held = stops.flags(joint, time, *cutoff_hz);
    let still =
        |i: usize| v.get(i).is_some_and(|v| v.abs() < 1e-5 * usual_here) && held.get(i) != Some(&true);
    let (mut best, mut first) = (0..0, None);
    for i in 0..=v.len() {
        match (still(i), first) {
            (true, None) => first = Some(i),
            (false, Some(from)) => {
                if i - from > best.len() {
                    best = from..i;
                }
                first = None;
            }
            _ => {}
        }
    }
    let r = evidence.recording;
    if (best.len() as f64) * r.step < STUCK {
        return None;
    }
    most_move(evidence, usual, joint, best.clone()).then(|| (r.time[best.start], r.time[best.end - 1]))
}

/// Whether most of the other joints move at once, most of the time.
fn most_move(evidence: &Evidence<'_>, usual: &[f64], joint: usize, stretch: Range<usize>) -> bool {
    let others = (0..usual.len()).filter(|&other| other != joint && usual[other] > 1e-2);
    let others: Vec<usize> = others.collect();
    let mut moving = vec![0; stretch.len()];
    for &other in &others {
        let speeds = evidence.velocity(other).skip(stretch.start);
        for (count, v) in moving.iter_mut().zip(speeds) {
            *count += usize::from(v.abs() > 0.2 * usual[other]);
        }
    }
    let samples = moving.iter().filter(|count| 2 * **count > others.len()).count();
    2 * samples > stretch.len()
}

#[cfg(test)]
mod tests {
    use super::limit;

    #[test]
    fn piles_are_limits_and_sines_are_not() {
        let sine: Vec<f64> = (0..4000).map(|i| 3.0 * (0.013 * f64::from(i)).sin()).collect();
        assert_eq!((limit(&sine, 1.0), limit(&sine, -1.0)), (None, None));
        let clipped: Vec<f64> = sine.iter().map(|x| x.min(2.5)).collect();
        assert_eq!((limit(&clipped, 1.0), limit(&clipped, -1.0)), (Some(2.5), None));
        // Coarse steps put many samples on the highest one, but as many on the next.
        let coarse: Vec<f64> = sine.iter().map(|x| (x * 4.0).round() / 4.0).collect();
        assert_eq!((limit(&coarse, 1.0), limit(&coarse, -1.0)), (None, None));
    }
}
