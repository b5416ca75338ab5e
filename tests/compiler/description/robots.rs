//! The robots of this repository, and other people's where they are at hand.
use bipedc_compiler::description::model::{Base, ContactPart, JointKind, Side};
use bipedc_compiler::description::{self};
use bipedc_effects::drive::Transmission;
use std::path::{Path, PathBuf};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
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
        (pitch.joint.as_str(), pitch.drive.gear_ratio, pitch.drive.rotor_inertia),
        ("right_hip_pitch", 111.0, 3.35e-6)
    );
    let spring = pitch.drive.transmission;
    assert!(matches!(spring, Transmission::SeriesElastic { spring_stiffness: 83008.0, .. }));
    assert_eq!(robot.drives[5].drive.transmission, Transmission::Passive { stiffness: 12.0, damping: 0.05 });
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

/// All robots at hand: ours, the bench's, and other people's.
fn all_urdfs() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for folder in ["robots", "benches/robots"] {
        for entry in std::fs::read_dir(repository().join(folder)).unwrap() {
            files.push(entry.unwrap().path().join("robot.urdf"));
        }
    }
    if let Some(shared) = shared() {
        for folder in ["robots", "peers/robots"] {
            let entries = std::fs::read_dir(shared.join(folder)).unwrap();
            files.extend(entries.map(|entry| entry.unwrap().path()));
        }
        for folder in std::fs::read_dir(shared.join("data")).unwrap() {
            let Ok(entries) = std::fs::read_dir(folder.unwrap().path()) else { continue };
            files.extend(entries.map(|entry| entry.unwrap().path()));
        }
    }
    files.retain(|file| file.extension().is_some_and(|extension| extension == "urdf") && file.is_file());
    files.sort();
    files
}

#[test]
fn every_guessed_description_can_be_read() {
    let files = all_urdfs();
    assert!(files.len() >= 9);
    for file in files {
        let guess = description::init(&file).unwrap_or_else(|errors| panic!("{errors}"));
        println!("{}\n{guess}", file.display());
        let text = std::fs::read_to_string(&file).unwrap();
        let robot = description::parse(&text, &file, &guess, Path::new("biped.toml"));
        let (_, warnings) = robot.unwrap_or_else(|errors| panic!("{guess}\n{errors}"));
        let about_the_guess = warnings.iter().find(|w| w.file.as_deref() == Some(Path::new("biped.toml")));
        assert_eq!(about_the_guess, None);
    }
}

#[test]
fn guesses_for_our_robots_are_right() {
    for name in ["three_link", "five_link", "seven_link", "biped_3d", "tulip"] {
        let folder = repository().join("robots").join(name);
        let guess = description::init(&folder.join("robot.urdf")).unwrap();
        let text = std::fs::read_to_string(folder.join("robot.urdf")).unwrap();
        let (guessed, _) =
            description::parse(&text, Path::new("robot.urdf"), &guess, Path::new("biped.toml")).unwrap();
        let (stated, _) = read(&format!("robots/{name}"));
        assert_eq!(guessed.base, stated.base, "{name}");
        assert_eq!(guessed.feet, stated.feet, "{name}");
        assert_eq!(guessed.actuated_joints, stated.actuated_joints, "{name}");
        let mut pairs = [guessed.symmetric_joints, stated.symmetric_joints];
        pairs.iter_mut().for_each(|pairs| pairs.sort_by(|a, b| a.left.cmp(&b.left)));
        assert_eq!(pairs[0], pairs[1], "{name}");
    }
}

#[test]
fn the_report_of_tulip() {
    let (robot, _) = read("robots/tulip");
    let report = description::check_report(&robot);
    println!("{report}");
    assert!((report.total_mass - 19.0).abs() < 1e-12);
    assert_eq!(report.inconsistencies, Vec::<String>::new());
    assert_eq!((report.links.len(), report.moving_joints), (13, 12));
    let text = report.to_string();
    assert!(text.contains("\n        right_lower_leg  1 kg  (right_knee_pitch: revolute y)\n"), "{text}");
    assert!(text.contains("base floating at `torso`"));
    assert!(report.height_above.starts_with("contact point right_foot/"));
    assert!(report.center_of_mass_height > 0.6 && report.center_of_mass_height < 0.8);
}

/// A body on a root at its lower end, with two arms or legs of this name that end at this height.
fn two_limbs(name: &str, height: f64) -> String {
    let inertial = "<inertial><mass value='1'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/></inertial>";
    let limb = |side: &str, y: f64| {
        format!(
            "<link name='{side}_{name}'>{inertial}</link><joint name='{side}_j' type='continuous'>\
             <parent link='body'/><child link='{side}_{name}'/><origin xyz='0 {y} {height}'/><axis xyz='1 0 0'/></joint>"
        )
    };
    format!(
        "<robot name='r'><link name='body'>{inertial}</link>{}{}</robot>",
        limb("left", 0.2),
        limb("right", -0.2)
    )
}

#[test]
fn legs_are_told_from_arms_and_wheels() {
    let base = |urdf: &str| {
        let guess = description::init_text(urdf, Path::new("robot.urdf")).unwrap();
        guess
            .lines()
            .find(|line| line.starts_with("kind"))
            .unwrap()
            .split('#')
            .next()
            .unwrap()
            .trim()
            .to_string()
    };
    assert_eq!(base(&two_limbs("tool", 0.5)), "kind = \"fixed\"");
    assert_eq!(base(&two_limbs("wheel", 0.0)), "kind = \"fixed\"");
    assert_eq!(base(&two_limbs("shank", -0.8)), "kind = \"floating\"");
    assert_eq!(base(&two_limbs("foot", 0.0)), "kind = \"floating\"");
}

#[test]
fn the_report_says_what_is_odd() {
    let (robot, _) = read("benches/robots/rabbit5");
    assert_eq!(description::check_report(&robot).inconsistencies, Vec::<String>::new());
    let (mut robot, _) = read("robots/three_link");
    robot.links[1].inertial.as_mut().unwrap().inertia = [1.0, 0.0, 0.0, 1.0, 0.0, 3.0];
    let text = description::check_report(&robot).to_string();
    assert!(text.contains("physically inconsistent:\n  link `right_leg`: the principal moments"), "{text}");
}
