//! `[[effect]]` of a scenario: what is hidden. Written as in `biped.toml`.
use super::reading::Reading;
use crate::robot::{BaseKind, Foot};
use crate::simulate::Plant;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::effect::{Effect, KINDS, Kind, Law, Location, Parameter, Place, Role, kind};
use bipedc_effects::spelling::suggest;
use std::collections::BTreeMap;
use toml::{Spanned, Value};

type Table = BTreeMap<String, Spanned<Value>>;

/// Reads one table; what is wrong goes to `reading`.
pub(super) fn effect(reading: &mut Reading<'_>, plant: &Plant, table: &Spanned<Table>) -> Option<Effect> {
    let at = table.span().start;
    let entries = table.get_ref();
    let name = match entries.get("kind").map(|value| (value.get_ref().as_str(), value.span().start)) {
        Some((Some(name), _)) => name,
        Some((None, at)) => return reading.wrong(at, "`kind` is not a text", "write kind = \"payload\""),
        None => return reading.wrong(at, "an [[effect]] has no `kind`", "add kind = \"coulomb_friction\""),
    };
    let Some(kind) = kind(name) else {
        let names = KINDS.iter().map(|kind| kind.name);
        let help = suggest(name, names, || "`bipedc effects` lists them".to_owned());
        return reading.wrong(at, format!("there is no effect `{name}`"), help);
    };
    if let Some(why) = refused(kind, plant) {
        return reading.wrong(at, format!("`{name}` cannot be simulated: {why}"), "leave it out");
    }
    let mut effect = Effect::new(kind, Location::default(), &[]);
    let mut fine = true;
    for (key, value) in entries.iter().filter(|(key, _)| *key != "kind") {
        if let Err(problem) = set(&mut effect, kind, plant, key, value.get_ref()) {
            let help = problem.help.unwrap_or_default();
            reading.wrong::<()>(value.span().start, problem.message, help);
            fine = false;
        }
    }
    if !fine {
        return None;
    }
    if let Some((what, help)) = impossible(kind, &effect, plant) {
        return reading.wrong(at, what, help);
    }
    let missing = missing_place(kind, &effect).or_else(|| {
        let needed = kind.estimated().find(|p| !effect.parameters.contains_key(p.name));
        needed.map(|p| format!("`{}` ({}: {})", p.name, p.unit, p.meaning))
    });
    match missing {
        Some(what) => reading.wrong(at, format!("[[effect]] `{name}` has no {what}"), "add it"),
        None => Some(effect),
    }
}

/// Why a kind has no place in a simulation.
fn refused(kind: &Kind, plant: &Plant) -> Option<&'static str> {
    let fixed = plant.layout.base == BaseKind::Fixed;
    match kind.law {
        Law::PointFeet | Law::NoImpact | Law::SingleMass | Law::DecoupledPlanes => {
            Some("it is an assumption about models, nothing that a robot does")
        }
        Law::GroundSlope if fixed => Some("the robot hangs on a stand and touches no ground"),
        Law::SpinFriction if plant.feet.iter().all(|foot| foot.corners.len() < 3) => {
            Some("no foot has a sole that could turn: three contact points at least")
        }
        _ => None,
    }
}

/// What must be so and is not, besides missing parameters.
fn impossible(kind: &Kind, effect: &Effect, plant: &Plant) -> Option<(String, String)> {
    let planar = plant.layout.base == BaseKind::Planar;
    match kind.law {
        Law::GroundSlope | Law::GravityTilt if planar && effect.value("roll") != 0.0 => {
            Some(("`roll` of a robot in the plane".to_owned(), "write roll = 0.0".to_owned()))
        }
        Law::Formula => match effect.torque.as_deref().map(Formula::parse) {
            None => Some((
                "[[effect]] `formula` has no `torque`".to_owned(),
                "add torque = \"k * sin(position)\", and parameters.k = 1.0".to_owned(),
            )),
            Some(Err(error)) => Some((format!("`torque` does not read: {error}"), error.help)),
            Some(Ok(_)) => None,
        },
        _ => None,
    }
}

fn missing_place(kind: &Kind, effect: &Effect) -> Option<String> {
    let place = &effect.location;
    match kind.place {
        Place::Joint | Place::JointPair if place.joint.is_none() => Some("`joint`".into()),
        Place::JointPair if place.other_joint.is_none() => Some("`other_joint`".into()),
        Place::Link if place.link.is_none() => Some("`link`".into()),
        _ => None,
    }
}

