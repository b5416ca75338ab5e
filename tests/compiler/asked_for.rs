//! Functions that a description asks for by name, also of one frame or phase.
use bipedc_compiler::Robot;
use bipedc_compiler::compile::FunctionRequest;
use bipedc_compiler::description::SourceFiles;
use std::path::Path;

fn robot(name: &str, generate: &str) -> Robot {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name);
    with(SourceFiles::load(&folder).unwrap(), generate)
}

fn with(mut files: SourceFiles, generate: &str) -> Robot {
    files.toml_text = format!("{}\n[generate]\n{generate}\n", files.toml_text);
    let (description, warnings) = files.parse().unwrap();
    Robot { description, warnings, sources: files }
}

fn names(robot: &Robot) -> Vec<String> {
    robot.compile().unwrap().functions.into_iter().map(|function| function.name).collect()
}

fn asked(robot: &Robot) -> Vec<FunctionRequest> {
    robot.requests(&robot.tree().unwrap()).unwrap()
}

#[test]
fn functions_of_one_frame_or_phase_have_names() {
    let robot = robot(
        "five_link",
        r#"functions = ["impact_map_of_single_support", "jacobian_of_torso", "bias", "position_of_right_foot/point_foot"]"#,
    );
    // In the order of the catalogue.
    let expected =
        ["bias", "impact_map_of_single_support", "position_of_right_foot_point_foot", "jacobian_of_torso"];
    assert_eq!(names(&robot), expected);
}

#[test]
fn names_are_those_that_inspect_prints() {
    let all = robot("seven_link", "");
    let printed = names(&all);
    let list: Vec<String> = printed.iter().map(|name| format!("{name:?}")).collect();
    assert_eq!(names(&robot("seven_link", &format!("functions = [{}]", list.join(", ")))), printed);
}

#[test]
fn frames_beside_the_feet() {
    let more = robot("five_link", r#"frames = ["torso", "left_tibia"]"#);
    let (without, all) = (asked(&robot("five_link", "")), asked(&more));
    let new: Vec<&FunctionRequest> = all.iter().filter(|request| !without.contains(request)).collect();
    assert_eq!(new.len(), 4, "{new:?}");
    assert!(new.iter().all(|request| request.subject.as_deref() == Some("torso")));
    // A whole family is of these frames too.
    let family = asked(&robot("five_link", "functions = [\"jacobian\"]\nframes = [\"torso\"]"));
    assert!(family.contains(&FunctionRequest { family: "jacobian".into(), subject: Some("torso".into()) }));
}

/// An arm on a stand: its tool hangs on a fixed joint.
const ARM: &str = "<robot name='arm'><link name='world'/>
    <link name='upper'><inertial><mass value='2'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/></inertial></link>
    <link name='tool'/>
    <joint name='shoulder' type='continuous'><parent link='world'/><child link='upper'/><axis xyz='0 1 0'/></joint>
    <joint name='flange' type='fixed'><parent link='upper'/><child link='tool'/><origin xyz='0 0 -0.5'/></joint></robot>";

#[test]
fn an_arm_has_its_end_effector() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("arm_without_feet");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("robot.urdf"), ARM).unwrap();
    std::fs::write(folder.join("biped.toml"), "").unwrap();
    let functions = names(&with(SourceFiles::load(&folder).unwrap(), ""));
    for family in ["position", "rotation", "jacobian", "jacobian_rate_times_velocity"] {
        assert!(functions.contains(&format!("{family}_of_tool")), "{functions:?}");
    }
    assert!(!functions.iter().any(|name| name.ends_with("_of_upper")));
}

#[test]
fn mistakes_are_named_with_their_place() {
    let cases = [
        (
            r#"functions = ["jacobian_of_tors"]"#,
            "there is no link or contact point `tors`",
            "did you mean `torso`?",
        ),
        (
            r#"functions = ["jacobain_of_torso"]"#,
            "there is no function `jacobain_of_torso`",
            "did you mean `jacobian`?",
        ),
        (r#"functions = ["impact_map_of_flight"]"#, "no phase `flight`", "phases are: single_support"),
        (r#"functions = ["bias_of_torso"]"#, "there is no function `bias_of_torso`", ""),
        (r#"frames = ["left_tibbia"]"#, "there is no link or contact point `left_tibbia`", "`left_tibia`"),
    ];
    for (generate, message, help) in cases {
        let robot = robot("five_link", generate);
        let error = robot.compile().unwrap_err();
        assert!(error.message.contains(message), "{generate}: {error}");
        assert!(error.help.as_deref().unwrap_or("").contains(help), "{generate}: {error}");
        assert!(error.file.is_some() && error.position.is_some_and(|(_, column)| column > 8), "{error}");
    }
}
