//! Every committed crate in `generated/` is exactly what the compiler emits for its robot.
use bipedc_compiler::Robot;
use std::path::{Path, PathBuf};

/// What `bipedc generate` writes into `generated/` for `bipedc-runtime`.
const RUNTIME: &str = "path = \"../../runtime/core\"";

fn folders(of: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(of);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn problem(robot: &str) -> Option<String> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let package = Robot::read(&root.join("robots").join(robot))
        .map_err(|e| e.to_string())
        .and_then(|r| r.package(&format!("robots/{robot}"), RUNTIME).map_err(|e| e.to_string()));
    let difference = match package {
        Ok(package) => package.compare(&root.join("generated").join(robot)).unwrap(),
        Err(error) => return Some(format!("robots/{robot}: {error}")),
    };
    (!difference.is_empty()).then(|| {
        format!(
            "generated/{robot}: {difference:?}\n\
             refresh: cargo run --release -- generate robots/{robot} --out generated/{robot}"
        )
    })
}

#[test]
fn committed_crates_are_up_to_date() {
    let generated = folders("generated");
    let robots = folders("robots");
    let orphans = generated.iter().filter(|name| !robots.contains(name));
    let mut problems: Vec<String> =
        orphans.map(|name| format!("generated/{name}: there is no robots/{name}; remove it")).collect();
    // Before the first crate is committed there is nothing to compare.
    if !generated.is_empty() {
        problems.extend(robots.iter().filter_map(|robot| problem(robot)));
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}
