//! What cannot be done is named: with step, time, joint, value and limit; nothing is left behind.
use crate::cli::{Run, bipedc, scratch, text};
use std::path::Path;

fn plan(robot: &str, more: &[&str]) -> Run {
    bipedc(&[&["gait", "plan", robot][..], more].concat())
}

/// A limit that does not hold: exit code 4, named in the answer, no plan.
fn violated(more: &[&str], quantity: &str, of: &str) {
    let out = scratch(&format!("walking-{quantity}")).join("plan.csv");
    let run = plan("robots/tulip", &[more, &["--out", text(&out), "--json"]].concat());
    assert_eq!(run.code, Some(4), "{}", run.err);
    let first = &run.json()["violation"];
    assert_eq!(first["quantity"], quantity, "{first}");
    assert!(first["of"].as_str().unwrap_or("").contains(of), "{first}");
    let step = first["step"].as_u64().unwrap_or(0);
    assert!(first["time"].as_f64().unwrap() > 0.0 && (step >= 1 || first["phase"] == "stand"), "{first}");
    assert!(!out.exists());
}

#[test]
fn the_first_limit_that_does_not_hold_is_named() {
    let forward = ["--gait", "forward", "--count", "1", "--set"];
    violated(&[&forward[..], &["effort_part=0.5"]].concat(), "effort", "hip_roll");
    violated(&[&forward[..], &["velocity_part=0.1"]].concat(), "velocity", "knee");
    violated(&[&forward[..], &["clearance=0.02"]].concat(), "clearance", "left");
    violated(&[&forward[..], &["static_shift_time=0.7"]].concat(), "zero_moment_point", "");
    violated(&[&forward[..], &["friction=0.012"]].concat(), "friction", "");
    violated(&[&forward[..], &["legs_distance=0.152"]].concat(), "legs_distance", "");
}

/// In words, with the picture in the page.
#[test]
fn the_report_shows_it() {
    let folder = scratch("walking-report");
    let [out, page] = ["plan.csv", "plan.html"].map(|name| folder.join(name));
    let more = ["--gait", "forward", "--count", "1", "--set", "effort_part=0.5"];
    let run = plan("robots/tulip", &[&more[..], &["--out", text(&out), "--report", text(&page)]].concat());
    assert_eq!((run.code, out.exists()), (Some(4), false));
    let words = "step 1, shift, at ";
    assert!(run.out.contains(words) && run.out.contains("allowed is at most 10.00000 N m"), "{}", run.out);
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("allowed is at most 10.00000 N m") && page.contains("stroke-dasharray=\"5 3\""));
}

#[test]
fn steps_that_no_leg_reaches_name_step_joint_and_time() {
    let long = plan("robots/tulip", &["--gait", "forward", "--stride", "0.4"]);
    long.fails_with(&["step 1 (left foot)", " s: `", "m or rad are missing", "shorter steps"]);
    let fast = plan("robots/tulip", &["--gait", "dynamic", "--speed", "1.5"]);
    fast.fails_with(&["(left foot)", " s: `", "m or rad are missing"]);
    let high = plan("robots/tulip", &["--gait", "forward", "--set", "com_height=0.8"]);
    high.fails_with(&["stand, at 0.000 s: `", "knee"]);
}

#[test]
fn feet_that_cross_are_refused_with_their_line() {
    let folder = scratch("walking-crossing");
    let refused = |text_of: &str, words: &[&str]| {
        let file = folder.join("steps.csv");
        std::fs::write(&file, text_of).unwrap();
        let more = ["--gait", "steps", "--steps", text(&file)];
        plan("robots/tulip", &more).fails_with(words);
    };
    refused(
        "foot,x,y,yaw\nleft,0.05,0.08,0\nright,0.1,0.2,0\n",
        &["steps.csv:3", "step 2 (right foot)", "the feet cross"],
    );
    refused("foot,x,y,yaw\nleft,0,0.04,0\n", &["steps.csv:2", "step 1 (left foot)", "`feet_distance`"]);
    refused("foot,x,y,yaw\nleft,0.9,0.08,0\n", &["steps.csv:2", "step 1 (left foot)", "are missing"]);
    refused("foot,x,y,yaw\nleft,0,nowhere,0\n", &["steps.csv:2:8", "`nowhere` is no number"]);
    plan("robots/tulip", &["--gait", "steps"]).fails_with(&["--gait steps needs footsteps"]);
    plan("robots/tulip", &["--gait", "turn", "--angle", "60"]).ok_or_named();
}

impl Run {
    /// Big turns are possible with feet farther apart or not, but never silently wrong.
    fn ok_or_named(self) {
        assert!(
            self.code == Some(0) || self.err.contains("step ") || self.out.contains("The first: step"),
            "{}",
            self.err
        );
    }
}

#[test]
fn robots_that_do_not_walk_and_numbers_that_do_not_exist_are_refused() {
    plan("robots/five_link", &["--gait", "forward"]).fails_with(&["floating base"]);
    plan("robots/five_link", &["--base", "floating", "--gait", "forward"])
        .fails_with(&["contact points", "biped.toml"]);
    plan("robots/tulip", &["--gait", "forward", "--set", "magrin=1"])
        .fails_with(&["`magrin`", "did you mean `margin`?"]);
    plan("robots/tulip", &["--gait", "forward", "--set", "margin=-1"]).fails_with(&["`margin` = -1"]);
    plan("robots/tulip", &["--gait", "forward", "--count", "0"]).fails_with(&["--count: 0"]);
    let folder = scratch("walking-numbers");
    let file = folder.join("walking.toml");
    std::fs::write(&file, "margin = 0.01\n[posture]\nright_knee_pitch = 1.0\n").unwrap();
    let asked = ["--gait", "forward", "--walking", text(&file)];
    plan("robots/tulip", &asked).fails_with(&["`right_knee_pitch`, a joint of a leg"]);
    std::fs::write(&file, "margin = 0.01\nstep = 1\n").unwrap();
    plan("robots/tulip", &asked).fails_with(&["walking.toml:2", "`step`"]);
    // No output over an input.
    let own = "robots/tulip/walking.toml";
    let before = std::fs::read_to_string(own).unwrap();
    assert_eq!(plan("robots/tulip", &["--gait", "forward", "--out", own]).code, Some(1));
    assert_eq!(std::fs::read_to_string(Path::new(own)).unwrap(), before);
}
