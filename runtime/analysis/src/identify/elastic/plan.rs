//! Which columns of a log are needed, which are there, and whose row they serve.
use super::driven::Driven;
use crate::log::{Kind, Reader};
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::drive::Drive;

/// Columns of a joint among the selected ones.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Columns {
    /// `<joint>/position`
    pub(super) position: Option<usize>,
    /// `<joint>/motor_position`
    pub(super) motor_position: Option<usize>,
    /// `<joint>/motor_current`
    pub(super) motor_current: Option<usize>,
}

impl Columns {
    /// Names of columns without which the row of a joint with this drive cannot be used.
    pub(super) fn absent(&self, drive: &Drive) -> Vec<&'static str> {
        let wanted = [
            (!drive.is_stiff(), self.position, "position"),
            (drive.is_elastic(), self.motor_position, "motor_position"),
            (drive.has_motor(), self.motor_current, "motor_current"),
        ];
        let mut absent: Vec<&str> =
            wanted.iter().filter(|(needed, column, _)| *needed && column.is_none()).map(|w| w.2).collect();
        if drive.is_stiff() && self.motor_position.or(self.position).is_none() {
            absent.push("motor_position");
        }
        absent
    }
}

/// What is read from a log.
#[derive(Debug, Clone)]
pub struct Plan {
    pub joints: Vec<Columns>,
    selected: Vec<String>,
    pub assumptions: Vec<String>,
    pub warnings: Vec<Diagnostic>,
}

impl Plan {
    pub fn new(
        reader: &mut Reader,
        layout: &JointLayout,
        drives: &[Driven<'_>],
    ) -> Result<Self, Diagnostics> {
        let one =
            |error: Diagnostic, reader: &Reader| Diagnostics(vec![error.in_file(reader.file()).at(1, 0)]);
        if reader.kind() != Kind::Time {
            let error = Diagnostic::error("drives are identified from logs over time, not from tables");
            return Err(one(error.help("give a log whose first column is `time`"), reader));
        }
        if layout.base.nv() > 0 && reader.columns().any(|c| c.name.starts_with("base/")) {
            let error = Diagnostic::error(
                "the log has base/... columns: series elastic drives are identified with the base held",
            );
            return Err(one(
                error.help("bolt the robot to a stand, or drop these columns if it was"),
                reader,
            ));
        }
        let mut plan =
            Self { joints: Vec::new(), selected: Vec::new(), assumptions: Vec::new(), warnings: Vec::new() };
        for joint in &layout.joints {
            let columns = Columns {
                position: plan.add(reader, format!("{}/position", joint.name)),
                motor_position: plan.add(reader, format!("{}/motor_position", joint.name)),
                motor_current: plan.add(reader, format!("{}/motor_current", joint.name)),
            };
            plan.joints.push(columns);
        }
        plan.refuse(reader, layout, drives).map_err(|error| one(error, reader))?;
        reader.select(&plan.selected);
        Ok(plan)
    }

    fn add(&mut self, reader: &Reader, name: String) -> Option<usize> {
        if !reader.has(&name) {
            return None;
        }
        self.selected.push(name);
        Some(self.selected.len() - 1)
    }

    /// A log that shows no elastic drive at all; warns of drives that it shows in part.
    fn refuse(
        &mut self,
        reader: &Reader,
        layout: &JointLayout,
        drives: &[Driven<'_>],
    ) -> Result<(), Diagnostic> {
        let mut lacking = Vec::new();
        for driven in drives {
            let name = &layout.joints[driven.joint].name;
            let absent = self.joints[driven.joint].absent(driven.drive);
            if !absent.is_empty() {
                let columns: Vec<String> = absent.iter().map(|what| format!("`{name}/{what}`")).collect();
                lacking.push((driven, columns.join(", ")));
            }
        }
        let shown = |driven: &Driven<'_>| {
            driven.drive.is_elastic() && !lacking.iter().any(|(d, _)| d.joint == driven.joint)
        };
        if !drives.iter().any(shown) {
            let columns: Vec<&str> =
                lacking.iter().filter(|(d, _)| d.drive.is_elastic()).map(|(_, c)| c.as_str()).collect();
            let message =
                format!("no series elastic drive is logged whole: there is no {}", columns.join(", "));
            return Err(Diagnostic::error(message).help(
                "log <joint>/position (rad), <joint>/motor_position (rad, motor shaft) and <joint>/motor_current (A), or name other columns with --mapping; --method torque needs joint torques only",
            ));
        }
        for (driven, columns) in &lacking {
            let name = &layout.joints[driven.joint].name;
            self.warnings.push(
                Diagnostic::warning(format!("`{name}` teaches nothing: the log has no {columns}"))
                    .in_file(reader.file())
                    .at(1, 0)
                    .help("log them, or name other columns with --mapping"),
            );
        }
        let still: Vec<&str> = (layout.joints.iter().zip(&self.joints))
            .enumerate()
            .filter(|(j, (_, c))| {
                let geared = drives.iter().any(|d| d.joint == *j && d.drive.is_stiff());
                c.position.is_none() && !(geared && c.motor_position.is_some())
            })
            .map(|(_, (joint, _))| joint.name.as_str())
            .collect();
        if !still.is_empty() {
            self.assumptions
                .push(format!("joints without a position column stand still at zero: {}", still.join(", ")));
        }
        Ok(())
    }

    /// Column that tells the joint's angle, and the factor to it.
    pub fn angle(&self, joint: usize, drives: &[Driven<'_>]) -> Option<(usize, f64)> {
        let columns = self.joints[joint];
        let stiff = drives.iter().find(|d| d.joint == joint && d.drive.is_stiff());
        match (stiff, columns.motor_position) {
            (Some(stiff), Some(motor)) => Some((motor, 1.0 / stiff.drive.gear_ratio)),
            _ => columns.position.map(|column| (column, 1.0)),
        }
    }
}

/// Whether each joint's row can be used with these columns.
pub fn observed(joints: &[Columns], drives: &[Driven<'_>]) -> Vec<bool> {
    let usable = |j: usize| drives.iter().any(|d| d.joint == j && joints[j].absent(d.drive).is_empty());
    (0..joints.len()).map(usable).collect()
}
