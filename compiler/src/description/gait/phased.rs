//! Gaits whose step is a sequence of phases (thesis 4.4.2, 6.2.2): feet that stand flat, roll over the toe, land on the heel.
use super::curve::{phase_dimension, read_moved};
use super::dimension::parse_unit;
use super::names::{Allowed, Names};
use super::phase::{VARIABLE, file_place, formula, read_outputs, read_posture, undriven};
use super::read::{check_turns, read_unit};
use super::{FilePlace, GaitLimits, GaitOutput, GaitParameter};
use crate::description::model::{ContactPart, Phase, RobotDescription};
use crate::description::settings::table::{Entry, Section};
use crate::description::source::{Messages, short, suggest};
use bipedc_effects::effect::Effect;
use bipedc_effects::effect::formula::Formula;
use std::collections::BTreeMap;

/// A gait of several phases, checked against its robot.
#[derive(Debug, Clone, PartialEq)]
pub struct PhasedGait {
    /// The file's name without its ending.
    pub name: String,
    /// Size of gravity, m/s²; `None`: that of the description.
    pub gravity: Option<f64>,
    /// In the order of the file.
    pub parameters: Vec<GaitParameter>,
    /// Formulas that other formulas name.
    pub quantities: BTreeMap<String, Formula>,
    /// In the order in which they follow each other; after the last comes the first.
    pub phases: Vec<SupportPhase>,
    /// Makes another body of the description, as the published robot has it.
    pub effects: Vec<Effect>,
    /// What forces on the feet are held to.
    pub limits: GaitLimits,
}

/// Virtual constraints of one phase, h = h₀(q) − h_d(φ, p) − h_p(φ) (6.27), and torques that it begins from.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportPhase {
    /// Phase of the description: it says what stands and which event ends it.
    pub name: String,
    /// φ(q), which grows along the phase.
    pub variable: Formula,
    /// Where it stands in the file.
    pub variable_at: FilePlace,
    /// Unit of φ.
    pub unit: String,
    /// Whether the cubic h_p takes up what is left of h and its rate where the phase begins.
    pub impact_matching: bool,
    /// N − M − 1 of them: with the contacts and the phase variable they fix every joint.
    pub outputs: Vec<GaitOutput>,
    /// φ at which h_p has vanished: where the phase is meant to end; of the gait parameters.
    pub end: Formula,
    /// Torques that the outputs' own are a least change of.
    pub feedforward: Option<Feedforward>,
    /// K_p (1/s²) and K_d (1/s), where the phase has its own.
    pub feedback: Option<[f64; 2]>,
    /// Joint positions where the search for a posture on the constraints begins, rad or m; those that are missing are 0.
    pub posture: BTreeMap<String, f64>,
}

/// Torques over φ: cubic splines (third derivatives go on at the second and at the last but one place), which stay where they are
/// beyond their ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Feedforward {
    /// φ, growing.
    pub at: Vec<f64>,
    /// By joint, as many as `at`, N m; joints that are missing have none.
    pub torques: BTreeMap<String, Vec<f64>>,
    /// Stands for φ in the splines, in its unit, as in [`Curve::Bezier`](super::Curve::Bezier).
    pub along: Option<Formula>,
    /// What is added, by joint, N m.
    pub plus: BTreeMap<String, Formula>,
}

const KEYS: [&str; 9] =
    ["name", "variable", "unit", "impact_matching", "end", "output", "feedforward", "feedback", "posture"];
const END: Allowed = Allowed {
    configuration: false,
    parameters: true,
    phase: false,
    rule: "the end of a phase is a number or a function of the gait parameters",
};

/// All phases; their numbers of outputs fit what stands, and each is followed by the next.
pub(super) fn read_phases(
    top: &Section<'_, '_>,
    names: &Names,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) -> Option<Vec<SupportPhase>> {
    let sections = top.sections("phase", messages);
    let mut found: Vec<Option<SupportPhase>> = Vec::new();
    let mut known: Vec<Option<&Phase>> = Vec::new();
    for section in &sections {
        section.check_keys(&KEYS, messages);
        let phase = find(section, description, messages);
        known.push(phase);
        found.push(read_phase(section, phase, names, description, messages));
    }
    check_order(&sections, &known, messages);
    let found: Vec<SupportPhase> = found.into_iter().collect::<Option<_>>()?;
    for (section, phase) in sections.iter().zip(&found) {
        if phase.unit != found[0].unit {
            let message = format!("φ is in {} here, in {} before", phase.unit, found[0].unit);
            messages.error(section.key_place("unit"), message, "use phase variables of one unit");
        }
    }
    Some(found)
}

