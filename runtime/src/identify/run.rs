//! All steps of identification in their order.
use super::accumulate::{Log, Settings, Sums, Weighting, accumulate};
use super::design::{BatchRegressor, Design};
use super::essential::{Essential, essential};
use super::estimate::{Estimate, Fit, Held, Method, by_channel, errors};
use super::motions::{Motions, Repetition};
use super::physical::{Bound, Bounds, Choice, Consistency, Inertia, Links, Physical, Problem, check, choose};
use super::result::*;
use super::survey::{Survey, survey};
use super::triangle::Triangle;
use super::unknowns::{BaseSet, ExtraChoice};
use crate::compare::Subject;
use crate::diagnose::Anatomy;
use crate::diagnostic::{Diagnostic, Diagnostics};
use nalgebra::{DMatrix, DVector};

/// Correlations above this are worth a warning.
const ALIKE: f64 = 0.95;
/// Most pairs that are named.
const PAIRS: usize = 20;
/// Passes of Huber's estimator.
const PASSES: usize = 6;
/// Huber's bend in scales: 95 % of the efficiency of least squares on normal errors.
const BEND: f64 = 1.345;

/// The robot, and what its logs show.
pub struct Parts<'a> {
    /// Joints and base.
    pub subject: &'a Subject,
    /// Links.
    pub anatomy: &'a Anatomy,
    /// Base parameters of the observed rows.
    pub base: &'a BaseSet,
    /// Their regressor.
    pub regressor: &'a dyn BatchRegressor,
    /// Observed rows of `v`.
    pub rows: &'a [usize],
    /// What each log shows.
    pub surveys: &'a [Survey],
}

/// How to identify.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Estimator.
    pub method: Method,
    /// What joints add.
    pub extras: ExtraChoice,
    /// Every so many-th sample, after a low-pass over regressor and torque.
    pub decimate: usize,
    /// Part of a joint's largest speed below which its samples do not count.
    pub slow: f64,
    /// Weight of CAD; none: chosen by folds.
    pub weight: Option<f64>,
    /// What is known beside the data.
    pub bounds: Vec<Bound>,
}

/// The answer, and the links' new inertias for a URDF.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// For people and programs.
    pub identification: Identification,
    /// By link name.
    pub links: Vec<(String, Inertia)>,
}

/// Estimates parameters from logs; `judge` is a log that only judges.
///
/// # Errors
/// Unreadable logs, data that cannot carry an estimate, bounds that contradict each other.
pub fn identify(
    parts: &Parts<'_>,
    logs: &[Log<'_>],
    judge: Option<&Log<'_>>,
    options: &Options,
    progress: &dyn Fn(f64),
) -> Result<Answer, Diagnostics> {
    let one = |diagnostic: Diagnostic| Diagnostics(vec![diagnostic]);
    let design = design(parts, options);
    let motions = Motions::new(parts.surveys);
    let settings = Settings {
        decimate: options.decimate,
        slow: options.slow,
        speed: fastest(parts),
        threads: std::thread::available_parallelism().map_or(1, usize::from).min(8),
    };
    let raw = accumulate(&design, logs, &motions, &settings, None)?;
    enough(&design, &raw).map_err(one)?;
    progress(0.3);
    let nominal = nominal(&design, &parts.anatomy.parameters());
    let (estimate, sums) = estimated(&design, logs, &motions, &settings, options, (&raw, &nominal))?;
    if estimate.seen.is_empty() {
        return Err(one(Diagnostic::error("the data tell none of the parameters")
            .help("record a motion in which all joints move")));
    }
    let fit = estimate.fit(&design, &sums);
    if let Some(k) = (0..fit.theta.len()).find(|&k| !fit.theta[k].is_finite()) {
        let message = format!("the estimate of `{}` is no number", design.unknowns[k].name);
        return Err(one(
            Diagnostic::error(message).help("are positions and efforts of the logs in SI units?")
        ));
    }
    let folds = motions.folds();
    let essential = essential(&estimate, &design, &raw, &folds);
    progress(0.5);
    let links = Links::new(parts.anatomy);
    let bounds = Bounds::new(&options.bounds, &links).map_err(one)?;
    let problem = Problem::new(&design, &links, &bounds);
    let choice = match options.weight {
        Some(weight) => Choice { weight, trials: Vec::new() },
        None => {
            choose(&problem, &design, &raw, &estimate, &folds, &|p| progress(0.5 + 0.4 * p)).map_err(one)?
        }
    };
    let physical = problem.solve(&estimate.total, choice.weight).map_err(one)?;
    let zeros = estimate.clone().with_held(DVector::zeros(nominal.len()));
    let essential_theta = zeros.solve(&zeros.total, &essential.unknowns);
    let models = [&nominal, &fit.theta, &essential_theta, &physical.theta];
    let found = Found { design: &design, motions: &motions, raw: &raw, estimate: &estimate, fit: &fit };
    let validation = match judge {
        Some(judge) => Some(found.validation(parts, judge, &settings, models)?),
        None => None,
    };
    progress(1.0);
    let physical_summary = found.physical(&problem, &physical, choice);
    let new = links.bodies.iter().zip(physical.coordinates.chunks_exact(10));
    let links = new.map(|(body, x)| (body.name.clone(), body.inertia(x))).collect();
    let identification = Identification {
        method: options.method,
        logs: found.logs(logs, parts.surveys),
        rows: raw.cells.iter().flatten().map(Triangle::rows).sum(),
        repetitions: motions.repetitions.clone(),
        different_motions: motions.different(),
        assumptions: assumptions(parts.surveys),
        warnings: found.warnings(logs, parts.surveys, &problem),
        condition_number: condition(&estimate.singular_values()),
        singular_values: estimate.singular_values(),
        parameters: found.parameters(&nominal, &essential),
        unseen: found.unseen(),
        pairs: found.pairs(),
        essential: found.essential(&essential),
        channels: found.channels(&nominal, &physical.theta, &folds),
        physical: physical_summary,
        validation,
    };
    Ok(Answer { identification, links })
}

fn design<'a>(parts: &Parts<'a>, options: &Options) -> Design<'a> {
    let nb = parts.subject.base.nv();
    let joints: Vec<usize> = parts.rows.iter().filter_map(|row| row.checked_sub(nb)).collect();
    let mut extras = options.extras.list(&joints);
    extras.retain(|extra| joints.contains(&extra.joint) && joints.contains(&extra.other));
    Design::new(parts.subject, parts.base, parts.regressor, extras, parts.rows)
}

