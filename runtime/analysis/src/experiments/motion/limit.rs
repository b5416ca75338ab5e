//! Where a drive may saturate: beyond its limit the true torque no longer follows the reported one.
use super::detrend::Detrend;

/// Part of the usual slope of the model's torque over the reading that may be left beyond the limit.
const LEFT: f64 = 0.5;
/// Fewest readings beyond the limit that say anything.
const FEWEST: usize = 20;
/// Most samples that a limit is sought in, and so many of the largest readings beside them.
const SAMPLES: usize = 2000;
/// Limits that are tried, the largest reading included.
const TRIED: usize = 80;
/// Part of the squares beside the other signals that a limit must explain.
const WORTH: f64 = 0.02;

/// The limit at which clipped readings leave least of a residual, beside what the other signals of the joint explain;
/// `None` if clipping hardly helps. Few readings may lie beyond it: motions reach their largest torques seldom.
pub(super) fn best(reading: &[f64], residual: &[f64], others: &[&[f64]]) -> Option<f64> {
    let mut by_size: Vec<usize> = (0..reading.len()).collect();
    by_size.sort_unstable_by(|a, b| reading[*b].abs().total_cmp(&reading[*a].abs()));
    let size = |rank: usize| reading[by_size[rank.min(by_size.len() - 1)]].abs();
    if by_size.len() < FEWEST {
        return None;
    }
    let stride = by_size.len().div_ceil(SAMPLES);
    let mut picked: Vec<usize> = (0..reading.len()).step_by(stride).collect();
    picked.extend(by_size.iter().take(SAMPLES));
    picked.sort_unstable();
    picked.dedup();
    let detrend = Detrend::new(&picked, others);
    let left = |limit: f64| -> f64 {
        let clipped = picked.iter().map(|&i| residual[i] - (reading[i] - reading[i].clamp(-limit, limit)));
        detrend.of_picked(clipped).iter().map(|x| x * x).sum()
    };
    // From nearly half of the readings beyond the limit to a handful of them: with more, clipping makes a sign of the
    // reading, and that is like friction.
    let (low, high) = (size(by_size.len() * 9 / 20), size(FEWEST / 4));
    // Readings that are zero but for a few have no limit.
    if high <= 0.0 {
        return None;
    }
    let tried = |k: usize| low.max(1e-3 * high) * (high / low.max(1e-3 * high)).powf(k as f64 / TRIED as f64);
    let all: Vec<f64> = (0..TRIED).map(|k| left(tried(k))).collect();
    let least = (0..TRIED).min_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    (all[least] < (1.0 - WORTH) * left(f64::MAX)).then(|| tried(least))
}

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

/// Whether the load lies at the limit wherever readings surely exceed it, by more than their noise makes. Most readings may lie beyond a limit;
/// but then clipping makes a sign of the reading, and where the load says nothing of a limit, that is friction's.
pub(super) fn rests_at(reading: &[f64], load: &[f64], (limit, noise): (f64, f64)) -> bool {
    /// Part of the limit, and of the samples.
    const NEAR: f64 = 0.25;
    const MOST: f64 = 0.7;
    let beyond = || reading.iter().zip(load).filter(|(u, _)| u.abs() > limit + 2.0 * noise);
    let near = beyond().filter(|(u, load)| (**load * u.signum() - limit).abs() <= NEAR * limit).count();
    let count = beyond().count();
    count >= FEWEST && near as f64 >= MOST * count as f64
}

