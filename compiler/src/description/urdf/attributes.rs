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

/// The attribute if it is one finite number; reports why not. `None` as well when it is absent.
pub(super) fn number(
    node: Node<'_, '_>,
    name: &str,
    owner: &str,
    messages: &mut Messages<'_>,
) -> Option<f64> {
    vector::<1>(node, name, owner, messages).map(|[value]| value)
}

/// The attribute if it is `N` finite numbers; reports why not. `None` as well when it is absent.
pub(super) fn vector<const N: usize>(
    node: Node<'_, '_>,
    name: &str,
    owner: &str,
    messages: &mut Messages<'_>,
) -> Option<[f64; N]> {
    let text = node.attribute(name)?;
    // Exporters write the largest float there is for joints without limits.
    let bounded = node.tag_name().name() != "limit";
    let read =
        numbers(text).and_then(|values| if bounded { of_possible_size(values, text) } else { Ok(values) });
    match read {
        Ok(values) => Some(values),
        Err((problem, help)) => {
            let element = node.tag_name().name();
            messages.error(place(node, name), format!("{owner}: {element}/{name} {problem}"), help);
            None
        }
    }
}

/// The numbers if all have a possible size; else what is wrong and what to do.
pub(super) fn of_possible_size<const N: usize>(
    values: [f64; N],
    text: &str,
) -> Result<[f64; N], (String, String)> {
    let mut written = values.iter().zip(text.split_whitespace());
    let refused = written.find_map(|(value, word)| {
        let (problem, help) = magnitude::refusal(*value)?;
        Some((format!("is `{}`, which {problem}", short(word)), help.to_owned()))
    });
    refused.map_or(Ok(values), Err)
}

/// The text as `N` finite numbers; else what is wrong and what to do.
pub(super) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], (String, String)> {
    let expected = if N == 1 { "a number".into() } else { format!("{N} numbers") };
    let (mut values, mut found) = ([0.0; N], 0);
    for word in text.split_whitespace() {
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                if let Some(value) = values.get_mut(found) {
                    *value = number;
                }
            }
            Ok(_) => {
                let problem =
                    format!("is `{}`, expected {expected}: NaN and infinity have no meaning", short(word));
                return Err((problem, "write a finite value, or remove the attribute".into()));
            }
            Err(_) => {
                let problem = format!(
                    "is `{}`, expected {expected}: `{}` is not a number",
                    short(text.trim()),
                    short(word)
                );
                let help = if word.contains(',') {
                    "write decimals with a point and separate by spaces"
                } else {
                    "write digits, such as 0.25 or 2.5e-3"
                };
                return Err((problem, help.into()));
            }
        }
        found += 1;
    }
    if found == N {
        return Ok(values);
    }
    Err((
        format!("is `{}`: expected {expected}, found {found}", short(text.trim())),
        "write as many as expected, separated by spaces".into(),
    ))
}