fn fastest(parts: &Parts<'_>) -> Vec<f64> {
    let speed = |joint| parts.surveys.iter().map(|s| s.speed[joint]).fold(0.0, f64::max);
    (0..parts.subject.joints.len()).map(speed).collect()
}

/// The unknowns for these inertial parameters, extras zero.
fn nominal(design: &Design<'_>, parameters: &[f64]) -> DVector<f64> {
    let value = |sum: &[(super::Part, f64)]| -> f64 {
        let term = |(part, factor): &(super::Part, f64)| match part {
            super::Part::Inertial(k) => factor * parameters[*k],
            super::Part::Extra(_) => 0.0,
        };
        sum.iter().map(term).sum()
    };
    DVector::from_iterator(design.unknowns.len(), design.sums().map(value))
}

/// Refuses channels with fewer rows than unknowns.
fn enough(design: &Design<'_>, sums: &Sums) -> Result<(), Diagnostic> {
    for (index, channel) in design.channels.iter().enumerate() {
        let rows = sums.rows(index);
        if rows < 2 * channel.places.len() {
            let message = format!(
                "`{}` has {rows} usable samples for {} parameters that act on it",
                channel.name,
                channel.places.len()
            );
            return Err(Diagnostic::error(message)
                .help("record longer, decimate less, or count slow samples too (--slow 0)"));
        }
    }
    Ok(())
}

/// Least squares of the wanted kind; Huber's weights need further passes over the logs.
fn estimated(
    design: &Design<'_>,
    logs: &[Log<'_>],
    motions: &Motions,
    settings: &Settings,
    options: &Options,
    (raw, nominal): (&Sums, &DVector<f64>),
) -> Result<(Estimate, Sums), Diagnostics> {
    let mut estimate = Estimate::weighted(design, raw, nominal.clone(), options.method);
    let mut sums = raw.clone();
    if options.method != Method::Huber {
        return Ok((estimate, sums));
    }
    let mut scale = estimate.noise.clone();
    for _ in 0..PASSES {
        let theta = estimate.solve(&estimate.total, &estimate.seen);
        let weighting = Weighting { theta, scale: scale.clone(), bend: BEND };
        sums = accumulate(design, logs, motions, settings, Some(&weighting))?;
        let robust = |(sizes, old): (&super::accumulate::Sizes, &f64)| {
            // The median of |x| of a normal x is 0.6745 standard deviations.
            sizes.median().map_or(*old, |median| (median / 0.6745).max(f64::MIN_POSITIVE.sqrt()))
        };
        scale = sums.sizes.iter().zip(&scale).map(robust).collect();
        estimate = Estimate::new(design, &sums, &scale, nominal.clone());
    }
    Ok((estimate, sums))
}

fn condition(values: &[f64]) -> f64 {
    let (most, least) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
    most / least.max(f64::MIN_POSITIVE)
}

fn assumptions(surveys: &[Survey]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for assumption in surveys.iter().flat_map(|s| &s.assumptions) {
        if !all.contains(assumption) {
            all.push(assumption.clone());
        }
    }
    all
}

/// What was found, to be put into words.
struct Found<'a> {
    design: &'a Design<'a>,
    motions: &'a Motions,
    raw: &'a Sums,
    estimate: &'a Estimate,
    fit: &'a Fit,
}

