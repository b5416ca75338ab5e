//! A diagnosis for people: words, then tables.
use crate::table::table;
use bipedc_analysis::diagnose::{Diagnosis, ErrorFall, FoundEffect};
use bipedc_analysis::number::four_decimals;
use std::fmt::Write as _;

/// The answer for people: words, then tables.
pub fn text(d: &Diagnosis) -> String {
    let mut out = format!("{}\n", d.summary);
    if !d.effects.is_empty() {
        out.push('\n');
        out.push_str(&table(
            &["effect", "where", "parameter", "value", "95 % from", "to", "unit", "share"],
            d.effects.iter().flat_map(effect_rows).collect(),
            3,
        ));
    }
    if !d.inertial_corrections.is_empty() {
        out.push('\n');
        out.push_str(&table(
            &["inertial correction", "parameter", "change", "95 % from", "to", "unit"],
            d.inertial_corrections.iter().flat_map(correction_rows).collect(),
            2,
        ));
    }
    out.push('\n');
    out.push_str(&errors(d));
    out.push_str(&whole_log(d));
    if !d.assumptions.is_empty() {
        out.push('\n');
    }
    for assumption in &d.assumptions {
        // Writing into a string cannot fail.
        let _ = writeln!(out, "assumed: {assumption}");
    }
    out
}

/// Without a log of its own that judges, parts of the log do: what `bipedc compare` measures on all of it is another number.
fn whole_log(d: &Diagnosis) -> String {
    if d.validation.is_some() {
        return String::new();
    }
    let mut out = String::new();
    for (kind, fall) in &d.rms_training {
        let unit = if fall.unit == "mixed" { "(mixed units)" } else { &fall.unit };
        let _ = write!(
            out,
            "\nall samples of the log, as bipedc compare counts: {} {:.4} → {:.4} {unit}",
            kind.replace('_', " "),
            fall.before,
            fall.after
        );
    }
    if !out.is_empty() {
        out.push('\n');
    }
    out
}

/// Errors by row; where joints stick, also without the samples at which they do.
fn errors(d: &Diagnosis) -> String {
    let sticks = d.rows.values().any(|fall| fall.after_moving.is_some());
    let number = four_decimals;
    let row = |name: &str, fall: &ErrorFall| {
        let moving = number(fall.after_moving.unwrap_or(fall.after));
        let mut cells = vec![name.to_owned(), number(fall.before), number(fall.after)];
        cells.extend(sticks.then_some(moving));
        cells.extend([number(fall.noise), fall.unit.clone()]);
        cells
    };
    let mut columns = vec!["held-out rms", "before", "after"];
    columns.extend(sticks.then_some("where free"));
    columns.extend(["noise", "unit"]);
    let rows = d.rows.iter().map(|(name, fall)| row(name, fall));
    let title = |kind: &str| if d.rms.len() > 1 { format!("all of {kind}") } else { "total".to_owned() };
    let all = d.rms.iter().filter(|_| d.rows.len() > 1).map(|(kind, fall)| row(&title(kind), fall));
    table(&columns, rows.chain(all).collect(), 1)
}

/// Five decimals as long as they show something.
fn value(x: f64) -> String {
    if x == 0.0 || x.abs() >= 1e-4 { format!("{x:.5}") } else { format!("{x:.2e}") }
}

/// The same with its sign.
fn changed(x: f64) -> String {
    if x > 0.0 { format!("+{}", value(x)) } else { value(x) }
}

fn bound(x: f64) -> String {
    if x.is_finite() { value(x) } else { "unknown".to_owned() }
}

/// Of a link: the changes that the data tell.
fn correction_rows(found: &FoundEffect) -> Vec<Vec<String>> {
    let effect = &found.effect;
    let names = effect.kind.parameters.iter().map(|parameter| parameter.name);
    let told = names.filter_map(|name| Some((name, found.ci95.get(name)?)));
    let link = effect.location.link.clone().unwrap_or_default();
    told.filter(|(_, [low, high])| (high - low).is_finite())
        .enumerate()
        .map(|(k, (name, [low, high]))| {
            let first = if k == 0 { link.clone() } else { String::new() };
            let value = changed(effect.value(name));
            vec![first, name.to_owned(), value, bound(*low), bound(*high), effect.unit(name).to_owned()]
        })
        .collect()
}

fn effect_rows(found: &FoundEffect) -> Vec<Vec<String>> {
    let effect = &found.effect;
    // What the data do not tell and the effect does not have is no parameter of it.
    let has =
        |(name, [low, high]): &(&String, &[f64; 2])| (high - low).is_finite() || effect.value(name) != 0.0;
    found
        .ci95
        .iter()
        .filter(has)
        .enumerate()
        .map(|(k, (name, [low, high]))| {
            let first = |text: String| if k == 0 { text } else { String::new() };
            vec![
                first(effect.kind.name.to_owned()),
                first(effect.location.to_string()),
                name.clone(),
                value(effect.value(name)),
                bound(*low),
                bound(*high),
                effect.unit(name).to_owned(),
                first(format!("{:.1} %", 100.0 * found.share)),
            ]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_show_something() {
        assert_eq!([0.0, 0.40021, -1.2e-7].map(value), ["0.00000", "0.40021", "-1.20e-7"]);
        assert_eq!(
            [0.0, 0.40021, -1.2e-7, 1.2e-7].map(changed),
            ["0.00000", "+0.40021", "-1.20e-7", "+1.20e-7"]
        );
        let fall = |before: f64| ErrorFall {
            unit: "m".to_owned(),
            before,
            after: before,
            noise: 2e-4,
            ..ErrorFall::default()
        };
        let rows = [("foot/heel/height".to_owned(), fall(3.1e-6))].into();
        let text = errors(&Diagnosis { rows, ..Diagnosis::default() });
        assert!(text.contains("3.10e-6") && text.contains("2.00e-4") && !text.contains("0.0000"), "{text}");
    }
}
