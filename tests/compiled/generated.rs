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
    // Crates of controllers are checked by `tests/walking/on_board.rs`.
    let of = |name: &String| name.strip_suffix("_controller").unwrap_or(name).to_owned();
    let orphans = generated.iter().filter(|name| !robots.contains(&of(name)));
    let mut problems: Vec<String> =
        orphans.map(|name| format!("generated/{name}: there is no robots/{name}; remove it")).collect();
    // Before the first crate is committed there is nothing to compare.
    if !generated.is_empty() {
        problems.extend(robots.iter().filter_map(|robot| problem(robot)));
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// Files of the committed crates: (path, text).
fn sources() -> Vec<(String, String)> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("generated");
    let files = folders("generated").into_iter().flat_map(|robot| {
        let entries = std::fs::read_dir(root.join(&robot).join("src")).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect::<Vec<_>>()
    });
    files.map(|path| (path.display().to_string(), std::fs::read_to_string(&path).unwrap())).collect()
}

/// Lists fill their lines, and no line leaves the screen but for a long name or statement.
#[test]
fn generated_code_fits_the_screen() {
    for (path, text) in sources() {
        for line in text.lines().filter(|line| line.chars().count() > 120) {
            let statements = ["= R::fused(", "= R::Two::fused(", "= two("];
            let long = statements.iter().any(|statement| line.contains(statement));
            let words = if long { "one" } else { line };
            let name = words.trim_start_matches(['/', '!', ' ']).split_once(' ').is_none();
            assert!(name, "{path}: {line}");
        }
        let lonely = |line: &&str| {
            line.trim()
                .strip_prefix('t')
                .and_then(|name| name.strip_suffix(','))
                .is_some_and(|k| k.parse::<u32>().is_ok())
        };
        let (lonely, lines) = (text.lines().filter(lonely).count(), text.lines().count());
        assert!(lonely * 50 <= lines, "{path}: {lonely} of {lines} lines are one name");
    }
}

#[test]
fn generated_code_says_what_is_what() {
    let sources = sources();
    let file = |name: &str| {
        &sources.iter().find(|(path, _)| path.ends_with(name)).unwrap_or_else(|| panic!("{name}")).1
    };
    let bias = file("five_link/src/bias.rs");
    for words in [
        "pub fn bias<R: Real>(q: &SVector<R, NQ>, v: &SVector<R, NV>) -> SMatrix<R, NV, 1> {",
        "/// Rows: all the elements of [`v`](super::V_NAMES), `base/x` to `left_knee_pitch`; N, then N m.",
        "    let q_left_knee_pitch = q[6];\n",
        "    let v_base_pitch = v[2];\n",
        "    // right_tibia, left_tibia: sums of what it carries\n",
        "sin_q_base_pitch",
    ] {
        assert!(bias.contains(words), "no `{words}` in {bias}");
    }
    let library = file("five_link/src/lib.rs");
    for words in [
        "//! `q`, length [`NQ`]: 0 `base/x`, 1 `base/z`".to_owned(),
        "//! - [`bias()`]: 7 × 1, 73 operations. Bias `H = C v + G`.".to_owned(),
        "const _: () = ::bipedc_runtime::require_format(".to_owned(),
    ] {
        assert!(library.replace('\u{a0}', " ").contains(&words), "no `{words}` in {library}");
    }
    assert!(!library.contains("Signature") && library.lines().count() < 250, "{library}");
    assert!(file("five_link/src/model.rs").contains("Signature::new(\"bias\", &[Q, V], NV, 1),\n"));
    let both = file("tulip/src/inverse_dynamics_derivatives.rs");
    assert!(
        both.contains("-> SMatrix<R, NV, { 3 * NV }> {")
            && both.contains("/// Columns: `q/`, `v/`, `a/`, each before all"),
        "{both}"
    );
}

/// What is folded is computed from the description's decimals: 0.0102, not 0.010199999999999987.
#[test]
fn folded_constants_have_no_dust() {
    let exact = ["five_link", "three_link", "biped_3d", "tulip", "tulip_v1_leg"];
    let wanted = exact.map(|robot| format!("{robot}/src/inverse_dynamics.rs"));
    let sources = sources();
    let files: Vec<_> =
        sources.iter().filter(|(path, _)| wanted.iter().any(|end| path.ends_with(end))).collect();
    assert_eq!(files.len(), exact.len());
    for (path, text) in files {
        for constant in text.split("R::constant(").skip(1) {
            let number = constant.split_once(')').unwrap().0;
            let digits = number.trim_start_matches(['-', '0', '.']).replace('.', "");
            assert!(digits.len() <= 15, "{path}: {number}");
        }
    }
}

#[test]
fn the_readme_shows_generated_code() {
    let readme = include_str!("../../README.md");
    let block = readme.split("```rust\n").find(|block| block.starts_with("pub(super) fn")).unwrap();
    let shown = block.split("```").next().unwrap().split("    ...\n");
    let sources = sources();
    let (_, code) = sources.iter().find(|(path, _)| path.ends_with("five_link/src/bias.rs")).unwrap();
    shown.for_each(|lines| assert!(code.contains(lines), "{lines}"));
}
