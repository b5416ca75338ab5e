//! A walk whose parameters are chosen at each mid-stance, and the speeds that it reaches.
use super::gait::Walker;
use crate::gait::choice::{Choosing, StepSpeed, chooser};
use crate::progress::Run;
use bipedc_analysis::gait::{Chooser, GaitModel};
use bipedc_analysis::simulate::phases::{LandingGuard, WalkSummary, Walking};
use bipedc_analysis::simulate::{self, Sample};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
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
    /// The largest difference of a speed that was reached from its prediction, per s.
    pub largest_surprise: f64,
    /// Step after step.
    pub steps: Vec<StepSpeed>,
}

/// What a walk chooses by.
pub(super) struct Chosen<'c> {
    gait: &'c Walker,
    model: &'c GaitModel<'c>,
    chooser: Chooser<'c, 'c>,
}

impl<'c> Chosen<'c> {
    /// Computes the steps that are chosen from.
    ///
    /// # Errors
    /// There is nothing to choose; an interruption.
    pub fn begin(gait: &'c Walker, model: &'c GaitModel<'c>, run: &Run<'_>) -> Result<Self, Diagnostics> {
        let interrupted = || Diagnostic::error("interrupted before the walk began");
        let wished = gait.wishes.as_ref().ok_or_else(interrupted)?;
        let chooser = chooser(model, wished.settings.clone(), run).ok_or_else(interrupted)?;
        Ok(Self { gait, model, chooser })
    }

    /// Walks.
    pub fn walk(
        &self,
        walking: &Walking<'_>,
        (run, watch): (&mut simulate::Run<'_>, &mut dyn FnMut(&Sample)),
    ) -> (Result<WalkSummary, Diagnostic>, Option<WalkedSpeeds>) {
        let (Some((bench, controller)), Some(wished)) = (self.gait.one_phase(), &self.gait.wishes) else {
            return (Err(Diagnostic::error("there is nothing to choose")), None);
        };
        let names = bench.gait.parameters.iter().map(|parameter| parameter.name.clone()).collect();
        let mut choosing = Choosing::new(
            controller.clone(),
            (self.model, &self.chooser),
            (names, self.gait.values()),
            &wished.speeds,
        );
        let ending = self.gait.ending(choosing.present());
        let ending = ending.as_ref().map(|ending| ending as &LandingGuard<'_>);
        let summary = walking.run_until(Borrowed(&mut choosing), ending, run, watch);
        let speeds = WalkedSpeeds::of(format!("{}/s", bench.gait.phase.unit), choosing.steps());
        (summary, Some(speeds))
    }
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
            largest_surprise: surprises.fold(0.0, f64::max),
            steps,
        }
    }
}

impl fmt::Display for WalkedSpeeds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { unit, wished, met, largest_surprise, steps } = self;
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
        writeln!(
            f,
            "{met} of {wished} wished speeds were met; largest difference from a prediction {largest_surprise:.1e} {unit}\n"
        )
    }
}
