//! A walk whose parameters are chosen at each mid-stance, and the speeds that it reaches.
use super::choosers::{Choosers, Walked};
use super::gait::Walker;
use crate::gait::choice::{StepPart, StepSpeed};
use bipedc_analysis::gait::{Assumptions, GaitModel};
use bipedc_analysis::report::{CurveFigure, CurveKind, PlottedCurve, Table as PageTable};
use bipedc_analysis::simulate::phases::{LandingGuard, WalkSummary, Walking};
use bipedc_analysis::simulate::{self, Sample};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::Borrowed;
use comfy_table::{CellAlignment, Table};
use serde::Serialize;
use std::fmt;

/// Steps that the table shows.
const SHOWN: usize = 40;
/// By how much a speed that was met may differ from the wished one, as a part of it or of 1.
const MET: f64 = 1e-6;

/// Wished, predicted and reached speeds at mid-stance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WalkedSpeeds {
    /// Of all speeds.
    pub unit: String,
    /// Steps that had a wish and passed their mid-stance.
    pub wished: usize,
    /// Those of them whose speed was the wished one within 1e-6 of it, or of 1 below 1.
    pub met: usize,
    /// The largest difference of a speed that was reached from the wished one, per s.
    pub largest_miss: f64,
    /// The largest difference of a speed that was reached from its prediction, per s.
    pub largest_surprise: f64,
    /// What choices kept of `friction`, `pull`, `clearance`, `torque` and `joints`; `None`: all that the scenario assumes.
    pub keep: Option<Vec<&'static str>>,
    /// Step after step.
    pub steps: Vec<StepSpeed>,
    /// Of the zero dynamics, as they were walked.
    #[serde(skip)]
    pub energies: Vec<StepEnergy>,
}

/// Energies of the zero dynamics at a row of the log, (kg m²/s)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepEnergy {
    /// The step it belongs to.
    pub step: usize,
    /// s
    pub time: f64,
    /// K = σ²/2, of the angular momentum of the whole robot as it moves.
    pub kinetic: f64,
    /// P(φ) from the beginning of the step (6.10); with other parameters it goes on where it was.
    pub potential: f64,
}

