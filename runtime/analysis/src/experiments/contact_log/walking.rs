//! Joint torques of a robot on its feet, beside the rows of its base.
//!
//! A joint's row is the logged effort minus `(D q̈ + H − Jᵀ w)`: inverse dynamics under the forces that the feet report.
//! Effort, motion and forces passed the same zero-phase filter, and all rows pass it once more. A moment about the
//! vertical that a foot does not log is eliminated: see `unlogged`.
use super::effects::spares_contact;
use super::rows::{CLEARLY, misfit};
use super::unlogged::Elimination;
use super::{ContactExperiment, ContactRecording};
use crate::experiments::memo::Memo;
use crate::experiments::motion::{Hidden, OnGround};
use crate::experiments::{Channel, Experiment, Inertial, MotionExperiment, Row};
use crate::log::Log;
use crate::measure::{JointPositions, Missing, Options, Recording};
use crate::robot::InertialParameters;
use crate::robot::LinkInertias;
use crate::robot::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::{Acts, Effect, Kind, Law, Location};
use std::sync::{Arc, OnceLock};

/// The filter of the rows smears what happens at an instant over this part of a period of its cut-off.
const SMEARED: f64 = 0.25;

/// A log of a free robot with foot forces and joint efforts: base rows first, then joints.
pub struct WalkingExperiment<'a> {
    base: ContactExperiment<'a>,
    joints: MotionExperiment<'a>,
    /// Of unknown moments about the vertical from the rows of `joints`.
    elimination: Elimination,
    /// Joint of each row of `joints`.
    joint_of: Vec<Option<usize>>,
    /// Rows of `joints` that are rows here.
    shown: Vec<usize>,
    rows: Vec<Row>,
    /// Of every joint's row the part of its noise that is in its signals too.
    in_signals: Vec<f64>,
    /// Of the joints' rows, at the samples that count.
    residual: Vec<Vec<f64>>,
    /// Where their joints stick, at the samples that count.
    sticks: Vec<Vec<bool>>,
    inertial: OnceLock<Vec<Option<Inertial>>>,
    /// What the effects that were asked for last make of the robot on the ground.
    on_ground: Memo<OnGround>,
    /// Joints without a row, and why.
    pub missing: Vec<Missing>,
}

impl<'a> WalkingExperiment<'a> {
    /// Reads a log as [`ContactExperiment::read`]; joints without an effort have no row.
    ///
    /// # Errors
    /// As [`ContactExperiment::read`].
    pub fn read(robot: Robot<'a>, log: &Log, options: &Options) -> Result<Self, Diagnostics> {
        let new = |base| Self::new(base).map_err(|e| Diagnostics(vec![e.in_file(log.path())]));
        let read = |cut_at_impacts: bool| {
            let options = Options { cut_at_impacts, ..options.clone() };
            ContactExperiment::from_reader(robot, log.rows(), &options)
        };
        if !options.cut_at_impacts {
            return new(read(false)?);
        }
        let cut = read(true)?;
        if !cut.recording.is_cut_at_impacts() {
            return new(cut);
        }
        let whole = read(false)?;
        if !whole.fits_clearly_better_than(&cut) {
            return new(cut);
        }
        // Efforts are those of an instant where forces are means: what a slap does to the joints may be wrong where the base is right.
        let (whole, cut) = (new(whole)?, new(cut)?);
        Ok(if whole.joint_misfit() < cut.joint_misfit() + CLEARLY { whole } else { cut })
    }

    /// Logarithm of the mean squares of the joints' rows, see [`ContactExperiment::misfit`].
    fn joint_misfit(&self) -> f64 {
        let rows = self.rows[self.first()..].iter().zip(&self.residual);
        let efforts: Vec<_> = rows.filter(|(row, _)| row.channel == Channel::Effort).collect();
        misfit(efforts.into_iter())
    }

