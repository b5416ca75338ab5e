//! Every command that README prints runs as printed, on robots and logs with the names that it uses.
use crate::cli::{run, scratch};
use crate::support::project;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Blocks of commands, line by line without what is said of them.
fn commands() -> Vec<String> {
    let readme = fs::read_to_string(project().join("README.md")).unwrap();
    let blocks = readme.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let lines = blocks.flat_map(str::lines).map(|line| line.split(" #").next().unwrap().trim().to_owned());
    lines.filter(|line| line.starts_with("bipedc ")).collect()
}

/// An example log under other joint names.
fn example(name: &str, rename: &[(&str, &str)], to: &Path) {
    let path = project().join("tests/data/examples").join(name).with_extension("csv.gz");
    let mut log = String::new();
    flate2::read::GzDecoder::new(fs::File::open(path).unwrap()).read_to_string(&mut log).unwrap();
    fs::write(to, renamed(&log, rename)).unwrap();
}

fn renamed(text: &str, rename: &[(&str, &str)]) -> String {
    rename.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

/// `my_robot`: TUlip, whose knees are called as README calls them, its logs and tables.
fn walker() -> PathBuf {
    const KNEES: [(&str, &str); 2] = [("left_knee_pitch", "left_knee"), ("right_knee_pitch", "right_knee")];
    let folder = scratch("readme_walker");
    fs::create_dir_all(folder.join("my_robot")).unwrap();
    let urdf = fs::read_to_string(project().join("robots/tulip/robot.urdf")).unwrap();
    fs::write(folder.join("my_robot/robot.urdf"), renamed(&urdf, &KNEES)).unwrap();
    example("coulomb/train", &KNEES, &folder.join("log.csv"));
    example("coulomb/validation", &KNEES, &folder.join("other.csv"));
    example("postures/train", &KNEES, &folder.join("measured.csv"));
    fs::write(folder.join("states.json"), r#"[{}, {"position": {"left_knee": 0.3}}]"#).unwrap();
    let stand = "duration = 0.2\n[control]\nstiffness = 800.0\ndamping = 8.0\n[ground]\nfriction = 0.8\n";
    fs::write(folder.join("stand.toml"), stand).unwrap();
    folder
}

/// `my_leg`: a leg with series elastic drives, and its log.
fn leg() -> PathBuf {
    let folder = scratch("readme_leg");
    fs::create_dir_all(folder.join("my_leg")).unwrap();
    for file in ["robot.urdf", "biped.toml"] {
        fs::copy(project().join("robots/tulip_v1_leg").join(file), folder.join("my_leg").join(file)).unwrap();
    }
    example("elastic_leg/train", &[], &folder.join("log.csv"));
    folder
}

/// The robots of this repository.
fn own() -> PathBuf {
    let folder = scratch("readme_own");
    let link = folder.join("robots");
    if !link.exists() {
        std::os::unix::fs::symlink(project().join("robots"), link).unwrap();
    }
    folder
}

fn runs(line: &str, folder: &Path) {
    let (line, output) = line.split_once(" > ").map_or((line, None), |(line, file)| (line, Some(file)));
    let mut command = Command::new(env!("CARGO_BIN_EXE_bipedc"));
    command.args(line.split_whitespace().skip(1)).current_dir(folder).stdin(Stdio::null());
    let done = run(&mut command);
    assert_eq!(done.code, Some(0), "{line}\n{}{}", done.out, done.err);
    if let Some(file) = output {
        fs::write(folder.join(file), done.out).unwrap();
    }
}

#[test]
#[ignore = "takes long"]
fn every_command_runs_as_printed() {
    let (walker, leg, own) = (walker(), leg(), own());
    let mut counts = [0; 4];
    for line in commands() {
        println!("{line}");
        let place = ["my_robot", "my_leg", "robots/", "xl330"].iter().position(|name| line.contains(name));
        match place {
            Some(0) => runs(&line, &walker),
            Some(1) => runs(&line, &leg),
            Some(2) => runs(&line, &own),
            // Other people's data: docs/real-data.md has a test of its own.
            Some(3) => {}
            // `history` of the servo, and what names no robot.
            _ => assert!(line.starts_with("bipedc completions"), "nobody knows where to run: {line}"),
        }
        counts[place.unwrap_or(3)] += 1;
    }
    assert!(counts[0] >= 16 && counts[1] >= 1 && counts[2] >= 2, "{counts:?}");
}
