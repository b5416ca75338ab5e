//! Where a residual repeats with the joint's angle: seeds for torque ripple.
use super::detrend::Detrend;
use std::f64::consts::TAU;

/// Most samples that are used.
const SAMPLES: usize = 3000;
/// Most periods per turn that are looked for.
const FINEST: f64 = 600.0;
/// Widest range of angles that is looked at, rad: a joint that turns on and on, or one wrong sample, must not multiply
/// the lines to be told apart.
const WIDEST: f64 = 64.0;
/// How many seeds are given.
const SEEDS: usize = 3;
/// Lines of so many periods over the range are looked at together with what else may be there, so far apart: of them angle and constant take a part. With
/// fewer periods a line is a spring that stiffens.
const SLOW: [f64; 2] = [1.1, 4.0];
const APART: f64 = 0.1;

/// Periods per turn of the strongest lines, the strongest first.
///
/// What other effects of the joint could explain (constant, angle, velocity, its sign, acceleration, load) is taken
/// out first.
pub(super) fn seeds(residual: &[f64], position: &[f64], others: &[&[f64]]) -> Vec<f64> {
    let near = within(position);
    let picked: Vec<usize> = near.iter().copied().step_by(near.len().div_ceil(SAMPLES).max(1)).collect();
    let q: Vec<f64> = picked.iter().map(|&i| position[i]).collect();
    let (low, high) = q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let range = high - low;
    if range.is_nan() || range < 1e-3 {
        return Vec::new();
    }
    let detrend = Detrend::new(&picked, others);
    let rest = detrend.of(residual);
    let slow = slow_line(&detrend, &rest, &q, TAU / range);
    // Lines closer than one period over the range are one line; slower ones are no ripple here.
    let step = TAU / range / 3.0;
    let first = 1.2 * TAU / range;
    let count = ((FINEST - first) / step).max(0.0) as usize;
    let power = |n: f64| {
        let (mut s, mut c) = (0.0, 0.0);
        for (r, q) in rest.iter().zip(&q) {
            let (sin, cos) = (n * q).sin_cos();
            s += r * sin;
            c += r * cos;
        }
        s * s + c * c
    };
    let spectrum = spectrum(&rest, &q, [first, step], count);
    let mut peaks: Vec<usize> = (1..count.saturating_sub(1))
        .filter(|&k| spectrum[k] >= spectrum[k - 1] && spectrum[k] > spectrum[k + 1])
        .collect();
    peaks.sort_by(|a, b| spectrum[*b].total_cmp(&spectrum[*a]));
    let quick = peaks.into_iter().take(SEEDS).map(|k| sharpened(first + k as f64 * step, step, &power));
    quick.chain(slow).collect()
}

/// The line of few periods that removes most of what is left beside all else, if there is a maximum; `turn`: periods per turn of one period over the range.
fn slow_line(detrend: &Detrend, rest: &[f64], q: &[f64], turn: f64) -> Option<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let removed = |n: f64| {
        let (sine, cosine): (Vec<f64>, Vec<f64>) = q.iter().map(|q| (n * q).sin_cos()).unzip();
        let [sine, cosine] = [sine, cosine].map(|column| detrend.of_picked(column.into_iter()));
        let (ss, sc, cc) = (dot(&sine, &sine), dot(&sine, &cosine), dot(&cosine, &cosine));
        let (rs, rc) = (dot(rest, &sine), dot(rest, &cosine));
        (rs * rs * cc - 2.0 * rs * rc * sc + rc * rc * ss) / (ss * cc - sc * sc).max(f64::MIN_POSITIVE)
    };
    // From below on, so that the first one can be a maximum.
    let from = SLOW[0] - 3.0 * APART;
    let count = ((SLOW[1] - from) / APART).round() as usize;
    let periods = |k: usize| from + APART * k as f64;
    let falls: Vec<f64> = (0..=count).map(|k| removed(turn * periods(k))).collect();
    let best = (0..=count).max_by(|a, b| falls[*a].total_cmp(&falls[*b]))?;
    let found = (0 < best && best < count).then(|| sharpened(turn * periods(best), turn * APART, &removed));
    found.filter(|n| *n >= SLOW[0] * turn)
}

