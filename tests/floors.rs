//! The plan of the house: which crate may use which, and that the modules of a crate stand on one another without circles.
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

type Names = BTreeSet<String>;

/// Every crate with those of ours that it may depend on.
const CRATES: [(&str, &[&str]); 7] = [
    ("runtime/core", &[]),
    ("runtime/effects", &[]),
    ("runtime/lapack", &[]),
    ("runtime/analysis", &["bipedc-effects", "bipedc-lapack", "bipedc-runtime"]),
    ("compiler", &["bipedc-effects", "bipedc-runtime"]),
    ("macros", &["bipedc-compiler"]),
    (".", &["bipedc-analysis", "bipedc-compiler", "bipedc-effects", "bipedc-runtime"]),
];
/// What solves, simulates or draws has no place below whoever derives a robot.
const HEAVY: [&str; 6] = ["clarabel", "flate2", "ivp", "maud", "slsqp", "wide"];
/// Modules of the analysis from the ground up; those of one floor do not know one another.
const ANALYSIS: [&[&str]; 6] = [
    &["gram", "log", "nonlinear", "number", "parallel", "polygon", "signal"],
    &["robot"],
    &["measure", "physical"],
    &["experiments"],
    &["compare", "diagnose", "gait", "identify", "simulate", "walking"],
    &["report"],
];
/// The same of the root package: its library, then the command on top of it.
const ROOT: [&[&str]; 9] = [
    &["crate_paths", "export", "kinds", "progress", "robot", "table"],
    &["amendment", "film", "gait", "inventory", "measurements"],
    &["report", "walking"],
    &["simulation"],
    &["comparison", "diagnosis", "identification"],
    &["excitation"],
    &["workbench"],
    &["terminal"],
    &["commands"],
];
/// Modules of the root package that belong to the command.
const COMMAND: [&str; 3] = ["commands", "main", "terminal"];
/// What only a command does: read arguments, print, end with a code.
const COMMANDS_DO: [&str; 7] = ["ExitCode", "clap", "eprint", "eprintln", "indicatif", "print", "println"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Names under `[dependencies]`.
fn dependencies(folder: &str) -> Names {
    let path = root().join(folder).join("Cargo.toml");
    let manifest: toml_edit::DocumentMut = fs::read_to_string(path).unwrap().parse().unwrap();
    let table = manifest.get("dependencies").and_then(|item| item.as_table_like());
    table.map(|table| table.iter().map(|(name, _)| name.to_owned()).collect()).unwrap_or_default()
}

#[test]
fn crates_depend_on_lower_floors_alone() {
    for (folder, allowed) in CRATES {
        let found = dependencies(folder);
        let ours: Vec<&String> = found.iter().filter(|name| name.starts_with("bipedc")).collect();
        assert_eq!(ours, allowed.iter().collect::<Vec<_>>(), "{folder}");
    }
    for entry in fs::read_dir(root().join("generated")).unwrap() {
        let folder = format!("generated/{}", entry.unwrap().file_name().display());
        assert_eq!(dependencies(&folder).into_iter().collect::<Vec<_>>(), ["bipedc-runtime"], "{folder}");
    }
}

#[test]
fn deriving_a_robot_compiles_no_solver() {
    for folder in ["runtime/core", "runtime/effects", "compiler", "macros"] {
        let found = dependencies(folder);
        assert!(HEAVY.iter().all(|heavy| !found.contains(*heavy)), "{folder}: {found:?}");
    }
    assert_eq!(dependencies("runtime/core").into_iter().collect::<Vec<_>>(), ["nalgebra"]);
}

/// All files of Rust below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            sources(&entry, found);
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            found.push(entry);
        }
    }
}

/// Whether a token is this word or mark.
fn is_token(token: Option<&TokenTree>, text: &str) -> bool {
    match token {
        Some(TokenTree::Ident(name)) => name == text,
        Some(TokenTree::Punct(mark)) => text.len() == 1 && text.starts_with(mark.as_char()),
        _ => false,
    }
}

