//! Reading states: names are checked while the text is parsed, so that messages know line and column.
use super::coordinates::BaseCoordinates;
use super::{BaseState, Coordinates};
use crate::description::source::suggest;
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::magnitude;
use bipedc_runtime::Argument;
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// Reads all states of a file (`file` is for messages) for a robot.
///
/// # Errors
/// Broken JSON, unknown keys, joints and contact points, motion that the base cannot have; with line and
/// column.
pub fn read_states(text: &str, file: &Path, tree: &Tree) -> Result<Vec<Coordinates>, Diagnostics> {
    let mut parser = serde_json::Deserializer::from_str(text);
    let read = States(tree).deserialize(&mut parser).and_then(|states| parser.end().map(|()| states));
    read.map_err(|error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = error.to_string();
        let message = message.strip_suffix(&place).unwrap_or(&message);
        let (message, help) = message.split_once(HELP).unwrap_or((message, GENERAL_HELP));
        Diagnostics(vec![
            Diagnostic::error(message).in_file(file).at(error.line(), error.column()).help(help),
        ])
    })
}

/// Separates message and help within the one string that a JSON error carries.
const HELP: &str = "\u{1f}";
const GENERAL_HELP: &str =
    "a state is {\"base\": {…}, \"position\": {joint: value}, \"velocity\": {…}, …}, or an array of them";

const STATE_KEYS: [&str; 9] = [
    "base",
    "position",
    "velocity",
    "acceleration",
    "effort",
    "forces",
    "motor_position",
    "motor_velocity",
    "motor_acceleration",
];
const BASE_KEYS: [&str; 8] = [
    "position",
    "orientation",
    "linear_velocity",
    "angular_velocity",
    "linear_acceleration",
    "angular_acceleration",
    "force",
    "torque",
];
/// Results that somebody keeps beside a state are no business of ours.
const IGNORED: &str = "expected";

fn unknown<'c, E: Error>(what: &str, name: &str, known: impl IntoIterator<Item = &'c str> + Clone) -> E {
    E::custom(format!("unknown {what} `{name}`{HELP}{}", suggest(name, known, "known are")))
}

fn twice<E: Error>(what: &str) -> E {
    E::custom(format!("{what} stands twice in one state{HELP}remove one of them"))
}

/// A number of possible size.
#[derive(Clone, Copy)]
struct Number(f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let value = f64::deserialize(d)?;
        match magnitude::refusal(value) {
            None => Ok(Self(value)),
            Some((problem, help)) => {
                Err(D::Error::custom(format!("the number {value:e} {problem}{HELP}{help}")))
            }
        }
    }
}

/// The next value of a map: so many numbers.
fn numbers<'de, A: MapAccess<'de>, const N: usize>(map: &mut A) -> Result<[f64; N], A::Error>
where
    [Number; N]: Deserialize<'de>,
{
    Ok(map.next_value::<[Number; N]>()?.map(|number| number.0))
}

struct States<'t>(&'t Tree);

impl<'de> DeserializeSeed<'de> for States<'_> {
    type Value = Vec<Coordinates>;
    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        d.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for States<'_> {
    type Value = Vec<Coordinates>;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a state or an array of states")
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        Ok(vec![StateVisitor(self.0).visit_map(map)?])
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut out = Vec::new();
        while let Some(state) = list.next_element_seed(StateVisitor(self.0))? {
            out.push(state);
        }
        Ok(out)
    }
}

struct StateVisitor<'t>(&'t Tree);

impl<'de> DeserializeSeed<'de> for StateVisitor<'_> {
    type Value = Coordinates;
    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        d.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for StateVisitor<'_> {
    type Value = Coordinates;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a state (an object)")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let tree = self.0;
        let mut base = None;
        let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        while let Some(key) = map.next_key::<String>()? {
            if values.contains_key(&key) || (key == "base" && base.is_some()) {
                return Err(twice(&format!("`{key}`")));
            }
            match key.as_str() {
                "base" => base = Some(map.next_value_seed(BaseVisitor(tree))?),
                IGNORED => drop(map.next_value::<IgnoredAny>()?),
                "forces" => drop(values.insert(key, map.next_value_seed(PointForces(tree))?)),
                "motor_position" | "motor_velocity" | "motor_acceleration" => {
                    drop(values.insert(key, map.next_value_seed(JointValues { tree, pivot: false })?));
                }
                name if STATE_KEYS.contains(&name) => {
                    let pivot = tree.base == BaseKind::Pivot;
                    drop(values.insert(key, map.next_value_seed(JointValues { tree, pivot })?));
                }
                name => return Err(unknown("key", name, STATE_KEYS)),
            }
        }
        let base = match base {
            Some(base) => base,
            None => BaseState::default().coordinates(tree.base).map_err(A::Error::custom)?,
        };
        Ok(assemble(tree, base, &mut values))
    }
}

