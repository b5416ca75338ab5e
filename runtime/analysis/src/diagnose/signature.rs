//! What a residual goes with: a quick screen against simple functions of the motion.
//!
//! Each physical effect leaves a mark: Coulomb friction follows the sign of velocity, a wrong zero does not change at
//! all, a delay follows the rate of the load. The function with the largest correlation is taken first; what it
//! explains is projected out before the next is looked for. This says how a residual looks; which effect stands behind
//! it is for [`super::diagnose`] to decide, on held-out data.
use super::breakdown::short;
use crate::experiments::Experiment;
use serde::Serialize;

/// Most functions that are named.
const MOST: usize = 3;
/// Smallest (partial) correlation that is named.
const CORRELATION: f64 = 0.25;
/// Smallest part of the squared error that is named.
const SHARE: f64 = 0.04;
/// `sign` of a velocity is smoothed over this part of its root mean square.
const SMOOTH: f64 = 0.05;
/// Samples that are looked at: more do not change a correlation.
const SAMPLES: usize = 4000;

/// A function of the motion that a residual goes with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Feature {
    /// Such as `sign of velocity`, `velocity`, `a constant`, `right_knee_pitch/velocity`.
    pub name: String,
    /// With what the features before it leave; −1 to 1. For `a constant`: mean over root mean square.
    pub correlation: f64,
    /// Part of the squared error that it explains beyond those before it.
    pub share: f64,
    /// Residual per unit of the function, SI units of both; for `a constant` the constant itself.
    pub slope: f64,
}

impl Feature {
    /// In words, about the row of this name.
    pub fn sentence(&self, row: &str, unit: &str) -> String {
        let (share, size) = (100.0 * self.share, self.correlation);
        if self.name == CONSTANT {
            return format!(
                "{row}: the residual is off by a constant {} {unit} ({share:.0} % of its square)",
                short(self.slope)
            );
        }
        format!(
            "{row}: the residual {} {} (correlation {size:.2}, {share:.0} % of its square)",
            if size < 0.0 { "runs against the" } else { "follows the" },
            self.name
        )
    }
}

/// Name of the feature that does not change.
pub const CONSTANT: &str = "constant";

/// Functions that a row's residual goes with, the strongest first; none if none is strong.
pub fn screen(experiment: &dyn Experiment, row: usize) -> Vec<Feature> {
    let residual = experiment.residual(row);
    let stride = residual.len().div_ceil(SAMPLES).max(1);
    let thin = |values: &[f64]| -> Vec<f64> { values.iter().step_by(stride).copied().collect() };
    let step = step(experiment.time());
    let signals: Vec<(String, Vec<f64>)> = experiment
        .signals(row)
        .into_iter()
        .flat_map(|(name, values)| functions(&name, &values, step))
        .map(|(name, values)| (name, thin(&values)))
        .chain(load_times_sign(experiment, row).map(|(name, values)| (name, thin(&values))))
        .collect();
    select(&thin(residual), signals)
}

/// Median step of the samples.
fn step(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_unstable_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(1.0)
}

/// What is made of one signal.
fn functions(name: &str, values: &[f64], step: f64) -> Vec<(String, Vec<f64>)> {
    let (joint, quantity) = name.rsplit_once('/').map_or((None, name), |(joint, q)| (Some(joint), q));
    let of = |what: &str| match joint {
        Some(joint) => format!("{what} of {joint}"),
        None => what.to_owned(),
    };
    let mut out = Vec::new();
    match quantity {
        "velocity" => {
            let smooth =
                SMOOTH * (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt();
            let sign = values.iter().map(|v| (v / smooth.max(f64::MIN_POSITIVE)).tanh()).collect();
            out.push((of("sign of velocity"), sign));
            out.push((of("velocity"), values.to_vec()));
        }
        "load" => {
            out.push((of("load"), values.to_vec()));
            out.push((of("rate of the load"), rate(values, step)));
        }
        "position" | "acceleration" => out.push((of(quantity), values.to_vec())),
        "time" => out.push(("time".to_owned(), values.to_vec())),
        _ => out.push((name.to_owned(), values.to_vec())),
    }
    out
}

/// Central differences; steps over gaps are wrong, and too few to matter.
fn rate(values: &[f64], step: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|i| (values[(i + 1).min(last)] - values[i.saturating_sub(1)]) / (2.0 * step))
        .collect()
}

