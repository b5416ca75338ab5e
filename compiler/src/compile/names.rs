//! Names that Rust takes, for whatever a URDF calls its parts.
use std::collections::HashSet;

/// The same names, told apart by a number where two links `a-b` and `a_b` became one identifier.
pub fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = HashSet::new();
    names
        .map(|name| {
            let numbered = (2..).map(|k| format!("{name}_{k}"));
            let free = std::iter::once(name.clone()).chain(numbered).find(|n| seen.insert(n.clone()));
            free.unwrap_or(name)
        })
        .collect()
}

/// The same for functions, which bring a second one, `NAME_into`, and the program behind both, in parts where it is long: a
/// link `sole_into` must not meet what belongs to the link `sole`.
pub(super) fn distinct_functions(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = HashSet::new();
    let own = |name: &str| ["", "_into", "_program"].map(|end| format!("{name}{end}"));
    names
        .map(|name| {
            let numbered = (2..).map(|k| format!("{name}_{k}"));
            let mut candidates = std::iter::once(name.clone()).chain(numbered);
            let is_part =
                |n: &str| n.rsplit_once("_part_").is_some_and(|(_, k)| k.bytes().all(|b| b.is_ascii_digit()));
            let free = candidates.find(|n| !is_part(n) && own(n).iter().all(|n| !seen.contains(n)));
            let free = free.unwrap_or(name);
            seen.extend(own(&free));
            free
        })
        .collect()
}

/// A Rust identifier for a link, contact point or joint name.
pub fn identifier(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        let c = if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
        if c != '_' || !out.ends_with('_') {
            out.push(c);
        }
    }
    if out.is_empty() || out.starts_with(|c: char| c.is_ascii_digit()) {
        out.insert(0, '_');
    }
    out
}

/// Names that no crate or module of a robot can have: those of the language, of its libraries, of folders of Cargo's, and
/// of the crates that the emitted code itself stands on.
const TAKEN: &str = "abstract alloc as async await become bipedc bipedc_compiler bipedc_macros bipedc_runtime box break \
    build const continue core crate deps do dyn else enum examples extern false final fn for gen if impl \
    in incremental let loop macro match mod move mut nalgebra override priv proc_macro pub ref return \
    self static std struct super test trait true try type typeof unsafe unsized use virtual where while \
    yield";

/// The name of a robot's crate, module and file: begins with a letter and is nobody else's.
pub fn crate_name(robot: &str) -> String {
    let name = identifier(robot);
    let name = name.trim_start_matches('_');
    if name.is_empty() {
        return "robot".to_owned();
    }
    if name.starts_with(|c: char| c.is_ascii_digit()) || TAKEN.split(' ').any(|taken| taken == name) {
        return format!("robot_{name}");
    }
    name.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_become_one_identifier_are_told_apart() {
        let names = ["a-b", "a_b", "A b", "c"].iter().map(|name| identifier(name));
        assert_eq!(distinct(names), ["a_b", "a_b_2", "a_b_3", "c"]);
    }

    #[test]
    fn functions_in_place_are_told_apart_too() {
        let names = ["of_a", "of_a_into", "of_b_into", "of_b", "of_a", "of_a_part_0"].map(str::to_owned);
        let expected = ["of_a", "of_a_into_2", "of_b_into", "of_b_2", "of_a_2", "of_a_part_0_2"];
        assert_eq!(distinct_functions(names.into_iter()), expected);
    }

    #[test]
    fn crates_have_names_that_rust_takes() {
        let names =
            ["tulip_v1_leg", "2dof", "3-RRR", "日本", "_", "Übung", "", "self", "Core", "bipedc_runtime"];
        let expected = [
            "tulip_v1_leg",
            "robot_2dof",
            "robot_3_rrr",
            "robot",
            "robot",
            "bung",
            "robot",
            "robot_self",
            "robot_core",
            "robot_bipedc_runtime",
        ];
        assert_eq!(names.map(crate_name), expected);
    }
}
