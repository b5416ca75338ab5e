//! Joint torques as an [`Experiment`].
use super::columns::Columns;
use super::on_ground::OnGround;
use super::places;
use super::rigid::Rigid;
use super::under_effects::{Inertials, Turned};
use super::unseen;
use crate::experiments::data_checks::{self, clipped};
use crate::experiments::memo::Memo;
use crate::experiments::{Channel, Experiment, Inertial, Row};
use crate::measure::JointPositions;
use crate::measure::recording::Recording;
use crate::parallel::parallel;
use crate::robot::JointLayout;
use crate::robot::LinkInertias;
use crate::robot::inertial_parameters::body_of;
use crate::robot::{InertialParameters, Trajectory};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Kind, Law, Location, Starts};
use bipedc_runtime::model::Model;
use std::sync::OnceLock;

/// The filter of positions smears a jump of the acceleration over this part of a period of its cut-off, on either side.
const SMEARED: f64 = 0.5;

/// A log of joint torques against a rigid-body model with the effects that its description already has.
pub struct MotionExperiment<'a> {
    pub(super) rigid: Rigid<'a>,
    pub(super) layout: &'a JointLayout,
    pub(super) link_inertias: &'a LinkInertias,
    pub(super) recording: Recording,
    pub(super) present: Vec<Effect>,
    pub(super) rows: Vec<Row>,
    /// Joint of each row.
    pub(super) joint_of: Vec<usize>,
    /// Rigid-body torques, `samples × nv`, with the inertial effects of the description.
    pub(super) load: Vec<f64>,
    /// Forces of the ground, `samples × nv`; empty without.
    pub(super) ground: Vec<f64>,
    /// Formed when first asked for: most of the memory.
    pub(super) inertial: OnceLock<Vec<Option<Inertial>>>,
    pub(super) parameters: InertialParameters,
    residual: Vec<Vec<f64>>,
    /// What the rigid model needs under the turned joints that were asked for last.
    pub(super) turned: Memo<Turned>,
    /// How inertial parameters of some links enter there.
    pub(super) turned_inertial: Memo<Inertials>,
    /// Of each joint what its link resists with, see [`Rigid::resistance`]; formed when first asked for.
    pub(super) resistance: Vec<OnceLock<Vec<[f64; 2]>>>,
    /// Of each joint its column of the mass matrix, `samples × nv` (kg m², kg); formed when first asked for.
    pub(super) inertia: Vec<OnceLock<Vec<f64>>>,
    /// By joint, where it lies at a stop, which carries what is left there: nothing is. Empty where it never does.
    pub(super) at_stop: Vec<Vec<bool>>,
    /// Where the joint of a row sticks, see [`super::sticking`].
    sticks: OnceLock<Vec<Vec<bool>>>,
    /// By row, N m or N, see [`Experiment::motion_noise`].
    motion_noise: Vec<f64>,
    /// By row, N m or N, see [`Experiment::within_steps`].
    within_steps: Vec<[f64; 2]>,
    /// Of each joint whether its effort jumps where it turns about; found when first asked for.
    pub(super) jumps: Vec<OnceLock<bool>>,
    pub(super) columns: Vec<Columns>,
}

impl<'a> MotionExperiment<'a> {
    /// `present` are the effects of the description; `model` is the rigid robot without them, on a floating or
    /// planar base (or fixed: then nothing can be said of a tilt).
    ///
    /// # Errors
    /// The model lacks `inverse_dynamics` or `inverse_dynamics_regressor`, or is another robot's.
    pub fn new(
        model: &'a (dyn Model<f64> + Sync),
        layout: &'a JointLayout,
        link_inertias: &'a LinkInertias,
        recording: Recording,
        present: &[Effect],
    ) -> Result<Self, Diagnostic> {
        Self::on_ground(model, layout, link_inertias, recording, present, Vec::new())
    }

