//! Where results go: never onto what was read, whole or not at all, and through links, pipes and devices as they are.
use super::STAND;
use super::cli::{Run, bipedc, command, scratch, text};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A robot with a mesh, a scenario with a trajectory, a log and a mapping file, under the names that the tests give.
fn arm(name: &str) -> PathBuf {
    let folder = scratch(name);
    for file in ["robot.urdf", "biped.toml"] {
        fs::copy(Path::new("robots/five_link").join(file), folder.join(file)).unwrap();
    }
    let urdf = fs::read_to_string(folder.join("robot.urdf")).unwrap();
    let mesh = "<visual><geometry><mesh filename=\"shin.stl\"/></geometry></visual></link>";
    fs::write(folder.join("robot.urdf"), urdf.replacen("</link>", mesh, 1)).unwrap();
    let moves = "[control]\nstiffness = 300.0\ndamping = 5.0\ntrajectory = \"moves.csv\"\n";
    let files = [
        ("swing.toml", format!("duration = 0.05\n{moves}")),
        ("moves.csv", "time,left_knee_pitch/position\n0,0.1\n1,0.2\n".to_owned()),
        ("shin.stl", "solid\nendsolid\n".to_owned()),
        ("log.csv", "time,left_knee_pitch/position\n0,0.1\n1,0.2\n".to_owned()),
        ("columns.toml", "time = \"time\"\n".to_owned()),
    ];
    for (file, content) in files {
        fs::write(folder.join(file), content).unwrap();
    }
    folder
}

/// Every file with its content; links by where they lead.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        match fs::read_link(&path) {
            Ok(to) => drop(all.insert(path, to.into_os_string().into_encoded_bytes())),
            Err(_) if path.is_dir() => all.append(&mut contents(&path)),
            Err(_) => drop(all.insert(path.clone(), fs::read(&path).unwrap())),
        }
    }
    all
}

/// Runs with `@` for the folder, and demands that it is refused and nothing changed.
fn refused(folder: &Path, arguments: &str, words: &[&str]) {
    let before = contents(folder);
    let arguments = arguments.replace('@', text(folder));
    bipedc(&arguments.split_whitespace().collect::<Vec<_>>()).fails_with(words);
    assert!(before == contents(folder), "{arguments} changed a file");
}

/// Simulates the arm; `@` is its folder.
fn simulate(folder: &Path, out: &str, more: &[&str]) -> Run {
    let out = out.replace('@', text(folder));
    let scenario = folder.join("swing.toml");
    let fixed = ["simulate", text(folder), "--base", "fixed", "--scenario", text(&scenario), "--out", &out];
    bipedc(&[&fixed, more].concat())
}

fn leftovers(folder: &Path) -> Vec<PathBuf> {
    contents(folder).into_keys().filter(|path| text(path).ends_with("-tmp")).collect()
}

#[test]
fn a_simulation_overwrites_nothing_that_it_reads() {
    let folder = arm("outputs_simulate");
    symlink("robot.urdf", folder.join("link.csv")).unwrap();
    fs::hard_link(folder.join("swing.toml"), folder.join("hard.csv")).unwrap();
    fs::create_dir(folder.join("pictures")).unwrap();
    symlink("../biped.toml", folder.join("pictures/side.svg")).unwrap();
    let run = "simulate @ --base fixed --scenario @/swing.toml";
    for (options, words) in [
        ("--out @/robot.urdf", ["--out would overwrite the robot's URDF", "robot.urdf"]),
        ("--out @/pictures/../biped.toml", ["the robot's description", "biped.toml"]),
        ("--out @/link.csv", ["the robot's URDF", "link.csv"]),
        ("--out @/hard.csv", ["the scenario", "hard.csv"]),
        ("--out @/moves.csv", ["the scenario's trajectory", "moves.csv"]),
        ("--out @/shin.stl", ["a mesh of the robot", "shin.stl"]),
        ("--out @/history.json", ["the description's history", "history.json"]),
        ("--out @/run.csv --truth @/swing.toml", ["--truth would overwrite the scenario", "swing.toml"]),
        ("--out @/run.csv --truth @/./run.csv", ["--truth and --out name the same file", "run.csv"]),
        ("--out @/run.csv --report @/pictures/../run.csv", ["--report and --out name", "run.csv"]),
        ("--out @/run.csv --svg @/pictures", ["--svg might overwrite the robot's description", "pictures"]),
        ("--out @/front.svg --svg @", ["--svg might overwrite --out", "folder of its own"]),
        ("--out @/run.csv --svg @/log.csv", ["--svg takes a folder, this is a file", "log.csv"]),
        ("--out @/pictures", ["this is a folder", "give the name of a file"]),
        ("--out @/new/", ["this is a folder", "new/"]),
        ("--out @/nowhere/run.csv", ["cannot write the file", "nowhere/run.csv"]),
        ("--out @/log.csv/run.csv", ["cannot write the file", "log.csv/run.csv"]),
    ] {
        refused(&folder, &format!("{run} {options}"), &words);
    }
}

