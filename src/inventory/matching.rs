//! Which joint of a robot a column is of, from its name.
use super::words::{Quantity, index, quantity, subject, telling, words};
use bipedc_effects::diagnostic::list;
use std::collections::BTreeMap;

/// A column of the file with what its name seems to say.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Guess {
    /// Place of the column in the file, from 0.
    pub field: usize,
    /// Place of the joint in the list that was asked about.
    pub joint: usize,
    pub quantity: &'static str,
    pub scale: f64,
    pub unit: Option<&'static str>,
}

/// What names say of joints.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Guesses {
    pub found: Vec<Guess>,
    /// What was taken for granted, for people.
    pub assumptions: Vec<String>,
    /// Columns that might have been of a joint, and why they are of none.
    pub doubts: Vec<String>,
}

/// Columns with their fields, against joints in the order of the model; `actuated`: those of them with an actuator, in the
/// order of the torques.
pub(super) fn guess(columns: &[(usize, &str)], joints: &[&str], actuated: &[usize]) -> Guesses {
    let mut guesses = Guesses::default();
    let mut numbered: BTreeMap<(&'static str, String), Vec<Numbered>> = BTreeMap::new();
    for &(field, name) in columns {
        if let Some((joint, quantity)) = named(name, joints) {
            guesses.found.push(of(field, joint, &quantity));
        } else if let Some(column) = Numbered::of(field, name) {
            numbered.entry((column.quantity.name, column.group.clone())).or_default().push(column);
        }
    }
    for ((quantity, _), columns) in numbered {
        in_order(quantity, &columns, (joints, actuated), &mut guesses);
    }
    drop_doubles(columns, joints, &mut guesses);
    guesses
}

fn of(field: usize, joint: usize, quantity: &Quantity) -> Guess {
    Guess { field, joint, quantity: quantity.name, scale: quantity.scale, unit: quantity.unit }
}

/// The joint that a column names, as it is or nearly.
fn named(name: &str, joints: &[&str]) -> Option<(usize, Quantity)> {
    contained(name, joints).or_else(|| {
        let words = words(name);
        let quantity = quantity(&words)?;
        let joint = alike(&subject(&words, &quantity), joints)?;
        Some((joint, quantity))
    })
}

/// The longest joint name that stands in the column's, word by word; the other words say the quantity.
fn contained(name: &str, joints: &[&str]) -> Option<(usize, Quantity)> {
    let all = words(name);
    let mut best: Option<(usize, usize, Quantity)> = None;
    for (joint, joint_name) in joints.iter().enumerate() {
        let wanted = words(joint_name);
        let same = |at: usize| wanted.iter().zip(&all[at..]).all(|(a, b)| a.text == b.text);
        if wanted.is_empty() || wanted.len() > all.len() {
            continue;
        }
        let Some(at) = (0..=all.len() - wanted.len()).rev().find(|&at| same(at)) else { continue };
        let mut rest = all.clone();
        rest.drain(at..at + wanted.len());
        let Some(quantity) = quantity(&rest) else { continue };
        if best.as_ref().is_none_or(|(length, ..)| wanted.len() > *length) {
            best = Some((wanted.len(), joint, quantity));
        }
    }
    best.map(|(_, joint, quantity)| (joint, quantity))
}

/// The only joint whose telling words are these, or contain them, or are contained in them.
fn alike(subject: &[String], joints: &[&str]) -> Option<usize> {
    let subject = telling(subject);
    if subject.is_empty() || subject.iter().all(|word| word.parse::<usize>().is_ok()) {
        return None;
    }
    let of_joint = |name: &&str| telling(&words(name).into_iter().map(|word| word.text).collect::<Vec<_>>());
    let joints: Vec<Vec<String>> = joints.iter().map(of_joint).collect();
    let within = |a: &[String], b: &[String]| !a.is_empty() && a.iter().all(|word| b.contains(word));
    let only = |fits: &dyn Fn(&[String]) -> bool| {
        let mut fitting = (0..joints.len()).filter(|&k| fits(&joints[k]));
        match (fitting.next(), fitting.next()) {
            (Some(one), None) => Some(one),
            _ => None,
        }
    };
    let joined = |words: &[String]| words.concat();
    only(&|joint| joint == subject)
        .or_else(|| only(&|joint| joined(joint) == joined(&subject)))
        .or_else(|| only(&|joint| within(joint, &subject)))
        .or_else(|| only(&|joint| within(&subject, joint)))
}

/// A column that has a number in the place of a joint's name.
#[derive(Debug, Clone)]
struct Numbered {
    field: usize,
    name: String,
    number: usize,
    quantity: Quantity,
    /// The name without the number.
    group: String,
}

impl Numbered {
    fn of(field: usize, name: &str) -> Option<Self> {
        let words = words(name);
        let quantity = quantity(&words)?;
        let number = index(&subject(&words, &quantity))?;
        let others = words.iter().filter(|word| word.text.parse::<usize>() != Ok(number));
        let group = others.map(|word| word.text.as_str()).collect::<Vec<_>>().join(" ");
        Some(Self { field, name: name.to_owned(), number, quantity, group })
    }
}

/// Numbers from 0 or 1, as many as there are joints: their order is taken for the joints'.
fn in_order(
    quantity: &str,
    columns: &[Numbered],
    (joints, actuated): (&[&str], &[usize]),
    guesses: &mut Guesses,
) {
    let mut sorted: Vec<&Numbered> = columns.iter().collect();
    sorted.sort_by_key(|column| column.number);
    let first = sorted[0].number;
    let complete = first <= 1 && sorted.iter().enumerate().all(|(k, column)| column.number == first + k);
    let all: Vec<usize> = (0..joints.len()).collect();
    let (order, whose) = if sorted.len() == joints.len() { (&all[..], "") } else { (actuated, " actuated") };
    let span = format!("`{}` to `{}`", sorted[0].name, sorted[sorted.len() - 1].name);
    if !complete || sorted.len() != order.len() {
        guesses.doubts.push(format!(
            "{span}: {} columns of {quantity} with numbers for {} joints; which joint is which, a mapping file must say",
            sorted.len(),
            joints.len()
        ));
        return;
    }
    for (column, &joint) in sorted.iter().zip(order) {
        guesses.found.push(of(column.field, joint, &column.quantity));
    }
    let names = list(order.iter().map(|&joint| joints[joint]), order.len());
    guesses
        .assumptions
        .push(format!("{span} are {quantity} of the{whose} joints in the order of the description: {names}"));
}

/// Two columns that seem to be one quantity of one joint: neither is taken.
fn drop_doubles(columns: &[(usize, &str)], joints: &[&str], guesses: &mut Guesses) {
    let name = |field: usize| columns.iter().find(|(other, _)| *other == field).map_or("", |(_, name)| *name);
    let mut by_meaning: BTreeMap<(usize, &'static str), Vec<usize>> = BTreeMap::new();
    for guess in &guesses.found {
        by_meaning.entry((guess.joint, guess.quantity)).or_default().push(guess.field);
    }
    for ((joint, quantity), fields) in by_meaning.iter().filter(|(_, fields)| fields.len() > 1) {
        let names = list(fields.iter().map(|&field| name(field)), 4);
        guesses.doubts.push(format!(
            "{names} all seem to be {quantity} of `{}`: a mapping file must say which of them is",
            joints[*joint]
        ));
    }
    guesses.found.retain(|guess| by_meaning[&(guess.joint, guess.quantity)].len() == 1);
}

#[cfg(test)]
mod tests {
    use super::*;

    const JOINTS: [&str; 4] = ["left_hip_pitch", "left_knee_pitch", "right_hip_pitch", "right_knee_pitch"];

    fn guessed(names: &[&str]) -> (Vec<String>, Guesses) {
        let columns: Vec<(usize, &str)> = names.iter().copied().enumerate().collect();
        let mut guesses = guess(&columns, &JOINTS, &[1, 3]);
        guesses.found.sort_by_key(|guess| guess.field);
        let found = guesses.found.iter().map(|g| format!("{} {}/{}", g.field, JOINTS[g.joint], g.quantity));
        (found.collect(), guesses)
    }

    #[test]
    fn names_as_they_are_and_nearly() {
        let (found, _) = guessed(&[
            "/joint_states/left_knee_pitch/position",
            "KneeR.tau",
            "l_hip_pos",
            "/joint_states/right_hip_pitch/velocity",
            "LeftKnee_torque",
            "elbow_pos",
        ]);
        assert_eq!(
            found,
            [
                "0 left_knee_pitch/position",
                "1 right_knee_pitch/effort",
                "2 left_hip_pitch/position",
                "3 right_hip_pitch/velocity",
                "4 left_knee_pitch/effort",
            ]
        );
    }

    #[test]
    fn numbers_are_the_order_of_the_joints_if_there_are_as_many() {
        let (found, guesses) =
            guessed(&["q_1", "q_2", "q_3", "q_4", "tau[0]", "tau[1]", "v_0", "qd_0", "qd_1", "qd_2"]);
        assert_eq!(found[..2], ["0 left_hip_pitch/position", "1 left_knee_pitch/position"]);
        assert_eq!(found[4..], ["4 left_knee_pitch/effort", "5 right_knee_pitch/effort"]);
        assert_eq!(guesses.assumptions.len(), 2);
        assert!(
            guesses.doubts[0].contains("`qd_0` to `qd_2`: 3 columns of velocity"),
            "{:?}",
            guesses.doubts
        );
    }

    #[test]
    fn two_columns_of_one_meaning_are_left_to_people() {
        let (found, guesses) = guessed(&["left_hip_pitch_pos", "arm/left_hip_pitch/position", "hip_pos"]);
        assert_eq!(found, [""; 0]);
        assert!(
            guesses.doubts[0].contains("all seem to be position of `left_hip_pitch`"),
            "{:?}",
            guesses.doubts
        );
    }
}
