//! From a posture table to an experiment.
use super::predict::Sensors;
use super::{PostureExperiment, Reading};
use crate::experiments::{Channel, Inertial, Row};
use crate::log::{Kind, Log, Reader, Table, names};
use crate::robot::calls::{ModelCalls, gravity};
use crate::robot::feet::{FootCalls, choose};
use crate::robot::inertial_parameters::element_of;
use crate::robot::world::World;
use crate::robot::{BaseKind, Robot};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use nalgebra::Vector3;

/// Fewer postures tell nothing.
const FEWEST: usize = 4;

impl<'a> PostureExperiment<'a> {
    /// Reads a table of postures. `stance` names the foot in whose sole frame `cop/x`, `cop/y` are; `None`: the right
    /// one.
    ///
    /// # Errors
    /// Those of the reader; another kind of table; no centre of pressure; joints without a position; a model without
    /// the functions that are needed.
    pub fn read(robot: Robot<'a>, log: &Log, stance: Option<&str>) -> Result<Self, Diagnostics> {
        Self::from_reader(robot, log.rows(), stance)
    }

    /// The same from any source.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_reader(robot: Robot<'a>, reader: Reader, stance: Option<&str>) -> Result<Self, Diagnostics> {
        let file = reader.file().to_path_buf();
        if reader.kind() != Kind::Posture {
            let message = format!(
                "a table of postures is needed (first column `posture`), not `{}`",
                reader.kind().column()
            );
            return Err(Diagnostics(vec![Diagnostic::error(message).in_file(&file)]));
        }
        let wanted: Vec<String> =
            reader.columns().map(|c| c.name.clone()).filter(|n| names::is_known_form(n)).collect();
        let wanted: Vec<String> = wanted.into_iter().filter(|n| n != Kind::Posture.column()).collect();
        let table = Table::read(reader, &wanted)?;
        build(robot, &table, stance).map_err(|e| Diagnostics(vec![e.in_file(&file)]))
    }
}

fn build<'a>(
    robot: Robot<'a>,
    table: &Table,
    stance: Option<&str>,
) -> Result<PostureExperiment<'a>, Diagnostic> {
    let count = table.rows();
    if count < FEWEST {
        return Err(Diagnostic::error(format!(
            "{count} postures tell nothing: at least {FEWEST} are needed"
        ))
        .help("take 30 or more that turn the links about two horizontal axes"));
    }
    let calls = ModelCalls::new(robot.model);
    let (stance, said) = choose(robot.feet, stance, "stance")?;
    let feet = robot.feet.iter().map(|foot| FootCalls::new(&calls, foot)).collect::<Result<Vec<_>, _>>()?;
    let parameters = robot.link_inertias.parameters();
    let regressor = calls.find("center_of_mass_regressor")?;
    if calls.columns(regressor) != parameters.len() {
        return Err(Diagnostic::error("the model's `center_of_mass_regressor` is of another robot"));
    }
    let mass = parameters.mass();
    let mut assumptions: Vec<String> = said.into_iter().collect();
    let (q, oriented) = configurations(&robot, &calls, table, &mut assumptions)?;
    let mut experiment = PostureExperiment {
        gravity: gravity(&calls, robot.layout.base, mass)?,
        number: table.columns[0].clone(),
        corners: corners(&robot, table, &mut assumptions),
        robot,
        calls,
        feet,
        stance,
        regressor,
        q,
        oriented,
        parameters,
        rows: Vec::new(),
        measured: Vec::new(),
        kinds: Vec::new(),
        residual: Vec::new(),
        inertial: Vec::new(),
        assumptions,
    };
    experiment.add_rows(table)?;
    experiment.finish();
    Ok(experiment)
}

/// Configurations, `postures × nq`, and whether the base's orientation was logged.
fn configurations(
    robot: &Robot<'_>,
    calls: &ModelCalls<'_>,
    table: &Table,
    assumptions: &mut Vec<String>,
) -> Result<(Vec<f64>, bool), Diagnostic> {
    let base: &[(usize, &str)] = match robot.layout.base {
        BaseKind::Fixed | BaseKind::Pivot => &[],
        BaseKind::Planar => &[(2, "base/orientation/pitch")],
        BaseKind::Floating => &[
            (3, "base/orientation/x"),
            (4, "base/orientation/y"),
            (5, "base/orientation/z"),
            (6, "base/orientation/w"),
        ],
    };
    let oriented = !base.is_empty() && base.iter().all(|(_, name)| table.column(name).is_some());
    if !oriented {
        assumptions.push(
            "no base/orientation columns: the stance sole is taken as horizontal, the base follows from the joints".to_owned(),
        );
    }
    let first = calls.nq - robot.layout.joints.len();
    let mut q = Vec::new();
    let mut still = Vec::new();
    for i in 0..table.rows() {
        let mut row = calls.rest(robot.layout.base);
        if oriented {
            base.iter()
                .filter_map(|(k, name)| Some((k, table.column(name)?)))
                .for_each(|(k, c)| row[*k] = c[i]);
            normalise(&mut row[..first]).ok_or_else(|| {
                Diagnostic::error("base/orientation is no rotation: its quaternion is zero")
                    .at(table.lines[i], 0)
            })?;
        }
        for (j, joint) in robot.layout.joints.iter().enumerate() {
            match table.column(&format!("{}/position", joint.name)) {
                Some(column) => row[first + j] = column[i],
                None if i == 0 => still.push(joint.name.as_str()),
                None => {}
            }
        }
        q.extend(row);
    }
    if still.len() == robot.layout.joints.len() {
        return Err(Diagnostic::error("no column is the position of a joint of this robot").at(1, 0).help(
            format!("columns are named like `{}/position`; a mapping file gives other names", still[0]),
        ));
    }
    if !still.is_empty() {
        assumptions
            .push(format!("joints without a position column stay at zero: {}", names::list(still, 40)));
    }
    Ok((q, oriented))
}

