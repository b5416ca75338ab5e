//! Where the controller wants a joint to be.
use std::f64::consts::TAU;

/// A motion of one joint.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// Mean and sines about it.
    Sines {
        /// rad
        mean: f64,
        /// None: the joint is held.
        terms: Vec<Sine>,
    },
    /// Through these points, with the slopes there (cubic between them); held before the first and after the last.
    Points {
        /// Increasing, s.
        time: Vec<f64>,
        /// rad
        position: Vec<f64>,
        /// rad/s
        velocity: Vec<f64>,
    },
}

/// `amplitude · (sin(2π frequency t + phase) − sin(phase))`, so that a motion begins at its mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// rad
    pub amplitude: f64,
    /// Hz
    pub frequency: f64,
    /// rad
    pub phase: f64,
}

impl Reference {
    /// Through points whose slopes are those of the parabolas through three neighbours.
    pub fn through(time: Vec<f64>, position: Vec<f64>) -> Self {
        let n = time.len();
        let slope = |i: usize| {
            if n < 2 || i == 0 || i + 1 == n {
                return 0.0;
            }
            let (before, after) = (time[i] - time[i - 1], time[i + 1] - time[i]);
            let rates = [(position[i] - position[i - 1]) / before, (position[i + 1] - position[i]) / after];
            (rates[0] * after + rates[1] * before) / (before + after)
        };
        let velocity = (0..n).map(slope).collect();
        Self::Points { time, position, velocity }
    }

    /// Position (rad) and velocity (rad/s) at a time (s).
    pub fn at(&self, t: f64) -> [f64; 2] {
        match self {
            Self::Sines { mean, terms } => {
                let mut found = [*mean, 0.0];
                for sine in terms {
                    let (s, c) = (TAU * sine.frequency * t + sine.phase).sin_cos();
                    found[0] += sine.amplitude * (s - sine.phase.sin());
                    found[1] += sine.amplitude * TAU * sine.frequency * c;
                }
                found
            }
            Self::Points { time, position, velocity } => {
                let next = time.partition_point(|x| *x <= t);
                if next == 0 {
                    return [position[0], 0.0];
                }
                if next == time.len() {
                    return [position[next - 1], 0.0];
                }
                let (i, h) = (next - 1, time[next] - time[next - 1]);
                hermite((t - time[i]) / h, h, [position[i], position[next]], [velocity[i], velocity[next]])
            }
        }
    }
}

/// The cubic with these values and slopes at both ends of a stretch of length `h`, at the part `s` of it.
fn hermite(s: f64, h: f64, p: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    let rise = p[1] - p[0];
    let c = 3.0 * rise - h * (2.0 * v[0] + v[1]);
    let d = h * (v[0] + v[1]) - 2.0 * rise;
    [p[0] + s * (h * v[0] + s * (c + s * d)), (h * v[0] + s * (2.0 * c + 3.0 * s * d)) / h]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope_fits(reference: &Reference, t: f64) {
        let h = 1e-6;
        let slope = (reference.at(t + h)[0] - reference.at(t - h)[0]) / (2.0 * h);
        assert!((slope - reference.at(t)[1]).abs() < 1e-7, "{t}: {slope} {:?}", reference.at(t));
    }

    #[test]
    fn velocities_are_derivatives() {
        let sine = Sine { amplitude: 0.3, frequency: 0.7, phase: 0.4 };
        let sines = Reference::Sines { mean: 0.1, terms: vec![sine] };
        assert_eq!(sines.at(0.0)[0], 0.1);
        let points = Reference::through(vec![0.0, 0.4, 1.0, 1.5], vec![0.0, 0.3, -0.2, 0.1]);
        for t in [0.1, 0.39, 0.7, 1.2] {
            slope_fits(&sines, t);
            slope_fits(&points, t);
        }
        assert_eq!(points.at(-1.0), [0.0, 0.0]);
        assert_eq!(points.at(0.4)[0], 0.3);
        assert_eq!(points.at(9.0), [0.1, 0.0]);
        // A parabola is met exactly inside.
        let square = Reference::through(vec![0.0, 0.5, 1.2, 2.0, 2.5], [0.0, 0.25, 1.44, 4.0, 6.25].into());
        assert!((square.at(1.0)[0] - 1.0).abs() < 1e-12 && (square.at(1.5)[1] - 3.0).abs() < 1e-12);
    }
}
