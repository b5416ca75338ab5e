//! What is seen first: the answer in figures, the robot beside them, the answer in words, and what to do next.
use super::causes::{breakable, coded, lines};
use super::data::{NextStep, Report};
use super::svg;
use crate::diagnose::{AT_NOISE, Diagnosis};
use crate::experiments::plotted::Row;
use crate::number::{joined, percent, significant, with_unit};
use maud::{Markup, html};

/// Paragraphs that stand open; the rest is a click away.
const OPEN: usize = 4;

/// A figure and what it is.
struct Card {
    title: String,
    figure: String,
    words: String,
}

impl Card {
    fn new(title: &str, figure: impl Into<String>, words: impl Into<String>) -> Self {
        Self { title: title.to_owned(), figure: figure.into(), words: words.into() }
    }
}

/// Cards, robot, words, warnings, commands.
pub(super) fn section(report: &Report) -> Markup {
    let cards = cards(report);
    html! {
        section.opening aria-label="Summary" {
            div.answer {
                @if !cards.is_empty() {
                    dl.cards { @for card in &cards { div.card {
                        dt { (card.title) }
                        dd.figure { (card.figure) }
                        dd.words { (card.words) }
                    } } }
                }
                (words(report))
                (next(&report.next))
                (lines("Warnings", "warnings", &super::sections::warnings(report)))
            }
            (robot(report))
        }
    }
}

fn cards(report: &Report) -> Vec<Card> {
    let mut cards = Vec::new();
    if !report.log.is_empty() {
        cards.push(Card::new("log", &report.log, log_words(report)));
    }
    cards.extend(match &report.diagnosis {
        Some(diagnosis) => diagnosed(diagnosis, &report.rows),
        None => at_noise(&report.rows),
    });
    cards.extend(report.diagnosis.as_ref().and_then(fallen));
    let units = super::page::units(&report.rows);
    let is_noise = |row: &Row| row.noise > 0.0 && row.told_before() <= AT_NOISE * row.noise;
    let told = units.iter().enumerate().filter(|(k, rows)| *k == 0 || !rows.iter().all(is_noise));
    cards.extend(told.filter_map(|(_, rows)| worst(rows)));
    if report.diagnosis.is_none() {
        cards.extend(units.first().and_then(|rows| noise(rows)));
    }
    cards
}

/// How the held-out error fell, in the kind of channel in which it did.
fn fallen(diagnosis: &Diagnosis) -> Option<Card> {
    let told = diagnosis.telling_channel().and_then(|kind| Some((kind, diagnosis.rms.get(kind)?)));
    let main = svg::headline(diagnosis);
    let fall = told.map(|(_, fall)| fall).or(main)?;
    let of = match told {
        Some((kind, fall)) if Some(fall) != main => format!("{}; ", kind.replace('_', " ")),
        _ => String::new(),
    };
    let noise = if fall.noise > 0.0 {
        format!("{of}the measurement's noise is {}", with_unit(fall.noise, &fall.unit))
    } else {
        format!("{of}root mean square over all rows")
    };
    let free = fall.where_free().map_or_else(String::new, |[before, after]| {
        format!("; where joints do not stick {} → {}", significant(before, 3), with_unit(after, &fall.unit))
    });
    let noise = noise + &free;
    let figure = format!("{} → {}", significant(fall.before, 3), with_unit(fall.after, &fall.unit));
    Some(Card::new("held-out error, with effects", figure, noise))
}

/// What was read of the log, from the facts.
fn log_words(report: &Report) -> String {
    let fact = |name: &str| report.facts.iter().find(|fact| fact.name == name).map(|fact| &fact.value);
    let samples = fact("samples").map(|samples| format!("{samples} samples"));
    let judged = report.diagnosis.as_ref().and_then(|found| found.judged_at_hz);
    let judged = judged.map_or(String::new(), |hz| format!(", of the errors {hz} Hz"));
    let cutoff = fact("cut-off").map(|cutoff| format!("cut-off {cutoff}{judged}"));
    let training = report.diagnosis.as_ref().filter(|found| found.validation.is_some());
    let training = training.map(|found| {
        let file = std::path::Path::new(&found.training.file).file_name().unwrap_or_default();
        format!("it judges; estimated from {}", file.to_string_lossy())
    });
    samples.into_iter().chain(cutoff).chain(training).collect::<Vec<_>>().join(", ")
}

/// In how many rows a diagnosis has nothing more to say: those that its last sentence does not speak of.
fn diagnosed(diagnosis: &Diagnosis, rows: &[Row]) -> Option<Card> {
    let known = |row: &&Row| diagnosis.rows.get(&row.name).is_some_and(|fall| fall.noise > 0.0);
    if !rows.iter().any(|row| known(&row)) {
        return None;
    }
    let is_left = |row: &Row| diagnosis.suspects.contains(&row.name);
    let after = rows.iter().filter(known).filter(|row| !is_left(row)).count();
    let before = rows.iter().filter(known).filter(|row| diagnosis.rows[&row.name].was_noise()).count();
    let words =
        format!("have nothing left beyond noise of measurement and motion; {before} by the nominal model");
    Some(Card::new("explained", counted(after, rows), words))
}

