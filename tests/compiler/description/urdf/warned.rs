#[test]
fn undeclared_world_is_a_fixed_root() {
    let joint = "  <joint name=\"weld\" type=\"fixed\"><parent link=\"world\"/><child link=\"torso\"/></joint>\n</robot>";
    let (robot, warnings) = read(&changed(&[("</robot>", joint)])).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(robot.root_link, "world");
    assert_eq!(robot.base, bipedc_compiler::description::model::Base::Fixed { link: "world".into() });
    assert_eq!(robot.links[0].name, "world");
}

#[test]
fn link_without_inertia() {
    let knee = "  <link name=\"shank\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>
  <link name=\"virtual\"/>
  <joint name=\"a\" type=\"continuous\"><parent link=\"leg\"/><child link=\"virtual\"/></joint>
  <joint name=\"b\" type=\"continuous\"><parent link=\"virtual\"/><child link=\"shank\"/></joint>
</robot>";
    warned(&changed(&[("</robot>", knee)]), r#"warning: link `virtual` has no mass and no inertia; it only carries joints
  --> robot.urdf:24:3
help: fine for a virtual link between two joints; else add <inertial>"#);
    let turns = knee.replace("<link name=\"virtual\"/>", "<link name=\"virtual\"><inertial><mass value=\"0\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>");
    let (_, warnings) = read(&changed(&[("</robot>", &turns)])).unwrap();
    assert!(warnings.iter().any(|w| w.contains("link `virtual` has an inertia but no mass: there is no such body")), "{warnings:?}");
    let knee = knee.replace("name=\"a\" type=\"continuous\"", "name=\"a\" type=\"fixed\"");
    let (_, warnings) = read(&changed(&[("</robot>", &knee)])).unwrap();
    assert!(warnings.is_empty(), "lumped with the link above: {warnings:?}");
}

#[test]
fn floating_root_without_mass() {
    let base = "  <link name=\"base\"/>\n  <joint name=\"b\" type=\"continuous\"><parent link=\"base\"/><child link=\"torso\"/></joint>\n</robot>";
    warned(&changed(&[("</robot>", base)]), r#"warning: the base floats, but its link `base` has no mass
  --> biped.toml
help: add <inertial> to it in the URDF, or write kind = "fixed" under [base]"#);
}

#[test]
fn point_mass() {
    warned(&changed(&[("ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.02\"", "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"")]), r#"warning: link `leg` has 5 kg but no rotational inertia
  --> robot.urdf:10:5
help: add <inertia …/>; a point mass on its joint axis cannot be accelerated sensibly"#);
}

#[test]
fn incomplete_inertial() {
    warned(&changed(&[(" ixz=\"0\" iyy=\"0.1\"", " iyy=\"0.1\"")]), r#"warning: link `leg`: the inertia lacks ixz; what is missing counts as zero
  --> robot.urdf:13:7
help: write all six of ixx, ixy, ixz, iyy, iyz, izz in kg m²"#);
}

#[test]
fn triangle_inequality() {
    warned(&changed(&[("izz=\"0.02\"", "izz=\"0.5\"")]), r#"warning: link `leg`: the principal moments 1.0000e-1, 1.0000e-1, 5.0000e-1 kg m² violate the triangle inequality
  --> robot.urdf:10:5
help: no rigid body has them: the largest may not exceed the sum of the other two"#);
}

#[test]
fn mimic_on_fixed_joint() {
    warned(&changed(&[("type=\"revolute\"", "type=\"fixed\""), ("<axis", "<mimic joint=\"knee\"/><axis")]), r#"warning: joint `hip` is fixed; its <mimic> is ignored
  --> robot.urdf:20:5
help: remove the <mimic>"#);
}

#[test]
fn repeated_origin() {
    let robot = warned(&changed(&[("<axis", "<origin xyz=\"0 0 9\"/><axis")]), r#"warning: joint `hip` has a second <origin>; the first one counts
  --> robot.urdf:20:5
help: remove one of the two"#);
    assert_eq!(robot.joints[0].origin.xyz, [0.0, 0.0, -0.1]);
}

#[test]
fn misspelt_elements() {
    let text = changed(&[("</link>\n  <link name=\"leg\">\n    <inertial>", "</link>\n  <link name=\"leg\">\n    <inertal/>\n    <inertial>")]);
    warned(&text, r#"warning: <inertal> is not an element of <link>; it is ignored
  --> robot.urdf:10:5
help: did you mean <inertial>?"#);
    warned(&changed(&[("</robot>", "  <joints/>\n</robot>")]), r#"warning: <joints> is not an element of <robot>; it is ignored
  --> robot.urdf:23:3
help: did you mean <joint>?"#);
    warned(&changed(&[("<mass value=\"5\"/>", "<mass value=\"5\" valu=\"6\"/>")]), r#"warning: `valu` is not an attribute of <mass>; it is ignored
  --> robot.urdf:12:23
help: did you mean `value`?"#);
    warned(&changed(&[("<axis", "<axes/><axis")]), r#"warning: <axes> is not an element of <joint>; it is ignored
  --> robot.urdf:20:5
help: did you mean <axis>?"#);
}

#[test]
fn undeclared_prefix() {
    warned(&changed(&[("</robot>", "  <gazebo><controller:torque name=\"x\"/></gazebo>\n</robot>")]), r#"warning: the name-space prefix `controller` is not declared; its elements are ignored
  --> robot.urdf:23:12
help: add `xmlns:controller="…"` to <robot>, or remove them"#);
}

#[test]
fn rounded_angles() {
    let robot = warned(&changed(&[("<origin xyz=\"0 0 -0.1\" rpy=\"0 0 0\"/>", "<origin xyz=\"0 0 -0.1\" rpy=\"0 3.1416 0\"/>")]), r#"warning: joint `hip`: pitch 3.1416 is 7.3e-6 rad away from a multiple of π/2
  --> robot.urdf:19:5
help: write 3.141592653589793 if that was meant; the value is used as it stands"#);
    assert_eq!(robot.joints[0].origin.rpy[1].to_string(), "3.1416");
    warned(&changed(&[("<origin xyz=\"0 0 -0.4\" rpy=\"0 0 0\"/>", "<origin xyz=\"0 0 -0.4\" rpy=\"0 -1.5708 0\"/>")]), r#"warning: link `leg`: pitch -1.5708 is 3.7e-6 rad away from a multiple of π/2
  --> robot.urdf:10:5
help: write -1.5707963267948966 if that was meant; the value is used as it stands"#);
    assert!(read(&changed(&[("rpy=\"0 0 0\"", "rpy=\"1.57079632679 0 0\"")])).unwrap().1.is_empty());
}

#[test]
fn rounded_angles_of_massless_frames_share_one_message() {
    let frame = |name: &str| format!("  <link name=\"{name}\"/><joint name=\"{name}\" type=\"fixed\"><parent link=\"leg\"/><child link=\"{name}\"/><origin rpy=\"1.5708 0 0\"/></joint>\n");
    warned(&changed(&[("</robot>", &format!("{}{}{}</robot>", frame("a"), frame("b"), frame("c")))]), r#"warning: joint `a`: roll 1.5708 is 3.7e-6 rad away from a multiple of π/2, and so are those of 2 more frames without mass
  --> robot.urdf:23:85
help: write 1.5707963267948966 if that was meant; the value is used as it stands"#);
}

#[test]
fn heavy_link() {
    warned(&changed(&[("mass value=\"5\"", "mass value=\"5000\"")]), r#"warning: link `leg`: 5000 kg is more than 10 times the 10.000 kg of all others
  --> robot.urdf:10:5
help: masses are in kilograms; were grams written?"#);
}

#[test]
fn inertia_in_wrong_units() {
    let text = changed(&[("ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.02\"", "ixx=\"100000\" ixy=\"0\" ixz=\"0\" iyy=\"100000\" iyz=\"0\" izz=\"20000\"")]);
    warned(&text, r#"warning: link `leg`: a radius of gyration of 141.421 m is impossible for a body of about 0.400 m
  --> robot.urdf:10:5
help: inertia is in kg m²; were kg mm² or g mm² written, or the mass in g?"#);
}

#[test]
fn lengths_in_millimetres() {
    warned(&changed(&[("xyz=\"0 0 -0.1\"", "xyz=\"0 0 -100\"")]), r#"warning: joint `hip`: its origin is 100 m away
  --> robot.urdf:19:5
help: lengths are in metres; were millimetres written?"#);
    warned(&changed(&[("xyz=\"0 0 -0.4\"", "xyz=\"0 0 -400\"")]), r#"warning: link `leg`: its centre of mass is 400 m away
  --> robot.urdf:10:5
help: lengths are in metres; were millimetres written?"#);
}

#[test]
fn axis_that_is_not_a_unit_vector() {
    let robot = warned(&changed(&[("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 2 0\"/>")]), r#"warning: joint `hip`: the axis has length 2.000000, it is normalised
  --> robot.urdf:20:5
help: write a unit vector"#);
    assert_eq!(robot.joints[0].axis, [0.0, 1.0, 0.0]);
    let (robot, warnings) = read(&changed(&[("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0.7071 0.7071 0\"/>")])).unwrap();
    assert!(warnings.is_empty());
    assert!((robot.joints[0].axis[0] - 0.5f64.sqrt()).abs() < 1e-15);
}

#[test]
fn limits_that_are_odd() {
    warned(&changed(&[("effort=\"60\"", "effort=\"-60\"")]), r#"warning: joint `hip`: the effort limit -60 is negative and ignored
  --> robot.urdf:21:5
help: write a positive number"#);
    warned(&changed(&[("    <limit lower=\"-1\" upper=\"1\" effort=\"60\" velocity=\"6\"/>\n", "")]), r#"warning: joint `hip` is revolute but has no <limit>; it is taken as unlimited
  --> robot.urdf:16:3
help: add <limit lower="…" upper="…" effort="…" velocity="…"/> or use type="continuous""#);
}

#[test]
fn broken_collision_shape() {
    let shape = "<collision><geometry><box size=\"1 1\"/></geometry></collision><inertial>";
    warned(&changed(&[("<inertial>", shape)]), r#"warning: link `torso`: collision <box> is ignored, its size is `1 1`: expected 3 numbers, found 2
  --> robot.urdf:3:26
help: correct it; it only serves to guess contact points"#);
}

#[test]
fn what_other_tools_accept_in_xml_is_accepted_without_a_word() {
    let text = changed(&[("<robot", "\n<?xml version=\"1.0\"?>\n<!-- --- a title --- -->\n<robot"), ("<axis", "<!---><mass--><axis")]);
    assert_eq!(read(&text).unwrap().1, Vec::<String>::new());
    assert_eq!(read(&format!("\u{feff}{ROBOT}")).unwrap().1, Vec::<String>::new());
    // The position of what follows on the line stays.
    refused(&changed(&[("<axis xyz=\"0 1 0\"/>", "<!-- -- ä --><axis xyz=\"0 0 0\"/>")]), r#"error: joint `hip`: the axis is zero
  --> robot.urdf:20:18
help: write the direction of motion, such as <axis xyz="0 1 0"/>"#);
}

/// What is fixed together moves together: one part's inertia may be nonsense if the whole has sense.
#[test]
fn indefinite_inertia_of_a_fixed_part() {
    let antenna = "  <link name=\"antenna\"><inertial><mass value=\"1e-6\"/><inertia ixx=\"2e-8\" ixy=\"6e-8\" ixz=\"0\" iyy=\"3e-8\" iyz=\"0\" izz=\"4e-8\"/></inertial></link>
  <joint name=\"a\" type=\"fixed\"><parent link=\"leg\"/><child link=\"antenna\"/></joint>
</robot>";
    let (_, warnings) = read(&changed(&[("</robot>", antenna)])).unwrap();
    let messages: Vec<&str> = warnings.iter().map(String::as_str).collect();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].starts_with("warning: link `antenna`: the inertia is indefinite"), "{messages:?}");
}

#[test]
fn rounding_dust_is_no_inertia() {
    let dust = ("ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.02\"", "ixx=\"0\" ixy=\"0\" ixz=\"2.4e-35\" iyy=\"0\" iyz=\"0\" izz=\"0\"");
    let (_, warnings) = read(&changed(&[dust])).unwrap();
    assert!(!warnings.iter().any(|warning| warning.contains("indefinite")), "{warnings:?}");
}
