//! Columns of a log with feet on the ground.
use crate::log::{ForceFrame, Kind, Reader, names};
use crate::measure::columns::{BaseColumns, JointColumns, Plan};
use crate::robot::{BaseKind, Foot, Robot};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Columns of one foot: indices into the selected columns.
#[derive(Debug, Clone, Default)]
pub(super) struct FootColumns {
    pub force: [Option<usize>; 3],
    pub torque: [Option<usize>; 3],
    pub cop: [Option<usize>; 2],
    /// One per corner.
    pub corners: Vec<Option<usize>>,
    /// Where the force of a foot acts that touches with one point, in the sole frame, if nothing else tells it: it carries no moment there.
    pub point: Option<[f64; 2]>,
    /// Force and torque are in the axes of the sole, not of the world.
    pub in_sole: bool,
    /// Normal force and its centre are enough: moments are taken at a point of the ground (a robot that stands on a foot).
    pub normal: bool,
}

impl FootColumns {
    /// Force in three directions (planar: x and z), and a moment or a centre of pressure.
    pub fn is_whole(&self, planar: bool) -> bool {
        if self.normal {
            let center = self.point.is_some() || self.cop.iter().all(Option::is_some);
            return self.force[2].is_some() && (center || self.torque[..2].iter().all(Option::is_some));
        }
        let force = (0..3).all(|k| self.force[k].is_some() || planar && k == 1);
        let moment = self.has_torque(planar) || self.cop[0].is_some() && (planar || self.cop[1].is_some());
        force && moment
    }

    /// Force in all three directions.
    pub fn has_force(&self) -> bool {
        self.force.iter().all(Option::is_some)
    }

    /// All components of the torque that the robot can feel.
    pub fn has_torque(&self, planar: bool) -> bool {
        self.point.is_some() || (0..3).all(|k| self.torque[k].is_some() || planar && k != 1)
    }
}

/// What is read: motion in the plan of the comparison, and feet.
#[derive(Debug, Default)]
pub(super) struct Columns {
    pub plan: Plan,
    pub feet: Vec<FootColumns>,
    /// Roll, pitch, yaw that stand for the last four columns, a quaternion.
    pub angles: Option<[usize; 3]>,
    /// The foot that carries the base and stands still, where the log has no motion of the base.
    pub standing: Option<usize>,
}

impl Columns {
    /// Looks at the header and selects columns in the reader.
    ///
    /// # Errors
    /// No log; no motion of the base; no force of any foot; mixed frames.
    pub fn new(robot: &Robot<'_>, reader: &mut Reader) -> Result<Self, Diagnostics> {
        let mut columns = Self::default();
        columns.find(robot, reader).map_err(|e| {
            let e = if e.file.is_none() { e.in_file(reader.file()).at(1, 0) } else { e };
            Diagnostics(vec![e])
        })?;
        reader.select(&columns.plan.selected);
        if columns.angles.is_some() {
            // Made from the angles, block by block, after the columns of the file.
            columns.plan.selected.extend(["x", "y", "z", "w"].map(|axis| format!("base/orientation/{axis}")));
        }
        Ok(columns)
    }

    fn add(&mut self, reader: &Reader, name: &str) -> Option<usize> {
        if !reader.has(name) {
            return None;
        }
        self.plan.selected.push(name.to_owned());
        Some(self.plan.selected.len() - 1)
    }

