//! `[[phase]]` of a gait: phase variable, outputs, guard.
use super::curve::{Curve, read_bezier};
use super::dimension::{parse_unit, words};
use super::names::{Allowed, Names};
use super::read::{check_turns, range, read_unit};
use super::{FilePlace, GaitOutput, GaitPhase, Guard};
use crate::description::model::{Contact, ContactPart, Phase, RobotDescription};
use crate::description::settings::table::Section;
use crate::description::source::{Messages, Place, short, suggest};
use bipedc_effects::effect::formula::Formula;
use std::collections::BTreeMap;

pub(super) const VARIABLE: Allowed = Allowed {
    configuration: true,
    parameters: false,
    phase: false,
    rule: "a phase variable is a function of the configuration alone: joints, base_pitch, contact points",
};
const CONTROLLED: Allowed =
    Allowed { rule: "what is controlled is a function of the configuration alone", ..VARIABLE };
const WANTED: Allowed = Allowed {
    configuration: false,
    parameters: true,
    phase: true,
    rule: "what is wanted is a function of phase, phase_start, phase_end and the gait parameters",
};
const GUARD: Allowed = Allowed {
    configuration: true,
    parameters: true,
    phase: false,
    rule: "a guard is a function of the configuration and the gait parameters",
};

/// The unit of φ, which formulas are checked with; what is wrong with it is said by [`read_phase`].
pub(super) fn read_phase_unit(top: &Section<'_, '_>, names: &mut Names, messages: &mut Messages<'_>) {
    let unit = top.sections("phase", messages).first().and_then(|section| section.get("unit")?.text());
    names.phase_in_rad = unit == Some("rad");
    names.set_phase_dimension(unit.and_then(parse_unit));
}

pub(super) fn read_phase(
    top: &Section<'_, '_>,
    names: &Names,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) -> Option<GaitPhase> {
    let sections = top.sections("phase", messages);
    let Some(section) = sections.first() else {
        messages.error(top.at, "the gait has no [[phase]]", "docs/gaits.md shows a whole gait");
        return None;
    };
    if let Some(second) = sections.get(1) {
        let help = "here a step is one phase: point feet, one foot on the ground at a time; `bipedc simulate`, `bipedc \
                    generate` and `bipedc gait step` take several";
        messages.error(second.at, format!("this is a gait of several phases ({})", sections.len()), help);
        return None;
    }
    section.check_keys(
        &["name", "variable", "unit", "impact_matching", "output", "guard", "end", "posture"],
        messages,
    );
    if section.has("end") && section.has("guard") {
        let help = "leave one out: by a `guard` steps have closed forms; with `end` the controller keeps to limits of the ground";
        messages.error(section.key_place("end"), "the phase has a `guard` and an `end`", help);
    }
    let phase = find_phase(section, description, messages);
    let unit = read_unit(section, messages);
    let variable = formula(section, "variable", VARIABLE, unit.as_deref(), names, messages);
    let outputs = read_outputs(section, names, messages);
    // How many outputs a phase needs depends on how it stands.
    if phase.is_some() {
        check_number(section, outputs.len(), description, messages);
    }
    let guard = read_guard(section, names, messages);
    let impact_matching = section.boolean("impact_matching", messages).unwrap_or(true);
    let posture = read_posture(section, description, messages);
    let (phase, outputs) = (phase?, outputs.into_iter().collect::<Option<Vec<_>>>()?);
    Some(GaitPhase {
        name: phase.name.clone(),
        variable: variable?,
        variable_at: file_place(section.get("variable").and_then(|entry| entry.at), messages),
        unit: unit?,
        impact_matching,
        outputs,
        guard: guard?,
        posture,
    })
}

/// Positions of joints, where a search begins.
pub(super) fn read_posture(
    section: &Section<'_, '_>,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    let Some(table) = section.section("posture", messages) else { return found };
    let moving = || description.joints.iter().filter(|joint| joint.kind.moves()).map(|j| j.name.as_str());
    for entry in table.entries() {
        if !moving().any(|name| name == entry.key) {
            let message = format!("`posture`: the robot has no joint `{}`", short(entry.key));
            let help = suggest(entry.key, moving().collect::<Vec<_>>(), "joints");
            messages.error(table.key_place(entry.key), message, help);
        } else if let Some(value) = entry.number(messages) {
            found.insert(entry.key.to_owned(), value);
        }
    }
    found
}

