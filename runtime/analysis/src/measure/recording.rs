//! A log in memory: states of the robot at its samples, and what was measured there.
use crate::log::{Block, Log};
use crate::measure::acceleration_noise::AccelerationNoise;
use crate::measure::columns::Plan;
use crate::measure::directions::{Direction, Directions, Turning};
use crate::measure::filtered::{Filtered, unusable};
use crate::measure::jolts::Jolts;
use crate::measure::noise::white_noise;
use crate::measure::stops::Stops;
use crate::measure::thinning::Held;
use crate::measure::trajectory::{Even, Unusable};
use crate::measure::wild::WildEfforts;
use crate::measure::{DataSource, Missing, Options};
use crate::robot::{JointLayout, Trajectory};
use crate::signal::{Butterworth, Grid, Spline, resample};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::ops::Range;
use std::path::Path;

/// Fewer samples tell nothing.
pub(super) const FEWEST: usize = 50;

/// The motion of a log, filtered and differentiated, with its measurements.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Where it came from.
    pub source: DataSource,
    /// Times of the samples, s.
    pub time: Vec<f64>,
    /// Stretches without gaps, as ranges of samples.
    pub segments: Vec<Range<usize>>,
    /// States at the samples.
    pub trajectory: Trajectory,
    /// Logged efforts by joint, not filtered; N m.
    pub effort: Vec<Option<Vec<f64>>>,
    /// Logged motor angle (divided by the gear ratio) minus joint angle, not filtered; rad.
    pub transmission: Vec<Option<Vec<f64>>>,
    /// Motions of motors beside those of their joints, filtered as these are: angle (divided by the gear ratio), velocity,
    /// acceleration; rad, rad/s, rad/s².
    pub motors: Vec<Option<Vec<[f64; 3]>>>,
    /// Joints of which the motor alone is measured: their states are the motor's.
    pub motor_side: Vec<bool>,
    /// Joints of which no position is logged: they are taken to stand still at zero.
    pub unseen: Vec<bool>,
    /// Directions of joints that were asked for.
    pub directions: Vec<Direction>,
    /// Median sampling step, s.
    pub step: f64,
    /// Cut-off of the filter, Hz.
    pub cutoff_hz: f64,
    /// Standard deviation of the noise of each joint's effort; 0 without an effort.
    pub noise: Vec<f64>,
    /// The same of each joint's filtered acceleration, rad/s² or m/s², from that of the position (or velocity) as logged; empty: not known.
    pub acceleration_noise: Vec<f64>,
    /// Of each joint that rests within a step of its encoder half of that step, rad or m, and 0 of others; empty: not known.
    pub at_rest: Vec<f64>,
    /// Whether the description says that something holds the robot's base; where nothing does, it may stand.
    pub is_held: bool,
    /// When joints lay at their stops.
    pub stops: Stops,
    /// When something shook joints.
    pub jolts: Jolts,
    /// What could not be used and why.
    pub missing: Vec<Missing>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
    /// What is odd about the log.
    pub warnings: Vec<Diagnostic>,
}

impl Recording {
    /// Reads a whole log; positions are filtered at `options.cutoff_hz` (10 Hz if that is not given).
    ///
    /// # Errors
    /// Those of the reader; a log too short for the filter.
    pub fn read(log: &Log, layout: &JointLayout, options: &Options) -> Result<Self, Diagnostics> {
        let mut recording = Self::each(log, layout, options, None, &mut |_| Ok(()))?;
        if recording.time.len() < FEWEST {
            return Err(too_short(recording.time.len(), log.path()).into());
        }
        recording.source = DataSource { samples: recording.time.len(), ..log.source()? };
        recording.noise = recording.effort.iter().map(|e| e.as_deref().map_or(0.0, white_noise)).collect();
        Ok(recording)
    }

    /// The same with evenly spaced samples of a log of any length, at most `most` of them (but one for every stretch
    /// without gaps): memory does not grow with the log, see [`crate::measure::HELD`].
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_thinned(
        log: &Log,
        layout: &JointLayout,
        options: &Options,
        most: usize,
    ) -> Result<Self, Diagnostics> {
        Ok(Held::read(log, layout, options)?.into_thinned(most))
    }

    /// Reads a log block by block and shows what was gathered so far after each; whoever looks may take samples out
    /// ([`Self::clear`]), so that a log of any length fits. With `directions` efforts, and these, pass the same filter as
    /// positions, so that both sides of a regression are equally late and smooth.
    pub(crate) fn each(
        log: &Log,
        layout: &JointLayout,
        options: &Options,
        directions: Option<&Directions>,
        visit: &mut dyn FnMut(&mut Self) -> Result<(), Diagnostics>,
    ) -> Result<Self, Diagnostics> {
        Self::each_block(log, layout, options, (directions, true), visit)
    }

