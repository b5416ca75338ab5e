//! Joints of which the motor's angle alone is measured: their links move behind the spring that a candidate puts between.
use super::experiment::MotionExperiment;
use super::hidden_link::Link;
use crate::robot::Trajectory;
use bipedc_effects::effect::{Effect, Law};
use std::f64::consts::TAU;

/// So often the equation of a link is linearised at its last estimate.
const ROUNDS: usize = 3;

/// A joint's link behind its motor.
pub(super) struct Hidden {
    joint: usize,
    /// N m/rad
    stiffness: f64,
    /// Link minus motor at every sample: rad, rad/s, rad/s².
    behind: Vec<[f64; 3]>,
}

impl MotionExperiment<'_> {
    /// Whether the motor's angle of a joint alone is measured.
    pub(super) fn is_motor_side(&self, joint: usize) -> bool {
        self.recording.motor_side.get(joint).is_some_and(|alone| *alone)
    }

    /// Links that effects put behind springs whose far end nobody measured.
    pub(super) fn hidden(&self, effects: &[Effect]) -> Vec<Hidden> {
        let springs = effects.iter().filter(|effect| effect.kind.law == Law::SeriesElasticity);
        let behind = |spring: &Effect| {
            let joint = self.joint(spring).filter(|joint| self.is_motor_side(*joint))?;
            let behind = vec![[0.0; 3]; self.recording.samples()];
            Some(Hidden { joint, stiffness: spring.value("stiffness"), behind })
        };
        springs.filter_map(behind).collect()
    }

    /// What all links need, `samples × nv`, if these move behind their springs; `load` of states that are their motors', and
    /// `needed` of others.
    pub(super) fn load_behind_springs(
        &self,
        mut hidden: Vec<Hidden>,
        effects: &[Effect],
        (mut states, mut load): (Trajectory, Vec<f64>),
        needed: &dyn Fn(&Trajectory) -> Vec<f64>,
    ) -> Vec<f64> {
        let change = self.link_inertias.change(effects);
        for _ in 0..ROUNDS {
            for link in &mut hidden {
                self.move_link(link, effects, (&mut states, &load), &change);
            }
            load = needed(&states);
        }
        load
    }

    /// Puts a link where its motor and its spring leave it, by the slopes of what it needs at its last place.
    fn move_link(
        &self,
        link: &mut Hidden,
        effects: &[Effect],
        (states, load): (&mut Trajectory, &[f64]),
        change: &[f64],
    ) {
        let joint = link.joint;
        let load = self.rigid_torques(load, joint, change);
        let through = self.effort_residual(joint, &load, effects);
        let measured: Vec<f64> = through.iter().zip(&load).map(|(left, load)| left + load).collect();
        let resistance = self.resistance(joint);
        let with_motor = |((load, [e, _, a]), [inertia, slope]): ((&f64, &[f64; 3]), &[f64; 2])| {
            load - inertia * a - slope * e
        };
        let load: Vec<f64> = load.iter().zip(&link.behind).zip(resistance).map(with_motor).collect();
        let segments = &self.recording.segments;
        let equation =
            Link { load: &load, resistance, measured: &measured, segments, step: self.recording.step };
        let behind = equation.behind(link.stiffness);
        for order in 0..3 {
            let moved = link.behind.iter().zip(&behind).map(|(old, new)| new[order] - old[order]);
            states.joint_mut(order, joint).zip(moved).for_each(|(x, moved)| *x += moved);
        }
        link.behind = behind;
    }

    fn resistance(&self, joint: usize) -> &[[f64; 2]] {
        let (q, v) = (self.layout.base.nq() + joint, self.layout.base.nv() + joint);
        self.resistance[joint].get_or_init(|| self.rigid.resistance(&self.recording.trajectory, (q, v)))
    }

    /// Stiffnesses from which a search starts: behind them a link would swing with a few frequencies; N m/rad or N/m.
    pub(super) fn stiffnesses(&self, joint: usize) -> Vec<f64> {
        const RESONANCES_HZ: [f64; 6] = [1.5, 2.5, 4.0, 6.5, 11.0, 18.0];
        let resistance = self.resistance(joint);
        let inertia = resistance.iter().map(|r| r[0]).sum::<f64>() / resistance.len().max(1) as f64;
        RESONANCES_HZ.map(|hz| inertia * (TAU * hz).powi(2)).to_vec()
    }
}
