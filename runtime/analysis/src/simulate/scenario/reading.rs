//! The text of a scenario, numbers and lists in it, and what was found wrong.
use super::file::Number;
use crate::simulate::Plant;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, line_and_column};
use bipedc_effects::magnitude;
use bipedc_effects::spelling::suggest;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text, and what was found wrong in it.
pub(super) struct Reading<'a> {
    file: &'a Path,
    text: &'a str,
    errors: Vec<Diagnostic>,
}

pub(super) const POSITIVE: (f64, f64) = (f64::MIN_POSITIVE, f64::MAX);
pub(super) const NOT_NEGATIVE: (f64, f64) = (0.0, f64::MAX);
pub(super) const ANY: (f64, f64) = (f64::MIN, f64::MAX);

impl<'a> Reading<'a> {
    /// Refuses numbers of impossible size before anything is read.
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        let mut reading = Self { file, text, errors: Vec::new() };
        reading.sizes();
        reading
    }

    /// What was read, if nothing was wrong.
    pub fn finish<T>(self, found: T) -> Result<T, Diagnostics> {
        if self.errors.is_empty() { Ok(found) } else { Err(self.failed()) }
    }

    /// What was found wrong, in the order of the file.
    pub fn failed(mut self) -> Diagnostics {
        self.errors.sort_by_key(|error| error.position);
        Diagnostics(self.errors)
    }

    /// Notes that a key of the whole file is missing, unless it is there and was left out for another reason.
    pub fn missing(&mut self, key: &str, help: &str) {
        let table = DeTable::parse(self.text);
        if !table.is_ok_and(|table| table.get_ref().contains_key(key)) {
            self.wrong::<()>(0, format!("`{key}` is missing"), help);
        }
    }

    /// Line and column of a byte offset.
    pub fn place(&self, at: usize) -> (usize, usize) {
        line_and_column(self.text, at)
    }

    /// Notes an error; always `None`.
    pub fn wrong<T>(&mut self, at: usize, message: impl Into<String>, help: impl Into<String>) -> Option<T> {
        let (line, column) = self.place(at);
        self.errors.push(Diagnostic::error(message).in_file(self.file).at(line, column).help(help));
        None
    }

    /// Notes that the robot has no such joint.
    pub fn no_joint(&mut self, at: usize, name: &str, plant: &Plant) {
        let otherwise = || format!("joints: {}", plant.joint_names().collect::<Vec<_>>().join(", "));
        let help = suggest(name, plant.joint_names(), otherwise);
        self.wrong::<()>(at, format!("the robot has no joint `{name}`"), help);
    }

    /// A number within bounds, or its default.
    pub fn number(
        &mut self,
        name: &str,
        found: Option<&Number>,
        default: f64,
        range: (f64, f64),
        unit: &str,
    ) -> f64 {
        let Some(found) = found else { return default };
        let value = *found.get_ref();
        if value.is_finite() && value >= range.0 && value <= range.1 {
            return value;
        }
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        let range = wanted(range, &unit);
        self.wrong::<()>(
            found.span().start,
            format!("`{name}` = {value}{unit} is not possible"),
            format!("it must be {range}"),
        );
        default
    }

    /// Counts of an encoder in a turn; 0, the default, for an exact one.
    pub fn counts(&mut self, name: &str, found: Option<&Number>) -> f64 {
        let exact = found.is_some_and(|found| *found.get_ref() == 0.0);
        self.number(name, found, 0.0, if exact { NOT_NEGATIVE } else { (1.0, f64::MAX) }, "1")
    }

    /// So many numbers, or as many zeros.
    pub fn vector(
        &mut self,
        name: &str,
        found: Option<&Spanned<Vec<f64>>>,
        size: usize,
        words: &str,
    ) -> Vec<f64> {
        let Some(found) = found else { return vec![0.0; size] };
        let values = found.get_ref();
        if values.len() == size && size > 0 && values.iter().all(|x| x.is_finite()) {
            return values.clone();
        }
        let message = if size == 0 {
            format!("`{name}` has no meaning on this base")
        } else {
            format!("`{name}` = {values:?} is not possible")
        };
        let help = if size == 0 { "leave it out".to_owned() } else { format!("write {words}") };
        self.wrong::<()>(found.span().start, message, help);
        vec![0.0; size]
    }

    /// A file beside the scenario.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.file.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Refuses numbers of impossible size wherever they stand.
    fn sizes(&mut self) {
        let Ok(table) = DeTable::parse(self.text) else { return };
        let mut values: Vec<&Spanned<DeValue<'_>>> = table.get_ref().values().collect();
        let mut wrong = Vec::new();
        while let Some(value) = values.pop() {
            let text = match value.get_ref() {
                DeValue::Float(x) => x.as_str(),
                DeValue::Integer(x) => x.as_str(),
                DeValue::Array(list) => {
                    values.extend(list.iter());
                    continue;
                }
                DeValue::Table(table) => {
                    values.extend(table.values());
                    continue;
                }
                _ => continue,
            };
            // Infinities and NaN are told with what is expected there.
            let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
            if let Some((problem, help)) = number.and_then(magnitude::refusal) {
                wrong.push((value.span().start, format!("the number {text} {problem}"), help));
            }
        }
        wrong.sort_by_key(|(at, ..)| *at);
        for (at, message, help) in wrong {
            self.wrong::<()>(at, message, help);
        }
    }
}

/// Which numbers lie within bounds, in words; `unit` begins with a space, or is empty.
fn wanted(range: (f64, f64), unit: &str) -> String {
    match range {
        (f64::MIN, f64::MAX) => format!("a finite number{unit}"),
        (low, f64::MAX) if low == f64::MIN_POSITIVE => format!("a number above 0{unit}"),
        (low, f64::MAX) => format!("at least {low}{unit}"),
        (low, high) => format!("from {low} to {high}{unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_that_are_none_are_not_told_as_numbers() {
        assert_eq!(wanted((f64::MIN, f64::MAX), " m/s"), "a finite number m/s");
        assert_eq!(wanted((0.0, f64::MAX), " s"), "at least 0 s");
        assert_eq!(wanted((f64::MIN_POSITIVE, f64::MAX), ""), "a number above 0");
        assert_eq!(wanted((0.0, 1.0), ""), "from 0 to 1");
    }
}