    /// The same; unless it `hears`, nothing is found out of the noise of accelerations, and of jolts.
    pub(super) fn each_block(
        log: &Log,
        layout: &JointLayout,
        options: &Options,
        (directions, hears): (Option<&Directions>, bool),
        visit: &mut dyn FnMut(&mut Self) -> Result<(), Diagnostics>,
    ) -> Result<Self, Diagnostics> {
        let mut reader = log.rows();
        let mut plan = Plan::new(layout, &mut reader, options)?;
        let passes = if directions.is_some_and(|wanted| !wanted.pairs.is_empty()) { 2 } else { 1 };
        let Filtered { step, cutoff_hz, filter, mut blocks } = Filtered::new(reader, options, (1, passes))?;
        let mut recording = Self {
            step,
            cutoff_hz,
            trajectory: Trajectory::new(layout),
            effort: plan.joints.iter().map(|c| c.effort.map(|_| Vec::new())).collect(),
            transmission: plan
                .joints
                .iter()
                .map(|c| c.motor_position.and(c.position).map(|_| Vec::new()))
                .collect(),
            motors: plan
                .joints
                .iter()
                .map(|c| c.motor_position.and(c.position).map(|_| Vec::new()))
                .collect(),
            motor_side: plan.joints.iter().map(|columns| columns.by_motor).collect(),
            unseen: plan.joints.iter().map(|columns| columns.position.is_none()).collect(),
            directions: vec![Direction::default(); directions.map_or(0, |wanted| wanted.pairs.len())],
            missing: std::mem::take(&mut plan.missing),
            assumptions: std::mem::take(&mut plan.assumptions),
            warnings: std::mem::take(&mut plan.warnings),
            ..Self::default()
        };
        let mut accelerations = AccelerationNoise::new(&plan);
        recording.stops = Stops::new(layout, &plan);
        recording.jolts = Jolts::new(&plan);
        let mut wild = WildEfforts::default();
        while let Some(block) = blocks.next_block()? {
            recording.stops.look(&block, step);
            if hears {
                accelerations.hear(&plan, &block);
                recording.jolts.look(&block, step);
                let told = wild.look(&plan, layout, &block);
                recording.warnings.extend(told.into_iter().map(|warning| warning.in_file(log.path())));
            }
            recording
                .add(&plan, layout, (&filter, directions), &block)
                .map_err(|e| unusable(e, log.path()))?;
            visit(&mut recording)?;
        }
        if hears {
            recording.acceleration_noise = accelerations.levels(&filter, step, 1);
            let slides: Vec<bool> = layout.joints.iter().map(|joint| joint.prismatic).collect();
            recording.at_rest = accelerations.at_rest(&slides);
        }
        recording.warnings.extend(blocks.report().warnings.iter().cloned());
        Ok(recording)
    }

    /// Forgets all samples.
    pub(crate) fn clear(&mut self) {
        let effort = self.effort.iter().map(|e| e.as_ref().map(|_| Vec::new())).collect();
        let transmission = self.transmission.iter().map(|t| t.as_ref().map(|_| Vec::new())).collect();
        self.motors.iter_mut().flatten().for_each(Vec::clear);
        self.time.clear();
        self.trajectory.clear();
        self.segments.clear();
        self.directions.iter_mut().for_each(Direction::clear);
        (self.effort, self.transmission) = (effort, transmission);
    }

    fn add(
        &mut self,
        plan: &Plan,
        layout: &JointLayout,
        (filter, directions): (&Butterworth, Option<&Directions>),
        block: &Block<'_>,
    ) -> Result<(), Unusable> {
        let range = block.core.clone();
        let even = Even::new(plan, block, self.step);
        let states = even.states(plan, layout, filter, block.time, range.clone())?;
        let first = self.time.len();
        let continues = self.time.last().is_some_and(|last| block.time[range.start] - last < 1.5 * self.step);
        self.time.extend_from_slice(&block.time[range.clone()]);
        match self.segments.last_mut() {
            Some(last) if continues => last.end = self.time.len(),
            _ => self.segments.push(first..self.time.len()),
        }
        self.trajectory.append([states.q, states.v, states.a]);
        for (joint, columns) in plan.joints.iter().enumerate() {
            if let (Some(values), Some(column)) = (&mut self.effort[joint], columns.effort) {
                match directions {
                    Some(_) => values.extend(filtered(
                        block,
                        &block.columns[column],
                        filter,
                        self.step,
                        range.clone(),
                    )),
                    None => values.extend_from_slice(&block.columns[column][range.clone()]),
                }
            }
            if let (Some(values), Some(motor), Some(position)) =
                (&mut self.transmission[joint], columns.motor_position, columns.position)
            {
                let pairs =
                    block.columns[motor][range.clone()].iter().zip(&block.columns[position][range.clone()]);
                values.extend(pairs.map(|(motor, position)| motor - position));
            }
            if let (Some(motion), Some(motor)) = (&mut self.motors[joint], columns.motor_position) {
                motion.extend(even.motion_of(&block.columns[motor], filter, block.time, range.clone())?);
            }
        }
        if let Some(wanted) = directions.filter(|wanted| !wanted.pairs.is_empty()) {
            self.add_directions(plan, wanted, filter, (&even, block))?;
        }
        Ok(())
    }

