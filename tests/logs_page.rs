//! `docs/logs.md` is true: it has every column that is read, its mapping file reads, its commands run and print what it shows.
use crate::cli;

use bipedc_analysis::log::names::{BASE_VECTORS, FOOT_VECTORS, JOINT_QUANTITIES};
use bipedc_analysis::log::{Kind, Mapping};
use cli::scratch;
use std::path::Path;

const PAGE: &str = include_str!("../docs/logs.md");

/// Blocks of this language, without their fences.
fn blocks(language: &str) -> Vec<&'static str> {
    let mut parts = PAGE.split("```").skip(1).step_by(2);
    let mut found = Vec::new();
    for part in parts.by_ref() {
        let (head, body) = part.split_once('\n').unwrap();
        if head == language {
            found.push(body);
        }
    }
    found
}

/// The row of a table whose first cell has this text.
fn row_of(column: &str) -> &'static str {
    let has = |line: &&str| line.starts_with('|') && line.split('|').nth(1).unwrap().contains(column);
    PAGE.lines().find(has).unwrap_or_else(|| panic!("no row for {column}"))
}

#[test]
fn every_column_is_on_the_page() {
    for kind in Kind::ALL {
        row_of(&format!("`{}`", kind.column()));
    }
    for quantity in JOINT_QUANTITIES {
        let name = format!("<joint>/{quantity}");
        let unit = bipedc_analysis::log::names::unit(&name).unwrap();
        assert!(row_of(&format!("`{name}`")).contains(&format!("| {unit} |")), "{name} is in {unit}");
    }
    for (vector, axes, unit) in BASE_VECTORS {
        assert_vector(vector, axes, unit);
    }
    for (vector, axes, unit) in FOOT_VECTORS {
        assert_vector(&format!("<foot>/{vector}"), axes, unit);
    }
    row_of("`cop/x`, `/y`");
    row_of("`<foot>/<corner>/force/z`");
}

fn assert_vector(vector: &str, axes: &[&str], unit: &str) {
    let rest: Vec<String> = axes[1..].iter().map(|axis| format!("`/{axis}`")).collect();
    let row = row_of(&format!("`{vector}/{}`, {}", axes[0], rest.join(", ")));
    assert!(row.contains(&format!("| {unit} |")), "{vector}: {unit}");
}

/// The other way round: what the tables call a column is one.
#[test]
fn every_name_on_the_page_is_a_column() {
    let tables = PAGE.split("## Mapping files").next().unwrap();
    let cells =
        tables.lines().filter(|line| line.starts_with("| `")).map(|line| line.split('|').nth(1).unwrap());
    let mut counted = 0;
    for cell in cells {
        let name = cell.split('`').nth(1).unwrap().replace("<joint>", "knee").replace("<foot>", "sole");
        let name = name.replace("<corner>", "heel");
        assert!(bipedc_analysis::log::names::is_known_form(&name), "{name}");
        counted += 1;
    }
    assert!(counted >= 20, "{counted}");
}

#[test]
fn the_mapping_file_reads_and_has_every_key() {
    let [example, patterns] = blocks("toml")[..] else { panic!("two examples") };
    let mapping = Mapping::parse(Path::new("docs/logs.md"), patterns).unwrap();
    assert_eq!((mapping.patterns.len(), mapping.columns.len()), (3, 0));
    let mapping = Mapping::parse(Path::new("docs/logs.md"), example).unwrap();
    assert_eq!((mapping.columns.len(), mapping.frames.len()), (4, 1));
    let error = Mapping::parse(Path::new("x"), "time = { unit = 1 }").unwrap_err().to_string();
    let keys = error.split("keys: ").nth(1).unwrap().lines().next().unwrap();
    for key in keys.split(", ") {
        assert!(PAGE.contains(&format!("| `{key}` |")), "no row for the key `{key}`");
        assert!(example.contains(&format!("{key} =")), "no example of `{key}`");
    }
}

/// In a folder of its own, with the repository's robots and examples in it.
#[cfg(unix)]
#[test]
fn its_commands_run_and_print_what_it_shows() {
    let folder = scratch("logs_page");
    for name in ["robots", "tests"] {
        std::os::unix::fs::symlink(Path::new(env!("CARGO_MANIFEST_DIR")).join(name), folder.join(name))
            .unwrap();
    }
    let programs = Path::new(env!("CARGO_BIN_EXE_bipedc")).parent().unwrap().display();
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap());
    let mut printed = String::new();
    for block in blocks("sh") {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-e", "-c", block]).env("PATH", &path).current_dir(&folder);
        printed += &cli::run(&mut shell).ok().out;
    }
    let shown = blocks("").into_iter().find(|block| block.starts_with("run.csv:")).unwrap();
    let lines: Vec<&str> = shown.lines().filter(|line| !line.is_empty() && *line != "...").collect();
    assert!(lines.len() > 9);
    for line in lines {
        assert!(printed.lines().any(|other| other == line), "not printed: {line}\n{printed}");
    }
    // The comparison at the end found the mapped columns.
    assert!(printed.contains("left_knee_pitch       0.3989 N m"), "{printed}");
}
