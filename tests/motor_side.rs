//! Robots whose encoders sit on the motors: a spring behind one is found from the motor's angle and torque alone.
use super::cli::{bipedc, scratch, text};
use super::hidden_effects::made;
use serde_json::Value;
use std::path::Path;

/// The table without position and velocity of joints of which it has the motor's angle.
fn without_links(file: &Path, joint: &str) {
    let table = std::fs::read_to_string(file).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let dropped = [format!("{joint}/position"), format!("{joint}/velocity")];
    let kept: Vec<usize> =
        (0..header.len()).filter(|k| !dropped.iter().any(|name| name == header[*k])).collect();
    assert!(kept.len() == header.len() - 2 && table.contains(&format!("{joint}/motor_position")));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        kept.iter().map(|k| cells[*k]).collect::<Vec<_>>().join(",")
    };
    std::fs::write(file, table.lines().map(row).collect::<Vec<_>>().join("\n") + "\n").unwrap();
}

fn copied(robot: &str, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for file in ["robot.urdf", "biped.toml"] {
        std::fs::copy(format!("robots/{robot}/{file}"), to.join(file)).unwrap();
    }
}

#[test]
#[ignore = "takes long"]
fn a_spring_behind_a_motor_is_found_and_described() {
    let (case, joint) = ("series_elasticity-2", "right_knee_pitch");
    let (truth, folder) = made(case, "motor_side");
    let [train, validation] = ["train.csv", "validation.csv"].map(|name| folder.join(name));
    for file in [&train, &validation] {
        without_links(file, joint);
    }
    let robot = scratch(&format!("motor_side_{case}")).join("robot");
    copied(&truth.robot, &robot);
    let logs = [text(&train), "--validate", text(&validation), "--json"];
    let answer = bipedc(&[&["diagnose", text(&robot)], &logs[..]].concat()).ok();
    let found: Value = answer.json();
    let spring = &found["effects"][0];
    assert_eq!(
        (spring["kind"].as_str(), spring["joint"].as_str()),
        (Some("series_elasticity"), Some(joint)),
        "{found}"
    );
    let [stiffness, true_one] = [
        &spring["parameters"]["stiffness"],
        &serde_json::to_value(&truth.effects[0]).unwrap()["parameters"]["stiffness"],
    ]
    .map(|value| value.as_f64().unwrap());
    assert!((stiffness / true_one - 1.0).abs() < 0.05, "{stiffness} instead of {true_one}");
    let rms = |when: &str| found["rms"]["effort"][when].as_f64().unwrap();
    assert!(rms("after") < 0.15 * rms("before"), "{} to {}", rms("before"), rms("after"));
    // Described, it is known to a comparison with the same log.
    let proposal = robot.with_file_name("diagnosis.json");
    std::fs::write(&proposal, &answer.out).unwrap();
    bipedc(&["amend", text(&robot), "--from", text(&proposal)]).ok();
    let cutoff = found["judged_at_hz"].as_f64().unwrap_or_else(|| found["cutoff_hz"].as_f64().unwrap());
    let compared =
        bipedc(&["compare", text(&robot), text(&validation), "--cutoff", &cutoff.to_string(), "--json"])
            .ok()
            .json();
    let error = compared["kinds"]["effort"]["rms"].as_f64().unwrap();
    assert!((error / rms("after") - 1.0).abs() < 1e-3, "{error} compared, {} diagnosed", rms("after"));
}
