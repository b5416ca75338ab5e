//! A flexible function of the signals at hand: what any explanation in these signals could reach.
//!
//! Piecewise linear functions of the joint's position, velocity and load, of their pairs, the sign of velocity alone
//! and times other signals, and linear terms in all other signals, fitted with a ridge.
use crate::experiments::Experiment;
use crate::gram::gram;
use nalgebra::{DMatrix, DVector};

/// Most samples that are used.
const SAMPLES: usize = 4000;
/// Knots of functions of one signal, and of one signal in functions of two.
const KNOTS: usize = 10;
const PAIR_KNOTS: usize = 5;
/// Speed over which the sign of velocity is smoothed, rad/s.
const SMOOTHING: f64 = 0.02;

/// Named signals of a row, the joint's position, velocity and load first.
pub(crate) type Signals = Vec<(String, Vec<f64>)>;

/// Which samples are used: evenly spaced.
fn stride(samples: usize) -> usize {
    samples.div_ceil(SAMPLES).max(1)
}

/// Where the functions bend, learned from the training signals.
struct Basis {
    knots: Vec<Vec<f64>>,
    pairs: Vec<Vec<f64>>,
    /// Mean and standard deviation of every signal.
    scales: Vec<(f64, f64)>,
}

/// Of sorted values.
fn quantiles(sorted: &[f64], count: usize) -> Vec<f64> {
    let last = sorted.len().saturating_sub(1);
    let mut knots: Vec<f64> = (0..count).map(|k| sorted[k * last / (count - 1)]).collect();
    knots.dedup();
    knots
}

impl Basis {
    fn new(signals: &Signals) -> Self {
        let thin =
            |values: &[f64]| -> Vec<f64> { values.iter().step_by(stride(values.len())).copied().collect() };
        let mut primary: Vec<Vec<f64>> = signals.iter().take(3).map(|(_, v)| thin(v)).collect();
        primary.iter_mut().for_each(|values| values.sort_unstable_by(f64::total_cmp));
        let scale = |(_, v): &(String, Vec<f64>)| {
            let mean = v.iter().sum::<f64>() / v.len().max(1) as f64;
            let square = v.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / v.len().max(1) as f64;
            (mean, square.sqrt().max(1e-12))
        };
        Self {
            knots: primary.iter().map(|v| quantiles(v, KNOTS)).collect(),
            pairs: primary.iter().map(|v| quantiles(v, PAIR_KNOTS)).collect(),
            scales: signals.iter().map(scale).collect(),
        }
    }

    /// `pair` is work space.
    fn row(&self, signals: &Signals, i: usize, pair: &mut [Vec<f64>; 3], out: &mut Vec<f64>) {
        out.clear();
        out.push(1.0);
        for (k, knots) in self.knots.iter().enumerate() {
            hats(knots, signals[k].1[i], out);
        }
        for (k, (knots, pair)) in self.pairs.iter().zip(&mut *pair).enumerate() {
            pair.clear();
            hats(knots, signals[k].1[i], pair);
        }
        for a in 0..self.pairs.len() {
            for b in 0..a {
                out.extend(pair[a].iter().flat_map(|x| pair[b].iter().map(move |y| x * y)));
            }
        }
        let scaled = |k: usize| (signals[k].1[i] - self.scales[k].0) / self.scales[k].1;
        if signals.len() < 2 {
            return;
        }
        let speed = signals[1].1[i];
        let sign = (speed / SMOOTHING).tanh();
        let velocity = scaled(1);
        out.extend([sign, sign * scaled(0), sign * velocity, velocity * velocity * velocity]);
        if signals.len() > 2 {
            out.extend([sign * scaled(2), sign * scaled(2).abs()]);
        }
        for (k, (name, values)) in signals.iter().enumerate().skip(3) {
            let s = scaled(k);
            out.extend([s, s * velocity, s * sign]);
            if name.ends_with("/velocity") {
                out.push((values[i] / SMOOTHING).tanh());
            }
        }
    }

    fn matrix(&self, signals: &Signals, picked: &[usize]) -> DMatrix<f64> {
        let (mut row, mut pair) = (Vec::new(), <[Vec<f64>; 3]>::default());
        self.row(signals, 0, &mut pair, &mut row);
        let mut x = DMatrix::zeros(picked.len(), row.len());
        for (r, &i) in picked.iter().enumerate() {
            self.row(signals, i, &mut pair, &mut row);
            for (c, value) in row.iter().enumerate() {
                x[(r, c)] = *value;
            }
        }
        x
    }
}

/// Values of the hat functions over these knots; constant beyond the ends.
fn hats(knots: &[f64], x: f64, out: &mut Vec<f64>) {
    let first = out.len();
    out.resize(first + knots.len(), 0.0);
    let upper = knots.partition_point(|k| *k <= x);
    if upper == 0 || knots.len() < 2 {
        out[first] = 1.0;
    } else if upper == knots.len() {
        out[first + upper - 1] = 1.0;
    } else {
        let t = (x - knots[upper - 1]) / (knots[upper] - knots[upper - 1]);
        out[first + upper - 1] = 1.0 - t;
        out[first + upper] = t;
    }
}

/// What a smooth function of the signals reaches.
pub(crate) struct Reach {
    /// Mean squared residual on the judging samples, as it is.
    pub before: f64,
    /// With the function subtracted.
    pub after: f64,
    /// How many judging samples in a row tell the same: 1 for white residuals.
    pub correlation: f64,
}

