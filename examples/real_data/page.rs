//! Answers as Markdown.
use crate::run::Part;
use serde_json::Value;
use std::fmt::Write as _;

/// Beginning of the page.
pub const HEAD: &str = "\
# The diagnosis on real machines

Made by `cargo run --release --example real_data -- --write FILE.md`. The data are
other people's: sources and licences are named with each machine; only figures computed from them stand here.

";

/// One question with its answer. Writing into a string cannot fail.
pub fn part(part: &Part) -> String {
    let mut out = format!("## {}\n\n{}\n\n```\n{}\n```\n\n", part.title, part.words.trim(), part.command);
    let answer = &part.answer;
    effects(&mut out, answer);
    errors(&mut out, part);
    let list = |key: &str| answer[key].as_array().cloned().unwrap_or_default();
    for group in list("indistinguishable") {
        let names: Vec<String> = group.as_array().into_iter().flatten().map(name).collect();
        let _ = writeln!(out, "- Cannot be told apart on this data: {}.", names.join("; or "));
    }
    for rest in list("unexplained_parts") {
        let signals: Vec<&str> =
            rest["signals"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let share = 100.0 * rest["share"].as_f64().unwrap_or(0.0);
        let joint = rest["joint"].as_str().unwrap_or_default();
        let with = match signals.as_slice() {
            [] => "what it goes with was not found".to_owned(),
            found => format!("goes with {}", found.join(", ")),
        };
        let _ = writeln!(out, "- Left unexplained in {joint}: {share:.0} % of what remains; {with}.");
    }
    for warning in list("warnings") {
        // Gaps between joined logs are no news.
        let warning = warning.as_str().unwrap_or_default();
        if !warning.starts_with("gap of") {
            let _ = writeln!(out, "- Warning: {warning}.");
        }
    }
    out.push('\n');
    out
}

fn effects(out: &mut String, answer: &Value) {
    let found = answer["effects"].as_array().cloned().unwrap_or_default();
    if found.is_empty() {
        out.push_str("No effect earned its place.\n\n");
        return;
    }
    out.push_str("| effect | where | parameters (95 %) | share |\n|---|---|---|---|\n");
    for effect in found {
        let parameters = effect["parameters"].as_object().cloned().unwrap_or_default();
        let values: Vec<String> = parameters
            .iter()
            .map(|(name, value)| {
                let end = |k: usize| effect["ci95"][name][k].as_f64();
                let value = value.as_f64().unwrap_or(f64::NAN);
                match (end(0), end(1)) {
                    (Some(low), Some(high)) => format!("{name} {value:.4} ({low:.4} to {high:.4})"),
                    _ => format!("{name} {value:.4}"),
                }
            })
            .collect();
        let share = 100.0 * effect["share"].as_f64().unwrap_or(0.0);
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {share:.1} % |",
            effect["kind"].as_str().unwrap_or_default(),
            place(&effect),
            values.join(", ")
        );
    }
    out.push('\n');
}

/// Errors as the answer states them, and as the amended robot has them.
fn errors(out: &mut String, part: &Part) {
    out.push_str("| rms | held out: before | after | `compare`: before | after `amend` | unit |\n|---|---|---|---|---|---|\n");
    for (row, fall) in part.answer["rows"].as_object().into_iter().flatten() {
        let number = |key: &str| fall[key].as_f64().unwrap_or(f64::NAN);
        let unit = fall["unit"].as_str().unwrap_or_default();
        let measured = part.measured.iter().find(|measured| measured.name == *row);
        let measured =
            measured.map_or("| ".to_owned(), |r| format!("{:.3} | {:.3}", r.errors[0], r.errors[1]));
        let _ = writeln!(
            out,
            "| {row} | {:.3} | {:.3} | {measured} | {unit} |",
            number("before"),
            number("after")
        );
    }
    out.push('\n');
}

/// An alternative in words.
fn name(alternative: &Value) -> String {
    let effects = alternative.as_array().into_iter().flatten();
    let names: Vec<String> =
        effects.map(|e| format!("`{}` at {}", e["kind"].as_str().unwrap_or_default(), place(e))).collect();
    names.join(" with ")
}

fn place(effect: &Value) -> String {
    let part = |key: &str| effect[key].as_str().map(str::to_owned);
    let place = part("joint").or_else(|| part("link")).or_else(|| part("sensor"));
    let place = place.unwrap_or_else(|| "the robot".to_owned());
    part("other_joint").map_or(place.clone(), |other| format!("{place}, from {other}"))
}
