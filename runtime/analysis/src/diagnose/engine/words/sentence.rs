//! One effect in words: what, where, how large, how sure, and how much of the error it is.
use super::text::short;
use crate::diagnose::{Diagnosis, FoundEffect};
use std::fmt::Write as _;

/// Shares below this part are next to nothing.
const LITTLE: f64 = 0.005;

pub(crate) fn sentence(d: &Diagnosis, found: &FoundEffect) -> String {
    let effect = &found.effect;
    let values: Vec<String> = found
        .ci95
        .iter()
        .filter(|(name, [low, high])| (high - low).is_finite() || effect.value(name) != 0.0)
        .map(|(name, [low, high])| {
            let value = format!("{name} {} {}", short(effect.value(name)), effect.unit(name));
            let value = value.trim_end_matches(" 1").to_owned();
            match (high - low).is_finite() {
                true => format!("{value} (95 %: {} to {})", short(*low), short(*high)),
                false => value,
            }
        })
        .collect();
    let mut text = format!(
        "{}: {} is {}, {}; the residual {}.",
        effect.location,
        part_of_error(d, found),
        effect.kind.title,
        values.join(", "),
        effect.kind.symptom
    );
    for doubt in &found.doubts {
        let _ = write!(text, " Doubtful: {doubt}.");
    }
    text
}

/// What an effect makes of the squared error: where that is next to nothing, of its joint's own, which is small beside those of large ones.
fn part_of_error(d: &Diagnosis, found: &FoundEffect) -> String {
    if !(0.0..LITTLE).contains(&found.share) {
        return format!("{:.0} % of the squared error", 100.0 * found.share);
    }
    match own_part(d, found).filter(|own| *own >= LITTLE) {
        Some(own) => format!("{:.0} % of its own squared error, less than 1 % of all,", 100.0 * own),
        None => "less than 1 % of the squared error".to_owned(),
    }
}

/// What the only effect that was found at a joint makes of its row's squared error.
fn own_part(d: &Diagnosis, found: &FoundEffect) -> Option<f64> {
    let joint = found.effect.location.joint.as_ref()?;
    let here = d.effects.iter().filter(|other| other.effect.location.joint.as_ref() == Some(joint));
    let fall = d.rows.get(joint).filter(|_| here.count() == 1)?;
    let before = fall.before_moving.unwrap_or(fall.before);
    let after = fall.after_moving.unwrap_or(fall.after);
    Some(1.0 - (after / before).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::ErrorFall;
    use bipedc_effects::effect::{Effect, Location, kinds};
    use std::collections::BTreeMap;

    #[test]
    fn a_share_next_to_nothing_is_told_of_the_joint_itself() {
        let effect = Effect::new(&kinds::VISCOUS_FRICTION, Location::joint("finger"), &[("damping", 2e-4)]);
        let found =
            |share| FoundEffect { effect: effect.clone(), ci95: BTreeMap::new(), share, doubts: Vec::new() };
        let fall = ErrorFall { before: 1e-3, after: 5e-4, ..ErrorFall::default() };
        let mut d = Diagnosis {
            effects: vec![found(1e-6)],
            rows: BTreeMap::from([("finger".to_owned(), fall)]),
            ..Diagnosis::default()
        };
        let said = |d: &Diagnosis, share| sentence(d, &found(share));
        assert!(
            said(&d, 1e-6)
                .starts_with("finger: 75 % of its own squared error, less than 1 % of all, is Viscous")
        );
        assert!(said(&d, 0.4).starts_with("finger: 40 % of the squared error is Viscous"));
        d.effects.push(found(1e-6));
        assert!(said(&d, 1e-6).starts_with("finger: less than 1 % of the squared error is Viscous"));
    }
}
