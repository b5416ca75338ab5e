//! From a table of impacts to an experiment.
use super::{Changed, ImpactExperiment};
use crate::experiments::postures::normalise;
use crate::experiments::{Channel, Inertial, Row};
use crate::log::{Kind, Log, Reader, Table, names};
use crate::robot::calls::{ModelCalls, base_rows};
use crate::robot::feet::{FootCalls, choose};
use crate::robot::{BaseKind, Robot};
use crate::signal::rotate_to_base;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use nalgebra::{DMatrix, DVector};

/// Fewer impacts tell nothing.
const FEWEST: usize = 3;
/// Smallest noise that is believed, m/s and rad/s.
const SMALLEST: f64 = 1e-6;

impl<'a> ImpactExperiment<'a> {
    /// Reads a table of impacts. `foot` names the foot that strikes; `None`: the right one.
    ///
    /// # Errors
    /// Those of the reader; another kind of table; configurations or velocities that are missing; a model without the
    /// functions that are needed, or whose base is fixed.
    pub fn read(robot: Robot<'a>, log: &Log, foot: Option<&str>) -> Result<Self, Diagnostics> {
        Self::from_reader(robot, log.rows(), foot)
    }

    /// The same from any source.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_reader(robot: Robot<'a>, reader: Reader, foot: Option<&str>) -> Result<Self, Diagnostics> {
        let file = reader.file().to_path_buf();
        if reader.kind() != Kind::Impact {
            let message = format!(
                "a table of impacts is needed (first column `impact`), not `{}`",
                reader.kind().column()
            );
            return Err(Diagnostics(vec![Diagnostic::error(message).in_file(&file)]));
        }
        let known = reader.columns().map(|c| c.name.clone()).filter(|n| names::is_known_form(n));
        let wanted: Vec<String> = known.filter(|n| n != Kind::Impact.column()).collect();
        let table = Table::read(reader, &wanted)?;
        build(robot, &table, foot).map_err(|e| Diagnostics(vec![e.in_file(&file)]))
    }

    pub(super) fn nominal(&self) -> Changed {
        self.changed(&[])
    }
}

/// Names of the coordinates of `q` and of those of `v`, as tables have them (without `/before`, `/after`).
fn coordinates(robot: &Robot<'_>) -> (Vec<String>, Vec<String>) {
    let base: &[&str] = match robot.layout.base {
        BaseKind::Fixed | BaseKind::Pivot => &[],
        BaseKind::Planar => &["base/position/x", "base/position/z", "base/orientation/pitch"],
        BaseKind::Floating => &[
            "base/position/x",
            "base/position/y",
            "base/position/z",
            "base/orientation/x",
            "base/orientation/y",
            "base/orientation/z",
            "base/orientation/w",
        ],
    };
    let mut q: Vec<String> = base.iter().map(|s| (*s).to_owned()).collect();
    let name = |(axis, linear): &(&str, bool)| {
        format!("base/{}_velocity/{axis}", if *linear { "linear" } else { "angular" })
    };
    let mut v: Vec<String> = base_rows(robot.layout.base).iter().map(name).collect();
    for joint in &robot.layout.joints {
        q.push(format!("{}/position", joint.name));
        v.push(format!("{}/velocity", joint.name));
    }
    (q, v)
}