    /// From the rows of the base.
    ///
    /// # Errors
    /// A model that lacks functions or is another robot's.
    pub fn new(base: ContactExperiment<'a>) -> Result<Self, Diagnostic> {
        let robot = base.robot;
        let nominal = base.change(&[]);
        let mut motion = base.recording.joint_motion();
        let (elimination, missing) = base.unlogged(&mut motion);
        let ground = base.ground_forces(&nominal);
        let ground_values = ground.len();
        // The effects on masses are in the joints' rows as in those of the base.
        let joints = MotionExperiment::on_ground(
            robot.model,
            robot.layout,
            robot.link_inertias,
            motion,
            robot.effects,
            ground,
        )?;
        let of_joint =
            |name: &Option<String>| robot.layout.joints.iter().position(|j| Some(&j.name) == name.as_ref());
        let joint_of: Vec<Option<usize>> = joints.rows().iter().map(|row| of_joint(&row.joint)).collect();
        let is_effort = |row: usize| joints.rows()[row].channel == Channel::Effort;
        let tells = |row: &usize| {
            is_effort(*row) && joint_of[*row].is_some_and(|joint| elimination.pivots.contains(&joint))
        };
        let shown: Vec<usize> = (0..joint_of.len()).filter(|row| !tells(row)).collect();
        let noise = base.joint_noise(&nominal, &elimination);
        let mut rows = base.rows().to_vec();
        rows.extend(shown.iter().map(|row| joints.rows()[*row].clone()));
        for row in rows.iter_mut().filter(|row| row.channel == Channel::Effort) {
            if let Some(joint) = of_joint(&row.joint) {
                row.noise = noise[joint][0].max(1e-9);
            }
        }
        let in_signals = |row: &Row| of_joint(&row.joint).map_or(0.0, |joint| noise[joint][1]);
        let in_signals = rows.iter().skip(base.rows().len()).map(in_signals).collect();
        let mut this = Self {
            base,
            joints,
            joint_of,
            elimination,
            shown,
            rows,
            in_signals,
            residual: Vec::new(),
            sticks: Vec::new(),
            inertial: OnceLock::new(),
            on_ground: Memo::new(2 * ground_values),
            missing,
        };
        this.find_described();
        this.residual = this.rest(|row| Some(this.joints.residual(row)));
        this.sticks = this.shown.iter().map(|row| this.sticking(this.joints.sticks(*row))).collect();
        Ok(this)
    }

    /// Links behind their motors under these effects and those of the description.
    fn behind_motors(&self, effects: &[Effect]) -> Vec<Hidden> {
        let forces = |behind: &[Hidden]| {
            let change = self.base.change(effects).with_links(behind.to_vec());
            self.base.ground_forces(&change)
        };
        self.joints.behind_motors(&self.base.robot.with(effects), &forces)
    }

    /// Puts links that the description has behind their motors where they are.
    fn find_described(&mut self) {
        let behind = self.behind_motors(&[]);
        if behind.is_empty() {
            return;
        }
        let change = self.base.change(&[]).with_links(behind);
        self.base.residual = self.base.residual_under(&change);
        let soles = self.base.sole_residuals(&change);
        self.base.residual.extend(soles);
        let forces = self.base.ground_forces(&change);
        self.joints.find_residuals(Some(&OnGround::new(forces, change.behind)));
    }

    /// Which joints lay at their stops, if any did: their rows leave those samples out.
    pub fn at_stops(&self) -> Option<String> {
        self.base.recording.stops.words(self.base.robot.layout)
    }

