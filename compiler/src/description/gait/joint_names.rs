//! What formulas of a gait call the joints of a robot, whose names in the URDF may hold anything.
use super::{PHASE, PHASE_END, PHASE_START};
use crate::description::model::RobotDescription;
use std::collections::{BTreeMap, BTreeSet};

/// Words that mean something else in formulas.
const TAKEN: [&str; 19] = [
    PHASE,
    PHASE_START,
    PHASE_END,
    "base_x",
    "base_z",
    "base_pitch",
    "pi",
    "sin",
    "cos",
    "tan",
    "tanh",
    "exp",
    "sqrt",
    "abs",
    "sign",
    "min",
    "max",
    "clip",
    "smoothing",
];

/// Whether formulas mean something else by a word, whatever the robot.
pub(super) fn means_something_else(word: &str) -> bool {
    TAKEN.contains(&word)
}

/// The names of a robot's joints in formulas, no two alike.
#[derive(Debug, Clone, Default)]
pub struct JointNames {
    /// By joint.
    names: BTreeMap<String, String>,
}

impl JointNames {
    /// Of the joints that move.
    pub fn of_robot(description: &RobotDescription) -> Self {
        let joints = description.joints.iter().filter(|joint| joint.kind.moves());
        let points = description
            .feet
            .iter()
            .flat_map(|foot| foot.points.iter().map(move |point| format!("{}_{}", foot.name, point.name)));
        Self::new(joints.map(|joint| joint.name.as_str()), points)
    }

    /// Of joints and contact points, these as `FOOT_POINT`. In whatever order joints come: names that are words as they are stay, of others that become the same word all but the first by the alphabet are numbered.
    pub fn new<'a>(joints: impl Iterator<Item = &'a str>, points: impl Iterator<Item = String>) -> Self {
        let mut used: BTreeSet<String> = TAKEN.iter().map(|&word| word.to_owned()).collect();
        used.extend(points.flat_map(|point| ["x", "z"].map(|axis| format!("{point}_{axis}"))));
        let joints: BTreeSet<&str> = joints.collect();
        let (kept, others): (Vec<&str>, Vec<&str>) =
            joints.into_iter().partition(|joint| word(joint) == **joint && !used.contains(*joint));
        let mut names: BTreeMap<String, String> =
            kept.into_iter().map(|joint| (joint.to_owned(), joint.to_owned())).collect();
        used.extend(names.keys().cloned());
        for joint in others {
            let plain = word(joint);
            let reserved = word(joint) == joint || means_something_else(&plain);
            let first = if reserved { format!("joint_{plain}") } else { plain };
            let numbered = (2..).map(|count| format!("{first}_{count}"));
            let free = std::iter::once(first.clone()).chain(numbered).find(|name| !used.contains(name));
            let name = free.unwrap_or(first);
            used.insert(name.clone());
            names.insert(joint.to_owned(), name);
        }
        Self { names }
    }

    /// Whether formulas could have a name as it is.
    pub(super) fn is_word(joint: &str) -> bool {
        word(joint) == joint
    }

    /// What formulas call a joint; its own name where it is none of the robot's.
    pub fn of<'a>(&'a self, joint: &'a str) -> &'a str {
        self.names.get(joint).map_or(joint, String::as_str)
    }

    /// Joint by joint: its own name, and the word by which formulas call it.
    pub fn each(&self) -> impl Iterator<Item = (&str, &str)> {
        self.names.iter().map(|(joint, name)| (joint.as_str(), name.as_str()))
    }

    /// Further words for joints, each for one joint alone: letters of other alphabets as `_`, as formulas once had to be written.
    pub fn plainer(&self) -> impl Iterator<Item = (&str, String)> {
        let plain = |name: &str| -> String {
            name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
        };
        let alone = move |(joint, name): &(&str, &str)| {
            let own = plain(name);
            let others = self.each().filter(|(other, _)| other != joint);
            own != *name && others.map(|(_, name)| plain(name)).all(|other| other != own)
        };
        self.each().filter(alone).map(move |(joint, name)| (joint, plain(name)))
    }
}

/// A name as a word: characters that are neither letters nor digits become `_`, and `joint_` stands before what begins with a digit.
fn word(joint: &str) -> String {
    let word: String = joint.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    match word.starts_with(|c: char| !c.is_alphabetic() && c != '_') {
        true => format!("joint_{word}"),
        false => word,
    }
}

#[cfg(test)]
mod tests {
    use super::JointNames;

    fn named(joints: &[&str]) -> Vec<String> {
        let names = JointNames::new(joints.iter().copied(), std::iter::once("foot_heel".to_owned()));
        joints.iter().map(|joint| names.of(joint).to_owned()).collect()
    }

    #[test]
    fn no_two_joints_have_one_name() {
        assert_eq!(named(&["left-hip", "left_hip", "left hip"]), ["left_hip_3", "left_hip", "left_hip_2"]);
        assert_eq!(named(&["左膝", "右膝", "Hüfte"]), ["左膝", "右膝", "Hüfte"]);
        assert_eq!(named(&["+", "-"]), ["_", "__2"]);
        // In whatever order they come.
        assert_eq!(named(&["left hip", "left-hip"]), ["left_hip", "left_hip_2"]);
        assert_eq!(named(&["left-hip", "left hip"]), ["left_hip_2", "left_hip"]);
    }

    #[test]
    fn no_joint_is_called_as_something_else() {
        assert_eq!(named(&["pi", "base_x", "2nd"]), ["joint_pi", "joint_base_x", "joint_2nd"]);
        assert_eq!(named(&["foot_heel_x", "foot_heel_y"]), ["joint_foot_heel_x", "foot_heel_y"]);
        assert_eq!(named(&["joint_pi", "pi"]), ["joint_pi", "joint_pi_2"]);
        assert_eq!(named(&["foot-heel-x"]), ["foot_heel_x_2"]);
    }

    #[test]
    fn words_of_one_alphabet_go_on_to_be_known() {
        let names = JointNames::new(["Hüfte", "Knie", "左膝", "右膝"].into_iter(), std::iter::empty());
        let plainer: Vec<(&str, String)> = names.plainer().collect();
        assert_eq!(plainer, [("Hüfte", "H_fte".to_owned())]);
    }
}