/// Fits on `train` and judges on `judge`; each with the signals, the residual and which samples count.
pub(crate) fn reach(
    train: (&Signals, &[f64], &dyn Fn(usize) -> bool),
    judge: (&Signals, &[f64], &dyn Fn(usize) -> bool),
) -> Option<Reach> {
    let pick = |residual: &[f64], counts: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..residual.len()).step_by(stride(residual.len())).filter(|&i| counts(i)).collect()
    };
    let rows = pick(train.1, train.2);
    let others = pick(judge.1, judge.2);
    if rows.len() < 100 || others.len() < 50 || train.0.is_empty() {
        return None;
    }
    let basis = Basis::new(train.0);
    let x = basis.matrix(train.0, &rows);
    let y = DVector::from_iterator(rows.len(), rows.iter().map(|&i| train.1[i]));
    let z = basis.matrix(judge.0, &others);
    let target = DVector::from_iterator(others.len(), others.iter().map(|&i| judge.1[i]));
    let before = target.norm_squared() / others.len() as f64;
    // The last fifth of the training samples chooses the ridge.
    let kept = rows.len() * 4 / 5;
    let rest = rows.len() - kept;
    let (a, b) = (x.rows(0, kept).into_owned(), x.rows(kept, rest).into_owned());
    let first = gram(&a);
    let mut matrix = &first + gram(&b);
    let right = x.tr_mul(&y);
    let mean = matrix.trace() / matrix.nrows() as f64;
    let ridge =
        choose_ridge((first, a.tr_mul(&y.rows(0, kept))), (&b, &y.rows(kept, rest).into_owned()), mean);
    (0..matrix.nrows()).for_each(|i| matrix[(i, i)] += ridge * mean);
    let coefficients = matrix.cholesky()?.solve(&right);
    let rest = target - z * coefficients;
    let after = rest.norm_squared() / others.len() as f64;
    Some(Reach { before, after, correlation: correlation_length(rest.as_slice()) })
}

/// The ridge, in means of the diagonal, whose solution of normal equations does best on other samples.
fn choose_ridge(
    (gram, right): (DMatrix<f64>, DVector<f64>),
    (b, yb): (&DMatrix<f64>, &DVector<f64>),
    mean: f64,
) -> f64 {
    let error = |ridge: f64| {
        let mut matrix = gram.clone();
        (0..matrix.nrows()).for_each(|i| matrix[(i, i)] += ridge * mean);
        matrix.cholesky().map_or(f64::INFINITY, |c| (b * c.solve(&right) - yb).norm_squared())
    };
    let tried = [1e-6, 1e-4, 1e-2, 1.0].map(|ridge| (error(ridge), ridge));
    tried.into_iter().min_by(|p, q| p.0.total_cmp(&q.0)).map_or(1e-2, |(_, ridge)| ridge)
}

/// Integrated autocorrelation: how many samples count as one. At least 1.
pub(crate) fn correlation_length(residual: &[f64]) -> f64 {
    let n = residual.len();
    if n == 0 {
        return 1.0;
    }
    let mean = residual.iter().sum::<f64>() / n as f64;
    let product = |lag: usize| -> f64 {
        residual[lag..].iter().zip(residual).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let variance = product(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let mut sum = 1.0;
    for lag in 1..n / 10 {
        let rho = product(lag) / variance;
        if rho < 0.05 {
            break;
        }
        sum += 2.0 * rho;
    }
    sum
}

/// Signals that a residual goes with, the strongest first, with their correlation.
pub(crate) fn correlated(signals: &Signals, residual: &[f64]) -> Vec<(String, f64)> {
    let mut list: Vec<(String, f64)> = Vec::new();
    let mut add = |name: String, values: &dyn Fn(usize) -> f64| {
        list.push((name, correlation(residual, values)));
    };
    for (k, (name, values)) in signals.iter().enumerate() {
        add(name.clone(), &|i| values[i]);
        if name.ends_with("velocity") {
            add(format!("sign of {name}"), &|i| (values[i] / SMOOTHING).tanh());
            add(format!("{name} squared with its sign"), &|i| values[i] * values[i].abs());
        }
        if k == 0 {
            add("position cubed".to_owned(), &|i| values[i].powi(3));
        }
    }
    if let Some((_, velocity)) = signals.get(1) {
        for (name, values) in signals.iter().filter(|(name, _)| name != "velocity") {
            add(format!("{name} × sign of velocity"), &|i| values[i] * (velocity[i] / SMOOTHING).tanh());
            if name.ends_with("/velocity") || name == "time" {
                add(format!("{name} × velocity"), &|i| values[i] * velocity[i]);
            }
        }
    }
    list.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    list
}

fn correlation(residual: &[f64], values: &dyn Fn(usize) -> f64) -> f64 {
    let n = residual.len() as f64;
    let (mut sx, mut sy, mut sxx, mut syy, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, &y) in residual.iter().enumerate() {
        let x = values(i);
        sx += x;
        sy += y;
        sxx += x * x;
        syy += y * y;
        sxy += x * y;
    }
    let (vx, vy) = (sxx - sx * sx / n, syy - sy * sy / n);
    if vx <= 0.0 || vy <= 0.0 { 0.0 } else { (sxy - sx * sy / n) / (vx * vy).sqrt() }
}

/// The signals of a row, or none if the experiment has none.
pub(crate) fn signals(experiment: &dyn Experiment, row: usize) -> Signals {
    experiment.signals(row)
}
