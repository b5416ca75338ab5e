//! Every command that README prints runs as printed, on robots and logs with the names that it uses.
use crate::cli::{Run, run, scratch};
use crate::real_data::{measurements, servo};
use crate::support::project;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// How long motions are searched for, s.
const SEARCHED: usize = 10;

fn readme() -> String {
    fs::read_to_string(project().join("README.md")).unwrap()
}

/// The pages speak of as many logs as the scoreboard has: three of them had three other numbers.
#[test]
fn pages_agree_with_the_scoreboard() {
    let page = |name: &str| fs::read_to_string(project().join("docs").join(name)).unwrap();
    let (board, diagnosis) = (page("scoreboard.md"), page("diagnosis.md"));
    let told = |after: &str| {
        let rest = board.split(after).nth(1).unwrap_or_else(|| panic!("no `{after}` on the scoreboard"));
        rest.split(['(', ',', '\n']).next().unwrap().trim().to_owned()
    };
    let spurious = told("- spurious effects: ");
    let cases = spurious.split(' ').nth(2).unwrap();
    assert!(readme().contains(&format!("right on {cases} logs")), "README.md: {cases}");
    let rows = [
        format!("scoreboard.md) scores {cases} simulated robots"),
        format!("| kind, place and parameters right | {} (", told("kind, place and parameters right: ")),
        format!("| spurious effects | {spurious} |"),
        format!("| clean logs without a claim | {} |", told("without a claim (wanted: all): ")),
        format!(
            "| error at most 1.1 times the true model's | {} (",
            told("held-out error at most 1.1 times that of the true model: ")
        ),
    ];
    for row in rows {
        assert!(diagnosis.contains(&row), "docs/diagnosis.md has no `{row}`");
    }
}

