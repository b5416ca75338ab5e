#[test]
fn feet() {
    refused(
        "[feet.left_foot]\nlink = \"left_fot\"\npoints.toe = [0, 0, 0]\n",
        r#"error: [feet.left_foot]: the URDF has no link `left_fot`
  --> biped.toml:2:8
help: did you mean `left_foot`?"#,
    );
    refused(
        "[feet.left_foot]\nside = \"lft\"\npoints.toe = [0, 0, 0]\n",
        r#"error: `side` in [feet.left_foot]: expected "left" or "right", found "lft"
  --> biped.toml:2:8
help: did you mean `left`?"#,
    );
    refused(
        "[feet.left_foot]\n",
        r#"error: [feet.left_foot] has no contact points
  --> biped.toml:1:1
help: add [feet.left_foot.points] with lines such as `toe = [0.15, 0.0, -0.05]`"#,
    );
    refused(
        "[feet.left_foot]\npoints.toe = [0, 0]\n",
        r#"error: [feet.left_foot] has no contact points
  --> biped.toml:1:1
help: add [feet.left_foot.points] with lines such as `toe = [0.15, 0.0, -0.05]`

error: `toe` in [feet.left_foot.points]: expected three numbers, found 2
  --> biped.toml:2:14
help: write [x, y, z]"#,
    );
    refused(
        "[feet.left_foot]\npoints.toe = [0, 0, 0]\npoints.heel = [0, 0, 0]\n",
        r#"error: `heel` in [feet.left_foot.points] lies on the point `toe`
  --> biped.toml:3:15
help: give each point a position of its own"#,
    );
    refused(
        "[feet.left_foot]\npoints.toe = [0, 0, 0]\npoints.toe = [0, 0, 1]\n",
        r#"error: broken TOML: duplicate key
  --> biped.toml:3:8
help: texts stand in quotes, lists in [ ], sections begin with [name]; each key stands once"#,
    );
    refused(
        "[feet.left_foot]\npoints.\"big toe\" = [0, 0, 0]\n",
        r#"error: the point name `big toe` is not an identifier
  --> biped.toml:2:20
help: use letters, digits and `_`, beginning with a letter"#,
    );
    refused(
        "[feet.left_foot]\npoints.toe = [0, 0, 0]\nedges.front = [\"toe\", \"te\"]\n",
        r#"error: `front` in [feet.left_foot.edges]: the foot has no point `te`
  --> biped.toml:3:23
help: did you mean `toe`?"#,
    );
    refused(
        "[feet.left_foot]\npoints.toe = [0, 0, 0]\nedges.front = [\"toe\"]\n",
        r#"error: `front` in [feet.left_foot.edges]: expected two points, found 1
  --> biped.toml:3:15
help: write the left point first: ["front_left", "front_right"]"#,
    );
    refused(
        "[feet.left_foot]\npoints.toe = [0, 0, 0]\nedges.toe = [\"toe\", \"toe\"]\n",
        r#"error: `toe` in [feet.left_foot.edges] has the name of a point
  --> biped.toml:3:13
help: contacts are written foot/part: points and edges need different names

error: `toe` in [feet.left_foot.edges]: both ends are `toe`
  --> biped.toml:3:13
help: name two points"#,
    );
}

#[test]
fn symmetry() {
    let pair = |text: &str| format!("[symmetry]\njoints = [\n  {{ {text} }},\n]\n");
    refused(
        &pair("left = \"left_kne_pitch\", right = \"right_knee_pitch\", sign = 1"),
        r#"error: [symmetry]: the URDF has no joint `left_kne_pitch`
  --> biped.toml:3:12
help: did you mean `left_knee_pitch`?"#,
    );
    refused(
        &pair("left = \"left_knee_pitch\""),
        r#"error: a pair of [symmetry] has no `right`
  --> biped.toml:3:3
help: write { left = "…", right = "…", sign = 1 }"#,
    );
    refused(
        &pair("left = \"left_knee_pitch\", right = \"right_knee_pitch\", sign = 2"),
        r#"error: [symmetry]: the sign of `left_knee_pitch` and `right_knee_pitch` is 2
  --> biped.toml:3:66
help: write 1 (pitch joints) or -1 (roll and yaw joints)"#,
    );
    refused(
        &pair("left = \"left_knee_pitch\", right = \"left_knee_pitch\", sign = 1"),
        r#"error: [symmetry]: joint `left_knee_pitch` stands in two pairs
  --> biped.toml:3:39
help: each joint has one mirror image"#,
    );
    warned(
        &pair("left = \"left_knee_pitch\", right = \"right_knee_pitch\", sign = -1"),
        r#"warning: [symmetry]: sign = -1 for `left_knee_pitch` and `right_knee_pitch`, but their axes mirror each other with 1
  --> biped.toml:3:66
help: write sign = 1, or leave it out"#,
    );
    refused_3d(
        &pair("left = \"left_hip_yaw\", right = \"right_hip_roll\""),
        r#"error: [symmetry]: `left_hip_yaw` and `right_hip_roll` do not mirror each other at zero posture
  --> biped.toml:3:3
help: state sign = 1 or -1, or remove the pair"#,
    );
}