/// How many rows have nothing but the measurement's noise left, by the nominal model.
fn at_noise(rows: &[Row]) -> Option<Card> {
    if rows.iter().all(|row| row.noise <= 0.0) {
        return None;
    }
    let quiet = |row: &&Row| row.noise > 0.0 && row.told_before() <= AT_NOISE * row.noise;
    let count = rows.iter().filter(quiet).count();
    Some(Card::new(
        "explained",
        counted(count, rows),
        "have nothing but the measurement's noise left, within a tenth",
    ))
}

fn counted(count: usize, rows: &[Row]) -> String {
    let what = if rows.iter().all(|row| row.joint.is_some()) { "joints" } else { "rows" };
    format!("{count} of {} {what}", rows.len())
}

/// The largest error among rows of one unit.
fn worst(rows: &[Row]) -> Option<Card> {
    let row = rows
        .iter()
        .filter(|row| row.rms_before.is_finite())
        .max_by(|a, b| a.rms_before.total_cmp(&b.rms_before))?;
    let figure = match row.rms_after {
        Some(after) => format!("{} → {}", significant(row.rms_before, 3), with_unit(after, &row.unit)),
        None => with_unit(row.rms_before, &row.unit),
    };
    let shares = match row.unexplained_after {
        Some(after) => format!("{} → {}", percent(row.unexplained_before), percent(after)),
        None => percent(row.unexplained_before),
    };
    let words = if row.unexplained_before.is_finite() {
        format!("{}: {shares} of the measured signal is unexplained", row.name)
    } else {
        row.name.clone()
    };
    Some(Card::new("largest error", figure, words))
}

/// From the quietest to the noisiest row of one unit.
fn noise(rows: &[Row]) -> Option<Card> {
    let known = || rows.iter().map(|row| row.noise).filter(|noise| *noise > 0.0);
    let (low, high) = known().fold((f64::INFINITY, 0.0), |(low, high), x| (x.min(low), x.max(high)));
    let unit = &rows.first()?.unit;
    let [least, most] = [low, high].map(|x| significant(x, 2));
    let figure = if known().count() > 1 && least != most {
        format!("{least} to {}", joined(most, unit))
    } else if high > 0.0 {
        joined(most, unit)
    } else {
        return None;
    };
    Some(Card::new("noise", figure, "of the measurement, estimated: no model leaves less"))
}

/// The answer in plain words.
fn words(report: &Report) -> Markup {
    let words = match &report.diagnosis {
        Some(diagnosis) if report.summary.is_empty() => diagnosis.summary.as_str(),
        _ => report.summary.as_str(),
    };
    let normal = words.replace("\r\n", "\n");
    let paragraphs: Vec<&str> = normal.split('\n').map(str::trim).filter(|p| !p.is_empty()).collect();
    let (open, rest) = paragraphs.split_at(paragraphs.len().min(OPEN));
    html! {
        @if !open.is_empty() { div.summary {
            @for paragraph in open { p { (coded(paragraph)) } }
            @if !rest.is_empty() { details {
                summary { "and " (rest.len()) " more" }
                @for paragraph in rest { p { (coded(paragraph)) } }
            } }
        } }
    }
}

/// Commands, to be copied.
fn next(steps: &[NextStep]) -> Markup {
    html! {
        @if !steps.is_empty() { div.next {
            h2 { "What to do next" }
            @for step in steps {
                p { (coded(&step.why)) }
                div.command {
                    code tabindex="0" { @for (k, word) in step.command.split(' ').enumerate() {
                        @if k > 0 { " " }
                        span { (breakable(word)) }
                    } }
                    button type="button" data-copy hidden { "Copy" }
                }
            }
        } }
    }
}

