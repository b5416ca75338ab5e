//! What was found, in the form of the answer.
use super::accumulate::{Settings, Sums};
use super::design::Design;
use super::essential::Essential;
use super::estimate::{Estimate, Fit, HeldOutError, Method, by_channel, errors};
use super::motions::{Motions, Repetition};
use super::physical::{Choice, Inertia, Physical, Problem, check};
use super::result::*;
use super::run::{Judge, RobotAndLogs};
use super::survey::Survey;
use super::triangle::Triangle;
use crate::robot::inertial_parameters::InertialParameters;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use nalgebra::{DMatrix, DVector};
use std::path::PathBuf;

/// Correlations above this are worth a warning.
const ALIKE: f64 = 0.95;
/// Estimates that noise moves by this part of their error bars are worth one too.
const MOVED: f64 = 0.7;
/// Most of them that are named.
const NAMED: usize = 6;
/// Most pairs that are named.
const PAIRS: usize = 20;

/// What was found, to be put into words.
pub(super) struct SummaryInput<'a> {
    pub design: &'a Design<'a>,
    pub motions: &'a Motions,
    pub raw: &'a Sums,
    pub estimate: &'a Estimate,
    pub fit: &'a Fit,
    pub rows_hz: Option<f64>,
}

/// What the later steps came to.
pub(super) struct Steps<'a> {
    pub nominal: &'a DVector<f64>,
    pub essential: &'a Essential,
    pub problem: &'a Problem<'a>,
    pub physical: &'a Physical,
    pub choice: Choice,
    pub validation: Option<Validation>,
}

