//! What the effects leave unexplained.
use crate::diagnose::engine::equations::regression::NOISE_MARGIN;
use crate::diagnose::engine::equations::smoother::{self, reach};
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::{Seen, Unexplained};
use crate::experiments::corners::{Corners, corners};
use crate::experiments::{Channel, Experiment};
use crate::number::counting;
use crate::parallel::parallel;
use bipedc_effects::effect::Effect;

/// A smooth function must lower a row's held-out squared error by this to call something unexplained.
const UNEXPLAINED: f64 = 0.05;
/// What a smooth function lowers by this is seen nearer to the noise too, down to so many times its square: no noise does that in another log.
const PLAIN: f64 = 0.2;
const PLAIN_MARGIN: f64 = 1.25;
/// A residual of which so much varies slowly is no noise, whatever it goes with.
const SLOW: f64 = 0.35;
/// Part of a row's squared error without effects that may be left: the inaccuracy of their forms.
const TRACE: f64 = 2e-4;
/// What a smooth function lowers by this is a function of the signals, however little it is.
const CLEARLY: f64 = 0.5;
/// A constant that makes this part of what a function of the motion would explain is all that there is to it.
const MOSTLY: f64 = 0.8;
/// So many times the noise of the measurement, what varies slowly is no noise of a narrow filter.
const LOUD: f64 = 1.8;
/// Noise of motion may be so many times what it is taken for: that of a joint which is held depends on where between two steps of its encoder it is.
const UNSURE: f64 = 1.3;
/// So many times the noise is no noise, where the rows are too few to see what goes with what.
const FEW: f64 = 3.0;
/// So many times what is left of the judging log is of something that it does not know.
const UNTAUGHT: f64 = 10.0;
/// What varies over this time is slow, s.
const SLOW_TIME: f64 = 0.15;

/// Part of a residual's squares that survives averaging over [`SLOW_TIME`]; 0 for tables.
fn slow_share(time: &[f64], residual: &[f64]) -> f64 {
    let n = residual.len();
    let step = if n > 1 { (time[n - 1] - time[0]) / (n - 1) as f64 } else { 0.0 };
    // Tables count postures and impacts: their numbers are no times.
    let half = (0.5 * SLOW_TIME / step.max(1e-9)) as usize;
    if half < 4 || n < 20 * half || step >= 0.5 {
        return 0.0;
    }
    let mut sums = vec![0.0; n + 1];
    for i in 0..n {
        sums[i + 1] = sums[i] + residual[i];
    }
    let averaged: f64 = (half..n - half)
        .map(|i| ((sums[i + half + 1] - sums[i - half]) / (2 * half + 1) as f64).powi(2))
        .sum();
    let all: f64 = residual.iter().map(|x| x * x).sum();
    averaged / all.max(f64::MIN_POSITIVE)
}

/// Mean over the samples that count.
fn mean(values: &[f64], counts: &dyn Fn(usize) -> bool) -> f64 {
    let counted = (0..values.len()).filter(|&i| counts(i));
    let (sum, count) = counted.fold((0.0, 0.0_f64), |(sum, count), i| (sum + values[i], count + 1.0));
    sum / count.max(1.0)
}

/// Part of the squares that one number makes.
fn constant_share(values: &[f64], counts: &dyn Fn(usize) -> bool) -> f64 {
    let counted = || (0..values.len()).filter(|&i| counts(i));
    let squares: f64 = counted().map(|i| values[i] * values[i]).sum();
    mean(values, counts).powi(2) * counted().count() as f64 / squares.max(f64::MIN_POSITIVE)
}