/// Walks with parameters that are chosen at each mid-stance; `drawn`: with the energies of the zero dynamics, of gaits of one phase.
pub(super) fn walk(
    (gait, choosers): (&Walker, &Choosers<'_, '_>),
    walking: &Walking<'_>,
    (run, watch): (&mut simulate::Run<'_>, &mut dyn FnMut(&Sample)),
    drawn: bool,
) -> (Result<WalkSummary, Diagnostic>, Option<WalkedSpeeds>) {
    let mut samples: Vec<State> = Vec::new();
    let mut watch = |sample: &Sample| {
        if drawn {
            samples.push((sample.time, sample.q.clone(), sample.v.clone()));
        }
        watch(sample);
    };
    let walked = choosers.walk(gait, |controller, present| {
        let ending = gait.ending(present);
        let ending = ending.as_ref().map(|ending| ending as &LandingGuard<'_>);
        walking.run_until(Borrowed(controller), ending, run, &mut watch)
    });
    let (summary, Walked { steps, parts }) = match walked {
        Ok(walked) => walked,
        Err(error) => return (Err(error), None),
    };
    let mut speeds = WalkedSpeeds::of(gait.speed_unit(), steps);
    speeds.keep = gait.kept();
    if let Choosers::OnePhase(model, _) = choosers {
        speeds.energies = energies(model, &parts, &samples);
    }
    (summary, Some(speeds))
}

/// Time, q and v.
type State = (f64, Vec<f64>, Vec<f64>);

/// What was walked, as energies of the zero dynamics; every second step stands on the other leg.
fn energies(model: &GaitModel<'_>, parts: &[StepPart], samples: &[State]) -> Vec<StepEnergy> {
    let mut found = Vec::new();
    let mut offset = 0.0;
    for (index, part) in parts.iter().enumerate() {
        let Ok(course) = model.course_from(&part.parameters, &part.q, &part.v) else { continue };
        let next = parts.get(index + 1);
        let end = next.map_or(f64::INFINITY, |next| next.time);
        for (time, q, v) in samples.iter().filter(|(time, ..)| (part.time..end).contains(time)) {
            let [q, v] = match part.step % 2 {
                0 => [q.clone(), v.clone()],
                _ => model.relabelled(q, v),
            };
            let Ok(potential) = course.potential(model.phase_at(&q, &v)[0]) else { continue };
            let kinetic = 0.5 * model.momentum(&q, &v).powi(2);
            found.push(StepEnergy { step: part.step, time: *time, kinetic, potential: offset + potential });
        }
        offset = match next.filter(|next| next.step == part.step) {
            Some(next) => {
                let phase = model.phase_at(&next.q, &next.v)[0];
                offset + course.potential(phase).unwrap_or(0.0)
            }
            None => 0.0,
        };
    }
    found
}

impl WalkedSpeeds {
    fn of(unit: String, steps: Vec<StepSpeed>) -> Self {
        let pairs = || steps.iter().filter_map(|step| Some((step.wished?, step.reached?)));
        let met = |(wished, reached): &(f64, f64)| (wished - reached).abs() <= MET * wished.max(1.0);
        let surprises = steps.iter().filter_map(|step| Some((step.predicted? - step.reached?).abs()));
        Self {
            unit,
            wished: pairs().count(),
            met: pairs().filter(met).count(),
            largest_miss: pairs().map(|(wished, reached)| (wished - reached).abs()).fold(0.0, f64::max),
            largest_surprise: surprises.fold(0.0, f64::max),
            keep: None,
            steps,
            energies: Vec::new(),
        }
    }

    /// The energies of the zero dynamics over time, step after step, as the thesis draws them (figures 7.8 and 7.9).
    pub fn figure(&self, robot: &str, title: &str) -> CurveFigure {
        type Of = fn(&StepEnergy) -> f64;
        let curve = |kind, words: &str, of: Of| {
            let mut points = Vec::new();
            let mut last = None;
            for energy in &self.energies {
                if last.is_some_and(|step| step != energy.step) {
                    points.push([energy.time, f64::NAN]);
                }
                last = Some(energy.step);
                points.push([energy.time, of(energy)]);
            }
            PlottedCurve { kind, words: words.to_owned(), points }
        };
        CurveFigure {
            title: title.to_owned(),
            robot: robot.to_owned(),
            x: "time (s)".to_owned(),
            y: "energy of the zero dynamics ((kg m²/s)²)".to_owned(),
            counted: [false, false],
            from_zero: false,
            curves: vec![
                curve(CurveKind::Other, "K, kinetic", |e| e.kinetic),
                curve(CurveKind::Third, "P, potential", |e| e.potential),
                curve(CurveKind::Limit, "E, both", |e| e.kinetic + e.potential),
            ],
            facts: Vec::new(),
            table: PageTable { caption: String::new(), head: Vec::new(), rows: Vec::new() },
        }
    }
}

impl fmt::Display for WalkedSpeeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { unit, wished, met, largest_miss, largest_surprise, steps, .. } = self;
        let mut table = Table::new();
        table.load_preset(comfy_table::presets::NOTHING);
        let names = steps.first().into_iter().flat_map(|step| step.parameters.keys().cloned());
        let head = ["step", "wished", "predicted", "reached", "choice"].map(str::to_owned);
        table.set_header(head.into_iter().chain(names));
        let number = |x: Option<f64>| x.map_or_else(|| "—".to_owned(), |x| format!("{x:.6}"));
        for step in steps.iter().take(SHOWN) {
            let choice = step.choice.map_or("—", |kind| kind.words());
            let speeds = [step.wished, step.predicted, step.reached].map(number);
            let first = std::iter::once(step.step.to_string()).chain(speeds).chain([choice.to_owned()]);
            table.add_row(first.chain(step.parameters.values().map(|x| format!("{x:.6}"))));
        }
        for column in table.column_iter_mut().filter(|column| column.index != 4) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        writeln!(f, "\nspeeds at mid-stance in {unit}\n{table}")?;
        if steps.len() > SHOWN {
            writeln!(f, "… and {} more: see --json", steps.len() - SHOWN)?;
        }
        if let Some(keep) = &self.keep {
            let left = Assumptions::default().named().map(|(name, _)| name);
            let left: Vec<&str> = left.into_iter().filter(|name| !keep.contains(name)).collect();
            let left = if left.is_empty() { String::new() } else { format!("; not {}", left.join(", ")) };
            let keep = if keep.is_empty() { "nothing".to_owned() } else { keep.join(", ") };
            writeln!(f, "choices kept {keep}{left} (`keep` of [control.choice])")?;
        }
        writeln!(
            f,
            "{met} of {wished} wished speeds were met within {MET:.0e}; largest difference from a wish {largest_miss:.1e} {unit}, from a prediction {largest_surprise:.1e} {unit}\n"
        )
    }
}
