//! Energies of the zero dynamics along a plan of several phases, as the thesis draws them (figure 7.10).
use super::Plans;
use crate::gait::chain::PhaseTrace;
use crate::gait::{Chain, Parametrised, PhasedBench};
use bipedc_analysis::report::{CurveFigure, CurveKind, PlottedCurve, Table};
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

impl PhasedBench {
    /// K, P and E = K + P over time from the mid-stance where the first plan begins to that where it ends, phase after phase (6.32).
    ///
    /// # Errors
    /// The plans have no way from a present step, or there are several.
    pub fn energies(&self, specs: &[PhaseSpec], plans: &Plans) -> Result<CurveFigure, Diagnostics> {
        let refused = |message: &str| {
            let help =
                "ask for one plan that is reached, without --alike: then steps follow each other as they are";
            Err(Diagnostics::from(Diagnostic::error(message).help(help)))
        };
        let [plan] = &plans.plans[..] else { return refused("energies are drawn of one plan") };
        if plan.plan.is_empty() || plans.alike {
            return refused("there are no steps whose energies could be drawn");
        }
        let values = |named: &std::collections::BTreeMap<String, f64>| {
            self.values(&named.iter().map(|(name, value)| (name.clone(), *value)).collect::<Vec<_>>())
        };
        let chain = Chain::new(self, specs, self.controller(None, &[])?)?;
        let mut now = chain.mid_stance(&values(&plans.from)?, plan.from_speed)?;
        let (mut traces, mut begun) = (Vec::new(), 0.0);
        for step in &plan.plan {
            let (hop, found) = chain.traced_hop(&now, &values(&step.parameters)?);
            traces.extend(found.into_iter().map(|trace| trace.later(begun)));
            begun += hop.duration;
            now = hop.next?;
        }
        Ok(self.energy_figure(&traces))
    }

    fn energy_figure(&self, traces: &[PhaseTrace]) -> CurveFigure {
        let curve = |kind, words: &str, of: fn([f64; 2]) -> f64| {
            let mut points = Vec::new();
            for trace in traces {
                points.extend(trace.points.iter().map(|&(time, energies)| [time, of(energies)]));
                points.extend(trace.points.last().map(|(time, _)| [*time, f64::NAN]));
            }
            PlottedCurve { kind, words: words.to_owned(), points }
        };
        CurveFigure {
            title: format!("Gait {}: energies of the zero dynamics", self.gait_name()),
            robot: self.robot_name().to_owned(),
            x: "time (s)".to_owned(),
            y: format!("energy of the zero dynamics (({})²)", self.speed_unit()),
            counted: [false, false],
            from_zero: false,
            curves: vec![
                curve(CurveKind::Other, "K, kinetic", |[kinetic, _]| kinetic),
                curve(CurveKind::Third, "P, potential", |[_, potential]| potential),
                curve(CurveKind::Limit, "E, both", |[kinetic, potential]| kinetic + potential),
            ],
            facts: Vec::new(),
            table: Table { caption: String::new(), head: Vec::new(), rows: Vec::new() },
        }
    }
}
