//! The ranked causes.
use super::svg;
use crate::diagnose::{Diagnosis, FoundEffect, Rejected, Step};
use crate::number::{joined, percent, set, significant, with_interval, with_unit};
use bipedc_effects::effect::{Effect, Location};
use maud::{Markup, html};

/// Everything that the diagnosis says about causes.
pub(super) fn section(diagnosis: &Diagnosis) -> Markup {
    let unit = svg::headline(diagnosis).map_or("", |fall| fall.unit.as_str());
    html! {
        section aria-labelledby="causes" {
            h2 #causes { "Causes" }
            @if diagnosis.effects.is_empty() {
                p {
                    "No effect earned its place."
                    @if !diagnosis.leaves_structure() { " " (diagnosis.summary.lines().last().unwrap_or_default()) }
                }
            }
            @if !diagnosis.effects.is_empty() {
                p.hint { "Ranked by how much of the held-out error they removed. Line: 95 % confidence; bar: plausible values; dotted: zero." }
            }
            ol.causes {
                @for found in &diagnosis.effects {
                    li { (card(found, entered(diagnosis, &found.effect), unit)) }
                }
            }
            @if !diagnosis.indistinguishable.is_empty() { (alternatives(&diagnosis.indistinguishable)) }
            @if diagnosis.unexplained { (unexplained(diagnosis)) }
            @if !diagnosis.inertial_corrections.is_empty() {
                h3 { "Inertial corrections" }
                p.hint { "What re-estimated masses, centres of mass and inertias account for: CAD errors. They were estimated together: what a single one removed of the error is not told apart." }
                @for found in &diagnosis.inertial_corrections { div.correction { (card(found, None, unit)) } }
            }
            (rejected(&diagnosis.rejected))
        }
    }
}

/// The step at which an effect entered.
fn entered<'a>(diagnosis: &'a Diagnosis, effect: &Effect) -> Option<&'a Step> {
    let same = |s: &&Step| {
        s.effect.kind == effect.kind && s.effect.location == effect.location && s.effect.name == effect.name
    };
    diagnosis.steps.iter().find(same)
}

/// One effect with its numbers.
fn card(found: &FoundEffect, step: Option<&Step>, unit: &str) -> Markup {
    let effect = &found.effect;
    html! {
        article.cause {
            h3 { (title(effect)) " " span.place { (place(&effect.location)) } }
            p.hint { (effect.kind.meaning) }
            @if let Some(torque) = &effect.torque { p { "torque = " code { (torque) } } }
            div.table { table.parameters {
                caption.hidden { "Parameters with 95 % confidence intervals" }
                tbody { @for (name, value) in ordered(effect) { (parameter(found, name, value)) } }
            } }
            @if found.share > 0.0 || step.is_some() { p.shares {
                span.track aria-hidden="true" { span.fill style=(format!("--share:{:.3}", found.share.clamp(0.0, 1.0))) {} }
                strong { (percent(found.share)) } " of the held-out squared error removed"
                @if let Some(step) = step { "; error " (with_unit(step.before, "")) " → " (with_unit(step.after, unit)) }
            } }
            @for doubt in &found.doubts { p.doubt { strong { "Doubt: " } (coded(doubt)) } }
        }
    }
}

/// Parameters in the order of the kind's definition (settings stand last there); unknown ones at the end.
pub(super) fn ordered(effect: &Effect) -> Vec<(&str, f64)> {
    let mut list: Vec<(&str, f64)> =
        effect.parameters.iter().map(|(name, value)| (name.as_str(), *value)).collect();
    let known = effect.kind.parameters;
    list.sort_by_key(|(name, _)| known.iter().position(|p| p.name == *name).unwrap_or(known.len()));
    list
}

fn title(effect: &Effect) -> String {
    effect.name.as_deref().unwrap_or(effect.kind.title).to_owned()
}

fn place(location: &Location) -> String {
    location.to_string()
}

fn parameter(found: &FoundEffect, name: &str, value: f64) -> Markup {
    let definition = found.effect.kind.parameter(name);
    let unit = found.effect.unit(name);
    let ci = found.ci95.get(name).copied();
    let (text, interval) = with_interval(value, ci);
    // Without an interval nothing says how many digits count.
    let known = ci.is_none_or(|ci| ci.iter().all(|x| x.is_finite()));
    let text = if known { text } else { significant(value, 2) };
    let plausible = found.effect.plausible(name);
    html! {
        tr {
            th scope="row" title=[definition.map(|p| p.meaning)] { (name) }
            td.number { (joined(text, unit)) }
            td { @match (&interval, known) {
                (Some([low, high]), true) => { "95 %: " (low) " to " (high) }
                (Some(_), false) => { span.hint { "the log does not tell it" } }
                (None, _) => { "set" }
            } }
            @if ci.is_some() && known { @if let Some(picture) = svg::interval(value, ci, plausible) { td.picture { (picture) } } }
        }
    }
}

