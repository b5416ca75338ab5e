//! Help texts at the widths that terminals have: every paragraph is wrapped once.
use crate::cli;

use cli::{bipedc, command, run};

/// Help of a command on a terminal of this width.
fn help(arguments: &[&str], width: usize) -> String {
    let mut command = command(&[arguments, &["--help"]].concat());
    run(command.env("COLUMNS", width.to_string())).ok().out
}

/// All commands that the program has.
fn commands() -> Vec<String> {
    let help = help(&[], 100);
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    names.map(str::to_owned).collect()
}

/// Lines of running text that end although the next word would have fitted and no sentence ends there.
fn broken_twice(help: &str, width: usize) -> Vec<String> {
    let text = help.split_once("Examples:").map_or("", |(_, text)| text);
    let lines: Vec<&str> = text.lines().collect();
    let is_text = |line: &str| !line.is_empty() && !line.starts_with("  ");
    let broken = lines.windows(2).filter(|pair| is_text(pair[0]) && is_text(pair[1])).filter(|pair| {
        let word = pair[1].split_whitespace().next().unwrap_or("").chars().count();
        pair[0].chars().count() + 1 + word <= width && !pair[0].ends_with(['.', ':'])
    });
    broken.map(|pair| pair.join(" ⏎ ")).collect()
}

/// All of them, those of `gait` and the program itself too.
fn all_commands() -> Vec<Vec<String>> {
    let names = commands();
    assert!(names.len() >= 14 && names.contains(&"log".to_owned()), "{names:?}");
    let gait = ["capture", "cycle", "map", "new", "optimise", "plan", "robust", "step", "steps"];
    let gait = gait.map(|name| vec!["gait".to_owned(), name.to_owned()]);
    names.into_iter().map(|name| vec![name]).chain(gait).chain([Vec::new()]).collect()
}

/// Where nothing says how wide the terminal is, such as in a pager.
#[test]
fn help_has_80_columns_where_no_terminal_is() {
    for arguments in all_commands() {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).chain(["--help"]).collect();
        let help = run(command(&arguments).env_remove("COLUMNS")).ok().out;
        let mut wide = help.lines().filter(|line| line.chars().count() > 80 && line.trim().contains(' '));
        assert_eq!(wide.next(), None, "{arguments:?}");
    }
}

/// Programs may ask every command for JSON.
#[test]
fn every_command_has_json() {
    for arguments in all_commands() {
        let names: Vec<&str> = arguments.iter().map(String::as_str).collect();
        if matches!(names[..], [] | ["gait"]) {
            continue;
        }
        let help = help(&names, 100);
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        let keys = ["JSON: {", "JSON: the step", "JSON, of one kind", "every key", "the JSON"];
        let told = keys.iter().any(|words| help.contains(words));
        assert!(help.contains("--json") && told, "{names:?}: {help}");
    }
}

#[test]
fn paragraphs_are_wrapped_once() {
    for arguments in all_commands() {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        for width in [80, 100] {
            let help = help(&arguments, width);
            assert!(help.contains("Examples:"), "{arguments:?}");
            let broken = broken_twice(&help, width);
            assert!(broken.is_empty(), "{arguments:?} at {width}: {broken:#?}");
            // clap leaves the line of the usage whole.
            let text = help.lines().filter(|line| !line.starts_with("Usage:"));
            let mut wide = text.filter(|line| line.chars().count() > width && line.trim().contains(' '));
            assert_eq!(wide.next(), None, "{arguments:?} at {width}");
        }
    }
}

/// The test above sees what it is there for.
#[test]
fn a_text_that_is_broken_twice_is_seen() {
    let text = "Examples:\n  bipedc x\n\nCandidates enter one after the other as\nlong as each\nlowers it.\nA new sentence.\n";
    assert_eq!(broken_twice(text, 40), ["long as each ⏎ lowers it."]);
    assert_eq!(broken_twice(text, 44).len(), 2);
}

/// Remarks beside example commands stay beside them.
#[test]
fn annotated_examples_fit_a_terminal() {
    let names = commands();
    for arguments in names.iter().map(|name| vec![name.as_str()]).chain([Vec::new()]) {
        let help = help(&arguments, 100);
        let text = help.split_once("Examples:").map_or("", |(_, text)| text);
        let annotated = text.lines().filter(|line| {
            line.trim_start().starts_with("bipedc ") && line.trim_start().split("  ").nth(1).is_some()
        });
        for line in annotated {
            assert!(line.chars().count() < 80, "{arguments:?}: {line}");
        }
    }
}

/// What a shell completes behind these words; none where no bash is installed.
fn completed(words: &[&str]) -> Option<Vec<String>> {
    let script = bipedc(&["completions", "bash"]).ok().out;
    let last = words.len() - 1;
    let ask = format!(
        "{script}\nCOMP_WORDS=({}); COMP_CWORD={last}; _bipedc bipedc '{}' '{}'; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        words.join(" "),
        words[last],
        words[last - 1]
    );
    let output = std::process::Command::new("bash").args(["-c", &ask]).output().ok()?;
    Some(String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect())
}

#[test]
fn shells_complete_commands_and_options() {
    let Some(found) = completed(&["bipedc", "di"]) else { return };
    assert_eq!(found, ["diagnose"]);
    assert_eq!(completed(&["bipedc", "diagnose", "--inertial", "f"]).unwrap(), ["free"]);
    let all = completed(&["bipedc", ""]).unwrap();
    assert!(commands().iter().all(|name| all.contains(name)), "{all:?}");
    for shell in ["zsh", "fish"] {
        let script = bipedc(&["completions", shell]).ok().out;
        let printed = bipedc(&["completions", shell, "--json"]).ok().json();
        assert!(printed["shell"] == shell && printed["script"] == script, "{shell}");
        assert!(script.contains("diagnose") && script.contains("validate"), "{shell}");
    }
}
