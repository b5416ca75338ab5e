//! The readers never panic: the fuzz targets' seeds, whole, truncated and mutated.
use bipedc_compiler::description::{check_report, init_text, parse};
use std::path::Path;

#[path = "../support/fuzz_diagnose.rs"]
mod fuzz_diagnose;
#[path = "../support/fuzz_evaluate.rs"]
mod fuzz_evaluate;
#[path = "../support/fuzz_gait.rs"]
mod fuzz_gait;
#[path = "../support/fuzz_inspect.rs"]
mod fuzz_inspect;
#[path = "../support/fuzz_inventory.rs"]
mod fuzz_inventory;

const ROBOT: &str = include_str!("../../robots/seven_link/robot.urdf");

/// Pieces that matter to the readers; mutations insert them.
const PIECES: [&str; 16] = [
    "<",
    ">",
    "/>",
    "\"",
    "nan",
    "-1e308",
    "0",
    "<origin",
    "</link>",
    "&#0;",
    "ä",
    "[",
    "]",
    "{",
    "=",
    "\n[[phase]]\n",
];

/// The file name and text of every seed.
fn seeds(folder: &str) -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(folder);
    let mut seeds: Vec<(String, String)> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap()))
        .collect();
    seeds.sort();
    assert!(seeds.len() >= 10);
    seeds
}

/// Reads a text as a URDF; what loads must get a description that loads.
fn read_urdf(text: &str) {
    let (urdf, toml) = (Path::new("robot.urdf"), Path::new("biped.toml"));
    let Ok((robot, _)) = parse(text, urdf, "", toml) else { return };
    let _ = check_report(&robot).to_string();
    let guess = init_text(text, urdf).unwrap();
    if let Err(errors) = parse(text, urdf, &guess, toml) {
        panic!("{text}\n{guess}\n{errors}");
    }
}

fn read_description(text: &str) {
    if let Ok((robot, _)) = parse(ROBOT, Path::new("robot.urdf"), text, Path::new("biped.toml")) {
        let _ = check_report(&robot).to_string();
    }
}

/// xorshift64*: the same mutations on every machine.
fn random(state: &mut u64, below: usize) -> usize {
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % below.max(1)
}

/// Deletes, doubles or inserts a piece somewhere.
fn mutate(text: &str, state: &mut u64) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    for _ in 0..=random(state, 3) {
        let at = random(state, letters.len() + 1);
        let end = (at + random(state, 40)).min(letters.len());
        match random(state, 3) {
            0 => drop(letters.drain(at..end)),
            1 => {
                let piece: Vec<char> = letters[at..end].to_vec();
                letters.splice(at..at, piece);
            }
            _ => drop(letters.splice(at..at, PIECES[random(state, PIECES.len())].chars())),
        }
    }
    letters.into_iter().collect()
}

fn run(folder: &str, read: impl Fn(&str)) {
    let mut state = 0x5EED;
    for (name, text) in seeds(folder) {
        println!("{name}");
        read(&text);
        let ends: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
        let step = (ends.len() / 60).max(1);
        ends.iter().step_by(step).for_each(|&end| read(&text[..end]));
        for _ in 0..60 {
            read(&mutate(&text, &mut state));
        }
    }
}

#[test]
fn urdf_seeds_never_panic() {
    run("urdf", read_urdf);
}

#[test]
fn description_seeds_never_panic() {
    run("description", read_description);
}

/// What is derived from them takes its time: a few mutations each.
fn run_few(folder: &str, mutations: usize, read: impl Fn(&str)) {
    let mut state = 0x5EED;
    for (name, text) in seeds(folder) {
        println!("{name}");
        read(&text);
        (0..mutations).for_each(|_| read(&mutate(&text, &mut state)));
    }
}

#[test]
fn nothing_that_is_derived_from_seeds_panics() {
    run_few("inspect", 2, fuzz_inspect::run);
}

#[test]
fn states_never_panic() {
    run_few("evaluate", 40, fuzz_evaluate::run);
}

/// Whatever a log's names are: what is proposed reads, and what is written is a log.
#[test]
#[ignore = "takes long"]
fn logs_of_others_never_panic() {
    let folder = crate::cli::scratch("corpus_inventory");
    run("inventory", |text| fuzz_inventory::run(text.as_bytes(), &folder));
}

#[test]
fn gaits_never_panic() {
    run_few("gait", 12, fuzz_gait::run);
}

#[test]
fn diagnosed_seeds_never_panic() {
    run_few("diagnose", 1, |text| fuzz_diagnose::run(text.as_bytes()));
}