    fn find(&mut self, robot: &Robot<'_>, reader: &Reader) -> Result<(), Diagnostic> {
        if reader.kind() != Kind::Time {
            let found = reader.kind().column();
            return Err(Diagnostic::error(format!("a log is needed (first column `time`), not `{found}`")));
        }
        self.find_joints(robot, reader)?;
        self.standing =
            super::standing::foot(robot).filter(|_| !reader.columns().any(|c| c.name.starts_with("base/")));
        match self.standing {
            Some(foot) => self.plan.assumptions.push(super::standing::assumption(&robot.feet[foot].name)),
            None => self.find_base(robot.layout.base, reader)?,
        }
        let planar = robot.planar();
        for foot in robot.feet {
            let found = self.find_foot(foot, reader)?;
            self.feet.push(found);
        }
        let points: Vec<&str> = robot
            .feet
            .iter()
            .zip(&self.feet)
            .filter(|(_, found)| found.point.is_some())
            .map(|(foot, _)| foot.name.as_str())
            .collect();
        if !points.is_empty() {
            let said = "only forces are logged of feet that touch the ground with one point: they act there and carry no moment";
            self.plan.assumptions.push(format!("{said}: {}", names::list(points.into_iter(), 8)));
        }
        let logs_something = |f: &FootColumns| f.is_whole(planar) || has_all_corners(f);
        let (with, without): (Vec<_>, Vec<_>) =
            robot.feet.iter().zip(&self.feet).partition(|(_, columns)| logs_something(columns));
        let names =
            |feet: &[(&Foot, &FootColumns)]| names::list(feet.iter().map(|(f, _)| f.name.as_str()), 8);
        if with.is_empty() {
            if self.standing.is_some() {
                return Err(Diagnostic::error("no foot has forces in the log").help(
                    "log `<foot>/force/z` with `<foot>/cop/x`, `/y` (m, sole frame) or `<foot>/torque/x`, `/y`, or all `<foot>/<corner>/force/z`",
                ));
            }
            return Err(Diagnostic::error("no foot has forces in the log").help(
                "log `<foot>/force/x`, `/y`, `/z` with `<foot>/cop/x`, `/y` or `<foot>/torque/x`, …, or all `<foot>/<corner>/force/z`; of feet that touch with one point the force is enough",
            ));
        }
        if !without.is_empty() {
            let said = format!("feet without forces in the log never touch the ground: {}", names(&without));
            self.plan.assumptions.push(said);
        }
        Ok(())
    }

    fn find_joints(&mut self, robot: &Robot<'_>, reader: &Reader) -> Result<(), Diagnostic> {
        let (mut still, mut as_motors, mut rigid) = (Vec::new(), Vec::new(), Vec::new());
        for joint in &robot.layout.joints {
            let position = self.add(reader, &format!("{}/position", joint.name));
            // Rows without a position do not count; other columns that are as good as empty count as not logged.
            let [motor_position, effort] = ["motor_position", "effort"].map(|what| {
                let name = format!("{}/{what}", joint.name);
                if self.plan.is_sparse(reader, &name) { None } else { self.add(reader, &name) }
            });
            let mut columns = JointColumns { position, effort, motor_position, ..JointColumns::default() };
            match (position, motor_position) {
                (None, None) => still.push(joint.name.as_str()),
                (None, Some(_)) => {
                    (columns.position, columns.motor_position) = (motor_position, None);
                    // Where the base is known by the joints alone, so is what they carry.
                    columns.by_motor = self.standing.is_none() && effort.is_some();
                    let list = if columns.by_motor { &mut as_motors } else { &mut rigid };
                    list.push(joint.name.as_str());
                }
                _ => {}
            }
            self.plan.joints.push(columns);
        }
        self.plan.note_motor_side(&as_motors);
        if !rigid.is_empty() {
            let without = if self.standing.is_some() { "the motion of the base" } else { "its effort" };
            self.plan.assumptions.push(format!(
                "no position column but `motor_position` for {}: the joint turns as its motor does; springs and play between them are \
                 neither looked for nor counted without {without}",
                names::list(rigid.iter().copied(), 40)
            ));
        }
        if still.len() == robot.layout.joints.len() {
            return Err(Diagnostic::error("no column is the position of a joint of this robot")
                .help("columns are named like `left_knee/position`; a mapping file gives other names"));
        }
        if !still.is_empty() {
            let said =
                format!("joints without a position column stand still at zero: {}", names::list(still, 40));
            self.plan.assumptions.push(said);
        }
        Ok(())
    }

