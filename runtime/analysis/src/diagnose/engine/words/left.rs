//! What effects leave, in sentences: where, how much, what it goes with, and in what nothing is missing.
use super::text::short;
use crate::diagnose::engine::search::late::later;
use crate::diagnose::error_fall::LEFT;
use crate::diagnose::{Diagnosis, ErrorFall, Scope, Seen, Unexplained};
use crate::experiments::Channel;
use crate::experiments::signals::RATE_OF_LOAD;
use crate::log::names::list;
use crate::number::counting;

/// In what it is seen that something is left.
pub(super) fn seen(part: &Unexplained) -> String {
    match part.seen {
        Seen::Motion if part.signals.is_empty() => "is a function of the motion".to_owned(),
        Seen::Motion if part.signals[0].starts_with("constant ") => format!("is {}", part.signals[0]),
        Seen::Motion if part.signals[0].starts_with("time ") => format!(
            "changes with time, as where a sensor drifts or something warms up; it goes with {}",
            part.signals.join(", ")
        ),
        Seen::Motion if part.signals[0].starts_with(RATE_OF_LOAD) => format!(
            "follows how fast the torque between motor and link changes, as where a spring damps; it goes with {}",
            part.signals.join(", ")
        ),
        Seen::Motion => format!("is a function of the motion; it goes with {}", part.signals.join(", ")),
        Seen::Slowness if !part.signals.is_empty() => {
            format!("varies slowly, which noise hardly does; it goes with {}", part.signals.join(", "))
        }
        Seen::Slowness => {
            "varies slowly, which noise hardly does; what it goes with was not found; a sensor that drifts, or noise as slow as the motion, would look the same"
                .to_owned()
        }
        Seen::Size => "is more than noise; these are too few rows to see what it goes with".to_owned(),
        Seen::Excess => {
            "is more than neighbouring readings differ by; what it goes with was not found, and noise behind a slow filter would look the same"
                .to_owned()
        }
    }
}

/// So many times the noise: it was a simulator that had none.
const HARDLY_ANY: f64 = 100.0;

/// The row that is missed by most of its noise, and by how many times, if that is more than noise.
pub(super) fn loudest(d: &Diagnosis) -> Option<(&String, &ErrorFall, f64)> {
    let ratios = d.rows.iter().filter_map(|(row, fall)| Some((row, fall, fall.above_noise()?)));
    ratios.max_by(|a, b| a.2.total_cmp(&b.2))
}

/// What is said where the judging log is explained and the training log is not: the judge cannot tell what acts there.
pub(super) fn training_only(d: &Diagnosis) -> Option<String> {
    let (name, fall, times) = d.unseen_by_judge()?;
    let what = told_name(d, name);
    let (error, unit) = (short(fall.told()), &fall.unit);
    Some(format!(
        "The validation log is explained down to its noise, the training log is not: its {what} is missed by {error} {unit}, \
         {times:.1} times the noise. Something acts there that the validation log does not show: let a log judge in which it \
         acts too, or judge this one by its own blocks (without --validate)."
    ))
}

/// A row as it is named, a kind of channel in words.
fn told_name(d: &Diagnosis, name: &str) -> String {
    if d.rows_training.contains_key(name) { name.to_owned() } else { name.replace('_', " ") }
}

/// What is said where both logs are missed, and the training log by more.
fn more_in_training(d: &Diagnosis) -> String {
    let Some((name, fall, times)) = d.unseen_by_judge() else { return String::new() };
    let what = told_name(d, name);
    format!(
        " Of the training log more is left: its {what} is missed by {} {}, {times:.1} times the noise.",
        short(fall.told()),
        fall.unit
    )
}

