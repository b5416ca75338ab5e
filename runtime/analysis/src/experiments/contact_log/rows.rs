//! Rows, residuals, derivatives by inertial parameters, and noise.
use super::effects::Change;
use super::foot::SIGNALS;
use super::predict::BaseWrench;
use super::{ContactExperiment, ContactRecording};
use crate::experiments::memo::Memo;
use crate::experiments::{Channel, Inertial, Row};
use crate::log::{Log, Reader};
use crate::measure::Options;
use crate::robot::Robot;
use crate::robot::calls::{ModelCalls, base_rows, gravity};
use crate::robot::feet::FootCalls;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use nalgebra::{Matrix3, Vector3};

/// Samples at which the noise's way through the model is computed.
pub(super) const NOISE_SAMPLES: usize = 16;
/// Part of the weight that the feet must carry for a centre of pressure.
pub(super) const LOADED: f64 = 0.05;
/// Smallest noise that is believed, N, N m; m for centres of pressure.
const SMALLEST: [f64; 2] = [1e-4, 1e-6];

/// Part of the noise that counts in a misfit.
const NOISE: f64 = 0.25;
/// Half the error, as a difference of logarithms of squares.
pub(super) const CLEARLY: f64 = 2.0 * std::f64::consts::LN_2;

/// What a row is, with its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    Force(usize),
    Moment(usize),
    Pressure(usize),
}

/// Where moments are taken to find a centre of pressure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground {
    pub axes: Matrix3<f64>,
    pub origin: Vector3<f64>,
    pub height: f64,
    /// Whether the feet carry enough for a centre of pressure.
    pub loaded: bool,
}

impl Ground {
    /// Centre of pressure x, y in world axes, m: where the moment has no horizontal part.
    pub fn pressure(&self, wrench: &BaseWrench) -> [f64; 2] {
        let (f, n, p) = (wrench.force, self.axes * wrench.moment, self.origin);
        let above = p.z - self.height;
        [p.x - (n.y + above * f.x) / f.z, p.y + (n.x - above * f.y) / f.z]
    }

    /// How it changes with the wrench.
    fn pressure_rate(&self, wrench: &BaseWrench, rate: &BaseWrench) -> [f64; 2] {
        let (f, n, above) = (rate.force, self.axes * rate.moment, self.origin.z - self.height);
        let [x, y] = self.pressure(wrench);
        let (x, y) = (x - self.origin.x, y - self.origin.y);
        let total = wrench.force.z;
        [-(n.y + above * f.x + x * f.z) / total, (n.x - above * f.y - y * f.z) / total]
    }
}

impl Component {
    fn of(self, wrench: &BaseWrench, ground: &Ground) -> f64 {
        match self {
            Self::Force(axis) => wrench.force[axis],
            Self::Moment(axis) => wrench.moment[axis],
            Self::Pressure(_) if !ground.loaded => 0.0,
            Self::Pressure(axis) => ground.pressure(wrench)[axis],
        }
    }

    fn rate(self, wrench: &BaseWrench, rate: &BaseWrench, ground: &Ground) -> f64 {
        match self {
            Self::Force(axis) => rate.force[axis],
            Self::Moment(axis) => rate.moment[axis],
            Self::Pressure(_) if !ground.loaded => 0.0,
            Self::Pressure(axis) => ground.pressure_rate(wrench, rate)[axis],
        }
    }

    fn row(self) -> Row {
        let (channel, unit, what, axis) = match self {
            Self::Force(axis) => (Channel::BaseForce, "N", "base/force", axis),
            Self::Moment(axis) => (Channel::BaseMoment, "N m", "base/moment", axis),
            Self::Pressure(axis) => (Channel::Cop, "m", "cop", axis),
        };
        Row { name: format!("{what}/{}", ["x", "y", "z"][axis]), channel, unit, joint: None, noise: 1.0 }
    }
}

impl<'a> ContactExperiment<'a> {
    /// Reads a log; see [`ContactRecording::read`]. About six samples per period of the cut-off count. It is cut at impacts unless it
    /// fits clearly better as a whole: feet that slip and stick make small jumps whose forces were measured.
    ///
    /// # Errors
    /// As [`ContactRecording::read`], and a model that lacks functions or is another robot's.
    pub fn read(robot: Robot<'a>, log: &Log, options: &Options) -> Result<Self, Diagnostics> {
        let cut = Self::from_reader(robot, log.rows(), options)?;
        if !cut.recording.is_cut_at_impacts() {
            return Ok(cut);
        }
        let options = Options { cut_at_impacts: false, ..options.clone() };
        let whole = Self::from_reader(robot, log.rows(), &options)?;
        Ok(if whole.fits_clearly_better_than(&cut) { whole } else { cut })
    }