impl SummaryInput<'_> {
    /// The answer, from all steps.
    pub fn identification(
        &self,
        parts: &RobotAndLogs<'_>,
        method: Method,
        steps: Steps<'_>,
    ) -> Identification {
        let Steps { nominal, essential, problem, physical, choice, validation } = steps;
        let singular_values = self.estimate.singular_values();
        Identification {
            method,
            logs: self.logs(parts.files, parts.surveys),
            rows: self.raw.cells.iter().flatten().map(Triangle::rows).sum(),
            cutoff_hz: None,
            rows_hz: self.rows_hz,
            repetitions: self.motions.repetitions.clone(),
            different_motions: self.motions.different(),
            assumptions: self.assumptions(parts.surveys),
            warnings: self.warnings(parts.files, parts.surveys, problem),
            condition_number: condition(&singular_values),
            singular_values,
            parameters: self.parameters(nominal, essential),
            unseen: self.unseen(),
            pairs: self.pairs(),
            essential: self.essential(essential),
            channels: self.channels(nominal, &physical.theta, &self.motions.folds()),
            physical: self.physical(problem, physical, choice),
            validation,
        }
    }

    fn assumptions(&self, surveys: &[Survey]) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for assumption in surveys.iter().flat_map(|s| &s.assumptions) {
            if !all.contains(assumption) {
                all.push(assumption.clone());
            }
        }
        all.extend(self.rows_hz.map(|hz| {
            format!("regressor and torque pass a low-pass of {hz} Hz together: above it accelerations are more noise of the encoders than they tell")
        }));
        all
    }

    pub fn logs(&self, files: &[PathBuf], surveys: &[Survey]) -> Vec<LogSummary> {
        let summary = |(file, survey): (&PathBuf, &Survey)| LogSummary {
            file: file.display().to_string(),
            hash: String::new(),
            samples: survey.samples,
            step: survey.step,
            cutoff_hz: survey.cutoff_hz,
        };
        files.iter().zip(surveys).map(summary).collect()
    }

    pub fn parameters(&self, nominal: &DVector<f64>, essential: &Essential) -> Vec<Parameter> {
        let spread = self.fit.standard_errors();
        let t = student(self.estimate.cells.iter().filter(|cell| cell.rows() > 0).count());
        let parameter = |&k: &usize| {
            let (unknown, value, error) = (&self.design.unknowns[k], self.fit.theta[k], spread[k]);
            let relative = (value != 0.0).then(|| 100.0 * error / value.abs());
            Parameter {
                name: unknown.name.clone(),
                unit: unknown.unit,
                value,
                standard_error: error,
                independent_error: self.fit.white[(k, k)].max(0.0).sqrt(),
                relative_error_percent: relative,
                interval: [value - t * error, value + t * error],
                nominal: nominal[k],
                well_identified: relative.is_some_and(|percent| percent < 15.0),
                essential: essential.unknowns.contains(&k),
            }
        };
        let told = self.estimate.seen.iter().filter(|k| !self.fit.untold.contains(k));
        told.map(parameter).collect()
    }

    pub fn unseen(&self) -> Vec<String> {
        let all = 0..self.design.unknowns.len();
        let told = |k: &usize| self.estimate.seen.contains(k) && !self.fit.untold.contains(k);
        let unseen = all.filter(|k| !told(k));
        unseen.map(|k| self.design.unknowns[k].name.clone()).collect()
    }

    pub fn pairs(&self) -> Vec<Pair> {
        let seen = &self.estimate.seen;
        let mut pairs = Vec::new();
        for (n, &i) in seen.iter().enumerate() {
            for &j in &seen[n + 1..] {
                let correlation = self.fit.correlation(i, j);
                if correlation.abs() > ALIKE {
                    let parameters = [i, j].map(|k| self.design.unknowns[k].name.clone());
                    pairs.push(Pair { parameters, correlation });
                }
            }
        }
        pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
        pairs.truncate(PAIRS);
        pairs
    }

    pub fn essential(&self, essential: &Essential) -> EssentialSummary {
        let name = |&k: &usize| self.design.unknowns[k].name.clone();
        EssentialSummary {
            parameters: essential.unknowns.iter().map(name).collect(),
            held_out: essential.held_out[1].relative(),
            held_out_of_all: essential.held_out[0].relative(),
        }
    }

    pub fn channels(
        &self,
        nominal: &DVector<f64>,
        physical: &DVector<f64>,
        folds: &[usize],
    ) -> Vec<ChannelSummary> {
        let own = by_channel(self.raw, self.design, &|_| true);
        let of = |theta: &DVector<f64>| errors(&own, self.design, theta);
        let (cad, fitted, physical) = (of(nominal), of(&self.fit.theta), of(physical));
        let estimate = self.estimate;
        let held = estimate.held_out(self.design, self.raw, folds, &|t| estimate.solve(t, &estimate.seen));
        let summary = |(index, channel): (usize, &super::Channel)| ChannelSummary {
            name: channel.name.clone(),
            unit: channel.unit,
            rows: own[index].rows(),
            resting: self.raw.resting[index],
            measured: (fitted[index].measured / own[index].rows().max(1) as f64).sqrt(),
            description: cad[index].rms(),
            least_squares: fitted[index].rms(),
            held_out: held.iter().fold(HeldOutError::default(), |sum, fold| sum.plus(&fold[index])).rms(),
            physical: physical[index].rms(),
        };
        self.design.channels.iter().enumerate().map(summary).collect()
    }

    pub fn validation(
        &self,
        parts: &RobotAndLogs<'_>,
        judge: &Judge<'_>,
        settings: &Settings,
        models: [&DVector<f64>; 4],
    ) -> Result<Validation, Diagnostics> {
        let look = judge.survey;
        let all: Vec<Survey> = parts.surveys.iter().cloned().chain([look.clone()]).collect();
        let last = parts.surveys.len();
        let again = |r: &Repetition| matches!(r, Repetition::Between { log, .. } if *log == last);
        let shares_motion = Motions::new(&all).repetitions.iter().any(again);
        let own = Motions::new(std::slice::from_ref(look));
        let sums = judge.feed.pass((self.design, parts.base), &own, settings, None)?;
        let channels = by_channel(&sums, self.design, &|_| true);
        let held = models.map(|theta| errors(&channels, self.design, theta));
        let of = |index: usize| [0, 1, 2, 3].map(|m: usize| held[m][index]);
        let channel = |(index, channel): (usize, &super::Channel)| {
            let held = of(index);
            ValidationChannel {
                name: channel.name.clone(),
                unit: channel.unit,
                measured: (held[0].measured / held[0].rows.max(1) as f64).sqrt(),
                rms: Models::of(held, HeldOutError::rms),
            }
        };
        let sum = |m: usize| held[m].iter().fold(HeldOutError::default(), |sum, e| sum.plus(e));
        Ok(Validation {
            file: judge.file.display().to_string(),
            hash: String::new(),
            samples: look.samples,
            shares_motion,
            channels: self.design.channels.iter().enumerate().map(channel).collect(),
            total: Models::of([0, 1, 2, 3].map(sum), HeldOutError::relative),
        })
    }

    pub fn physical(&self, problem: &Problem<'_>, found: &Physical, choice: Choice) -> PhysicalSummary {
        let covariance = self.spread(problem, found, choice.weight);
        let links: Vec<LinkSummary> = problem
            .links
            .bodies
            .iter()
            .zip(found.coordinates.chunks_exact(InertialParameters::PER_BODY))
            .enumerate()
            .map(|(index, (body, x))| {
                let block = covariance.view((10 * index, 10 * index), (10, 10)).into_owned();
                let values = with_errors(&|x| flat(&body.inertia(x)), x, &block);
                LinkSummary {
                    name: body.name.clone(),
                    mass: values[0],
                    center: [values[1], values[2], values[3]],
                    inertia: std::array::from_fn(|k| values[4 + k]),
                    nominal_mass: body.nominal.mass,
                    check: check(&body.inertia(x)),
                }
            })
            .collect();
        let first = problem.links.coordinates();
        let extra = |(k, extra): (usize, &super::Extra)| ExtraSummary {
            name: extra.name(self.design.layout),
            unit: extra.unit(self.design.layout),
            value: Value {
                value: found.extras[k],
                standard_error: covariance[(first + k, first + k)].max(0.0).sqrt(),
            },
        };
        PhysicalSummary {
            weight: choice.weight,
            chosen: !choice.trials.is_empty(),
            trials: choice.trials,
            certificate: found.certificate,
            consistent: links.iter().all(|link: &LinkSummary| link.check.consistent),
            links,
            extras: self.design.extras.iter().enumerate().map(extra).collect(),
        }
    }

    /// Covariance of coordinates and extras: data count as many independent rows as the correlation in time leaves, CAD
    /// by its weight. Conditions (definiteness, signs) can only make it smaller.
    fn spread(&self, problem: &Problem<'_>, found: &Physical, weight: f64) -> DMatrix<f64> {
        let total = &self.estimate.total;
        let rows = total.rows().max(1) as f64;
        let variance = total.squares(&found.theta) / rows;
        let factor = total.matrix() * problem.slopes();
        let mut precision = factor.tr_mul(&factor) / rows;
        let first = problem.links.coordinates();
        (0..first).for_each(|k| precision[(k, k)] += weight);
        let scale = variance * self.inflation() / rows;
        // Rotor inertias that equal an inertia of a link have a direction of their own only through CAD.
        let least = 1e-12 * precision.diagonal().max();
        (first..precision.nrows()).for_each(|k| precision[(k, k)] += least);
        let inverse = precision.clone().cholesky().map(|c| c.inverse());
        inverse.map_or_else(
            || DMatrix::from_element(precision.nrows(), precision.ncols(), f64::INFINITY),
            |i| i * scale,
        )
    }

    /// How many rows say as much as one independent row: the median of both variances' ratio.
    fn inflation(&self) -> f64 {
        let ratio = |&k: &usize| self.fit.covariance[(k, k)] / self.fit.white[(k, k)].max(f64::MIN_POSITIVE);
        let mut ratios: Vec<f64> = self.estimate.seen.iter().map(ratio).filter(|r| r.is_finite()).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(1.0).max(1.0)
    }

    pub fn warnings(&self, files: &[PathBuf], surveys: &[Survey], problem: &Problem<'_>) -> Vec<String> {
        let name = |log: usize| {
            files[log].file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
        };
        let mut all: Vec<String> = surveys.iter().flat_map(|s| &s.warnings).map(Diagnostic::placed).collect();
        all.extend(self.motions.repetitions.iter().map(|repetition| match repetition {
            Repetition::Within { log, period } => format!(
                "`{}` repeats its motion every {period:.2} s: folds are cut by the phase of this period",
                name(*log)
            ),
            Repetition::Between { earlier, log, shift } => format!(
                "`{}` shows the motion of `{}` again ({:.2} s {}): it teaches nothing new about other motions and does not judge them",
                name(*log),
                name(*earlier),
                shift.abs(),
                if *shift < 0.0 { "earlier" } else { "later" }
            ),
        }));
        all.extend(problem.links.bodies.iter().filter(|body| body.mended).map(|body| {
            format!("the inertia of `{}` in the description is one that no body has: it was mended before it served as prior", body.name)
        }));
        all.extend(noisy(self.design, self.estimate, self.fit));
        all
    }
}

