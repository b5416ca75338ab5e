//! A diagnosis as sentences.
use super::left::{at_jumps, looked_at, loudest, seen, taken_off, training_only, what_is_left};
use super::sentence::sentence;
use super::told_apart::alike;
use crate::diagnose::engine::search::late::{later, reported_late};
use crate::diagnose::error_fall::LEFT;
use crate::diagnose::{Diagnosis, ErrorFall, rises};
use crate::number::counting;
use std::fmt::Write as _;

/// A number with four significant digits.
pub(crate) fn short(x: f64) -> String {
    counting(x, 4)
}

/// The effects of the description that were estimated again, with the values that they had.
fn described(d: &Diagnosis) -> String {
    let mut out = String::new();
    for was in &d.described {
        let Some(found) = d
            .standing
            .iter()
            .find(|found| found.effect.kind == was.kind && found.effect.location == was.location)
        else {
            continue;
        };
        let told = found.ci95.iter().map(|(name, [low, high])| {
            let value = format!("{name} {} → {}", short(was.value(name)), short(found.effect.value(name)));
            let unit = Some(was.unit(name))
                .filter(|unit| *unit != "1")
                .map_or(String::new(), |unit| format!(" {unit}"));
            match (high - low).is_finite() {
                true => format!("{value}{unit} (95 %: {} to {})", short(*low), short(*high)),
                false => format!("{value}{unit}, which this data cannot tell"),
            }
        });
        let told: Vec<String> = told.collect();
        let _ = writeln!(
            out,
            "{}: {} of the description, estimated again: {}.",
            was.location,
            was.kind.title,
            told.join("; ")
        );
    }
    if !out.is_empty() && d.effects.is_empty() && d.inertial_corrections.is_empty() {
        let unit = d.rms.values().find(|f| f.before == d.rms_before).map_or("", |f| f.unit.as_str());
        let _ = writeln!(out, "Held-out error {} → {} {unit}.", short(d.rms_before), short(d.rms_after));
    }
    out
}

/// The held-out error without the samples at which joints stick, where that is another one.
fn where_free(d: &Diagnosis) -> String {
    let fall = d.rms.values().find(|fall| fall.before == d.rms_before);
    let free = fall.and_then(|fall| Some((fall.where_free()?, &fall.unit)));
    free.map_or_else(String::new, |([before, after], unit)| {
        format!(", where joints do not stick {} → {} {unit}", short(before), short(after))
    })
}

/// Kinds of channels whose held-out error is larger with the answer, though another falls.
fn risen(d: &Diagnosis) -> String {
    let risen = d.rms.iter().filter(|(_, fall)| rises(fall.before, fall.after, fall.noise));
    let told = |(kind, fall): (&String, &ErrorFall)| {
        let [before, after] = [fall.before, fall.after].map(short);
        format!("That of the {} rises by it, {before} → {after} {}.\n", kind.replace('_', " "), fall.unit)
    };
    risen.map(told).collect()
}

/// The whole answer, from its numbers.
pub fn summary(d: &Diagnosis) -> String {
    let unit = d.rms.values().find(|f| f.before == d.rms_before).map_or("", |f| f.unit.as_str());
    if d.effects.is_empty() && d.inertial_corrections.is_empty() && !d.leaves_structure() {
        return match (loudest(d), training_only(d).or_else(|| at_jumps(d))) {
            (Some(_), _) => described(d) + &what_is_left(d),
            (None, Some(said)) => described(d) + &said,
            (None, None) => format!(
                "{}Nothing {}is missing in {}: the held-out error of {} {unit} is what {}.{}",
                described(d),
                if d.described.is_empty() { "" } else { "else " },
                looked_at(d),
                short(d.rms_after),
                left_by(d),
                taken_off(d)
            ),
        };
    }
    let mut out = another_robot(d).unwrap_or_default() + &described(d);
    for found in &d.effects {
        let _ = writeln!(out, "{}", sentence(d, found));
    }
    out.push_str(&reported_late(d));
    out.push_str(&opposed(d));
    if !d.inertial_corrections.is_empty() {
        let links: Vec<&str> =
            d.inertial_corrections.iter().filter_map(|f| f.effect.location.link.as_deref()).collect();
        let doubt = d.inertial_corrections.iter().find_map(|found| found.doubts.last());
        let _ = writeln!(
            out,
            "Masses, centres of mass and inertias were estimated beside the effects, and differ: {}.{}",
            links.join(", "),
            doubt.map_or_else(String::new, |doubt| format!(" Doubtful: {doubt}."))
        );
    }
    let filter = d.judged_at_hz.map_or(String::new(), |hz| format!(", both behind a filter of {hz} Hz"));
    let (before, after) = (short(d.rms_before), short(d.rms_after));
    let _ = writeln!(out, "Held-out error {before} → {after} {unit}{}{filter}.", where_free(d));
    out.push_str(&risen(d));
    for group in &d.indistinguishable {
        let _ = writeln!(out, "{}", alike(group, &d.bolted));
    }
    if d.leaves_structure() {
        for part in &d.unexplained_parts {
            // What was not looked for any more may explain it.
            let why = match d.is_full() {
                true => "that the effects found do not explain, and no more were looked for",
                false => "that none of the library's effects explains",
            };
            let share = 100.0 * part.share;
            let _ = writeln!(
                out,
                "{}: something is left {why}: {share:.0} % of the remaining squared error {}.{}",
                part.joint,
                seen(part),
                part.late_s.map_or_else(String::new, later)
            );
        }
    } else {
        out.push_str(&what_is_left(d));
    }
    out.trim_end().to_owned()
}