    /// Whether the rows of the base have half the other's error.
    pub(super) fn fits_clearly_better_than(&self, other: &Self) -> bool {
        self.misfit() < other.misfit() - CLEARLY
    }

    /// Logarithm of the mean squares of the base's rows. Fits suffer from what is wrong in all samples alike; noise averages out, so that
    /// only a part of it counts.
    pub fn misfit(&self) -> f64 {
        misfit(self.rows.iter().zip(&self.residual).take(self.kinds.len()))
    }

    /// The same from any source.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_reader(robot: Robot<'a>, reader: Reader, options: &Options) -> Result<Self, Diagnostics> {
        let file = reader.file().to_path_buf();
        let recording = ContactRecording::from_reader(&robot, reader, options, None)?;
        Self::new(robot, recording).map_err(|e| Diagnostics(vec![e.in_file(&file)]))
    }

    /// From a recording of this robot.
    ///
    /// # Errors
    /// A model that lacks functions or is another robot's.
    pub fn new(robot: Robot<'a>, recording: ContactRecording) -> Result<Self, Diagnostic> {
        let calls = ModelCalls::new(robot.model);
        let parameters = robot.link_inertias.parameters();
        let mass: f64 = parameters.mass();
        let kinds = kinds(&robot, &recording);
        let mut experiment = Self {
            feet: robot.feet.iter().map(|foot| FootCalls::new(&calls, foot)).collect::<Result<_, _>>()?,
            inverse_dynamics: calls.find("inverse_dynamics")?,
            regressor: calls.find("inverse_dynamics_regressor")?,
            gravity: gravity(&calls, robot.layout.base, mass)?,
            rows: kinds.iter().map(|kind| kind.row()).collect(),
            robot,
            calls,
            recording,
            parameters,
            kinds,
            time: Vec::new(),
            residual: Vec::new(),
            inertial: Vec::new(),
            soles: Vec::new(),
            stances: Vec::new(),
            under: Memo::new(0),
        };
        if calls.columns(experiment.regressor) != experiment.parameters.len() {
            return Err(Diagnostic::error("the model's `inverse_dynamics_regressor` is of another robot"));
        }
        let nominal = experiment.change(&[]);
        experiment.time = experiment.recording.pick(&experiment.recording.time);
        experiment.residual = experiment.residual_under(&nominal);
        experiment.inertial = experiment.derivatives(&nominal);
        let noise = experiment.noise(&nominal);
        experiment.rows.iter_mut().zip(noise).for_each(|(row, noise)| row.noise = noise);
        experiment.add_soles();
        experiment.under = Memo::new(experiment.residual.iter().map(Vec::len).sum());
        Ok(experiment)
    }

    pub(super) fn samples(&self) -> usize {
        self.recording.time.len()
    }

    pub(super) fn ground(&self, i: usize, change: &Change) -> Ground {
        let [q, ..] = self.kinematics(i, change);
        let carried: f64 = self.recording.feet.iter().filter_map(|f| f.signals.get(i)).map(|s| s[2]).sum();
        Ground {
            axes: self.base_axes(&q),
            origin: self.base_origin(&q),
            height: self.ground_height(i, change),
            loaded: carried > LOADED * self.parameters.mass() * self.gravity.norm(),
        }
    }

    /// What was measured of a row, at the samples that count.
    pub(super) fn reported_row(&self, row: usize) -> Vec<f64> {
        let nominal = self.change(&[]);
        let value = |i| self.kinds[row].of(&self.reported(i, &nominal), &self.ground(i, &nominal));
        self.recording.smooth(&(0..self.samples()).map(value).collect::<Vec<_>>())
    }

    /// Measured minus predicted, all rows of the base, under a change; at the samples that count.
    pub(super) fn residual_under(&self, change: &Change) -> Vec<Vec<f64>> {
        let mut rows = vec![Vec::with_capacity(self.samples()); self.kinds.len()];
        let simpler = change.level.is_simpler().then(|| self.simpler(change));
        for i in 0..self.samples() {
            let needed = match &simpler {
                Some(needed) => needed[i],
                None => self.needed(&self.moved_state(i, change), change),
            };
            let reported = self.reported(i, change);
            let ground = self.ground(i, change);
            let mut residual: Vec<f64> = self
                .kinds
                .iter()
                .map(|kind| kind.of(&reported, &ground) - kind.of(&needed, &ground))
                .collect();
            self.add_missing(i, change, &reported, &ground, &mut residual);
            rows.iter_mut().zip(residual).for_each(|(row, residual)| row.push(residual));
        }
        rows.iter().map(|row| self.recording.smooth(row)).collect()
    }

    /// Adds the forces that saturated sensors did not report, as far as they make the residual smaller.
    fn add_missing(
        &self,
        i: usize,
        change: &Change,
        reported: &BaseWrench,
        ground: &Ground,
        residual: &mut [f64],
    ) {
        let places = if change.limits.is_empty() { Vec::new() } else { self.missing_forces(i, change) };
        if places.is_empty() {
            return;
        }
        let column = |(foot, at): &(usize, Vector3<f64>)| -> Vec<f64> {
            let unit = self.unit_normal(i, *foot, at, change);
            self.kinds.iter().map(|kind| kind.rate(reported, &unit, ground)).collect()
        };
        let columns: Vec<Vec<f64>> = places.iter().map(column).collect();
        let weights: Vec<f64> = self.rows.iter().map(|row| row.noise.powi(-2)).collect();
        let product = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(&weights).map(|((a, b), w)| a * b * w).sum()
        };
        let mut forces = vec![0.0; columns.len()];
        // One force after the other, until all fit: two or three rounds do, since few sensors saturate at a time.
        for _ in 0..8 {
            for (force, column) in forces.iter_mut().zip(&columns) {
                let size = product(column, column);
                let step = if size > 0.0 { -product(column, residual) / size } else { 0.0 };
                let more = step.max(-*force);
                *force += more;
                residual.iter_mut().zip(column).for_each(|(r, c)| *r += more * c);
            }
        }
    }

    /// Derivatives of the predicted rows by the inertial parameters.
    fn derivatives(&self, change: &Change) -> Vec<Inertial> {
        let (nv, width) = (self.calls.nv, self.parameters.len());
        let mut matters = vec![vec![false; width]; self.rows.len()];
        let mut all: Vec<Vec<f64>> = vec![Vec::new(); self.rows.len()];
        let mut regressor = vec![0.0; nv * width];
        let planar = self.robot.planar();
        for i in 0..self.samples() {
            let state = self.logged_state(i);
            let axes = self.base_axes(&state[0]);
            let needed = self.needed(&state, change);
            let ground = self.ground(i, change);
            let [q, v, a] = self.true_state(&state, change);
            self.calls.moving(self.regressor, &q, &v, &a, &mut regressor);
            for (k, column) in regressor.chunks_exact(nv).enumerate() {
                let mut rate = self.base_wrench(column, &axes);
                if planar {
                    rate.force = change.world.tilt.transpose() * rate.force;
                }
                for (row, kind) in self.kinds.iter().enumerate() {
                    let value = kind.rate(&needed, &rate, &ground);
                    matters[row][k] |= value.abs() > 1e-12;
                    all[row].push(value);
                }
            }
        }
        all.into_iter()
            .zip(matters)
            .map(|(values, matters)| {
                let columns: Vec<usize> = (0..width).filter(|k| matters[*k]).collect();
                let column = |k: &usize| values.iter().skip(*k).step_by(width).copied().collect::<Vec<f64>>();
                let smooth: Vec<Vec<f64>> =
                    columns.iter().map(|k| self.recording.smooth(&column(k))).collect();
                let rows = 0..self.time.len();
                Inertial { columns, values: rows.flat_map(|i| smooth.iter().map(move |c| c[i])).collect() }
            })
            .collect()
    }

    /// One standard deviation per row, from the noise of forces and of accelerations.
    fn noise(&self, change: &Change) -> Vec<f64> {
        let stride = (self.samples() / NOISE_SAMPLES).max(1);
        let at: Vec<usize> = (0..self.samples()).step_by(stride).collect();
        let mut sums = vec![0.0; self.rows.len()];
        for &i in &at {
            let ground = self.ground(i, change);
            let needed = self.needed(&self.logged_state(i), change);
            let mut add = |rate: &BaseWrench, sigma: f64| {
                for (sum, kind) in sums.iter_mut().zip(&self.kinds) {
                    *sum += (kind.rate(&needed, rate, &ground) * sigma).powi(2);
                }
            };
            self.force_noise(i, change, &mut add);
            self.acceleration_noise(i, change, &mut add);
        }
        let rows = sums.iter().zip(&self.kinds);
        rows.map(|(sum, kind)| {
            let smallest = SMALLEST[usize::from(matches!(kind, Component::Pressure(_)))];
            (sum / at.len() as f64).sqrt().max(smallest)
        })
        .collect()
    }

    /// Visits what a unit of each foot signal does to the base, with the signal's noise.
    fn force_noise(&self, i: usize, change: &Change, add: &mut impl FnMut(&BaseWrench, f64)) {
        let gain = self.recording.noise_gain().sqrt();
        let [q, ..] = self.kinematics(i, change);
        let axes = self.base_axes(&q);
        for (foot, record) in self.recording.feet.iter().enumerate().filter(|(_, r)| r.is_logged) {
            for k in (0..12).filter(|k| record.noise[*k] > 0.0) {
                let mut unit = [0.0; SIGNALS];
                unit[k] = 1.0;
                let one = |f: usize, sole: &_| {
                    if f == foot { record.wrench(sole, &unit) } else { (Vector3::zeros(), Vector3::zeros()) }
                };
                let tau = super::forces::mapped(
                    &self.robot,
                    &self.calls,
                    &self.feet,
                    &q,
                    &self.recording.logged(),
                    one,
                );
                add(&self.base_wrench(&tau, &axes), record.noise[k] * gain);
            }
        }
    }

    /// Visits what a unit of each acceleration needs of the base: columns of the mass matrix.
    fn acceleration_noise(&self, i: usize, change: &Change, add: &mut impl FnMut(&BaseWrench, f64)) {
        let state = self.logged_state(i);
        let axes = self.base_axes(&state[0]);
        let needed = self.needed(&state, change);
        let floating = base_rows(self.robot.layout.base).len() == 6;
        let noise = self.recording.acceleration_noise();
        for (k, sigma) in noise.iter().enumerate().filter(|(_, s)| **s > 0.0) {
            let mut faster = state.clone();
            if floating && k < 3 {
                // Logged in world axes, wanted in those of the base.
                let part = axes.row(k);
                faster[2].iter_mut().zip(part.iter()).for_each(|(a, p)| *a += p);
            } else {
                faster[2][k] += 1.0;
            }
            let more = self.needed(&faster, change);
            let rate = BaseWrench { force: more.force - needed.force, moment: more.moment - needed.moment };
            add(&rate, *sigma);
        }
    }
}