    /// The rows of the base.
    pub fn base(&self) -> &ContactExperiment<'a> {
        &self.base
    }

    fn first(&self) -> usize {
        self.base.rows.len()
    }

    /// Whether a row of `joints` is an effort, and no angle between motor and link.
    fn is_effort(&self, row: usize) -> bool {
        self.joints.rows()[row].channel == Channel::Effort
    }

    /// The row of `joints` with a joint's effort.
    fn effort_row(&self, joint: usize) -> Option<usize> {
        (0..self.joint_of.len()).find(|&row| self.joint_of[row] == Some(joint) && self.is_effort(row))
    }

    /// Where a joint's row has to do with a joint that sticks, at the samples that count: the rows pass the filter once more.
    fn sticking(&self, flags: &[bool]) -> Vec<bool> {
        let recording = &self.base.recording;
        let reach = (SMEARED / (recording.cutoff_hz * recording.step)).ceil() as usize;
        let beside = |i: usize| {
            let around = i.saturating_sub(reach)..(i + reach + 1).min(flags.len());
            flags[around].contains(&true)
        };
        if flags.is_empty() { Vec::new() } else { recording.kept.iter().map(|i| beside(*i)).collect() }
    }

    /// What is left of the rows shown here, of values by row of `joints` (`None`: zeros), through the filter.
    fn rest<'v>(&self, values: impl Fn(usize) -> Option<&'v [f64]>) -> Vec<Vec<f64>> {
        let pivot = |joint: usize| values(self.effort_row(joint)?);
        let moments = self.elimination.pivots.iter().any(|joint| pivot(*joint).is_some());
        let of_row = |row: &usize| {
            let own = values(*row).map(<[f64]>::to_vec);
            if !self.is_effort(*row) {
                // Angles are held against each other as they were logged.
                return own
                    .map_or_else(|| vec![0.0; self.base.time.len()], |own| self.base.recording.pick(&own));
            }
            if own.is_none() && !moments {
                return vec![0.0; self.base.time.len()];
            }
            let own = own.unwrap_or_else(|| vec![0.0; self.base.samples()]);
            let rest = match self.joint_of[*row] {
                Some(joint) => self.elimination.rest(joint, own, pivot),
                None => own,
            };
            self.base.recording.smooth(&rest)
        };
        self.shown.iter().map(of_row).collect()
    }

    /// Derivatives of the joints' rows through elimination and filter, like the rows themselves.
    fn joint_inertial(&self) -> Vec<Option<Inertial>> {
        let has = |row: usize, column: usize| {
            let inertial = self.joints.inertial(row)?;
            let place = inertial.columns.iter().position(|c| *c == column)?;
            Some(inertial.values.iter().skip(place).step_by(inertial.columns.len()).copied().collect())
        };
        let all: Vec<Vec<Option<Vec<f64>>>> = (0..self.inertial_count())
            .map(|column| (0..self.joint_of.len()).map(|row| has(row, column)).collect())
            .collect();
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); self.shown.len()];
        let mut values: Vec<Vec<Vec<f64>>> = vec![Vec::new(); self.shown.len()];
        for (column, by_row) in
            all.iter().enumerate().filter(|(_, by_row)| by_row.iter().any(Option::is_some))
        {
            let rest = self.rest(|row| by_row[row].as_deref());
            for (row, rest) in rest.into_iter().enumerate().filter(|(_, rest)| rest.iter().any(|x| *x != 0.0))
            {
                columns[row].push(column);
                values[row].push(rest);
            }
        }
        let of_row = |(columns, values): (Vec<usize>, Vec<Vec<f64>>)| {
            let samples = 0..self.base.time.len();
            let values = samples.flat_map(|i| values.iter().map(move |c| c[i])).collect();
            Some(Inertial { columns, values })
        };
        columns.into_iter().zip(values).map(of_row).collect()
    }

    fn joint_response(&self, effects: &[Effect], behind: Vec<Hidden>) -> Vec<(usize, Vec<f64>)> {
        let all = self.base.robot.with(effects);
        let at_feet = |effect: &Effect| {
            matches!(effect.kind.law, Law::EncoderOffset | Law::ForceSensorBias | Law::ForceSensorGain)
        };
        let changes = effects.iter().any(at_feet) || !behind.is_empty();
        let as_motors = behind.is_empty();
        let made = || {
            let change = self.base.change(effects).with_links(behind);
            OnGround::new(self.base.ground_forces(&change), change.behind)
        };
        // Bodies are another matter than where they are; where links move behind their motors, all that acts moves them.
        let matters = |effect: &Effect| !spares_contact(effect) && effect.kind.law.acts() != Acts::Body;
        let ground = changes.then(|| match as_motors {
            true => self.on_ground.of(effects, matters, made),
            false => Arc::new(made()),
        });
        let rows = if changes { (0..self.joint_of.len()).collect() } else { self.joints.touched(effects) };
        let mut responses: Vec<Option<Vec<f64>>> = vec![None; self.joint_of.len()];
        for (row, changed) in self.joints.residuals(&all, &rows, ground.as_deref()) {
            let nominal = self.joints.residual(row);
            responses[row] = Some(nominal.iter().zip(changed).map(|(nominal, x)| nominal - x).collect());
        }
        self.rest(|row| responses[row].as_deref())
            .into_iter()
            .enumerate()
            .map(|(k, x)| (self.first() + k, x))
            .collect()
    }
}

impl ContactRecording {
    /// All samples as a log of efforts, which passed the filter here.
    fn joint_motion(&self) -> Recording {
        Recording {
            time: self.time.clone(),
            segments: self.segments.clone(),
            trajectory: self.trajectory.clone(),
            effort: self.effort.clone(),
            transmission: self.transmission.clone(),
            motors: self.motors.clone(),
            motor_side: self.motor_side.clone(),
            step: self.step,
            cutoff_hz: self.cutoff_hz,
            noise: self.effort_noise.clone(),
            stops: self.stops.clone(),
            ..Recording::default()
        }
    }
}

