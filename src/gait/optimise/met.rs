//! Which limits a motion meets: what stands in the way of a faster one.
use super::constraints::Builder;
use super::demands::Demands;
use super::similarity::{Measure, Similarity};
use super::transcription::Transcription;
use super::{Optimum, SLOWEST};
use bipedc_analysis::nonlinear::Program;
use bipedc_compiler::compile::Collocation;

/// A limit counts as met within this part of what is allowed.
const NEAR: f64 = 2e-3;

impl Optimum {
    /// Mean walking speed, m/s.
    pub fn speed(&self) -> f64 {
        self.step_length() / self.durations().iter().sum::<f64>()
    }

    /// The same motion as a beginning for another speed (m/s): the slowest allowed rates of the phase variables follow a slower one.
    #[must_use]
    pub fn towards(&self, speed: f64) -> Self {
        let slower = (speed / self.speed()).min(1.0);
        Self { rates: self.rates.iter().map(|rate| slower * rate).collect(), iterations: 0, ..self.clone() }
    }

    /// Limits that this motion meets somewhere, each once: torques, speeds and stops of joints, then what the rows of the program allow.
    pub fn limits_met(&self, of: &Collocation, demands: &Demands) -> Vec<String> {
        let similar = Similarity::new(of, self.height);
        let rates: Vec<f64> = self.rates.iter().map(|rate| SLOWEST * rate).collect();
        let builder = Builder {
            of,
            layout: &self.layout,
            similar,
            coordinates: &Measure::of_coordinates(of),
            demands,
            outputs: true,
            rates: &rates,
            regular: &self.regular,
            parts: &self.parts,
            height: self.height,
        };
        let program =
            Transcription::new(of, self.layout.clone(), (builder.rows(), similar), demands, &self.x);
        let x = program.scaled(&self.x);
        let mut found = self.of_joints(of, &x, &program.bounds());
        let mut values = vec![0.0; program.rows.limits.len()];
        program.constraints(&x, &mut values);
        for (row, [low, high]) in program.rows.limits.iter().enumerate() {
            // Equations are no limits; what is asked of one side alone is compared with 1, which is much of every row.
            let range = if high - low < f64::INFINITY { high - low } else { 1.0 };
            let left = (values[row] - low).min(high - values[row]);
            if range > 0.0 && left < NEAR * range {
                tell(&mut found, program.rows.names[row].what.clone());
            }
        }
        found
    }

    /// Of the joints, at any node.
    fn of_joints(&self, of: &Collocation, x: &[f64], bounds: &[[f64; 2]]) -> Vec<String> {
        let mut found = Vec::new();
        let met = |place: usize| {
            let [low, high] = bounds[place];
            (x[place] - low).min(high - x[place]) < NEAR * (high - low)
        };
        for (p, phase) in self.layout.phases.iter().enumerate() {
            for node in 0..phase.nodes() {
                let [q, v] = [0, 1].map(|order| self.layout.motion(p, node, order));
                for (k, joint) in of.tree.joints.iter().enumerate() {
                    let places = [
                        ("torque of", self.layout.torques(p, node) + k),
                        ("speed of", v + joint.v_index),
                        ("stop of", q + joint.v_index),
                    ];
                    for (what, _) in places.into_iter().filter(|(_, place)| met(*place)) {
                        tell(&mut found, format!("{what} {}", joint.name));
                    }
                }
                if met(q + 2) {
                    tell(&mut found, "lean of the base".to_owned());
                }
            }
        }
        found
    }
}

fn tell(found: &mut Vec<String>, what: String) {
    if !found.contains(&what) {
        found.push(what);
    }
}
