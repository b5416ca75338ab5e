//! The mapping file: other column names, factors, signs and force frames.
//!
//! TOML, one entry per column of ours:
//!
//! ```toml
//! time = "header/stamp"
//! "left_knee/position" = { column = "joint_states/KneeL/pos", scale = 0.0174533, offset = 0.02, sign = -1 }
//! "left_foot/force" = { frame = "sole" }   # default: "world"
//! "{joint}/velocity" = "joint_states/{joint}/velocity"   # of every joint that the file has so
//! ```
//!
//! value = sign · scale · logged + offset; scale 1, sign 1 and offset 0 (in the SI unit of the result) by default.
use super::names::is_known_form;
use super::pattern::Pattern;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, line_and_column};
use bipedc_effects::spelling::{did_you_mean, suggest};
use bipedc_effects::{input, magnitude};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Where a column of ours comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedColumn {
    /// Name in the file's header; `None`: the same as ours.
    pub column: Option<String>,
    /// sign · scale
    pub factor: f64,
    /// Added after the factor, in the unit of the result.
    pub offset: f64,
    /// Line and column in the mapping file, from 1.
    pub position: (usize, usize),
}

/// The axes in which a foot's force and torque are logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ForceFrame {
    /// World axes.
    #[default]
    World,
    /// Axes of the foot, at the sole frame.
    Sole,
}

/// What a mapping file says; the default one changes nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mapping {
    /// The file, if it came from one.
    pub file: Option<PathBuf>,
    /// Our column name to its source.
    pub columns: BTreeMap<String, MappedColumn>,
    /// `<foot>/force` or `<foot>/torque` to its frame, where it is not the world.
    pub frames: BTreeMap<String, ForceFrame>,
    /// What stands for a column of every joint or foot; [`Mapping::of_columns`] finds them.
    pub patterns: Vec<Pattern>,
    /// Columns that are not to be seen: under their own names, or under ours.
    pub ignored: BTreeSet<String>,
    /// Joints whose position is measured at the motor, with the motor's turns per turn of the joint: a log's `<joint>/position` is
    /// `<joint>/motor_position` then, unless it has that too.
    pub motor_encoders: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a column name or { column, scale, offset, sign, frame }")]
enum Entry {
    Name(String),
    Full(Full),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Full {
    column: Option<String>,
    scale: Option<f64>,
    offset: Option<f64>,
    sign: Option<f64>,
    frame: Option<ForceFrame>,
}

impl Mapping {
    /// Whether a column of the file is not to be seen under its own name: that is another's, or it is told to be the angle of
    /// a motor and no joint's position.
    pub fn hides(&self, name: &str) -> bool {
        let is_motors = |joint: &str| {
            let mapped = self.columns.get(&format!("{joint}/motor_position"));
            mapped.is_some_and(|source| source.column.as_deref() == Some(name))
        };
        self.columns.contains_key(name)
            || self.ignored.contains(name)
            || name.strip_suffix("/position").is_some_and(is_motors)
    }

    /// Reads a mapping file.
    ///
    /// # Errors
    /// Not readable, not TOML, unknown keys or names, numbers without meaning; all of them at once.
    pub fn open(path: &Path) -> Result<Self, Diagnostics> {
        let text = input::read_to_string(path).map_err(|e| {
            Diagnostics(vec![Diagnostic::error(format!("cannot read the mapping file: {e}")).in_file(path)])
        })?;
        Self::parse(path, &text)
    }

    /// The same from a text; `path` is for messages.
    ///
    /// # Errors
    /// As [`Mapping::open`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, Diagnostics> {
        let entries: BTreeMap<String, Spanned<toml::Value>> = toml::from_str(text).map_err(|e| {
            let (line, column) = line_and_column(text, e.span().map_or(0, |s| s.start));
            Diagnostics(vec![Diagnostic::error(e.message().to_owned()).in_file(path).at(line, column)])
        })?;
        let mut mapping = Self { file: Some(path.to_path_buf()), ..Self::default() };
        let mut errors = Vec::new();
        for (name, value) in entries {
            let position = line_and_column(text, value.span().start);
            if let Err(error) = mapping.add(&name, value.into_inner(), position) {
                errors.push(error.in_file(path).at(position.0, position.1));
            }
        }
        if errors.is_empty() { Ok(mapping) } else { Err(Diagnostics(errors)) }
    }

