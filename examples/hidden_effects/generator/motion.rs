//! Motions: sums of sines within the joints' limits.
use super::random::Random;
use bipedc_compiler::description::model::{Joint, RobotDescription};
use std::f64::consts::TAU;

/// One joint's wanted motion.
#[derive(Debug, Clone)]
pub struct JointMotion {
    /// rad
    pub center: f64,
    /// Amplitude (rad), angular frequency (rad/s), phase (rad).
    waves: Vec<[f64; 3]>,
    /// Whether it stops again and again.
    pub rests: bool,
}

/// How long a motion with rests goes on until it has rested once, s; the part of that in which it moves.
const REST_EVERY: f64 = 2.5;
const MOVES: f64 = 0.7;
/// Its mean pace beside a motion without rests.
const PACE: f64 = 0.8;

/// The time of a motion without rests at which one with rests is, and its two derivatives; s. It speeds up and slows down smoothly.
fn warped(time: f64) -> [f64; 3] {
    let turn = (time / REST_EVERY).floor();
    let part = (time - turn * REST_EVERY) / (MOVES * REST_EVERY);
    let length = PACE * REST_EVERY;
    if part >= 1.0 {
        return [(turn + 1.0) * length, 0.0, 0.0];
    }
    let (sin, cos) = (TAU * part).sin_cos();
    let rate = PACE / MOVES;
    [turn * length + length * (part - sin / TAU), rate * (1.0 - cos), rate * TAU / (MOVES * REST_EVERY) * sin]
}

impl JointMotion {
    /// Around the middle of the joint's range, from slow waves of large and quick ones of small amplitude.
    fn draw(joint: &Joint, pace: f64, random: &mut Random) -> Self {
        let (low, high) = joint.position_limits.unwrap_or((-1.0, 1.0));
        let reach = (0.4 * (high - low)).min(0.55);
        let room = (0.5 * (high - low) - reach).max(0.0);
        let center = 0.5 * (low + high) + random.range(-0.7, 0.7) * room;
        let bands = [(0.1, 0.25), (0.3, 0.55), (0.6, 0.9), (1.0, 1.5), (2.0, 3.0)];
        let shares = [0.36, 0.32, 0.17, 0.11, 0.04];
        let waves = bands.iter().zip(shares).map(|(&(from, to), share)| {
            let amplitude = reach * share * random.range(0.8, 1.0);
            [amplitude, pace * TAU * random.range(from, to), random.range(0.0, TAU)]
        });
        Self { center, waves: waves.collect(), rests: false }
    }

    /// The same, stopping again and again.
    pub fn with_rests(self) -> Self {
        Self { rests: true, ..self }
    }

    /// Held in its middle.
    pub fn held(self) -> Self {
        Self { waves: Vec::new(), ..self }
    }

    /// Position, velocity and acceleration; rad, s.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let [at, rate, growth] = if self.rests { warped(time) } else { [time, 1.0, 0.0] };
        let [q, v, a] = self.moving(at);
        [q, v * rate, a * rate * rate + v * growth]
    }

    /// The same without rests.
    fn moving(&self, time: f64) -> [f64; 3] {
        let mut sum = [self.center, 0.0, 0.0];
        for &[amplitude, omega, phase] in &self.waves {
            let (sin, cos) = (omega * time + phase).sin_cos();
            sum[0] += amplitude * sin;
            sum[1] += amplitude * omega * cos;
            sum[2] -= amplitude * omega * omega * sin;
        }
        sum
    }
}

/// One motion per moving joint, in the order of the description; `pace` 1 is usual, less is slower.
pub fn draw(description: &RobotDescription, pace: f64, random: &mut Random) -> Vec<JointMotion> {
    let moving = description.joints.iter().filter(|joint| joint.kind.moves());
    moving.map(|joint| JointMotion::draw(joint, pace, random)).collect()
}
