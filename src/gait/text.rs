//! A step for people.
use super::Stepped;
use crate::table::table;
use bipedc_analysis::gait::Margins;
use bipedc_compiler::description::gait::GaitParameter;
use std::fmt;

/// Six decimals, or that there is no such number.
pub(super) fn figure(x: Option<f64>) -> String {
    // What rounds to zero has no sign.
    let digits = |x: f64| format!("{:.6}", if x.abs() < 5e-7 { 0.0 } else { x });
    x.map_or_else(|| "—".to_owned(), digits)
}

pub(super) fn row(name: &str, value: Option<f64>, unit: &str) -> Vec<String> {
    vec![name.to_owned(), figure(value), unit.to_owned()]
}

impl fmt::Display for Stepped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&question(&self.parameters, &self.values, ["next step", "this step"]))?;
        let (step, rate) = (&self.step, format!("{}/s", self.unit));
        let energy = "(kg m²/s)²";
        let rows = vec![
            row("speed at mid-stance, this step", Some(self.speed), &rate),
            row("speed at mid-stance, next step", step.next_speed, &rate),
            row("… after many steps", step.limit_speed, &rate),
            row("dead centre φ_m", step.phi_m, &self.unit),
            row("phase at the beginning φ₊", step.phi_start, &self.unit),
            row("phase at the end φ₋", step.phi_end, &self.unit),
            row("δ of the impact", step.delta, "1"),
            row("η of the impact", step.eta, "1"),
            row("P₋", step.p_minus, energy),
            row("largest P", step.p_max, energy),
            row("energy of this step", step.energy, energy),
            row("energy of the next step", step.next_energy, energy),
            row("least K of the next step at mid-stance", step.k_min, energy),
            row("largest K of the next step at mid-stance", step.k_max, energy),
        ];
        writeln!(f, "\n{}", columns(&["", "value", "unit"], rows))?;
        f.write_str(&columns(&["margin", "value", "unit"], margins(&step.margins)))?;
        match &step.reason {
            None => writeln!(f, "\nthe next step passes its dead centre"),
            Some(reason) => writeln!(f, "\nnot possible: {reason}"),
        }
    }
}

/// The parameters that a step is asked for; of the step before a column of its own, if they are others there.
pub(super) fn question(
    parameters: &[GaitParameter],
    [to, from]: &[Vec<f64>; 2],
    [now, before]: [&str; 2],
) -> String {
    let mut head = vec!["parameter", now, "unit", "meaning"];
    if from != to {
        head.insert(1, before);
    }
    let rows = parameters.iter().zip(to).zip(from).map(|((parameter, to_value), from_value)| {
        let GaitParameter { name, unit, meaning, .. } = parameter;
        let mut row = vec![name.clone(), format!("{to_value:.6}"), unit.clone(), meaning.clone()];
        if from != to {
            row.insert(1, format!("{from_value:.6}"));
        }
        row
    });
    table(&head, rows.collect(), head.len())
}

/// Names and units to the left, numbers to the right.
pub(super) fn columns(head: &[&str], rows: Vec<Vec<String>>) -> String {
    let width =
        rows.iter().filter_map(|row| row.get(1)).map(|value| value.chars().count()).max().unwrap_or(0);
    let aligned = rows.into_iter().map(|mut row| {
        if let Some(value) = row.get_mut(1) {
            *value = format!("{value:>width$}");
        }
        row
    });
    table(head, aligned.collect(), head.len())
}

pub(super) fn margins(margins: &Margins) -> Vec<Vec<String>> {
    vec![
        row("friction", margins.friction, "1"),
        row("pull", margins.pull, "N"),
        row("zmp", margins.zmp, "m"),
        row("clearance", margins.clearance, "m"),
        row("torque", margins.torque, "N m"),
        row("joint stop", margins.joint, "rad or m"),
        row("velocity", margins.velocity, "rad/s or m/s"),
        row("impact: friction", margins.impact_friction, "1"),
        row("impact: pull", margins.impact_pull, "N s"),
        row("impact: lift-off", margins.lift_off, "m/s"),
    ]
}