/// Whether `#[cfg(test)]` begins here.
fn for_tests_alone(tokens: &[TokenTree]) -> bool {
    is_token(tokens.first(), "#")
        && tokens.get(1).is_some_and(|token| token.to_string().replace(' ', "") == "[cfg(test)]")
}

/// Modules of the crate's root that a text names: by `crate::…`, or by as many `super::` as it lies deep.
fn named(tokens: TokenStream, depth: usize, found: &mut Names) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let is = |k: usize, text: &str| is_token(tokens.get(k), text);
    let mut k = 0;
    while k < tokens.len() {
        if for_tests_alone(&tokens[k..]) {
            // What is compiled for tests only: up to its body or its end.
            k += 2;
            let body =
                |token: &TokenTree| matches!(token, TokenTree::Group(g) if g.delimiter() == Delimiter::Brace);
            while k < tokens.len() && !body(&tokens[k]) && !is(k, ";") {
                k += 1;
            }
        } else if is(k, "crate") || is(k, "super") {
            let mut climbed = if is(k, "crate") { depth } else { 1 };
            k += 1;
            while is(k, ":") && is(k + 1, ":") && is(k + 2, "super") {
                (climbed, k) = (climbed + 1, k + 3);
            }
            if climbed == depth && is(k, ":") && is(k + 1, ":") {
                heads(&tokens[k + 2..], found);
            }
            continue;
        } else if let TokenTree::Group(group) = &tokens[k] {
            named(group.stream(), depth, found);
        }
        k += 1;
    }
}

/// The first name of a path, or of each path in braces.
fn heads(tokens: &[TokenTree], found: &mut Names) {
    match tokens.first() {
        Some(TokenTree::Ident(name)) => drop(found.insert(name.to_string())),
        Some(TokenTree::Group(group)) => {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            inner.split(|token| is_token(Some(token), ",")).for_each(|path| heads(path, found));
        }
        _ => {}
    }
}