fn build<'a>(
    robot: Robot<'a>,
    table: &Table,
    foot: Option<&str>,
) -> Result<ImpactExperiment<'a>, Diagnostic> {
    if robot.layout.base == BaseKind::Fixed {
        return Err(Diagnostic::error("a robot whose base is fixed has no impacts with the ground")
            .help("describe it with a floating or planar base"));
    }
    if table.rows() < FEWEST {
        return Err(Diagnostic::error(format!(
            "{} impacts tell nothing: at least {FEWEST} are needed",
            table.rows()
        )));
    }
    let calls = ModelCalls::new(robot.model);
    let (foot, said) = choose(robot.feet, foot, "striking")?;
    let mut assumptions: Vec<String> = said.into_iter().collect();
    let flat = robot.feet[foot].is_flat(robot.planar());
    if flat {
        assumptions.push(format!("`{}` strikes flat, with its whole sole", robot.feet[foot].name));
    }
    let (q_names, v_names) = coordinates(&robot);
    let (q, before) = states(&robot, table, &q_names, &v_names, &mut assumptions)?;
    let (after, measured) = results(table, &v_names)?;
    let parameters = robot.link_inertias.parameters();
    let mut experiment = ImpactExperiment {
        foot_calls: FootCalls::new(&calls, &robot.feet[foot])?,
        inverse_dynamics: calls.find("inverse_dynamics")?,
        regressor: calls.find("inverse_dynamics_regressor")?,
        number: table.columns[0].clone(),
        rows: measured.iter().map(|k| row(&robot, *k, &v_names[*k])).collect(),
        robot,
        calls,
        foot,
        flat,
        q,
        before,
        after,
        measured,
        parameters,
        residual: Vec::new(),
        inertial: Vec::new(),
        assumptions,
    };
    if calls.columns(experiment.regressor) != experiment.parameters.len() {
        return Err(Diagnostic::error("the model's `inverse_dynamics_regressor` is of another robot"));
    }
    experiment.finish();
    Ok(experiment)
}

fn row(robot: &Robot<'_>, index: usize, name: &str) -> Row {
    let base = base_rows(robot.layout.base);
    let joint = index.checked_sub(base.len()).map(|j| &robot.layout.joints[j]);
    let linear = base.get(index).map_or(joint.is_some_and(|j| j.prismatic), |(_, linear)| *linear);
    Row {
        name: name.to_owned(),
        channel: Channel::PostImpactVelocity,
        unit: if linear { "m/s" } else { "rad/s" },
        joint: joint.map(|j| j.name.clone()),
        noise: 1.0,
    }
}

/// Configurations (`impacts × nq`) and velocities before (`impacts × nv`, as the model has them).
fn states(
    robot: &Robot<'_>,
    table: &Table,
    q_names: &[String],
    v_names: &[String],
    assumptions: &mut Vec<String>,
) -> Result<(Vec<f64>, Vec<f64>), Diagnostic> {
    let base_nq = robot.layout.base.nq();
    let mut columns = Vec::new();
    for (k, name) in q_names.iter().enumerate() {
        // Where the robot is does not matter, only how it is turned.
        let needed = k >= base_nq || name.starts_with("base/orientation");
        match table.column(name) {
            None if needed => return Err(lacking(name)),
            found => columns.push(found),
        }
    }
    if q_names[..base_nq].iter().any(|name| table.column(name).is_none()) {
        assumptions.push("no base/position columns: where the robot is plays no part".to_owned());
    }
    let velocities: Vec<&[f64]> = v_names
        .iter()
        .map(|name| table.column(&format!("{name}/before")).ok_or_else(|| lacking(&format!("{name}/before"))))
        .collect::<Result<_, _>>()?;
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for i in 0..table.rows() {
        let mut row: Vec<f64> = columns.iter().map(|c| c.map_or(0.0, |c| c[i])).collect();
        let mut rate: Vec<f64> = velocities.iter().map(|c| c[i]).collect();
        if robot.layout.base == BaseKind::Floating {
            normalise(&mut row[..base_nq]).ok_or_else(|| {
                Diagnostic::error("base/orientation is no rotation: its quaternion is zero")
                    .at(table.lines[i], 0)
            })?;
            let base = rotate_to_base([row[3], row[4], row[5], row[6]], [rate[0], rate[1], rate[2]]);
            rate[..3].copy_from_slice(&base);
        }
        q.extend(row);
        v.extend(rate);
    }
    Ok((q, v))
}

/// Velocities after (`impacts × nv`, zero where not measured) and the rows that are.
fn results(table: &Table, v_names: &[String]) -> Result<(Vec<f64>, Vec<usize>), Diagnostic> {
    let columns: Vec<Option<&[f64]>> = v_names.iter().map(|n| table.column(&format!("{n}/after"))).collect();
    let measured: Vec<usize> = (0..columns.len()).filter(|k| columns[*k].is_some()).collect();
    if measured.is_empty() {
        return Err(lacking(&format!("{}/after", v_names[v_names.len() - 1])));
    }
    let rows = 0..table.rows();
    Ok((rows.flat_map(|i| columns.iter().map(move |c| c.map_or(0.0, |c| c[i]))).collect(), measured))
}