    /// The same with generalised forces of the ground on the robot, `Jᵀ w`, `samples × nv` (or empty: none): they are
    /// taken away from what the motion needs.
    pub(crate) fn on_ground(
        model: &'a (dyn Model<f64> + Sync),
        layout: &'a JointLayout,
        link_inertias: &'a LinkInertias,
        mut recording: Recording,
        present: &[Effect],
        ground: Vec<f64>,
    ) -> Result<Self, Diagnostic> {
        let rigid = Rigid::new(model)?;
        // On the ground its forces are taken away before.
        if ground.is_empty() {
            unseen::leave_out(&rigid, layout, &mut recording)?;
        }
        let joints = layout.joints.len();
        let fits =
            rigid.nv == layout.base.nv() + joints && rigid.parameters == 10 * link_inertias.bodies.len();
        if !fits {
            return Err(Diagnostic::error("the model and the description are of different robots"));
        }
        // Stops carry what the drive does not.
        let Recording { stops, time, cutoff_hz, .. } = &recording;
        let at_stop = (0..joints).map(|joint| stops.flags(joint, time, *cutoff_hz)).collect();
        let mut this = Self {
            rigid,
            at_stop,
            layout,
            link_inertias,
            present: present.to_vec(),
            rows: Vec::new(),
            joint_of: Vec::new(),
            load: less(
                rigid.inverse_dynamics(
                    &recording.trajectory.q,
                    &recording.trajectory.v,
                    &recording.trajectory.a,
                ),
                &ground,
            ),
            ground,
            inertial: OnceLock::new(),
            parameters: link_inertias.parameters(),
            residual: Vec::new(),
            turned: Memo::new(4 * recording.trajectory.v.len()),
            turned_inertial: Memo::new(recording.trajectory.v.len() * rigid.parameters),
            sticks: OnceLock::new(),
            motion_noise: Vec::new(),
            within_steps: Vec::new(),
            resistance: (0..joints).map(|_| OnceLock::new()).collect(),
            inertia: (0..joints).map(|_| OnceLock::new()).collect(),
            jumps: (0..joints).map(|_| OnceLock::new()).collect(),
            columns: (0..joints).map(|_| Columns::default()).collect(),
            recording,
        };
        this.list_rows();
        this.find_residuals(None);
        this.motion_noise = this.noise_of_motion();
        this.within_steps = this.unseen_within_steps();
        Ok(this)
    }

    /// What the description leaves. On the ground: with its effects there.
    pub(crate) fn find_residuals(&mut self, ground: Option<&OnGround>) {
        let all: Vec<usize> = (0..self.rows.len()).collect();
        self.residual = self.residuals(&self.present, &all, ground).into_iter().map(|(_, r)| r).collect();
        self.sticks = OnceLock::new();
    }

    /// Where joints stick, by row.
    fn find_sticking(&self) -> Vec<Vec<bool>> {
        // Where a joint strikes or leaves a stop, drives answer faster than the filter lets the motion be seen; on the ground efforts
        // passed it too.
        let Recording { stops, time, cutoff_hz, .. } = &self.recording;
        let strikes = if self.ground.is_empty() { stops.strikes(time, *cutoff_hz) } else { Vec::new() };
        let shaken = either(strikes, &self.shaken());
        parallel(self.rows.len(), |row| self.sticking(row, &shaken))
    }

    /// Where the joint of an effort sticks or lies at a stop, its effort is clipped, or one strikes its stop or is shaken: the effort is a bound there, or told by
    /// what the filter does not see.
    fn sticking(&self, row: usize, shaken: &[bool]) -> Vec<bool> {
        let joint = self.joint_of[row];
        if self.rows[row].channel != Channel::Effort {
            return Vec::new();
        }
        let [position, velocity, acceleration] = self.motion_of_motor(joint);
        let load = self.recording.trajectory.of_joint(&self.load, joint).collect();
        let signals: [Vec<f64>; 4] = [position, velocity, acceleration, load];
        let present: Vec<&Effect> = self.present.iter().filter(|e| self.joint(e) == Some(joint)).collect();
        let what = super::sticking::Joint {
            residual: &self.residual[row],
            signals: &signals,
            still: still_speed(self.recording.trajectory.velocities(joint)),
            noise: self.rows[row].noise,
            period: 1.0 / (self.recording.cutoff_hz * self.recording.step),
            alone: self.layout.joints.len() == 1,
        };
        let sticks = super::sticking::sticking(&what, &present);
        let clipped = self.recording.effort[joint].as_deref().map_or_else(Vec::new, clipped);
        either(either(either(sticks, &clipped), &self.at_stop[joint]), shaken)
    }

    /// Which joints lay at their stops, where what is left is taken for what these carry, and which were shaken: a sentence each.
    pub fn set_aside(&self) -> Vec<String> {
        let jolts = if self.ground.is_empty() { self.recording.jolts.words(self.layout) } else { Vec::new() };
        self.recording.stops.words(self.layout).into_iter().chain(jolts).collect()
    }

