//! Survival for people.
use super::{Disturbance, Robust, Survival, Tried};
use crate::table::table;
use std::collections::BTreeSet;
use std::fmt;

fn percent(survival: &Survival) -> String {
    let [low, high] = survival.interval.map(|x| 100.0 * x);
    format!("{:.1} % ({low:.1} to {high:.1})", 100.0 * survival.rate)
}

/// As far as it disturbs, with its unit.
fn size(Disturbance { kind, size }: &Disturbance) -> String {
    if kind.unit() == "1" { size.to_string() } else { format!("{size} {}", kind.unit()) }
}

/// A row for each reason for which walks ended: how many did with fixed parameters, and with chosen ones.
fn reasons(tried: &Tried) -> Vec<Vec<String>> {
    let ways = [&tried.fixed, &tried.chosen];
    let all: BTreeSet<&String> = ways.iter().flat_map(|way| way.failures.keys()).collect();
    let row = |why: &String| {
        let [fixed, chosen] = ways.map(|way| way.failures.get(why).copied().unwrap_or(0).to_string());
        vec![tried.disturbance.kind.name().to_owned(), size(&tried.disturbance), fixed, chosen, why.clone()]
    };
    all.into_iter().map(row).collect()
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
                size(&tried.disturbance),
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
        let rows: Vec<_> = tried.iter().flat_map(reasons).collect();
        if !rows.is_empty() {
            writeln!(f, "\nwhy the others end: walks with fixed parameters, with chosen ones")?;
            f.write_str(&table(&["disturbance", "up to", "fixed", "chosen", "why"], rows, 5))?;
        }
        if !complete {
            writeln!(f, "\ninterrupted: trials are missing")?;
        }
        Ok(())
    }
}
