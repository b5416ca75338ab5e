//! `bipedc export`: what was amended, as a URDF for other tools.
use super::{JOINT, read, robot};
use crate::cli::{bipedc, text};
use bipedc_compiler::Robot;
use bipedc_compiler::tree::as_built;

#[test]
fn an_export_of_nothing_names_what_there_is() {
    let run = bipedc(&["export", "robots/tulip"]);
    let names = ["--urdf <OUT.urdf>", "--mjcf <OUT.xml>"];
    assert!(run.code == Some(2) && names.iter().all(|name| run.err.contains(name)), "{}", run.err);
}

#[test]
fn bodies_and_friction_are_written_and_the_rest_stays() {
    let folder = robot("export");
    let amend = |words: &[&str]| {
        bipedc(&[&["amend", text(&folder)][..], words].concat()).ok();
    };
    amend(&["--effect", "payload", "--link", "torso", "--set", "mass=1.2,x=0.05,y=0,z=0.3"]);
    amend(&["--effect", "inertial_correction", "--link", "torso", "--set", "mass=0.3,z=-0.01,iyy=0.02"]);
    amend(&["--effect", "viscous_friction", "--joint", JOINT, "--set", "damping=0.25"]);
    amend(&["--effect", "coulomb_friction", "--joint", JOINT, "--set", "torque=0.43"]);
    amend(&["--effect", "torque_gain", "--joint", JOINT, "--set", "gain=0.9"]);
    let file = folder.join("amended.urdf");
    let run = bipedc(&["export", text(&folder), "--urdf", text(&file)]).ok();
    assert!(run.out.contains("link torso; joint left_knee_pitch"), "{}", run.out);
    assert!(run.err.contains("no words for: Gain of the torque signal at left_knee_pitch"), "{}", run.err);

    let (before, after) = (read(&folder, "robot.urdf"), read(&folder, "amended.urdf"));
    let (old, new): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    let gone = old.iter().filter(|line| !new.contains(line)).count();
    let come = new.iter().filter(|line| !old.contains(line)).count();
    assert!(gone <= 5 && come <= 7, "{gone} lines gone, {come} come:\n{after}");
    assert!(after.contains("<dynamics damping=\"0.25\" friction=\"0.43\"/>"), "{after}");

    let (amended, exported) = (Robot::read(&folder).unwrap(), Robot::read(&file).unwrap());
    let built = as_built(&amended.description);
    for (built, link) in built.links.iter().zip(&exported.description.links) {
        assert_eq!(built.inertial, link.inertial, "{}", link.name);
    }
    let mass = |robot: &bipedc_compiler::description::model::RobotDescription| -> f64 {
        robot.links.iter().filter_map(|link| Some(link.inertial.as_ref()?.mass)).sum()
    };
    assert!((mass(&exported.description) - mass(&amended.description) - 1.5).abs() < 1e-12);
    // A link weighs something, and `check` speaks of the bodies as amended.
    let heavy =
        ["amend", text(&folder), "--effect", "inertial_correction", "--link", "torso", "--set", "mass=-100"];
    bipedc(&heavy).fails_with(&["link `torso` would weigh -8", "effects on a link add up"]);
    assert!(bipedc(&["check", text(&folder)]).ok().out.contains("physically consistent"));
    amend(&[
        "--effect",
        "inertia_error",
        "--link",
        "left_foot",
        "--set",
        "ixx=9,ixy=0,ixz=0,iyy=0,iyz=0,izz=0",
    ]);
    let odd = bipedc(&["check", text(&folder)]).ok().out;
    assert!(odd.contains("physically inconsistent") && odd.contains("left_foot"), "{odd}");
    // What other tools will read and the model does not have is named.
    let stated = before.replacen("</joint>", "<dynamics damping=\"0.5\" friction=\"0\"/></joint>", 1);
    std::fs::write(folder.join("robot.urdf"), &stated).unwrap();
    let run = bipedc(&["export", text(&folder), "--urdf", text(&file), "--json"]).ok();
    assert!(
        run.err.contains("say what the model does not have") && run.err.contains("--set damping=0.5"),
        "{}",
        run.err
    );
    let kept = run.json()["urdf"]["kept"].clone();
    assert_eq!((&kept[0]["damping"], kept.as_array().unwrap().len()), (&serde_json::json!(0.5), 1), "{kept}");
    std::fs::write(folder.join("robot.urdf"), &before).unwrap();
    // An output never destroys an input.
    bipedc(&["export", text(&folder), "--urdf", text(&folder.join("robot.urdf"))])
        .fails_with(&["robot.urdf"]);
    assert_eq!(read(&folder, "robot.urdf"), before);
}