/// The robot, joints coloured by what is unexplained.
fn robot(report: &Report) -> Markup {
    let Some((drawing, (width, height))) = svg::robot(report) else { return html! {} };
    let amended = report.rows.iter().any(|row| row.rms_after.is_some());
    html! {
        figure.robot {
            @if amended {
                div.switch role="group" aria-label="Colours show" {
                    button type="button" data-show="before" aria-pressed="true" { "nominal model" }
                    button type="button" data-show="after" aria-pressed="false" { (super::page::after(&report.rows)) }
                }
            }
            svg #robot viewBox=(format!("0 0 {width} {height}")) role="group"
                aria-label=(format!("{} with its joints, coloured by the share of their torque that is unexplained", report.robot)) { (drawing) }
            figcaption { "Unexplained share of the measured torque; discs carry the numbers of the table: " span.keys { (svg::legend()) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::ErrorFall;
    use crate::experiments::Channel;
    use crate::report::Series;

    fn row(name: &str, unit: &str, error: f64, noise: f64) -> Row {
        let series = Series {
            time: vec![0.0, 1.0],
            measured: vec![4.0, -4.0],
            nominal: vec![4.0 - error, -4.0 - error],
            ..Series::default()
        };
        Row::new(name, Channel::Effort, unit, noise, series).at_joint(name)
    }

    #[test]
    fn figures_say_what_the_rows_say() {
        let rows =
            vec![row("knee", "N m", 2.0, 0.1), row("hip", "N m", 0.1, 0.1), row("slide", "N", 9.0, 0.0)];
        let report = Report { rows, log: "walk.csv".to_owned(), ..Report::default() };
        let figures: Vec<(String, String)> =
            cards(&report).into_iter().map(|card| (card.title, card.figure.replace('\u{a0}', " "))).collect();
        let expected = [
            ("log", "walk.csv"),
            ("explained", "1 of 3 joints"),
            ("largest error", "2.00 N m"),
            ("largest error", "9.00 N"),
            ("noise", "0.10 N m"),
        ];
        let expected = expected.map(|(title, figure)| (title.to_owned(), figure.to_owned()));
        assert_eq!(figures, expected);
    }

    #[test]
    fn a_diagnosis_counts_rows_as_its_words_do() {
        let fall = |after: f64, resolution: f64| ErrorFall {
            before: 2.0,
            after,
            noise: 0.1,
            resolution,
            ..ErrorFall::default()
        };
        let rows = ["knee", "hip", "ankle"].map(|name| row(name, "N m", 2.0, 0.1)).to_vec();
        // 1.3 times the noise, twice the noise but at what motions are known to, and twice the noise.
        let falls = [("knee", fall(0.13, 0.0)), ("hip", fall(0.2, 0.2)), ("ankle", fall(0.2, 0.0))];
        let falls = falls.map(|(name, fall)| (name.to_owned(), fall));
        let mut diagnosis = Diagnosis { rows: falls.into_iter().collect(), ..Diagnosis::default() };
        diagnosis.conclude();
        assert_eq!(diagnosis.suspects, ["ankle"]);
        let report = Report { rows, diagnosis: Some(diagnosis), ..Report::default() };
        let card = cards(&report).into_iter().find(|card| card.title == "explained").unwrap();
        assert_eq!(card.figure, "2 of 3 joints");
        assert!(card.words.ends_with("; 0 by the nominal model"), "{}", card.words);
    }

    #[test]
    fn the_filter_of_the_errors_is_named_beside_that_of_the_search() {
        let said = |judged_at_hz| {
            let diagnosis = Some(Diagnosis { judged_at_hz, ..Diagnosis::default() });
            let facts = vec![crate::report::Fact::new("cut-off", "60 Hz")];
            log_words(&Report { facts, diagnosis, ..Report::default() }).replace('\u{a0}', " ")
        };
        assert_eq!(said(None), "cut-off 60 Hz");
        assert_eq!(said(Some(10.0)), "cut-off 60 Hz, of the errors 10 Hz");
    }

    #[test]
    fn the_error_that_fell_is_shown() {
        let fall = |unit: &str, before: f64, after: f64| ErrorFall {
            unit: unit.to_owned(),
            before,
            after,
            noise: 0.02,
            ..ErrorFall::default()
        };
        let of = |effort: f64| {
            let kinds = [("base_force", fall("N", 5.117, 0.2604)), ("effort", fall("N m", 0.0291, effort))];
            let rms = kinds.map(|(kind, fall)| (kind.to_owned(), fall)).into_iter().collect();
            fallen(&Diagnosis { rms, rms_before: 0.0291, rms_after: effort, ..Diagnosis::default() }).unwrap()
        };
        let card = of(0.0291);
        assert!(card.figure.starts_with("5.12 → 0.260"), "{}", card.figure);
        assert!(card.words.starts_with("base force; the measurement's noise"), "{}", card.words);
        // Where the main error falls it is the one.
        assert!(of(0.01).figure.starts_with("0.0291 → 0.01"), "{}", of(0.01).figure);
    }

    #[test]
    fn many_words_are_folded_and_commands_escaped() {
        let report = Report {
            summary: (0..9).map(|k| format!("word {k}")).collect::<Vec<_>>().join("\n\n"),
            next: vec![NextStep { why: "why".to_owned(), command: "bipedc x > <y>".to_owned() }],
            ..Report::default()
        };
        let page = section(&report).into_string();
        assert!(page.contains("and 5 more"), "{page}");
        // Words that no line is broken in.
        assert!(
            page.contains("<span>bipedc</span> <span>x</span> <span>&gt;</span> <span>&lt;y&gt;</span>"),
            "{page}"
        );
    }
}
