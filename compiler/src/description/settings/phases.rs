//! Contact phases: what stands on the ground, and what happens at the change to the next phase.
use super::base::{find_foot, parts};
use super::check_identifier;
use super::table::Section;
use crate::description::model::{Contact, ContactPart, Foot, Phase, Side};
use crate::description::source::{Messages, Place, short, suggest};

pub(super) fn read_phases(
    top: &Section<'_, '_>,
    feet: &[Foot],
    planar: bool,
    no_symmetry: bool,
    messages: &mut Messages<'_>,
) -> Vec<Phase> {
    let sections = top.sections("phase", messages);
    let names: Vec<Option<(String, Place)>> =
        sections.iter().map(|section| section.string("name", messages)).collect();
    let mut phases: Vec<Phase> = Vec::new();
    for (index, section) in sections.iter().enumerate() {
        section.check_keys(&["name", "contacts", "next", "impact", "relabel"], messages);
        let Some((name, at)) = names[index].clone() else {
            if !section.has("name") {
                messages.error(section.at, "a [[phase]] has no `name`", "add name = \"single_support\"");
            }
            continue;
        };
        check_identifier(&name, "phase", at, messages);
        if phases.iter().any(|phase| phase.name == name) {
            let message = format!("the phase name `{}` is used twice", short(&name));
            messages.error(at, message, "rename one of the two phases");
        }
        let next = read_next(section, index, &names, messages);
        let contacts = read_contacts(section, "contacts", feet, planar, messages);
        let impact = read_contacts(section, "impact", feet, planar, messages);
        let relabel = section.boolean("relabel", messages).unwrap_or_default();
        if relabel {
            check_relabel(section, feet, no_symmetry, messages);
        }
        phases.push(Phase { name, contacts, next, impact, relabel });
    }
    phases
}

/// The stated phase, or the one below; after the last the first.
fn read_next(
    section: &Section<'_, '_>,
    index: usize,
    names: &[Option<(String, Place)>],
    messages: &mut Messages<'_>,
) -> String {
    let known: Vec<&str> = names.iter().flatten().map(|(name, _)| name.as_str()).collect();
    let Some((next, at)) = section.string("next", messages) else {
        let below = &names[(index + 1) % names.len()];
        return below.as_ref().map_or_else(String::new, |(name, _)| name.clone());
    };
    if !known.contains(&next.as_str()) {
        let message = format!("`next` in [[phase]]: there is no phase `{}`", short(&next));
        messages.error(at, message, suggest(&next, known, "phases"));
    }
    next
}

fn check_relabel(section: &Section<'_, '_>, feet: &[Foot], no_symmetry: bool, messages: &mut Messages<'_>) {
    let at = section.get("relabel").and_then(|entry| entry.at);
    if no_symmetry {
        let help = "list the mirrored joints under [symmetry], or remove `relabel`";
        messages.error(at, "[[phase]]: `relabel` needs to know which joints mirror each other", help);
    }
    let count = |side| feet.iter().filter(|foot| foot.side == Some(side)).count();
    if count(Side::Left) != count(Side::Right) {
        let message = format!(
            "[[phase]]: `relabel` needs as many left as right feet, there are {} and {}",
            count(Side::Left),
            count(Side::Right)
        );
        messages.error(at, message, "state `side` of every foot");
    }
}

fn read_contacts(
    section: &Section<'_, '_>,
    key: &'static str,
    feet: &[Foot],
    planar: bool,
    messages: &mut Messages<'_>,
) -> Vec<Contact> {
    let mut contacts: Vec<Contact> = Vec::new();
    for (text, at) in section.strings(key, messages).unwrap_or_default() {
        let Some(contact) = read_contact(&text, at, key, feet, planar, messages) else { continue };
        if contacts.contains(&contact) {
            let message = format!("`{key}` in [[phase]]: `{}` stands there twice", short(&text));
            messages.error(at, message, "remove one");
            continue;
        }
        contacts.push(contact);
    }
    contacts
}

fn read_contact(
    text: &str,
    at: Place,
    key: &str,
    feet: &[Foot],
    planar: bool,
    messages: &mut Messages<'_>,
) -> Option<Contact> {
    let (name, part) = text.split_once('/').map_or((text, None), |(foot, part)| (foot, Some(part)));
    let what = format!("`{key}` in [[phase]]");
    let foot = find_foot(name, at, &what, feet, messages)?;
    let part = match part {
        None => whole_foot(foot, at, &what, planar, messages)?,
        Some(part) if foot.points.iter().any(|point| point.name == part) => ContactPart::Point(part.into()),
        Some(part) if foot.edges.iter().any(|edge| edge.name == part) => ContactPart::Edge(part.into()),
        Some(part) => {
            let message = format!("{what}: foot `{}` has no point or edge `{}`", foot.name, short(part));
            messages.error(at, message, suggest(part, parts(foot), "its parts"));
            return None;
        }
    };
    Some(Contact { foot: foot.name.clone(), part })
}

/// The whole foot is a point if it has only one, else flat, for which it needs enough points.
fn whole_foot(
    foot: &Foot,
    at: Place,
    what: &str,
    planar: bool,
    messages: &mut Messages<'_>,
) -> Option<ContactPart> {
    if let [point] = &foot.points[..] {
        return Some(ContactPart::Point(point.name.clone()));
    }
    // A robot whose base joints stand in the URDF may be planar too: its foot then lies in one plane.
    let in_plane = planar || foot.points.iter().all(|point| point.position[1] == foot.points[0].position[1]);
    if foot.points.len() < 3 && !in_plane {
        let message = format!("{what}: foot `{}` cannot be flat on {} points", foot.name, foot.points.len());
        messages.error(at, message, "name a point or edge (foot/part), or give the foot more points");
        return None;
    }
    Some(ContactPart::Flat)
}