/// Groups that the data cannot tell apart, with the experiment that could.
fn alternatives(groups: &[Vec<Vec<FoundEffect>>]) -> Markup {
    let names = |effects: &[FoundEffect]| {
        let names: Vec<String> = effects.iter().map(|f| described(&f.effect)).collect();
        if names.is_empty() { "nothing".to_owned() } else { names.join(" with ") }
    };
    html! {
        h3 { "Indistinguishable on this data" }
        @for group in groups {
            div.alternatives {
                ul { @for (i, alternative) in group.iter().enumerate() {
                    li { (names(alternative)) @if i == 0 { small { " (stands above)" } } }
                } }
                @for experiment in experiments(group) { p { strong { "To tell them apart: " } (coded(experiment)) } }
            }
        }
    }
}

/// Such as `Coulomb friction at left_knee_pitch (torque 0.402 N m)`.
fn described(effect: &Effect) -> String {
    let numbers: Vec<String> = ordered(effect)
        .into_iter()
        .map(|(name, value)| {
            let unit = effect.unit(name);
            format!("{name} {}", joined(significant(value, 3), unit))
        })
        .collect();
    if numbers.is_empty() { effect.to_string() } else { format!("{effect} ({})", numbers.join(", ")) }
}

/// What to measure next: from the confounders of either kind, else the experiment of the first kind.
fn experiments(group: &[Vec<FoundEffect>]) -> Vec<&'static str> {
    let kinds =
        |alternative: &Vec<FoundEffect>| alternative.iter().map(|f| f.effect.kind).collect::<Vec<_>>();
    let (Some(first), others) = (group.first().map(kinds), group.iter().skip(1).map(kinds)) else {
        return Vec::new();
    };
    let mut out: Vec<&'static str> = Vec::new();
    for b in others.flatten() {
        for a in &first {
            if let Some(experiment) = a.told_apart_by(b)
                && !out.contains(&experiment)
            {
                out.push(experiment);
            }
        }
    }
    if out.is_empty() {
        out.extend(first.iter().map(|kind| kind.experiment).take(1));
    }
    out
}

fn unexplained(diagnosis: &Diagnosis) -> Markup {
    html! {
        h3 { "Unexplained" }
        p { (what_is_left(diagnosis)) " " (diagnosis.suspects.join(", ")) "." }
        @if !diagnosis.unexplained_parts.is_empty() {
            div.table { table {
                thead { tr { th scope="col" { "row" } th.number scope="col" { "share of what remains" } th scope="col" { "seen in" } } }
                tbody { @for part in &diagnosis.unexplained_parts { tr {
                    th scope="row" { (part.joint) }
                    td.number { (percent(part.share)) }
                    td { (part.seen.words()) @if !part.signals.is_empty() { ": " (part.signals.join(", ")) } }
                } } }
            } }
        }
    }
}

/// Rows that are merely above their noise may have nothing but noise of a slow filter in them.
fn what_is_left(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.structured().next().is_some() || diagnosis.unexplained_parts.is_empty() {
        true => "Something is left that no effect of the library accounts for, in:",
        false => {
            "More is left than neighbouring readings differ by; what it goes with was not found, and noise behind a slow filter would look the same, in:"
        }
    }
}

fn rejected(list: &[Rejected]) -> Markup {
    if list.is_empty() {
        return html! {};
    }
    html! {
        details {
            summary { "Tried and rejected: " (list.len()) }
            div.table { table {
                thead { tr { th scope="col" { "effect" } th scope="col" { "place" } th scope="col" { "why" } } }
                tbody { @for entry in list { tr {
                    th scope="row" { (entry.kind.title) }
                    td { (place(&entry.place)) }
                    td { (entry.why) }
                } } }
            } }
        }
    }
}

/// A titled list; nothing if it is empty.
pub(super) fn lines(title: &str, class: &str, texts: &[String]) -> Markup {
    if texts.is_empty() {
        return html! {};
    }
    html! {
        div class=(class) {
            h3 { (title) }
            ul { @for text in texts { li { (coded(text)) } } }
        }
    }
}

/// Text whose names and commands stand between backticks, as plain text has them; numbers set for pages.
pub(in crate::report) fn coded(text: &str) -> Markup {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return html! { (set(text)) };
    }
    html! { @for (k, part) in parts.iter().enumerate() { @if !k.is_multiple_of(2) { code { (breakable(part)) } } @else { (set(part)) } } }
}

/// Words of commands: paths and names end a line behind their parts and not within them, options not at all.
pub(in crate::report) fn breakable(words: &str) -> Markup {
    html! { @for (k, word) in words.split(' ').enumerate() {
        @if k > 0 { " " }
        @if word.starts_with("--") {
            span.option { (word) }
        } @else {
            @for part in word.split_inclusive(['/', '_']) { (part) @if part.ends_with(['/', '_']) { wbr; } }
        }
    } }
}
