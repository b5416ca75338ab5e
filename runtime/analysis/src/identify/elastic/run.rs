//! All steps of the identification of series elastic drives in their order.
use super::super::design::Design;
use super::super::motions::Motions;
use super::super::physical::{Bound, Inertia};
use super::super::reading::Reading;
use super::super::result::Identification;
use super::super::run::{RobotAndLogs, nominal};
use super::super::unknowns::{Extra, ExtraChoice, Law};
use super::bodies::Bodies;
use super::check::{odd, stops};
use super::driven::Driven;
use super::fold::{Folded, Folding, fold};
use super::laws::{Estimator, Laws, Steps};
use super::look::Look;
use super::picture;
use super::solve::{Solved, Solver};
use super::summary::{DriveSummary, SummaryInput};
use crate::experiments::plotted::Row;
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use nalgebra::DVector;
use serde::Serialize;

/// Rows that a motor's regression needs per unknown.
const ROWS: usize = 10;

/// The robot, its drives and logs.
pub struct ElasticParts<'a> {
    /// Bodies and the observed joints; its surveys are those of `looks`.
    pub parts: RobotAndLogs<'a>,
    /// Drives.
    pub drives: &'a [Driven<'a>],
    /// What each log shows.
    pub looks: &'a [Look],
    /// Logs that teach.
    pub logs: &'a [Reading<'a>],
}

/// How to identify.
#[derive(Debug, Clone)]
pub struct Elastic {
    /// What motors and stiff drives consist of.
    pub laws: Laws,
    /// Part of a motor's largest speed below which its samples do not count.
    pub slow: f64,
    /// One after the other or at once.
    pub steps: Steps,
    /// How residuals count.
    pub estimator: Estimator,
    /// Weight of the described bodies; none: chosen by folds.
    pub weight: Option<f64>,
    /// What is known beside the data.
    pub bounds: Vec<Bound>,
    /// Go on although signals seem to be mixed up.
    pub anyway: bool,
    /// Whether torques over time are wanted, for a report.
    pub pictures: bool,
}

/// The answer: of the drives, of the bodies, and the links' new inertias.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticAnswer {
    /// Of the bodies, as from joint torques.
    #[serde(flatten)]
    pub identification: Identification,
    /// Of the drives.
    pub drives: DriveSummary,
    /// By link name.
    #[serde(skip)]
    pub links: Vec<(String, Inertia)>,
    /// Torques of the joints over time, if they were wanted: of the log that judges, or else the first.
    #[serde(skip)]
    pub pictures: Vec<Row>,
}

