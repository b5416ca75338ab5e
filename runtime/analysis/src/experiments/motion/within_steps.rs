//! What nobody sees of joints that rest within a step of their encoders.
use super::experiment::MotionExperiment;
use super::motion_noise::NOISE_SAMPLES;
use crate::experiments::Channel;

impl MotionExperiment<'_> {
    /// By row, see [`Experiment::within_steps`](crate::experiments::Experiment::within_steps). On feet all moves, and rows have noise of their own.
    pub(super) fn unseen_within_steps(&self) -> Vec<[f64; 2]> {
        let (base, joints) = (self.layout.base, self.layout.joints.len());
        let nothing = vec![[0.0; 2]; self.rows.len()];
        let at_rest = &self.recording.at_rest;
        if !self.ground.is_empty() || at_rest.iter().all(|half| *half == 0.0) {
            return nothing;
        }
        let trajectory = &self.recording.trajectory;
        let square = self.quickness().powi(2);
        // Of each joint's row: what every angle makes, their squares, and the squares of what motions make.
        let mut sums = vec![[0.0; 3]; joints];
        for (resting, half) in at_rest.iter().enumerate().filter(|(_, half)| **half > 0.0) {
            let turned = self.rigid.displaced(trajectory, base.nq() + resting, (*half, NOISE_SAMPLES));
            let pushed = self.rigid.inertia_column(trajectory, base.nv() + resting, NOISE_SAMPLES);
            let mean_square = |values: &[f64], joint: usize| {
                let row = values.iter().skip(base.nv() + joint).step_by(self.rigid.nv);
                let (sum, count) = row.fold((0.0, 0.0_f64), |(sum, n), x| (sum + x * x, n + 1.0));
                sum / count.max(1.0)
            };
            for (joint, [most, squares, motions]) in sums.iter_mut().enumerate() {
                let turned = mean_square(&turned, joint);
                *most += turned.sqrt();
                *squares += turned;
                *motions += mean_square(&pushed, joint) * (half * square).powi(2) / 3.0;
            }
        }
        // Any place within a step is as likely: three standard deviations of all of them together, and of motions that nobody sees.
        let of_joint =
            |[most, squares, motions]: [f64; 3]| [most.min((3.0 * squares).sqrt()), 3.0 * motions.sqrt()];
        let rows = self.rows.iter().zip(&self.joint_of);
        rows.map(
            |(row, joint)| if row.channel == Channel::Effort { of_joint(sums[*joint]) } else { [0.0; 2] },
        )
        .collect()
    }

    /// How quickly joints move that are seen to move: accelerations by speeds, root mean squares, 1/s.
    fn quickness(&self) -> f64 {
        let recording = &self.recording;
        let mean_square = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0.0_f64), |(sum, n), x| (sum + x * x, n + 1.0));
            sum / count.max(1.0)
        };
        let moving = (0..self.layout.joints.len()).filter(|joint| recording.at_rest[*joint] == 0.0);
        let sums = moving.fold([0.0; 2], |[speeds, changes], joint| {
            let noise = recording.acceleration_noise.get(joint).map_or(0.0, |noise| noise.powi(2));
            let change = mean_square(&mut recording.trajectory.accelerations(joint)) - noise;
            [speeds + mean_square(&mut recording.trajectory.velocities(joint)), changes + change.max(0.0)]
        });
        (sums[1] / sums[0].max(f64::MIN_POSITIVE)).sqrt()
    }
}
