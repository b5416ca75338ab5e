//! `[[effect]]`: what the rigid-body model lacks, each a kind of the library at a place with numbers.
use super::Known;
use super::formula::{self, read_formula};
use super::table::{Entry, Section};
use crate::description::model::Foot;
use crate::description::source::{Messages, Place as At, list_names, short, suggest};
use bipedc_effects::effect::{self, Effect, KINDS, Kind, Law, Location, Parameter, Place, Role};
use bipedc_effects::spelling;

/// All keys that say where.
const PLACES: [&str; 4] = ["joint", "other_joint", "link", "sensor"];

pub(in crate::description) fn read_effects(
    top: &Section<'_, '_>,
    known: Known<'_>,
    feet: &[Foot],
    messages: &mut Messages<'_>,
) -> Vec<Effect> {
    let mut effects: Vec<Effect> = Vec::new();
    for section in top.sections("effect", messages) {
        let Some(effect) = read_effect(&section, known, feet, messages) else { continue };
        check_twins(&section, &effect, &effects, messages);
        effects.push(effect);
        check_mass(&section, &effects, known, messages);
    }
    effects
}

fn read_effect(
    section: &Section<'_, '_>,
    known: Known<'_>,
    feet: &[Foot],
    messages: &mut Messages<'_>,
) -> Option<Effect> {
    let kind = read_kind(section, messages)?;
    check_keys(section, kind, messages);
    let errors = messages.errors();
    let location = read_location(section, kind, known, feet, messages);
    let mut effect = Effect { sliding: known.slides(&location), ..Effect::new(kind, location, &[]) };
    for parameter in kind.parameters {
        if let Some(value) = read_parameter(section, &effect, parameter, messages) {
            effect.parameters.insert(parameter.name.to_owned(), value);
        }
    }
    if kind.law == Law::Formula {
        read_formula(section, &mut effect, messages);
    }
    (messages.errors() == errors).then_some(effect)
}

fn read_kind(section: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<&'static Kind> {
    let names = || KINDS.iter().map(|kind| kind.name).collect::<Vec<_>>();
    let Some((name, at)) = section.string("kind", messages) else {
        if !section.has("kind") {
            let help = format!("add kind = \"coulomb_friction\"; kinds are: {}", names().join(", "));
            messages.error(section.at, "an [[effect]] has no `kind`", help);
        }
        return None;
    };
    let found = effect::kind(&name);
    if found.is_none() {
        let message = format!("`kind` in [[effect]]: there is no effect `{}`", short(&name));
        let help = spelling::suggest(&name, names(), || format!("kinds are: {}", names().join(", ")));
        messages.error(at, message, help);
    }
    found
}

/// The keys of a kind that say where it acts: the second is optional.
fn place_keys(kind: &Kind) -> &'static [&'static str] {
    match kind.place {
        Place::Joint if kind.law == Law::Formula => &["joint", "other_joint"],
        Place::Joint => &["joint"],
        Place::JointPair => &["joint", "other_joint"],
        Place::Link => &["link"],
        Place::Sensor => &["sensor"],
        Place::Robot => &[],
    }
}

/// Where a kind acts, for messages.
fn place_words(kind: &Kind) -> &'static str {
    match kind.place {
        Place::Joint => "acts at a joint: write joint = \"…\"",
        Place::JointPair => {
            "is what one joint does to another: write joint = \"…\" and other_joint = \"…\" (the cause)"
        }
        Place::Link => "belongs to a link: write link = \"…\"",
        Place::Sensor => "belongs to a foot force sensor: write sensor = \"foot\" or \"foot/corner\"",
        Place::Robot => "belongs to the whole robot and has no place: remove the key",
    }
}

fn check_keys(section: &Section<'_, '_>, kind: &Kind, messages: &mut Messages<'_>) {
    let places = place_keys(kind);
    let mut known: Vec<&'static str> = std::iter::once("kind").chain(places.iter().copied()).collect();
    known.extend(kind.parameters.iter().map(|parameter| parameter.name));
    if kind.law == Law::Formula {
        known.extend(formula::KEYS);
    }
    for entry in section.entries() {
        if PLACES.contains(&entry.key) && !places.contains(&entry.key) {
            let message = format!("{} has no meaning for `{}`", entry.name(), kind.name);
            let help = format!("`{}` {}", kind.name, place_words(kind));
            messages.error(section.key_place(entry.key), message, help);
            known.extend(PLACES.iter().filter(|place| **place == entry.key));
        }
    }
    section.check_keys(&known, messages);
}

fn read_location(
    section: &Section<'_, '_>,
    kind: &Kind,
    known: Known<'_>,
    feet: &[Foot],
    messages: &mut Messages<'_>,
) -> Location {
    let mut text = |key: &'static str, needed: bool| {
        let found = section.string(key, messages);
        if found.is_none() && needed && !section.has(key) {
            let message = format!("[[effect]] `{}` has no `{key}`", kind.name);
            messages.error(section.at, message, format!("`{}` {}", kind.name, place_words(kind)));
        }
        found
    };
    let keys = place_keys(kind);
    let [joint, other_joint, link, sensor] = PLACES.map(|key| {
        let optional = key == "sensor" || (key == "other_joint" && kind.law == Law::Formula);
        if keys.contains(&key) { text(key, !optional) } else { None }
    });
    for (name, at) in joint.iter().chain(&other_joint) {
        known.check_joint(name, *at, "[[effect]]", messages);
    }
    if let (Some((joint, _)), Some((other, at))) = (&joint, &other_joint)
        && joint == other
    {
        let help = "name the joint whose motion causes the torque";
        messages.error(*at, "[[effect]]: `joint` and `other_joint` are the same", help);
    }
    if let Some((name, at)) = &link {
        known.check_link(name, *at, "[[effect]]", messages);
    }
    if let Some((name, at)) = &sensor {
        check_sensor(name, *at, feet, messages);
    }
    let name = |place: Option<(String, At)>| place.map(|(name, _)| name);
    Location { joint: name(joint), other_joint: name(other_joint), link: name(link), sensor: name(sensor) }
}