/// Estimates friction and springs, then bodies.
///
/// # Errors
/// Unreadable logs, mixed-up signals, data that cannot carry an estimate.
pub fn identify_elastic(
    all: &ElasticParts<'_>,
    judge: Option<(&Reading<'_>, &Look)>,
    options: &Elastic,
    progress: &dyn Fn(f64),
) -> Result<ElasticAnswer, Diagnostics> {
    let one = |error: Diagnostic| Diagnostics(vec![error]);
    let (parts, layout) = (&all.parts, all.parts.layout);
    let warnings = checked(all, judge, options)?;
    let joints: Vec<usize> = parts.rows.iter().filter_map(|row| row.checked_sub(layout.base.nv())).collect();
    let extras = extras(all.drives, &joints, options.laws);
    let extras = ExtraChoice { exactly: Some(extras), ..ExtraChoice::none() };
    let design = Design::new(layout, parts.base, parts.regressor, extras.list(&joints), parts.rows);
    let slow: Vec<f64> = (0..all.drives.len()).map(|t| options.slow * fastest(all.looks, t)).collect();
    let folding = Folding {
        design: &design,
        drives: all.drives,
        laws: options.laws,
        slow: &slow,
        instruments: options.estimator == Estimator::Instrumental,
    };
    let folded = fold(&folding, all.logs, &Motions::new(parts.surveys))?;
    let judged = judge.map(|judge| folded_judge(&folding, judge)).transpose()?;
    enough(&folded, &folding, options.slow).map_err(one)?;
    progress(0.2);
    let nominal = nominal(&design, &parts.link_inertias.parameters(), &extras);
    let solved = solved(all, options, &folding, &folded, &nominal).map_err(one)?;
    progress(0.3);
    let bodies = Bodies {
        design: &design,
        folded: &folded,
        judged: judged.as_ref(),
        solved: &solved,
        nominal: &nominal,
        extras: &extras,
    };
    let (mut identification, links) = bodies.identify(parts, judge, options, &|p| progress(0.3 + 0.7 * p))?;
    let drives = SummaryInput {
        layout,
        drives: all.drives,
        looks: all.looks,
        folded: &folded,
        judged: judged.as_ref(),
        solved: &solved,
        laws: options.laws,
    }
    .summary(options, &identification.parameters);
    identification.warnings.extend(warnings);
    identification.warnings.extend(drives.joints.iter().flat_map(|joint| joint.warnings()));
    identification.assumptions.extend(assumptions(all.drives, &joints, layout));
    let shown = judge.map(|(reading, _)| reading).or(all.logs.first()).filter(|_| options.pictures);
    let pictures = shown.map(|reading| picture::of_log(&folding, reading, &solved, &nominal)).transpose()?;
    let pictures = pictures.unwrap_or_default();
    Ok(ElasticAnswer { identification, drives, links, pictures })
}

/// Motors, springs and joints.
fn solved(
    all: &ElasticParts<'_>,
    options: &Elastic,
    folding: &Folding<'_, '_>,
    folded: &Folded,
    nominal: &DVector<f64>,
) -> Result<Solved, Diagnostic> {
    let solver = Solver {
        design: folding.design,
        folded,
        drives: all.drives,
        layout: all.parts.layout,
        steps: options.steps,
        estimator: options.estimator,
        nominal: nominal.clone(),
    };
    solver.solve()
}

/// The log that judges, cut by its own motions.
fn folded_judge(
    folding: &Folding<'_, '_>,
    (reading, look): (&Reading<'_>, &Look),
) -> Result<Folded, Diagnostics> {
    let own = Motions::new(std::slice::from_ref(&look.survey));
    fold(folding, std::slice::from_ref(reading), &own)
}

/// Looks for mixed-up signals; what does not stop becomes a warning.
fn checked(
    all: &ElasticParts<'_>,
    judge: Option<(&Reading<'_>, &Look)>,
    options: &Elastic,
) -> Result<Vec<String>, Diagnostics> {
    for driven in all.drives {
        driven.check(all.parts.layout).map_err(|error| Diagnostics(vec![error]))?;
    }
    if options.steps == Steps::One && options.estimator != Estimator::Weighted {
        let error = Diagnostic::error(
            "one regression of motors and joints needs weights: their torques differ by the gear",
        )
        .help("leave out --estimator, or --steps one");
        return Err(Diagnostics(vec![error]));
    }
    let logs = all.logs.iter().zip(all.looks).chain(judge);
    let mut found: Vec<Diagnostic> = logs
        .flat_map(|(reading, look)| {
            let list = odd(look, all.drives, all.parts.layout).into_iter();
            list.map(|diagnostic| diagnostic.in_file(reading.log.path())).collect::<Vec<_>>()
        })
        .collect();
    if options.anyway {
        found.iter_mut().for_each(|diagnostic| diagnostic.severity = Severity::Warning);
    }
    if stops(&found) {
        return Err(Diagnostics(found));
    }
    Ok(found.into_iter().map(|diagnostic| diagnostic.message).collect())
}

/// Friction and offset of stiff drives; of springs only what a shifted encoder adds to their torque. With described
/// values at the joint.
fn extras(drives: &[Driven<'_>], joints: &[usize], laws: Laws) -> Vec<(Extra, f64)> {
    let mut all = Vec::new();
    for Driven { joint, drive } in drives.iter().filter(|driven| joints.contains(&driven.joint)) {
        let stiff = drive.is_stiff();
        let wanted = [
            (stiff && laws.viscous, Law::VISCOUS, drive.viscous_friction_at_joint()),
            (stiff && laws.coulomb, Law::COULOMB, drive.coulomb_friction_at_joint()),
            (drive.has_motor() && laws.offset, Law::OFFSET, 0.0),
        ];
        let of = |law| Extra { law, joint: *joint, other: *joint };
        all.extend(wanted.into_iter().filter(|w| w.0).map(|(_, law, value)| (of(law), value)));
    }
    all
}

fn fastest(looks: &[Look], drive: usize) -> f64 {
    looks.iter().map(|look| look.drives[drive].speed).fold(0.0, f64::max)
}

/// Refuses motors with hardly a usable row.
fn enough(folded: &Folded, folding: &Folding<'_, '_>, slow: f64) -> Result<(), Diagnostic> {
    for (k, &t) in folded.elastic.iter().enumerate() {
        let rows = folded.motor_rows(k);
        if rows < ROWS * folding.laws.count() {
            let name = &folding.design.layout.joints[folding.drives[t].joint].name;
            let message = format!(
                "the motor of `{name}` has {rows} usable samples for {} parameters: elsewhere it is slower than {:.3} rad/s ({} % of its largest speed)",
                folding.laws.count(),
                folding.slow[t],
                100.0 * slow
            );
            return Err(Diagnostic::error(message)
                .help("record a longer or faster motion, or count slower samples too (--slow)"));
        }
    }
    Ok(())
}

fn assumptions(drives: &[Driven<'_>], joints: &[usize], layout: &JointLayout) -> Vec<String> {
    let name = |driven: &Driven<'_>| layout.joints[driven.joint].name.clone();
    let passive: Vec<String> =
        drives.iter().filter(|d| !d.drive.has_motor() && joints.contains(&d.joint)).map(name).collect();
    let mut all =
        vec!["inertia of the rotors, gears, pulley radii and torque constants are as described".to_owned()];
    if !passive.is_empty() {
        all.push(format!(
            "springs and dampers beside passive joints are as described: {}",
            passive.join(", ")
        ));
    }
    all
}
