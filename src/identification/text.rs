//! The answer for people.
use crate::table::table;
use bipedc_analysis::identify::elastic::{DriveSummary, MotorErrors};
use bipedc_analysis::identify::{Identification, Models, Value};
use std::fmt::Write as _;

/// Most parameters' worth of letters of a name.
const NAME: usize = 60;

/// Words first, then tables.
pub fn text(answer: &Identification) -> String {
    let mut out = String::new();
    for warning in &answer.warnings {
        let _ = writeln!(out, "warning: {warning}");
    }
    for assumption in &answer.assumptions {
        let _ = writeln!(out, "assumed: {assumption}");
    }
    let seen = answer.parameters.len();
    let well = answer.parameters.iter().filter(|p| p.well_identified).count();
    let _ = writeln!(
        out,
        "{seen} of {} parameters seen in {} rows of {} logs ({} different motions); {well} with a standard error below 15 %; condition number {:.1}\n",
        seen + answer.unseen.len(),
        answer.rows,
        answer.logs.len(),
        answer.different_motions,
        answer.condition_number
    );
    for channel in answer.channels.iter().filter(|channel| channel.resting > 0) {
        let part = 100.0 * channel.resting as f64 / (channel.resting + channel.rows) as f64;
        let _ = writeln!(
            out,
            "`{}` rests, turns back or lies at a stop in or next to {part:.0} % of its samples, where dry friction or the stop makes an effort a bound: left out",
            channel.name
        );
    }
    if answer.channels.iter().any(|channel| channel.resting > 0) {
        out.push('\n');
    }
    out.push_str(&parameters(answer));
    if !answer.unseen.is_empty() {
        let _ = writeln!(out, "\nnot told by these data: {}", answer.unseen.join("; "));
    }
    for pair in &answer.pairs {
        let [a, b] = pair.parameters.each_ref().map(|name| short(name));
        let _ = writeln!(out, "hardly told apart (correlation {:+.3}): {a}  and  {b}", pair.correlation);
    }
    let essential = &answer.essential;
    let _ = writeln!(
        out,
        "\n{} essential parameters (marked *): {:.2} % of what was measured is missed on held-out stretches, {:.2} % with all\n",
        essential.parameters.len(),
        100.0 * essential.held_out,
        100.0 * essential.held_out_of_all
    );
    out + &format!("{}\n{}{}", links(answer), channels(answer), validation(answer))
}

/// Tables of drives.
pub fn drives(drives: &DriveSummary) -> String {
    let mut rows = Vec::new();
    for joint in &drives.joints {
        for p in &joint.parameters {
            rows.push(vec![
                joint.joint.clone(),
                p.name.to_owned(),
                scientific(p.value, p.standard_error),
                p.relative_error_percent.map_or_else(|| "-".to_owned(), |percent| format!("{percent:.2} %")),
                format!("{:.4e}", p.nominal),
                p.unit.to_owned(),
            ]);
        }
    }
    let head = ["drive", "parameter", "estimate ± std. error", "relative", "described", "unit"];
    let mut out = table(&head, rows, 2);
    let of = |errors: &MotorErrors| {
        [errors.measured, errors.described, errors.estimated].map(|x| format!("{x:.3e}"))
    };
    let mut rows = Vec::new();
    for joint in &drives.joints {
        for (which, errors) in [("taught", &joint.motor), ("validation", &joint.validation)] {
            let Some(errors) = errors else { continue };
            let mut row = vec![joint.joint.clone(), which.to_owned()];
            row.extend(of(errors));
            row.push(format!("{:.2} %", 100.0 * errors.estimated / errors.measured));
            rows.push(row);
        }
    }
    let head = ["motor torque, rms N m", "log", "measured", "described", "estimated", "missed"];
    out.push('\n');
    out.push_str(&table(&head, rows, 2));
    out
}

/// A value of any size with its error, both to the error's second digit.
fn scientific(value: f64, error: f64) -> String {
    if value.abs() >= 0.01 && value.abs() < 1e6 {
        return number(&Value { value, standard_error: error });
    }
    let power = value.abs().max(error.abs()).max(f64::MIN_POSITIVE).log10().floor();
    let unit = 10f64.powf(power);
    let digits =
        if error > 0.0 { (1.0 - (error / unit).log10().floor()).clamp(1.0, 9.0) } else { 6.0 } as usize;
    format!("({:.digits$} ± {:.digits$})e{power:.0}", value / unit, error / unit)
}

