//! All steps of identification in their order.
use super::accumulate::{Settings, Sums, Weighting, accumulate, fold_table};
use super::design::{BatchRegressor, Design};
use super::dry_friction::{slow, uncertain_friction};
use super::essential::essential;
use super::estimate::{Estimate, Fit, Method};
use super::motions::Motions;
use super::physical::{Bound, Bounds, Choice, Consistency, Inertia, Links, check, choose, problem};
use super::picture;
use super::reading::Reading;
use super::regressor_noise::noise_effect;
use super::result::Identification;
use super::row_cutoff;
use super::summary::{Steps, SummaryInput};
use super::survey::Survey;
use super::unknowns::{BaseSet, ExtraChoice};
use crate::experiments::Experiment;
use crate::experiments::plotted::Row;
use crate::robot::inertial_parameters::InertialParameters;
use crate::robot::{JointLayout, LinkInertias};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use nalgebra::DVector;
use std::path::{Path, PathBuf};

/// Passes of Huber's estimator.
const PASSES: usize = 6;
/// Huber's bend in scales: 95 % of the efficiency of least squares on normal errors.
const BEND: f64 = 1.345;

/// The robot, and what its logs show.
pub struct RobotAndLogs<'a> {
    /// Joints and base.
    pub layout: &'a JointLayout,
    /// Links.
    pub link_inertias: &'a LinkInertias,
    /// Base parameters of the observed rows.
    pub base: &'a BaseSet,
    /// Their regressor.
    pub regressor: &'a dyn BatchRegressor,
    /// Observed rows of `v`.
    pub rows: &'a [usize],
    /// Names of the logs.
    pub files: &'a [PathBuf],
    /// What each log shows.
    pub surveys: &'a [Survey],
}

/// Where samples come from.
pub enum Feed<'a> {
    /// Logs of joint torques, read as often as they are needed.
    Logs(&'a [Reading<'a>]),
    /// Logs of a free robot with forces at its feet, in memory.
    Tables(&'a [&'a dyn Experiment]),
    /// Samples that were folded in already.
    Folded(&'a Sums),
}

impl Feed<'_> {
    /// One pass over all samples.
    pub(super) fn pass(
        &self,
        (design, base): (&Design<'_>, &BaseSet),
        motions: &Motions,
        settings: &Settings,
        weighting: Option<&Weighting>,
    ) -> Result<Sums, Diagnostics> {
        match self {
            Self::Logs(logs) => accumulate(design, logs, motions, settings, weighting),
            Self::Tables(tables) => {
                let mut sums = Sums::new(design, motions.cells());
                for (index, table) in tables.iter().enumerate() {
                    fold_table(design, base, *table, &|time| motions.cell(index, time), weighting, &mut sums);
                }
                Ok(sums)
            }
            // Residuals cannot be weighed one by one any more: callers leave Huber's estimator out.
            Self::Folded(sums) => Ok((*sums).clone()),
        }
    }
}

/// A log that only judges.
pub struct Judge<'a> {
    /// Its samples.
    pub feed: Feed<'a>,
    /// What it shows.
    pub survey: &'a Survey,
    /// Its name.
    pub file: &'a Path,
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
    /// Cut-off of the low-pass over regressor and torque of logs that are not decimated, Hz; none: as the noise asks for.
    pub rows_hz: Option<f64>,
    /// Part of a joint's largest speed below which its samples do not count; none: a tenth, or a quarter of its usual speed if that is less, of joints
    /// with dry friction.
    pub slow: Option<f64>,
    /// Weight of CAD; none: chosen by folds.
    pub weight: Option<f64>,
    /// What is known beside the data.
    pub bounds: Vec<Bound>,
    /// Whether torques over time are wanted, for a report.
    pub pictures: bool,
    /// Rows are few, such as those of postures: all of them together must tell the unknowns, not each channel's.
    pub scarce: bool,
}

/// The answer, and the links' new inertias for a URDF.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentificationResult {
    /// For people and programs.
    pub identification: Identification,
    /// By link name.
    pub links: Vec<(String, Inertia)>,
    /// Torques over time by description and least squares, of the log that judges or else the first; if they were wanted
    /// and logs of joint torques taught.
    pub pictures: Vec<Row>,
}

