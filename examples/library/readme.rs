//! The code blocks of README.md's library section against the files of a crate.
use std::path::Path;
use std::process::Command;

/// The blocks, in their order.
fn blocks() -> Vec<String> {
    let readme = include_str!("../../README.md");
    let section =
        readme.split("\n## ").find(|section| section.starts_with("The code\n")).expect("the section");
    section
        .split("```")
        .skip(1)
        .step_by(2)
        .map(|block| block.split_once('\n').unwrap().1.to_owned())
        .collect()
}

/// Places of the files: README.md's crate stands beside the repository, these stand in it.
fn here(text: &str) -> String {
    text.replace("\"../bipedc/", "\"../../../")
        .replace("path = \"tulip\"", "path = \"../../../generated/tulip\"")
}

/// Asserts that the crate in a folder consists of these blocks: those of `src/main.rs`, the end of `Cargo.toml`, `build.rs`.
pub fn prints(folder: &str, main: &[usize], manifest: usize, script: Option<usize>) {
    let blocks = blocks();
    let file = |name: &str| std::fs::read_to_string(Path::new(folder).join(name)).ok();
    let texts: Vec<String> = main.iter().map(|block| here(&blocks[*block])).collect();
    assert_eq!(file("src/main.rs").unwrap(), texts.join("\n"), "src/main.rs");
    let (found, printed) = (file("Cargo.toml").unwrap(), here(&blocks[manifest]));
    let dependencies = &found[found.find("[dependencies]").unwrap()..];
    assert_eq!(dependencies, printed, "Cargo.toml");
    assert_eq!(file("build.rs"), script.map(|block| here(&blocks[block])), "build.rs");
}

/// Runs the program: what the robot's weight must be.
pub fn runs(program: &str) {
    let output = Command::new(program).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "186.39 N carry 19.000 kg, 6 by 18\n");
}