/// Rows of which the log that teaches leaves many times more than the one that judges, in words, with the time at which it does: what was
/// learnt there is of something else.
pub(crate) fn untaught(train: &Amended<'_>, judge: &Amended<'_>, resolutions: &[f64]) -> Vec<String> {
    let told = |of: &Amended<'_>, row: usize| -> Vec<f64> {
        let sticks = of.sticks(row);
        let told = |(i, x): (usize, &f64)| if sticks.get(i).is_some_and(|sticks| *sticks) { 0.0 } else { *x };
        of.residual(row).iter().enumerate().map(told).collect()
    };
    let rms =
        |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let sentence = |row: usize| {
        let values = told(train, row);
        let (taught, judged) = (rms(&values), rms(&told(judge, row)));
        if taught <= UNTAUGHT * judged.max(resolutions[row]) {
            return None;
        }
        let all: f64 = values.iter().map(|x| x * x).sum();
        let sums: Vec<f64> = values
            .iter()
            .scan(0.0, |sum, x| {
                *sum += x * x;
                Some(*sum)
            })
            .collect();
        let at = |part: f64| train.time()[sums.partition_point(|sum| *sum < part * all).min(sums.len() - 1)];
        let what = &train.rows()[row];
        Some(format!(
            "`{}`: {} {} are left of the log that teaches, {} of the one that judges; most of it between {:.2} and {:.2} s. What \
             was learnt there does not hold elsewhere: look at that time, or leave it out with --from and --to",
            what.name,
            counting(taught, 3),
            what.unit,
            counting(judged, 3),
            at(0.05),
            at(0.95)
        ))
    };
    (0..train.rows().len()).filter_map(sentence).collect()
}

/// Rows in which a smooth function of the signals would still lower the held-out error.
pub(crate) fn unexplained(
    train: &Amended<'_>,
    judge: &Amended<'_>,
    counts: &(dyn Fn(usize, usize) -> bool + Sync),
    (effects, resolutions): (&[Effect], &[f64]),
) -> Vec<Unexplained> {
    // Those of an amended description turn about as they did when they were found.
    let effects = &[judge.described(), effects].concat();
    let parts = parallel(train.rows().len(), |row| {
        Row { train, judge, counts, effects, row, resolution: resolutions[row] }.unexplained()
    });
    let mut parts: Vec<Unexplained> = parts.into_iter().flatten().collect();
    parts.sort_by(|a, b| b.share.total_cmp(&a.share));
    parts
}

/// One row, and what it takes to judge what is left of it.
struct Row<'a> {
    train: &'a Amended<'a>,
    judge: &'a Amended<'a>,
    counts: &'a (dyn Fn(usize, usize) -> bool + Sync),
    effects: &'a [Effect],
    row: usize,
    resolution: f64,
}