    fn find_base(&mut self, base: BaseKind, reader: &Reader) -> Result<(), Diagnostic> {
        const ANGLES: [&str; 3] = ["base/orientation/roll", "base/orientation/pitch", "base/orientation/yaw"];
        let quaternion = ["x", "y", "z", "w"].map(|axis| format!("base/orientation/{axis}"));
        let mut wanted: Vec<String> = match base {
            BaseKind::Fixed | BaseKind::Pivot => {
                return Err(Diagnostic::error(
                    "the base of the model is fixed: forces on its feet tell nothing of it",
                )
                .help("describe the robot with a floating or planar base"));
            }
            BaseKind::Planar => ["base/position/x", "base/position/z"].map(str::to_owned).to_vec(),
            BaseKind::Floating => ["x", "y", "z"].map(|axis| format!("base/position/{axis}")).to_vec(),
        };
        let angles = base == BaseKind::Floating && !quaternion.iter().any(|name| reader.has(name));
        match base {
            BaseKind::Planar => wanted.push(ANGLES[1].to_owned()),
            _ if angles => {}
            _ => wanted.extend(quaternion),
        }
        let mut missing: Vec<&str> =
            wanted.iter().map(String::as_str).filter(|name| !reader.has(name)).collect();
        if angles {
            missing.extend(ANGLES.iter().filter(|name| !reader.has(name)));
        }
        if !missing.is_empty() {
            let message =
                format!("the motion of the base is not in the log: no column {}", names::list(missing, 7));
            return Err(Diagnostic::error(message)
                .help("log position and orientation (quaternion, or roll, pitch and yaw) of the root link"));
        }
        let mut columns: Vec<usize> = wanted.iter().filter_map(|name| self.add(reader, name)).collect();
        if angles {
            let found: Vec<usize> = ANGLES.iter().filter_map(|name| self.add(reader, name)).collect();
            self.angles = found.try_into().ok();
            // Where the quaternion will be is known when all columns are.
            columns.extend([usize::MAX; 4]);
            self.plan.assumptions.push(
                "base/orientation/roll, pitch, yaw turn about fixed axes: R = R_z(yaw) R_y(pitch) R_x(roll)"
                    .to_owned(),
            );
        }
        self.plan.base = Some(BaseColumns(columns));
        Ok(())
    }

    fn find_foot(&mut self, foot: &Foot, reader: &Reader) -> Result<FootColumns, Diagnostic> {
        let vector = |quantity: &str| ["x", "y", "z"].map(|axis| format!("{}/{quantity}/{axis}", foot.name));
        let frame = |quantity: &str| reader.frame(&format!("{}/{quantity}", foot.name));
        let mut found = FootColumns {
            force: vector("force").map(|name| self.add(reader, &name)),
            torque: vector("torque").map(|name| self.add(reader, &name)),
            cop: ["x", "y"].map(|axis| self.add(reader, &format!("{}/cop/{axis}", foot.name))),
            corners: foot
                .corners
                .iter()
                .map(|corner| self.add(reader, &format!("{}/{}/force/z", foot.name, corner.name)))
                .collect(),
            in_sole: frame("force") == ForceFrame::Sole,
            normal: self.standing.is_some(),
            point: None,
        };
        let elsewhere = found.torque.iter().chain(&found.cop).any(Option::is_some);
        if let ([_], false, true) = (&foot.corners[..], elsewhere, found.has_force()) {
            let place = foot.corner(0);
            found.point = Some([place.x, place.y]);
        }
        if found.torque.iter().any(Option::is_some) && frame("force") != frame("torque") {
            let message = format!("force and torque of `{}` are in different frames", foot.name);
            return Err(Diagnostic::error(message).help(format!(
                "set the frame of both `{0}/force` and `{0}/torque` in the mapping file",
                foot.name
            )));
        }
        Ok(found)
    }

    /// Puts the quaternion made from angles after the file's columns.
    pub fn place_quaternion(&mut self) {
        if self.angles.is_none() {
            return;
        }
        let first = self.plan.selected.len() - 4;
        if let Some(base) = &mut self.plan.base {
            let fill = base.0.iter_mut().filter(|c| **c == usize::MAX);
            fill.enumerate().for_each(|(k, column)| *column = first + k);
        }
    }
}

pub(super) fn has_all_corners(columns: &FootColumns) -> bool {
    !columns.corners.is_empty() && columns.corners.iter().all(Option::is_some)
}
