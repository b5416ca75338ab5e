//! Survival for people.
use super::{Robust, Survival};
use crate::table::table;
use std::fmt;

fn percent(survival: &Survival) -> String {
    let [low, high] = survival.interval.map(|x| 100.0 * x);
    format!("{:.1} % ({low:.1} to {high:.1})", 100.0 * survival.rate)
}

fn failures(survival: &Survival) -> String {
    let each = survival.failures.iter().map(|(why, count)| format!("{count}× {why}"));
    let all: Vec<String> = each.collect();
    if all.is_empty() { "—".to_owned() } else { all.join("; ") }
}

impl fmt::Display for Robust {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robot, scenario, steps, seed, complete, tried } = self;
        writeln!(
            f,
            "{robot}, {scenario}: walks that take all {steps} steps with every assumption kept; seed {seed}"
        )?;
        writeln!(f, "95 % intervals of Wilson\n")?;
        let rows = tried.iter().map(|tried| {
            let kind = tried.disturbance.kind;
            vec![
                kind.name().to_owned(),
                format!("{} {}", tried.disturbance.size, kind.unit()),
                tried.fixed.trials.to_string(),
                percent(&tried.fixed),
                percent(&tried.chosen),
                tried.only_fixed.to_string(),
                tried.only_chosen.to_string(),
            ]
        });
        let heads = [
            "disturbance",
            "up to",
            "trials",
            "fixed parameters",
            "chosen anew",
            "only fixed",
            "only chosen",
        ];
        f.write_str(&table(&heads, rows.collect(), 0))?;
        let rows = tried.iter().map(|tried| {
            let size = format!("{} {}", tried.disturbance.size, tried.disturbance.kind.unit());
            vec![
                tried.disturbance.kind.name().to_owned(),
                size,
                failures(&tried.fixed),
                failures(&tried.chosen),
            ]
        });
        writeln!(f, "\nwhy the others end")?;
        f.write_str(&table(&["disturbance", "up to", "fixed parameters", "chosen anew"], rows.collect(), 0))?;
        if !complete {
            writeln!(f, "\ninterrupted: trials are missing")?;
        }
        Ok(())
    }
}