    /// What it was made from.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    fn list_rows(&mut self) {
        for (j, joint) in self.layout.joints.iter().enumerate() {
            if self.recording.effort[j].is_some() {
                self.joint_of.push(j);
                self.rows.push(Row {
                    name: joint.name.clone(),
                    channel: Channel::Effort,
                    unit: joint.unit(),
                    joint: Some(joint.name.clone()),
                    noise: self.recording.noise[j].max(1e-12),
                });
            }
        }
        for (j, joint) in self.layout.joints.iter().enumerate() {
            if let Some(values) = &self.recording.transmission[j] {
                self.joint_of.push(j);
                let noise = crate::measure::noise::of_encoders(values, 2).max(1e-7);
                self.rows.push(Row {
                    name: format!("{}/motor_position", joint.name),
                    channel: Channel::Transmission,
                    unit: if joint.prismatic { "m" } else { "rad" },
                    joint: Some(joint.name.clone()),
                    noise,
                });
            }
        }
    }

    pub(super) fn joint(&self, effect: &Effect) -> Option<usize> {
        self.index(effect.location.joint.as_deref())
    }

    pub(super) fn index(&self, name: Option<&str>) -> Option<usize> {
        let name = name?;
        self.layout.joints.iter().position(|joint| joint.name == name)
    }

    pub(super) fn strided<'s>(&self, values: &'s [f64], joint: usize) -> impl Iterator<Item = f64> + use<'s> {
        self.recording.trajectory.of_joint(values, joint)
    }

    /// A small part of a joint's usual speed, one digit: where it is slower it may as well be about to turn.
    pub(super) fn reversal_speed(&self, joint: usize) -> f64 {
        small_part(self.recording.trajectory.velocities(joint))
    }

    /// Whether another joint moves often enough while a joint does that the sign of a sum of their speeds is not the joint's own.
    fn meet(&self, joint: usize, other: usize) -> bool {
        /// Part of the samples at which the joint moves.
        const OFTEN: f64 = 0.1;
        let moves = |joint: usize| {
            let speeds = self.recording.trajectory.velocities(joint);
            let still = still_speed(speeds);
            self.recording.trajectory.velocities(joint).map(move |speed| speed.abs() > still)
        };
        let moving = moves(joint).filter(|moves| *moves).count();
        let both = moves(joint).zip(moves(other)).filter(|(own, other)| *own && *other).count();
        both as f64 > OFTEN * moving as f64
    }

    /// The row of a joint's effort.
    pub(super) fn effort_row(&self, joint: usize) -> Option<usize> {
        (0..self.rows.len()).find(|&r| self.rows[r].channel == Channel::Effort && self.joint_of[r] == joint)
    }
}

/// Slower than this a joint may as well rest: 4 % of its root mean square speed while it moves, rests of whatever length left out.
fn still_speed(velocities: impl Iterator<Item = f64>) -> f64 {
    const PART: f64 = 0.04;
    const MOVES: f64 = 0.05;
    let speeds: Vec<f64> = velocities.map(f64::abs).collect();
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let moving = speeds.iter().filter(|speed| **speed > MOVES * fastest);
    let (sum, count) = moving.fold((0.0, 0.0_f64), |(sum, count), v| (sum + v * v, count + 1.0));
    (PART * (sum / count.max(1.0)).sqrt()).max(1e-5)
}

/// A small part of what values usually are (root mean square), one digit.
fn small_part(values: impl Iterator<Item = f64>) -> f64 {
    const PART: f64 = 0.04;
    let (sum, count) = values.fold((0.0, 0.0_f64), |(sum, count), v| (sum + v * v, count + 1.0));
    let part = (PART * (sum / count.max(1.0)).sqrt()).max(1e-5);
    let digit = 10_f64.powf(part.log10().floor());
    (part / digit).round() * digit
}

/// The first less the second, which may be empty.
pub(super) fn less(mut values: Vec<f64>, others: &[f64]) -> Vec<f64> {
    values.iter_mut().zip(others).for_each(|(value, other)| *value -= other);
    values
}

/// Where either of two lists of flags is set; an empty list is none.
fn either(flags: Vec<bool>, others: &[bool]) -> Vec<bool> {
    match (flags.is_empty(), others.is_empty()) {
        (_, true) => flags,
        (true, false) => others.to_vec(),
        (false, false) => flags.iter().zip(others).map(|(flag, other)| *flag || *other).collect(),
    }
}

