//! A step of several phases for people.
use super::ChainStep;
use crate::gait::text::{columns, figure, margins, question, row};
use crate::table::table;
use std::fmt;

impl fmt::Display for ChainStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.parameters.is_empty() {
            let heads = ["from mid-stance", "until there"];
            writeln!(f, "{}", question(&self.parameters, &self.values, heads))?;
        }
        let (rate, energy) = (format!("{}/s", self.unit), format!("({}/s)²", self.unit));
        let rows = vec![
            row("speed at mid-stance, this step", Some(self.speed), &rate),
            row("speed at mid-stance, next step", self.next_speed, &rate),
            row("dead centre φ_m", self.phi_m, &self.unit),
            row("δ of the step", self.delta, "1"),
            row("P₋ of the step", self.p_minus, &energy),
            row("P at the next dead centre", self.p_max, &energy),
            row("energy of this step", self.energy, &energy),
            row("energy of the next step", self.next_energy, &energy),
            row("duration", self.duration, "s"),
        ];
        writeln!(f, "{}", columns(&["", "value", "unit"], rows))?;
        let head = ["phase", "φ₊", "φ₋", "φ̇₊", "φ̇₋", "duration (s)", "ν", "P₋", "limits"];
        let phase = |of: &super::ChainedPhase| {
            let numbers =
                [of.phi_start, of.phi_end, of.speed_start, of.speed_end, of.duration, of.nu, of.p_minus];
            let limits = match of {
                _ if of.without_limits => "left out",
                _ if of.limited => "reached",
                _ => "—",
            };
            let mut row = vec![of.name.clone()];
            row.extend(numbers.iter().map(|&x| figure(Some(x))));
            row.push(limits.to_owned());
            row
        };
        f.write_str(&table(&head, self.phases.iter().map(phase).collect(), head.len()))?;
        write!(f, "\n{}", columns(&["margin", "value", "unit"], margins(&self.margins)))?;
        match &self.reason {
            None => writeln!(
                f,
                "\nthe next step passes its dead centre; the speed after many steps is what `bipedc gait cycle` says"
            ),
            Some(reason) => writeln!(f, "\nnot possible: {reason}"),
        }
    }
}
