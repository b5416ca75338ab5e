//! Scores for people.
use super::judge::{Scored, short};
use crate::generator::Group;
use comfy_table::{ContentArrangement, Table, presets};
use std::collections::BTreeMap;
use std::fmt::Write;

const HEADER: [&str; 9] = [
    "case",
    "hidden",
    "found",
    "right",
    "kind",
    "place",
    "worst parameter",
    "after / true model",
    "spurious",
];

fn cells(score: &Scored) -> [String; 9] {
    let yes = |is: bool| if is { "yes" } else { "no" }.to_owned();
    let or_dash = |value: Option<String>| value.unwrap_or_else(|| "–".to_owned());
    let mut found = match &score.failed {
        Some(error) => format!("failed: {error}"),
        None if score.found.is_empty() => "nothing".to_owned(),
        None => score.found.clone(),
    };
    if let Some(suspects) = &score.unexplained {
        let _ = write!(found, "; unexplained: {}", suspects.join(", "));
    }
    if score.corrections > 0 {
        let _ = write!(found, "; {} inertial corrections", score.corrections);
    }
    let right = if score.named_as_alternative { "as alternative".to_owned() } else { yes(score.right) };
    [
        score.name.clone(),
        if score.hidden.is_empty() { "nothing".to_owned() } else { score.hidden.clone() },
        found,
        right,
        yes(score.kinds),
        yes(score.places),
        or_dash(score.parameter_error.map(|e| format!("{:.1} %", 100.0 * e))),
        or_dash(score.ratio().map(|ratio| format!("{ratio:.3} ({})", score.metric))),
        score.spurious.to_string(),
    ]
}

/// A table and what it adds up to, for a terminal. Intervals of `others` count too.
pub fn table(scores: &[Scored], others: &[Scored]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Dynamic);
    if table.width().is_none() {
        // Not a terminal.
        table.set_width(180);
    }
    table.set_header(HEADER);
    table.add_rows(scores.iter().map(cells));
    let mut sure = Table::new();
    sure.load_preset(presets::UTF8_HORIZONTAL_ONLY).set_header(INTERVALS).add_rows(intervals(scores, others));
    format!("{table}\n\n{sure}\n\n{}", summary(scores).join("\n"))
}

/// Head of the table of intervals.
const INTERVALS: [&str; 5] =
    ["kind", "parameter", "truth within the 95 % interval", "of", "median error / half width"];

/// How often the truth lies in the stated 95 % interval, by kind and parameter, and over all.
fn intervals(scores: &[Scored], others: &[Scored]) -> Vec<[String; 5]> {
    let mut by_kind: BTreeMap<[&str; 2], Vec<f64>> = BTreeMap::new();
    for interval in scores.iter().chain(others).flat_map(|score| &score.intervals) {
        by_kind.entry([&interval.kind, &interval.parameter]).or_default().push(interval.off);
    }
    let all: Vec<f64> = by_kind.values().flatten().copied().collect();
    let line = |[kind, parameter]: [&str; 2], mut offs: Vec<f64>| {
        offs.sort_unstable_by(f64::total_cmp);
        let within = offs.iter().filter(|off| **off <= 1.0).count();
        let part = 100.0 * within as f64 / offs.len().max(1) as f64;
        let median = offs.get(offs.len() / 2).copied().unwrap_or(0.0);
        let within = format!("{within} ({part:.0} %)");
        [kind.to_owned(), parameter.to_owned(), within, offs.len().to_string(), format!("{median:.2}")]
    };
    let mut lines = vec![line(["all", ""], all)];
    lines.extend(by_kind.into_iter().map(|(of, offs)| line(of, offs)));
    lines
}

