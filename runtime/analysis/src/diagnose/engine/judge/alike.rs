//! What is left behind two filters alike.
use crate::diagnose::engine::equations::regression::is_held_out;
use crate::diagnose::engine::refine::amended::Amended;
use crate::experiments::jumps::Jumps;
use crate::experiments::moving::moving;
use crate::experiments::{Channel, Experiment};
use bipedc_effects::effect::Effect;
use std::collections::BTreeMap;

/// Samples at times that differ by less than this part of a step are the same.
const SAME: f64 = 0.25;

/// Of every torque, what is left with these effects behind the filter of `judge` and behind the faster one of `closer` alike, N m or N: the root of
/// the mean product of both residuals. What the slower filter takes off the motion is left behind it alone, and noise that only the faster one
/// lets through behind that alone, so that neither counts. Of the samples that [`errors`](crate::diagnose::errors()) counts; rows without any are left out.
pub fn left_alike(
    (judge, closer): (&dyn Experiment, &dyn Experiment),
    effects: &[Effect],
    own_blocks: bool,
) -> BTreeMap<String, f64> {
    let counts = |sample: usize, n: usize| !own_blocks || is_held_out(sample, n);
    let [here, other] = [judge, closer].map(|experiment| Amended::new(experiment, effects));
    let jumps = Jumps::of(&here, effects);
    let Some(places) = places(here.time(), other.time()) else { return BTreeMap::new() };
    let of_row = |(row, what): (usize, &crate::experiments::Row)| {
        let same = |of: &crate::experiments::Row| of.name == what.name && of.channel == Channel::Effort;
        let theirs = other.residual(other.rows().iter().position(same)?);
        let ours = here.residual(row);
        let square = |sign: f64| {
            let values = ours.iter().zip(&places).map(|(x, place)| x + sign * theirs[*place]);
            let values: Vec<f64> = values.collect();
            let of_all = || root_mean_square(&values, &counts);
            let of_moving = || moving(&here, row, &values, &counts).map(|told| told.rms());
            jumps.away(&here, row, &values, &counts).or_else(of_moving).unwrap_or_else(of_all).powi(2)
        };
        // The mean of a product by those of squares.
        Some((what.name.clone(), (0.25 * (square(1.0) - square(-1.0))).max(0.0).sqrt()))
    };
    here.rows().iter().enumerate().filter_map(of_row).collect()
}

fn root_mean_square(values: &[f64], counts: &dyn Fn(usize, usize) -> bool) -> f64 {
    let n = values.len();
    let kept = || (0..n).filter(|i| counts(*i, n));
    (kept().map(|i| values[i].powi(2)).sum::<f64>() / kept().count().max(1) as f64).sqrt()
}

/// Where in `among` each of these times is; `None` where one is not.
fn places(times: &[f64], among: &[f64]) -> Option<Vec<usize>> {
    let step = times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let place = |time: &f64| {
        let next = among.partition_point(|other| other < time);
        let off = |k: usize| among.get(k).map_or(f64::INFINITY, |other| (other - time).abs());
        let nearest = if next > 0 && off(next - 1) < off(next) { next - 1 } else { next };
        (off(nearest) <= SAME * step).then_some(nearest)
    };
    times.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::places;

    #[test]
    fn times_are_found_among_others() {
        assert_eq!(places(&[1.0, 2.0, 3.0], &[0.0, 1.0001, 1.9999, 3.0, 4.0]), Some(vec![1, 2, 3]));
        assert_eq!(places(&[1.0, 2.0], &[1.0, 2.5]), None);
        assert_eq!(places(&[], &[]), Some(Vec::new()));
    }
}
