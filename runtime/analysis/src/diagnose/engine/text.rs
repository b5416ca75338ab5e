//! A diagnosis as sentences.
use crate::diagnose::{Diagnosis, FoundEffect};
use bipedc_effects::effect::{Effect, Location, kinds};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A number with four significant digits.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{x:.digits$}")
}

/// The whole answer, from its numbers.
pub fn summary(d: &Diagnosis) -> String {
    let unit = d.rms.values().find(|f| f.before == d.rms_before).map_or("", |f| f.unit.as_str());
    let mut out = String::new();
    if d.effects.is_empty() && d.inertial_corrections.is_empty() && !d.unexplained {
        let _ = write!(
            out,
            "Nothing is missing: the held-out error of {} {unit} is what the measurement's noise and the filter leave.",
            short(d.rms_before)
        );
        return out;
    }
    for found in &d.effects {
        let _ = writeln!(out, "{}", sentence(found));
    }
    if !d.inertial_corrections.is_empty() {
        let links: Vec<&str> =
            d.inertial_corrections.iter().filter_map(|f| f.effect.location.link.as_deref()).collect();
        let _ = writeln!(
            out,
            "Masses and centres of mass are corrected, apart from the effects: {}.",
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
        out.push_str("Nothing else is missing.");
    }
    out.trim_end().to_owned()
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

/// A correction of one body: mass and centre of mass, from nominal parameters and their change.
pub(super) fn correction(link: &str, nominal: &[f64], change: &[f64]) -> FoundEffect {
    let mass = nominal[0] + change[0];
    let mut parameters: BTreeMap<String, f64> = BTreeMap::from([("mass".to_owned(), change[0])]);
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let shift = (nominal[1 + k] + change[1 + k]) / mass - nominal[1 + k] / nominal[0];
        parameters.insert(axis.to_owned(), shift);
    }
    let mut effect = Effect::new(&kinds::INERTIAL_CORRECTION, Location::link(link), &[]);
    effect.parameters = parameters;
    FoundEffect { effect, ci95: BTreeMap::new(), share: 0.0, doubts: Vec::new() }
}
