//! An `[[effect]]` of kind `formula`: the user's own law with named parameters.
use super::check_identifier;
use super::effects::range;
use super::table::{Entry, Section};
use crate::description::source::{Messages, short};
use crate::expression::ValuedFormula;
use bipedc_effects::effect::formula::{Formula, SMOOTHING};
use bipedc_effects::effect::{Effect, OwnParameter, VARIABLES};
use bipedc_effects::spelling::suggest;

/// Keys of a formula beside its place and its settings.
pub(super) const KEYS: [&str; 3] = ["name", "torque", "parameters"];
const PARAMETER_KEYS: [&str; 4] = ["value", "unit", "min", "max"];
/// Names that the language uses itself.
const RESERVED: [&str; 12] =
    ["sin", "cos", "tan", "tanh", "exp", "sqrt", "abs", "sign", "min", "max", "clip", "pi"];

pub(super) fn read_formula(section: &Section<'_, '_>, effect: &mut Effect, messages: &mut Messages<'_>) {
    let errors = messages.errors();
    if let Some((name, at)) = section.string("name", messages) {
        check_identifier(&name, "effect", at, messages);
        effect.name = Some(name);
    }
    if let Some(section) = section.section("parameters", messages) {
        for entry in section.entries() {
            read_parameter(&section, &entry, effect, messages);
        }
    }
    let Some(entry) = section.get("torque") else {
        let help = "add torque = \"k * sin(3 * position) * velocity\", a formula in N m";
        messages.error(section.at, "[[effect]] `formula` has no `torque`", help);
        return;
    };
    let Some(text) = entry.string(messages) else { return };
    match Formula::parse(&text) {
        // After a refused parameter its name would only be reported again.
        Ok(_) if messages.errors() > errors => {}
        Ok(formula) => {
            check_names(section, &entry, &text, &formula, effect, messages);
            if messages.errors() == errors {
                check_value(&entry, formula, effect, messages);
            }
        }
        Err(error) => {
            let at = entry.inside_text(error.at, messages);
            messages.error(at, format!("{}: {}", entry.name(), error.message), error.help);
        }
    }
    effect.torque = Some(text);
}

/// A number, or a table with value, unit and bounds.
fn read_parameter(
    section: &Section<'_, '_>,
    entry: &Entry<'_, '_>,
    effect: &mut Effect,
    messages: &mut Messages<'_>,
) {
    let at = section.key_place(entry.key);
    check_identifier(entry.key, "parameter", at, messages);
    if VARIABLES.contains(&entry.key) || RESERVED.contains(&entry.key) || entry.key == SMOOTHING {
        let message = format!("the parameter name `{}` has a meaning already", entry.key);
        messages.error(at, message, format!("rename it; taken are: {}", taken().join(", ")));
        return;
    }
    let mut own = OwnParameter { unit: "1".to_owned(), min: None, max: None };
    let value = if entry.is_table() {
        let title = format!("the formula's parameter `{}`", short(entry.key));
        let Some(section) = entry.section(title, messages) else { return };
        section.check_keys(&PARAMETER_KEYS, messages);
        if let Some((unit, _)) = section.string("unit", messages) {
            own.unit = unit;
        }
        own.min = section.number("min", messages);
        own.max = section.number("max", messages);
        if !section.has("value") {
            let message = format!("{} has no `value`", section.title);
            messages.error(section.at, message, "add value = …, at least a first guess");
        }
        section.number("value", messages)
    } else {
        entry.number(messages)
    };
    let Some(value) = value else { return };
    check_bounds(entry, value, &own, messages);
    effect.parameters.insert(entry.key.to_owned(), value);
    effect.own.insert(entry.key.to_owned(), own);
}

fn taken() -> Vec<&'static str> {
    VARIABLES.into_iter().chain([SMOOTHING]).chain(RESERVED).collect()
}

fn check_bounds(entry: &Entry<'_, '_>, value: f64, own: &OwnParameter, messages: &mut Messages<'_>) {
    let low = own.min.unwrap_or(f64::NEG_INFINITY);
    let high = own.max.unwrap_or(f64::INFINITY);
    if low >= high {
        let message = format!("{}: `min` {low} is not below `max` {high}", entry.name());
        messages.error(entry.at, message, "exchange or remove them");
    } else if !(low..=high).contains(&value) {
        let message =
            format!("{}: {value} is out of its bounds, {}", entry.name(), range(low, high, &own.unit));
        messages.error(entry.at, message, "change the value, or `min` and `max`");
    }
}

/// Every name is a variable or a parameter, and every parameter is used.
fn check_names(
    section: &Section<'_, '_>,
    entry: &Entry<'_, '_>,
    text: &str,
    formula: &Formula,
    effect: &Effect,
    messages: &mut Messages<'_>,
) {
    let known: Vec<&str> = VARIABLES
        .into_iter()
        .chain([SMOOTHING])
        .chain(effect.parameters.keys().map(String::as_str).filter(|name| *name != SMOOTHING))
        .collect();
    for name in formula.names() {
        let at = || position(text, name);
        if !known.contains(&name.as_str()) {
            let message =
                format!("{}: `{}` is neither a variable nor a parameter", entry.name(), short(name));
            let help = suggest(name, known.iter().copied(), || {
                format!("add `parameters.{} = 1.0`; variables are: {}", short(name), VARIABLES.join(", "))
            });
            messages.error(entry.inside_text(at(), messages), message, help);
        } else if name.starts_with("other_")
            && VARIABLES.contains(&name.as_str())
            && !section.has("other_joint")
        {
            let message = format!("{}: `{name}` needs another joint", entry.name());
            messages.error(entry.inside_text(at(), messages), message, "add other_joint = \"…\"");
        }
    }
    let unused = |name: &&String| *name != SMOOTHING && !formula.names().contains(name);
    for name in effect.parameters.keys().filter(unused) {
        let message = format!("{}: the parameter `{name}` does not stand in it", entry.name());
        messages.error(entry.at, message, "remove the parameter, or use it: it cannot be estimated");
    }
}

/// A division by zero in every state is found before anything is derived.
fn check_value(entry: &Entry<'_, '_>, formula: Formula, effect: &Effect, messages: &mut Messages<'_>) {
    let names = formula.names().iter();
    let parameters = names
        .filter(|name| effect.parameters.contains_key(*name) || *name == SMOOTHING)
        .map(|name| (name.clone(), effect.value(name)))
        .collect();
    if let Some(problem) = (ValuedFormula { formula, parameters }).without_value() {
        let message = format!("{}: {problem}, whatever the state is", entry.name());
        messages.error(entry.at, message, "change the formula or its parameters");
    }
}

/// Index of the character where a name first stands as a word of its own.
fn position(text: &str, name: &str) -> usize {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let whole =
        |&(at, _): &(usize, &str)| !text[..at].ends_with(part) && !text[at + name.len()..].starts_with(part);
    let at = text.match_indices(name).find(whole).map_or(0, |(at, _)| at);
    text[..at].chars().count()
}
