//! Cycles for people.
use super::{CycleOf, Cycles, Whole, numbers};
use crate::table::table;
use std::fmt;

/// What each number means.
const MEANINGS: [&str; 13] = [
    "at mid-stance, in every step",
    "what is left of a small deviation after a step",
    "of a step",
    "distance of the feet",
    "mean, forward",
    "of all joints in a step, driving and braking",
    "driving less braking: what the impact takes",
    "work over weight and distance",
    "E of every step",
    "at mid-stance: less, and a step is not made or breaks what is assumed",
    "at mid-stance: more does",
    "slowest mid-stance from which steps come back",
    "fastest one",
];

impl fmt::Display for Cycles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cycles[..] {
            [one] if self.over.is_none() => f.write_str(&self.one(one))?,
            _ => f.write_str(&self.many())?,
        }
        if !self.complete {
            writeln!(f, "\ninterrupted: cycles are missing")?;
        }
        Ok(())
    }
}

impl Cycles {
    fn one(&self, of: &CycleOf) -> String {
        let parameters = of.parameters.iter().map(|(name, value)| format!("{name} = {value}"));
        let mut head = parameters.collect::<Vec<_>>().join(", ");
        if !head.is_empty() {
            head.push_str("\n\n");
        }
        let Some(cycle) = &of.cycle else {
            return format!("{head}no cycle: {}\n", of.reason.as_deref().unwrap_or(""));
        };
        let rows = numbers(&self.speed_unit, &self.energy_unit).into_iter().zip(MEANINGS).map(
            |((name, unit, number), meaning)| {
                let name = name.replace('_', " ");
                let value = number(cycle).map_or_else(|| "—".to_owned(), |x| format!("{x:.6}"));
                vec![name, format!("{value:>12}"), unit, meaning.to_owned()]
            },
        );
        let numbers = table(&["", "value", "unit", "meaning"], rows.collect(), 4);
        format!("{head}{numbers}{}", of.whole.as_ref().map_or_else(String::new, whole))
    }

    fn many(&self) -> String {
        let over = self.over.clone().unwrap_or_default();
        let all = numbers(&self.speed_unit, &self.energy_unit);
        // What is left out stands in CSV and JSON.
        let shown = [0, 1, 2, 4, 7].map(|k| &all[k]);
        let heads: Vec<String> =
            std::iter::once(format!("{over} ({})", self.over_unit.as_deref().unwrap_or("1")))
                .chain(shown.iter().map(|(name, unit, _)| format!("{} ({unit})", name.replace('_', " "))))
                .chain([String::new()])
                .collect();
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        let rows = self.cycles.iter().map(|of| {
            let value = of.parameters.get(&over).map_or_else(String::new, |x| format!("{x:.6}"));
            let each = shown.iter().map(|(.., number)| {
                of.cycle.as_ref().and_then(number).map_or_else(|| "—".to_owned(), |x| format!("{x:.6}"))
            });
            std::iter::once(value).chain(each).chain([of.reason.clone().unwrap_or_default()]).collect()
        });
        table(&heads, rows.collect(), 0)
    }
}

/// What steps of the whole robot make of deviations.
fn whole(found: &Whole) -> String {
    if let Some(reason) = &found.reason {
        return format!("\nmultipliers of the whole robot are not known: {reason}\n");
    }
    let one = |[real, imaginary]: &[f64; 2]| match imaginary.abs() {
        small if small < 5e-5 => format!("{:.4}", if real.abs() < 5e-5 { 0.0 } else { *real }),
        _ => format!("{real:.4} {} {:.4} i", if *imaginary < 0.0 { '−' } else { '+' }, imaginary.abs()),
    };
    let all: Vec<String> = found.multipliers.iter().map(one).collect();
    let cycle = found.repeats.map_or_else(String::new, |cycle| {
        format!(
            "its own cycle, by Newton's method, begins {:.1e} beside that of the zero dynamics, and a step comes back to it within {:.1e} (rad, m, rad/s, m/s)\n",
            cycle.off, cycle.miss
        )
    });
    format!("\nmultipliers of the whole robot under its controller (1): {}\n{cycle}", all.join(", "))
}
