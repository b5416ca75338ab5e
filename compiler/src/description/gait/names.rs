//! What formulas of a gait can name, and of what they are then functions.
use super::dimension::{self, Dimension};
use super::joint_names::{JointNames, means_something_else};
use super::{PHASE, PHASE_END, PHASE_START};
use crate::description::model::{Base, JointKind, RobotDescription};
use crate::description::settings::table::{Entry, Section};
use crate::description::source::{Messages, short, suggest};
use bipedc_effects::effect::formula::Formula;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

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
    /// A quantity: a name of the configuration, a parameter, and a name of the phase in it or in what it names.
    leaves: [Option<String>; 3],
}

/// All names with what they stand for.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub known: BTreeMap<String, Known>,
    pub quantities: BTreeMap<String, Formula>,
    /// Whether φ is an angle.
    pub phase_in_rad: bool,
    /// Joints whose own names mean something else in formulas, and how these call them.
    renamed: BTreeMap<String, String>,
    /// What formulas outside of quantities named.
    used: RefCell<BTreeSet<String>>,
    /// Where own names of those joints stand first, in formulas of any kind.
    doubtful: RefCell<BTreeMap<String, Option<usize>>>,
}

impl Names {
    /// Joints, coordinates of a planar base, contact points, and φ with its ends, whose unit is given later.
    pub(super) fn of_robot(description: &RobotDescription) -> Self {
        let mut names = Self::default();
        let (angle, length) = (Some([0, 0, 0]), Some([1, 0, 0]));
        let joints = JointNames::of_robot(description);
        let slides = |name: &str| {
            let joint = description.joints.iter().find(|joint| joint.name == name);
            joint.is_some_and(|joint| joint.kind == JointKind::Prismatic)
        };
        for (joint, name) in joints.each() {
            names.add(name, Of::Configuration, if slides(joint) { length } else { angle });
            if joint != name && JointNames::is_word(joint) {
                names.renamed.insert(joint.to_owned(), name.to_owned());
            }
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
        for (joint, name) in joints.plainer() {
            names.add(&name, Of::Configuration, if slides(joint) { length } else { angle });
        }
        names
    }

    /// `false`: the name is taken.
    pub(super) fn add(&mut self, name: &str, of: Of, dimension: Dimension) -> bool {
        let fresh = !self.known.contains_key(name);
        if fresh {
            self.known.insert(name.to_owned(), Known { of, dimension, leaves: Default::default() });
        }
        fresh
    }

    /// Whether a formula names something, itself or by a quantity that it names.
    pub(super) fn is_used(&self, name: &str) -> bool {
        self.all_used().contains(name)
    }

    /// Everything that formulas name, themselves or by quantities.
    pub(super) fn all_used(&self) -> BTreeSet<String> {
        let mut open: Vec<String> = self.used.borrow().iter().cloned().collect();
        let mut seen: BTreeSet<String> = BTreeSet::new();
        while let Some(next) = open.pop() {
            if seen.insert(next.clone()) {
                open.extend(self.quantities.get(&next).into_iter().flat_map(|of| of.names().iter().cloned()));
            }
        }
        seen
    }

    /// What a name stands for already, if it does, for messages.
    pub(super) fn meaning(&self, name: &str) -> Option<&'static str> {
        if let Some(known) = self.known.get(name) {
            return Some(match known.of {
                Of::Configuration => "a joint, a coordinate of the base or of a contact point",
                Of::Parameter => "a parameter",
                Of::Phase => "the phase variable or one of its ends",
                Of::Quantity => "a quantity",
            });
        }
        means_something_else(name).then_some("a word of formulas")
    }

    /// The unit of φ.
    pub(super) fn set_phase_dimension(&mut self, dimension: Dimension) {
        for name in [PHASE, PHASE_START, PHASE_END] {
            self.known
                .insert(name.to_owned(), Known { of: Of::Phase, dimension, leaves: Default::default() });
        }
    }

    /// Says of a file that never calls a joint as formulas do, and has its own name, that this is something else: a number is refused, which can be written
    /// out; what has no other word is warned of.
    pub(super) fn tell_apart(&self, messages: &mut Messages<'_>) {
        for (joint, &at) in self.doubtful.borrow().iter() {
            let Some(renamed) = self.renamed.get_key_value(joint).filter(|(_, name)| !self.is_used(name))
            else {
                continue;
            };
            if joint == "pi" {
                let help = format!("write `{}` for the joint, 3.141592653589793 for the number", renamed.1);
                let message = "`pi` is both a number of formulas and a joint of this robot";
                messages.error(at, message, help);
            } else {
                let message = format!("`{}` is here {}, and not the joint", short(joint), self.meant(joint));
                messages.warning(at, message, called(renamed));
            }
        }
    }

