//! Which columns of the log are needed, which are there, and what follows from those that are not.
use crate::log::{Column, Kind, Reader, names};
use crate::measure::{Options, VelocitySource};
use crate::robot::{BaseKind, JointLayout};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::spelling::suggest;
use serde::Serialize;

/// A joint that could not be compared.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Of the joint.
    pub name: String,
    /// Such as the column that is not there.
    pub reason: String,
}

/// Columns of one joint: indices into the selected columns (without the time).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct JointColumns {
    pub position: Option<usize>,
    pub velocity: Option<usize>,
    pub effort: Option<usize>,
    pub motor_position: Option<usize>,
    /// `position` is the motor's.
    pub by_motor: bool,
}

/// Columns of the base, in the order of its `q`.
#[derive(Debug, Clone)]
pub(crate) struct BaseColumns(pub Vec<usize>);

/// What is read from the log.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    pub selected: Vec<String>,
    pub joints: Vec<JointColumns>,
    pub base: Option<BaseColumns>,
    pub missing: Vec<Missing>,
    pub assumptions: Vec<String>,
    pub warnings: Vec<Diagnostic>,
    /// Columns that are there and as good as empty, and how empty.
    sparse: Vec<(String, String)>,
}

const FLOATING: [&str; 7] = [
    "base/position/x",
    "base/position/y",
    "base/position/z",
    "base/orientation/x",
    "base/orientation/y",
    "base/orientation/z",
    "base/orientation/w",
];
const PLANAR: [&str; 3] = ["base/position/x", "base/position/z", "base/orientation/pitch"];

impl Plan {
    /// Looks at the header and selects the columns in the reader.
    pub fn new(layout: &JointLayout, reader: &mut Reader, options: &Options) -> Result<Self, Diagnostics> {
        if reader.kind() != Kind::Time {
            let message = format!(
                "a comparison needs a log (first column `time`), this table has `{}`",
                reader.kind().column()
            );
            let help = "posture and impact tables are for other commands";
            return Err(Diagnostics(vec![Diagnostic::error(message).in_file(reader.file()).help(help)]));
        }
        let mut plan = Self::default();
        plan.note_unknown_joints(layout, reader)?;
        let mut by_motor: Vec<&str> = Vec::new();
        for joint in &layout.joints {
            let mut columns = JointColumns {
                position: plan.add(reader, format!("{}/position", joint.name)),
                velocity: None,
                effort: plan.add(reader, format!("{}/effort", joint.name)),
                motor_position: plan.add(reader, format!("{}/motor_position", joint.name)),
                by_motor: false,
            };
            if columns.position.is_none() && columns.motor_position.is_some() {
                (columns.position, columns.motor_position) = (columns.motor_position, None);
                columns.by_motor = true;
                by_motor.push(&joint.name);
            }
            if options.velocity == VelocitySource::Logged && columns.position.is_some() {
                columns.velocity = plan.add(reader, format!("{}/velocity", joint.name));
            }
            plan.joints.push(columns);
        }
        plan.note_motor_side(&by_motor);
        plan.note_missing(layout, reader, options)?;
        plan.add_base(layout, reader)?;
        reader.select(&plan.selected);
        Ok(plan)
    }

    fn add(&mut self, reader: &Reader, name: String) -> Option<usize> {
        if !reader.has(&name) || self.is_sparse(reader, &name) {
            return None;
        }
        self.selected.push(name);
        Some(self.selected.len() - 1)
    }