/// `foot` or `foot/corner` must exist.
fn check_sensor(name: &str, at: At, feet: &[Foot], messages: &mut Messages<'_>) {
    let (foot_name, corner) =
        name.split_once('/').map_or((name, None), |(foot, corner)| (foot, Some(corner)));
    let Some(foot) = feet.iter().find(|foot| foot.name == foot_name) else {
        let message = format!("`sensor` in [[effect]]: there is no foot `{}`", short(foot_name));
        let names: Vec<&str> = feet.iter().map(|foot| foot.name.as_str()).collect();
        messages.error(at, message, suggest(foot_name, names, "feet of the description"));
        return;
    };
    let corners: Vec<&str> = foot.points.iter().map(|point| point.name.as_str()).collect();
    if let Some(corner) = corner.filter(|corner| !corners.contains(corner)) {
        let message =
            format!("`sensor` in [[effect]]: foot `{}` has no corner `{}`", short(foot_name), short(corner));
        messages.error(at, message, suggest(corner, corners, "its corners"));
    }
}

fn read_parameter(
    section: &Section<'_, '_>,
    effect: &Effect,
    parameter: &'static Parameter,
    messages: &mut Messages<'_>,
) -> Option<f64> {
    let Some(entry) = section.get(parameter.name) else {
        if parameter.role == Role::Estimated {
            let message = format!("[[effect]] `{}` has no `{}`", effect.kind.name, parameter.name);
            let unit = effect.unit(parameter.name);
            let help = format!("add `{} = …`: {}, {unit}", parameter.name, parameter.meaning);
            messages.error(section.at, message, help);
        }
        return None;
    };
    let value = entry.number(messages)?;
    check_range(&entry, value, (effect, parameter), messages);
    Some(value)
}

fn check_range(
    entry: &Entry<'_, '_>,
    value: f64,
    (effect, parameter): (&Effect, &Parameter),
    messages: &mut Messages<'_>,
) {
    let ((low, high), unit) = (parameter.bounds, effect.unit(parameter.name));
    if !(low..=high).contains(&value) {
        let message =
            format!("{}: {value} is not possible, expected {}", entry.name(), range(low, high, unit));
        messages.error(entry.at, message, format!("it is {}", what_it_is(parameter.meaning)));
        return;
    }
    let (low, high) = effect.plausible(parameter.name);
    if !(low..=high).contains(&value) {
        let message = format!("{}: {value} is unusual, usual is {}", entry.name(), range(low, high, unit));
        let what = what_it_is(parameter.meaning);
        let help =
            if unit == "1" { format!("it is {what}") } else { format!("is it in {unit}? It is {what}") };
        messages.warning(entry.at, message, help);
    }
}

/// A parameter's meaning with its article.
fn what_it_is(meaning: &str) -> String {
    if meaning.starts_with("its ") { meaning.to_owned() } else { format!("the {meaning}") }
}

/// "0 to 30 N m", "0 N m or more".
pub(super) fn range(low: f64, high: f64, unit: &str) -> String {
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{low} to {high}{unit}"),
        (true, false) => format!("{low}{unit} or more"),
        (false, true) => format!("{high}{unit} or less"),
        (false, false) => format!("any finite number{unit}"),
    }
}

/// The link of the last effect must not weigh less than nothing with all effects on it.
fn check_mass(section: &Section<'_, '_>, effects: &[Effect], known: Known<'_>, messages: &mut Messages<'_>) {
    let name = effects.last().and_then(|effect| effect.location.link.as_ref());
    let link = known.robot.and_then(|robot| robot.links.iter().find(|link| Some(&link.name) == name));
    let Some(link) = link else { return };
    let described = link.inertial.map_or(0.0, |inertial| inertial.mass);
    let here = effects.iter().filter(|effect| effect.location.link.as_ref() == name);
    let total = described + here.filter_map(|effect| effect.parameters.get("mass")).sum::<f64>();
    if total < 0.0 {
        let at = section.get("mass").and_then(|entry| entry.at).or(section.at);
        let message = format!("`mass` in [[effect]]: link `{}` would weigh {total:.4} kg", short(&link.name));
        messages.error(at, message, format!("the URDF says {described} kg; effects on a link add up"));
    }
}

/// Two effects of one kind at one place can only be told apart if their sum is no effect of that kind.
fn check_twins(section: &Section<'_, '_>, effect: &Effect, before: &[Effect], messages: &mut Messages<'_>) {
    let at = |key: &'static str| section.get(key).and_then(|entry| entry.at).or(section.at);
    if let Some(name) = &effect.name
        && before.iter().any(|other| other.name.as_ref() == Some(name))
    {
        let message = format!("`name` in [[effect]]: `{}` is used twice", short(name));
        messages.error(at("name"), message, "rename one of the two effects");
        return;
    }
    let twin = |other: &&Effect| {
        let same_place = other.kind == effect.kind && other.location == effect.location;
        let same_numbers = other.parameters == effect.parameters && other.torque == effect.torque;
        same_place && (!effect.kind.relations.repeats || same_numbers)
    };
    if before.iter().any(|other| twin(&other)) {
        let message = format!("[[effect]]: {} stands there twice", describe(effect));
        messages.error(section.at, message, "remove one, or merge the two");
    }
}

fn describe(effect: &Effect) -> String {
    let place = effect.location.to_string();
    format!("`{}` at {}", effect.kind, list_names([place.as_str()]))
}
