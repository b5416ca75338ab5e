//! How numbers, units and effects are said, in comments and on the terminal.
use super::Proposed;
use super::history::{BeforeAfter, Change, ChannelError, Step};
use bipedc_analysis::measure::DataSource;
use bipedc_effects::effect::{Effect, kinds};
use std::fmt::Write;

/// How comments that amend writes begin.
pub const COMMENT: &str = "bipedc amend, ";

/// Shortest text that reads back as the same number, and is a number of TOML.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Rounded for people: four digits.
pub fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let size = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&size) {
        return format!("{value:.3e}");
    }
    let decimals = (3.0 - size).clamp(0.0, 8.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number with its unit.
pub fn quantity(value: f64, unit: &str) -> String {
    let number = rounded(value);
    match unit {
        "1" => number,
        "mixed" => format!("{number} (mixed units)"),
        unit => format!("{number} {unit}"),
    }
}

/// The unit as a comment says it.
pub fn unit_words(unit: &str) -> &str {
    if unit == "1" { "no unit" } else { unit }
}

/// The comment behind a parameter: unit, and how sure it is.
pub fn behind(effect: &Effect, name: &str, ci95: Option<&[f64; 2]>) -> String {
    // One line, whatever the author of a formula wrote.
    let mut text = format!("  # {}", one_line(unit_words(effect.unit(name))));
    if let Some([low, high]) = ci95 {
        let _ = write!(text, ", {}", sure(*low, *high));
    }
    text
}

/// How sure a parameter is: `95 %: 0.42 to 0.44`.
pub fn sure(low: f64, high: f64) -> String {
    if low.is_finite() && high.is_finite() {
        format!("95 %: {} to {}", rounded(low), rounded(high))
    } else {
        "not determined by the data".to_owned()
    }
}

/// Such as `Coulomb friction at left_knee_pitch`, or `cable (formula) at …`.
pub fn title(effect: &Effect) -> String {
    match &effect.name {
        Some(name) => format!("{} (formula) at {}", one_line(name), one_line(&effect.location.to_string())),
        None => one_line(&effect.to_string()),
    }
}

/// Parameters with units: `torque 0.43 N m, smoothing 0.02 rad/s`.
pub fn parameters(effect: &Effect) -> String {
    let one = |(name, value): (&String, &f64)| format!("{name} {}", quantity(*value, effect.unit(name)));
    effect.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// The same with error bars, where known.
pub fn estimates(change: &Change) -> String {
    let effect = &change.effect;
    let one = |(name, value): (&String, &f64)| {
        let text = format!("{name} {}", quantity(*value, effect.unit(name)));
        let sure = change.ci95.get(name).map(|[low, high]| format!(" ({})", sure(*low, *high)));
        text + &sure.unwrap_or_default()
    };
    effect.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// What a change did to be noticed: parameters that are zero within their error bars, or for anybody's eyes, are left out, and
/// so are inertias beside masses and centres of mass. All of them stand in the history's file and in the description.
pub fn noticeable(change: &Change) -> String {
    let effect = &change.effect;
    let is_zero = |name: &str, value: f64| {
        let within = change.ci95.get(name).is_some_and(|[low, high]| *low <= 0.0 && 0.0 <= *high);
        within || value == 0.0
    };
    let changed = effect.kind == &kinds::INERTIAL_CORRECTION;
    let one = |(name, value): (&String, &f64)| {
        (!is_zero(name, *value)).then(|| format!("{name} {}", quantity(*value, effect.unit(name))))
    };
    let (shown, inertia): (Vec<_>, Vec<_>) =
        effect.parameters.iter().partition(|(name, _)| !changed || !name.starts_with('i'));
    let mut parts: Vec<String> = shown.into_iter().filter_map(one).collect();
    let sure: Vec<String> = inertia.into_iter().filter_map(one).collect();
    match (parts.is_empty(), sure.len()) {
        (true, 0) if !change.ci95.is_empty() => parts.push("nothing beyond its error bars".to_owned()),
        (true, 0) => return parameters(effect),
        (_, 0) => {}
        (_, 1) => parts.extend(sure),
        (_, count) => parts.push(format!("{count} inertias")),
    }
    parts.join(", ")
}

/// `0.52 → 0.06 N m`.
pub fn fall(fall: &BeforeAfter, unit: &str) -> String {
    format!("{} → {}", rounded(fall.before), quantity(fall.after, unit))
}

/// `held-out effort 0.52 → 0.06 N m, on the whole training log 0.5 → 0.05 N m`: where blocks of it judge they are a part of it.
pub fn error(error: &ChannelError) -> String {
    let mut parts = Vec::new();
    if let Some(held_out) = &error.held_out {
        parts.push(format!("held-out {} {}", error.channel, fall(held_out, &error.unit)));
    }
    if let Some(training) = &error.training {
        let data = if error.held_out.is_some() { "the whole training log" } else { "the training data" };
        parts.push(format!("on {data} {}", fall(training, &error.unit)));
    }
    parts.join(", ")
}

/// The comment above a table: what, when, from which data, error before → after.
pub fn above(effect: &Effect, proposed: &Proposed, step: &Step) -> String {
    let mut text = format!("{COMMENT}{}: {}, {}", day(&step.date), title(effect), step.origin);
    let training: Vec<String> = step.training.iter().chain(&step.more_training).map(data).collect();
    if !training.is_empty() {
        let _ = write!(text, ", from {}", training.join(" and "));
    }
    if let Some(validation) = &step.validation {
        let _ = write!(text, ", judged on {}", data(validation));
    }
    if let Some(errors) = proposed.error.as_ref().or(step.main_error()) {
        let _ = write!(text, "; {}", error(errors));
    }
    one_line(&text)
}

/// `train.csv (2501 samples)`; answers of old did not count them all.
fn data(source: &DataSource) -> String {
    match source.samples {
        0 => source.file.clone(),
        samples => format!("{} ({samples} samples)", source.file),
    }
}

/// The day of a date.
pub fn day(date: &str) -> &str {
    date.get(..10).unwrap_or(date)
}

/// Fit for one line of a comment or a table.
pub fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_exactly() {
        for value in [0.43, -1e-9, 5.0, 1e300, 0.1 + 0.2, f64::MIN_POSITIVE, 123456.789] {
            let document: toml_edit::DocumentMut = format!("x = {}", number(value)).parse().unwrap();
            assert_eq!(document["x"].as_float(), Some(value), "{}", number(value));
        }
    }

    #[test]
    fn a_history_shows_what_can_be_noticed() {
        use crate::amendment::history::Action;
        use bipedc_effects::effect::Location;
        let change = |effect: Effect, sure: &[(&str, [f64; 2])]| Change {
            action: Action::Added,
            effect,
            ci95: sure.iter().map(|(name, range)| ((*name).to_owned(), *range)).collect(),
            previous: None,
            error: None,
        };
        let values = [("mass", 0.5), ("x", -1.677e-8), ("z", -0.06), ("ixx", 0.01), ("iyy", 1e-9)];
        let effect = Effect::new(&kinds::INERTIAL_CORRECTION, Location::link("fore"), &values);
        let sure = [("x", [-1e-3, 1e-3]), ("iyy", [-1e-3, 1e-3])];
        assert_eq!(noticeable(&change(effect.clone(), &sure)), "mass 0.5 kg, z -0.06 m, ixx 0.01 kg m²");
        let mut two = effect.clone();
        two.parameters.insert("izz".to_owned(), 0.02);
        assert_eq!(noticeable(&change(two, &sure)), "mass 0.5 kg, z -0.06 m, 2 inertias");
        let mut slide = Effect::new(&kinds::COULOMB_FRICTION, Location::joint("rail"), &[("torque", 2.0)]);
        slide.sliding = true;
        assert_eq!(noticeable(&change(slide.clone(), &[])), "torque 2 N");
        assert_eq!(
            estimates(&change(slide.clone(), &[("torque", [1.9, 2.1])])),
            "torque 2 N (95 %: 1.9 to 2.1)"
        );
        // Who reads it back without the robot knows as much.
        let text = serde_json::to_string(&slide).unwrap();
        assert_eq!(serde_json::from_str::<Effect>(&text).unwrap().unit("torque"), "N");
        assert!(!serde_json::to_string(&effect).unwrap().contains("sliding"));
    }

    #[test]
    fn rounding_keeps_four_digits() {
        let cases =
            [(0.431_278, "0.4313"), (12.0, "12"), (0.0, "0"), (-1234.56, "-1235"), (1e-7, "1.000e-7")];
        for (value, text) in cases {
            assert_eq!(rounded(value), text);
        }
    }
}
