//! Entries of a mapping file that stand for a column of every joint or foot.
use super::mapping::{ForceFrame, MappedColumn, Mapping};
use super::names::is_known_form;
use bipedc_effects::diagnostic::{Diagnostic, list, shorten};

/// What stands for the name of any joint or foot.
const PLACEHOLDERS: [&str; 2] = ["{joint}", "{foot}"];

/// A mapped column of any joint, `{joint}/position`, or of any foot, `{foot}/force/z`.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Our name, with a placeholder.
    pub name: String,
    /// The file's name with the same placeholder, factor and offset; without a name the same as ours.
    pub source: MappedColumn,
    /// Of a foot's force or torque.
    pub frame: Option<ForceFrame>,
}

impl Pattern {
    /// Whether a name is one.
    pub fn is_one(name: &str) -> bool {
        PLACEHOLDERS.iter().any(|placeholder| name.contains(placeholder))
    }

    /// What is wrong with it.
    pub fn refusal(&self) -> Option<Diagnostic> {
        let theirs = self.source.column.as_deref().unwrap_or(&self.name);
        let once = |text: &str, placeholder: &str| text.matches(placeholder).count() == 1;
        let good =
            PLACEHOLDERS.iter().any(|p| self.name.starts_with(p) && once(&self.name, p) && once(theirs, p));
        let count = |text: &str| text.matches('{').count();
        (!good || count(&self.name) != 1 || count(theirs) != 1).then(|| {
            let what = format!("`{}` = `{}` is no pattern", shorten(&self.name), shorten(theirs));
            Diagnostic::error(what).help(
                "both names have one {joint} or one {foot}: \"{joint}/position\" = \"/joint_states/{joint}/position\"",
            )
        })
    }

    /// Joints or feet whose column is among these: name and column.
    fn matches<'n>(&self, names: &[&'n str]) -> Vec<(&'n str, &'n str)> {
        let theirs = self.source.column.as_deref().unwrap_or(&self.name);
        let parts = PLACEHOLDERS.iter().find_map(|placeholder| theirs.split_once(placeholder));
        let Some((before, after)) = parts else { return Vec::new() };
        let middle = |name: &'n str| {
            let owner = name.strip_prefix(before)?.strip_suffix(after).filter(|owner| !owner.is_empty())?;
            Some((owner, name))
        };
        names.iter().filter_map(|name| middle(name)).collect()
    }

    fn ours(&self, owner: &str) -> String {
        PLACEHOLDERS.iter().fold(self.name.clone(), |name, placeholder| name.replace(placeholder, owner))
    }
}

impl Mapping {
    /// The same with every pattern as the columns of this file that it stands for. What has a line of its own keeps it.
    ///
    /// # Errors
    /// Patterns that no column has.
    pub fn of_columns(&self, names: &[&str]) -> Result<Mapping, Vec<Diagnostic>> {
        let mut whole = Mapping { patterns: Vec::new(), ..self.clone() };
        let mut errors = Vec::new();
        for pattern in self.patterns.iter().filter(|pattern| pattern.frame.is_none()) {
            let found = pattern.matches(names);
            if found.is_empty() {
                errors.push(self.without_match(pattern, names));
            }
            for (owner, column) in found {
                let source = MappedColumn { column: Some(column.to_owned()), ..pattern.source.clone() };
                whole.columns.entry(pattern.ours(owner)).or_insert(source);
            }
        }
        whole.forget_ignored();
        whole.read_as_motors(names);
        let known: Vec<&str> = names.iter().copied().filter(|name| is_known_form(name)).collect();
        let ours: Vec<String> = whole.columns.keys().cloned().collect();
        for pattern in &self.patterns {
            let Some(frame) = pattern.frame else { continue };
            let axis = format!("{}/z", pattern.name);
            let of_foot = Pattern { name: axis, source: pattern.source.clone(), frame: None };
            let all: Vec<&str> = known.iter().copied().chain(ours.iter().map(String::as_str)).collect();
            let feet = of_foot.matches(&all);
            if feet.is_empty() {
                errors.push(self.without_match(&of_foot, names));
            }
            for (foot, _) in feet {
                whole.frames.entry(pattern.ours(foot)).or_insert(frame);
            }
        }
        if errors.is_empty() { Ok(whole) } else { Err(errors) }
    }

    /// What is not to be seen is not read either, under whatever name it stands in the file.
    fn forget_ignored(&mut self) {
        let Self { columns, ignored, .. } = self;
        let sources: Vec<String> = columns
            .iter()
            .filter(|(name, _)| ignored.contains(*name))
            .filter_map(|(_, source)| source.column.clone())
            .collect();
        columns.retain(|name, _| !ignored.contains(name));
        // A motor's angle may still be that of its joint.
        let used = |name: &String| columns.values().any(|source| source.column.as_ref() == Some(name));
        ignored.extend(sources.into_iter().filter(|name| !used(name)).collect::<Vec<_>>());
    }

    /// In logs over time, positions of joints whose encoder is the motor's become the motor's, of its shaft.
    fn read_as_motors(&mut self, names: &[&str]) {
        let motor_encoders = std::mem::take(&mut self.motor_encoders);
        let Self { columns, ignored, .. } = self;
        let is_log = names.contains(&"time") || columns.contains_key("time");
        for (joint, turns) in motor_encoders.iter().filter(|_| is_log) {
            let [ours, motors] = ["position", "motor_position"].map(|what| format!("{joint}/{what}"));
            let stands = names.contains(&motors.as_str()) && !ignored.contains(&motors);
            if stands || columns.contains_key(&motors) || ignored.contains(&ours) {
                continue;
            }
            let own =
                || MappedColumn { column: Some(ours.clone()), factor: 1.0, offset: 0.0, position: (0, 0) };
            let logged = columns.remove(&ours).or_else(|| names.contains(&ours.as_str()).then(own));
            if let Some(logged) = logged {
                let column = logged.column.clone().or_else(|| Some(ours.clone()));
                let (factor, offset) = (turns * logged.factor, turns * logged.offset);
                columns.insert(motors, MappedColumn { column, factor, offset, ..logged });
            }
        }
    }

    fn without_match(&self, pattern: &Pattern, names: &[&str]) -> Diagnostic {
        let theirs = pattern.source.column.as_deref().unwrap_or(&pattern.name);
        let error = Diagnostic::error(format!("the log has no column like `{}`", shorten(theirs)))
            .help(format!("columns of the log: {}", list(names.iter().copied(), 12)));
        match &self.file {
            Some(file) => error.in_file(file).at(pattern.source.position.0, pattern.source.position.1),
            None => error,
        }
    }
}