/// For each module of a crate's root, the others that it names.
fn arrows(folder: &str) -> BTreeMap<String, Names> {
    let folder = root().join(folder);
    let (mut files, mut arrows) = (Vec::new(), BTreeMap::<String, Names>::new());
    sources(&folder, &mut files);
    for file in files {
        let below = file.strip_prefix(&folder).unwrap().with_extension("");
        let mut path: Vec<String> = below.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        path.retain(|part| part != "mod");
        if ["lib", "main"].contains(&path[0].as_str())
            || path.last().is_some_and(|name| name.ends_with("tests"))
        {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap().parse().unwrap();
        named(text, path.len(), arrows.entry(path[0].clone()).or_default());
    }
    let modules: Names = arrows.keys().cloned().collect();
    for (module, others) in &mut arrows {
        others.retain(|other| other != module && modules.contains(other));
    }
    arrows
}

/// The modules that a module reaches.
fn reached(arrows: &BTreeMap<String, Names>, from: &str) -> Names {
    let (mut found, mut open) = (Names::new(), vec![from.to_owned()]);
    while let Some(module) = open.pop() {
        for other in arrows.get(&module).into_iter().flatten() {
            if found.insert(other.clone()) {
                open.push(other.clone());
            }
        }
    }
    found
}

#[test]
fn no_module_stands_on_itself() {
    for (crate_folder, _) in CRATES {
        let arrows = arrows(&format!("{crate_folder}/src"));
        for module in arrows.keys() {
            assert!(
                !reached(&arrows, module).contains(module),
                "{crate_folder}: `{module}` in a circle: {arrows:#?}"
            );
        }
    }
}

#[test]
fn modules_have_floors() {
    for (folder, floors) in [("runtime/analysis/src", &ANALYSIS[..]), ("src", &ROOT[..])] {
        let floor = |name: &str| floors.iter().position(|floor| floor.contains(&name));
        for (module, others) in &arrows(folder) {
            let own = floor(module).unwrap_or_else(|| panic!("{folder}: `{module}` has no floor"));
            for other in others {
                assert!(floor(other) < Some(own), "{folder}: `{module}` names `{other}`, not below it");
            }
        }
    }
}

/// All names in a text.
fn names(tokens: TokenStream, found: &mut Names) {
    for token in tokens {
        match token {
            TokenTree::Ident(name) => drop(found.insert(name.to_string())),
            TokenTree::Group(group) => names(group.stream(), found),
            _ => {}
        }
    }
}

#[test]
fn the_library_reads_no_arguments_and_prints_nothing() {
    let folder = root().join("src");
    let mut files = Vec::new();
    sources(&folder, &mut files);
    for file in files {
        let below = file.strip_prefix(&folder).unwrap().with_extension("");
        let module = below.iter().next().unwrap().to_str().unwrap();
        if COMMAND.contains(&module) {
            continue;
        }
        let mut found = Names::new();
        names(fs::read_to_string(&file).unwrap().parse().unwrap(), &mut found);
        let of_commands: Vec<&&str> = COMMANDS_DO.iter().filter(|name| found.contains(**name)).collect();
        assert!(of_commands.is_empty(), "{}: {of_commands:?}", file.display());
    }
}

/// Texts in quotes, without those of what is compiled for tests only.
fn quoted(tokens: TokenStream, found: &mut Names) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut k = 0;
    while k < tokens.len() {
        match &tokens[k] {
            _ if for_tests_alone(&tokens[k..]) => {
                let body = |token: &TokenTree| {
                    matches!(token, TokenTree::Group(g) if g.delimiter() == Delimiter::Brace)
                        || is_token(Some(token), ";")
                };
                k += 2;
                k += tokens[k..].iter().position(body).unwrap();
            }
            TokenTree::Group(group) => quoted(group.stream(), found),
            token => drop(found.insert(token.to_string())),
        }
        k += 1;
    }
}

/// Numbers of a drive are called like the effects that they are; a formula is an option and a key, too.
fn means_no_kind(name: &str, file: &Path) -> bool {
    let of_drives = ["settings/drives.rs", "scenario/motor.rs", "identify/elastic/"];
    let file = file.to_str().unwrap();
    match name {
        "rotor_inertia" | "viscous_friction" | "coulomb_friction" => {
            of_drives.iter().any(|f| file.contains(f))
        }
        "formula" => file.contains("src/commands/"),
        _ => false,
    }
}

/// A kind of effect is a statement of the library: whoever knows it by its name knows it twice.
#[test]
fn only_the_library_names_kinds_of_effects() {
    for folder in ["compiler", "runtime/core", "runtime/analysis", "macros", "."] {
        let mut files = Vec::new();
        sources(&root().join(folder).join("src"), &mut files);
        // Files of unit tests are named after what they hold.
        for file in files.iter().filter(|file| !file.ends_with("tests.rs") && !file.ends_with("support.rs")) {
            let mut found = Names::new();
            quoted(fs::read_to_string(file).unwrap().parse().unwrap(), &mut found);
            let kinds = bipedc_effects::effect::KINDS.iter().map(|kind| kind.name);
            let named: Vec<&str> = kinds
                .filter(|kind| found.contains(&format!("\"{kind}\"")) && !means_no_kind(kind, file))
                .collect();
            assert!(named.is_empty(), "{}: {named:?}", file.display());
        }
    }
}

/// The reader of imports sees what it must see.
#[test]
fn imports_are_read() {
    let text = "use crate::{a::b, c::{d, e}}; use super::super::f::g; fn x() { crate::h::i(); super::j::k(); }\n\
                #[cfg(test)] mod tests { use crate::l; } // crate::m\n fn y() { crate::n() }";
    let mut found = Names::new();
    named(text.parse().unwrap(), 2, &mut found);
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["a", "c", "f", "h", "n"]);
}
