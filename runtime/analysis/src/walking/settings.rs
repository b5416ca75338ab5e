//! Numbers of a walk: stated in a robot's `walking.toml` or on the command line, else derived from the robot.
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, line_and_column};
use bipedc_effects::input;
use bipedc_effects::spelling::suggest;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

macro_rules! settings {
    ($($name:ident, $unit:literal, $low:literal, $high:literal, $meaning:literal;)*) => {
        /// All numbers of a walk.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize)]
        pub struct Settings {
            $(#[doc = concat!($meaning, ", ", $unit)] pub $name: f64,)*
        }

        impl Settings {
            /// Name, unit, bounds and meaning of each.
            pub const KEYS: &'static [(&'static str, &'static str, [f64; 2], &'static str)] =
                &[$((stringify!($name), $unit, [$low, $high], $meaning),)*];

            /// Those that are stated instead of these.
            #[must_use]
            pub fn with(mut self, stated: &Stated) -> Self {
                $(if let Some(value) = stated.values.get(stringify!($name)) { self.$name = *value; })*
                self
            }
        }
    };
}

settings! {
    knee_bend, "rad", 0.05, 2.0, "angle of the knees when the robot stands";
    com_height, "m", 0.01, 100.0, "height of the centre of mass above the ground";
    stance_width, "m", 0.001, 10.0, "distance of the middles of the soles when the robot stands";
    step_height, "m", 0.0005, 10.0, "how high feet are lifted";
    margin, "m", 0.0, 1.0, "least distance of zero moment point and (static) centre of mass from the edge of the support polygon";
    clearance, "m", 0.0, 1.0, "least height of a foot in the middle half of its way";
    feet_distance, "m", 0.0, 1.0, "least distance of the soles as seen from above";
    legs_distance, "m", 0.0, 10.0, "least distance of the lines through the joints of both legs";
    friction, "1", 0.01, 10.0, "largest horizontal force of the ground per vertical one";
    effort_part, "1", 0.01, 1.0, "part of the effort limits that a plan may use";
    velocity_part, "1", 0.01, 1.0, "part of the velocity limits that a plan may use";
    static_shift_time, "s", 0.05, 60.0, "static: of shifting the weight";
    static_swing_time, "s", 0.1, 60.0, "static: of a foot in the air";
    static_stand_time, "s", 0.05, 60.0, "static: of standing at the beginning and at the end";
    step_time, "s", 0.2, 10.0, "dynamic: of a step";
    double_support, "1", 0.05, 0.8, "dynamic: part of a step in which both feet stand";
    stand_time, "s", 0.5, 60.0, "dynamic: of standing at the beginning and at the end";
    sample, "s", 0.0005, 0.05, "between rows of the plan";
}

/// What a file or a user says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stated {
    values: BTreeMap<String, f64>,
    /// Angles of joints that are not in the legs, rad.
    pub posture: BTreeMap<String, f64>,
}

impl Stated {
    /// States a number.
    ///
    /// # Errors
    /// No such name; a number out of its bounds.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), Diagnostic> {
        let Some((_, unit, [low, high], _)) = Settings::KEYS.iter().find(|key| key.0 == name) else {
            let message = format!("a walk has no number `{name}`");
            let names = Settings::KEYS.iter().map(|key| key.0);
            return Err(Diagnostic::error(message)
                .help(suggest(name, names, || "docs/walking.md lists them".to_owned())));
        };
        if !(*low..=*high).contains(&value) {
            let message = format!("`{name}` = {value} is not possible");
            return Err(
                Diagnostic::error(message).help(format!("write a number from {low} to {high} ({unit})"))
            );
        }
        self.values.insert(name.to_owned(), value);
        Ok(())
    }

    /// Whether it is stated.
    pub fn states(&self, name: &str) -> bool {
        self.values.contains_key(name)
    }
}

/// Reads a `walking.toml`: numbers by their names, and a table `[posture]` of joint angles.
///
/// # Errors
/// Everything that has no meaning, with line and column.
pub fn read_settings(path: &Path) -> Result<Stated, Diagnostics> {
    let cannot = |error: std::io::Error| Diagnostic::error(format!("cannot be read: {error}")).in_file(path);
    parse_settings(&input::read_to_string(path).map_err(cannot)?)
        .map_err(|list| Diagnostics(list.0.into_iter().map(|wrong| wrong.in_file(path)).collect()))
}

pub(super) fn parse_settings(text: &str) -> Result<Stated, Diagnostics> {
    let at = |error: Diagnostic, offset: usize| {
        let (line, column) = line_and_column(text, offset);
        error.at(line, column)
    };
    let entries: BTreeMap<String, Spanned<toml::Value>> = toml::from_str(text)
        .map_err(|e| at(Diagnostic::error(e.message().to_owned()), e.span().map_or(0, |s| s.start)))?;
    let (mut stated, mut wrong) = (Stated::default(), Vec::new());
    for (name, value) in entries {
        let start = value.span().start;
        let value = value.into_inner();
        let said = match (name.as_str(), value.as_table()) {
            ("posture", Some(joints)) => posture(joints).map(|joints| stated.posture = joints),
            _ => number(&name, &value).and_then(|value| stated.set(&name, value)),
        };
        wrong.extend(said.err().map(|error| at(error, start)));
    }
    if wrong.is_empty() { Ok(stated) } else { Err(Diagnostics(wrong)) }
}

fn posture(joints: &toml::Table) -> Result<BTreeMap<String, f64>, Diagnostic> {
    joints.iter().map(|(name, value)| Ok((name.clone(), number(name, value)?))).collect()
}

fn number(name: &str, value: &toml::Value) -> Result<f64, Diagnostic> {
    let found = value.as_float().or_else(|| value.as_integer().map(|x| x as f64));
    let found = found.filter(|x| x.is_finite() && x.abs() < 1e6);
    found.ok_or_else(|| {
        Diagnostic::error(format!("`{name}` is no number")).help("write a number in SI units, such as 0.03")
    })
}
