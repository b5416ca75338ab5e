//! A mapping file for a log with other names.
use super::matching::{Guesses, guess};
use super::plan::{Plan, Taken};
use super::words::is_clock;
use bipedc_analysis::log::names::joint_of;
use serde::Serialize;

/// What a mapping file for the log would say.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Proposal {
    /// One per column that is to have another name.
    pub entries: Vec<Entry>,
    /// What was taken for granted and is to be checked.
    pub assumptions: Vec<String>,
    /// Columns that look like something and were left out, and why.
    pub doubts: Vec<String>,
}

/// A column of ours and where it comes from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Our name.
    pub name: String,
    /// The file's name.
    pub column: String,
    /// SI unit of ours per unit of the file; 1 unless the file's name or its time stamps say another unit.
    pub scale: f64,
    /// The file's unit where it is another.
    pub unit: Option<String>,
    #[serde(skip)]
    pub(super) field: usize,
}

impl Proposal {
    /// The mapping file as text; `about` is what it is for, such as `log.csv of tulip`.
    pub fn toml(&self, about: &str) -> String {
        // A comment has no control characters.
        let plain = |text: &str| text.replace(char::is_control, " ");
        let about = plain(about);
        let mut text = format!(
            "# Columns of {about}. Value = scale · logged; in a wrong direction: {{ column = …, sign = -1 }}.\n"
        );
        for assumption in &self.assumptions {
            text += &format!("# To be checked: {}.\n", plain(assumption));
        }
        for entry in &self.entries {
            let quoted = |text: &str| toml_edit::Value::from(text).to_string();
            let name = if entry.name.contains('/') { quoted(&entry.name) } else { entry.name.clone() };
            let column = quoted(&entry.column);
            text += &match &entry.unit {
                None => format!("{name} = {column}\n"),
                Some(unit) => {
                    format!("{name} = {{ column = {column}, scale = {} }} # {unit}\n", entry.scale)
                }
            };
        }
        text
    }
}

/// The column with the time stamps, if none has our name: the first that is named like a clock.
pub(super) fn clock(columns: &[Plan]) -> Option<usize> {
    columns.iter().find(|column| column.taken.is_none() && is_clock(&column.name)).map(|column| column.field)
}

/// What columns that have no meaning yet could be of a robot's joints.
pub(super) fn joints(columns: &[Plan], robot: &[&str], actuated: &[usize]) -> Guesses {
    let has = |name: &str| columns.iter().any(|c| c.taken.as_ref().is_some_and(|taken| taken.name == name));
    let foreign = |taken: &Taken| joint_of(&taken.name).is_some_and(|joint| !robot.contains(&joint));
    let open = |column: &&Plan| column.taken.as_ref().is_none_or(foreign);
    let open: Vec<(usize, &str)> =
        columns.iter().filter(open).map(|column| (column.field, column.name.as_str())).collect();
    let mut guesses = guess(&open, robot, actuated);
    // What stands in the file under our name is not looked for elsewhere.
    guesses.found.retain(|guess| !has(&format!("{}/{}", robot[guess.joint], guess.quantity)));
    guesses.found.sort_by_key(|guess| guess.field);
    guesses
}