impl Row<'_> {
    fn unexplained(&self) -> Option<Unexplained> {
        let judge_corners = corners(self.judge, self.row, self.effects);
        let judged = |i: usize| told(self.judge, self.row, &judge_corners, i);
        let left = self.judge.residual(self.row);
        let moving: Vec<f64> =
            left.iter().enumerate().map(|(i, x)| if judged(i) { *x } else { 0.0 }).collect();
        // What is left of an effect that was hundreds of times larger is the inaccuracy of its form.
        let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
        let matters = squares(&moving) > TRACE * squares(self.judge.nominal(self.row));
        let each = squares(&moving) / left.len().max(1) as f64;
        let beyond = |noise: f64| each / noise.powi(2).max(f64::MIN_POSITIVE);
        // What the encoders' noise makes of the model's torque goes with the motion that they tell, as what feet's sensors and the base's make of it does.
        let in_signals = (UNSURE * UNSURE - 1.0).sqrt() * self.judge.noise_in_signals(self.row);
        let size =
            beyond(self.resolution.hypot(in_signals).hypot(UNSURE * self.judge.motion_noise(self.row)));
        // Nor is where within a step of their encoders joints rest; and where nothing tells what goes with what, the encoders' noise.
        let [angles, motions] = self.judge.within_steps(self.row);
        let resting = self.resolution.hypot(angles).hypot(motions);
        // Whatever it goes with, so little is noise.
        if size <= PLAIN_MARGIN && beyond(resting) <= LOUD.powi(2) {
            return None;
        }
        let [a, b] = [self.train, self.judge].map(|of| smoother::signals(of, self.row));
        if a.is_empty() {
            return None;
        }
        let Some(smooth) = self.smooth_share((&a, &b), &judged) else {
            return (matters && beyond(resting.hypot(self.judge.motion_noise(self.row))) > FEW.powi(2))
                .then(|| self.named(Seen::Size, 1.0 - 1.0 / beyond(self.resolution), Vec::new()));
        };
        // Between two encoders there is no motion to be known: what follows the signals there is no inaccuracy.
        let between = self.train.rows()[self.row].channel == Channel::Transmission;
        let matters = matters || (between && smooth > CLEARLY);
        let slow = slow_share(self.judge.time(), &moving);
        let (seen, share) = match (smooth > UNEXPLAINED, slow > SLOW) {
            (true, _) if size > NOISE_MARGIN || (smooth > PLAIN && size > PLAIN_MARGIN) => {
                (Seen::Motion, smooth)
            }
            // What encoders that count in steps make of slow motion is slow too.
            (_, true) if beyond(resting) > LOUD.powi(2) && size > 1.0 => (Seen::Slowness, slow),
            _ => return None,
        };
        let is_constant = seen == Seen::Motion && constant_share(&moving, &judged) > MOSTLY * smooth;
        let signals = match is_constant {
            true => {
                let unit = &self.train.rows()[self.row].unit;
                vec![format!("constant ({} {unit})", counting(mean(&moving, &judged), 3))]
            }
            false => goes_with(&b, left, seen),
        };
        matters.then(|| self.named(seen, share, signals))
    }

    /// Part of the judged squares that a smooth function of the signals removes; `None` where samples are too few.
    fn smooth_share(
        &self,
        (a, b): (&smoother::Signals, &smoother::Signals),
        judged: &dyn Fn(usize) -> bool,
    ) -> Option<f64> {
        let (r, s) = (self.train.residual(self.row), self.judge.residual(self.row));
        let own_blocks = std::ptr::eq(self.train.time().as_ptr(), self.judge.time().as_ptr());
        let train_corners = corners(self.train, self.row, self.effects);
        // Where the joint reverses, friction is smeared by the filter: no reason to doubt the effects.
        let smeared = self.effects.iter().any(|e| e.kind.follows_velocity());
        let speed = |signals: &smoother::Signals| {
            let v = &signals[1].1;
            0.15 * (v.iter().map(|x| x * x).sum::<f64>() / v.len().max(1) as f64).sqrt()
        };
        let (slow_a, slow_b) = if smeared { (speed(a), speed(b)) } else { (0.0, 0.0) };
        let counts = self.counts;
        let trains = |i: usize| {
            told(self.train, self.row, &train_corners, i)
                && a[1].1[i].abs() >= slow_a
                && (!own_blocks || !counts(i, r.len()))
        };
        let judges = |i: usize| judged(i) && b[1].1[i].abs() >= slow_b && counts(i, s.len());
        let reach = reach((a, r, &trains), (b, s, &judges))?;
        Some(1.0 - reach.after / reach.before.max(f64::MIN_POSITIVE))
    }

    fn named(&self, seen: Seen, share: f64, signals: Vec<String>) -> Unexplained {
        let what = &self.train.rows()[self.row];
        // A joint has a torque, and perhaps an angle between its motor and its link.
        let of_joint = what.joint.as_ref().filter(|_| what.channel != Channel::Transmission);
        let joint = of_joint.unwrap_or(&what.name).clone();
        Unexplained { joint, share, signals, seen, late_s: None }
    }
}

/// Where a joint sticks, its friction is what is needed there, within its bounds; where it turns about, what the filter makes of it.
fn told(of: &Amended<'_>, row: usize, corners: &Corners, i: usize) -> bool {
    !of.sticks(row).get(i).is_some_and(|sticks| *sticks) && !corners.hold(i)
}

/// Signals that what is left goes with, with their correlations.
fn goes_with(signals: &smoother::Signals, left: &[f64], seen: Seen) -> Vec<String> {
    // A drift goes with some signal or other by chance.
    let least = if seen == Seen::Motion { 0.15 } else { 0.5 };
    let heard = smoother::correlated(signals, left).into_iter().filter(|(_, c)| c.abs() > least);
    heard.take(4).map(|(name, c)| format!("{name} ({c:+.2})")).collect()
}