/// A page in Markdown. Intervals of `others` count too.
pub fn page(scores: &[Scored], others: &[Scored]) -> String {
    let mut text = String::from(
        "# Scoreboard of hidden effects\n\nAs measured, failures included. Made by `cargo run --release --example \
         hidden_effects -- --write docs/scoreboard.md`; its `--help` says what counts as right. Logs come from our own \
         simulator (`examples/hidden_effects`), which shares the rigid-body model with the diagnosis and nothing else; \
         the diagnosis sees URDF and logs. The search's few thresholds were set with these cases in sight; `--seed N` \
         draws other magnitudes, motions and noise (figures: `docs/diagnosis.md`).\n\n",
    );
    for line in summary(scores) {
        let _ = writeln!(text, "- {line}");
    }
    let row = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    text.push('\n');
    text.push_str(&row(&HEADER.map(str::to_owned)));
    text.push_str(&row(&HEADER.map(|_| "---".to_owned())));
    for score in scores {
        text.push_str(&row(&cells(score).map(|cell| cell.replace('|', "\\|"))));
    }
    let cases = scores.len() + others.len();
    let _ = write!(
        text,
        "\n## Intervals\n\nHow often the truth lies in the stated 95 % interval, over {cases} cases (seed 0, and other draws that were scored as a whole: --scores), where a \
         hidden effect was found where it is and the data determine the parameter. Right would be 95 %; the median of the error \
         in half widths, 0.33.\n\n"
    );
    text.push_str(&row(&INTERVALS.map(str::to_owned)));
    text.push_str(&row(&INTERVALS.map(|_| "---".to_owned())));
    for line in intervals(scores, others) {
        text.push_str(&row(&line));
    }
    text
}

/// What the scores add up to, beside what was asked for.
fn summary(scores: &[Scored]) -> Vec<String> {
    let of = |groups: &[Group]| -> Vec<&Scored> {
        let counts =
            |score: &&Scored| score.group.is_none_or(|group| groups.contains(&group)) && !score.not_judged;
        scores.iter().filter(counts).collect()
    };
    let count = |scores: &[&Scored], test: fn(&Scored) -> bool| {
        let (yes, all) = (scores.iter().filter(|score| test(score)).count(), scores.len());
        format!("{yes} of {all} ({:.0} %)", 100.0 * yes as f64 / all.max(1) as f64)
    };
    let effects = of(&[Group::Single, Group::Pair, Group::CadAndEffect]);
    let mut lines = vec![
        format!("kind, place and parameters right: {} (wanted: 95 %)", count(&effects, |s| s.right)),
        format!(
            "kind right: {}; kind and place right: {}",
            count(&effects, |s| s.kinds),
            count(&effects, |s| s.places)
        ),
        format!(
            "held-out error at most 1.1 times that of the true model: {}",
            count(&effects, |s| s.ratio().is_some_and(|r| r <= 1.1))
        ),
        format!("named as an alternative only: {}", count(&effects, |s| s.named_as_alternative)),
    ];
    let groups = [
        (Group::Single, "one effect"),
        (Group::Pair, "two effects"),
        (Group::CadAndEffect, "an effect beside CAD errors"),
        (Group::Clean, "clean logs without a claim (wanted: all)"),
        (Group::Cad, "CAD errors alone without a claim but inertial corrections (wanted: all)"),
        (Group::Outside, "outsiders called unexplained at the right joint (wanted: all)"),
    ];
    for (group, words) in groups {
        let own: Vec<&Scored> = scores.iter().filter(|score| score.group == Some(group)).collect();
        if !own.is_empty() {
            lines.push(format!("{words}: {}", count(&own, |s| s.right)));
        }
    }
    let no_outsider = |score: &&Scored| score.group != Some(Group::Outside);
    let doubted: Vec<&str> = scores
        .iter()
        .filter(no_outsider)
        .filter(|score| score.unexplained.is_some() && score.right)
        .map(|score| score.name.as_str())
        .collect();
    lines.push(format!(
        "right answers beside which something is called unexplained though nothing else is hidden (wanted: none): {} of {}{}{}",
        doubted.len(),
        scores.iter().filter(no_outsider).count(),
        if doubted.is_empty() { "" } else { ": " },
        doubted.join(", ")
    ));
    let spurious: usize = scores.iter().map(|score| score.spurious).sum();
    let per_case = spurious as f64 / scores.len().max(1) as f64;
    lines.push(format!(
        "spurious effects: {spurious} in {} cases, {} per case (wanted: below 0.05)",
        scores.len(),
        short(per_case)
    ));
    let failed = scores.iter().filter(|score| score.failed.is_some()).count();
    let seconds: f64 = scores.iter().map(|score| score.seconds).sum();
    lines.push(format!(
        "diagnoses that failed: {failed}; {:.1} s each on average",
        seconds / scores.len().max(1) as f64
    ));
    lines
}
