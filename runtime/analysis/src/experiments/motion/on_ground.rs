//! Links behind motors in legs on the ground, where only the motors' angles are measured.
//!
//! Behind a spring q = θ − s / k, with s the joint's effort less what effects take on the motor's side: what a foot on the ground lets a link
//! do is not the link's own equation, since the whole robot moves over it, but s was measured. Behind play the link rests and flies as in
//! `hidden_play`, under what the measured forces of the feet and the measured motion of the base leave its transmission to carry.
use super::experiment::{MotionExperiment, less};
use super::motor_side::Hidden;
use super::under_effects::Turned;
use crate::signal::Spline;
use bipedc_effects::effect::Effect;
use std::sync::{Arc, OnceLock};

/// So often what a link behind play carries is computed anew where the last round has put it.
const ROUNDS: usize = 2;
/// Deflections of springs from which a search starts, where the joint carries what it usually does; rad (m where it slides).
const DEFLECTIONS: [f64; 4] = [0.05, 0.02, 0.008, 0.003];

/// What effects make of a robot on the ground.
pub(crate) struct OnGround {
    /// Generalised forces of the ground on the robot, `samples × nv`; N, N m.
    pub forces: Vec<f64>,
    /// Links that move behind their motors.
    pub behind: Vec<Hidden>,
    /// What the rigid model needs of its joints there, when first asked for: see [`MotionExperiment::turned_load`].
    pub(super) load: OnceLock<Arc<Turned>>,
}

impl OnGround {
    pub fn new(forces: Vec<f64>, behind: Vec<Hidden>) -> Self {
        Self { forces, behind, load: OnceLock::new() }
    }
}

impl MotionExperiment<'_> {
    /// Links that effects put behind their motors; `forces` are those of the ground, as in [`OnGround`], with links there. A joint
    /// without an effort moves as its motor.
    pub(crate) fn behind_motors(
        &self,
        effects: &[Effect],
        forces: &dyn Fn(&[Hidden]) -> Vec<f64>,
    ) -> Vec<Hidden> {
        let mut links = self.hidden(effects);
        links.retain(|link| self.recording.effort[link.joint].is_some());
        for link in links.iter_mut().filter(|link| link.gap == 0.0) {
            link.behind = self.deflected(link.yielding, &self.carried(link.joint, effects));
        }
        if links.iter().all(|link| link.gap == 0.0) {
            return links;
        }
        let change = self.link_inertias.change(effects);
        let mut motors = self.recording.trajectory.clone();
        motors.q = self.turned_positions(effects).unwrap_or(motors.q);
        for _ in 0..ROUNDS {
            let mut states = motors.clone();
            links.iter().for_each(|link| link.add_to(&mut states));
            let load = less(self.rigid.inverse_dynamics(&states.q, &states.v, &states.a), &forces(&links));
            for link in links.iter_mut().filter(|link| link.gap > 0.0) {
                self.move_link(link, effects, (&mut states, &load), (&change, None));
            }
        }
        links
    }

    /// What goes through a joint's transmission, from its effort; N m or N.
    fn carried(&self, joint: usize, effects: &[Effect]) -> Vec<f64> {
        let motion = &self.recording.trajectory;
        let rigid: Vec<f64> = self.strided(&self.load, joint).collect();
        let left = self.effort_residual(joint, &rigid, effects, motion);
        let load = self.link_torques(joint, &rigid, effects, motion);
        left.iter().zip(load).map(|(left, load)| left + load).collect()
    }

    /// Link minus motor behind a spring that these torques go through; they passed the filter as angles do.
    fn deflected(&self, yielding: f64, carried: &[f64]) -> Vec<[f64; 3]> {
        let mut motion = vec![[0.0; 3]; carried.len()];
        for segment in &self.recording.segments {
            let angles: Vec<f64> = carried[segment.clone()].iter().map(|torque| -yielding * torque).collect();
            let Some(spline) = Spline::new(&angles, self.recording.step) else { continue };
            let motion = motion[segment.clone()].iter_mut().enumerate();
            motion.for_each(|(i, motion)| *motion = spline.at_sample(i));
        }
        motion
    }

    /// Stiffnesses from which a search starts in a leg on the ground, N m/rad or N/m; none where nothing goes through the joint.
    pub(super) fn stiffnesses_on_ground(&self, joint: usize) -> Vec<f64> {
        let carried = self.carried(joint, &[]);
        let square = carried.iter().map(|torque| torque * torque).sum::<f64>() / carried.len().max(1) as f64;
        let usual = square.sqrt();
        if usual <= self.recording.noise[joint] || usual < 1e-9 {
            return Vec::new();
        }
        DEFLECTIONS.map(|deflection| usual / deflection).to_vec()
    }
}
