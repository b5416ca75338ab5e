//! The robots of this repository, and other people's where they are at hand.
use bipedc_compiler::description::model::{Base, ContactPart, DriveKind, JointKind, Side};
use bipedc_compiler::description::{self};
use std::path::{Path, PathBuf};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

fn read(folder: &str) -> (description::model::RobotDescription, Vec<String>) {
    match description::read(&repository().join(folder)) {
        Ok((robot, warnings)) => (robot, warnings.iter().map(ToString::to_string).collect()),
        Err(errors) => panic!("{errors}"),
    }
}

#[test]
fn own_robots_load_without_a_word() {
    for name in ["three_link", "five_link", "seven_link", "biped_3d", "tulip", "tulip_v1_leg"] {
        let (robot, warnings) = read(&format!("robots/{name}"));
        assert_eq!(warnings, Vec::<String>::new(), "{name}");
        assert_eq!(robot.gravity, [0.0, 0.0, -9.81]);
        assert_eq!(robot.root_link, "torso");
    }
}

#[test]
fn bench_robots_load() {
    for (name, warned) in [("lower12", 0), ("rabbit5", 2), ("biped7", 2)] {
        let (_, warnings) = read(&format!("benches/robots/{name}"));
        assert_eq!(warnings.len(), warned, "{name}: {warnings:#?}");
    }
}

#[test]
fn tulip_is_what_its_files_say() {
    let (robot, _) = read("robots/tulip");
    assert_eq!((robot.links.len(), robot.joints.len(), robot.actuated_joints.len()), (13, 12, 12));
    assert_eq!(robot.base, Base::Floating { root: "torso".into() });
    assert!(robot.drives.is_empty());
    let knee = robot.joints.iter().find(|joint| joint.name == "left_knee_pitch").unwrap();
    assert_eq!(knee.kind, JointKind::Revolute);
    assert_eq!(knee.axis, [0.0, 1.0, 0.0]);
    assert_eq!(knee.origin.xyz, [0.0, 0.0, -0.315]);
    let foot = &robot.feet[0];
    assert_eq!((foot.name.as_str(), foot.side, foot.points.len()), ("right_foot", Some(Side::Right), 4));
    let edges: Vec<String> =
        foot.edges.iter().map(|edge| format!("{}: {}", edge.name, edge.points.join(" "))).collect();
    assert_eq!(
        edges,
        [
            "front: front_left front_right",
            "rear: rear_left rear_right",
            "left: front_left rear_left",
            "right: front_right rear_right"
        ]
    );
    let names: Vec<&str> = robot.phases.iter().map(|phase| phase.next.as_str()).collect();
    assert_eq!(names, ["double_support_left", "left_support", "double_support_right", "right_support"]);
}

#[test]
fn the_version_1_leg_has_its_drive_trains() {
    let (robot, _) = read("robots/tulip_v1_leg");
    assert_eq!(robot.base, Base::Fixed { link: "torso".into() });
    assert_eq!(robot.drives.len(), 6);
    let pitch = &robot.drives[2];
    assert_eq!(
        (pitch.joint.as_str(), pitch.gear_ratio, pitch.rotor_inertia),
        ("right_hip_pitch", 111.0, 3.35e-6)
    );
    assert!(matches!(pitch.kind, DriveKind::SeriesElastic { spring_stiffness: 83008.0, .. }));
    assert!(matches!(robot.drives[5].kind, DriveKind::Passive { stiffness: 12.0, damping: 0.05 }));
    assert_eq!(robot.actuated_joints.len(), 5);
}

#[test]
fn point_feet_are_points_and_flat_feet_flat() {
    let (robot, _) = read("robots/five_link");
    let phase = &robot.phases[0];
    assert_eq!(phase.contacts[0].part, ContactPart::Point("point_foot".into()));
    assert_eq!(phase.impact[0].foot, "left_foot");
    assert!(phase.relabel && phase.next == "single_support");
    let (robot, _) = read("robots/biped_3d");
    let parts: Vec<&ContactPart> = robot.phases.iter().map(|phase| &phase.contacts[0].part).collect();
    let edge = ContactPart::Edge("front".into());
    assert_eq!(parts, [&ContactPart::Flat, &edge, &edge, &ContactPart::Flat]);
}

/// Folders with other people's robots beside this repository; they are read there and never copied.
fn shared() -> Option<PathBuf> {
    let folder = repository().parent()?.join("shared");
    let folder = if folder.is_dir() { folder } else { repository().parent()?.parent()?.join("shared") };
    if !folder.is_dir() {
        println!("skipped: no folder `shared` beside the repository");
        return None;
    }
    Some(folder)
}

#[test]
fn other_peoples_robots_load() {
    let Some(shared) = shared() else { return };
    let files = [
        ("data/kuka_lwr4/kuka_lwr4.urdf", 9, 8, "second <origin>"),
        ("data/dfki_double_pendulum/acrobot_model_1.0.urdf", 5, 4, "-3.1416 is"),
        ("data/icub_walking/iCubGenova04.urdf", 190, 189, ""),
        ("data/staubli_tx40/tx40_mdh_modified.urdf", 8, 7, ""),
    ];
    for (file, links, joints, warning) in files {
        let (robot, warnings) = match description::read(&shared.join(file)) {
            Ok(result) => result,
            Err(errors) => panic!("{file}: {errors}"),
        };
        assert_eq!((robot.links.len(), robot.joints.len()), (links, joints), "{file}");
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        println!("{file}: {warnings:#?}");
        assert!(warnings.iter().any(|text| text.contains(warning)) || warning.is_empty(), "{file}");
    }
}
