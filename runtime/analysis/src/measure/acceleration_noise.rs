//! What the noise of measured positions makes of accelerations.
use crate::log::Block;
use crate::measure::columns::Plan;
use crate::measure::noise::of_encoders;

/// A joint whose encoder says the same for so many samples rests.
const RESTS: usize = 64;

/// Noise of filtered accelerations, by joint.
pub(crate) struct AccelerationNoise {
    /// Variances of derivatives of filtered white noise of variance 1.
    gains: [f64; 3],
    /// Variance times samples.
    sums: Vec<f64>,
    samples: usize,
}

impl AccelerationNoise {
    pub fn new(plan: &Plan, gains: [f64; 3]) -> Self {
        Self { gains, sums: vec![0.0; plan.joints.len()], samples: 0 }
    }

    /// Adds what a block's samples tell.
    pub fn hear(&mut self, plan: &Plan, block: &Block<'_>) {
        let count = block.core.len();
        for (sum, columns) in self.sums.iter_mut().zip(&plan.joints) {
            let known = match (columns.velocity, columns.position) {
                (Some(velocity), _) => Some((velocity, self.gains[1])),
                (None, position) => position.map(|position| (position, self.gains[2])),
            };
            let Some((column, gain)) = known else { continue };
            let signal = &block.columns[column][block.core.clone()];
            // An encoder at rest is off by as much all the time.
            let moving = signal.chunks(RESTS).filter(|part| part.iter().any(|x| *x != part[0])).count();
            let moving = moving as f64 / signal.chunks(RESTS).len().max(1) as f64;
            *sum += gain * moving * of_encoders(signal, 1).powi(2) * count as f64;
        }
        self.samples += count;
    }

    /// One standard deviation by joint, rad/s² or m/s²; 0 where no motion is logged.
    pub fn levels(&self) -> Vec<f64> {
        let samples = self.samples.max(1) as f64;
        self.sums.iter().map(|sum| (sum / samples).sqrt()).collect()
    }
}
