//! What amending and taking back do to files: unusual ones, those edited by hand, interruptions, damage.
use super::{JOINT, files, friction, read, robot};
use crate::cli::{self, bipedc, text};
use serde_json::{Value, json};

#[test]
fn line_ends_of_windows_are_kept() {
    let folder = robot("amend_crlf");
    let windows = read(&folder, "biped.toml").replace('\n', "\r\n");
    std::fs::write(folder.join("biped.toml"), &windows).unwrap();
    friction(&folder, "0.43", &[]).ok();
    let after = read(&folder, "biped.toml");
    assert!(after.starts_with(&windows));
    assert_eq!(after.matches('\n').count(), after.matches("\r\n").count());
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert_eq!(read(&folder, "biped.toml"), windows);
}

/// A byte order mark, no line end at the end of the file, and an effect that was written by hand.
#[test]
fn unusual_files_are_amended_exactly() {
    let folder = robot("amend_unusual_files");
    let plain = read(&folder, "biped.toml");
    let by_hand =
        "\n  [[effect]] # mine\n  joint='left_knee_pitch'\n  torque = 1 # guessed\n  kind='coulomb_friction'";
    for mark in ["", "\u{feff}"] {
        let text_of = format!("{mark}{plain}{by_hand}");
        std::fs::write(folder.join("biped.toml"), &text_of).unwrap();
        friction(&folder, "0.25", &[]).ok();
        let after = read(&folder, "biped.toml");
        let (head, tail) = after.split_at(text_of.find("  [[effect]]").unwrap());
        assert_eq!(head, &text_of[..head.len()]);
        let (comment, tail) = tail.split_once('\n').unwrap();
        assert!(comment.starts_with("# bipedc amend, "), "{comment}");
        assert_eq!(tail, text_of[head.len()..].replace("torque = 1", "torque = 0.25"));
        bipedc(&["amend", text(&folder), "--undo"]).ok();
        assert_eq!(read(&folder, "biped.toml"), text_of);
    }
}

#[test]
fn a_file_edited_by_hand_is_not_overwritten() {
    let folder = robot("amend_edited");
    let before = read(&folder, "biped.toml");
    friction(&folder, "0.43", &[]).ok();
    let edited = read(&folder, "biped.toml") + "# precious\n";
    std::fs::write(folder.join("biped.toml"), &edited).unwrap();
    let words = ["edited since step 1", "# precious", "--force"];
    bipedc(&["amend", text(&folder), "--undo"]).fails_with(&words);
    assert_eq!(read(&folder, "biped.toml"), edited);
    let history = bipedc(&["history", text(&folder)]).ok();
    assert!(history.out.contains("edited by hand since step 1"), "{}", history.out);
    let run = bipedc(&["amend", text(&folder), "--undo", "--force"]).ok();
    assert!(run.out.contains("biped.edited.toml"), "{}", run.out);
    assert_eq!(read(&folder, "biped.toml"), before);
    assert_eq!(read(&folder, "biped.edited.toml"), edited);
}

#[test]
fn amending_goes_on_after_an_edit_by_hand() {
    let folder = robot("amend_after_edit");
    friction(&folder, "0.43", &[]).ok();
    let edited = read(&folder, "biped.toml") + "# precious\n";
    std::fs::write(folder.join("biped.toml"), &edited).unwrap();
    let run = friction(&folder, "0.5", &[]).ok();
    assert!(run.out.contains("edited by hand since step 1"), "{}", run.out);
    let history = bipedc(&["history", text(&folder)]).ok();
    assert!(history.out.contains("between steps 1 and 2"), "{}", history.out);
    bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert_eq!(read(&folder, "biped.toml"), edited);
    bipedc(&["amend", text(&folder), "--undo"]).fails_with(&["edited since step 1"]);
}