/// Makes the quaternion of a floating base a unit one.
pub(crate) fn normalise(base: &mut [f64]) -> Option<()> {
    let Some(quaternion) = base.get_mut(3..7) else { return Some(()) };
    let norm = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
    if !(norm > 1e-6 && norm.is_finite()) {
        return None;
    }
    quaternion.iter_mut().for_each(|c| *c /= norm);
    Some(())
}

/// The corners' forces: those of all feet, or none.
fn corners(robot: &Robot<'_>, table: &Table, assumptions: &mut Vec<String>) -> Vec<Reading> {
    let mut readings = Vec::new();
    let mut missing = Vec::new();
    for (f, foot) in robot.feet.iter().enumerate() {
        for (c, corner) in foot.corners.iter().enumerate() {
            let name = format!("{}/{}/force/z", foot.name, corner.name);
            match table.column(&name) {
                Some(force) => readings.push(Reading { place: (f, c), force: force.to_vec() }),
                None => missing.push(name),
            }
        }
    }
    if missing.is_empty() {
        return readings;
    }
    if !readings.is_empty() {
        let missing = names::list(missing.iter().map(String::as_str), 8);
        assumptions.push(format!("corner forces are not used because some are missing: {missing}"));
    }
    Vec::new()
}

impl PostureExperiment<'_> {
    fn add_rows(&mut self, table: &Table) -> Result<(), Diagnostic> {
        for (kind, name) in [(0, "cop/x"), (1, "cop/y")] {
            let Some(column) = table.column(name) else { continue };
            if let Some(i) = column.iter().position(|c| !c.is_finite()) {
                return Err(Diagnostic::error(format!("`{name}` is empty in posture {}", self.number[i]))
                    .at(table.lines[i], 0)
                    .help("remove postures in which no foot is loaded"));
            }
            self.push_row(kind, name, Channel::Cop, "m", column.to_vec());
        }
        if self.rows.is_empty() {
            return Err(Diagnostic::error("the table has neither `cop/x` nor `cop/y`")
                .at(1, 0)
                .help("log the centre of pressure in the sole frame of the stance foot, m"));
        }
        if !self.corners.is_empty() {
            let total = |i: usize| self.corners.iter().map(|r| r.force[i]).sum();
            let totals = (0..table.rows()).map(total).collect();
            self.push_row(2, "base/force/z", Channel::BaseForce, "N", totals);
        }
        Ok(())
    }

    fn push_row(
        &mut self,
        kind: usize,
        name: &str,
        channel: Channel,
        unit: &'static str,
        measured: Vec<f64>,
    ) {
        self.rows.push(Row { name: name.to_owned(), channel, unit, joint: None, noise: 1.0 });
        self.kinds.push(kind);
        self.measured.push(measured);
    }

    /// Residuals, derivatives and noise, once everything else is known.
    fn finish(&mut self) {
        self.residual = self.residual_under(&[]);
        let present = self.robot.effects;
        let (world, sensors) = (World::of(present, self.robot.layout), Sensors::of(present));
        let change = self.robot.link_inertias.change(present);
        let predicted = self.predict(&world, &change, &sensors);
        let added = change.mass();
        let mass = self.parameters.mass() + added;
        let gradients: Vec<Vec<[f64; 3]>> =
            (0..self.number.len()).map(|i| self.gradient(i, &world, &sensors, mass, &predicted[i])).collect();
        self.inertial = self.kinds.iter().map(|&kind| sparse(&gradients, kind)).collect();
        let noise = self.noise();
        self.rows.iter_mut().zip(noise).for_each(|(row, noise)| row.noise = noise);
    }

    /// Derivatives of centre of pressure and weight by the inertial parameters: by the quotient rule, since the
    /// centre of mass is `regressor · parameters / mass`.
    fn gradient(
        &self,
        posture: usize,
        world: &World,
        sensors: &Sensors,
        mass: f64,
        predicted: &[f64; 3],
    ) -> Vec<[f64; 3]> {
        let q = self.configuration(posture, world);
        let sole = self.feet[self.stance].sole(&self.calls, &self.robot.feet[self.stance], &q);
        let true_sole = self.sole_in_world(posture, world, sensors, &sole.rotation);
        let down = true_sole.transpose() * self.gravity.normalize();
        let columns = self.regressor_at(&q);
        let columns = columns.chunks_exact(3).enumerate();
        columns
            .map(|(k, column)| {
                let is_mass = if element_of(k) == 0 { 1.0 } else { 0.0 };
                let origin = sole.origin * is_mass;
                let moved = sole.rotation.transpose() * (Vector3::from_column_slice(column) - origin);
                let along = |axis: usize| {
                    (moved[axis] - moved.z * down[axis] / down.z - predicted[axis] * is_mass) / mass
                };
                [along(0), along(1), -is_mass * self.gravity.norm() * down.z]
            })
            .collect()
    }
}

/// The columns of one row kind that are not zero.
fn sparse(gradients: &[Vec<[f64; 3]>], kind: usize) -> Inertial {
    let width = gradients.first().map_or(0, Vec::len);
    let matters = |k: &usize| gradients.iter().any(|g| g[*k][kind].abs() > 1e-12);
    let columns: Vec<usize> = (0..width).filter(matters).collect();
    let values = gradients.iter().flat_map(|g| columns.iter().map(|k| g[*k][kind])).collect();
    Inertial { columns, values }
}