/// Said first where so many effects do not explain a log.
fn another_robot(d: &Diagnosis) -> Option<String> {
    (d.unexplained && d.is_full()).then(|| {
        format!(
            "{} effects, as many as are looked for, do not explain this log. Before any of them is believed: is it a log of the robot that is described \
             (masses, geometry, order, signs and units of its joints, how its base is held)? Masses alone: `bipedc identify`.\n",
            d.effects.len()
        )
    })
}

/// What leaves the error where nothing is missing.
fn left_by(d: &Diagnosis) -> &'static str {
    let main = d.rms.values().find(|fall| fall.before == d.rms_before);
    match main.is_some_and(|fall| fall.noise > 0.0 && fall.after > LEFT * fall.noise) {
        true => {
            "the measurement's noise leaves where joints move and nothing jumps, and filters and the smoothing of a friction's sign where they rest or turn back"
        }
        false => "the measurement's noise and the filter leave",
    }
}

/// A step that makes the held-out error larger by more than this factor waits for another effect.
const RISES: f64 = 1.005;

/// What is said of effects that lower the error only together.
fn opposed(d: &Diagnosis) -> String {
    let mut out = String::new();
    for (k, step) in d.steps.iter().enumerate().filter(|(_, step)| step.after > RISES * step.before) {
        let other = d.steps.get(k + 1).or_else(|| k.checked_sub(1).and_then(|k| d.steps.get(k)));
        let Some(other) = other else { continue };
        let _ = writeln!(
            out,
            "{} and {} work against each other: the error falls only with both, and they share what they remove equally.",
            step.effect, other.effect
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::{FoundEffect, Scope, Seen, Unexplained};
    use bipedc_effects::effect::{Effect, Location, kinds};
    use std::collections::BTreeMap;

    fn left(after: f64) -> Diagnosis {
        let fall = ErrorFall { unit: "N m".into(), before: 0.3, after, noise: 0.05, ..ErrorFall::default() };
        Diagnosis {
            rms: BTreeMap::from([("effort".to_owned(), fall.clone())]),
            rows: BTreeMap::from([("knee".to_owned(), fall)]),
            rms_before: 0.3,
            rms_after: after,
            ..Diagnosis::default()
        }
    }

    #[test]
    fn a_training_log_that_is_missed_is_not_passed_over() {
        let mut found = left(0.051);
        let missed = ErrorFall { after: 0.9, ..found.rms["effort"].clone() };
        found.rms_training = BTreeMap::from([("effort".to_owned(), missed)]);
        // Without a log that judges, blocks of the same log do.
        assert!(summary(&found).starts_with("Nothing is missing"));
        found.validation = Some(crate::measure::DataSource::default());
        let said = summary(&found);
        assert!(said.contains("its effort is missed by 0.9000 N m, 18.0 times the noise"), "{said}");
        // One joint of many may be missed where all together are not.
        let row = |after| ErrorFall { after, ..found.rms["effort"].clone() };
        let of = |after| Diagnosis {
            rms_training: found.rms.clone(),
            rows_training: BTreeMap::from([("knee".to_owned(), row(after))]),
            ..found.clone()
        };
        let said = summary(&of(0.12));
        assert!(said.contains("its knee is missed by 0.1200 N m, 2.4 times the noise"), "{said}");
        assert!(summary(&of(0.09)).starts_with("Nothing is missing"));
        // A judge that is missed itself is not said to be explained.
        let loud = ErrorFall { after: 0.11, ..found.rms["effort"].clone() };
        let said = summary(&Diagnosis { rows: BTreeMap::from([("knee".to_owned(), loud)]), ..of(0.3) });
        assert!(
            said.contains("Of the training log more is left: its knee is missed by 0.3000 N m, 6.0 times"),
            "{said}"
        );
        assert!(!said.contains("explained down to its noise"), "{said}");
    }

    #[test]
    fn what_drifts_is_not_said_to_be_a_function_of_the_motion() {
        let said = |seen: Seen| {
            let part =
                Unexplained { joint: "knee".into(), share: 0.61, signals: Vec::new(), seen, late_s: None };
            summary(&Diagnosis { unexplained: true, unexplained_parts: vec![part], ..left(0.11) })
        };
        assert!(
            said(Seen::Motion).contains("61 % of the remaining squared error is a function of the motion.")
        );
        assert!(
            said(Seen::Slowness).contains("varies slowly") && !said(Seen::Slowness).contains("a function")
        );
        assert!(said(Seen::Size).contains("too few rows"));
    }

    /// A humanoid's log beside the description of another one: twelve effects, and as if they were to be believed.
    #[test]
    fn a_log_that_as_many_effects_as_are_looked_for_do_not_explain_is_another_robots() {
        let effect = Effect::new(&kinds::VISCOUS_FRICTION, Location::joint("knee"), &[("damping", 0.4)]);
        let found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.9, doubts: Vec::new() };
        let full = format!("{}, 12: there may be more", Diagnosis::AS_MANY);
        let said = |warnings: Vec<String>, unexplained: bool| {
            summary(&Diagnosis { effects: vec![found.clone(); 12], warnings, unexplained, ..left(0.11) })
        };
        let first = "12 effects, as many as are looked for, do not explain this log.";
        assert!(said(vec![full.clone()], true).starts_with(first));
        assert!(!said(vec![full], false).contains(first) && !said(Vec::new(), true).contains(first));
    }

    /// A swing-up of a real pendulum was said to lack nothing at twice its noise.
    #[test]
    fn what_is_left_around_jumps_is_told() {
        let mut found = left(0.11);
        let fall = found.rows.get_mut("knee").unwrap();
        (fall.after_moving, fall.away_from_jumps) = (Some(0.1), Some(0.06));
        let said = summary(&found);
        assert!(said.contains("knee is missed by more, 0.1000 N m in all, 2.0 times the noise"), "{said}");
        assert!(
            !said.contains("issing in effort") && said.starts_with("No effect was found in effort."),
            "{said}"
        );
        found.rows.get_mut("knee").unwrap().after_moving = Some(0.06);
        assert!(summary(&found).starts_with("Nothing is missing in effort: "));
        // What a faster filter does not leave is told beside that nothing is missing.
        let fall = found.rows.get_mut("knee").unwrap();
        (fall.away_from_jumps, fall.gone_at_hz) = (Some(0.1), Some(20.0));
        let said = summary(&found);
        assert!(said.starts_with("Nothing is missing in effort: "), "{said}");
        assert!(
            said.contains("Behind this filter knee is missed by 0.1000 N m, 2.0 times the noise: fast"),
            "{said}"
        );
    }

    /// Six of twelve joints had no position: nothing was said to be missing in all efforts.
    #[test]
    fn what_was_not_looked_at_is_said() {
        let unseen = vec!["hip".to_owned(), "toe".to_owned()];
        let of = |scope: Scope| summary(&Diagnosis { scope, ..left(0.051) });
        let said = of(Scope { joints: 3, unseen, ..Scope::default() });
        assert!(
            said.starts_with(
                "Nothing is missing in effort (1 of 3 joints; not looked at: `hip`, `toe`): the held-out"
            ),
            "{said}"
        );
        // A robot that fell after half a second lacked nothing by the little that was left.
        let said = of(Scope { short_s: Some(0.22), ..Scope::default() });
        assert!(
            said.starts_with("Nothing is missing in effort, of which only 0.22 s of motion were looked at: "),
            "{said}"
        );
    }

    #[test]
    fn errors_that_rise_beside_one_that_falls_are_told() {
        let effect = Effect::new(&kinds::PAYLOAD, Location::link("torso"), &[("mass", 3.0)]);
        let found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.1, doubts: Vec::new() };
        let mut answer = Diagnosis { effects: vec![found], ..left(0.051) };
        let said = |answer: &Diagnosis| summary(answer).contains("rises");
        let moment = |after| ErrorFall { after, before: 1.8, noise: 1.5, ..answer.rms["effort"].clone() };
        let [more, hardly] = [2.4, 1.9].map(moment);
        answer.rms.insert("base_moment".to_owned(), hardly);
        assert!(!said(&answer));
        answer.rms.insert("base_moment".to_owned(), more);
        assert!(summary(&answer).contains("\nThat of the base moment rises by it, 1.800 → 2.400 N m.\n"));
    }

    #[test]
    fn nothing_is_missing_only_down_to_the_noise() {
        let effect = Effect::new(&kinds::VISCOUS_FRICTION, Location::joint("knee"), &[("damping", 0.4)]);
        let found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.9, doubts: Vec::new() };
        assert!(summary(&left(0.051)).starts_with("Nothing is missing in effort: "));
        assert_eq!(
            summary(&left(0.11)),
            "No effect was found in effort. What is left is above the noise: knee is missed by 0.1100 N m, 2.2 times the \
             noise of its measurement. What it goes with was not found; noise behind a slow filter would look the same."
        );
        let with_effect = |after| summary(&Diagnosis { effects: vec![found.clone()], ..left(after) });
        assert!(with_effect(0.051).ends_with("\nNothing else is missing in effort."));
        let loud = with_effect(0.11);
        assert!(
            loud.contains(
                "\nNo further effect was found in effort. What is left is above the noise: knee is "
            ),
            "{loud}"
        );
    }
}
