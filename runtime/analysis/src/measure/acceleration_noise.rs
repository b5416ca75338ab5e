//! What the noise of measured positions makes of accelerations.
use crate::log::Block;
use crate::measure::columns::Plan;
use crate::measure::noise::of_encoders;

/// A joint whose encoder says the same for so many samples rests.
const RESTS: usize = 64;

/// Noise of what accelerations are derived from, by joint; filters come in at the end, so that one reading serves all of them.
pub(crate) struct AccelerationNoise {
    /// Variance times samples: rad² or m² of a position, of a velocity per s² more.
    sums: Vec<f64>,
    /// Whether it is the velocity's.
    of_velocity: Vec<bool>,
    samples: usize,
}

impl AccelerationNoise {
    pub fn new(plan: &Plan) -> Self {
        let of_velocity = plan.joints.iter().map(|columns| columns.velocity.is_some()).collect();
        Self { sums: vec![0.0; plan.joints.len()], of_velocity, samples: 0 }
    }

    /// Adds what a block's samples tell.
    pub fn hear(&mut self, plan: &Plan, block: &Block<'_>) {
        let count = block.core.len();
        for (sum, columns) in self.sums.iter_mut().zip(&plan.joints) {
            let Some(column) = columns.velocity.or(columns.position) else { continue };
            let signal = &block.columns[column][block.core.clone()];
            // An encoder at rest is off by as much all the time.
            let moving = signal.chunks(RESTS).filter(|part| part.iter().any(|x| *x != part[0])).count();
            let moving = moving as f64 / signal.chunks(RESTS).len().max(1) as f64;
            *sum += moving * of_encoders(signal, 1).powi(2) * count as f64;
        }
        self.samples += count;
    }

    /// One standard deviation of the acceleration by joint, rad/s² or m/s², behind a filter of these
    /// [`noise_gains`](crate::measure::filtered::noise_gains); 0 where no motion is logged.
    pub fn levels(&self, [_, first, second]: [f64; 3]) -> Vec<f64> {
        let samples = self.samples.max(1) as f64;
        let joints = self.sums.iter().zip(&self.of_velocity);
        joints
            .map(|(sum, of_velocity)| (if *of_velocity { first } else { second } * sum / samples).sqrt())
            .collect()
    }
}