#[test]
fn actuation_and_drives() {
    refused(
        "[actuation]\njoints = [\"left_knee\"]\n",
        r#"error: [actuation]: the URDF has no joint `left_knee`
  --> biped.toml:2:11
help: did you mean `left_knee_pitch`?"#,
    );
    refused(
        "[actuation]\njoints = [\"left_knee_pitch\", \"left_knee_pitch\"]\n",
        r#"error: [actuation]: joint `left_knee_pitch` stands there twice
  --> biped.toml:2:30
help: remove one"#,
    );
    refused(
        "[actuation]\njoints = [\"left_knee_pitch\"]\n[drives.left_knee_pitch]\nkind = \"passive\"\n",
        r#"error: [actuation]: joint `left_knee_pitch` has a passive drive
  --> biped.toml:2:11
help: remove it here, or change `kind` under [drives]"#,
    );
    refused(
        "[drives.knee]\ngear_ratio = 5\n",
        r#"error: [drives]: the URDF has no joint `knee`
  --> biped.toml:1:1
help: moving joints: `right_hip_pitch`, `right_knee_pitch`, `right_ankle_pitch`, `left_hip_pitch`, `left_knee_pitch`, `left_ankle_pitch`"#,
    );
    refused(
        "[drives.left_knee_pitch]\nkind = \"stif\"\n",
        r#"error: `kind` in [drives.left_knee_pitch]: unknown drive "stif"
  --> biped.toml:2:8
help: did you mean `stiff`?"#,
    );
    refused(
        "[drives.left_knee_pitch]\ngear_ratio = 0\n",
        r#"error: `gear_ratio` in [drives.left_knee_pitch] is zero
  --> biped.toml:2:14
help: write motor turns per output turn"#,
    );
    refused(
        "[drives.left_knee_pitch]\nrotor_inertia = -1e-6\n",
        r#"error: `rotor_inertia` in [drives.left_knee_pitch] is negative: -0.000001
  --> biped.toml:2:17
help: write zero or more"#,
    );
    refused(
        "[drives.left_knee_pitch]\nkind = \"series_elastic\"\nload_pulley_radius = 0.04\nspring_stiffness = 0\n",
        r#"error: [drives.left_knee_pitch] is series elastic but has no `motor_pulley_radius`
  --> biped.toml:1:1
help: add `motor_pulley_radius = …` (radii in m, stiffness in N/m)

error: `spring_stiffness` in [drives.left_knee_pitch] is zero
  --> biped.toml:4:20
help: write a positive number"#,
    );
}

#[test]
fn phases() {
    let with_feet = |text: &str| format!("{FEET}[[phase]]\n{text}");
    refused(
        &with_feet("contacts = [\"left_foot\"]\n"),
        r#"error: a [[phase]] has no `name`
  --> biped.toml:7:1
help: add name = "single_support""#,
    );
    refused(
        &with_feet("name = \"one\"\n[[phase]]\nname = \"one\"\n"),
        r#"error: the phase name `one` is used twice
  --> biped.toml:10:8
help: rename one of the two phases"#,
    );
    refused(
        &with_feet("name = \"phase one\"\n"),
        r#"error: the phase name `phase one` is not an identifier
  --> biped.toml:8:8
help: use letters, digits and `_`, beginning with a letter"#,
    );
    refused(
        &with_feet("name = \"one\"\nnext = \"tow\"\n"),
        r#"error: `next` in [[phase]]: there is no phase `tow`
  --> biped.toml:9:8
help: phases: `one`"#,
    );
    refused(
        &with_feet("name = \"one\"\ncontacts = [\"leftfoot\"]\n"),
        r#"error: `contacts` in [[phase]]: there is no foot `leftfoot`
  --> biped.toml:9:13
help: did you mean `left_foot`?"#,
    );
    refused(
        &with_feet("name = \"one\"\ncontacts = [\"left_foot/tow\"]\n"),
        r#"error: `contacts` in [[phase]]: foot `left_foot` has no point or edge `tow`
  --> biped.toml:9:13
help: did you mean `toe`?"#,
    );
    refused(
        &with_feet("name = \"one\"\ncontacts = [\"left_foot/toe\", \"left_foot/toe\"]\n"),
        r#"error: `contacts` in [[phase]]: `left_foot/toe` stands there twice
  --> biped.toml:9:30
help: remove one"#,
    );
    refused(
        &with_feet("name = \"one\"\nrelabel = true\n"),
        r#"error: [[phase]]: `relabel` needs to know which joints mirror each other
  --> biped.toml:9:11
help: list the mirrored joints under [symmetry], or remove `relabel`"#,
    );
    let one_foot = "[symmetry]\njoints = [{ left = \"left_knee_pitch\", right = \"right_knee_pitch\" }]\n[feet.left_foot]\npoints.toe = [0, 0, 0]\n[[phase]]\nname = \"one\"\nrelabel = true\n";
    refused(
        one_foot,
        r#"error: [[phase]]: `relabel` needs as many left as right feet, there are 1 and 0
  --> biped.toml:7:11
help: state `side` of every foot"#,
    );
    let line = "[feet.left_foot]\npoints.a = [0, 0.1, 0]\npoints.b = [0, -0.1, 0]\n[[phase]]\nname = \"one\"\ncontacts = [\"left_foot\"]\n";
    refused_3d(
        line,
        r#"error: `contacts` in [[phase]]: foot `left_foot` cannot be flat on 2 points
  --> biped.toml:6:13
help: name a point or edge (foot/part), or give the foot more points"#,
    );
}

#[test]
fn both_files_are_checked_at_once() {
    let urdf = URDF.replace("<mass value=\"11.6\"/>", "<mass value=\"-11.6\"/>");
    let errors = parse(&urdf, Path::new("robot.urdf"), "gravty = 1\n", Path::new("biped.toml")).unwrap_err();
    let files: Vec<_> = errors.0.iter().map(|error| error.file.clone().unwrap()).collect();
    assert_eq!(files, [Path::new("biped.toml"), Path::new("robot.urdf")]);
    // Without a URDF its names are unknown: the description's references are not reported.
    let errors =
        parse("<robot", Path::new("robot.urdf"), "[base]\nlink = \"torso\"\n", Path::new("biped.toml"));
    assert_eq!(errors.unwrap_err().0.len(), 2);
}
