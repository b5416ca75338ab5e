//! Libraries of gaits by `bipedc gait optimise`: what is there is taken over, and goes on to the same bytes.
use crate::cli::{Run, bipedc, scratch, text};
use serde_json::Value;
use std::path::Path;

const SPEEDS: [&str; 4] = ["0.6", "0.62", "0.64", "0.66"];

/// The first speeds of all into a folder.
fn library(folder: &Path, count: usize, more: &[&str]) -> Run {
    let form = ["gait", "optimise", "robots/five_link", "--gait", "optimised", "--out", text(folder)];
    bipedc(&[&form[..], &["--speed"], &SPEEDS[..count], more].concat())
}

fn json(folder: &Path, count: usize, more: &[&str]) -> Value {
    library(folder, count, &[&["--json"], more].concat()).ok().json()
}

/// Which gaits were found by an earlier run.
fn taken_over(found: &Value) -> Vec<bool> {
    found["gaits"].as_array().unwrap().iter().map(|gait| gait["taken_over"].as_bool().unwrap()).collect()
}

/// The gaits without what depends on the clock and on who found them.
fn same(found: &Value) -> Value {
    let mut gaits = found["gaits"].clone();
    for gait in gaits.as_array_mut().unwrap() {
        for key in ["seconds", "search_seconds", "taken_over"] {
            assert!(gait.as_object_mut().unwrap().remove(key).is_some(), "{key}");
        }
    }
    gaits
}

/// All files of the speeds, and when they were written.
fn files(folder: &Path, speeds: &[&str]) -> Vec<(String, std::time::SystemTime)> {
    let places = speeds.iter().flat_map(|speed| [format!("{speed}.toml"), format!("searches/{speed}.txt")]);
    let read = |name: String| {
        let file = folder.join(name);
        let time = std::fs::metadata(&file).unwrap().modified().unwrap();
        (std::fs::read_to_string(file).unwrap(), time)
    };
    places.map(read).collect()
}

fn bytes(folder: &Path) -> Vec<String> {
    files(folder, &SPEEDS).into_iter().map(|(text, _)| text).collect()
}

/// Two of four speeds, then all four, against all four in one run.
#[test]
fn a_library_goes_on_to_the_same_bytes() {
    let (parts, whole) = (scratch("library-parts"), scratch("library-whole"));
    assert_eq!(taken_over(&json(&parts, 2, &[])), [false; 2]);
    let first = files(&parts, &SPEEDS[..2]);
    let rest = json(&parts, 4, &[]);
    assert_eq!(taken_over(&rest), [true, true, false, false]);
    assert_eq!(files(&parts, &SPEEDS[..2]), first, "files that were there are untouched");
    let uninterrupted = json(&whole, 4, &[]);
    assert_eq!(bytes(&parts), bytes(&whole));
    assert_eq!(same(&rest), same(&uninterrupted));
    let again = library(&parts, 4, &[]).ok();
    assert_eq!(again.out.matches("taken over").count(), 4, "{}", again.out);
    // A search whose end was lost, here by damage, is made anew, and so is nothing else.
    let search = parts.join("searches/0.62.txt");
    let kept = std::fs::read_to_string(&search).unwrap();
    std::fs::write(&search, &kept[..kept.len() / 2]).unwrap();
    assert_eq!(taken_over(&json(&parts, 4, &[])), [true, false, true, true]);
    assert_eq!(bytes(&parts), bytes(&whole));
    // Another request takes over nothing.
    assert_eq!(taken_over(&json(&parts, 2, &["--friction", "0.55"])), [false; 2]);
}

/// What somebody wrote into a gait of a library is neither taken over as found nor written over.
#[test]
fn a_gait_of_a_library_that_was_changed_is_left_alone() {
    let folder = scratch("library-changed");
    library(&folder, 2, &[]).ok();
    let file = folder.join("0.62.toml");
    let found = std::fs::read_to_string(&file).unwrap();
    let (head, rest) = found.split_once("[[phase]]").unwrap();
    let changed = format!("{head}# by hand\n[[phase]]{rest}");
    let cut_off = &found[..found.len() - 20];
    for other in [changed.as_str(), cut_off] {
        std::fs::write(&file, other).unwrap();
        let told =
            library(&folder, 2, &[]).fails_with(&["0.62.toml", "changed since, or cut off", "move it away"]);
        assert!(told.err.contains("help: "), "{}", told.err);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), other);
    }
    // Another request would write it anew: not over what nobody found.
    std::fs::write(&file, "# mine\n").unwrap();
    library(&folder, 2, &[]).fails_with(&["0.62.toml", "help: "]);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "# mine\n");
    std::fs::remove_file(&file).unwrap();
    assert_eq!(taken_over(&json(&folder, 2, &[])), [true, false]);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), found);
}
