#[test]
fn broken_xml() {
    refused(
        &changed(&[("</inertial>", "</inertia>")]),
        r#"error: broken XML: expected 'inertial' tag, not 'inertia'
  --> robot.urdf:7:5
help: correct the XML here; every <tag> needs its </tag>"#,
    );
}

#[test]
fn empty_file() {
    refused(r#"error: no XML element found
  --> robot.urdf:1:1
help: the file must contain <robot name="…">…</robot>"#, r#"error: broken XML: unknown token
  --> robot.urdf:1:1
help: correct the XML here; every <tag> needs its </tag>"#);
    refused("   \n", r#"error: no XML element found
  --> robot.urdf:1:1
help: the file must contain <robot name="…">…</robot>"#);
}

#[test]
fn not_a_robot() {
    refused("<sdf version='1.7'/>", r#"error: the file holds <sdf>, expected <robot>
  --> robot.urdf:1:1
help: give a URDF; SDF and MJCF files must be converted first"#);
}

#[test]
fn no_links() {
    refused("<robot name='r'/>", r#"error: the robot has no links
  --> robot.urdf:1:1
help: add <link name="…"> elements"#);
}

#[test]
fn entity_bomb() {
    let bomb = "<!DOCTYPE robot [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]>\n<robot name='&b;'/>";
    refused(bomb, r#"error: a DOCTYPE (with entity definitions) is not supported
  --> robot.urdf:1:1
help: remove the <!DOCTYPE …> and write the values where they are used"#);
}

#[test]
fn absurd_nesting() {
    let text = format!("<robot name='r'>\n{}{}</robot>", "<a>".repeat(1_000_000), "</a>".repeat(1_000_000));
    refused(&text, r#"error: XML elements nested more than 200 deep
  --> robot.urdf:2:598
help: a URDF needs six levels; remove the nesting"#);
}

#[test]
fn too_many_links() {
    let text = format!("<robot name='r'>{}</robot>", "<link name='a'/>".repeat(10_001));
    refused(&text, r#"error: more than 10000 links and joints
  --> robot.urdf:1:1
help: is this one robot?"#);
}

#[test]
fn xacro() {
    refused(&changed(&[("<link name=\"leg\">", "<xacro:include filename=\"leg.xacro\"/><link name=\"leg\">")]), r#"error: this is a xacro file, not a URDF: it has `xacro:` elements
  --> robot.urdf:9:4
help: run xacro first and use its output: `ros2 run xacro xacro robot.urdf.xacro > robot.urdf`"#);
    refused(
        &changed(&[
            ("<robot name=\"test\">", "<robot name=\"test\" xmlns:xacro=\"http://ros.org/wiki/xacro\">"),
            ("<link name=\"leg\">", "<xacro:include filename=\"leg.xacro\"/><link name=\"leg\">"),
        ]),
        r#"error: `<xacro:include>` is not URDF: this is a xacro file
  --> robot.urdf:9:3
help: run xacro first and use its output: `ros2 run xacro xacro robot.urdf.xacro > robot.urdf`"#,
    );
    refused(&changed(&[("mass value=\"5\"", "mass value=\"${leg_mass}\"")]), r#"error: `value="${leg_mass}"` is a xacro expression, not a value
  --> robot.urdf:12:13
help: run xacro first and use its output: `ros2 run xacro xacro robot.urdf.xacro > robot.urdf`"#);
}

#[test]
fn cycle() {
    let joint = "<joint name=\"back\" type=\"fixed\"><parent link=\"leg\"/><child link=\"torso\"/></joint>\n</robot>";
    refused(&changed(&[("</robot>", joint)]), r#"error: the links form a cycle: `leg` → `torso` → `leg`
  --> robot.urdf:16:3
help: remove one of its joints; a robot's links must form a tree"#);
    refused(&changed(&[("<parent link=\"torso\"/>", "<parent link=\"leg\"/>")]), r#"error: the links form a cycle: `leg` → `leg`
  --> robot.urdf:16:3
help: remove one of its joints; a robot's links must form a tree"#);
}

#[test]
fn several_roots() {
    refused(&changed(&[("</robot>", "  <link name=\"arm\"/>\n</robot>")]), r#"error: the links form 2 separate trees; their roots are `torso`, `arm`
  --> robot.urdf:23:3
help: connect them by joints (fixed ones if nothing moves), or remove the parts that do not belong"#);
}

#[test]
fn two_parents() {
    let joint = "  <joint name=\"again\" type=\"fixed\"><parent link=\"torso\"/><child link=\"leg\"/></joint>\n</robot>";
    refused(&changed(&[("</robot>", joint)]), r#"error: link `leg` is the child of two joints, `hip` and `again`
  --> robot.urdf:23:3
help: closed chains are not supported: cut the loop, each link needs exactly one parent"#);
}

#[test]
fn undefined_links() {
    refused(&changed(&[("<child link=\"leg\"/>", "<child link=\"legs\"/>")]), r#"error: joint `hip`: child link `legs` does not exist
  --> robot.urdf:18:5
help: did you mean `leg`?"#);
    refused(&changed(&[("<parent link=\"torso\"/>", "<parent link=\"pelvis\"/>")]), r#"error: joint `hip`: parent link `pelvis` does not exist
  --> robot.urdf:17:5
help: links in this file: `torso`, `leg`"#);
    refused(&changed(&[("<parent link=\"torso\"/>", "")]), r#"error: joint `hip` has no parent link
  --> robot.urdf:16:3
help: add <parent link="…"/>"#);
    refused(&changed(&[("<child link=\"leg\"/>", "<child/>")]), r#"error: joint `hip`: <child> has no `link`
  --> robot.urdf:18:5
help: write <child link="…"/>"#);
}

#[test]
fn duplicate_names() {
    refused(&changed(&[("<link name=\"leg\">", "<link name=\"leg\"/>\n  <link name=\"leg\">")]), r#"error: the link name `leg` is used twice
  --> robot.urdf:10:3
help: rename one of the two links"#);
    let joint = "  <link name=\"foot\"/><joint name=\"hip\" type=\"fixed\"><parent link=\"leg\"/><child link=\"foot\"/></joint>\n</robot>";
    refused(&changed(&[("</robot>", joint)]), r#"error: the joint name `hip` is used twice
  --> robot.urdf:23:22
help: rename one of the two joints"#);
}

#[test]
fn a_link_and_a_joint_may_share_a_name() {
    let (_, warnings) = read(&changed(&[("joint name=\"hip\"", "joint name=\"leg\"")])).unwrap();
    assert!(warnings.is_empty());
}

#[test]
fn missing_names() {
    refused(&changed(&[("<link name=\"leg\">", "<link>")]), r#"error: a link without a name
  --> robot.urdf:9:3
help: write <link name="…">

error: joint `hip`: child link `leg` does not exist
  --> robot.urdf:18:5
help: links in this file: `torso`"#);
    refused(&changed(&[("joint name=\"hip\"", "joint name=\"a&#10;b\"")]), r#"error: the name of joint `a b` holds a control character
  --> robot.urdf:16:3
help: use letters, digits and `_`"#);
}

#[test]
fn zero_axis() {
    refused(&changed(&[("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 0 0\"/>")]), r#"error: joint `hip`: the axis is zero
  --> robot.urdf:20:5
help: write the direction of motion, such as <axis xyz="0 1 0"/>"#);
}

#[test]
fn reversed_limits() {
    refused(&changed(&[("lower=\"-1\" upper=\"1\"", "lower=\"1\" upper=\"-1\"")]), r#"error: joint `hip`: the limits are reversed: lower = 1 is above upper = -1
  --> robot.urdf:21:5
help: exchange them"#);
}

#[test]
fn moving_mimic() {
    refused(&changed(&[("<axis", "<mimic joint=\"knee\"/><axis")]), r#"error: joint `hip`: moving joints that <mimic> another are not supported
  --> robot.urdf:20:5
help: lock it in biped.toml (`[joints]`, `locked = ["hip"]`; `bipedc init` writes that), or remove <mimic> and let it move by itself"#);
}

/// Published grippers have such fingers: a first description locks them, and what is locked is as fixed as any joint.
#[test]
fn followers_are_locked() {
    let urdf = changed(&[("<axis", "<mimic joint=\"knee\"/><axis")]);
    let toml = init_text(&urdf, Path::new("robot.urdf")).unwrap();
    assert!(toml.contains("[joints]\nlocked = [\"hip\"]\n"), "{toml}");
    let (robot, _) = parse(&urdf, Path::new("robot.urdf"), &toml, Path::new("biped.toml")).unwrap();
    assert!(robot.joints.iter().all(|joint| joint.name != "hip" || !joint.kind.moves()));
}

#[test]
fn unsupported_joint_types() {
    refused(&changed(&[("type=\"revolute\"", "type=\"planar\"")]), r#"error: joint `hip`: joints of type `planar` are not supported
  --> robot.urdf:16:3
help: for a planar robot remove the joint and write `kind = "planar"` under [base] in biped.toml; otherwise use two prismatic joints and a revolute one"#);
    refused(&changed(&[("type=\"revolute\"", "type=\"floating\"")]), r#"error: joint `hip`: joints of type `floating` are not supported
  --> robot.urdf:16:3
help: remove the joint (and the link `world` above it) and write `kind = "floating"` under [base] in biped.toml"#);
    refused(&changed(&[("type=\"revolute\"", "type=\"revolut\"")]), r#"error: joint `hip`: unknown type `revolut`
  --> robot.urdf:16:3
help: did you mean `revolute`?"#);
    refused(&changed(&[(" type=\"revolute\"", "")]), r#"error: joint `hip` has no type
  --> robot.urdf:16:3
help: write type="…": revolute, continuous, prismatic, fixed"#);
}

#[test]
fn moving_leaf_without_mass() {
    let foot = "  <link name=\"foot\"/>\n  <joint name=\"ankle\" type=\"continuous\"><parent link=\"leg\"/><child link=\"foot\"/></joint>\n</robot>";
    refused(&changed(&[("</robot>", foot)]), r#"error: link `foot` moves with joint `ankle` but has no mass: the equations of motion have no solution
  --> robot.urdf:23:3
help: add <inertial> with a mass, or make the joint fixed"#);
}

#[test]
fn negative_mass() {
    refused(&changed(&[("mass value=\"5\"", "mass value=\"-5\"")]), r#"error: link `leg`: the mass -5 kg is negative
  --> robot.urdf:12:7
help: write a mass of zero or more"#);
}

#[test]
fn indefinite_inertia() {
    refused(&changed(&[("ixx=\"0.1\" ixy=\"0\"", "ixx=\"0.1\" ixy=\"0.2\"")]), r#"error: link `leg`: the inertia is indefinite: its smallest principal moment is -1.000e-1 kg m²
  --> robot.urdf:13:7
help: a rotating body needs principal moments of zero or more: check signs and the order ixx ixy ixz iyy iyz izz"#);
}

#[test]
fn numbers_that_are_none() {
    refused(&changed(&[("mass value=\"5\"", "mass value=\"nan\"")]), r#"error: link `leg`: mass/value is `nan`, expected a number: NaN and infinity have no meaning
  --> robot.urdf:12:13
help: write a finite value, or remove the attribute"#);
    refused(&changed(&[("upper=\"1\"", "upper=\"inf\"")]), r#"error: joint `hip`: limit/upper is `inf`, expected a number: NaN and infinity have no meaning
  --> robot.urdf:21:23
help: write a finite value, or remove the attribute"#);
    refused(&changed(&[("ixx=\"0.1\"", "ixx=\"1e999\"")]), r#"error: link `leg`: inertia/ixx is `1e999`, expected a number: NaN and infinity have no meaning
  --> robot.urdf:13:16
help: write a finite value, or remove the attribute"#);
    refused(&changed(&[("mass value=\"5\"", "mass value=\"five\"")]), r#"error: link `leg`: mass/value is `five`, expected a number: `five` is not a number
  --> robot.urdf:12:13
help: write digits, such as 0.25 or 2.5e-3"#);
    refused(&changed(&[("xyz=\"0 0 -0.4\"", "xyz=\"0 0 -0,4\"")]), r#"error: link `leg`: origin/xyz is `0 0 -0,4`, expected 3 numbers: `-0,4` is not a number
  --> robot.urdf:11:15
help: write decimals with a point and separate by spaces"#);
    refused(&changed(&[("xyz=\"0 0 -0.1\"", "xyz=\"0 -0.1\"")]), r#"error: joint `hip`: origin/xyz is `0 -0.1`: expected 3 numbers, found 2
  --> robot.urdf:19:13
help: write as many as expected, separated by spaces"#);
}

#[test]
fn everything_is_reported_at_once() {
    let text = changed(&[
        ("mass value=\"10\"", "mass value=\"-10\""),
        ("mass value=\"5\"", "mass value=\"x\""),
        ("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 0 0\"/>"),
        ("lower=\"-1\" upper=\"1\"", "lower=\"1\" upper=\"-1\""),
    ]);
    let errors = parse(&text, Path::new("robot.urdf"), "gravty = 1", Path::new("biped.toml")).unwrap_err();
    let places: Vec<_> = errors.0.iter().map(|error| error.position.unwrap()).collect();
    assert_eq!(places, [(1, 1), (5, 7), (12, 13), (20, 5), (21, 5)]);
}

/// Such numbers overflowed in the derivations, far from the file.
#[test]
fn impossible_sizes() {
    refused(&changed(&[("mass value=\"5\"", "mass value=\"1e300\"")]), r#"error: link `leg`: mass/value is `1e300`, which is too large
  --> robot.urdf:12:13
help: numbers in SI units are at most 1e12 in size: is the unit right?"#);
    refused(&changed(&[("mass value=\"5\"", "mass value=\"1e-320\"")]), r#"error: link `leg`: mass/value is `1e-320`, which is too small
  --> robot.urdf:12:13
help: numbers in SI units are 0 or at least 1e-100 in size: write 0"#);
    for (old, new) in [("0 0 -0.4", "0 0 1e200"), ("0 0 -0.1", "1e155 0 0"), ("ixx=\"0.1\"", "ixx=\"-1e13\"")] {
        let errors = read(&changed(&[(old, new)])).unwrap_err();
        assert!(errors.contains("which is too large\n  --> robot.urdf:"), "{errors}");
    }
}

/// Exporters write the largest number that there is where a joint has no limit.
#[test]
fn limits_may_be_as_large_as_exporters_like() {
    let text = changed(&[("lower=\"-1\" upper=\"1\"", "lower=\"-1.7976931348623157e308\" upper=\"1.7976931348623157e308\"")]);
    assert!(read(&text).is_ok());
}

/// As in URDF 1.1; the length of the quaternion does not count.
#[test]
fn orientations_by_quaternions() {
    let turned = |origin: &str| {
        let text = changed(&[("<origin xyz=\"0 0 -0.1\" rpy=\"0 0 0\"/>", &format!("<origin xyz=\"0 0 -0.1\" {origin}/>"))]);
        read(&text).map(|(robot, _)| robot.joints[0].origin.rpy)
    };
    let half = std::f64::consts::FRAC_PI_2;
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
    assert!(near(turned("quat_xyzw=\"0 0 0 1\"").unwrap(), [0.0; 3]));
    assert!(near(turned("quat_xyzw=\"0.7071068 0 0 0.7071068\"").unwrap(), [half, 0.0, 0.0]));
    assert!(near(turned("quat_xyzw=\"0 2 0 2\"").unwrap(), [0.0, half, 0.0]));
    assert!(near(turned("quat_xyzw=\"1 1 1 1\"").unwrap(), [half, 0.0, half]));
    refused(&changed(&[("xyz=\"0 0 -0.1\" rpy=\"0 0 0\"", "quat_xyzw=\"0 0 0 0\"")]), r#"error: joint `hip`: origin/quat_xyzw is zero, which is no rotation
  --> robot.urdf:19:5
help: write a unit quaternion x y z w, such as 0 0 0 1"#);
}
