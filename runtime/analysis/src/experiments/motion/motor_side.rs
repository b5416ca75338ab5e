//! Joints of which the motor's angle alone is measured: their links move behind the spring or play that a candidate puts between.
use super::experiment::MotionExperiment;
use super::hidden_link::Link;
use super::hidden_links::Links;
use super::hidden_play::Play;
use super::under_effects::Inertials;
use crate::robot::Trajectory;
use crate::signal::Butterworth;
use bipedc_effects::effect::{Effect, Law};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// So often the equation of a link is linearised at its last estimate.
const ROUNDS: usize = 3;
/// Plays from which a search starts, rad.
const GAPS: [f64; 5] = [0.003, 0.006, 0.012, 0.024, 0.048];
/// The same of teeth this far from an axis are those of a rack or a screw, m.
const SLIDING: f64 = 0.1;

/// Behind the filter a link that rests on a stop is at least this part of half the gap away from the middle.
const AT_A_STOP: f64 = 0.9;

/// A joint's link behind its motor.
#[derive(Debug, Clone)]
pub(crate) struct Hidden {
    /// In the order of the robot's joints.
    pub joint: usize,
    /// Of the spring, rad/(N m) or m/N; 0: rigid.
    pub yielding: f64,
    /// From stop to stop, rad or m.
    pub gap: f64,
    /// Link minus motor at every sample: rad, rad/s, rad/s².
    pub behind: Vec<[f64; 3]>,
}

impl Hidden {
    /// Whether the link is on its way between the stops of its play, or near enough for the filter to show that.
    pub fn is_between_stops(&self, sample: usize) -> bool {
        self.gap > 0.0 && is_between(self.gap, self.behind[sample][0])
    }

    /// Moves it from where it was, in these states too.
    fn move_to(&mut self, behind: Vec<[f64; 3]>, states: &mut Trajectory) {
        for order in 0..3 {
            let moved = self.behind.iter().zip(&behind).map(|(old, new)| new[order] - old[order]);
            states.joint_mut(order, self.joint).zip(moved).for_each(|(x, moved)| *x += moved);
        }
        self.behind = behind;
    }

    /// Moves a joint from where its motor is to where its link is.
    pub fn add_to(&self, states: &mut Trajectory) {
        for order in 0..3 {
            let behind = self.behind.iter().map(|behind| behind[order]);
            states.joint_mut(order, self.joint).zip(behind).for_each(|(x, behind)| *x += behind);
        }
    }
}

/// Whether a link this far from its motor is in neither stop's reach.
fn is_between(gap: f64, behind: f64) -> bool {
    behind.abs() < AT_A_STOP * 0.5 * gap
}

