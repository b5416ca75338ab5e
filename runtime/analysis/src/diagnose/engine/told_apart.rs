//! Alternatives in words, and what would tell them apart.
use crate::diagnose::FoundEffect;
use bipedc_effects::effect::Effect;
use std::fmt::Write as _;

/// So many effects of one alternative stand each with its place; more are listed by kind,
const EACH: usize = 3;
/// with so many places.
const PLACES: usize = 4;

/// Alternatives, and what would tell them apart.
pub(super) fn alike(group: &[Vec<FoundEffect>]) -> String {
    let names: Vec<String> = group.iter().map(|alternative| named(alternative)).collect();
    let mut text = format!("This data cannot tell apart: {}.", names.join("; or "));
    if let (Some(first), Some(second)) =
        (group.first().and_then(|a| a.first()), group.get(1).and_then(|a| a.first()))
    {
        let _ = write!(text, " To tell them apart: {}", experiment(&first.effect, &second.effect));
    }
    text
}

/// Effects that act together.
fn named(alternative: &[FoundEffect]) -> String {
    if alternative.len() <= EACH {
        return alternative.iter().map(|f| f.effect.to_string()).collect::<Vec<_>>().join(" with ");
    }
    let mut kinds: Vec<(&str, Vec<String>)> = Vec::new();
    for Effect { kind, location, .. } in alternative.iter().map(|found| &found.effect) {
        match kinds.iter_mut().find(|(title, _)| *title == kind.title) {
            Some((_, places)) => places.push(location.to_string()),
            None => kinds.push((kind.title, vec![location.to_string()])),
        }
    }
    let of_kind = |(title, places): &(&str, Vec<String>)| match places.len().saturating_sub(PLACES) {
        0 => format!("{title} at {}", places.join(", ")),
        more => format!("{title} at {} and {more} more", places[..PLACES].join(", ")),
    };
    kinds.iter().map(of_kind).collect::<Vec<_>>().join(", with ")
}

/// The motion that separates two effects, from either's words.
pub(crate) fn experiment(a: &Effect, b: &Effect) -> &'static str {
    a.kind.told_apart_by(b.kind).unwrap_or(a.kind.experiment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::{Kind, Location, kinds};
    use std::collections::BTreeMap;

    fn at(kind: &'static Kind, link: &str) -> FoundEffect {
        let effect = Effect::new(kind, Location::link(link), &[]);
        FoundEffect { effect, ci95: BTreeMap::new(), share: 0.5, doubts: Vec::new() }
    }

    #[test]
    fn many_effects_are_listed_by_kind() {
        let two = [at(&kinds::PAYLOAD, "hand"), at(&kinds::COM_OFFSET, "arm")];
        assert_eq!(named(&two), "Payload at hand with Offset of the centre of mass at arm");
        let all: Vec<FoundEffect> = "abcdef"
            .chars()
            .map(|c| at(&kinds::COM_OFFSET, &c.to_string()))
            .chain([at(&kinds::PAYLOAD, "hand")])
            .collect();
        assert_eq!(
            named(&all),
            "Offset of the centre of mass at a, b, c, d and 2 more, with Payload at hand"
        );
    }
}