fn condition(values: &[f64]) -> f64 {
    let (most, least) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
    most / least.max(f64::MIN_POSITIVE)
}

/// What noise of the encoders leaves of the estimates, where it moves them by more than all else or they rest on it.
fn noisy(design: &Design<'_>, estimate: &Estimate, fit: &Fit) -> Vec<String> {
    let listed = |places: Vec<usize>| {
        let names: Vec<String> =
            places.iter().take(NAMED).map(|&k| format!("`{}`", design.unknowns[k].name)).collect();
        let more = places.len().saturating_sub(NAMED);
        names.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
    };
    let spread = fit.standard_errors();
    let moves = |k: &usize| fit.moved[*k].abs() > MOVED * spread[*k] && !fit.untold.contains(k);
    let moved: Vec<usize> = estimate.seen.iter().copied().filter(moves).collect();
    let mut said = Vec::new();
    if !fit.untold.is_empty() {
        said.push(format!(
            "the motion is too slow for its encoders: accelerations are so much noise that {} are not told, and bodies of the physical part that depend on them are not to be trusted; move faster, or let a slower filter take that noise off (--row-cutoff)",
            listed(fit.untold.clone())
        ));
    }
    if !moved.is_empty() {
        said.push(format!(
            "the motion is slow for its encoders: noise of accelerations moves {} by most of their error bars, always to the same side",
            listed(moved)
        ));
    }
    said
}

