//! Readings that stray alone: electrical noise, lost bits. They are noise, of which medians see nothing.
//!
//! Where a joint turns about, friction that jumps a sample early or late leaves the same: that is no noise.
use super::noise::white_noise;

/// So many samples on either side tell where a reading should be.
const BESIDE: usize = 2;
/// A reading strays that is so many standard deviations of the noise away, while those beside it are not.
const FAR: f64 = 5.0;
/// And so many times as far as those beside it lie apart.
const BEYOND: f64 = 1.5;
/// Beside so many samples more a joint that turns about may make it.
const TURN: usize = 2;
/// Fewer say nothing, and where more than this part of all do so it is no rare thing.
const FEWEST: usize = 5;
const MOST: f64 = 0.1;

/// A residual without the readings that stray alone.
pub(super) struct Strays {
    /// The residual with what its neighbours say in their places.
    pub rest: Vec<f64>,
    /// Root mean square over all samples of what they stray by, unit of the residual.
    pub rms: f64,
}

impl Strays {
    /// `None` where there are none to speak of. `velocity` of the joint, one per sample, or empty where it is not known.
    pub fn of(residual: &[f64], velocity: &dyn Fn() -> Vec<f64>) -> Option<Self> {
        let far = FAR * white_noise(residual);
        // By how much a reading is off, and how far those beside it lie apart: what is smooth is off by less.
        let off = |i: usize| {
            let mut near = [i - 2, i - 1, i + 1, i + 2].map(|k| residual[k]);
            near.sort_unstable_by(f64::total_cmp);
            (residual[i] - 0.5 * (near[1] + near[2]), near[3] - near[0])
        };
        let offs: Vec<(f64, f64)> = (BESIDE..residual.len().saturating_sub(BESIDE)).map(off).collect();
        let is_far = |k: usize| offs.get(k).is_some_and(|(off, _)| off.abs() > far);
        let alone = |k: usize| {
            let beside = [k.checked_sub(1), Some(k + 1)];
            is_far(k) && offs[k].0.abs() > BEYOND * offs[k].1 && !beside.into_iter().flatten().any(is_far)
        };
        let mut found: Vec<usize> = (0..offs.len()).filter(|k| far > 0.0 && alone(*k)).collect();
        if found.len() < FEWEST {
            return None;
        }
        let velocity = velocity();
        let turns = |k: &usize| {
            let near = velocity.get(k.saturating_sub(TURN)..(k + 2 * BESIDE + TURN).min(velocity.len()));
            near.is_some_and(|near| near.iter().any(|v| *v > 0.0) && near.iter().any(|v| *v <= 0.0))
        };
        let all = found.len();
        found.retain(|k| !turns(k));
        if 2 * found.len() < all || found.len() < FEWEST || found.len() as f64 > MOST * residual.len() as f64
        {
            return None;
        }
        let mut rest = residual.to_vec();
        found.iter().for_each(|k| rest[k + BESIDE] -= offs[*k].0);
        let squares: f64 = found.iter().map(|k| offs[*k].0.powi(2)).sum();
        Some(Self { rest, rms: (squares / residual.len() as f64).sqrt() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::residual_noise::residual_noise;
    use super::*;
    use bipedc_effects::random::Random;

    fn velocity(count: usize) -> Vec<f64> {
        (0..count).map(|i| (0.015 * i as f64).cos()).collect()
    }

    fn rms(values: &[f64]) -> f64 {
        (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt()
    }

    #[test]
    fn noise_of_which_some_readings_stray_has_the_size_it_has() {
        for (seed, (part, times)) in
            [(0.01, 10.0), (0.02, 10.0), (0.01, 6.0), (0.004, 30.0)].into_iter().enumerate()
        {
            let mut random = Random::new(seed as u64 + 1);
            let mut next = || {
                let size = if random.unit() < part { times } else { 1.0 };
                size * random.normal()
            };
            let noise: Vec<f64> = (0..6000).map(|_| next()).collect();
            let found = residual_noise(&noise, || velocity(6000), f64::INFINITY).unwrap() / rms(&noise);
            assert!((found - 1.0).abs() < 0.06, "{part} of {times}: {found}");
        }
    }

    #[test]
    fn what_the_motion_leaves_does_not_stray() {
        let mut random = Random::new(5);
        let friction: Vec<f64> =
            velocity(6000).iter().map(|v| 4.0 * v.signum() + 0.3 * random.normal()).collect();
        assert!(Strays::of(&friction, &|| velocity(6000)).is_none());
        // A sample late, the sign leaves a spike at every reversal.
        let signs: Vec<f64> = velocity(6000).iter().map(|v| v.signum()).collect();
        let late = |i: usize| 4.0 * (signs[i] - signs[i.saturating_sub(1)]) + 0.3 * random.normal();
        let late: Vec<f64> = (0..6000).map(late).collect();
        assert!(Strays::of(&late, &Vec::new).is_some() && Strays::of(&late, &|| velocity(6000)).is_none());
        let strikes: Vec<f64> =
            (0..6000).map(|i| if i % 200 < 4 { 9.0 } else { 0.0 } + 0.3 * random.normal()).collect();
        assert!(Strays::of(&strikes, &Vec::new).is_none());
        let white: Vec<f64> = (0..6000).map(|_| random.normal()).collect();
        assert!(Strays::of(&white, &Vec::new).is_none_or(|strays| strays.rms < 0.2));
    }
}
