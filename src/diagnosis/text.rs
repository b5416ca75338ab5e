//! A diagnosis for people: words, then tables.
use crate::table::table;
use bipedc_analysis::diagnose::{Diagnosis, FoundEffect};

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
    out.push('\n');
    let rows = d
        .rows
        .iter()
        .map(|(name, fall)| {
            let number = |x: f64| format!("{x:.4}");
            vec![name.clone(), number(fall.before), number(fall.after), number(fall.noise), fall.unit.clone()]
        })
        .collect();
    out.push_str(&table(&["held-out rms", "before", "after", "noise", "unit"], rows, 1));
    out
}

fn bound(x: f64) -> String {
    if x.is_finite() { format!("{x:.5}") } else { "unknown".to_owned() }
}

fn effect_rows(found: &FoundEffect) -> Vec<Vec<String>> {
    let effect = &found.effect;
    found
        .ci95
        .iter()
        .enumerate()
        .map(|(k, (name, [low, high]))| {
            let first = |text: String| if k == 0 { text } else { String::new() };
            vec![
                first(effect.kind.name.to_owned()),
                first(effect.location.to_string()),
                name.clone(),
                format!("{:.5}", effect.value(name)),
                bound(*low),
                bound(*high),
                effect.unit(name).to_owned(),
                first(format!("{:.1} %", 100.0 * found.share)),
            ]
        })
        .collect()
}