impl Experiment for WalkingExperiment<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        self.base.time()
    }
    fn residual(&self, row: usize) -> &[f64] {
        match row.checked_sub(self.first()) {
            Some(joint) => &self.residual[joint],
            None => self.base.residual(row),
        }
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        match row.checked_sub(self.first()) {
            Some(row) => {
                let (row, recording) = (self.shown[row], &self.base.recording);
                let values = self.joints.measured(row)?;
                Some(if self.is_effort(row) { recording.smooth(&values) } else { recording.pick(&values) })
            }
            None => self.base.measured(row),
        }
    }
    fn sticks(&self, row: usize) -> &[bool] {
        row.checked_sub(self.first()).map_or(&[], |joint| &self.sticks[joint])
    }
    fn described(&self) -> &[Effect] {
        self.joints.described()
    }
    fn noise_in_signals(&self, row: usize) -> f64 {
        match row.checked_sub(self.first()) {
            Some(joint) => self.in_signals[joint],
            None => self.base.noise_in_signals(row),
        }
    }
    fn smeared(&self) -> usize {
        // The joints' own in samples of the log, of which not all count.
        self.joints.smeared().div_ceil(self.base.recording.spacing())
    }
    fn crossings(&self, effects: &[Effect]) -> Vec<bool> {
        let behind = self.behind_motors(effects);
        let between = |i: &usize| behind.iter().any(|link| link.is_between_stops(*i));
        let flags: Vec<bool> = self.base.recording.kept.iter().map(between).collect();
        if flags.contains(&true) { flags } else { Vec::new() }
    }
    fn beside_impacts(&self) -> f64 {
        self.base.beside_impacts()
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let behind = self.behind_motors(effects);
        let mut out = self.base.response_with(effects, behind.clone());
        let joints = self.joint_response(effects, behind).into_iter();
        out.extend(joints.filter(|(_, values)| values.iter().any(|x| *x != 0.0)));
        out
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        let mut out = self.base.candidates();
        for candidate in self.joints.candidates() {
            if !out.contains(&candidate) {
                out.push(candidate);
            }
        }
        out
    }
    fn guess(&self, kind: &'static Kind, place: &Location) -> Option<Effect> {
        self.base.guess(kind, place)
    }
    fn inertial_count(&self) -> usize {
        self.base.inertial_count()
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        self.base.inertial_parameters()
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        match row.checked_sub(self.first()) {
            Some(joint) => self.inertial.get_or_init(|| self.joint_inertial())[joint].as_ref(),
            None => self.base.inertial(row),
        }
    }
    fn signals(&self, row: usize) -> Vec<(String, Vec<f64>)> {
        let Some(row) = row.checked_sub(self.first()) else { return self.base.signals(row) };
        let signals = self.joints.signals(self.shown[row]).into_iter();
        signals.map(|(name, values)| (name, self.base.recording.pick(&values))).collect()
    }
    fn signal(&self, row: usize, name: &str) -> Option<Vec<f64>> {
        let Some(row) = row.checked_sub(self.first()) else { return self.base.signal(row, name) };
        Some(self.base.recording.pick(&self.joints.signal(self.shown[row], name)?))
    }
    fn phases(&self) -> Vec<(String, Vec<bool>)> {
        self.base.phases()
    }
    fn slides(&self, place: &Location) -> Option<f64> {
        self.joints.slides(place)
    }
    fn heaviness(&self, place: &Location) -> f64 {
        self.joints.heaviness(place)
    }
    fn slowness(&self, place: &Location) -> [f64; 2] {
        self.joints.slowness(place)
    }
    fn small_load(&self, place: &Location) -> Option<f64> {
        self.joints.small_load(place)
    }
    fn seeds(&self, kind: &'static Kind, location: &Location) -> Option<Vec<f64>> {
        self.joints.seeds(kind, location)
    }
    fn check(&self) -> Vec<Diagnostic> {
        self.base.check()
    }
    fn duration(&self) -> Option<f64> {
        self.base.duration()
    }
    fn joints(&self) -> Vec<&str> {
        self.joints.joints()
    }
    fn motion(&self) -> JointPositions {
        self.base.motion()
    }
    fn link_inertias(&self) -> Option<&LinkInertias> {
        self.base.link_inertias()
    }
}