/// Mass, centre, xx, xy, xz, yy, yz, zz.
fn flat(inertia: &Inertia) -> [f64; 10] {
    let (c, i) = (inertia.center, inertia.inertia);
    [inertia.mass, c.x, c.y, c.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
}

/// Values of a function of a link's coordinates, with errors by its derivatives.
fn with_errors(f: &dyn Fn(&[f64]) -> [f64; 10], x: &[f64], covariance: &DMatrix<f64>) -> [Value; 10] {
    const STEP: f64 = 1e-6;
    let mut slopes = DMatrix::zeros(10, 10);
    for k in 0..10 {
        let moved = |step: f64| {
            let mut x = x.to_vec();
            x[k] += step;
            f(&x)
        };
        let (up, down) = (moved(STEP), moved(-STEP));
        (0..10).for_each(|row| slopes[(row, k)] = (up[row] - down[row]) / (2.0 * STEP));
    }
    let spread = &slopes * covariance * slopes.transpose();
    let values = f(x);
    std::array::from_fn(|k| Value { value: values[k], standard_error: spread[(k, k)].max(0.0).sqrt() })
}

/// Half width of a 95 % interval in standard errors, with so many stretches behind them (Cornish and Fisher).
pub(super) fn student(stretches: usize) -> f64 {
    let (z, n) = (1.959_964_f64, stretches.saturating_sub(1).max(1) as f64);
    z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
}
