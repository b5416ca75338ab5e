//! Whether a drive may saturate: beyond its limit the true torque no longer follows the reported one.

/// Part of the usual slope of the model's torque over the reading that may be left beyond the limit.
const LEFT: f64 = 0.5;
/// Fewest readings beyond the limit that say anything.
const FEWEST: usize = 20;

/// Whether the load (what the rigid-body model needs) stays where it is while readings exceed the limit. Clipping a
/// drive that does not saturate hides large torques, and with them whatever is wrong there.
///
/// Slopes are compared with each other, so that gains do not matter.
pub(super) fn stays(reading: &[f64], load: &[f64], limit: f64) -> bool {
    let within = Line::through(reading, load, |u| u.abs() <= limit);
    let beyond = [1.0, -1.0].map(|side| Line::through(reading, load, |u| side * u > limit));
    let covariance: f64 = beyond.iter().map(|line| line.covariance).sum();
    let variance: f64 = beyond.iter().map(|line| line.variance).sum();
    let count: usize = beyond.iter().map(|line| line.count).sum();
    count < FEWEST || covariance * within.variance <= LEFT * within.covariance.max(0.0) * variance
}

/// Sums of a straight line through some samples.
struct Line {
    count: usize,
    variance: f64,
    covariance: f64,
}

impl Line {
    fn through(x: &[f64], y: &[f64], counts: impl Fn(f64) -> bool) -> Self {
        let picked: Vec<(f64, f64)> =
            x.iter().zip(y).filter(|(x, _)| counts(**x)).map(|(x, y)| (*x, *y)).collect();
        let count = picked.len();
        let mean = |of: fn(&(f64, f64)) -> f64| picked.iter().map(of).sum::<f64>() / count.max(1) as f64;
        let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
        Self {
            count,
            variance: picked.iter().map(|(x, _)| (x - mx).powi(2)).sum(),
            covariance: picked.iter().map(|(x, y)| (x - mx) * (y - my)).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_at_its_limit_stays_and_a_strong_one_does_not() {
        let reading: Vec<f64> = (0..2000).map(|i| 3.0 * (0.013 * f64::from(i)).sin()).collect();
        let clipped: Vec<f64> = reading.iter().map(|u| 1.3 * u.clamp(-2.0, 2.0)).collect();
        let strong: Vec<f64> = reading.iter().map(|u| 1.3 * u).collect();
        assert!(stays(&reading, &clipped, 2.0));
        assert!(!stays(&reading, &strong, 2.0));
        // A limit far below the true one: most of the readings beyond it are followed.
        let seldom: Vec<f64> = reading.iter().map(|u| 1.3 * u.clamp(-2.8, 2.8)).collect();
        assert!(!stays(&reading, &seldom, 1.0));
    }
}