#[test]
fn no_other_command_does() {
    let folder = arm("outputs_others");
    fs::hard_link(folder.join("robot.urdf"), folder.join("other.urdf")).unwrap();
    fs::create_dir_all(folder.join("crate/src")).unwrap();
    fs::write(folder.join("crate/Cargo.toml"), "# @generated by bipedc\n").unwrap();
    symlink("../../robot.urdf", folder.join("crate/src/lib.rs")).unwrap();
    fs::create_dir(folder.join("twin")).unwrap();
    fs::copy(folder.join("robot.urdf"), folder.join("twin/robot.urdf")).unwrap();
    symlink("robot.urdf", folder.join("twin/biped.toml")).unwrap();
    for (arguments, words) in [
        ("compare @ @/log.csv --report @/log.csv", ["--report would overwrite the log", "log.csv"]),
        (
            "compare @ @/log.csv --mapping @/columns.toml --report @/columns.toml",
            ["the mapping file", "columns.toml"],
        ),
        (
            "diagnose @ @/log.csv --validate @/moves.csv --report @/moves.csv",
            ["the log of --validate", "moves.csv"],
        ),
        (
            "diagnose @ @/log.csv --report @/biped.toml",
            ["--report would overwrite the robot's", "biped.toml"],
        ),
        ("identify @ @/log.csv --write-urdf @/log.csv", ["--write-urdf would overwrite a log", "log.csv"]),
        ("identify @ @/log.csv --write-urdf @/other.urdf", ["the robot's URDF", "other.urdf"]),
        ("identify @ @/log.csv --write-urdf @/new --report @/new", ["--report and --write-urdf name", "new"]),
        (
            "excite @ --base fixed --out @/robot.urdf",
            ["--out would overwrite the robot's URDF", "robot.urdf"],
        ),
        ("excite @ --postures 20 --out @/p --plot @/p", ["--plot and --out name the same file", "p"]),
        ("history @ --svg @/biped.toml", ["--svg would overwrite the robot's description", "biped.toml"]),
        ("history @ --report @/history.json", ["the description's history", "history.json"]),
        ("history @ --report @/robot.urdf", ["the robot's URDF", "robot.urdf"]),
        ("init @/twin/robot.urdf --force", ["would overwrite the URDF", "biped.toml"]),
        ("generate @ --out @/crate", ["`src/lib.rs` would overwrite the robot's URDF", "lib.rs"]),
        ("generate @ --out @/log.csv", ["a crate needs a folder", "--out"]),
    ] {
        refused(&folder, arguments, &words);
    }
}