impl Experiment for MotionExperiment<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        &self.recording.time
    }
    fn residual(&self, row: usize) -> &[f64] {
        &self.residual[row]
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        let measured = match self.rows[row].channel {
            Channel::Transmission => &self.recording.transmission,
            _ => &self.recording.effort,
        };
        measured[self.joint_of[row]].clone()
    }
    fn sticks(&self, row: usize) -> &[bool] {
        &self.sticks.get_or_init(|| self.find_sticking())[row]
    }
    fn shaken(&self) -> Vec<bool> {
        // On the ground feet strike it all the time.
        if !self.ground.is_empty() {
            return Vec::new();
        }
        self.recording.jolts.flags(&self.recording.time, self.recording.cutoff_hz)
    }
    fn described(&self) -> &[Effect] {
        &self.present
    }
    fn motion_noise(&self, row: usize) -> f64 {
        self.motion_noise[row]
    }
    fn within_steps(&self, row: usize) -> [f64; 2] {
        self.within_steps[row]
    }
    fn smeared(&self) -> usize {
        (SMEARED / (self.recording.cutoff_hz * self.recording.step)).ceil() as usize
    }
    fn crossings(&self, effects: &[Effect]) -> Vec<bool> {
        self.between_stops(&[&self.present, effects].concat())
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let all: Vec<Effect> = self.present.iter().chain(effects).cloned().collect();
        let mut responses = self.residuals(&all, &self.touched(effects), None);
        for (row, residual) in &mut responses {
            residual.iter_mut().zip(&self.residual[*row]).for_each(|(r, nominal)| *r = nominal - *r);
        }
        responses
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        let mut moved = vec![false; self.link_inertias.bodies.len()];
        for inertial in self.all_inertial().iter().flatten() {
            inertial.columns.iter().for_each(|column| moved[body_of(*column)] = true);
        }
        let mut list = places::candidates(self.layout, &self.recording, self.link_inertias, &moved);
        // What the description has was estimated before; a second one of the kind would only share its part.
        list.retain(|(kind, place)| !self.present.iter().any(|e| e.kind == *kind && e.location == *place));
        list
    }
    fn inertial_count(&self) -> usize {
        self.rigid.parameters
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        &self.parameters
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        self.all_inertial()[row].as_ref()
    }
    fn inertial_at(&self, samples: &[usize]) -> Vec<Option<Inertial>> {
        self.inertial_of(samples)
    }
    fn signals(&self, row: usize) -> Vec<(String, Vec<f64>)> {
        self.signals_of_row(row)
    }
    fn signal(&self, row: usize, name: &str) -> Option<Vec<f64>> {
        self.signal_of(self.joint_of[row], name)
    }
    fn slides(&self, place: &Location) -> Option<f64> {
        let joint =
            self.index(place.joint.as_deref()).filter(|joint| self.layout.joints[*joint].prismatic)?;
        Some(self.reversal_speed(joint))
    }
    fn heaviness(&self, place: &Location) -> f64 {
        self.times_as_heavy(place)
    }
    fn slowness(&self, place: &Location) -> [f64; 2] {
        self.times_as_slow(place)
    }
    fn small_load(&self, place: &Location) -> Option<f64> {
        self.index(place.joint.as_deref()).map(|joint| small_part(self.strided(&self.load, joint)))
    }
    fn seeds(&self, kind: &'static Kind, location: &Location) -> Option<Vec<f64>> {
        let joint = self.index(location.joint.as_deref());
        if let Some(joint) = joint.filter(|joint| self.is_motor_side(*joint)) {
            match kind.law {
                Law::SeriesElasticity if self.ground.is_empty() => return Some(self.stiffnesses(joint)),
                Law::SeriesElasticity => return Some(self.stiffnesses_on_ground(joint)),
                Law::Backlash => return Some(self.gaps(joint)),
                _ => {}
            }
        }
        match kind.search.starts {
            Starts::Limits => Some(joint.map_or(Vec::new(), |j| self.limits(j))),
            Starts::Periods => Some(joint.map_or(Vec::new(), |j| self.lines(j))),
            Starts::Neighbours(values) => joint
                .zip(self.index(location.other_joint.as_deref()))
                .filter(|(j, other)| j.abs_diff(*other) == 1)
                .map(|(j, other)| {
                    values.iter().copied().filter(|d| *d == 0.0 || self.meet(j, other)).collect()
                }),
            Starts::None | Starts::At(_) => None,
        }
    }
    fn link_inertias(&self) -> Option<&LinkInertias> {
        Some(self.link_inertias)
    }
    fn check(&self) -> Vec<Diagnostic> {
        let torques = |states: &Trajectory| self.rigid.inverse_dynamics(&states.q, &states.v, &states.a);
        data_checks::check(&data_checks::Evidence {
            joints: self.layout.joints.iter().map(|j| (j.name.as_str(), j.prismatic)).collect(),
            recording: &self.recording,
            torques: &torques,
            moments: &|states: &Trajectory| self.rigid.moments(states),
            links: self.link_inertias,
        })
    }
    fn duration(&self) -> Option<f64> {
        Some(self.recording.time.len() as f64 * self.recording.step)
    }
    fn joints(&self) -> Vec<&str> {
        self.layout.joints.iter().map(|joint| joint.name.as_str()).collect()
    }
    fn motion(&self) -> JointPositions {
        let position = |joint| self.recording.trajectory.positions(joint).collect();
        JointPositions {
            time: self.recording.time.clone(),
            positions: (0..self.layout.joints.len()).map(position).collect(),
        }
    }
}