/// What lies on the disk when a process dies between its two renames: a step in the history that the description
/// does not have yet (amending) or no longer (taking back), and perhaps a temporary.
#[test]
fn an_interruption_is_seen_and_put_right() {
    let folder = robot("amend_interrupted");
    let before = read(&folder, "biped.toml");
    friction(&folder, "0.43", &[]).ok();
    std::fs::write(folder.join("biped.toml"), &before).unwrap();
    for left in [".biped.toml.1-0.bipedc-tmp", ".history.json.4194304-1.bipedc-tmp"] {
        std::fs::write(folder.join(left), "half of a").unwrap();
    }
    let history = bipedc(&["history", text(&folder)]).ok();
    assert!(history.out.contains("step 1 is not in the description"), "{}", history.out);
    assert_eq!(bipedc(&["history", text(&folder), "--json"]).ok().json()["state"], "last_step_missing");

    let run = friction(&folder, "0.5", &[]).ok();
    assert!(
        run.out.contains("step 1 is not in the description") && run.out.contains("step 2"),
        "{}",
        run.out
    );
    let steps = bipedc(&["history", text(&folder), "--json"]).ok().json()["steps"].clone();
    assert!(steps[0]["undone"].is_string() && steps[1]["undone"].is_null(), "{steps}");

    std::fs::write(folder.join("biped.toml"), &before).unwrap();
    let run = bipedc(&["amend", text(&folder), "--undo"]).ok();
    assert!(run.out.contains("is as before step 2"), "{}", run.out);
    assert_eq!(bipedc(&["history", text(&folder), "--json"]).ok().json()["state"], "agrees");
    assert_eq!(read(&folder, "biped.toml"), before);
    assert_eq!(files(&folder), ["biped.toml", "history.json", "robot.urdf"]);
}

/// Killed at any moment, amending and taking back leave a description that reads and a history that knows it.
#[cfg(unix)]
#[test]
#[ignore = "takes long"]
fn killing_it_at_any_moment_does_no_harm() {
    let folder = robot("amend_killed");
    let before = read(&folder, "biped.toml");
    for round in 0..40_u64 {
        let set = format!("torque=0.{}", round + 1);
        let amend = ["amend", text(&folder), "--effect", "coulomb_friction", "--joint", JOINT, "--set", &set];
        let undo = ["amend", text(&folder), "--undo"];
        let mut child = cli::command(if round % 3 == 2 { &undo } else { &amend })
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_micros(250 * round));
        child.kill().unwrap();
        child.wait().unwrap();
        let state = bipedc(&["history", text(&folder), "--json"]).ok().json()["state"].clone();
        assert!(state == "agrees" || state == "last_step_missing", "round {round}: {state}");
        bipedc(&["check", text(&folder)]).ok();
    }
    while bipedc(&["amend", text(&folder), "--undo"]).code == Some(0) {}
    assert_eq!(read(&folder, "biped.toml"), before);
}

#[cfg(unix)]
#[test]
fn read_only_files_and_folders_are_left_alone() {
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::PermissionsExt;
    let folder = robot("amend_read_only");
    let before = read(&folder, "biped.toml");
    for path in [folder.join("biped.toml"), folder.clone()] {
        let writable = std::fs::metadata(&path).unwrap().permissions();
        set_permissions(&path, Permissions::from_mode(writable.mode() & !0o222)).unwrap();
        let run = friction(&folder, "1", &[]);
        set_permissions(&path, writable).unwrap();
        run.fails_with(&["read-only", "nothing was changed"]);
        assert_eq!(read(&folder, "biped.toml"), before);
        assert_eq!(files(&folder), ["biped.toml", "robot.urdf"]);
    }
}

#[test]
fn a_history_that_cannot_be_written_leaves_the_description() {
    let folder = robot("amend_history_blocked");
    let before = read(&folder, "biped.toml");
    std::fs::create_dir(folder.join("history.json")).unwrap();
    friction(&folder, "1", &[]).fails_with(&["history.json"]);
    assert_eq!(read(&folder, "biped.toml"), before);
    std::fs::remove_dir(folder.join("history.json")).unwrap();
    for (broken, words) in [("{", "damaged"), ("{\"format\": 9, \"steps\": []}", "has form 9")] {
        std::fs::write(folder.join("history.json"), broken).unwrap();
        friction(&folder, "1", &[]).fails_with(&["history.json", words]);
        bipedc(&["history", text(&folder)]).fails_with(&["history.json", words]);
    }
    assert_eq!(read(&folder, "biped.toml"), before);
    assert_eq!(files(&folder), ["biped.toml", "history.json", "robot.urdf"]);
}

#[test]
fn a_damaged_kept_text_is_noticed() {
    let folder = robot("amend_damaged");
    friction(&folder, "1", &[]).ok();
    let after = read(&folder, "biped.toml");
    let mut history: Value = serde_json::from_str(&read(&folder, "history.json")).unwrap();
    for damaged in ["!", "AAAA", ""] {
        history["steps"][0]["previous_text"] = json!(damaged);
        std::fs::write(folder.join("history.json"), history.to_string()).unwrap();
        bipedc(&["amend", text(&folder), "--undo"]).fails_with(&["step 1 is damaged", "history.json"]);
        assert_eq!(read(&folder, "biped.toml"), after);
    }
}
