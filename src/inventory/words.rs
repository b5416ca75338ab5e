//! What a column's name says in other people's ways of writing it: words, a quantity, a unit, a number.
use std::f64::consts::PI;

/// A word of a name, in small letters, and the part of the path that it stands in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Word {
    pub text: String,
    pub segment: usize,
}

/// What a name says beside the joint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Quantity {
    /// One of [`bipedc_analysis::log::names::JOINT_QUANTITIES`].
    pub name: &'static str,
    /// SI unit of ours per unit of the file.
    pub scale: f64,
    /// The file's unit, where the name says one.
    pub unit: Option<&'static str>,
    /// Words that say all this.
    used: Vec<usize>,
}

/// Words that name a quantity of a joint.
const QUANTITIES: [(&str, &[&str]); 5] = [
    ("position", &["position", "positions", "pos", "angle", "angles", "theta", "q"]),
    ("velocity", &["velocity", "velocities", "vel", "speed", "qd", "dq", "qdot", "omega"]),
    ("acceleration", &["acceleration", "accelerations", "acc", "accel", "qdd", "ddq", "qddot"]),
    ("effort", &["effort", "efforts", "torque", "torques", "tau", "trq"]),
    ("motor_current", &["current", "currents", "curr"]),
];
/// Words for what was asked for and not measured.
const ASKED_FOR: [&str; 12] = [
    "ref",
    "reference",
    "des",
    "desired",
    "cmd",
    "command",
    "commanded",
    "target",
    "setpoint",
    "goal",
    "d",
    "demand",
];
/// Words for what is no measurement of a quantity but something made of it.
const DERIVED: [&str; 8] = ["error", "err", "limit", "max", "min", "var", "covariance", "integral"];
/// Units that names state, what they are in SI, and the quantities that may have them.
const UNITS: [(&str, f64, &[&str]); 11] = [
    ("deg", PI / 180.0, &["position", "velocity", "acceleration"]),
    ("degree", PI / 180.0, &["position", "velocity", "acceleration"]),
    ("degrees", PI / 180.0, &["position", "velocity", "acceleration"]),
    ("rpm", PI / 30.0, &["velocity"]),
    ("rev", 2.0 * PI, &["position", "velocity"]),
    ("mnm", 1e-3, &["effort"]),
    ("ma", 1e-3, &["motor_current"]),
    ("mrad", 1e-3, &["position", "velocity", "acceleration"]),
    ("rad", 1.0, &["position", "velocity", "acceleration"]),
    ("nm", 1.0, &["effort"]),
    ("a", 1.0, &["motor_current"]),
];
/// Words that tell no joint from another.
const FILLERS: [&str; 27] = [
    "joint", "joints", "motor", "motors", "axis", "j", "dof", "state", "states", "actuator", "robot",
    "measured", "meas", "msr", "actual", "act", "current", "data", "value", "values", "feedback", "fb",
    "sensor", "link", "s", "n", "m",
];

/// The words of a name: parts of its path, split at `_`, capitals and digits.
pub(super) fn words(name: &str) -> Vec<Word> {
    let mut words = Vec::new();
    for (segment, part) in name.split(is_separator).enumerate() {
        let letters: Vec<char> = part.chars().collect();
        let mut word = String::new();
        for (k, &letter) in letters.iter().enumerate() {
            let starts = k > 0 && begins_word(letters[k - 1], letter, letters.get(k + 1).copied());
            if (starts || !letter.is_alphanumeric()) && !word.is_empty() {
                words.push(Word { text: std::mem::take(&mut word), segment });
            }
            if letter.is_alphanumeric() {
                word.extend(letter.to_lowercase());
            }
        }
        if !word.is_empty() {
            words.push(Word { text: word, segment });
        }
    }
    words
}

/// What parts of a path stand between.
fn is_separator(letter: char) -> bool {
    matches!(letter, '/' | '.' | ':' | '[' | ']' | '(' | ')' | ' ' | '|')
}

/// `kneeL`, `LKnee`, `q0`, `2nd`.
fn begins_word(before: char, letter: char, after: Option<char>) -> bool {
    let capital = letter.is_uppercase()
        && (before.is_lowercase() || before.is_uppercase() && after.is_some_and(char::is_lowercase));
    capital || before.is_numeric() != letter.is_numeric()
}

/// The quantity that these words name, the last of them counting most; none where they name none, or one that no log has.
pub(super) fn quantity(words: &[Word]) -> Option<Quantity> {
    let text = |k: usize| words[k].text.as_str();
    let is = |k: usize, list: &[&str]| list.contains(&text(k));
    if (0..words.len()).any(|k| is(k, &DERIVED)) {
        return None;
    }
    let named = |k: &usize| QUANTITIES.iter().any(|(_, list)| is(*k, list));
    let at = (0..words.len()).rev().find(named)?;
    let (mut name, _) = *QUANTITIES.iter().find(|(_, list)| is(at, list))?;
    let mut used = vec![at];
    let dot = |k: &usize| (name, text(*k)) == ("position", "dot") || (name, text(*k)) == ("position", "ddot");
    if let Some(k) = (0..words.len()).find(dot) {
        name = if text(k) == "dot" { "velocity" } else { "acceleration" };
        used.push(k);
    }
    if at > 0 && text(at - 1) == "motor" && matches!(name, "position" | "motor_current") {
        name = if name == "position" { "motor_position" } else { name };
        used.push(at - 1);
    }
    let asked: Vec<usize> = (0..words.len()).filter(|&k| k != at && is(k, &ASKED_FOR)).collect();
    if !asked.is_empty() {
        name = (name == "position").then_some("reference")?;
        used.extend(asked);
    }
    let (scale, unit) = unit(words, at, name, &mut used);
    Some(Quantity { name, scale, unit, used })
}