    /// Whether a column is as good as empty, so that the others keep their samples without it.
    pub fn is_sparse(&mut self, reader: &Reader, name: &str) -> bool {
        let Some(sparse) = reader.sparse(name) else { return false };
        let how = match sparse.rows {
            rows if rows == sparse.of => format!("`{name}` is empty in all {rows} rows"),
            rows => format!("`{name}` is empty in {rows} of {} rows", sparse.of),
        };
        let (what, first) = match name.strip_suffix("/effort") {
            Some(joint) => {
                (format!("the effort of `{joint}` is left out"), "all other joints keep their samples")
            }
            None => ("the column counts as not logged".to_owned(), "rows without it would not count either"),
        };
        let line = if sparse.rows == sparse.of { "" } else { ", first in this line" };
        let help = format!("{first}; take the column out, or fill it, to be rid of this warning");
        let warning = Diagnostic::warning(format!("{how}{line}: {what}"));
        self.warnings.push(warning.in_file(reader.file()).at(sparse.line, 0).help(help));
        self.sparse.push((name.to_owned(), how));
        true
    }

    /// Why a column is not used: it is empty, or not there.
    fn lack(&self, name: &str) -> String {
        let sparse = self.sparse.iter().find(|(column, _)| column == name);
        sparse.map_or_else(|| format!("the log has no column `{name}`"), |(_, how)| how.clone())
    }

    /// Columns of joints that the robot does not have; an error if it has none of them.
    fn note_unknown_joints(&mut self, layout: &JointLayout, reader: &Reader) -> Result<(), Diagnostics> {
        let known = || layout.joints.iter().map(|j| j.name.as_str());
        let mut unknown: Vec<(&str, &str)> = Vec::new();
        let mut found = 0;
        let renamed = |column: &&Column| reader.is_renamed(column);
        // What a mapping does not read of such a joint is of the same joint.
        let others: Vec<&str> =
            reader.columns().filter(renamed).filter_map(|column| names::joint_of(&column.name)).collect();
        for column in reader.columns().filter(|column| !renamed(column)) {
            let Some(joint) = names::joint_of(&column.name) else { continue };
            if others.contains(&joint) && !known().any(|name| name == joint) {
                continue;
            }
            if known().any(|name| name == joint) {
                found += 1;
            } else if !unknown.iter().any(|(_, other)| *other == joint) {
                unknown.push((&column.name, joint));
            }
        }
        if found == 0 {
            let columns = reader.columns().map(|c| c.name.as_str());
            let message =
                format!("no column is of a joint of this robot; columns: {}", names::list(columns, 8));
            let help = format!(
                "columns are named like `left_knee/position`, joints of the robot: {}; a mapping file gives other names, \
                 `bipedc log {} --robot ROBOT` proposes one",
                names::list(known(), 40),
                reader.file().display()
            );
            return Err(Diagnostics(vec![
                Diagnostic::error(message).in_file(reader.file()).at(1, 0).help(help),
            ]));
        }
        for (column, joint) in unknown {
            let message =
                format!("columns of `{}` are ignored: the robot has no such joint", names::shorten(joint));
            let help =
                suggest(joint, known(), || format!("joints of the robot: {}", names::list(known(), 40)));
            let (file, (line, character)) = reader.named_by(column).unwrap_or((reader.file(), (1, 0)));
            self.warnings.push(Diagnostic::warning(message).in_file(file).at(line, character).help(help));
        }
        Ok(())
    }

    /// Joints of which only the motor's side is measured.
    pub fn note_motor_side(&mut self, joints: &[&str]) {
        if !joints.is_empty() {
            self.assumptions.push(format!(
                "no position column but `motor_position` for {}: the joint turns as its motor does (`compare` and `diagnose` heed a \
                 spring or play between them that is described or found, `identify` does not)",
                names::list(joints.iter().copied(), 40)
            ));
        }
    }