/// Estimates parameters from logs; `judge` is a log that only judges.
///
/// # Errors
/// Unreadable logs, data that cannot carry an estimate, bounds that contradict each other.
pub fn identify(
    parts: &RobotAndLogs<'_>,
    feed: &Feed<'_>,
    judge: Option<&Judge<'_>>,
    options: &Options,
    progress: &dyn Fn(f64),
) -> Result<IdentificationResult, Diagnostics> {
    let one = |diagnostic: Diagnostic| Diagnostics(vec![diagnostic]);
    let design = design(parts, feed, options);
    let motions = Motions::new(parts.surveys);
    let (settings, raw) = folded(parts, (&design, feed), &motions, options)?;
    enough(&design, &raw, options.scarce).map_err(one)?;
    progress(0.3);
    let nominal = nominal(&design, &parts.link_inertias.parameters(), &options.extras);
    let (estimate, sums) =
        estimated((&design, parts.base), feed, &motions, &settings, options, (&raw, &nominal))?;
    let mut fit = checked_fit(&estimate, &design, &sums).map_err(one)?;
    if let Feed::Logs(_) = feed {
        let effect = noise_effect(parts, (&design, &sums, &settings), &estimate, &fit.theta);
        fit.widen(effect.moved, effect.untold);
        uncertain_friction(parts, &design, &mut fit);
    }
    let folds = motions.folds();
    let essential = essential(&estimate, &design, &raw, &folds);
    progress(0.5);
    let links = Links::new(parts.link_inertias);
    let bounds = Bounds::new(&options.bounds, &links).map_err(one)?;
    let problem = problem(&design, &links, &bounds);
    let choice = match options.weight {
        Some(weight) => Choice { weight, trials: Vec::new() },
        None => {
            choose(&problem, &design, &raw, &estimate, &folds, &|p| progress(0.5 + 0.4 * p)).map_err(one)?
        }
    };
    let physical = problem.solve(&estimate.total.least_squares(), choice.weight).map_err(one)?;
    let zeros = estimate.clone().with_held(DVector::zeros(nominal.len()));
    let essential_theta = zeros.solve(&zeros.total, &essential.unknowns);
    let models = [&nominal, &fit.theta, &essential_theta, &physical.theta];
    let found = SummaryInput {
        design: &design,
        motions: &motions,
        raw: &raw,
        estimate: &estimate,
        fit: &fit,
        rows_hz: settings.rows_hz,
    };
    let validation = judge.map(|judge| found.validation(parts, judge, &settings, models)).transpose()?;
    progress(1.0);
    let steps = Steps {
        nominal: &nominal,
        essential: &essential,
        problem: &problem,
        physical: &physical,
        choice,
        validation,
    };
    let identification = found.identification(parts, options.method, steps);
    let shown = judge.map_or(feed, |judge| &judge.feed);
    let pictures = pictures(shown, options, &design, &settings, [&nominal, &fit.theta])?;
    let new = links.bodies.iter().zip(physical.coordinates.chunks_exact(InertialParameters::PER_BODY));
    let links = new.map(|(body, x)| (body.name.clone(), body.inertia(x))).collect();
    Ok(IdentificationResult { identification, links, pictures })
}

fn settings(
    parts: &RobotAndLogs<'_>,
    (design, feed, motions): (&Design<'_>, &Feed<'_>, &Motions),
    options: &Options,
) -> Settings {
    let most = design.channels.iter().map(|channel| channel.places.len()).max().unwrap_or(0);
    let are_read = matches!(feed, Feed::Logs(_)) && options.decimate <= 1;
    let chosen = || row_cutoff::chosen(parts.surveys, most, motions.stretch());
    Settings {
        decimate: options.decimate,
        rows_hz: if are_read { options.rows_hz.or_else(chosen) } else { None },
        slow: slow(parts, options.slow),
        slow_if_dry: options.slow.is_none(),
        speed: fastest(parts),
        threads: std::thread::available_parallelism().map_or(1, usize::from).min(8),
    }
}

/// How rows count, and all of them: behind a filter of our own choice only where enough is left, since rests cost more there.
fn folded(
    parts: &RobotAndLogs<'_>,
    (design, feed): (&Design<'_>, &Feed<'_>),
    motions: &Motions,
    options: &Options,
) -> Result<(Settings, Sums), Diagnostics> {
    let settings = settings(parts, (design, feed, motions), options);
    let raw = feed.pass((design, parts.base), motions, &settings, None)?;
    let chosen = settings.rows_hz.is_some() && options.rows_hz.is_none();
    if !chosen || enough(design, &raw, options.scarce).is_ok() {
        return Ok((settings, raw));
    }
    let settings = Settings { rows_hz: None, ..settings };
    let raw = feed.pass((design, parts.base), motions, &settings, None)?;
    Ok((settings, raw))
}