/// The phase of the description, if the zero dynamics of a step can be made of it.
fn find_phase<'d>(
    section: &Section<'_, '_>,
    description: &'d RobotDescription,
    messages: &mut Messages<'_>,
) -> Option<&'d Phase> {
    let Some((name, at)) = section.string("name", messages) else {
        if !section.has("name") {
            let help = "add name = \"single_support\": a phase of biped.toml";
            messages.error(section.at, "a [[phase]] has no `name`", help);
        }
        return None;
    };
    let Some(phase) = description.phases.iter().find(|phase| phase.name == name) else {
        let names: Vec<&str> = description.phases.iter().map(|phase| phase.name.as_str()).collect();
        let message = format!("the robot has no phase `{}`", short(&name));
        messages.error(at, message, suggest(&name, names, "phases of biped.toml"));
        return None;
    };
    let reason = if phase.next != phase.name {
        Some(("is followed by another phase", "a step is one phase that is followed by itself"))
    } else if phase.impact.is_empty() || !phase.relabel {
        Some((
            "does not end with an impact that swaps the legs",
            "add impact and relabel = true in biped.toml",
        ))
    } else if !is_one_point(description, &phase.contacts) || !is_one_point(description, &phase.impact) {
        let help = "on a whole sole a step ends at a φ: `end` instead of `guard` (`bipedc gait new` writes such a form); else contacts and impact name one foot with one contact point each";
        Some(("does not stand on one point", help))
    } else {
        None
    };
    match reason {
        None => Some(phase),
        Some((what, help)) => {
            messages.error(at, format!("phase `{}` {what}", short(&name)), help);
            None
        }
    }
}

/// Whether contacts are one point in all: the foot is pinned and may turn.
pub(super) fn is_one_point(description: &RobotDescription, contacts: &[Contact]) -> bool {
    let [contact] = contacts else { return false };
    let foot = description.feet.iter().find(|foot| foot.name == contact.foot);
    match &contact.part {
        ContactPart::Point(_) => true,
        ContactPart::Flat => foot.is_some_and(|foot| foot.points.len() == 1),
        ContactPart::Edge(_) => false,
    }
}

/// Which joints nothing drives.
pub(super) fn undriven(description: &RobotDescription) -> String {
    let moving: Vec<&str> = description
        .joints
        .iter()
        .filter(|joint| joint.kind.moves())
        .map(|joint| joint.name.as_str())
        .collect();
    let has_none = |name: &&&str| !description.actuated_joints.iter().any(|driven| driven == **name);
    let missing: Vec<String> =
        moving.iter().filter(has_none).map(|name| format!("`{}`", short(name))).collect();
    format!("{} of {} joints have no actuator: {}", missing.len(), moving.len(), missing.join(", "))
}

fn check_number(
    section: &Section<'_, '_>,
    found: usize,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) {
    let joints = description.joints.iter().filter(|joint| joint.kind.moves()).count();
    let actuated = description.actuated_joints.len();
    if actuated != joints {
        let message = undriven(description);
        let help = "on a pinned foot the robot's turn about it is without an actuator already: one degree of \
                    underactuation is what zero dynamics need";
        messages.error(section.at, message, help);
    } else if found != actuated {
        let message = format!("{found} outputs for {actuated} actuators");
        let help =
            format!("write {actuated} [[phase.output]] tables: with the phase variable they fix every joint");
        let at = section.key_place("output").or(section.at);
        messages.error(at, message, help);
    }
}

/// A formula of a section with its unit; `unit`: what it must have.
pub(super) fn formula<'t>(
    section: &Section<'t, '_>,
    key: &'static str,
    allowed: Allowed,
    unit: Option<&str>,
    names: &Names,
    messages: &mut Messages<'_>,
) -> Option<Formula> {
    let Some(entry) = section.get(key) else {
        messages.error(section.at, format!("{} has no `{key}`", section.title), format!("add {key} = \"…\""));
        return None;
    };
    let (formula, dimension) = names.formula(&entry, allowed, messages)?;
    let wanted = unit.and_then(parse_unit);
    if let (Some(wanted), Some(found)) = (wanted, dimension)
        && wanted != found
    {
        let message = format!("{} is in {}, its unit says {}", entry.name(), words(found), words(wanted));
        messages.error(entry.at, message, "correct the formula or the `unit`");
        return None;
    }
    Some(formula)
}