impl MotionExperiment<'_> {
    /// Whether the motor's angle of a joint alone is measured.
    pub(super) fn is_motor_side(&self, joint: usize) -> bool {
        self.recording.motor_side.get(joint).is_some_and(|alone| *alone)
    }

    /// Links that effects put behind springs or play whose far end nobody measured.
    pub(super) fn hidden(&self, effects: &[Effect]) -> Vec<Hidden> {
        let mut links: Vec<Hidden> = Vec::new();
        for effect in effects {
            let [yielding, gap] = match effect.kind.law {
                Law::SeriesElasticity => [effect.value("stiffness").recip(), 0.0],
                Law::Backlash => [0.0, effect.value("gap")],
                _ => continue,
            };
            let Some(joint) = self.joint(effect).filter(|joint| self.is_motor_side(*joint)) else { continue };
            match links.iter_mut().find(|link| link.joint == joint) {
                Some(link) => (link.yielding, link.gap) = (link.yielding + yielding, link.gap + gap),
                None => {
                    let behind = vec![[0.0; 3]; self.recording.samples()];
                    links.push(Hidden { joint, yielding, gap, behind });
                }
            }
        }
        links.retain(|link| link.yielding > 0.0 || link.gap > 0.0);
        links
    }

    /// Samples at which a link is on its way between the stops of its play, or near enough for the filter to show that; empty: no joint
    /// has play that its motor alone shows.
    pub(super) fn between_stops(&self, effects: &[Effect]) -> Vec<bool> {
        let gaps: Vec<(usize, f64)> =
            self.hidden(effects).iter().filter(|link| link.gap > 0.0).map(|l| (l.joint, l.gap)).collect();
        if gaps.is_empty() {
            return Vec::new();
        }
        let turned = self.turned_load(effects, None);
        let Some((_, Some(links))) = turned.as_deref() else { return Vec::new() };
        let mut flags = vec![false; self.recording.samples()];
        for (joint, gap) in gaps {
            let own = effects.iter().filter(|effect| effect.kind.law == Law::EncoderOffset);
            let offset: f64 = own.filter(|e| self.joint(e) == Some(joint)).map(|e| e.value("offset")).sum();
            let motor = self.recording.trajectory.positions(joint).map(|q| q - offset);
            let behind = links.positions(joint).zip(motor).map(|(link, motor)| link - motor);
            let crossing = behind.map(|e| is_between(gap, e));
            flags.iter_mut().zip(crossing).for_each(|(flag, crossing)| *flag |= crossing);
        }
        flags
    }

    /// What all links need, `samples × nv`, and their states, if these move behind their motors; `load` of states that are
    /// their motors', and `needed` of others.
    pub(super) fn load_behind_motors(
        &self,
        mut hidden: Vec<Hidden>,
        effects: &[Effect],
        (mut states, mut load): (Trajectory, Vec<f64>),
        needed: &dyn Fn(&Trajectory) -> Vec<f64>,
    ) -> (Vec<f64>, Trajectory) {
        let change = self.link_inertias.change(effects);
        // Of those behind play or alone behind a spring each moves by itself.
        hidden.sort_by_key(|link| link.gap > 0.0);
        let springs = hidden.iter().filter(|link| link.gap == 0.0).count();
        let (together, alone) = hidden.split_at_mut(if springs > 1 { springs } else { 0 });
        // What is carried moves with the links; the first time these are where their motors are.
        let carries = change.iter().any(|change| *change != 0.0);
        for round in 0..ROUNDS {
            let inertial = (round > 0 && carries).then(|| self.inertial_at(effects, &states));
            let carried = (&change[..], inertial.as_ref());
            if !together.is_empty() {
                self.move_links(together, effects, (&mut states, &load), carried);
            }
            for link in alone.iter_mut() {
                self.move_link(link, effects, (&mut states, &load), carried);
            }
            load = needed(&states);
        }
        (load, states)
    }

    /// Puts links that shake each other where their motors and springs leave them. `inertial`: how changes of inertial parameters enter torques where links
    /// are; `None` where they are as logged.
    fn move_links(
        &self,
        links: &mut [Hidden],
        effects: &[Effect],
        (states, load): (&mut Trajectory, &[f64]),
        (change, inertial): (&[f64], Option<&Inertials>),
    ) {
        let inertia = self.inertia_among(links);
        let resistance: Vec<&[[f64; 2]]> = links.iter().map(|link| self.resistance(link.joint)).collect();
        let [mut loads, mut measured] = [const { Vec::new() }; 2];
        for (j, link) in links.iter().enumerate() {
            let rigid = self.rigid_torques(load, link.joint, change, inertial);
            let carried = self.link_torques(link.joint, &rigid, effects, states);
            let left = self.effort_residual(link.joint, &rigid, effects, states);
            measured.push(left.iter().zip(&carried).map(|(left, load)| left + load).collect::<Vec<f64>>());
            let with_motors = |(i, load): (usize, &f64)| {
                let shaken: f64 =
                    links.iter().enumerate().map(|(k, o)| inertia[i][(j, k)] * o.behind[i][2]).sum();
                load - shaken - resistance[j][i][1] * link.behind[i][0]
            };
            loads.push(carried.iter().enumerate().map(with_motors).collect::<Vec<f64>>());
        }
        let (segments, step) = (&self.recording.segments[..], self.recording.step);
        let springs = Links {
            load: &loads,
            inertia: &inertia,
            resistance: &resistance,
            measured: &measured,
            segments,
            step,
        };
        let stiffness: Vec<f64> = links.iter().map(|link| link.yielding.recip()).collect();
        for (link, behind) in links.iter_mut().zip(springs.behind(&stiffness)) {
            link.move_to(behind, states);
        }
    }

    /// Puts a link where its motor and what lies between leave it, by the slopes of what it needs at its last place.
    pub(super) fn move_link(
        &self,
        link: &mut Hidden,
        effects: &[Effect],
        (states, load): (&mut Trajectory, &[f64]),
        (change, inertial): (&[f64], Option<&Inertials>),
    ) {
        let joint = link.joint;
        let rigid = self.rigid_torques(load, joint, change, inertial);
        let carried = self.link_torques(joint, &rigid, effects, states);
        let resistance = self.resistance(joint);
        let with_motor = |((load, [e, _, a]), [inertia, slope]): ((&f64, &[f64; 3]), &[f64; 2])| {
            load - inertia * a - slope * e
        };
        let load: Vec<f64> = carried.iter().zip(&link.behind).zip(resistance).map(with_motor).collect();
        let (segments, step) = (&self.recording.segments[..], self.recording.step);
        let behind = if link.gap > 0.0 {
            let filter = Butterworth::new(self.recording.cutoff_hz, step.recip()).ok();
            let play = Play { load: &load, resistance, segments, step, filter: filter.as_ref() };
            play.behind(link.gap, link.yielding)
        } else {
            let left = self.effort_residual(joint, &rigid, effects, states);
            let measured: Vec<f64> = left.iter().zip(&carried).map(|(left, load)| left + load).collect();
            let spring = Link { load: &load, resistance, measured: &measured, segments, step };
            spring.behind(link.yielding.recip())
        };
        link.move_to(behind, states);
    }

    /// The mass matrix of these joints at every sample, kg m².
    fn inertia_among(&self, links: &[Hidden]) -> Vec<DMatrix<f64>> {
        let at = |joint: usize| self.layout.base.nv() + joint;
        let column = |link: &Hidden| {
            let of = || {
                let motion = &self.recording.trajectory;
                self.rigid.inertia_column(motion, at(link.joint), self.recording.samples())
            };
            self.inertia[link.joint].get_or_init(of)
        };
        let columns: Vec<&Vec<f64>> = links.iter().map(column).collect();
        let (nv, count) = (self.layout.base.nv() + self.layout.joints.len(), links.len());
        let entry = |i: usize, r: usize, c: usize| columns[c][i * nv + at(links[r].joint)];
        (0..self.recording.samples()).map(|i| DMatrix::from_fn(count, count, |r, c| entry(i, r, c))).collect()
    }

    fn resistance(&self, joint: usize) -> &[[f64; 2]] {
        let (q, v) = (self.layout.base.nq() + joint, self.layout.base.nv() + joint);
        self.resistance[joint].get_or_init(|| self.rigid.resistance(&self.recording.trajectory, (q, v)))
    }

    /// Plays from which a search starts, rad (m where the joint slides).
    pub(super) fn gaps(&self, joint: usize) -> Vec<f64> {
        let scale = if self.layout.joints[joint].prismatic { SLIDING } else { 1.0 };
        GAPS.map(|gap| scale * gap).to_vec()
    }

    /// Stiffnesses from which a search starts: behind them a link would swing with a few frequencies; N m/rad or N/m. A motion that meets
    /// such a frequency swells, and a straight line from half the stiffness, or twice, tells nothing of it.
    pub(super) fn stiffnesses(&self, joint: usize) -> Vec<f64> {
        const RESONANCES_HZ: [f64; 9] = [1.5, 2.0, 2.5, 3.2, 4.0, 5.0, 6.5, 11.0, 18.0];
        let resistance = self.resistance(joint);
        let inertia = resistance.iter().map(|r| r[0]).sum::<f64>() / resistance.len().max(1) as f64;
        RESONANCES_HZ.map(|hz| inertia * (TAU * hz).powi(2)).to_vec()
    }
}