/// Logarithm of the mean squares of rows beyond their noise, mean of the rows.
pub(super) fn misfit<'r>(rows: impl ExactSizeIterator<Item = (&'r Row, &'r Vec<f64>)>) -> f64 {
    let count = rows.len().max(1) as f64;
    let of_row = |(row, residual): (&Row, &Vec<f64>)| {
        let square = residual.iter().map(|x| x * x).sum::<f64>() / residual.len().max(1) as f64;
        let noise = row.noise.powi(2);
        ((square - noise).max(0.0) + NOISE * noise).max(f64::MIN_POSITIVE).ln()
    };
    rows.map(of_row).sum::<f64>() / count
}

/// Which rows the log allows.
fn kinds(robot: &Robot<'_>, recording: &ContactRecording) -> Vec<Component> {
    let planar = robot.planar();
    let logged = || recording.feet.iter().filter(|foot| foot.is_logged);
    if recording.standing.is_some() {
        let force = !logged().any(|foot| foot.from_corners) && logged().all(|foot| foot.columns.has_force());
        let torque = force && logged().all(|foot| foot.columns.has_torque(false));
        let mut rows = vec![Component::Force(2), Component::Moment(0), Component::Moment(1)];
        rows.extend(force.then_some([Component::Force(0), Component::Force(1)]).into_iter().flatten());
        rows.extend(torque.then_some(Component::Moment(2)));
        return rows;
    }
    if logged().any(|foot| foot.from_corners) {
        let rows = [Component::Force(2), Component::Pressure(0), Component::Pressure(1)];
        return rows[..if planar { 2 } else { 3 }].to_vec();
    }
    let torques = logged().all(|foot| foot.columns.has_torque(planar));
    let rows: &[Component] = match (planar, torques) {
        (true, _) => &[Component::Force(0), Component::Force(2), Component::Moment(1)],
        (false, true) => &[
            Component::Force(0),
            Component::Force(1),
            Component::Force(2),
            Component::Moment(0),
            Component::Moment(1),
            Component::Moment(2),
        ],
        (false, false) => &[
            Component::Force(0),
            Component::Force(1),
            Component::Force(2),
            Component::Moment(0),
            Component::Moment(1),
        ],
    };
    rows.to_vec()
}