/// Power of `count` lines, from one on and so far apart. Angles are turned on from line to line: no sines are taken.
fn spectrum(rest: &[f64], q: &[f64], [first, step]: [f64; 2], count: usize) -> Vec<f64> {
    let turned = |n: f64| -> Vec<[f64; 2]> { q.iter().map(|q| (n * q).sin_cos().into()).collect() };
    let (mut at, by) = (turned(first), turned(step));
    let mut spectrum = Vec::with_capacity(count);
    for _ in 0..count {
        let (mut s, mut c) = (0.0, 0.0);
        for ((at, [sin, cos]), r) in at.iter_mut().zip(&by).zip(rest) {
            s += r * at[0];
            c += r * at[1];
            *at = [at[0] * cos + at[1] * sin, at[1] * cos - at[0] * sin];
        }
        spectrum.push(s * s + c * c);
    }
    spectrum
}

/// Samples at most half of [`WIDEST`] from the middle one: usually all.
fn within(position: &[f64]) -> Vec<usize> {
    let mut sorted = position.to_vec();
    let middle = sorted.len() / 2;
    if sorted.is_empty() {
        return Vec::new();
    }
    let center = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    let range = position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
    let all = range.1 - range.0 <= WIDEST;
    (0..position.len()).filter(|&i| all || (position[i] - center).abs() <= 0.5 * WIDEST).collect()
}

/// The maximum near a grid point, by halving.
fn sharpened(mut n: f64, mut step: f64, power: &dyn Fn(f64) -> f64) -> f64 {
    let mut here = power(n);
    for _ in 0..6 {
        step *= 0.5;
        let tried = [(n - step, power(n - step)), (n, here), (n + step, power(n + step))];
        (n, here) = tried.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((n, here));
    }
    n
}

#[cfg(test)]
mod tests {
    use super::seeds;

    /// One wrong sample of 1e8 rad asked for 27 GB; that of 1e5 rad took 39 s.
    #[test]
    fn one_wild_sample_costs_nothing_and_hides_nothing() {
        let time: Vec<f64> = (0..2000).map(|i| f64::from(i) * 0.008).collect();
        let mut q: Vec<f64> = time.iter().map(|t| 0.5 * (1.3 * t).sin() + 0.2 * (3.7 * t).cos()).collect();
        let residual: Vec<f64> = q.iter().map(|q| 0.1 * (28.0 * q + 0.4).sin()).collect();
        for wild in [1e3, 1e8, -1e150] {
            q[777] = wild;
            let found = seeds(&residual, &q, &[]);
            assert!((found[0] - 28.0).abs() < 0.3, "{found:?}");
        }
    }

    /// The angle itself takes a part of them.
    #[test]
    fn lines_of_few_periods_are_found() {
        let time: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.004).collect();
        let q: Vec<f64> = time.iter().map(|t| 0.5 * (1.3 * t).sin() + 0.2 * (3.7 * t).cos()).collect();
        let constant = vec![1.0; q.len()];
        for periods in [1.25, 1.6, 2.0] {
            let n = periods * std::f64::consts::TAU / 1.4;
            for phase in [0.0, 0.9, 2.0] {
                let residual: Vec<f64> = q.iter().map(|q| 0.1 * (n * q + phase).sin()).collect();
                let found = seeds(&residual, &q, &[&constant, &q]);
                let nearest = found.iter().map(|f| (f / n - 1.0).abs()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.03, "{periods} periods, {phase}: {found:?}, truly {n}");
            }
        }
    }

    #[test]
    fn a_hidden_line_is_found() {
        let time: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.004).collect();
        let q: Vec<f64> = time.iter().map(|t| 0.5 * (1.3 * t).sin() + 0.2 * (3.7 * t).cos()).collect();
        let v: Vec<f64> = time.iter().map(|t| 0.65 * (1.3 * t).cos() - 0.74 * (3.7 * t).sin()).collect();
        let residual: Vec<f64> =
            q.iter().zip(&v).map(|(q, v)| 0.1 * (28.0 * q + 0.4).sin() + 0.7 * v.signum()).collect();
        let sign: Vec<f64> = v.iter().map(|v| v.signum()).collect();
        let found = seeds(&residual, &q, &[&q, &v, &sign]);
        assert!((found[0] - 28.0).abs() < 0.3, "{found:?}");
    }
}
