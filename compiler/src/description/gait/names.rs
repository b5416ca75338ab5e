//! What formulas of a gait can name, and of what they are then functions.
use super::dimension::{self, Dimension};
use super::{PHASE, PHASE_END, PHASE_START};
use crate::description::model::{Base, JointKind, RobotDescription};
use crate::description::settings::table::Entry;
use crate::description::source::{Messages, suggest};
use bipedc_effects::effect::formula::Formula;
use std::collections::BTreeMap;

/// Quantities that refer to each other deeper than this go in a circle.
const DEPTH: usize = 32;

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    /// A function of q.
    Configuration,
    /// A gait parameter.
    Parameter,
    /// φ, φ₊ or φ₋.
    Phase,
    /// Another formula.
    Quantity,
}

/// Which names a formula may have.
#[derive(Debug, Clone, Copy)]
pub(super) struct Allowed {
    pub configuration: bool,
    pub parameters: bool,
    pub phase: bool,
    /// "a controlled quantity depends on the configuration alone", for messages.
    pub rule: &'static str,
}

#[derive(Debug, Clone)]
pub(super) struct Known {
    pub of: Of,
    pub dimension: Dimension,
}

/// All names with what they stand for.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub known: BTreeMap<String, Known>,
    pub quantities: BTreeMap<String, Formula>,
}

impl Names {
    /// Joints, coordinates of a planar base, contact points, and φ with its ends, whose unit is given later.
    pub(super) fn of_robot(description: &RobotDescription) -> Self {
        let mut names = Self::default();
        let (angle, length) = (Some([0, 0, 0]), Some([1, 0, 0]));
        for joint in description.joints.iter().filter(|joint| joint.kind.moves()) {
            let unit = if joint.kind == JointKind::Prismatic { length } else { angle };
            names.add(&joint.name, Of::Configuration, unit);
        }
        if matches!(description.base, Base::Planar { .. }) {
            names.add("base_x", Of::Configuration, length);
            names.add("base_z", Of::Configuration, length);
            names.add("base_pitch", Of::Configuration, angle);
        }
        for foot in &description.feet {
            for point in &foot.points {
                for axis in ["x", "z"] {
                    names.add(&format!("{}_{}_{axis}", foot.name, point.name), Of::Configuration, length);
                }
            }
        }
        for name in [PHASE, PHASE_START, PHASE_END] {
            names.add(name, Of::Phase, None);
        }
        names
    }

    /// `false`: the name is taken.
    pub(super) fn add(&mut self, name: &str, of: Of, dimension: Dimension) -> bool {
        let fresh = !self.known.contains_key(name);
        if fresh {
            self.known.insert(name.to_owned(), Known { of, dimension });
        }
        fresh
    }

    /// The unit of φ.
    pub(super) fn set_phase_dimension(&mut self, dimension: Dimension) {
        for name in [PHASE, PHASE_START, PHASE_END] {
            self.known.insert(name.to_owned(), Known { of: Of::Phase, dimension });
        }
    }

    /// Reads a formula, with all that it names in its quantities, and its unit.
    pub(super) fn formula(
        &self,
        entry: &Entry<'_, '_>,
        allowed: Allowed,
        messages: &mut Messages<'_>,
    ) -> Option<(Formula, Dimension)> {
        let text = entry.string(messages)?;
        let formula = match Formula::parse(&text) {
            Ok(formula) => formula,
            Err(error) => {
                let at = entry.inside_text(error.at, messages);
                messages.error(at, format!("{}: {}", entry.name(), error.message), error.help);
                return None;
            }
        };
        for name in formula.names() {
            if let Err((message, help)) = self.refusal(name, allowed, 0) {
                let index = word_index(&text, name);
                messages.error(
                    entry.inside_text(index, messages),
                    format!("{}: {message}", entry.name()),
                    help,
                );
                return None;
            }
        }
        match self.dimension(&formula, 0) {
            Ok(dimension) => Some((formula, dimension)),
            Err(problem) => {
                let message = format!("{}: the units do not fit: {problem}", entry.name());
                messages.error(entry.at, message, "lengths are in m, angles in rad, times in s");
                None
            }
        }
    }

    /// Why a formula cannot have this name, and what to do.
    fn refusal(&self, name: &str, allowed: Allowed, depth: usize) -> Result<(), (String, String)> {
        let Some(known) = self.known.get(name) else {
            let names = || self.known.keys().map(String::as_str);
            return Err((
                format!("nothing is called `{name}`"),
                suggest(name, names().collect::<Vec<_>>(), "names"),
            ));
        };
        let (fits, what) = match known.of {
            Of::Configuration => (allowed.configuration, "belongs to the configuration"),
            Of::Parameter => (allowed.parameters, "is a gait parameter"),
            Of::Phase => (allowed.phase, "belongs to the phase variable"),
            Of::Quantity if depth > DEPTH => {
                return Err((
                    format!("`{name}` depends on itself"),
                    "a quantity is made of other things".into(),
                ));
            }
            Of::Quantity => {
                let inner = self.quantities.get(name).map_or(&[][..], Formula::names);
                return inner.iter().try_for_each(|name| self.refusal(name, allowed, depth + 1));
            }
        };
        if fits {
            return Ok(());
        }
        Err((format!("`{name}` {what}"), allowed.rule.to_owned()))
    }

    fn dimension(&self, formula: &Formula, depth: usize) -> Result<Dimension, String> {
        if depth > DEPTH {
            return Err("a quantity depends on itself".to_owned());
        }
        let of = |name: &String| match (self.known.get(name), self.quantities.get(name)) {
            (_, Some(quantity)) => self.dimension(quantity, depth + 1),
            (Some(known), None) => Ok(known.dimension),
            (None, None) => Ok(None),
        };
        let names = formula.names().iter().map(of).collect::<Result<Vec<_>, _>>()?;
        dimension::dimension_of(formula, &names)
    }
}

/// Where a name begins in a formula, in characters.
fn word_index(text: &str, name: &str) -> usize {
    let letter = |c: char| c.is_alphanumeric() || c == '_';
    let whole = |at: &usize| {
        let before = text.get(..*at).and_then(|part| part.chars().next_back());
        let after = text.get(at + name.len()..).and_then(|part| part.chars().next());
        !before.is_some_and(letter) && !after.is_some_and(letter)
    };
    let found = text.match_indices(name).map(|(at, _)| at).find(whole).unwrap_or(0);
    text.get(..found).map_or(0, |part| part.chars().count())
}
