//! Rows of a report from an experiment.
use crate::diagnose::Diagnosis;
use crate::diagnose::breakdown::{breakdown, direction_states, motion_states};
use crate::experiments::Experiment;
use crate::experiments::jumps::Jumps;
use crate::experiments::moving::moving;
use crate::experiments::noise::noise_of;
use crate::experiments::plotted::{Row, Series};
use crate::experiments::signals::velocity_of;
use crate::number::worst_first;
use bipedc_effects::effect::Effect;

/// Signals that residuals are plotted against, in this order.
const SIGNALS: [&str; 4] = ["velocity", "position", "acceleration", "load"];

/// Rows of the experiment that judged, with the effects and corrections of its diagnosis; without one, of the model
/// alone. Errors are those of the diagnosis where it has them. The largest error comes first, those of one unit together.
pub fn rows_of(experiment: &dyn Experiment, diagnosis: Option<&Diagnosis>) -> Vec<Row> {
    let found = diagnosis.iter().flat_map(|d| d.effects.iter().chain(&d.inertial_corrections));
    let effects: Vec<Effect> = found.map(|found| found.effect.clone()).collect();
    let mut responses = if effects.is_empty() { Vec::new() } else { experiment.response(&effects) };
    let indices = 0..experiment.rows().len();
    let jumps = Jumps::of(experiment, &[]);
    let rows = indices.map(|row| {
        let response =
            responses.iter_mut().find(|(r, _)| *r == row).map(|(_, values)| std::mem::take(values));
        let samples = experiment.residual(row).len();
        let response = (!effects.is_empty()).then(|| response.unwrap_or_else(|| vec![0.0; samples]));
        let built = row_of(experiment, row, response, &jumps);
        let told = |values: &mut dyn Iterator<Item = f64>| {
            moving(experiment, row, &values.collect::<Vec<f64>>(), &|_, _| true).map(|moving| moving.rms())
        };
        let before = told(&mut built.series.residual());
        let after = built.series.amended.as_ref().and_then(|_| told(&mut built.series.residual_after()));
        let away = jumps.away(experiment, row, experiment.residual(row), &|_, _| true);
        match diagnosis.and_then(|d| d.rows.get(&built.name)) {
            Some(fall) => {
                let after = built.rms_after.map(|_| fall.after);
                let built = Row { noise: fall.noise, ..built };
                let built = built.judged(fall.before, after);
                let built = built.without_sticking([fall.before_moving, fall.after_moving]);
                built.where_nothing_jumps([away, after.and(fall.away_from_jumps)])
            }
            None => built.without_sticking([before, after]).where_nothing_jumps([away, None]),
        }
    });
    let mut rows: Vec<Row> = rows.collect();
    worst_first(&mut rows, |row| row.unit.clone(), |row| row.rms_before);
    rows
}

fn row_of(experiment: &dyn Experiment, index: usize, response: Option<Vec<f64>>, jumps: &Jumps) -> Row {
    let row = &experiment.rows()[index];
    let residual = experiment.residual(index);
    let measured = experiment.measured(index).unwrap_or_else(|| residual.to_vec());
    let nominal: Vec<f64> = measured.iter().zip(residual).map(|(m, r)| m - r).collect();
    let amended = response.map(|response| nominal.iter().zip(&response).map(|(n, r)| n + r).collect());
    let mut series =
        Series { time: experiment.time().to_vec(), measured, nominal, amended, ..Series::default() };
    let mut known = experiment.signals(index);
    for name in SIGNALS {
        if let Some(at) = known.iter().position(|(known, _)| known == name) {
            series = series.with(name, unit_of(name, row.unit), known.swap_remove(at).1);
        }
    }
    let built = Row::new(&row.name, row.channel, row.unit, noise_of(experiment, index, residual), series);
    let built = match &row.joint {
        Some(joint) => built.at_joint(joint),
        None => built,
    };
    with_parts(experiment, index, built, jumps)
}

/// Of a signal of a joint whose effort has this unit.
fn unit_of(signal: &str, effort: &'static str) -> &'static str {
    let slides = effort == "N";
    match signal {
        "velocity" if slides => "m/s",
        "velocity" => "rad/s",
        "position" if slides => "m",
        "position" => "rad",
        "acceleration" if slides => "m/s²",
        "acceleration" => "rad/s²",
        _ if slides => "N",
        _ => "N m",
    }
}

/// What is structured in the error, and the error by what the robot was doing.
fn with_parts(experiment: &dyn Experiment, index: usize, mut row: Row, jumps: &Jumps) -> Row {
    row.note = sentences(&row.name, &breakdown(experiment, index, jumps).words);
    let mut states = experiment.phases();
    if row.joint.is_some()
        && let Some(velocity) = velocity_of(experiment, index)
    {
        states.extend(direction_states(&velocity));
        states.extend(motion_states(&velocity, experiment.time()));
    }
    let shown = states.into_iter().filter(|(_, chosen)| chosen.contains(&true));
    shown.fold(row, |row, (name, chosen)| row.with_part(name, |i| chosen.get(i).copied().unwrap_or(false)))
}

/// Said of one row: its name first, then one sentence after the other.
fn sentences(name: &str, words: &[String]) -> String {
    let own = format!("{name}: ");
    let mut text = String::new();
    for (k, sentence) in words.iter().enumerate() {
        let bare = sentence.strip_prefix(&own).unwrap_or(sentence);
        let mut letters = bare.chars();
        match (k, letters.next()) {
            (0, _) => text += &format!("{own}{bare}"),
            (_, Some(first)) => text += &format!(". {}{}", first.to_uppercase(), letters.as_str()),
            _ => {}
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::sentences;

    #[test]
    fn sentences_begin_large_and_say_the_name_once() {
        let words = ["knee: the error is small", "knee: it follows velocity", "0.1 N m (moving)"];
        let words = words.map(str::to_owned);
        assert_eq!(
            sentences("knee", &words),
            "knee: the error is small. It follows velocity. 0.1 N m (moving)"
        );
        assert_eq!(sentences("knee", &[]), "");
    }
}
