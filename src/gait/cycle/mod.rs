//! Cycles of a gait: walking that repeats itself (thesis 6.17), for given parameters or over one of them.
mod phased;
mod text;

use super::over::Over;
use super::{Assignment, GaitBench, Parametrised};
use crate::progress::Run;
use bipedc_analysis::gait::{Cycle, Watch};
use bipedc_analysis::report::{CurveFigure, CurveKind, Fact, PlottedCurve, Table};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What cycles are asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CycleOptions {
    /// Parameters, where they are not the gait's own.
    pub set: Vec<Assignment>,
    /// A cycle for each value of a parameter.
    pub over: Option<Over>,
}

/// Cycles. As text and as JSON they are what `bipedc gait cycle` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cycles {
    /// Name of the gait.
    pub gait: String,
    /// Of the robot.
    pub robot: String,
    /// Unit of `speed`.
    pub speed_unit: String,
    /// Unit of energies.
    pub energy_unit: String,
    /// The parameter that differs, if there is one.
    pub over: Option<String>,
    /// Its unit.
    pub over_unit: Option<String>,
    /// No cycle is missing.
    pub complete: bool,
    /// One for each value.
    pub cycles: Vec<CycleOf>,
    /// What lies beyond its bounds.
    #[serde(skip)]
    pub messages: Vec<Diagnostic>,
}

/// The cycle of some parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CycleOf {
    /// Of all parameters.
    pub parameters: BTreeMap<String, f64>,
    /// What it is; none: there is none.
    pub cycle: Option<Cycle>,
    /// Why there is none.
    pub reason: Option<String>,
    /// Of the whole robot under its controller; none where that was not asked for.
    pub whole: Option<Whole>,
}

/// Steps of the whole robot around a cycle, on its constraints or off them.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Whole {
    /// Eigenvalues of what a step makes of small deviations of the state in which it begins, real and imaginary parts, the largest first; that of a
    /// deviation along the motion, which is zero, is left out.
    pub multipliers: Vec<[f64; 2]>,
    /// By how much a step of the whole robot misses the state in which it began: largest of rad (m) and rad/s (m/s).
    pub miss: Option<f64>,
    /// The cycle of the whole robot; none where none was found near that of the zero dynamics.
    pub repeats: Option<WholeCycle>,
    /// Why there are no multipliers.
    pub reason: Option<String>,
}

/// A state of the whole robot from which a step comes back to it, by Newton's method on the full hybrid model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WholeCycle {
    /// Largest difference from the state in which the cycle of the zero dynamics begins: of rad (m) and rad/s (m/s).
    pub off: f64,
    /// By how much a step misses it, the same way.
    pub miss: f64,
    /// Steps of the method that brought it nearer.
    pub rounds: usize,
}

impl GaitBench {
    /// Walking that repeats itself.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers and ranges that are none.
    pub fn cycles(&self, options: &CycleOptions, run: &Run<'_>) -> Result<Cycles, Diagnostics> {
        let model = self.model()?;
        self.each_cycle(options, run, "(kg m²/s)²".to_owned(), |all, watch| {
            let found = model.cycles(all, watch);
            found.into_iter().map(|cycle| cycle.map_err(|why| why.to_string())).collect()
        })
    }
}