    fn note_missing(
        &mut self,
        layout: &JointLayout,
        reader: &Reader,
        options: &Options,
    ) -> Result<(), Diagnostics> {
        let place = |d: Diagnostic| d.in_file(reader.file()).at(1, 0);
        let without = |has: fn(&JointColumns) -> bool| {
            let joints = layout.joints.iter().zip(&self.joints).filter(move |(_, c)| !has(c));
            joints.map(|(j, _)| j.name.clone()).collect::<Vec<_>>()
        };
        let no_position = without(|c| c.position.is_some());
        let no_effort = without(|c| c.effort.is_some());
        let no_velocity = without(|c| c.velocity.is_some() || c.position.is_none());
        for (what, missing) in [("position", &no_position), ("effort", &no_effort)] {
            if missing.len() == layout.joints.len() {
                let message =
                    format!("no joint of the robot has a column `<joint>/{what}`: nothing can be compared");
                let help = format!(
                    "the log needs columns like `{}/{what}`; a mapping file gives other names",
                    missing[0]
                );
                return Err(Diagnostics(vec![place(Diagnostic::error(message)).help(help)]));
            }
        }
        for name in &no_effort {
            let reason = self.lack(&format!("{name}/effort"));
            self.missing.push(Missing { name: name.clone(), reason });
        }
        if options.velocity == VelocitySource::Logged && !no_velocity.is_empty() {
            let joints = names::list(no_velocity.iter().map(String::as_str), 40);
            let message = format!("no velocity column for {joints}: their positions are differentiated");
            self.warnings.push(
                place(Diagnostic::warning(message)).help("log `<joint>/velocity` for all joints or for none"),
            );
        }
        if !no_position.is_empty() {
            let joints = names::list(no_position.iter().map(String::as_str), 40);
            self.assumptions.push(format!("joints without a position column stand still at zero: {joints}"));
        }
        // Its torque was measured, so it was there; the model would be held against a motion that is not its own.
        for name in no_position.iter().filter(|name| !no_effort.contains(name)) {
            let message = format!(
                "the log has `{name}/effort` but no {}`{name}/position`: what depends on its motion is left out",
                if self.sparse.iter().any(|(column, _)| *column == format!("{name}/position")) {
                    "usable "
                } else {
                    "column "
                }
            );
            let help = format!(
                "log `{name}/position` (rad), or give its column's name with --mapping; lock a joint that stood still in biped.toml: `[joints] locked = {{ {name} = ANGLE }}`"
            );
            self.warnings.push(place(Diagnostic::warning(message)).help(help));
        }
        Ok(())
    }

    fn add_base(&mut self, layout: &JointLayout, reader: &Reader) -> Result<(), Diagnostics> {
        let wanted: &[&str] = match layout.base {
            BaseKind::Fixed | BaseKind::Pivot => &[],
            BaseKind::Floating => &FLOATING,
            BaseKind::Planar => &PLANAR,
        };
        let (found, missing): (Vec<&str>, Vec<&str>) = wanted.iter().partition(|name| reader.has(name));
        let any_of_base = reader.columns().any(|c| c.name.starts_with("base/"));
        if !any_of_base {
            self.assumptions.push(
                "the log has no base/... columns: the root link is taken as fixed, upright and at rest"
                    .to_owned(),
            );
        } else if wanted.is_empty() {
            self.assumptions
                .push("the base of the model is fixed: the log's base/... columns are ignored".to_owned());
        } else if missing.is_empty() {
            let columns = found.iter().filter_map(|name| self.add(reader, (*name).to_owned())).collect();
            self.base = Some(BaseColumns(columns));
            self.note_forces(reader);
        } else {
            let message =
                format!("the motion of the base is incomplete: no column {}", names::list(missing, 7));
            let help =
                "log position and orientation of the base, or drop all base/... columns if it did not move";
            return Err(Diagnostics(vec![
                Diagnostic::error(message).in_file(reader.file()).at(1, 0).help(help),
            ]));
        }
        Ok(())
    }

    fn note_forces(&mut self, reader: &Reader) {
        self.assumptions
            .push("no external forces act: ground contact is not part of the prediction".to_owned());
        let force = reader.columns().find(|c| c.name.contains("/force/") || c.name.contains("/cop/"));
        if let Some(column) = force {
            let message = format!(
                "contact forces (`{}`) are in the log but not part of the prediction yet",
                column.name
            );
            let help =
                "while a foot touches the ground the errors contain the torques that hold the robot up";
            self.warnings.push(Diagnostic::warning(message).in_file(reader.file()).at(1, 0).help(help));
        }
    }
}