/// A formula, or a table with the coefficients of a polynomial.
fn read_wanted(
    section: &Section<'_, '_>,
    unit: Option<&str>,
    names: &Names,
    messages: &mut Messages<'_>,
) -> Option<Curve> {
    match section.get("wanted").filter(|entry| entry.is_table()) {
        Some(entry) => {
            let table = entry.section("wanted".to_owned(), messages)?;
            read_bezier(&table, (unit.and_then(parse_unit), names), messages)
        }
        None => formula(section, "wanted", WANTED, unit, names, messages).map(Curve::Formula),
    }
}

/// Line and column of a place.
pub(super) fn file_place(place: Place, messages: &Messages<'_>) -> FilePlace {
    let (line, column) = place.map_or((1, 1), |offset| messages.source.line_and_column(offset));
    FilePlace { line, column }
}

/// The outputs of a phase, each with a name of its own; `None`: what is wrong with one was said.
pub(super) fn read_outputs(
    phase: &Section<'_, '_>,
    names: &Names,
    messages: &mut Messages<'_>,
) -> Vec<Option<GaitOutput>> {
    let sections = phase.sections("output", messages);
    let outputs: Vec<Option<GaitOutput>> =
        sections.iter().map(|section| read_output(section, names, messages)).collect();
    for (k, output) in outputs.iter().enumerate() {
        let Some(output) = output else { continue };
        if outputs[..k].iter().flatten().any(|other| other.name == output.name) {
            let at = sections[k].get("name").and_then(|entry| entry.at);
            let message = format!("there is another output `{}` in this phase", short(&output.name));
            messages.error(at, message, "choose another name: results are told by it");
        }
    }
    outputs
}

fn read_output(section: &Section<'_, '_>, names: &Names, messages: &mut Messages<'_>) -> Option<GaitOutput> {
    section.check_keys(&["name", "unit", "controlled", "wanted"], messages);
    let name = section.string("name", messages).map(|(name, _)| name);
    if name.is_none() && !section.has("name") {
        messages.error(section.at, "an output has no `name`", "add name = \"torso\"");
    }
    let unit = read_unit(section, messages);
    let controlled = formula(section, "controlled", CONTROLLED, unit.as_deref(), names, messages);
    let wanted = read_wanted(section, unit.as_deref(), names, messages);
    Some(GaitOutput {
        name: name?,
        unit: unit?,
        controlled: controlled?,
        wanted: wanted?,
        at: file_place(section.at, messages),
    })
}

fn read_guard(section: &Section<'_, '_>, names: &Names, messages: &mut Messages<'_>) -> Option<Guard> {
    let Some(entry) = section.get("guard") else {
        let help = "add guard = { zero = FORMULA, between = [0.0, 1.5] } with a formula that vanishes where the step ends, such as the distance \
                    of the feet less a parameter; or, for a controller that keeps to \
                    limits of the ground, end = the φ where the phase is meant to end";
        let said = match section.has("end") {
            true => "here a step of one phase ends by a `guard`",
            false => "the phase has no `guard`, and no `end`",
        };
        messages.error(section.at, said, help);
        return None;
    };
    let guard = entry.section("guard".to_owned(), messages)?;
    guard.check_keys(&["zero", "between"], messages);
    let formula = formula(&guard, "zero", GUARD, None, names, messages);
    let between = match guard.get("between") {
        Some(entry) => range(&entry, messages).inspect(|between| {
            if names.phase_in_rad {
                check_turns(&entry, between, messages);
            }
        }),
        None => {
            let help = "add between = [0.0, 1.5]: where φ is at the end of a step";
            messages.error(guard.at, "the guard has no `between`", help);
            None
        }
    };
    Some(Guard { formula: formula?, between: between? })
}
