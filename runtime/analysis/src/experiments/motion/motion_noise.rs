//! What the noise of the motion makes of rows: accelerations that are not so, through masses, rotors and springs.
use super::experiment::MotionExperiment;
use crate::experiments::noise::yielding;
use crate::experiments::{Channel, Row};
use bipedc_effects::effect::{Effect, Simulation};

/// Samples at which the noise's way through the model is computed.
pub(super) const NOISE_SAMPLES: usize = 16;

impl MotionExperiment<'_> {
    /// What the noise of accelerations makes of the efforts: through the mass matrix, and the rotors that the description has.
    pub(super) fn noise_of_motion(&self) -> Vec<f64> {
        let (recording, base) = (&self.recording, self.layout.base.nv());
        let trajectory = &recording.trajectory;
        let rotor = |joint: usize| -> f64 {
            let own = self.present.iter().filter(|e| self.joint(e) == Some(joint));
            let inertia = |effect: &Effect| match effect.kind.simulation {
                Simulation::Inertia(name) => Some(effect.value(name)),
                _ => None,
            };
            own.filter_map(inertia).sum()
        };
        let mut variances = vec![0.0; self.layout.joints.len()];
        for (moving, noise) in recording.acceleration_noise.iter().enumerate().filter(|(_, s)| **s > 0.0) {
            let column = self.rigid.inertia_column(trajectory, base + moving, NOISE_SAMPLES);
            for (joint, variance) in variances.iter_mut().enumerate() {
                let motor = if joint == moving { rotor(joint) } else { 0.0 };
                let squares = column.iter().skip(base + joint).step_by(self.rigid.nv);
                let squares: Vec<f64> = squares.map(|inertia| (inertia + motor).powi(2)).collect();
                *variance += noise.powi(2) * squares.iter().sum::<f64>() / squares.len().max(1) as f64;
            }
        }
        let yielding = |joint: usize| yielding(self.present.iter().filter(|e| self.joint(e) == Some(joint)));
        let of_row = |(row, joint): (&Row, &usize)| match row.channel {
            Channel::Effort => variances[*joint].sqrt(),
            // Through the springs that the description has.
            Channel::Transmission => yielding(*joint) * variances[*joint].sqrt(),
            _ => 0.0,
        };
        self.rows.iter().zip(&self.joint_of).map(of_row).collect()
    }
}
