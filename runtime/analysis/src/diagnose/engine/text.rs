//! A diagnosis as sentences.
use crate::diagnose::{Diagnosis, ErrorFall, FoundEffect};
use crate::number::counting;
use bipedc_effects::effect::Effect;
use std::fmt::Write as _;

/// A number with four significant digits.
fn short(x: f64) -> String {
    counting(x, 4)
}

/// The whole answer, from its numbers.
pub fn summary(d: &Diagnosis) -> String {
    let unit = d.rms.values().find(|f| f.before == d.rms_before).map_or("", |f| f.unit.as_str());
    if d.effects.is_empty() && d.inertial_corrections.is_empty() && !d.unexplained {
        return match loudest(d) {
            Some(_) => what_is_left(d),
            None => format!(
                "Nothing is missing in {}: the held-out error of {} {unit} is what the measurement's noise and the filter leave.",
                looked_at(d),
                short(d.rms_before)
            ),
        };
    }
    let mut out = String::new();
    for found in &d.effects {
        let _ = writeln!(out, "{}", sentence(found));
    }
    if !d.inertial_corrections.is_empty() {
        let links: Vec<&str> =
            d.inertial_corrections.iter().filter_map(|f| f.effect.location.link.as_deref()).collect();
        let _ = writeln!(
            out,
            "Masses, centres of mass and inertias were estimated beside the effects, and differ: {}.",
            links.join(", ")
        );
    }
    let _ = writeln!(out, "Held-out error {} → {} {unit}.", short(d.rms_before), short(d.rms_after));
    for group in &d.indistinguishable {
        let _ = writeln!(out, "{}", alike(group));
    }
    if d.unexplained {
        for part in &d.unexplained_parts {
            let with = if part.signals.is_empty() {
                String::new()
            } else {
                format!("; it goes with {}", part.signals.join(", "))
            };
            let _ = writeln!(
                out,
                "{}: something is left that none of the library's effects explains: {:.0} % of the remaining squared \
                 error is a function of the motion{with}.",
                part.joint,
                100.0 * part.share
            );
        }
    } else {
        out.push_str(&what_is_left(d));
    }
    out.trim_end().to_owned()
}

/// So many times the noise: it was a simulator that had none.
const HARDLY_ANY: f64 = 100.0;
/// Rows above so many times their noise have something left.
const LEFT: f64 = 1.4;

/// The row that is missed by most of its noise, and by how many times, if that is more than noise.
fn loudest(d: &Diagnosis) -> Option<(&String, &ErrorFall, f64)> {
    let ratios = d.rows.iter().filter_map(|(row, fall)| Some((row, fall, fall.noises()?)));
    ratios.filter(|(_, _, ratio)| *ratio > LEFT).max_by(|a, b| a.2.total_cmp(&b.2))
}

/// The last sentence where nothing structured was seen in what is left.
fn what_is_left(d: &Diagnosis) -> String {
    let further = if d.effects.is_empty() { "No" } else { "No further" };
    match loudest(d) {
        None => format!("Nothing else is missing in {}.", looked_at(d)),
        Some((row, fall, ratio)) => {
            let times = if ratio > HARDLY_ANY {
                "and there is hardly any noise".to_owned()
            } else {
                format!("{ratio:.1} times the noise of its measurement")
            };
            format!(
                "{further} effect was found in {}. What is left is above the noise: {row} is missed by {} {}{}, {times}.",
                looked_at(d),
                short(fall.after_moving.unwrap_or(fall.after)),
                fall.unit,
                if fall.after_moving.is_some() { " where it does not stick" } else { "" },
            )
        }
    }
}

/// The kinds of channels that were compared, in words.
fn looked_at(d: &Diagnosis) -> String {
    d.rms.keys().map(|kind| kind.replace('_', " ")).collect::<Vec<_>>().join(", ")
}

/// One effect: what, where, how large, how sure.
fn sentence(found: &FoundEffect) -> String {
    let effect = &found.effect;
    let values: Vec<String> = found
        .ci95
        .iter()
        .filter(|(name, [low, high])| (high - low).is_finite() || effect.value(name) != 0.0)
        .map(|(name, [low, high])| {
            let value = format!("{name} {} {}", short(effect.value(name)), effect.unit(name));
            match (high - low).is_finite() {
                true => format!("{value} (95 %: {} to {})", short(*low), short(*high)),
                false => value,
            }
        })
        .collect();
    let symptom = effect.kind.symptom;
    let mut text = format!(
        "{}: {:.0} % of the squared error is {}, {}; the residual {symptom}.",
        effect.location,
        100.0 * found.share,
        effect.kind.title,
        values.join(", ")
    );
    for doubt in &found.doubts {
        let _ = write!(text, " Doubtful: {doubt}.");
    }
    text
}

/// Alternatives, and what would tell them apart.
fn alike(group: &[Vec<FoundEffect>]) -> String {
    let names: Vec<String> = group
        .iter()
        .map(|alternative| {
            alternative.iter().map(|f| f.effect.to_string()).collect::<Vec<_>>().join(" with ")
        })
        .collect();
    let mut text = format!("This data cannot tell apart: {}.", names.join("; or "));
    if let (Some(first), Some(second)) =
        (group.first().and_then(|a| a.first()), group.get(1).and_then(|a| a.first()))
    {
        let _ = write!(text, " To tell them apart: {}", experiment(&first.effect, &second.effect));
    }
    text
}

/// The motion that separates two effects, from either's words.
pub(crate) fn experiment(a: &Effect, b: &Effect) -> &'static str {
    a.kind.told_from(b.kind).or_else(|| b.kind.told_from(a.kind)).unwrap_or(a.kind.experiment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::{Location, kinds};
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
    fn nothing_is_missing_only_down_to_the_noise() {
        let effect = Effect::new(&kinds::VISCOUS_FRICTION, Location::joint("knee"), &[("damping", 0.4)]);
        let found = FoundEffect { effect, ci95: BTreeMap::new(), share: 0.9, doubts: Vec::new() };
        assert!(summary(&left(0.051)).starts_with("Nothing is missing in effort: "));
        assert_eq!(
            summary(&left(0.11)),
            "No effect was found in effort. What is left is above the noise: knee is missed by 0.1100 N m, 2.2 times the \
             noise of its measurement."
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