    fn meant(&self, name: &str) -> &'static str {
        match self.known.get(name).map(|known| known.of) {
            Some(Of::Phase) => "the phase variable or one of its ends",
            _ => "a coordinate of the base or of a contact point",
        }
    }

    /// Finds out what quantities are made of, those that others name first. Each is looked at once, however many name it.
    pub(super) fn settle(&mut self, section: &Section<'_, '_>, messages: &mut Messages<'_>) {
        let mut open: Vec<Entry<'_, '_>> = section.entries();
        while !open.is_empty() {
            let ready = |entry: &Entry<'_, '_>| {
                let formula = self.quantities.get(entry.key);
                let waits = |name: &String| open.iter().any(|other| other.key == name);
                !formula.is_some_and(|formula| formula.names().iter().any(waits))
            };
            let Some(index) = open.iter().position(ready) else {
                for entry in &open {
                    let message = format!("{} depends on itself", entry.name());
                    messages.error(entry.at, message, "a quantity is made of other things");
                }
                return;
            };
            let entry = open.swap_remove(index);
            let dimension = self.formula(&entry, ANYTHING, messages).and_then(|(_, dimension)| dimension);
            let leaves =
                self.quantities.get(entry.key).map_or_else(Default::default, |formula| self.leaves(formula));
            if let Some(known) = self.known.get_mut(entry.key) {
                (known.dimension, known.leaves) = (dimension, leaves);
            }
        }
    }

    /// A name of each kind that a formula depends on.
    fn leaves(&self, formula: &Formula) -> [Option<String>; 3] {
        let mut found: [Option<String>; 3] = Default::default();
        for name in formula.names() {
            let Some(known) = self.known.get(name) else { continue };
            let of = match known.of {
                Of::Configuration => [Some(name.clone()), None, None],
                Of::Parameter => [None, Some(name.clone()), None],
                Of::Phase => [None, None, Some(name.clone())],
                Of::Quantity => known.leaves.clone(),
            };
            found = [0, 1, 2].map(|kind| found[kind].take().or_else(|| of[kind].clone()));
        }
        found
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
                let renamed = self.renamed.iter().find(|(joint, _)| holds_word(&text, joint));
                let help = renamed.map_or(error.help, called);
                messages.error(at, format!("{}: {}", entry.name(), error.message), help);
                return None;
            }
        };
        for joint in self.renamed.keys().filter(|joint| holds_word(&text, joint)) {
            let at = entry.inside_text(word_index(&text, joint), messages);
            self.doubtful.borrow_mut().entry(joint.clone()).or_insert(at);
        }
        if !allowed.rule.is_empty() {
            self.used.borrow_mut().extend(formula.names().iter().cloned());
        }
        for name in formula.names() {
            if let Err((message, help)) = self.refusal(name, allowed) {
                let at = entry.inside_text(word_index(&text, name), messages);
                messages.error(at, format!("{}: {message}", entry.name()), help);
                return None;
            }
        }
        let dimension = |name: &String| self.known.get(name).and_then(|known| known.dimension);
        let names: Vec<Dimension> = formula.names().iter().map(dimension).collect();
        match dimension::dimension_of(&formula, &names) {
            Ok(dimension) => Some((formula, dimension)),
            Err(problem) => {
                let message = format!("{}: the units do not fit: {problem}", entry.name());
                messages.error(entry.at, message, "lengths are in m, angles in rad, times in s");
                None
            }
        }
    }

    /// Why a formula cannot have this name, and what to do.
    fn refusal(&self, name: &str, allowed: Allowed) -> Result<(), (String, String)> {
        let Some(known) = self.known.get(name) else {
            let names: Vec<&str> = self.known.keys().map(String::as_str).collect();
            return Err((format!("nothing is called `{}`", short(name)), suggest(name, names, "names")));
        };
        let rules = [allowed.configuration, allowed.parameters, allowed.phase];
        let words = ["belongs to the configuration", "is a gait parameter", "belongs to the phase variable"];
        let leaves = match known.of {
            Of::Configuration => [Some(name), None, None],
            Of::Parameter => [None, Some(name), None],
            Of::Phase => [None, None, Some(name)],
            Of::Quantity => [0, 1, 2].map(|kind| known.leaves[kind].as_deref()),
        };
        match (0..3).find_map(|kind| leaves[kind].filter(|_| !rules[kind]).map(|leaf| (leaf, words[kind]))) {
            None => Ok(()),
            Some((leaf, word)) => {
                let joint = self.renamed.get_key_value(leaf);
                let help = joint.map_or_else(|| allowed.rule.to_owned(), called);
                Err((format!("`{}` {word}", short(leaf)), help))
            }
        }
    }
}

/// Formulas of `[quantities]`: what they may name shows where they are used.
const ANYTHING: Allowed = Allowed { configuration: true, parameters: true, phase: true, rule: "" };

/// What to write for a joint whose own name means something else in formulas.
fn called((joint, name): (&String, &String)) -> String {
    format!(
        "`{}` means something else in formulas: the joint of that name is called `{name}` there",
        short(joint)
    )
}

/// Whether a text holds a name as a whole word that is no call of a function.
fn holds_word(text: &str, name: &str) -> bool {
    let behind = place_of_word(text, name).and_then(|at| text.get(at + name.len()..));
    behind.is_some_and(|behind| !behind.trim_start().starts_with('('))
}

/// Where a name begins in a formula, in characters.
fn word_index(text: &str, name: &str) -> usize {
    let found = place_of_word(text, name).unwrap_or(0);
    text.get(..found).map_or(0, |part| part.chars().count())
}

/// Where a name stands as a whole word, in bytes.
fn place_of_word(text: &str, name: &str) -> Option<usize> {
    let letter = |c: char| c.is_alphanumeric() || c == '_';
    let whole = |at: &usize| {
        let before = text.get(..*at).and_then(|part| part.chars().next_back());
        let after = text.get(at + name.len()..).and_then(|part| part.chars().next());
        !before.is_some_and(letter) && !after.is_some_and(letter)
    };
    text.match_indices(name).map(|(at, _)| at).find(whole)
}