/// Friction that grows with the load: its size times the sign of velocity.
fn load_times_sign(experiment: &dyn Experiment, row: usize) -> impl Iterator<Item = (String, Vec<f64>)> {
    let both = experiment.signal(row, "load").zip(experiment.signal(row, "velocity"));
    both.map(|(load, velocity)| {
        let values = load.iter().zip(&velocity).map(|(load, v)| load.abs() * v.signum()).collect();
        ("size of the load times the sign of velocity".to_owned(), values)
    })
    .into_iter()
}

/// Forward selection: every function has lost its mean and what was chosen before.
fn select(residual: &[f64], mut functions: Vec<(String, Vec<f64>)>) -> Vec<Feature> {
    let total: f64 = residual.iter().map(|r| r * r).sum();
    if residual.len() < 8 || total <= 0.0 {
        return Vec::new();
    }
    let mut out = Vec::new();
    let mut left = residual.to_vec();
    let mean = center(&mut left);
    let constant = mean * mean * residual.len() as f64 / total;
    let sizes: Vec<f64> = functions.iter().map(|(_, values)| dot(values, values)).collect();
    for (_, values) in &mut functions {
        center(values);
    }
    if constant > SHARE {
        let correlation = constant.sqrt() * mean.signum();
        out.push(Feature { name: CONSTANT.to_owned(), correlation, share: constant, slope: mean });
    }
    for _ in 0..MOST {
        let before = dot(&left, &left);
        let strength = |k: usize| {
            let own = dot(&functions[k].1, &functions[k].1);
            // What was projected out but for rounding says nothing.
            if own > 1e-9 * sizes[k] { dot(&functions[k].1, &left) / (own * before).sqrt() } else { 0.0 }
        };
        let best =
            (0..functions.len()).map(|k| (k, strength(k))).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((best, correlation)) = best else { break };
        let share = correlation * correlation * before / total;
        if correlation.is_nan() || correlation.abs() < CORRELATION || share < SHARE {
            break;
        }
        let (name, chosen) = functions[best].clone();
        let slope = remove(&mut left, &chosen);
        for (_, values) in &mut functions {
            remove(values, &chosen);
        }
        out.push(Feature { name, correlation, share, slope });
    }
    out.sort_by(|a, b| b.share.total_cmp(&a.share));
    out
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes the mean away and returns it.
fn center(values: &mut [f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|x| *x -= mean);
    mean
}

/// Takes away what is proportional to `other`; the factor.
fn remove(values: &mut [f64], other: &[f64]) -> f64 {
    let factor = dot(values, other) / dot(other, other);
    values.iter_mut().zip(other).for_each(|(x, o)| *x -= factor * o);
    factor
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reproducible uniform number in ±1.
    fn noise(i: usize) -> f64 {
        let x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((x >> 11) as f64 / (1_u64 << 52) as f64) - 1.0
    }

    fn signals() -> Vec<(String, Vec<f64>)> {
        let velocity: Vec<f64> =
            (0..3000).map(|i| (0.013 * f64::from(i)).sin() + 0.4 * (0.031 * f64::from(i)).cos()).collect();
        let position: Vec<f64> = (0..3000).map(|i| (0.007 * f64::from(i)).cos()).collect();
        let mut all = functions("velocity", &velocity, 0.01);
        all.extend(functions("position", &position, 0.01));
        all
    }

    #[test]
    fn friction_and_a_bias_are_seen() {
        let functions = signals();
        let residual: Vec<f64> = (0..3000).map(|i| 0.4 * functions[0].1[i] + 0.3 + 0.15 * noise(i)).collect();
        let found = select(&residual, functions);
        let names: Vec<&str> = found.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["sign of velocity", CONSTANT]);
        assert!((found[0].slope - 0.4).abs() < 0.01 && (found[1].slope - 0.3).abs() < 0.02, "{found:?}");
        assert!(
            found[0]
                .sentence("knee", "N m")
                .starts_with("knee: the residual follows the sign of velocity (correlation 0.9")
        );
    }

    #[test]
    fn noise_has_no_structure() {
        let residual: Vec<f64> = (0..3000).map(noise).collect();
        assert!(select(&residual, signals()).is_empty());
        assert!(select(&[0.0; 100], signals()).is_empty());
    }
}
