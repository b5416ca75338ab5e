//! `bipedc check` and `bipedc init`, what they print and how they fail.
#[path = "support/cli.rs"]
#[allow(dead_code)]
mod cli;

use cli::{bipedc, command, scratch, text};
use std::io::Read;
use std::process::Stdio;

#[test]
fn help_teaches_with_examples() {
    let run = bipedc(&["--help"]).ok();
    assert!(run.out.contains("bipedc generate robots/tulip"), "{}", run.out);
    for name in ["init", "check", "generate", "inspect", "evaluate", "compare", "excite"] {
        let run = bipedc(&[name, "--help"]).ok();
        assert!(run.out.contains("Examples:") && run.out.contains(&format!("bipedc {name}")), "{}", run.out);
    }
}

#[test]
fn check_prints_tree_masses_and_height() {
    let run = bipedc(&["check", "robots/five_link"]).ok();
    for words in
        ["right_tibia  3.2 kg", "total mass 32.000000 kg", "height 0.715250 m", "physically consistent"]
    {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
    assert_eq!(run.err, "");
}

#[test]
fn check_speaks_json() {
    let value = bipedc(&["check", "robots/five_link", "--json"]).ok().json();
    assert_eq!(value["robot"], "five_link");
    assert_eq!(value["total_mass"], 32.0);
    assert_eq!(value["links"][0]["name"], "torso");
    assert_eq!(value["errors"], serde_json::json!([]));
    assert!(value["warnings"].is_array() && value["inconsistencies"].is_array());
}

#[test]
fn check_reports_all_errors_at_once() {
    let folder = scratch("check_all");
    let urdf = std::fs::read_to_string("robots/three_link/robot.urdf").unwrap();
    let broken = urdf.replacen("mass value=\"", "mass value=\"-", 1).replacen(
        "<axis xyz=\"0 1 0\"",
        "<axis xyz=\"0 0 0\"",
        1,
    );
    std::fs::write(folder.join("robot.urdf"), broken).unwrap();
    std::fs::copy("robots/three_link/biped.toml", folder.join("biped.toml")).unwrap();
    bipedc(&["check", text(&folder)]).fails_with(&["is negative", "axis", "robot.urdf:"]);
    let run = bipedc(&["check", text(&folder), "--json"]).fails_with(&["is negative"]);
    let errors = run.json()["errors"].as_array().unwrap().clone();
    assert!(errors.len() >= 2, "{errors:?}");
    assert!(errors[0]["line"].is_u64() && errors[0]["file"].is_string() && errors[0]["help"].is_string());
}

#[test]
fn a_wrong_path_is_one_message() {
    let run = bipedc(&["check", "robots/nowhere"]).fails_with(&[
        "error: ",
        "robots/nowhere",
        "help: give a robot's folder",
    ]);
    assert_eq!(run.out, "");
}

#[test]
fn a_function_that_does_not_exist_is_found_by_check() {
    let folder = scratch("check_function");
    let toml = std::fs::read_to_string("robots/three_link/biped.toml").unwrap();
    std::fs::copy("robots/three_link/robot.urdf", folder.join("robot.urdf")).unwrap();
    std::fs::write(folder.join("biped.toml"), toml + "\n[generate]\nfunctions = [\"mass_matrx\"]\n").unwrap();
    bipedc(&["check", text(&folder)]).fails_with(&["`mass_matrx`", "did you mean `mass_matrix`?"]);
}

#[test]
fn bases_are_overridden_and_checked() {
    let run = bipedc(&["check", "robots/five_link", "--base", "floating", "--root", "right_tibia"]).ok();
    assert!(run.out.contains("base floating at `right_tibia`"), "{}", run.out);
    bipedc(&["check", "robots/five_link", "--root", "rigth_tibia"])
        .fails_with(&["`rigth_tibia`", "known are"]);
}

#[test]
fn init_writes_once() {
    let folder = scratch("init");
    let urdf = folder.join("robot.urdf");
    std::fs::copy("robots/five_link/robot.urdf", &urdf).unwrap();
    let run = bipedc(&["init", text(&urdf)]).ok();
    assert!(run.out.contains("wrote ") && run.out.contains("bipedc check"), "{}", run.out);
    let toml = std::fs::read_to_string(folder.join("biped.toml")).unwrap();
    assert!(toml.contains("kind = \"planar\""), "{toml}");
    bipedc(&["check", text(&folder)]).ok();
    bipedc(&["init", text(&urdf)]).fails_with(&["exists already", "--force"]);
    bipedc(&["init", text(&urdf), "--force"]).ok();
    bipedc(&["init", text(&folder.join("none.urdf"))]).fails_with(&["cannot read"]);
}

/// The reader takes one byte and leaves: `bipedc … | head -c1`.
#[test]
fn a_broken_pipe_is_no_error() {
    let mut child = command(&["inspect", "robots/tulip", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut byte = [0];
    let mut out = child.stdout.take().unwrap();
    out.read_exact(&mut byte).unwrap();
    drop(out);
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert!(child.wait().unwrap().success(), "{err}");
    assert_eq!(err, "");
}
