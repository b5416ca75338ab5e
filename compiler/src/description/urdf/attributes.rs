//! Attributes of URDF elements: numbers that are numbers, names that are known.
use crate::description::source::{Messages, Place, short};
use bipedc_effects::magnitude;
use bipedc_effects::spelling::did_you_mean;
use roxmltree::Node;

/// The element of this name.
pub(super) fn find<'a, 'i>(nodes: &[Node<'a, 'i>], name: &str) -> Option<Node<'a, 'i>> {
    nodes.iter().find(|node| node.tag_name().name() == name).copied()
}

/// Where an attribute stands.
fn place(node: Node<'_, '_>, name: &str) -> Place {
    Some(node.attribute_node(name).map_or(node.range().start, |attribute| attribute.range().start))
}

/// Warns of misspelt attributes.
pub(super) fn check_attributes(node: Node<'_, '_>, known: &[&str], messages: &mut Messages<'_>) {
    for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
        let name = attribute.name();
        if known.contains(&name) {
            continue;
        }
        if let Some(meant) = did_you_mean(name, known.iter().copied()) {
            let element = node.tag_name().name();
            messages.warning(
                Some(attribute.range().start),
                format!("`{}` is not an attribute of <{element}>; it is ignored", short(name)),
                format!("did you mean `{meant}`?"),
            );
        }
    }
}

/// A required text.
pub(super) fn text<'a>(
    node: Node<'a, '_>,
    name: &str,
    owner: &str,
    messages: &mut Messages<'_>,
) -> Option<&'a str> {
    let value = node.attribute(name).map(str::trim).filter(|value| !value.is_empty());
    if value.is_none() {
        let element = node.tag_name().name();
        messages.error(
            Some(node.range().start),
            format!("{owner}: <{element}> has no `{name}`"),
            format!("write <{element} {name}=\"…\"/>"),
        );
    }
    value
}

/// The attribute's text if it is one finite number; reports why not. `None` as well when it is absent.
pub(super) fn number<'a>(
    node: Node<'a, '_>,
    name: &str,
    owner: &str,
    messages: &mut Messages<'_>,
) -> Option<&'a str> {
    vector(node, name, 1, owner, messages)
}

/// The attribute's text if it is `count` finite numbers; reports why not. `None` as well when it is absent.
pub(super) fn vector<'a>(
    node: Node<'a, '_>,
    name: &str,
    count: usize,
    owner: &str,
    messages: &mut Messages<'_>,
) -> Option<&'a str> {
    let value = node.attribute(name)?.trim();
    // Exporters write the largest float there is for joints without limits.
    let bounded = node.tag_name().name() != "limit";
    match check_numbers(value, count).and_then(|()| if bounded { check_sizes(value) } else { Ok(()) }) {
        Ok(()) => Some(value),
        Err((problem, help)) => {
            let element = node.tag_name().name();
            messages.error(place(node, name), format!("{owner}: {element}/{name} {problem}"), help);
            None
        }
    }
}

/// Whether all numbers of a text that holds nothing else have a possible size.
pub(super) fn check_sizes(value: &str) -> Result<(), (String, String)> {
    let refused = value.split_whitespace().find_map(|word| {
        let (problem, help) = magnitude::refusal(word.parse().ok()?)?;
        Some((format!("is `{}`, which {problem}", short(word)), help.to_owned()))
    });
    refused.map_or(Ok(()), Err)
}

/// Whether the text is `count` finite numbers; else what is wrong and what to do.
pub(super) fn check_numbers(value: &str, count: usize) -> Result<(), (String, String)> {
    let expected = if count == 1 { "a number".into() } else { format!("{count} numbers") };
    let mut found = 0;
    for word in value.split_whitespace() {
        found += 1;
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => {}
            Ok(_) => {
                let problem =
                    format!("is `{}`, expected {expected}: NaN and infinity have no meaning", short(word));
                return Err((problem, "write a finite value, or remove the attribute".into()));
            }
            Err(_) => {
                let problem =
                    format!("is `{}`, expected {expected}: `{}` is not a number", short(value), short(word));
                let help = if word.contains(',') {
                    "write decimals with a point and separate by spaces"
                } else {
                    "write digits, such as 0.25 or 2.5e-3"
                };
                return Err((problem, help.into()));
            }
        }
    }
    if found == count {
        return Ok(());
    }
    Err((
        format!("is `{}`: expected {expected}, found {found}", short(value)),
        "write as many as expected, separated by spaces".into(),
    ))
}
