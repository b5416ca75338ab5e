//! The comparison itself: one pass over the log, all cut-offs at once.
use super::experiment::by_kind;
use super::motion_noise::motion_noise;
use super::report::{Channel, Comparison, Cutoff};
use super::statistics::{Sums, geometric_mean};
use crate::experiments::{depends_on_unseen, nothing_left};
use crate::log::{Block, Blocks, Log, MOST_GAPS, Reader, Sampling};
use crate::measure::Options;
use crate::measure::acceleration_noise::AccelerationNoise;
use crate::measure::coloured::telling_velocity;
use crate::measure::columns::{JointColumns, Plan};
use crate::measure::filtered::{cut, in_hertz, no_filter, reason, unusable};
use crate::measure::noise::white_noise;
use crate::measure::residual_noise::residual_noise;
use crate::measure::trajectory::{Even, States};
use crate::measure::wild::WildEfforts;
use crate::parallel::parallel;
use crate::robot::{Batch, InverseDynamics, JointLayout, depends_on};
use crate::signal::Butterworth;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::{Path, PathBuf};

/// Sums of squares of anything smaller are finite, N m.
const LARGEST_EFFORT: f64 = 1e140;
/// Samples at which the noise's way through the model is computed.
const NOISE_SAMPLES: usize = 16;

/// One cut-off on trial.
struct Candidate {
    cutoff_hz: f64,
    filter: Butterworth,
    /// One per joint; joints that are not compared stay empty.
    sums: Vec<Sums>,
    /// What the first block leaves, one per joint.
    left: Vec<Left>,
}

/// A row of a block.
#[derive(Debug, Clone, Default)]
struct Left {
    /// Logged effort less the model's.
    residual: Vec<f64>,
    /// Of the joint.
    velocity: Vec<f64>,
}

impl Candidate {
    fn total(&self) -> Sums {
        self.sums.iter().fold(Sums::default(), |total, s| total.merged(s))
    }
    fn geometric_mean(&self) -> f64 {
        geometric_mean(self.sums.iter().filter(|sums| sums.samples > 0).map(Sums::rms))
    }
}

/// Everything that stays the same from block to block.
struct Run<'a> {
    file: PathBuf,
    layout: &'a JointLayout,
    plan: Plan,
    /// Which joints are compared.
    compared: Vec<bool>,
    step: f64,
    candidates: Vec<Candidate>,
    /// Noise of the logged efforts by joint, from the first stretch.
    noise: Vec<f64>,
    accelerations: AccelerationNoise,
    wild: WildEfforts,
    /// Configurations from the first stretch, one after the other: the noise's way through the model is computed there.
    postures: Vec<f64>,
    /// First and last time that counted, s.
    span: Option<(f64, f64)>,
}

/// Compares a log; see [`compare`].
///
/// # Errors
/// As [`compare`].
pub fn compare_file(
    model: &mut dyn InverseDynamics,
    layout: &JointLayout,
    log: &Log,
    options: &Options,
) -> Result<Comparison, Diagnostics> {
    compare(model, layout, log.rows(), options)
}

/// Compares logged efforts with those that the model predicts from the logged motion.
///
/// The log is read once. `layout` names the model's joints in the order of `v`.
///
/// # Errors
/// Options without meaning; the table is no log; no joint of the robot has position and effort; any error in a
/// row; a log that is too short; a model that does not fit its joints or gives numbers that are not finite.
pub fn compare(
    model: &mut dyn InverseDynamics,
    layout: &JointLayout,
    mut reader: Reader,
    options: &Options,
) -> Result<Comparison, Diagnostics> {
    check(model, layout, options)?;
    let file = reader.file().to_path_buf();
    let mut plan = Plan::new(layout, &mut reader, options)?;
    let compared = compared_joints(model, layout, &mut plan).map_err(|e| one(e.in_file(&file)))?;
    let sampling = Sampling::probe(reader)?;
    let step = sampling.step();
    let candidates = candidates(&mut plan, layout, options, 1.0 / step).map_err(|e| one(e.in_file(&file)))?;
    let overlap = candidates.iter().map(|c| c.filter.overlap()).max().unwrap_or(0);
    let mut blocks = cut(sampling, overlap, 1, options);
    let accelerations = AccelerationNoise::new(&plan);
    let mut run = Run {
        file,
        layout,
        plan,
        compared,
        step,
        candidates,
        noise: Vec::new(),
        accelerations,
        wild: WildEfforts::default(),
        postures: Vec::new(),
        span: None,
    };
    while let Some(block) = blocks.next_block()? {
        run.add(model, &block)?;
    }
    run.finish(model, &blocks, options)
}