/// The last sentence where nothing structured was seen in what is left.
pub(super) fn what_is_left(d: &Diagnosis) -> String {
    let further = if d.effects.is_empty() { "No" } else { "No further" };
    match loudest(d) {
        None => training_only(d).unwrap_or_else(|| at_jumps(d).unwrap_or_else(|| nothing_else(d))),
        Some((row, fall, ratio)) => {
            let times = if ratio > HARDLY_ANY {
                "and there is hardly any noise".to_owned()
            } else {
                format!("{ratio:.1} times the noise of its measurement")
            };
            format!(
                "{further} effect was found in {}. What is left is above the noise: {row} is missed by {} {}{}, {times}.",
                looked_at(d),
                short(fall.told()),
                fall.unit,
                match (fall.behind_both, fall.away_from_jumps, fall.after_moving) {
                    (Some(_), ..) => " behind two filters alike",
                    (_, Some(_), _) => " where nothing jumps",
                    (.., Some(_)) => " where it does not stick",
                    _ => "",
                },
            ) + &more_in_training(d)
                + &match d.late.get(row) {
                    Some(late) => later(*late),
                    None if ratio > HARDLY_ANY => String::new(),
                    None => {
                        " What it goes with was not found; noise behind a slow filter would look the same."
                            .to_owned()
                    }
                }
        }
    }
}

/// The last sentence where all is explained.
fn nothing_else(d: &Diagnosis) -> String {
    format!("Nothing else is missing in {}.{}", looked_at(d), taken_off(d))
}

/// The row that is above its noise behind this filter and not behind a faster one, or behind two alike.
pub(super) fn taken_off(d: &Diagnosis) -> String {
    let above = |fall: &ErrorFall| (fall.noise > 0.0).then(|| fall.told_here() / fall.noise);
    let is_settled = |fall: &ErrorFall| fall.behind_both.is_some() || fall.gone_at_hz.is_some();
    let rows = d.rows.iter().filter(|(_, fall)| is_settled(fall) && fall.above_noise().is_none());
    let loud = rows.filter_map(|(row, fall)| Some((row, fall, above(fall).filter(|times| *times > LEFT)?)));
    let Some((row, fall, times)) = loud.max_by(|a, b| a.2.total_cmp(&b.2)) else { return String::new() };
    format!(
        " Behind this filter {row} is missed by {} {}, {times:.1} times the noise: fast motion that the filter takes off; it is not left behind a faster one as well.",
        short(fall.told_here()),
        fall.unit
    )
}

/// The last sentence where all is explained but for what is left around jumps: what acts there alone would hide.
pub(super) fn at_jumps(d: &Diagnosis) -> Option<String> {
    let times = |fall: &ErrorFall| fall.after_moving.unwrap_or(fall.after) / fall.noise;
    let (row, fall) = d.left_at_jumps().max_by(|a, b| times(a.1).total_cmp(&times(b.1)))?;
    let further = if d.effects.is_empty() { "No" } else { "No further" };
    Some(format!(
        "{further} effect was found in {}. What is left is down to the noise where nothing jumps; around the moments at which joints \
         turn back or drives reach their limits, which the filter smears, {row} is missed by more, {} {} in all, {:.1} times the noise: \
         what acts there alone would not be seen.",
        looked_at(d),
        short(fall.after_moving.unwrap_or(fall.after)),
        fall.unit,
        times(fall)
    ))
}

/// Joints that were not looked at and are named.
const NAMED: usize = 6;

/// The kinds of channels that were compared, in words; of which joints, and for how long, if that is not all or little.
pub(super) fn looked_at(d: &Diagnosis) -> String {
    let Scope { short_s, joints, unseen } = &d.scope;
    let kind = |kind: &String| match kind == Channel::Effort.name() && !unseen.is_empty() {
        true => format!(
            "{kind} ({} of {joints} joints; not looked at: {})",
            joints - unseen.len(),
            list(unseen.iter().map(String::as_str), NAMED)
        ),
        false => kind.replace('_', " "),
    };
    let kinds = d.rms.keys().map(kind).collect::<Vec<_>>().join(", ");
    let little = |seconds: &f64| {
        format!("{kinds}, of which only {} s of motion were looked at", counting(*seconds, 2))
    };
    short_s.as_ref().map_or(kinds.clone(), little)
}