#[test]
fn links_are_followed_and_permissions_kept() {
    let folder = arm("outputs_links");
    fs::create_dir(folder.join("kept")).unwrap();
    fs::write(folder.join("kept/run.csv"), "old").unwrap();
    fs::set_permissions(folder.join("kept/run.csv"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("kept/run.csv", folder.join("latest.csv")).unwrap();
    symlink("kept/new.csv", folder.join("dangling.csv")).unwrap();
    for (link, file) in [("latest.csv", "kept/run.csv"), ("dangling.csv", "kept/new.csv")] {
        simulate(&folder, &format!("@/{link}"), &[]).ok();
        assert!(folder.join(link).symlink_metadata().unwrap().is_symlink(), "{link} was replaced");
        assert!(fs::read_to_string(folder.join(file)).unwrap().starts_with("time,"), "{file}");
    }
    assert_eq!(fs::metadata(folder.join("kept/run.csv")).unwrap().permissions().mode() & 0o777, 0o640);
    fs::set_permissions(folder.join("kept/run.csv"), fs::Permissions::from_mode(0o440)).unwrap();
    simulate(&folder, "@/latest.csv", &[]).fails_with(&["read-only", "nothing was changed"]);
    assert!(leftovers(&folder).is_empty());
}

#[test]
fn devices_and_pipes_are_written_directly() {
    let folder = arm("outputs_devices");
    simulate(&folder, "@/run.csv", &[]).ok();
    let whole = fs::read_to_string(folder.join("run.csv")).unwrap();
    // Words go elsewhere, so that the log can be piped on.
    let run = simulate(&folder, "/dev/stdout", &[]).ok();
    assert!(run.out == whole && run.err.contains("rows in /dev/stdout"), "{}", run.err);
    let run = simulate(&folder, "/dev/stderr", &["--json"]).ok();
    assert!(run.err == whole && run.json()["rows"].is_number());
    simulate(&folder, "/dev/null", &[]).ok();
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    simulate(&folder, "/dev/full", &[]).fails_with(&["No space left", "--> /dev/full", "make room"]);

    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = Command::new("cat").arg(&pipe).stdout(Stdio::piped()).spawn().unwrap();
    simulate(&folder, "@/pipe", &[]).ok();
    assert!(reader.wait_with_output().unwrap().stdout == whole.as_bytes());
    assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
    fs::remove_file(pipe).unwrap();

    // Into a file of the shell: the log begins where the shell's text ends. By its name, both would be mixed.
    let printed = folder.join("printed.csv");
    let shell = |out: &str| {
        let words =
            "echo title; exec \"$0\" simulate \"$1\" --base fixed --scenario \"$1/swing.toml\" --out \"$2\"";
        let mut command = Command::new("sh");
        command.args(["-c", words, env!("CARGO_BIN_EXE_bipedc"), text(&folder), out]);
        command.stdout(fs::File::create(&printed).unwrap()).output().unwrap().status.code()
    };
    assert_eq!(shell("/dev/stdout"), Some(0));
    assert_eq!(fs::read_to_string(&printed).unwrap(), format!("title\n{whole}"));
    assert_eq!(shell(text(&printed)), Some(1));
    assert_eq!(fs::read_to_string(&printed).unwrap(), "title\n");
    assert!(leftovers(&folder).is_empty());
}

#[test]
fn a_log_that_does_not_fit_leaves_the_old_one_and_is_named() {
    let folder = arm("outputs_full");
    fs::write(folder.join("run.csv"), "old").unwrap();
    // Eight blocks of at most a kilobyte; the log needs more.
    let script = "ulimit -f 8; exec \"$0\" \"$@\"";
    let (scenario, out) = (folder.join("swing.toml"), folder.join("run.csv"));
    let run = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_bipedc"), "simulate", text(&folder), "--base", "fixed"])
        .args(["--scenario", text(&scenario), "--out", text(&out)])
        .output()
        .unwrap();
    let err = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{err}");
    assert!(
        err.contains("File too large") && err.contains("run.csv") && !err.contains("swing.toml"),
        "{err}"
    );
    assert_eq!(fs::read_to_string(out).unwrap(), "old");
    assert!(leftovers(&folder).is_empty());
}

#[test]
fn interrupted_twice_it_ends_at_once_and_leaves_nothing() {
    let folder = arm("outputs_interrupted");
    fs::write(folder.join("swing.toml"), STAND.replace("0.4", "100000.0")).unwrap();
    let (scenario, out) = (folder.join("swing.toml"), folder.join("run.csv"));
    let mut run = command(&["simulate", text(&folder), "--scenario", text(&scenario), "--out", text(&out)]);
    let mut child = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    assert!(super::grows(&folder), "no temporary file");
    for _ in 0..2 {
        // The second one finds it at work still, or done.
        let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).stderr(Stdio::null()).status();
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(leftovers(&folder).is_empty());
}