fn find<'d>(
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
    let found = description.phases.iter().find(|phase| phase.name == name);
    if found.is_none() {
        let names: Vec<&str> = description.phases.iter().map(|phase| phase.name.as_str()).collect();
        let message = format!("the robot has no phase `{}`", short(&name));
        messages.error(at, message, suggest(&name, names, "phases of biped.toml"));
    }
    found
}

/// Each phase is followed by the next of the file, the last by the first.
fn check_order(sections: &[Section<'_, '_>], known: &[Option<&Phase>], messages: &mut Messages<'_>) {
    for (index, (section, phase)) in sections.iter().zip(known).enumerate() {
        let (Some(phase), Some(Some(next))) = (phase, known.get((index + 1) % known.len())) else { continue };
        if phase.next != next.name {
            let message =
                format!("phase `{}` is followed by `{}`, not by `{}`", phase.name, phase.next, next.name);
            let help = "write one [[phase]] for each phase of the step, in the order of biped.toml; the last is followed by the first";
            messages.error(section.key_place("name"), message, help);
        }
    }
}

fn read_phase(
    section: &Section<'_, '_>,
    phase: Option<&Phase>,
    names: &Names,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) -> Option<SupportPhase> {
    let unit = read_unit(section, messages);
    let variable = formula(section, "variable", VARIABLE, unit.as_deref(), names, messages);
    let outputs = read_outputs(section, names, messages);
    if let Some(phase) = phase {
        check_number(section, outputs.len(), phase, description, messages);
    }
    let end = read_end(section, unit.as_deref(), names, messages);
    let feedforward = match section.section("feedforward", messages) {
        Some(table) => Some(read_feedforward(&table, names, description, messages)?),
        None => None,
    };
    let feedback = match section.section("feedback", messages) {
        Some(table) => Some(read_feedback(&table, messages)?),
        None => None,
    };
    Some(SupportPhase {
        name: phase?.name.clone(),
        variable: variable?,
        variable_at: file_place(section.get("variable").and_then(|entry| entry.at), messages),
        unit: unit?,
        impact_matching: section.boolean("impact_matching", messages).unwrap_or(true),
        outputs: outputs.into_iter().collect::<Option<Vec<_>>>()?,
        end: end?,
        feedforward,
        feedback,
        posture: read_posture(section, description, messages),
    })
}

/// N − M − 1 outputs: constraints of the ground, outputs and the phase variable are as many as q; no more than actuators.
fn check_number(
    section: &Section<'_, '_>,
    found: usize,
    phase: &Phase,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) {
    let joints = description.joints.iter().filter(|joint| joint.kind.moves()).count();
    let actuated = description.actuated_joints.len();
    let held = held_rows(description, phase);
    let wanted = (joints + 2).saturating_sub(held);
    let at = section.key_place("output").or(section.at);
    if found != wanted {
        let message =
            format!("{found} outputs in phase `{}`, which leaves room for {wanted}", short(&phase.name));
        let help = format!(
            "the robot has {} coordinates, the contacts of the phase hold {held}, the phase variable is one: write {wanted} \
             [[phase.output]] tables",
            joints + 3
        );
        messages.error(at, message, help);
    } else if actuated != joints {
        let message = undriven(description);
        messages.error(at, message, "gaits are those of robots whose joints are all driven");
    } else if found > actuated {
        let message = format!("{found} outputs for {actuated} actuators in phase `{}`", short(&phase.name));
        messages.error(at, message, "a phase in the air has no gait: more outputs than actuators");
    }
}