impl Found<'_> {
    fn logs(&self, logs: &[Log<'_>], surveys: &[Survey]) -> Vec<LogSummary> {
        let summary = |(log, survey): (&Log<'_>, &Survey)| LogSummary {
            file: log.path.display().to_string(),
            samples: survey.samples,
            step: survey.step,
            cutoff_hz: survey.cutoff_hz,
        };
        logs.iter().zip(surveys).map(summary).collect()
    }

    fn parameters(&self, nominal: &DVector<f64>, essential: &Essential) -> Vec<Parameter> {
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
        self.estimate.seen.iter().map(parameter).collect()
    }

    fn unseen(&self) -> Vec<String> {
        let all = 0..self.design.unknowns.len();
        let unseen = all.filter(|k| !self.estimate.seen.contains(k));
        unseen.map(|k| self.design.unknowns[k].name.clone()).collect()
    }

    fn pairs(&self) -> Vec<Pair> {
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

    fn essential(&self, essential: &Essential) -> EssentialSummary {
        let name = |&k: &usize| self.design.unknowns[k].name.clone();
        EssentialSummary {
            parameters: essential.unknowns.iter().map(name).collect(),
            held_out: essential.held_out[1].relative(),
            held_out_of_all: essential.held_out[0].relative(),
        }
    }

    fn channels(
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
            measured: (fitted[index].measured / own[index].rows().max(1) as f64).sqrt(),
            description: cad[index].rms(),
            least_squares: fitted[index].rms(),
            held_out: held.iter().fold(Held::default(), |sum, fold| sum.plus(&fold[index])).rms(),
            physical: physical[index].rms(),
        };
        self.design.channels.iter().enumerate().map(summary).collect()
    }

    fn validation(
        &self,
        parts: &Parts<'_>,
        judge: &Log<'_>,
        settings: &Settings,
        models: [&DVector<f64>; 4],
    ) -> Result<Validation, Diagnostics> {
        let look = survey(judge, parts.subject)?;
        let all: Vec<Survey> = parts.surveys.iter().cloned().chain([look.clone()]).collect();
        let last = parts.surveys.len();
        let again = |r: &Repetition| matches!(r, Repetition::Between { log, .. } if *log == last);
        let shares_motion = Motions::new(&all).repetitions.iter().any(again);
        let own = Motions::new(&[look]);
        let sums = accumulate(self.design, std::slice::from_ref(judge), &own, settings, None)?;
        let channels = by_channel(&sums, self.design, &|_| true);
        let held = models.map(|theta| errors(&channels, self.design, theta));
        let of = |index: usize| [0, 1, 2, 3].map(|m: usize| held[m][index]);
        let channel = |(index, channel): (usize, &super::Channel)| {
            let held = of(index);
            ValidationChannel {
                name: channel.name.clone(),
                unit: channel.unit,
                measured: (held[0].measured / held[0].rows.max(1) as f64).sqrt(),
                rms: Models::of(held, Held::rms),
            }
        };
        let sum = |m: usize| held[m].iter().fold(Held::default(), |sum, e| sum.plus(e));
        Ok(Validation {
            file: judge.path.display().to_string(),
            shares_motion,
            channels: self.design.channels.iter().enumerate().map(channel).collect(),
            total: Models::of([0, 1, 2, 3].map(sum), Held::relative),
        })
    }

    fn physical(&self, problem: &Problem<'_>, found: &Physical, choice: Choice) -> PhysicalSummary {
        let covariance = self.spread(problem, found, choice.weight);
        let links: Vec<LinkSummary> = problem
            .links
            .bodies
            .iter()
            .zip(found.coordinates.chunks_exact(10))
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
            name: extra.name(self.design.subject),
            unit: extra.unit(self.design.subject),
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

    fn warnings(&self, logs: &[Log<'_>], surveys: &[Survey], problem: &Problem<'_>) -> Vec<String> {
        let name = |log: usize| {
            logs[log].path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
        };
        let mut all: Vec<String> =
            surveys.iter().flat_map(|s| &s.warnings).map(|w| w.message.clone()).collect();
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
        all
    }
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
fn student(stretches: usize) -> f64 {
    let (z, n) = (1.959_964_f64, stretches.saturating_sub(1).max(1) as f64);
    z + (z.powi(3) + z) / (4.0 * n) + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
}

/// Judged again from the numbers alone.
pub fn judged(links: &[(String, Inertia)]) -> Vec<(String, Consistency)> {
    links.iter().map(|(name, inertia)| (name.clone(), check(inertia))).collect()
}