    /// From the speeds of the whole block: its ends are not those of the motion.
    fn add_directions(
        &mut self,
        plan: &Plan,
        wanted: &Directions,
        filter: &Butterworth,
        (even, block): (&Even, &Block<'_>),
    ) -> Result<(), Unusable> {
        let turning = Turning { filter, cutoff_hz: self.cutoff_hz, step: self.step };
        let joints = plan.joints.iter().map(|columns| {
            let Some(position) = columns.position else { return Ok((vec![0.0; even.count()], 0.0)) };
            Ok((even.speeds(columns, filter)?, white_noise(&block.columns[position])))
        });
        let joints: Vec<(Vec<f64>, f64)> = joints.collect::<Result<_, Unusable>>()?;
        for (direction, &(one, other)) in self.directions.iter_mut().zip(&wanted.pairs) {
            let both = if one == other { vec![one] } else { vec![one, other] };
            let sum = |i: usize| both.iter().map(|&joint| joints[joint].0[i]).sum();
            let speeds: Vec<f64> = (0..even.count()).map(sum).collect();
            let fastest = both.iter().map(|&joint| wanted.fastest[joint]).sum();
            let noise = both.iter().map(|&joint| joints[joint].1).fold(0.0, f64::max);
            let found = turning.of(&speeds, fastest, noise);
            even.directions_at(&found, block, direction);
        }
        Ok(())
    }

    /// Keeps every so many-th sample, so that at most `most` remain. Derivatives were taken before.
    pub fn thin(&mut self, most: usize) {
        if self.samples() > most.max(1) {
            *self = self.thinned(most);
        }
    }

    /// Every so many-th sample, so that at most `most` remain.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let count = self.time.len();
        let stride = count.div_ceil(most.max(1));
        if stride <= 1 {
            return self.clone();
        }
        let mut kept: Vec<usize> = Vec::with_capacity(most);
        let mut segments = Vec::new();
        for segment in &self.segments {
            let first = kept.len();
            kept.extend(segment.clone().step_by(stride));
            segments.push(first..kept.len());
        }
        Self { segments, step: self.step * stride as f64, ..self.some(&kept) }
    }

    /// Keeps these samples; segments are left to the caller.
    pub(super) fn retain(&mut self, kept: &[usize]) {
        *self = self.some(kept);
    }

    /// These samples alone; segments are left to the caller.
    fn some(&self, kept: &[usize]) -> Self {
        fn picked<T: Copy>(values: &[T], kept: &[usize]) -> Vec<T> {
            kept.iter().map(|&i| values[i]).collect()
        }
        let of_joints = |columns: &[Option<Vec<f64>>]| {
            columns.iter().map(|values| values.as_ref().map(|values| picked(values, kept))).collect()
        };
        Self {
            source: self.source.clone(),
            time: picked(&self.time, kept),
            segments: self.segments.clone(),
            trajectory: self.trajectory.some(kept),
            effort: of_joints(&self.effort),
            transmission: of_joints(&self.transmission),
            motors: self.motors.iter().map(|motion| motion.as_ref().map(|m| picked(m, kept))).collect(),
            motor_side: self.motor_side.clone(),
            unseen: self.unseen.clone(),
            directions: self.directions.clone(),
            step: self.step,
            cutoff_hz: self.cutoff_hz,
            noise: self.noise.clone(),
            acceleration_noise: self.acceleration_noise.clone(),
            at_rest: self.at_rest.clone(),
            is_held: self.is_held,
            stops: self.stops.clone(),
            jolts: self.jolts.clone(),
            missing: self.missing.clone(),
            assumptions: self.assumptions.clone(),
            warnings: self.warnings.clone(),
        }
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.time.len()
    }
}

/// A signal of a block after the filter, at the logged samples.
fn filtered(
    block: &Block<'_>,
    values: &[f64],
    filter: &Butterworth,
    step: f64,
    range: Range<usize>,
) -> Vec<f64> {
    if block.uniform {
        return filter.zero_phase(values)[range].to_vec();
    }
    let (first, last) = (block.time[0], block.time[block.time.len() - 1]);
    let grid = Grid::covering(block.start, step, first, last);
    match Spline::new(&filter.zero_phase(&resample(block.time, values, grid)), step) {
        Some(spline) => block.time[range].iter().map(|t| spline.at(t - grid.start)[0]).collect(),
        None => values[range].to_vec(),
    }
}

/// Said of a log that leaves so few samples.
pub(crate) fn too_short(samples: usize, path: &Path) -> Diagnostic {
    Diagnostic::error(format!("only {samples} samples of the log can be used"))
        .in_file(path)
        .help("at least a few seconds of motion are needed")
}