/// Where the load lies while readings are largest, if it lies at one value then that is far below them: the limit of a drive whose commands
/// run away from it, by the load alone. Noise of the readings may be larger than such a limit.
pub(super) fn rested_at(reading: &[f64], load: &[f64], noise: f64) -> Option<f64> {
    /// Largest readings over their limit, and the correlation with which a load follows them.
    const FAR: f64 = 2.0;
    const FOLLOWS: f64 = 0.6;
    let mut by_size: Vec<f64> = reading.iter().map(|u| u.abs()).collect();
    by_size.sort_unstable_by(f64::total_cmp);
    let [half, usual] = [2, 4].map(|part| by_size.get(by_size.len() - by_size.len() / part).copied());
    let pairs = reading.iter().zip(load).filter(|(u, _)| Some(u.abs()) > half);
    let mut pressed: Vec<f64> = pairs.map(|(u, load)| load * u.signum()).collect();
    pressed.sort_unstable_by(f64::total_cmp);
    let limit = pressed.get(pressed.len() / 2).copied().filter(|limit| *limit > 0.0)?;
    let is_pressed = usual? > FAR * limit && rests_at(reading, load, (limit, noise));
    let far = half.unwrap_or(0.0).max(limit + 2.0 * noise);
    let follows = |side: f64| {
        let pairs = reading.iter().zip(load).filter(|(u, _)| side * **u > far);
        let (readings, loads): (Vec<f64>, Vec<f64>) = pairs.map(|(u, load)| (*u, *load)).unzip();
        let [of_load, of_reading] =
            [(&readings, &loads), (&loads, &readings)].map(|(x, y)| Line::through(x, y, |_| true));
        of_load.covariance > FOLLOWS * (of_load.variance * of_reading.variance).sqrt()
    };
    (is_pressed && ![1.0, -1.0].into_iter().any(follows)).then_some(limit)
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
    fn a_limit_that_is_reached_seldom_is_found() {
        let time: Vec<f64> = (0..3500).map(|i| 0.004 * f64::from(i)).collect();
        let torque: Vec<f64> = time.iter().map(|t| 3.0 * (1.3 * t).sin() + 2.0 * (4.1 * t).cos()).collect();
        let speed: Vec<f64> = time.iter().map(|t| (2.2 * t).cos()).collect();
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            0.05 * ((state >> 40) as f64 / 16_777_216.0 - 0.5)
        };
        let mut residual_with = |limit: f64| -> Vec<f64> {
            let clip = |u: f64| u - u.clamp(-limit, limit);
            torque.iter().zip(&speed).map(|(u, v)| clip(*u) + 0.4 * v.signum() + noise()).collect()
        };
        let sign: Vec<f64> = speed.iter().map(|v| v.signum()).collect();
        for limit in [4.75, 4.4, 3.0] {
            let found = best(&torque, &residual_with(limit), &[&speed, &sign]).expect("a limit");
            assert!((found / limit - 1.0).abs() < 0.02, "{found} instead of {limit}");
        }
        assert_eq!(best(&torque, &residual_with(9.0), &[&speed, &sign]), None);
    }

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

    /// Noise of the readings is twice the limit, and readings run away to twenty times of it.
    #[test]
    fn a_limit_below_the_noise_is_where_the_load_rests() {
        let mut state = 7_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            4.0 * ((state >> 40) as f64 / 16_777_216.0 - 0.5)
        };
        let wanted: Vec<f64> = (0..3000).map(|i| 20.0 * (0.009 * f64::from(i)).sin()).collect();
        let reading: Vec<f64> = wanted.iter().map(|u| u + noise()).collect();
        let limited: Vec<f64> = wanted.iter().map(|u| u.clamp(-1.0, 1.0) + 0.02 * noise()).collect();
        let found = rested_at(&reading, &limited, 2.0).expect("a limit");
        assert!((found - 1.0).abs() < 0.05, "{found}");
        // A drive that gives what is asked, and one of which half is lost, rest nowhere.
        assert_eq!(rested_at(&reading, &wanted, 2.0), None);
        assert_eq!(rested_at(&reading, &wanted.iter().map(|u| 0.5 * u).collect::<Vec<f64>>(), 2.0), None);
        assert_eq!(rested_at(&reading[..10], &limited[..10], 2.0), None);
    }

    /// What lies between no torque and no torque was no number.
    #[test]
    fn a_drive_that_gives_no_torque_has_no_limit() {
        let residual: Vec<f64> = (0..500).map(|i| (0.1 * f64::from(i)).sin()).collect();
        let velocity: Vec<f64> = (0..500).map(|i| (0.07 * f64::from(i)).cos()).collect();
        assert_eq!(best(&[0.0; 500], &residual, &[&velocity]), None);
    }
}