fn one(error: Diagnostic) -> Diagnostics {
    Diagnostics(vec![error])
}

fn check(model: &dyn InverseDynamics, layout: &JointLayout, options: &Options) -> Result<(), Diagnostics> {
    let joints = layout.joints.len();
    let (nq, nv) = (layout.base.nq() + joints, layout.base.nv() + joints);
    let mut errors = Vec::new();
    if (model.nq(), model.nv()) != (nq, nv) {
        let found = format!("the model has nq {} and nv {}", model.nq(), model.nv());
        errors.push(Diagnostic::error(format!("{found}, its base and {joints} joints make {nq} and {nv}")));
    }
    if !(options.trim_s >= 0.0 && options.trim_s.is_finite()) {
        let message = format!("{} s cannot be left out at the ends", options.trim_s);
        errors.push(Diagnostic::error(message).help("give a number of seconds that is not negative"));
    }
    if let (Some(from), Some(to)) = (options.from_s, options.to_s)
        && from.partial_cmp(&to) != Some(std::cmp::Ordering::Less)
    {
        let message = format!("no time lies between {from} s and {to} s");
        errors.push(Diagnostic::error(message).help("the first time must be before the last"));
    }
    if options.cutoff_hz.is_none() && options.candidates.is_empty() {
        errors.push(Diagnostic::error("no cut-off frequency to try").help("give one, or candidates"));
    }
    if errors.is_empty() { Ok(()) } else { Err(Diagnostics(errors)) }
}

/// Joints with an effort whose prediction depends on no joint without a position.
fn compared_joints(
    model: &mut dyn InverseDynamics,
    layout: &JointLayout,
    plan: &mut Plan,
) -> Result<Vec<bool>, Diagnostic> {
    let mut compared: Vec<bool> = plan.joints.iter().map(|c| c.effort.is_some()).collect();
    for moved in 0..layout.joints.len() {
        if plan.joints[moved].position.is_some() {
            continue;
        }
        let mut torques = |batch: &Batch<'_>| {
            let mut tau = vec![0.0; batch.count * model.nv()];
            model.torques(batch, &mut tau).map(|()| tau)
        };
        let rows = depends_on(layout, moved, &mut torques).map_err(|e| Diagnostic::error(e.to_string()))?;
        for (other, _) in rows.iter().enumerate().filter(|(_, depends)| **depends) {
            if std::mem::replace(&mut compared[other], false) {
                plan.missing.push(depends_on_unseen(layout, other, moved));
            }
        }
    }
    if compared.contains(&true) {
        return Ok(compared);
    }
    Err(nothing_left(&plan.missing))
}

fn candidates(
    plan: &mut Plan,
    layout: &JointLayout,
    options: &Options,
    rate: f64,
) -> Result<Vec<Candidate>, Diagnostic> {
    let tried = options.cutoff_hz.map_or_else(|| options.candidates.clone(), |c| vec![c]);
    let mut candidates = Vec::new();
    let mut refused = Vec::new();
    let mut why = String::new();
    for cutoff_hz in tried {
        match Butterworth::new(cutoff_hz, rate) {
            Ok(filter) => {
                candidates.push(Candidate {
                    cutoff_hz,
                    filter,
                    sums: vec![Sums::default(); layout.joints.len()],
                    left: vec![Left::default(); layout.joints.len()],
                });
            }
            Err(error) => {
                refused.push(cutoff_hz);
                why = reason(error, rate);
            }
        }
    }
    if candidates.is_empty() {
        return Err(no_filter(&refused, &why));
    }
    if !refused.is_empty() {
        plan.assumptions.push(format!("cut-offs not tried because {why}: {}", in_hertz(&refused)));
    }
    Ok(candidates)
}

