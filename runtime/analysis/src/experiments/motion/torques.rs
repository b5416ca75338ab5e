//! What is left of a joint's measured torque, and of the angle between its motor and link, under effects.
use super::experiment::MotionExperiment;
use super::laws::{advanced, torque_law};
use crate::robot::Trajectory;
use bipedc_effects::effect::{Acts, BoundLaw, Effect, Law, VARIABLES};
use std::borrow::Cow;
use std::ops::Range;

impl MotionExperiment<'_> {
    /// Motor minus joint angle, less what play and elasticity make of the transmitted torque.
    pub(super) fn transmission_residual(
        &self,
        joint: usize,
        rigid: &[f64],
        effects: &[Effect],
        links: &Trajectory,
    ) -> Vec<f64> {
        let transmitted = self.link_torques(joint, rigid, effects, links);
        let mut residual = self.recording.transmission[joint].clone().unwrap_or_default();
        for effect in effects.iter().filter(|e| self.joint(e) == Some(joint)) {
            let angle: &dyn Fn(f64) -> f64 = match effect.kind.law {
                // The play rests on the side to which the torque pushes; a small torque has not moved it yet.
                Law::Backlash => {
                    let (half, smoothing) = (0.5 * effect.value("gap"), effect.value("smoothing"));
                    &move |torque: f64| half * (torque / smoothing).tanh()
                }
                Law::SeriesElasticity => &|torque| torque / effect.value("stiffness"),
                _ => continue,
            };
            residual.iter_mut().zip(&transmitted).for_each(|(r, torque)| *r -= angle(*torque));
        }
        residual
    }

    /// Measured minus predicted torque of a joint, zero where a stop carries the rest, and where a delayed torque acts after the end or was needed before the begin; `rigid` is what the rigid model needs, `links` the states of all links.
    pub(super) fn effort_residual(
        &self,
        joint: usize,
        rigid: &[f64],
        effects: &[Effect],
        links: &Trajectory,
    ) -> Vec<f64> {
        let here: Vec<&Effect> = effects.iter().filter(|e| self.joint(e) == Some(joint)).collect();
        let mut torque = self.link_torques(joint, rigid, effects, links);
        let offset = self.encoder_offset(joint, effects);
        for effect in here.iter().filter(|effect| effect.kind.simulation.is_on_motor()) {
            self.add_torque((joint, offset), effect, rigid, links, &mut torque);
        }
        let mut measured = self.recording.effort[joint].clone().unwrap_or_default();
        let mut late = 0.0;
        let follow = |text: &str, name: &str, effect: &Effect, signal: &mut Vec<f64>| {
            if let Ok(law) = BoundLaw::new(text, &[name], effect) {
                *signal = law.at_all(signal.len(), 1, &|_| Cow::from(&**signal));
            }
        };
        for effect in &here {
            match effect.kind.law {
                Law::Reading(text) => follow(text, "torque", effect, &mut torque),
                Law::TrueTorque(text) => follow(text, "reading", effect, &mut measured),
                Law::Delay => {
                    let steps = effect.value("delay") / self.recording.step;
                    torque = advanced(&torque, &self.recording.segments, steps);
                    late += steps;
                }
                // Torques are added above; nothing else is in the signal.
                law => debug_assert!(!matches!(law.acts(), Acts::Reading | Acts::Time)),
            }
        }
        let mut residual: Vec<f64> = measured.iter().zip(&torque).map(|(u, t)| u - t).collect();
        let at_stop = residual.iter_mut().zip(&self.at_stop[joint]).filter(|(_, at_stop)| **at_stop);
        at_stop.for_each(|(left, _)| *left = 0.0);
        self.beyond(late).for_each(|samples| residual[samples].fill(0.0));
        residual
    }

    /// Samples so many steps before the ends of stretches, or behind their begins, whose torques act when nothing is known.
    fn beyond(&self, steps: f64) -> impl Iterator<Item = Range<usize>> {
        let unknown = if steps == 0.0 { 0 } else { steps.abs().ceil() as usize + 1 };
        let stretches = self.recording.segments.iter();
        stretches.map(move |stretch| {
            if steps < 0.0 {
                stretch.start..(stretch.start + unknown).min(stretch.end)
            } else {
                stretch.end.saturating_sub(unknown).max(stretch.start)..stretch.end
            }
        })
    }

    /// What the transmission carries to a link: what the rigid model needs, and effects on the link's side.
    pub(super) fn link_torques(
        &self,
        joint: usize,
        rigid: &[f64],
        effects: &[Effect],
        links: &Trajectory,
    ) -> Vec<f64> {
        let mut torque = rigid.to_vec();
        let on_link = |e: &&Effect| self.joint(e) == Some(joint) && !e.kind.simulation.is_on_motor();
        for effect in effects.iter().filter(on_link) {
            self.add_torque((joint, 0.0), effect, rigid, links, &mut torque);
        }
        torque
    }

    /// By how much the logged angle of a motor is larger than its true one: that of the joint, unless the motor has an encoder of its own.
    fn encoder_offset(&self, joint: usize, effects: &[Effect]) -> f64 {
        let is_own = matches!(self.recording.motors.get(joint), Some(Some(_)));
        let here = |e: &&Effect| e.kind.law == Law::EncoderOffset && self.joint(e) == Some(joint) && !is_own;
        effects.iter().filter(here).map(|effect| effect.value("offset")).sum()
    }

    /// Adds what the law of an effect makes of the motion on its side of the transmission, if it is a torque; `offset`: of the motor's angle.
    fn add_torque(
        &self,
        (joint, offset): (usize, f64),
        effect: &Effect,
        rigid: &[f64],
        links: &Trajectory,
        torque: &mut [f64],
    ) {
        let effect = &*self.as_it_jumps(joint, effect);
        let Some(law) = torque_law(effect) else { return };
        let other = self.index(effect.location.other_joint.as_deref()).unwrap_or(joint);
        let on_motor = effect.kind.simulation.is_on_motor();
        let as_logged = std::ptr::eq(links, &raw const self.recording.trajectory);
        let of_link = |joint: usize, order: usize| match as_logged {
            true => Cow::from(self.of_link(joint, order)),
            false => (0..torque.len()).map(|i| links.joint_at(i, joint)[order]).collect(),
        };
        let added = law.at_all(torque.len(), VARIABLES.len(), &|variable| match variable {
            0 if on_motor && offset != 0.0 => self.of_motor(joint, 0).iter().map(|x| x - offset).collect(),
            0..3 if on_motor => self.of_motor(joint, variable).into(),
            0..3 => of_link(joint, variable),
            3 => rigid.into(),
            _ => of_link(other, variable - 4),
        });
        torque.iter_mut().zip(added).for_each(|(torque, added)| *torque += added);
    }

    /// Motion of a joint's motor as seen from the joint, where it was measured; else that of the joint.
    pub(super) fn motor_at(&self, sample: usize, joint: usize) -> [f64; 3] {
        match self.recording.motors.get(joint) {
            Some(Some(motor)) => motor[sample],
            _ => self.recording.trajectory.joint_at(sample, joint),
        }
    }

    /// The same at all samples: angle, velocity, acceleration.
    pub(super) fn motion_of_motor(&self, joint: usize) -> [Vec<f64>; 3] {
        let of =
            |order: usize| (0..self.recording.samples()).map(|i| self.motor_at(i, joint)[order]).collect();
        [of(0), of(1), of(2)]
    }
}