/// Numbers that the author of a formula named: plain ones, or tables with a `value`.
fn own_parameters(effect: &mut Effect, value: &Value) -> Result<(), Diagnostic> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|x| x as f64));
    let table = value.as_table().ok_or_else(|| {
        Diagnostic::error("`parameters` is not a table").help("write parameters.k = 0.1, or { value = 0.1 }")
    })?;
    for (name, value) in table {
        let found = number(value).or_else(|| value.get("value").and_then(number)).filter(|x| x.is_finite());
        let Some(found) = found else {
            return Err(Diagnostic::error(format!("`parameters.{name}` has no value"))
                .help(format!("write parameters.{name} = 0.1, or {{ value = 0.1 }}")));
        };
        effect.parameters.insert(name.clone(), found);
    }
    Ok(())
}

fn set(effect: &mut Effect, kind: &Kind, plant: &Plant, key: &str, value: &Value) -> Result<(), Diagnostic> {
    if let Some(parameter) = kind.parameter(key) {
        let number = possible(kind, parameter, value)?;
        effect.parameters.insert(key.to_owned(), number);
        return Ok(());
    }
    match key {
        "torque" if kind.law == Law::Formula => effect.torque = Some(text(key, value)?),
        "name" if kind.law == Law::Formula => effect.name = Some(text(key, value)?),
        "parameters" if kind.law == Law::Formula => own_parameters(effect, value)?,
        _ => set_place(&mut effect.location, kind, plant, key, value)?,
    }
    Ok(())
}

fn text(key: &str, value: &Value) -> Result<String, Diagnostic> {
    value.as_str().map(str::to_owned).ok_or_else(|| Diagnostic::error(format!("`{key}` is not a text")))
}

/// A number within the parameter's bounds.
fn possible(kind: &Kind, parameter: &Parameter, value: &Value) -> Result<f64, Diagnostic> {
    let number = value.as_float().or_else(|| value.as_integer().map(|x| x as f64));
    let (low, high) = parameter.bounds;
    number.filter(|x| x.is_finite() && *x >= low && *x <= high).ok_or_else(|| {
        let unit = parameter.unit;
        Diagnostic::error(format!("`{}` of `{}` has no possible value", parameter.name, kind.name))
            .help(format!("the {} is a number from {low} to {high} {unit}", parameter.meaning))
    })
}

/// Where an effect is: a name that the robot has.
fn set_place(
    location: &mut Location,
    kind: &Kind,
    plant: &Plant,
    key: &str,
    value: &Value,
) -> Result<(), Diagnostic> {
    let (wanted, what, names): (_, _, Vec<String>) = match (key, kind.place) {
        ("other_joint", _) if kind.law == Law::Formula => {
            (&mut location.other_joint, "joint", plant.joint_names().map(str::to_owned).collect())
        }
        ("joint", Place::Joint | Place::JointPair) => {
            (&mut location.joint, "joint", plant.joint_names().map(str::to_owned).collect())
        }
        ("other_joint", Place::JointPair) => {
            (&mut location.other_joint, "joint", plant.joint_names().map(str::to_owned).collect())
        }
        ("link", Place::Link) => (&mut location.link, "link", plant.links.clone()),
        ("sensor", Place::Sensor) => (&mut location.sensor, "foot or corner", sensors(plant)),
        _ => {
            let names: Vec<&str> = kind.parameters.iter().map(|p| p.name).collect();
            let otherwise = || format!("its parameters: {}", names.join(", "));
            let help = suggest(key, names.iter().copied(), otherwise);
            return Err(Diagnostic::error(format!("`{}` has no `{key}`", kind.name)).help(help));
        }
    };
    *wanted = Some(known(text(key, value)?, what, &names)?);
    Ok(())
}

/// Feet and their corners.
fn sensors(plant: &Plant) -> Vec<String> {
    let of = |foot: &Foot| {
        let corners = foot.corners.iter().map(|corner| format!("{}/{}", foot.name, corner.name));
        std::iter::once(foot.name.clone()).chain(corners).collect::<Vec<_>>()
    };
    plant.feet.iter().flat_map(of).collect()
}

fn known(name: String, what: &str, names: &[String]) -> Result<String, Diagnostic> {
    if names.contains(&name) {
        return Ok(name);
    }
    let help =
        suggest(&name, names.iter().map(String::as_str), || format!("there are: {}", names.join(", ")));
    Err(Diagnostic::error(format!("there is no {what} `{name}`")).help(help))
}

/// Settings that were left out, so that the truth says everything.
pub(super) fn with_settings(mut effect: Effect) -> Effect {
    for parameter in effect.kind.parameters {
        if let Role::Setting(default) = parameter.role {
            effect.parameters.entry(parameter.name.to_owned()).or_insert(default);
        }
    }
    effect
}
