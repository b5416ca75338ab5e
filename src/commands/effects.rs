//! `bipedc effects`: the library of what a rigid-body model may lack.
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::amendment::comments::unit_words;
use bipedc::kinds::demand_kind;
use bipedc::table::table;
use bipedc_effects::effect::{KINDS, Kind, Law, Parameter, Place, Role};
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc effects                     all kinds with their parameters and units
  bipedc effects coulomb_friction    its law, what it looks like
  bipedc effects --json

An effect is written as an [[effect]] table in biped.toml: by hand or by `bipedc amend`.
JSON, of one kind or a list of all: {\"kind\", \"title\", \"place\", \"meaning\", \"law\", \"symptom\", \"experiment\", \"example\", \
\"parameters\": [{\"name\", \"unit\", \"meaning\", \"bounds\", \"default\", \"plausible\"}], \"confounders\": [{\"kind\", \"experiment\"}]}.";

/// List the physical effects that can be added to a model
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Effects {
    /// Everything about this kind
    #[arg(value_name = "KIND")]
    kind: Option<String>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

impl Effects {
    /// Prints all kinds, or one.
    pub fn run(self) -> Outcome {
        let kind = self.kind.as_deref().map(demand_kind).transpose()?;
        match (kind, self.json) {
            (Some(kind), true) => output::print_json(&as_json(kind))?,
            (Some(kind), false) => output::print(&card(kind))?,
            (None, true) => output::print_json(&KINDS.iter().map(|kind| as_json(kind)).collect::<Vec<_>>())?,
            (None, false) => output::print(&list())?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn list() -> String {
    let parameters = |kind: &Kind| {
        let estimated = kind.estimated().map(|p| format!("{} ({})", p.name, p.unit));
        let names: Vec<String> = estimated.collect();
        if names.is_empty() { "—".to_owned() } else { names.join(", ") }
    };
    let rows = KINDS.iter().map(|kind| {
        vec![kind.name.to_owned(), place(kind).0.to_owned(), parameters(kind), kind.meaning.to_owned()]
    });
    table(&["kind", "place", "parameters (unit)", "meaning"], rows.collect(), 4)
        + "\nbipedc effects KIND shows law, symptom and what it is confused with; bipedc amend adds one to a robot.\n"
}

/// In a word, and as keys of the description with an example.
fn place(kind: &Kind) -> (&'static str, &'static [(&'static str, &'static str)]) {
    match kind.place {
        Place::Joint => ("joint", &[("joint", "left_knee_pitch")]),
        Place::JointPair => {
            ("two joints", &[("joint", "left_ankle_roll"), ("other_joint", "left_ankle_pitch")])
        }
        Place::Link => ("link", &[("link", "torso")]),
        Place::Sensor => ("sensor", &[("sensor", "left_foot")]),
        Place::Robot => ("robot", &[]),
    }
}

/// The law as a formula, in words where it is none.
fn law(kind: &Kind) -> String {
    let words = match kind.law {
        Law::Torque(text) => return format!("reported torque = rigid-body torque + {text}"),
        Law::Reading(text) => return format!("reported torque = {text}, where `torque` is the true one"),
        Law::TrueTorque(text) => return format!("true torque = {text}, where `reading` is the reported one"),
        Law::Formula => "reported torque = rigid-body torque + your formula",
        Law::Delay => "true torque(t) = reported torque(t - delay)",
        Law::EncoderOffset => "logged position = true position + offset",
        Law::Payload => "a point mass at (x, y, z) of the link's frame, moving with the link",
        Law::CenterOfMassOffset => "centre of mass = that of the URDF + (x, y, z)",
        Law::InertialCorrection => "mass, centre of mass, inertia about it = those of the URDF + these",
        Law::InertiaError => "inertia about the centre of mass = that of the URDF + these six components",
        Law::GravityTilt => {
            "the world is turned against what the base orientation says by R_y(pitch) R_x(roll)"
        }
        Law::GroundSlope => "the ground is turned against level by R_y(pitch) R_x(roll)",
        Law::SeriesElasticity => "transmitted torque = stiffness * (motor angle at the joint - joint angle)",
        Law::Backlash => {
            "the motor angle at the joint and the joint angle differ by up to gap from stop to stop"
        }
        Law::ForceSensorGain => "reported force = gain * true force",
        Law::ForceSensorBias => "reported force = true force + (x, y, z)",
        Law::ForceSensorSaturation => "reported force = min(true force, limit)",
        Law::GroundCompliance => "force below a corner = stiffness * depth + damping * speed of sinking in",
        Law::Restitution => "normal speed after the impact = coefficient * normal speed before",
        Law::Slip => "the foot holds while tangential force <= friction * normal force",
        Law::SpinFriction => {
            "the foot holds while moment about the vertical <= friction * radius * normal force"
        }
        Law::PointFeet | Law::NoImpact | Law::SingleMass | Law::DecoupledPlanes => kind.meaning,
    };
    words.to_owned()
}

fn card(kind: &Kind) -> String {
    let mut text = format!("{} ({})\n{}\n\n", kind.title, kind.name, kind.meaning);
    let _ = writeln!(text, "law         {}", law(kind));
    if law(kind).contains("sign(") {
        text += "            sign(x) is tanh(x / smoothing)\n";
    }
    let _ = writeln!(text, "symptom     the residual {}", kind.symptom);
    let _ = writeln!(text, "experiment  {}\n", kind.experiment);
    if !kind.parameters.is_empty() {
        let rows = kind.parameters.iter().map(|p| {
            let role = match p.role {
                Role::Estimated => "from data".to_owned(),
                Role::Setting(value) => format!("{value} unless given"),
            };
            vec![
                p.name.to_owned(),
                p.unit.to_owned(),
                p.meaning.to_owned(),
                role,
                range(p.bounds),
                range(p.plausible),
            ]
        });
        let head = ["parameter", "unit", "meaning", "value", "possible", "usual"];
        text += &table(&head, rows.collect(), 6);
        text.push('\n');
    }
    if !kind.confounders.is_empty() {
        text += "Easily confused with, and what tells them apart:\n";
        for confounder in kind.confounders {
            let _ = writeln!(text, "  {:28} {}", confounder.kind, confounder.experiment);
        }
        text.push('\n');
    }
    let _ = write!(text, "In biped.toml:\n\n{}", example(kind));
    text
}

fn range((low, high): (f64, f64)) -> String {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{low} to {high}"),
        (true, false) => format!("{low} or more"),
        (false, true) => format!("{high} or less"),
        (false, false) => "any".to_owned(),
    }
}

/// A table that a description of a robot with these names accepts.
fn example(kind: &Kind) -> String {
    let mut text = format!("[[effect]]\nkind = \"{}\"\n", kind.name);
    for (key, name) in place(kind).1 {
        let _ = writeln!(text, "{key} = \"{name}\"");
    }
    if kind.law == Law::Formula {
        text += "name = \"cable\"\ntorque = \"k * sin(3 * position)\"  # N m\n";
        text += "parameters.k = { value = 0.1, unit = \"N m\", min = 0.0, max = 2.0 }\n";
        return text;
    }
    for parameter in kind.estimated() {
        let _ = writeln!(
            text,
            "{} = {:?}  # {}",
            parameter.name,
            parameter.example(),
            unit_words(parameter.unit)
        );
    }
    text
}

fn as_json(kind: &Kind) -> Value {
    let bound = |value: f64| value.is_finite().then_some(value);
    let parameter = |p: &Parameter| {
        let default = match p.role {
            Role::Setting(value) => Some(value),
            Role::Estimated => None,
        };
        json!({
            "name": p.name, "unit": p.unit, "meaning": p.meaning, "default": default,
            "bounds": [bound(p.bounds.0), bound(p.bounds.1)],
            "plausible": [bound(p.plausible.0), bound(p.plausible.1)],
        })
    };
    let confounder =
        |c: &bipedc_effects::effect::Confounder| json!({ "kind": c.kind, "experiment": c.experiment });
    json!({
        "kind": kind.name, "title": kind.title, "place": place(kind).0, "meaning": kind.meaning, "law": law(kind),
        "symptom": kind.symptom, "experiment": kind.experiment,
        "parameters": kind.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "confounders": kind.confounders.iter().map(confounder).collect::<Vec<_>>(),
        "example": example(kind),
    })
}