/// Blocks of commands of a program, line by line without what is said of them.
fn commands(program: &str) -> Vec<String> {
    let readme = readme();
    let blocks = readme.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let lines = blocks.flat_map(str::lines).map(|line| line.split(" #").next().unwrap().trim().to_owned());
    lines.filter(|line| line.split(' ').next() == Some(program)).collect()
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

/// `xl330`: the pendulum and nothing of the servo, with what other people measured on it; none where that is not there.
fn pendulum() -> Option<PathBuf> {
    let data = measurements()?;
    let folder = scratch("readme_servo");
    fs::create_dir_all(folder.join("xl330")).unwrap();
    fs::write(folder.join("xl330/robot.urdf"), servo::URDF).unwrap();
    fs::write(folder.join("xl330/biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    servo::write_logs(&data, [&folder.join("swing.csv"), &folder.join("lift.csv")]).unwrap();
    Some(folder)
}

/// What the line prints, unless it goes into a file.
fn runs(line: &str, folder: &Path) -> String {
    let (line, output) = line.split_once(" > ").map_or((line, None), |(line, file)| (line, Some(file)));
    let mut command = Command::new(env!("CARGO_BIN_EXE_bipedc"));
    command.args(line.split_whitespace().skip(1)).current_dir(folder).stdin(Stdio::null());
    let done = if line.contains(" excite ") { interrupted(&mut command) } else { run(&mut command) };
    assert_eq!(done.code, Some(0), "{line}\n{}{}", done.out, done.err);
    let Some(file) = output else { return done.out };
    fs::write(folder.join(file), done.out).unwrap();
    String::new()
}

/// A search for motions takes minutes; stopped, it writes the best so far. Ctrl-C (INT) is ignored by what a shell starts in the background,
/// such as these tests.
fn interrupted(command: &mut Command) -> Run {
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let process = child.id().to_string();
    std::thread::scope(|scope| {
        let waiting = scope.spawn(|| child.wait_with_output().unwrap());
        for _ in 0..SEARCHED {
            std::thread::sleep(Duration::from_secs(1));
            if waiting.is_finished() {
                break;
            }
        }
        if !waiting.is_finished() {
            let _ = Command::new("kill").args(["-TERM", &process]).stderr(Stdio::null()).status();
        }
        let output = waiting.join().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    })
}

#[test]
#[ignore = "takes long"]
fn every_command_runs_as_printed() {
    let (walker, leg, own) = (walker(), leg(), own());
    let mut counts = [0; 4];
    for line in commands("bipedc") {
        println!("{line}");
        let place = ["my_robot", "my_leg", "robots/", "xl330"].iter().position(|name| line.contains(name));
        match place {
            Some(0) => drop(runs(&line, &walker)),
            Some(1) => drop(runs(&line, &leg)),
            Some(2) => drop(runs(&line, &own)),
            // Other people's data: the next test.
            Some(3) => {}
            _ => assert!(line.starts_with("bipedc completions"), "nobody knows where to run: {line}"),
        }
        counts[place.unwrap_or(3)] += 1;
    }
    assert!(counts[0] >= 16 && counts[1] >= 1 && counts[2] >= 2, "{counts:?}");
}

/// Cargo builds and passes on what stands behind `--`: run in this project as printed. Its tests are these; it installs what it builds.
#[test]
#[ignore = "takes long"]
fn the_lines_of_cargo_do_what_they_promise() {
    let mut jobs = 0;
    for line in commands("cargo") {
        match line.strip_prefix("cargo run --release -- ") {
            Some(arguments) => {
                let printed = runs(&format!("bipedc {arguments}"), &project());
                assert!(printed.contains("Held-out error"), "{line}\n{printed}");
                jobs += 1;
            }
            None => assert!(
                ["cargo test --workspace", "cargo install --path ."].contains(&line.as_str()),
                "nobody runs this: {line}"
            ),
        }
    }
    assert_eq!(jobs, 1);
    let manifest = fs::read_to_string(project().join("Cargo.toml")).unwrap();
    let checks = fs::read_to_string(project().join(".ci/run")).unwrap();
    assert!(manifest.contains("\nname = \"bipedc\"\n") && checks.contains("\ncargo test --workspace\n"));
}

/// As `bipedc compare` has them in its table, in README's words: the error of the only joint, and its part of the torque.
fn compared(table: &str) -> String {
    let row = table.lines().find(|line| line.starts_with("joint") && line.contains('%')).unwrap();
    let fields: Vec<&str> = row.split_whitespace().collect();
    let percent = fields.iter().position(|field| *field == "%").unwrap();
    let part: f64 = fields[percent - 1].parse().unwrap();
    format!("rms {} {} {}, {part:.0} % of the torque", fields[1], fields[2], fields[3])
}

/// A picture without the dates of its steps.
fn undated(svg: &str) -> String {
    let mut parts = svg.split("(step ");
    let rest = |part: &str| part.split_once(')').map_or(String::new(), |(_, rest)| rest.to_owned());
    parts.next().unwrap_or_default().to_owned() + &parts.map(rest).collect::<String>()
}

/// What README says beside and below the commands, and its picture, are what they print.
#[test]
fn the_servo_is_as_printed() {
    let Some(folder) = pendulum() else { return };
    let readme = readme();
    let begin = readme.find("```sh\nbipedc compare  xl330").unwrap();
    let mut blocks = readme[begin..].split("```");
    let (lines, shown) = (blocks.nth(1).unwrap(), blocks.nth(1).unwrap());
    let mut figures = 0;
    for line in lines.lines().skip(1) {
        let (command, said) = line.split_once('#').unwrap_or((line, ""));
        let printed = runs(command.trim(), &folder);
        if !said.is_empty() {
            figures += 1;
            assert!(compared(&printed).starts_with(said.trim()), "{line}\n{printed}");
        }
    }
    assert_eq!(figures, 2);
    let answer = fs::read_to_string(folder.join("diagnosis.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    // README breaks lines elsewhere, and leaves parts out.
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let summary = words(answer["summary"].as_str().unwrap());
    let shown = words(shown);
    assert!(shown.len() > 200);
    for part in shown.split('…') {
        assert!(summary.contains(part.trim()), "no `{part}` in {summary}");
    }
    let drawn = fs::read_to_string(folder.join("staircase.svg")).unwrap();
    let picture = fs::read_to_string(project().join("docs/servo.svg")).unwrap();
    assert_eq!(undated(&drawn), undated(&picture));
}