/// Coordinates in the plane that the contacts of a phase hold.
fn held_rows(description: &RobotDescription, phase: &Phase) -> usize {
    let rows = |foot: &crate::description::model::Foot| {
        let contacts = phase.contacts.iter().filter(|contact| contact.foot == foot.name);
        let points = contacts.map(|contact| match contact.part {
            ContactPart::Flat => foot.points.len(),
            // In the plane an edge is a point.
            ContactPart::Edge(_) | ContactPart::Point(_) => 1,
        });
        match points.sum::<usize>() {
            0 => 0,
            1 => 2,
            _ => 3,
        }
    };
    description.feet.iter().map(rows).sum()
}

/// A number, or a formula of the parameters.
fn read_end(
    section: &Section<'_, '_>,
    unit: Option<&str>,
    names: &Names,
    messages: &mut Messages<'_>,
) -> Option<Formula> {
    let Some(entry) = section.get("end") else {
        let help = "add end = 0.1: φ where the phase is meant to end; h_p has vanished there";
        messages.error(section.at, format!("{} has no `end`", section.title), help);
        return None;
    };
    if entry.text().is_some() {
        return formula(section, "end", END, unit, names, messages);
    }
    let value = entry.number(messages)?;
    if names.phase_in_rad {
        check_turns(&entry, &[value], messages);
    }
    Formula::parse(&format!("{value:?}")).ok()
}

fn read_feedforward(
    table: &Section<'_, '_>,
    names: &Names,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) -> Option<Feedforward> {
    table.check_keys(&["at", "torques", "along", "plus"], messages);
    let along = read_moved(table, "along", (phase_dimension(names), names), messages);
    let at = read_places(table, messages)?;
    let mut torques = BTreeMap::new();
    let listed = table.section("torques", messages);
    for entry in listed.iter().flat_map(Section::entries) {
        if !is_joint(&entry, description, messages) {
            continue;
        }
        let Some(values) = entry.numbers(messages) else { continue };
        if values.len() != at.len() {
            let message =
                format!("{} has {} torques, `at` has {} places", entry.name(), values.len(), at.len());
            messages.error(entry.at, message, "write one torque (N m) for each place");
            continue;
        }
        torques.insert(entry.key.to_owned(), values);
    }
    let mut plus = BTreeMap::new();
    if let Some(listed) = table.section("plus", messages) {
        let torque = parse_unit("N m");
        for entry in listed.entries() {
            let known = is_joint(&entry, description, messages);
            if let Some(Some(formula)) = read_moved(&listed, entry.key, (torque, names), messages)
                && known
            {
                plus.insert(entry.key.to_owned(), formula);
            }
        }
    }
    Some(Feedforward { at, torques, along: along?, plus })
}

/// Whether an entry is called as a joint of the robot.
fn is_joint(entry: &Entry<'_, '_>, description: &RobotDescription, messages: &mut Messages<'_>) -> bool {
    let joints = || description.joints.iter().filter(|joint| joint.kind.moves()).map(|j| j.name.as_str());
    let known = joints().any(|name| name == entry.key);
    if !known {
        let message = format!("the robot has no joint `{}`", short(entry.key));
        messages.error(entry.at, message, suggest(entry.key, joints().collect::<Vec<_>>(), "joints"));
    }
    known
}

/// φ of the torques, growing.
fn read_places(table: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<Vec<f64>> {
    match table.get("at") {
        Some(entry) => {
            let at = entry.numbers(messages)?;
            if at.len() < 4 || at.windows(2).any(|pair| pair[0] >= pair[1]) {
                let help = "write 4 values of φ or more, each larger than the one before";
                messages.error(entry.at, format!("{} does not grow, or is too short", entry.name()), help);
                return None;
            }
            Some(at)
        }
        None => {
            let help = "add at = [0.0, 0.1, 0.2, 0.3]: values of φ";
            messages.error(table.at, "[phase.feedforward] has no `at`", help);
            None
        }
    }
}

fn read_feedback(table: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<[f64; 2]> {
    table.check_keys(&["stiffness", "damping"], messages);
    let mut number = |key: &'static str| {
        let Some(entry) = table.get(key) else {
            let help = "add stiffness = 400.0 (1/s²) and damping = 40.0 (1/s)";
            messages.error(table.at, format!("{} has no `{key}`", table.title), help);
            return None;
        };
        super::read::positive(&entry, messages)
    };
    let (stiffness, damping) = (number("stiffness"), number("damping"));
    Some([stiffness?, damping?])
}
