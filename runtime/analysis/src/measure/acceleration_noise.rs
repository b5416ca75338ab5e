//! What the noise of measured positions makes of accelerations.
use crate::log::Block;
use crate::measure::columns::Plan;
use crate::measure::filtered::noise_gains;
use crate::measure::noise::{of_encoders, rounding_step};
use crate::parallel::parallel;
use crate::signal::{Butterworth, Spline};

/// A joint whose encoder says the same for so many samples rests.
const RESTS: usize = 64;
/// Places between two steps of an encoder at which its rounding is computed.
const PLACES: usize = 4;

/// Noise of what accelerations are derived from, by joint; filters come in at the end, so that one reading serves all of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct AccelerationNoise {
    /// Variance times samples: rad² or m² of a position, of a velocity per s² more.
    sums: Vec<f64>,
    /// Whether it is the velocity's.
    of_velocity: Vec<bool>,
    samples: usize,
    /// Positions that are rounded to steps, of the first block.
    rounded: Vec<Option<Rounded>>,
    /// Lowest and highest position by joint.
    spans: Vec<[f64; 2]>,
}

/// Angles as an encoder tells them, and its step.
#[derive(Debug, Clone)]
struct Rounded {
    angles: Vec<f64>,
    step: f64,
}

impl AccelerationNoise {
    pub fn new(plan: &Plan) -> Self {
        let of_velocity = plan.joints.iter().map(|columns| columns.velocity.is_some()).collect();
        let (joints, nowhere) = (plan.joints.len(), [f64::INFINITY, f64::NEG_INFINITY]);
        Self { sums: vec![0.0; joints], spans: vec![nowhere; joints], of_velocity, ..Self::default() }
    }

    /// Adds what a block's samples tell.
    pub fn hear(&mut self, plan: &Plan, block: &Block<'_>) {
        let count = block.core.len();
        if self.samples == 0 {
            let positions =
                plan.joints.iter().map(|columns| columns.position.filter(|_| columns.velocity.is_none()));
            self.rounded = positions.map(|column| Rounded::of(&block.columns[column?])).collect();
        }
        let heard = parallel(plan.joints.len(), |joint| {
            let columns = &plan.joints[joint];
            let signal = &block.columns[columns.velocity.or(columns.position)?][block.core.clone()];
            // An encoder at rest is off by as much all the time.
            let moving = signal.chunks(RESTS).filter(|part| part.iter().any(|x| *x != part[0])).count();
            let moving = moving as f64 / signal.chunks(RESTS).len().max(1) as f64;
            Some(moving * of_encoders(signal, 1).powi(2) * count as f64)
        });
        self.sums.iter_mut().zip(heard).for_each(|(sum, heard)| *sum += heard.unwrap_or(0.0));
        for (span, columns) in self.spans.iter_mut().zip(&plan.joints) {
            let positions =
                columns.position.map_or(&[][..], |column| &block.columns[column][block.core.clone()]);
            *span = positions.iter().fold(*span, |[low, high], q| [low.min(*q), high.max(*q)]);
        }
        self.samples += count;
    }

    /// Half a step of the encoder of each joint that rests within a step all along: where in it the joint is nobody knows. 0 of other joints. An encoder that
    /// always says the same shows no steps: it is taken for as coarse as any of its `sort`, by joint.
    pub fn at_rest(&self, sort: &[bool]) -> Vec<f64> {
        let own =
            |joint: usize| self.rounded.get(joint).and_then(Option::as_ref).map_or(0.0, |told| told.step);
        let of_joint = |joint: usize| {
            let alike = (0..sort.len()).filter(|other| sort[*other] == sort[joint]);
            let step = if own(joint) > 0.0 { own(joint) } else { alike.map(own).fold(0.0, f64::max) };
            let [low, high] = self.spans[joint];
            // From one to the next and back: it is between the two.
            if (0.0..1.5 * step).contains(&(high - low)) { 0.5 * step } else { 0.0 }
        };
        (0..sort.len()).map(of_joint).collect()
    }

    /// One standard deviation of the acceleration by joint, rad/s² or m/s², where samples are `step` s apart and pass the filter so
    /// often; 0 where no motion is logged.
    pub fn levels(&self, filter: &Butterworth, step: f64, passes: usize) -> Vec<f64> {
        let samples = self.samples.max(1) as f64;
        let [_, first, second] = noise_gains(filter, step, passes);
        let white = |joint: usize| {
            let gain = if self.of_velocity[joint] { first } else { second };
            (gain * self.sums[joint] / samples).sqrt()
        };
        let of_joint = |joint: usize| {
            let rounded = self.rounded.get(joint).and_then(Option::as_ref);
            rounded
                .and_then(|rounded| rounded.acceleration(filter, step, passes))
                .unwrap_or_else(|| white(joint))
        };
        (0..self.sums.len()).map(of_joint).collect()
    }
}

impl Rounded {
    /// If an angle is rounded and has no other noise.
    fn of(angles: &[f64]) -> Option<Self> {
        rounding_step(angles).map(|step| Self { angles: angles.to_vec(), step })
    }

    /// What rounding makes of the acceleration: of a slow joint it is no white noise, but repeats itself as often as the joint passes
    /// a step. The motion behind the filter is rounded anew, with the joint here and there between two steps.
    fn acceleration(&self, filter: &Butterworth, step: f64, passes: usize) -> Option<f64> {
        let motion = filter.zero_phase(&self.angles);
        let mut squares = 0.0;
        for place in 0..PLACES {
            let shift = self.step * place as f64 / PLACES as f64;
            let rounded = |angle: f64| ((angle + shift) / self.step).round() * self.step - shift - angle;
            let error: Vec<f64> = motion.iter().map(|angle| rounded(*angle)).collect();
            let left = (0..passes).fold(error, |signal, _| filter.zero_phase(&signal));
            let spline = Spline::new(&left, step)?;
            squares +=
                (0..left.len()).map(|i| spline.at_sample(i)[2].powi(2)).sum::<f64>() / left.len() as f64;
        }
        Some((squares / PLACES as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The noise of a slow joint behind coarse steps, against what rounding really does to its acceleration.
    #[test]
    fn rounding_of_slow_motions_is_no_white_noise() {
        let (step, dt) = (1.5e-3, 2e-3);
        for (cutoff, amplitude) in [(5.0, 0.01), (5.0, 0.05), (5.0, 0.3), (20.0, 0.05), (20.0, 0.3)] {
            let filter = Butterworth::new(cutoff, 1.0 / dt).unwrap();
            let (mut real, mut told) = (0.0, 0.0);
            for phase in 0..8 {
                let at = |i: usize| {
                    let t = dt * i as f64;
                    let phase = f64::from(phase);
                    amplitude * ((2.1 * t + phase).sin() + 0.4 * (5.3 * t + 2.0 * phase).sin()) + 1e-4 * phase
                };
                let angles: Vec<f64> = (0..8000).map(|i| (at(i) / step).round() * step).collect();
                let error: Vec<f64> = angles.iter().enumerate().map(|(i, seen)| seen - at(i)).collect();
                let left = Spline::new(&filter.zero_phase(&error), dt).unwrap();
                let inside = 800..7200;
                let count = inside.len() as f64;
                real += inside.map(|i| left.at_sample(i)[2].powi(2)).sum::<f64>() / count;
                let rounded = Rounded::of(&angles).unwrap();
                told += rounded.acceleration(&filter, dt, 1).unwrap().powi(2);
            }
            let ratio = (told / real).sqrt();
            assert!((0.7..1.2).contains(&ratio), "{cutoff} Hz, {amplitude} rad: {ratio}");
        }
    }
}