fn assemble(tree: &Tree, base: BaseCoordinates, values: &mut BTreeMap<String, Vec<f64>>) -> Coordinates {
    let pivot = usize::from(tree.base == BaseKind::Pivot);
    let mut take = |key: &str, length: usize| values.remove(key).unwrap_or_else(|| vec![0.0; length]);
    let joints = tree.joints.len();
    let mut arguments: [Vec<f64>; Argument::COUNT] = Default::default();
    let moved = [
        (Argument::Q, base.q, "position"),
        (Argument::V, base.v, "velocity"),
        (Argument::A, base.a, "acceleration"),
        (Argument::Tau, base.tau, "effort"),
    ];
    for (argument, mut values, key) in moved {
        values.extend(take(key, joints + pivot));
        arguments[argument as usize] = values;
    }
    arguments[Argument::Forces as usize] = take("forces", 3 * tree.points.len());
    arguments[Argument::MotorQ as usize] = take("motor_position", joints);
    arguments[Argument::MotorV as usize] = take("motor_velocity", joints);
    arguments[Argument::MotorA as usize] = take("motor_acceleration", joints);
    Coordinates { arguments }
}

struct BaseVisitor<'t>(&'t Tree);

impl<'de> DeserializeSeed<'de> for BaseVisitor<'_> {
    type Value = BaseCoordinates;
    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        d.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for BaseVisitor<'_> {
    type Value = BaseCoordinates;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the base's position, orientation, … (an object)")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut base = BaseState::default();
        let mut seen: Vec<String> = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            if seen.contains(&key) {
                return Err(twice(&format!("`{key}` of the base")));
            }
            seen.push(key.clone());
            match key.as_str() {
                "orientation" => base.orientation = map.next_value()?,
                "position" => base.position = numbers(&mut map)?,
                "linear_velocity" => base.linear_velocity = numbers(&mut map)?,
                "angular_velocity" => base.angular_velocity = numbers(&mut map)?,
                "linear_acceleration" => base.linear_acceleration = numbers(&mut map)?,
                "angular_acceleration" => base.angular_acceleration = numbers(&mut map)?,
                "force" => base.force = numbers(&mut map)?,
                "torque" => base.torque = numbers(&mut map)?,
                name => return Err(unknown("key of the base", name, BASE_KEYS)),
            }
        }
        base.coordinates(self.0.base).map_err(A::Error::custom)
    }
}

/// `{joint: value}` in the order of the joints; on a pivot its angle first.
struct JointValues<'t> {
    tree: &'t Tree,
    pivot: bool,
}

impl<'de> DeserializeSeed<'de> for JointValues<'_> {
    type Value = Vec<f64>;
    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        d.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for JointValues<'_> {
    type Value = Vec<f64>;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("numbers by joint name (an object)")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let pivot = self.pivot.then_some("base/pivot");
        let names: Vec<&str> =
            pivot.into_iter().chain(self.tree.joints.iter().map(|joint| joint.name.as_str())).collect();
        let mut values = vec![None; names.len()];
        while let Some(key) = map.next_key::<String>()? {
            let Some(index) = names.iter().position(|name| *name == key) else {
                return Err(unknown("joint", &key, names.iter().copied()));
            };
            if values[index].is_some() {
                return Err(twice(&format!("joint `{key}`")));
            }
            values[index] = Some(map.next_value::<Number>()?.0);
        }
        Ok(values.into_iter().map(Option::unwrap_or_default).collect())
    }
}

/// `{foot/point: [x, y, z]}`, world axes, N.
struct PointForces<'t>(&'t Tree);

impl<'de> DeserializeSeed<'de> for PointForces<'_> {
    type Value = Vec<f64>;
    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<Self::Value, D::Error> {
        d.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for PointForces<'_> {
    type Value = Vec<f64>;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("forces by contact point (an object)")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let points = &self.0.points;
        let mut values = vec![None; points.len()];
        while let Some(key) = map.next_key::<String>()? {
            let Some(index) = points.iter().position(|point| point.name == key) else {
                return Err(unknown("contact point", &key, points.iter().map(|point| point.name.as_str())));
            };
            if values[index].is_some() {
                return Err(twice(&format!("contact point `{key}`")));
            }
            values[index] = Some(numbers::<A, 3>(&mut map)?);
        }
        Ok(values.into_iter().flat_map(Option::unwrap_or_default).collect())
    }
}