fn lacking(name: &str) -> Diagnostic {
    Diagnostic::error(format!("the table has no column `{name}`"))
        .at(1, 0)
        .help("an impact needs the configuration and all velocities before and after it")
}

impl ImpactExperiment<'_> {
    fn finish(&mut self) {
        self.residual = self.residual_under(&[]);
        let nominal = self.nominal();
        let gradients: Vec<DMatrix<f64>> = (0..self.number.len())
            .map(|i| {
                let mut gradient = self.gradient(i, &nominal);
                for mut column in gradient.column_iter_mut() {
                    let logged = self.logged(i, &column.clone_owned());
                    column.copy_from(&logged);
                }
                gradient
            })
            .collect();
        self.inertial = self.measured.iter().map(|&k| sparse(&gradients, k)).collect();
        let noise = self.noise(&nominal);
        self.rows.iter_mut().zip(noise).for_each(|(row, noise)| row.noise = noise);
    }

    /// Noise of the rows: all velocities are taken to be equally noisy (σ), those before come in through the map.
    ///
    /// Whatever the law of the contact, it changes velocities in the directions `M⁻¹ Jᵀ` only. What the residual has
    /// in the other directions is noise (and errors of the inertia, which make the estimate too large).
    fn noise(&self, nominal: &Changed) -> Vec<f64> {
        let (nv, all) = (self.calls.nv, self.measured.len() == self.calls.nv);
        let (mut square, mut expected) = (0.0, 0.0);
        let mut spread = vec![0.0; nv];
        for i in 0..self.number.len() {
            let Some((map, reach)) = self.projection(i, nominal) else { continue };
            let covariance = DMatrix::identity(nv, nv) + &map * map.transpose();
            spread.iter_mut().enumerate().for_each(|(k, s)| *s += covariance[(k, k)]);
            let basis = reach.qr().q();
            let other = DMatrix::identity(nv, nv) - &basis * basis.transpose();
            let residual = DVector::from_fn(nv, |k, _| self.residual_at(k, i));
            // In the base's axes, as `map` is; the length of a turned vector is the same.
            let residual = self.in_base(i, residual);
            square += (&other * residual).norm_squared();
            expected += (&other * covariance * &other).trace();
        }
        let count = self.number.len() as f64;
        let plain = |k: usize| (self.residual[k].iter().map(|r| r * r).sum::<f64>() / count).sqrt();
        let sigma = if all && expected > 0.0 { (square / expected).sqrt() } else { f64::INFINITY };
        let rows = self.measured.iter().enumerate();
        rows.map(|(r, &k)| (sigma * (spread[k] / count).sqrt()).min(plain(r)).max(SMALLEST)).collect()
    }

    fn residual_at(&self, k: usize, i: usize) -> f64 {
        self.measured.iter().position(|m| *m == k).map_or(0.0, |row| self.residual[row][i])
    }

    /// From the table's coordinates to the model's.
    fn in_base(&self, i: usize, mut v: DVector<f64>) -> DVector<f64> {
        if self.robot.layout.base == BaseKind::Floating {
            let q = &self.q[i * self.calls.nq..];
            let base = rotate_to_base([q[3], q[4], q[5], q[6]], [v[0], v[1], v[2]]);
            v.as_mut_slice()[..3].copy_from_slice(&base);
        }
        v
    }
}

fn sparse(gradients: &[DMatrix<f64>], row: usize) -> Inertial {
    let width = gradients.first().map_or(0, DMatrix::ncols);
    let matters = |k: &usize| gradients.iter().any(|g| g[(row, *k)].abs() > 1e-12);
    let columns: Vec<usize> = (0..width).filter(matters).collect();
    let values = gradients.iter().flat_map(|g| columns.iter().map(|k| g[(row, *k)])).collect();
    Inertial { columns, values }
}