/// A unit behind the quantity.
fn unit(words: &[Word], at: usize, name: &str, used: &mut Vec<usize>) -> (f64, Option<&'static str>) {
    let measure = match name {
        "reference" | "motor_position" => "position",
        other => other,
    };
    for k in at + 1..words.len() {
        // `mA` and `mNm` look like two words.
        let two = words.get(k + 1).map(|next| format!("{}{}", words[k].text, next.text));
        let is = |text: &str| {
            UNITS
                .iter()
                .find(|(unit, _, of)| *unit == text && of.contains(&measure))
                .map(|found| (text.len(), found))
        };
        let found = two.as_deref().and_then(is).or_else(|| is(&words[k].text));
        if let Some((length, (unit, scale, _))) = found {
            used.extend(if length > words[k].text.len() { k..k + 2 } else { k..k + 1 });
            // `rad/s`, `deg_s2`: what follows belongs to the unit.
            used.extend((k + 1..words.len()).filter(|&j| matches!(words[j].text.as_str(), "s" | "2")));
            return (*scale, Some(unit));
        }
    }
    (1.0, None)
}

/// Words that say which joint: those of the path's part with the quantity, else those of the part before it.
pub(super) fn subject(words: &[Word], quantity: &Quantity) -> Vec<String> {
    let free = |k: &usize| !quantity.used.contains(k);
    let of = |segments: &dyn Fn(usize) -> bool| -> Vec<String> {
        let chosen = (0..words.len()).filter(free).filter(|&k| segments(words[k].segment));
        chosen.map(|k| words[k].text.clone()).collect()
    };
    let own = words[quantity.used[0]].segment;
    let here = of(&|segment| segment >= own);
    if here.is_empty() {
        let before = words.iter().map(|word| word.segment).filter(|segment| *segment < own).max();
        return before.map(|before| of(&|segment| segment == before)).unwrap_or_default();
    }
    here
}

/// The number in a subject that says nothing else.
pub(super) fn index(subject: &[String]) -> Option<usize> {
    let numbers: Vec<usize> = subject.iter().filter_map(|word| word.parse().ok()).collect();
    let others = subject.iter().filter(|word| word.parse::<usize>().is_err());
    match numbers.as_slice() {
        [number] if others.clone().all(|word| FILLERS.contains(&word.as_str())) => Some(*number),
        _ => None,
    }
}

/// Words that tell a joint from others, left and right written out, sorted.
pub(super) fn telling(words: &[String]) -> Vec<String> {
    let written_out = |word: &String| match word.as_str() {
        "l" => "left".to_owned(),
        "r" => "right".to_owned(),
        other => other.to_owned(),
    };
    let mut kept: Vec<String> =
        words.iter().filter(|word| !FILLERS.contains(&word.as_str())).map(written_out).collect();
    kept.sort();
    kept
}

/// Whether a name is that of a clock.
pub(super) fn is_clock(name: &str) -> bool {
    let words = words(name);
    let is = |word: &Word| matches!(word.text.as_str(), "time" | "timestamp" | "stamp" | "timestamps");
    let is_t = |word: &Word| matches!(word.text.as_str(), "t" | "secs" | "seconds" | "nsecs");
    let is_unit = |word: &Word| matches!(word.text.as_str(), "s" | "ms" | "us" | "ns" | "sec");
    words.iter().any(is) || words.first().is_some_and(is_t) && words[1..].iter().all(is_unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str) -> Option<(&'static str, f64, String)> {
        let words = words(name);
        let quantity = quantity(&words)?;
        Some((quantity.name, quantity.scale, subject(&words, &quantity).join(" ")))
    }

    #[test]
    fn common_ways_of_writing() {
        for (name, quantity, subject) in [
            ("/joint_states/left_knee/position", "position", "left knee"),
            ("/joint_states/position[3]", "position", "3"),
            ("robot.velocity.2", "velocity", "2"),
            ("q_0", "position", "0"),
            ("joint1_pos", "position", "joint 1"),
            ("tau_3", "effort", "3"),
            ("KneeL.tau", "effort", "knee l"),
            ("qd[4]", "velocity", "4"),
            ("q_dot_4", "velocity", "4"),
            ("motor_current[2]", "motor_current", "2"),
            ("left_knee_motor_position", "motor_position", "left knee"),
            ("q_des_1", "reference", "1"),
        ] {
            let found = read(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((found.0, found.1, found.2.as_str()), (quantity, 1.0, subject), "{name}");
        }
        for name in ["tau_des_3", "position_error_2", "battery", "/imu/orientation/w"] {
            assert_eq!(read(name), None, "{name}");
        }
    }

    #[test]
    fn units_in_names() {
        assert_eq!(read("left_knee.pos [deg]").unwrap(), ("position", PI / 180.0, "left knee".to_owned()));
        assert_eq!(read("speed_3_rpm").unwrap(), ("velocity", PI / 30.0, "3".to_owned()));
        assert_eq!(read("left_knee_vel_rad/s").unwrap(), ("velocity", 1.0, "left knee".to_owned()));
        assert_eq!(read("current_2_mA").unwrap().1, 1e-3);
    }

    #[test]
    fn numbers_and_clocks() {
        let index_of = |text: &str| index(&text.split(' ').map(str::to_owned).collect::<Vec<_>>());
        assert_eq!(
            [index_of("joint 1"), index_of("3"), index_of("knee 1"), index_of("1 2")],
            [Some(1), Some(3), None, None]
        );
        for name in ["__time", "timestamp", "t", "t_ms", "time [s]", "/joint_states/header/stamp"] {
            assert!(is_clock(name), "{name}");
        }
        assert!(!is_clock("left_knee/position") && !is_clock("torque"));
    }
}
