#[test]
fn broken_toml() {
    refused(
        "gravity = [0, 0\n",
        r#"error: broken TOML: unclosed array, expected `]`
  --> biped.toml:1:16
help: texts stand in quotes, lists in [ ], sections begin with [name]; each key stands once"#,
    );
    refused(
        "name = \"a\"\nname = \"b\"\n",
        r#"error: broken TOML: duplicate key
  --> biped.toml:2:1
help: texts stand in quotes, lists in [ ], sections begin with [name]; each key stands once"#,
    );
}

#[test]
fn unknown_keys() {
    refused(
        "gravty = [0, 0, -9.81]\n",
        r#"error: unknown key `gravty` at the top level
  --> biped.toml:1:1
help: did you mean `gravity`?"#,
    );
    refused(
        "[base]\nkind = \"fixed\"\nlnk = \"torso\"\n",
        r#"error: unknown key `lnk` in [base]
  --> biped.toml:3:1
help: did you mean `link`?"#,
    );
    refused(
        "[feet.left_foot]\npoint.toe = [0, 0, 0]\npoints.toe = [0, 0, 0]\n",
        r#"error: unknown key `point` in [feet.left_foot]
  --> biped.toml:2:1
help: did you mean `points`?"#,
    );
    refused(
        "[drives.left_knee_pitch]\ngear_ration = 5\n",
        r#"error: unknown key `gear_ration` in [drives.left_knee_pitch]
  --> biped.toml:2:1
help: did you mean `gear_ratio`?"#,
    );
    refused(
        "[drives.left_knee_pitch]\nspring_stiffness = 5\n",
        r#"error: unknown key `spring_stiffness` in [drives.left_knee_pitch]
  --> biped.toml:2:1
help: known keys: `kind`, `gear_ratio`, `rotor_inertia`, `torque_constant`, `viscous_friction`, `coulomb_friction`, `motor_encoder_counts`, `joint_encoder_counts`"#,
    );
    refused(
        "[[phase]]\nname = \"a\"\ncontact = []\n",
        r#"error: unknown key `contact` in [[phase]]
  --> biped.toml:3:1
help: did you mean `contacts`?"#,
    );
    refused(
        "[generate]\nfunction = []\n",
        r#"error: unknown key `function` in [generate]
  --> biped.toml:2:1
help: did you mean `functions`?"#,
    );
    refused(
        "[actuation]\njoint = []\n",
        r#"error: unknown key `joint` in [actuation]
  --> biped.toml:2:1
help: did you mean `joints`?"#,
    );
    refused(
        "[symmetry]\njoints = [{ left = \"left_knee_pitch\", right = \"right_knee_pitch\", sine = 1 }]\n",
        r#"error: unknown key `sine` in the pairs of [symmetry]
  --> biped.toml:2:67
help: did you mean `sign`?"#,
    );
}

#[test]
fn wrong_types() {
    refused(
        "gravity = 9.81\n",
        r#"error: `gravity` at the top level: expected three numbers, such as [0.0, 0.0, -0.1], found the number 9.81
  --> biped.toml:1:11
help: write three numbers, such as [0.0, 0.0, -0.1]"#,
    );
    refused(
        "gravity = [0, -9.81]\n",
        r#"error: `gravity` at the top level: expected three numbers, found 2
  --> biped.toml:1:11
help: write [x, y, z]"#,
    );
    refused(
        "gravity = [0, 0, nan]\n",
        r#"error: `gravity` at the top level: expected a finite number, found the number nan
  --> biped.toml:1:18
help: write a finite number"#,
    );
    refused(
        "name = 5\n",
        r#"error: `name` at the top level: expected a text in quotes, found the number 5
  --> biped.toml:1:8
help: write a text in quotes"#,
    );
    refused(
        "base = \"floating\"\n",
        r#"error: `base` at the top level: expected a table, found the text "floating"
  --> biped.toml:1:8
help: write a table"#,
    );
    refused(
        "phase = 1\n",
        r#"error: `phase` at the top level: expected an array of tables, found the number 1
  --> biped.toml:1:9
help: write an array of tables"#,
    );
    refused(
        "[phase]\nname = \"single_support\"\ncontacts = [\"left_foot\"]\n",
        r#"error: [phase] is one table of a list
  --> biped.toml:1:1
help: write [[phase]], with two brackets

error: `contacts` in [[phase]]: there is no foot `left_foot`
  --> biped.toml:3:13
help: feet under [feet]: none"#,
    );
    refused(
        "[generate]\nruntime_parameters = \"yes\"\n",
        r#"error: `runtime_parameters` in [generate]: expected true or false, found the text "yes"
  --> biped.toml:2:22
help: write true or false"#,
    );
}