/// A value with its error, both to the error's second digit.
fn number(value: &Value) -> String {
    let digits = if value.standard_error > 0.0 { 1.0 - value.standard_error.log10().floor() } else { 6.0 };
    let digits = digits.clamp(1.0, 9.0) as usize;
    format!("{:.digits$} ± {:.digits$}", value.value, value.standard_error)
}

fn short(name: &str) -> String {
    if name.chars().count() <= NAME {
        return name.to_owned();
    }
    name.chars().take(NAME - 1).chain(['…']).collect()
}

fn parameters(answer: &Identification) -> String {
    let rows = answer.parameters.iter().map(|p| {
        vec![
            if p.essential { "*".to_owned() } else { String::new() },
            short(&p.name),
            number(&Value { value: p.value, standard_error: p.standard_error }),
            p.relative_error_percent.map_or_else(|| "-".to_owned(), |percent| format!("{percent:.1} %")),
            format!("{:.5}", p.nominal),
            p.unit.to_owned(),
        ]
    });
    let head = ["", "parameter", "estimate ± std. error", "relative", "described", "unit"];
    table(&head, rows.collect(), 2)
}

fn links(answer: &Identification) -> String {
    let physical = &answer.physical;
    let with = number;
    let rows = physical.links.iter().map(|link| {
        let mut row = vec![link.name.clone(), with(&link.mass), format!("{:.4}", link.nominal_mass)];
        row.extend(link.center.iter().map(with));
        row.extend([0, 3, 5].map(|k: usize| with(&link.inertia[k])));
        row.push(if link.check.consistent { "yes" } else { "NO" }.to_owned());
        row
    });
    let head =
        ["link", "mass, kg", "described", "center x, m", "y", "z", "Ixx, kg m²", "Iyy", "Izz", "possible"];
    let how = if physical.chosen { "chosen by folds" } else { "given" };
    let certificate = &physical.certificate;
    let mut out = format!(
        "physically possible parameters: weight of the description {} ({how}); duality gap {:.1e}, dual residual {:.1e}\n\n",
        crate::amendment::comments::rounded(physical.weight),
        certificate.gap,
        certificate.residual
    );
    out.push_str(&table(&head, rows.collect(), 1));
    if !physical.extras.is_empty() {
        let rows = physical.extras.iter().map(|e| vec![e.name.clone(), with(&e.value), e.unit.to_owned()]);
        out.push('\n');
        out.push_str(&table(&["joint", "value", "unit"], rows.collect(), 1));
    }
    out
}

fn channels(answer: &Identification) -> String {
    let rows = answer.channels.iter().map(|c| {
        let numbers = [c.measured, c.description, c.least_squares, c.held_out, c.physical];
        let mut row = vec![c.name.clone()];
        row.extend(numbers.map(|x| format!("{x:.4}")));
        row.extend([c.rows.to_string(), c.unit.to_owned()]);
        row
    });
    let head =
        ["rms error", "measured", "described", "least squares", "held out", "possible", "rows", "unit"];
    table(&head, rows.collect(), 1)
}

fn validation(answer: &Identification) -> String {
    let Some(validation) = &answer.validation else { return String::new() };
    let numbers = |m: &Models| [m.description, m.least_squares, m.essential, m.physical];
    let mut rows: Vec<Vec<String>> = Vec::new();
    for channel in &validation.channels {
        let mut row = vec![channel.name.clone(), format!("{:.4}", channel.measured)];
        row.extend(numbers(&channel.rms).map(|x| format!("{x:.4}")));
        row.push(channel.unit.to_owned());
        rows.push(row);
    }
    let mut row = vec!["|error| / |measured|".to_owned(), String::new()];
    row.extend(numbers(&validation.total).map(|x| format!("{:.2} %", 100.0 * x)));
    row.push(String::new());
    rows.push(row);
    let head = ["validation", "measured", "described", "least squares", "essential", "possible", "unit"];
    let mut out = String::from("\n");
    if validation.shares_motion {
        out.push_str("warning: the validation log shows a motion of the logs that taught: these errors are optimistic\n");
    }
    out.push_str(&table(&head, rows, 1));
    out
}