/// What cycles of all gaits have in common.
trait Cycling: Parametrised {
    /// Cycles of all values that were asked for, by `find`.
    fn each_cycle(
        &self,
        options: &CycleOptions,
        run: &Run<'_>,
        energy_unit: String,
        find: impl FnOnce(&[Vec<f64>], &Watch<'_>) -> Vec<Result<Cycle, String>>,
    ) -> Result<Cycles, Diagnostics> {
        let values = self.with(&self.defaults(), &options.set)?;
        let fixed: Vec<&str> = options.set.iter().map(|(name, _)| name.as_str()).collect();
        let over: Vec<Over> = options.over.iter().cloned().collect();
        let axis = self.axes(&over, &fixed)?.pop();
        let all: Vec<Vec<f64>> = match &axis {
            None => vec![values.clone()],
            Some((index, along)) => along.iter().map(|&x| replaced(&values, *index, x)).collect(),
        };
        let found = run.progress.counted("cycles", |advance| find(&all, &Watch { advance, stop: run.stop }));
        let of = |(parameters, cycle): (&Vec<f64>, &Result<Cycle, String>)| CycleOf {
            parameters: self.named(parameters),
            cycle: cycle.as_ref().ok().copied(),
            reason: cycle.as_ref().err().cloned(),
            whole: None,
        };
        let inside = axis
            .as_ref()
            .map_or(values.clone(), |(index, _)| replaced(&values, *index, self.parameter(*index).bounds[0]));
        Ok(Cycles {
            gait: self.gait_name().to_owned(),
            robot: self.robot_name().to_owned(),
            speed_unit: self.speed_unit(),
            energy_unit,
            over: axis.as_ref().map(|(index, _)| self.parameter(*index).name.clone()),
            over_unit: axis.as_ref().map(|(index, _)| self.parameter(*index).unit.clone()),
            complete: found.len() == all.len(),
            cycles: all.iter().zip(&found).map(of).collect(),
            messages: self.outside(&inside, ""),
        })
    }
}

impl<B: Parametrised> Cycling for B {}

fn replaced(values: &[f64], index: usize, value: f64) -> Vec<f64> {
    let mut values = values.to_vec();
    values[index] = value;
    values
}

/// Name, unit and value of a number.
pub(super) type Number = (&'static str, String, fn(&Cycle) -> Option<f64>);

/// The numbers of a cycle, as tables have them.
pub(super) fn numbers(speed_unit: &str, energy_unit: &str) -> [Number; 13] {
    let unit = str::to_owned;
    [
        ("speed", unit(speed_unit), |cycle| Some(cycle.speed)),
        ("multiplier", unit("1"), |cycle| Some(cycle.multiplier)),
        ("duration", unit("s"), |cycle| Some(cycle.duration)),
        ("step_length", unit("m"), |cycle| Some(cycle.step_length)),
        ("walking_speed", unit("m/s"), |cycle| Some(cycle.walking_speed)),
        ("work", unit("J"), |cycle| Some(cycle.work)),
        ("net_work", unit("J"), |cycle| Some(cycle.net_work)),
        ("cost_of_transport", unit("1"), |cycle| Some(cycle.cost_of_transport)),
        ("energy", unit(energy_unit), |cycle| Some(cycle.energy)),
        ("k_min", unit(energy_unit), |cycle| cycle.k_min),
        ("k_max", unit(energy_unit), |cycle| cycle.k_max),
        ("basin_low", unit(speed_unit), |cycle| cycle.basin[0]),
        ("basin_high", unit(speed_unit), |cycle| cycle.basin[1]),
    ]
}

impl Cycles {
    /// One row per cycle: all parameters, then its numbers, then the reason where there is none.
    pub fn csv(&self) -> String {
        let numbers = numbers(&self.speed_unit, &self.energy_unit);
        let names = self.cycles.first().map(|of| of.parameters.keys().cloned().collect::<Vec<_>>());
        let heads = names
            .unwrap_or_default()
            .into_iter()
            .chain(numbers.iter().map(|(name, ..)| format!("cycle/{name}")));
        let mut text = format!("{},reason\n", heads.collect::<Vec<_>>().join(","));
        for of in &self.cycles {
            for value in of.parameters.values() {
                // Writing to a string cannot fail.
                let _ = write!(text, "{value},");
            }
            for (.., number) in &numbers {
                let value = of.cycle.as_ref().and_then(number);
                let _ = write!(text, "{},", value.map_or_else(String::new, |x| x.to_string()));
            }
            let reason = of.reason.as_deref().unwrap_or("").replace('"', "\"\"");
            let _ = if reason.is_empty() { writeln!(text) } else { writeln!(text, "\"{reason}\"") };
        }
        text
    }

    /// Speed and cost over the parameter.
    pub fn figure(&self) -> CurveFigure {
        let over = self.over.clone().unwrap_or_default();
        let points = |number: fn(&Cycle) -> f64| {
            let of = |of: &CycleOf| {
                [of.parameters.get(&over).copied().unwrap_or(0.0), of.cycle.as_ref().map_or(f64::NAN, number)]
            };
            self.cycles.iter().map(of).collect::<Vec<_>>()
        };
        let curve = |kind, words: &str, number| PlottedCurve {
            kind,
            words: words.to_owned(),
            points: points(number),
        };
        let unit = self
            .over_unit
            .as_deref()
            .filter(|unit| *unit != "1")
            .map_or_else(String::new, |unit| format!(" ({unit})"));
        CurveFigure {
            title: format!("Gait {}: walking that repeats itself", self.gait),
            robot: self.robot.clone(),
            x: if over.is_empty() { "gait".to_owned() } else { format!("{over}{unit}") },
            y: "speeds and cost".to_owned(),
            counted: [false, false],
            from_zero: true,
            curves: vec![
                curve(CurveKind::Main, &format!("speed at mid-stance ({})", self.speed_unit), |cycle| {
                    cycle.speed
                }),
                curve(CurveKind::Other, "walking speed (m/s)", |cycle| cycle.walking_speed),
                curve(CurveKind::Third, "cost of transport", |cycle| cycle.cost_of_transport),
            ],
            facts: vec![Fact { name: "gait".to_owned(), value: self.gait.clone() }],
            table: self.table(),
        }
    }

    fn table(&self) -> Table {
        let names: Vec<String> =
            self.cycles.first().map_or_else(Vec::new, |of| of.parameters.keys().cloned().collect());
        let numbers = numbers(&self.speed_unit, &self.energy_unit);
        let heads = numbers.iter().map(|(name, unit, _)| format!("{} ({unit})", name.replace('_', " ")));
        let row = |of: &CycleOf| {
            let own = of.parameters.values().map(|x| format!("{x:.4}"));
            let each = numbers.iter().map(|(.., number)| {
                of.cycle.as_ref().and_then(number).map_or_else(|| "–".to_owned(), |x| format!("{x:.4}"))
            });
            own.chain(each).chain([of.reason.clone().unwrap_or_default()]).collect()
        };
        Table {
            caption: "Cycles".to_owned(),
            head: names.into_iter().chain(heads).chain([String::new()]).collect(),
            rows: self.cycles.iter().map(row).collect(),
        }
    }
}