/// Torques over time, if they are wanted and the feed has any.
fn pictures(
    feed: &Feed<'_>,
    options: &Options,
    design: &Design<'_>,
    settings: &Settings,
    models: [&DVector<f64>; 2],
) -> Result<Vec<Row>, Diagnostics> {
    match feed {
        Feed::Logs([reading, ..]) if options.pictures => {
            picture::of_log(design, reading, &settings.speed, models)
        }
        _ => Ok(Vec::new()),
    }
}

/// The fit, if the data tell anything and all of it is a number.
fn checked_fit(estimate: &Estimate, design: &Design<'_>, sums: &Sums) -> Result<Fit, Diagnostic> {
    if estimate.seen.is_empty() {
        return Err(Diagnostic::error("the data tell none of the parameters")
            .help("record a motion in which all joints move"));
    }
    let fit = estimate.fit(design, sums);
    match fit.theta.iter().position(|theta| !theta.is_finite()) {
        None => Ok(fit),
        Some(k) => {
            let message = format!("the estimate of `{}` is no number", design.unknowns[k].name);
            Err(Diagnostic::error(message).help("are positions and efforts of the logs in SI units?"))
        }
    }
}

fn design<'a>(parts: &RobotAndLogs<'a>, feed: &Feed<'_>, options: &Options) -> Design<'a> {
    if let Feed::Tables([first, ..]) = feed {
        return Design::of_table(parts.layout, parts.base, *first);
    }
    let nb = parts.layout.base.nv();
    let joints: Vec<usize> = parts.rows.iter().filter_map(|row| row.checked_sub(nb)).collect();
    let mut extras = options.extras.list(&joints);
    extras.retain(|extra| joints.contains(&extra.joint) && joints.contains(&extra.other));
    Design::new(parts.layout, parts.base, parts.regressor, extras, parts.rows)
}

pub(super) fn fastest(parts: &RobotAndLogs<'_>) -> Vec<f64> {
    let speed = |joint| parts.surveys.iter().map(|s| s.speed[joint]).fold(0.0, f64::max);
    (0..parts.layout.joints.len()).map(speed).collect()
}

/// The unknowns for these inertial parameters; extras as described, else zero.
pub(super) fn nominal(design: &Design<'_>, parameters: &[f64], extras: &ExtraChoice) -> DVector<f64> {
    let value = |sum: &[(super::Summand, f64)]| -> f64 {
        let term = |(part, factor): &(super::Summand, f64)| match part {
            super::Summand::Inertial(k) => factor * parameters[*k],
            super::Summand::Extra(k) => factor * extras.described(&design.extras[*k]),
        };
        sum.iter().map(term).sum()
    };
    DVector::from_iterator(design.unknowns.len(), design.sums().map(value))
}

/// Refuses channels with fewer rows than unknowns; of scarce rows, all channels together.
fn enough(design: &Design<'_>, sums: &Sums, scarce: bool) -> Result<(), Diagnostic> {
    if scarce {
        return enough_together(design, sums);
    }
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

/// Refuses fewer rows than unknowns, over all channels.
fn enough_together(design: &Design<'_>, sums: &Sums) -> Result<(), Diagnostic> {
    let rows: usize = (0..design.channels.len()).map(|channel| sums.rows(channel)).sum();
    let unknowns = design.unknowns.len();
    if rows > unknowns {
        return Ok(());
    }
    let each = design.channels.len().max(1);
    let message = format!(
        "{} postures give {rows} equations for {unknowns} parameters: at least {} postures are needed (thesis 5.4.1)",
        rows / each,
        unknowns / each + 1
    );
    Err(Diagnostic::error(message)
        .help("take three times as many; `bipedc excite ROBOT --postures 50` designs them"))
}

/// Least squares of the wanted kind; Huber's weights need further passes over the logs.
fn estimated(
    (design, base): (&Design<'_>, &BaseSet),
    feed: &Feed<'_>,
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
        sums = feed.pass((design, base), motions, settings, Some(&weighting))?;
        let robust = |(sizes, old): (&super::accumulate::Sizes, &f64)| {
            // The median of |x| of a normal x is 0.6745 standard deviations.
            sizes.median().map_or(*old, |median| (median / 0.6745).max(f64::MIN_POSITIVE.sqrt()))
        };
        scale = sums.sizes.iter().zip(&scale).map(robust).collect();
        estimate = Estimate::new(design, &sums, &scale, nominal.clone());
    }
    Ok((estimate, sums))
}

/// Judged again from the numbers alone.
pub fn judged(links: &[(String, Inertia)]) -> Vec<(String, Consistency)> {
    links.iter().map(|(name, inertia)| (name.clone(), check(inertia))).collect()
}
