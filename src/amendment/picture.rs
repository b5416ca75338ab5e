//! The falling error as bars on a terminal.
use super::comments::quantity;
use super::history::Stair;
use std::fmt::Write;

/// Cells of the longest bar.
const WIDTH: usize = 40;
const LABEL: usize = 44;

/// Stairs of one channel and unit, in the order of the first of each.
pub fn by_channel(stairs: &[Stair]) -> Vec<Vec<&Stair>> {
    let mut groups: Vec<Vec<&Stair>> = Vec::new();
    for stair in stairs {
        let same = |group: &&mut Vec<&Stair>| {
            group.first().is_some_and(|first| {
                (&first.channel, &first.unit, first.held_out) == (&stair.channel, &stair.unit, stair.held_out)
            })
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(stair),
            None => groups.push(vec![stair]),
        }
    }
    groups
}

/// What the numbers of a group are: `held-out effort, N m`.
pub fn heading(stair: &Stair) -> String {
    let data = if stair.held_out { "held-out" } else { "on the training data:" };
    let unit = match stair.unit.as_str() {
        "1" => String::new(),
        "mixed" => ", mixed units".to_owned(),
        unit => format!(", {unit}"),
    };
    format!("{data} {}{unit}", stair.channel)
}

/// One line per stair: what is left as `█`, what the effect took away as `░`. Empty without stairs.
pub fn staircase(stairs: &[Stair]) -> String {
    let mut text = String::new();
    for group in by_channel(stairs) {
        let largest = group.iter().flat_map(|stair| [stair.before, stair.after]).fold(0.0_f64, f64::max);
        let cells = |value: f64| {
            if largest > 0.0 { ((value / largest) * WIDTH as f64).round().max(0.0) as usize } else { 0 }
        };
        let first = group[0];
        let _ = writeln!(text, "{} (root mean square)", heading(first));
        line(&mut text, "before", first.before, cells(first.before), 0, &first.unit);
        for stair in &group {
            let (left, taken) = (cells(stair.after), cells(stair.before).saturating_sub(cells(stair.after)));
            line(
                &mut text,
                &format!("{} {}", stair.step, stair.label),
                stair.after,
                left,
                taken,
                &stair.unit,
            );
        }
        if let Some(noise) = group.iter().map(|stair| stair.noise).rfind(|noise| *noise > 0.0) {
            let _ =
                writeln!(text, "{:LABEL$}  noise of the measurement {}", "", quantity(noise, &first.unit));
        }
    }
    text
}

fn line(text: &mut String, label: &str, value: f64, left: usize, taken: usize, unit: &str) {
    let label: String = if label.chars().count() > LABEL {
        label.chars().take(LABEL - 1).chain(['…']).collect()
    } else {
        label.to_owned()
    };
    let bar = "█".repeat(left) + &"░".repeat(taken);
    let _ = writeln!(text, "{label:LABEL$}  {bar} {}", quantity(value, unit));
}