#[test]
fn base() {
    refused(
        "[base]\nkind = \"floatin\"\n",
        r#"error: `kind` in [base]: unknown base "floatin"
  --> biped.toml:2:8
help: did you mean `floating`?"#,
    );
    refused(
        "[base]\nkind = \"floating\"\nroot = \"trso\"\n",
        r#"error: [base]: the URDF has no link `trso`
  --> biped.toml:3:8
help: did you mean `torso`?"#,
    );
    refused(
        "[base]\nkind = \"fixed\"\nlink = \"stand\"\n",
        r#"error: [base]: the URDF has no link `stand`
  --> biped.toml:3:8
help: links of the URDF: `torso`, `right_upper_leg`, `right_lower_leg`, `right_foot`, `left_upper_leg`, `left_lower_leg`, `left_foot`"#,
    );
    refused(
        "[base]\nkind = \"pivot\"\n",
        r#"error: [base]: kind "pivot" needs `about`
  --> biped.toml:1:1
help: write about = "foot/point" (planar robots) or "foot/edge""#,
    );
    refused(
        &format!("[base]\nkind = \"pivot\"\nabout = \"left_foot/tip\"\n{FEET}"),
        r#"error: [base]: foot `left_foot` has no point or edge `tip`
  --> biped.toml:3:9
help: its parts: `heel`, `toe`"#,
    );
    refused(
        "[base]\nkind = \"pivot\"\nabout = \"toe\"\n",
        r#"error: [base]: `about = "toe"` is not of the form "foot/part"
  --> biped.toml:3:9
help: write about = "right_foot/toe" or "right_foot/front""#,
    );
    refused(
        &format!("[base]\nkind = \"planar\"\nroot = \"left_foot/tip\"\n{FEET}"),
        r#"error: [base]: foot `left_foot` has no point `tip`
  --> biped.toml:3:8
help: its points: `heel`, `toe`"#,
    );
    refused(
        "[base]\nkind = \"planar\"\nroot = \"left_feet/tip\"\n",
        r#"error: [base]: there is no foot `left_feet`
  --> biped.toml:3:8
help: feet under [feet]: none"#,
    );
}

#[test]
fn planar_robots_stay_in_their_plane() {
    refused_3d(
        "[base]\nkind = \"planar\"\n[actuation]\njoints = []\n",
        r#"error: [base]: the robot is planar, but joint `right_hip_yaw` leaves the x-z plane
  --> biped.toml:1:1
help: use kind = "floating", or fix the joint in the URDF

error: [base]: the robot is planar, but joint `left_hip_yaw` leaves the x-z plane
  --> biped.toml:1:1
help: use kind = "floating", or fix the joint in the URDF

error: [base]: the robot is planar, but joint `right_hip_roll` leaves the x-z plane
  --> biped.toml:1:1
help: use kind = "floating", or fix the joint in the URDF

error: [base]: the robot is planar, but joint `right_ankle_roll` leaves the x-z plane
  --> biped.toml:1:1
help: use kind = "floating", or fix the joint in the URDF

error: [base]: the robot is planar, but joint `left_hip_roll` leaves the x-z plane
  --> biped.toml:1:1
help: use kind = "floating", or fix the joint in the URDF

error: [base]: the robot is planar, but joint `left_ankle_roll` leaves the x-z plane
  --> biped.toml:1:1
help: use kind = "floating", or fix the joint in the URDF"#,
    );
    refused(
        "gravity = [0, 1, -9.81]\n[base]\nkind = \"planar\"\n",
        r#"error: a planar robot cannot have gravity along y
  --> biped.toml:1:11
help: write gravity = [0.0, 0.0, -9.81]"#,
    );
}

#[test]
fn upward_gravity() {
    warned(
        "gravity = [0, 0, 9.81]\n",
        r#"warning: gravity points up: its z component is 9.81 m/s²
  --> biped.toml:1:11
help: write gravity = [0.0, 0.0, -9.81]"#,
    );
}

#[test]
fn impossible_sizes() {
    refused(
        "gravity = [0.0, 0.0, -1e200]\n",
        r#"error: `gravity` at the top level: the number -1e200 is too large
  --> biped.toml:1:22
help: numbers in SI units are at most 1e12 in size: is the unit right?"#,
    );
    refused(
        "[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 1e-320\n",
        r#"error: `damping` in [[effect]]: the number 1e-320 is too small
  --> biped.toml:4:11
help: numbers in SI units are 0 or at least 1e-100 in size: write 0"#,
    );
}
