//! Where a model fails, for people: sentences, then tables.
use crate::table;
use bipedc_analysis::diagnose::{AT_NOISE, Breakdown, BreakdownPart, Window};
use bipedc_analysis::number::{four_decimals, worst_first};

/// Sentences about every row, then its error by motion, phase and time.
pub fn text(rows: &[Breakdown]) -> String {
    let mut rows: Vec<&Breakdown> = rows.iter().collect();
    worst_first(&mut rows, |row| row.unit.clone(), |row| row.rms);
    let mut out = String::from("\n");
    let quiet = |row: &&&Breakdown| row.signature.is_empty() && row.told() <= AT_NOISE * row.noise;
    for sentence in rows.iter().filter(|row| !quiet(row)).flat_map(|row| &row.words) {
        out += &format!("{sentence}\n");
    }
    // At rests and reversals all samples may tell more than those at which the joint moves.
    let (silent, moving): (Vec<&Breakdown>, Vec<&Breakdown>) =
        rows.iter().filter(quiet).partition(|row| row.rms <= AT_NOISE * row.noise);
    let names = |rows: &[&Breakdown]| rows.iter().map(|row| row.name.as_str()).collect::<Vec<_>>().join(", ");
    if !silent.is_empty() {
        out += &format!("nothing but noise is left in: {}\n", names(&silent));
    }
    if !moving.is_empty() {
        out += &format!(
            "nothing but noise is left while the joint moves, but more where it rests or turns back (filters and the smoothing of a friction's sign round what happens there), in: {}\n",
            names(&moving)
        );
    }
    let of_joints: [fn(&Breakdown) -> &[BreakdownPart]; 3] = [|b| &b.motion, |b| &b.direction, |b| &b.phases];
    for parts in of_joints {
        out += &table(&rows, parts);
    }
    out + &windows(&rows)
}

/// One column per part; nothing if no row has any.
fn table(rows: &[&Breakdown], parts: impl Fn(&Breakdown) -> &[BreakdownPart]) -> String {
    let Some(first) = rows.iter().find(|row| !parts(row).is_empty()) else { return String::new() };
    let names = || parts(first).iter().map(|part| part.name.as_str());
    let head: Vec<&str> = ["rms"].into_iter().chain(names()).chain(["noise", "unit"]).collect();
    let line = |row: &&Breakdown| {
        let value = |name: &str| parts(row).iter().find(|part| part.name == name);
        let cells = names().map(|name| match value(name) {
            Some(part) if part.samples > 0 => four_decimals(part.rms),
            _ => "-".to_owned(),
        });
        let ends = [four_decimals(row.noise), row.unit.clone()];
        [row.name.clone()].into_iter().chain(cells).chain(ends).collect()
    };
    let lines = rows.iter().filter(|row| !parts(row).is_empty()).map(line).collect();
    format!("\n{}", table::table(&head, lines, 1))
}

fn windows(rows: &[&Breakdown]) -> String {
    let Some(first) = rows.first() else { return String::new() };
    let span = |window: &Window| format!("{:.1}\u{2013}{:.1}", window.from, window.to);
    let spans: Vec<String> = first.windows.iter().map(span).collect();
    let head: Vec<&str> =
        ["rms from\u{2013}to"].into_iter().chain(spans.iter().map(String::as_str)).collect();
    let line = |row: &&Breakdown| {
        [row.name.clone()].into_iter().chain(row.windows.iter().map(|w| four_decimals(w.rms))).collect()
    };
    format!("\n{}", table::table(&head, rows.iter().map(line).collect(), 1))
}