    fn add(&mut self, name: &str, value: toml::Value, position: (usize, usize)) -> Result<(), Diagnostic> {
        let entry: Entry = value.clone().try_into().map_err(|_| bad_entry(name, value))?;
        let full = match entry {
            Entry::Name(column) => {
                Full { column: Some(column), scale: None, offset: None, sign: None, frame: None }
            }
            Entry::Full(full) => full,
        };
        let scale = full.scale.unwrap_or(1.0);
        let sign = full.sign.unwrap_or(1.0);
        let offset = full.offset.unwrap_or(0.0);
        if sign.abs() != 1.0 {
            return Err(Diagnostic::error(format!("`{name}`: sign is {sign}, expected 1 or -1"))
                .help("use `scale` for a factor"));
        }
        let possible = |x: f64| x.is_finite() && magnitude::refusal(x).is_none();
        if !possible(scale) || scale == 0.0 || !possible(offset) {
            return Err(Diagnostic::error(format!(
                "`{name}`: scale {scale} and offset {offset} have no meaning"
            ))
            .help("scale must not be zero; both are finite and at most 1e12 in size"));
        }
        let is_vector = is_known_form(&format!("{name}/z")) && !is_known_form(name);
        if let Some(frame) = full.frame {
            if !is_vector {
                return Err(Diagnostic::error(format!(
                    "`{name}`: only the force or torque of a foot has a frame"
                ))
                .help("write it as \"left_foot/force\" = { frame = \"sole\" }"));
            }
            if !Pattern::is_one(name) {
                self.frames.insert(name.to_owned(), frame);
            }
        } else if !is_known_form(name) {
            return Err(unknown_name(name));
        }
        let source = MappedColumn { column: full.column, factor: sign * scale, offset, position };
        if Pattern::is_one(name) || source.column.as_deref().is_some_and(Pattern::is_one) {
            let pattern = Pattern { name: name.to_owned(), source, frame: full.frame };
            if let Some(refusal) = pattern.refusal() {
                return Err(refusal);
            }
            self.patterns.push(pattern);
        } else if !is_vector {
            self.columns.insert(name.to_owned(), source);
        }
        Ok(())
    }
}

fn bad_entry(name: &str, value: toml::Value) -> Diagnostic {
    const KEYS: [&str; 5] = ["column", "scale", "offset", "sign", "frame"];
    let unknown = value.as_table().and_then(|t| t.keys().find(|k| !KEYS.contains(&k.as_str())));
    match unknown {
        Some(key) => {
            let otherwise = || "keys: column, scale, offset, sign, frame".to_owned();
            Diagnostic::error(format!("`{name}`: unknown key `{key}`")).help(suggest(key, KEYS, otherwise))
        }
        None => Diagnostic::error(format!(
            "`{name}`: expected a column name or {{ column, scale, offset, sign, frame }}"
        ))
        .help("scale, offset and sign are numbers, column is a text, frame is \"world\" or \"sole\""),
    }
}

fn unknown_name(name: &str) -> Diagnostic {
    let error = Diagnostic::error(format!("`{name}` is no column of a log, posture or impact table"));
    let guess = name.rsplit_once('/').and_then(|(joint, quantity)| {
        did_you_mean(quantity, super::names::JOINT_QUANTITIES)
            .map(|meant| format!("did you mean `{joint}/{meant}`?"))
    });
    error.help(
        guess.unwrap_or_else(|| {
            "columns are named like `left_knee/position` or `left_foot/force/z`".to_owned()
        }),
    )
}
