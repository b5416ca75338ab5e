//! Alternatives in words, and what would tell them apart.
use crate::diagnose::FoundEffect;
use bipedc_effects::effect::Effect;
use std::fmt::Write as _;

/// So many effects of one alternative stand each with its place; more are listed by kind,
const EACH: usize = 3;
/// with so many places.
const PLACES: usize = 4;

/// Alternatives, and what would tell them apart; `bolted`: links that are one body.
pub(crate) fn alike(group: &[Vec<FoundEffect>], bolted: &[Vec<String>]) -> String {
    let is_one = |a: &FoundEffect, b: &FoundEffect| {
        let links = [a, b].map(|found| found.effect.location.link.as_ref());
        let [Some(one), Some(other)] = links else { return false };
        a.effect.kind == b.effect.kind
            && bolted.iter().any(|links| links.contains(one) && links.contains(other))
    };
    let names: Vec<String> = group.iter().map(|alternative| named(alternative)).collect();
    let Some(first) = group.first().and_then(|a| a.first()) else { return String::new() };
    // The first of other kinds, or of another body.
    let second = group[1..].iter().filter_map(|a| a.first()).find(|other| !is_one(first, other));
    let Some(second) = second.filter(|_| group.len() > 1) else {
        return format!(
            "{}: these links are bolted to each other, so that it is one and the same.",
            names.join(", or ")
        );
    };
    let mut text = format!("This data cannot tell apart: {}.", names.join("; or "));
    let _ = write!(text, " To tell them apart: {}", experiment(&first.effect, &second.effect));
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
    fn links_that_are_one_body_are_not_to_be_told_apart() {
        let bolted = [vec!["torso".to_owned(), "logo".to_owned()]];
        let told = |all: &[(&'static Kind, &str)]| {
            let group: Vec<Vec<FoundEffect>> = all.iter().map(|(kind, link)| vec![at(kind, link)]).collect();
            alike(&group, &bolted)
        };
        assert_eq!(
            told(&[(&kinds::PAYLOAD, "torso"), (&kinds::PAYLOAD, "logo")]),
            "Payload at torso, or Payload at logo: these links are bolted to each other, so that it is one and the same."
        );
        let others = [(&kinds::PAYLOAD, "torso"), (&kinds::PAYLOAD, "logo"), (&kinds::PAYLOAD, "arm")];
        assert!(
            told(&others).contains("cannot tell apart") && told(&others).contains("To tell them apart: ")
        );
        assert!(
            told(&[(&kinds::PAYLOAD, "torso"), (&kinds::COM_OFFSET, "logo")]).contains("To tell them apart")
        );
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