impl Run<'_> {
    fn add(&mut self, model: &mut dyn InverseDynamics, block: &Block<'_>) -> Result<(), Diagnostics> {
        let range = block.core.clone();
        let even = Even::new(&self.plan, block, self.step);
        if self.noise.is_empty() {
            let effort = |joint: &JointColumns| {
                joint.effort.map_or(0.0, |c| white_noise(&block.columns[c][range.clone()]))
            };
            self.noise = self.plan.joints.iter().map(effort).collect();
        }
        let (first, last) = (block.time[range.start], block.time[range.end - 1]);
        self.span = Some((self.span.map_or(first, |s| s.0), last));
        self.accelerations.hear(&self.plan, block);
        let told = self.wild.look(&self.plan, self.layout, block);
        self.plan.warnings.extend(told.into_iter().map(|warning| warning.in_file(&self.file)));
        let filtered = parallel(self.candidates.len(), |index| {
            let filter = &self.candidates[index].filter;
            even.states(&self.plan, self.layout, filter, block.time, range.clone())
        });
        for (index, states) in filtered.into_iter().enumerate() {
            let states = states.map_err(|e| unusable(e, &self.file))?;
            if self.postures.is_empty() {
                let every = (states.count / NOISE_SAMPLES).max(1);
                self.postures = states.q.chunks_exact(model.nq()).step_by(every).flatten().copied().collect();
            }
            self.judge(model, index, block, range.start, &states)?;
        }
        Ok(())
    }

    /// Adds the errors of consecutive samples under one cut-off.
    fn judge(
        &mut self,
        model: &mut dyn InverseDynamics,
        candidate: usize,
        block: &Block<'_>,
        first: usize,
        states: &States,
    ) -> Result<(), Diagnostics> {
        let nv = model.nv();
        let mut tau = vec![0.0; states.count * nv];
        let batch = Batch { count: states.count, q: &states.q, v: &states.v, a: &states.a };
        model
            .torques(&batch, &mut tau)
            .map_err(|e| one(Diagnostic::error(e.to_string()).in_file(&self.file)))?;
        let before = &self.candidates[candidate].sums;
        let judged = parallel(before.len(), |joint| {
            self.judge_joint(joint, before[joint], (block, first), (states, &tau))
        });
        for (joint, judged) in judged.into_iter().enumerate() {
            let Some((sums, left)) = judged? else { continue };
            let is_first = self.candidates[candidate].sums[joint].samples == 0;
            self.candidates[candidate].sums[joint] = sums;
            if is_first {
                self.candidates[candidate].left[joint] = left;
            }
        }
        Ok(())
    }

    /// Sums with the errors of consecutive samples of a joint, and what these leave if they are the first. `None`: the joint is not compared.
    fn judge_joint(
        &self,
        joint: usize,
        mut sums: Sums,
        (block, first): (&Block<'_>, usize),
        (states, tau): (&States, &[f64]),
    ) -> Result<Option<(Sums, Left)>, Diagnostics> {
        let Some(effort) = self.plan.joints[joint].effort.filter(|_| self.compared[joint]) else {
            return Ok(None);
        };
        let nv = tau.len() / states.count.max(1);
        let logged = &block.columns[effort][first..];
        let row = self.layout.base.nv() + joint;
        let is_first = sums.samples == 0;
        for (i, tau) in tau.chunks_exact(nv.max(1)).enumerate() {
            // Its square must be a number too.
            if tau[row].abs().partial_cmp(&LARGEST_EFFORT) != Some(std::cmp::Ordering::Less) {
                let name = &self.layout.joints[joint].name;
                let time = block.time[first + i];
                let message = format!("the model's effort of `{name}` at {time} s is {:e}", tau[row]);
                let help = "check the masses of the description and the positions at that time";
                return Err(one(Diagnostic::error(message).in_file(&self.file).help(help)));
            }
            sums.add(logged[i], tau[row]);
        }
        if !is_first {
            return Ok(Some((sums, Default::default())));
        }
        let left = logged.iter().zip(tau.chunks_exact(nv.max(1))).map(|(logged, tau)| logged - tau[row]);
        let velocity = states.v.chunks_exact(nv.max(1)).map(|v| v[row]).collect();
        Ok(Some((sums, Left { residual: left.collect(), velocity })))
    }

    /// Noise of each joint's row: of the logged effort as what is left shows it, and of the motion.
    fn noise_of_rows(
        &self,
        model: &mut dyn InverseDynamics,
        best: &Candidate,
    ) -> Result<Vec<f64>, Diagnostics> {
        let levels = self.accelerations.levels(&best.filter, self.step, 1);
        let of_motion = motion_noise(model, self.layout.base.nv(), &self.postures, &levels)
            .map_err(|e| one(Diagnostic::error(e.to_string()).in_file(&self.file)))?;
        // What is left shows noise that is correlated in time or changes, which differences of neighbours do not; it may be the motion's.
        let of_row = |joint: usize| {
            let left = &best.left[joint];
            let both = self.noise[joint].hypot(of_motion[joint]);
            let velocity =
                || telling_velocity(joint, best.left.len(), |joint| best.left[joint].velocity.clone());
            residual_noise(&left.residual, velocity, best.sums[joint].logged_rms())
                .map_or(both, |heard| heard.max(both))
        };
        let rows = self.noise.len().min(of_motion.len());
        Ok(parallel(rows, of_row))
    }

    fn finish(
        self,
        model: &mut dyn InverseDynamics,
        blocks: &Blocks,
        options: &Options,
    ) -> Result<Comparison, Diagnostics> {
        let report = blocks.report();
        let Some((from_s, to_s)) = self.span else { return Err(one(self.nothing(blocks, options))) };
        let best = self.candidates.iter().min_by(|a, b| a.geometric_mean().total_cmp(&b.geometric_mean()));
        let Some(best) = best else { return Err(one(self.nothing(blocks, options))) };
        let noise = self.noise_of_rows(model, best)?;
        let channels = self.layout.joints.iter().zip(&best.sums).zip(noise);
        let channels: Vec<Channel> = channels
            .filter(|((_, sums), _)| sums.samples > 0)
            .map(|((joint, sums), noise)| channel(&joint.name, joint.unit(), sums, noise))
            .collect();
        let kinds = by_kind(&channels);
        let mut warnings = self.plan.warnings;
        warnings.extend(uneven(blocks, self.step, &self.file));
        warnings.extend(report.warnings.iter().cloned());
        if report.gaps > MOST_GAPS {
            let message =
                format!("the log has {} gaps in all; the first {MOST_GAPS} are listed", report.gaps);
            warnings.push(
                Diagnostic::warning(message).in_file(&self.file).help("check the recorder for lost messages"),
            );
        }
        Ok(Comparison {
            rms: best.total().rms(),
            unit: kinds.values().next().map_or_else(String::new, |kind| kind.unit.clone()),
            kinds,
            abscissa: "time",
            cutoff_hz: best.cutoff_hz,
            trim_s: options.trim_s,
            from_s,
            to_s,
            samples: channels.first().map_or(0, |c| c.samples),
            sampling_hz: 1.0 / self.step,
            segments: report.segments,
            missing: self.plan.missing,
            assumptions: self.plan.assumptions,
            warnings,
            channels,
            cutoffs: self
                .candidates
                .iter()
                .map(|c| Cutoff {
                    cutoff_hz: c.cutoff_hz,
                    rms: c.total().rms(),
                    geometric_mean: c.geometric_mean(),
                })
                .collect(),
        })
    }

    /// No sample counted: why.
    fn nothing(&self, blocks: &Blocks, options: &Options) -> Diagnostic {
        let rows = blocks.reader().rows();
        let (step, trim) = (self.step, options.trim_s);
        let message = if blocks.report().segments == 0 {
            format!(
                "the log is too short: {rows} rows at {step:.6} s leave nothing after {trim} s are dropped at both ends"
            )
        } else {
            let end = |time: Option<f64>, end: &str| time.map_or(end.to_owned(), |t| format!("{t} s"));
            let (from, to) = (end(options.from_s, "its start"), end(options.to_s, "its end"));
            format!("no sample of the log counts between {from} and {to} ({trim} s are dropped at both ends)")
        };
        let help = "record longer, leave out less, or choose times that the log has";
        Diagnostic::error(message).in_file(&self.file).help(help)
    }
}

fn channel(name: &str, unit: &str, sums: &Sums, noise: f64) -> Channel {
    Channel {
        name: name.to_owned(),
        unit: unit.to_owned(),
        rms: sums.rms(),
        max: sums.max_error,
        relative: sums.relative(),
        samples: sums.samples,
        noise,
        rms_moving: None,
        sticking: None,
        away_from_jumps: None,
        kind: "effort",
    }
}

/// A warning if the samples were not evenly spaced.
fn uneven(blocks: &Blocks, step: f64, file: &Path) -> Option<Diagnostic> {
    let report = blocks.report();
    let (line, (shortest, longest)) = (report.first_uneven?, report.steps?);
    let message = format!(
        "the sampling is not even: steps from {shortest:.6} s to {longest:.6} s (most are {step:.6} s), first in this line"
    );
    let help = "positions are interpolated on an even grid before filtering; a steady clock gives better accelerations";
    Some(Diagnostic::warning(message).in_file(file).at(line, 0).help(help))
}
