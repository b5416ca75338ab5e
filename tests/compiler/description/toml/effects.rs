fn effect(text: &str) -> String {
    format!("{FEET}[[effect]]\n{text}")
}

#[test]
fn effects_kind() {
    refused(
        &effect("joint = \"left_knee_pitch\"\n"),
        r#"error: an [[effect]] has no `kind`
  --> biped.toml:7:1
help: add kind = "coulomb_friction"; kinds are: viscous_friction, quadratic_drag, coulomb_friction, asymmetric_coulomb_friction, stribeck_friction, load_dependent_friction, rotor_inertia, payload, com_offset, inertia_error, inertial_correction, parallel_spring, series_elasticity, backlash, torque_gain, torque_bias, torque_saturation, torque_ripple, actuator_delay, encoder_offset, gravity_tilt, ground_slope, force_sensor_gain, force_sensor_bias, force_sensor_saturation, ground_compliance, impact_restitution, foot_slip, spin_friction, coupling, point_feet, no_impact, single_mass, decoupled_planes, formula"#,
    );
    refused(
        &effect("kind = \"coulomb_frction\"\njoint = \"left_knee_pitch\"\ntorque = 0.4\n"),
        r#"error: `kind` in [[effect]]: there is no effect `coulomb_frction`
  --> biped.toml:8:8
help: did you mean `coulomb_friction`?"#,
    );
    refused(
        &effect("kind = \"magic\"\n"),
        r#"error: `kind` in [[effect]]: there is no effect `magic`
  --> biped.toml:8:8
help: kinds are: viscous_friction, quadratic_drag, coulomb_friction, asymmetric_coulomb_friction, stribeck_friction, load_dependent_friction, rotor_inertia, payload, com_offset, inertia_error, inertial_correction, parallel_spring, series_elasticity, backlash, torque_gain, torque_bias, torque_saturation, torque_ripple, actuator_delay, encoder_offset, gravity_tilt, ground_slope, force_sensor_gain, force_sensor_bias, force_sensor_saturation, ground_compliance, impact_restitution, foot_slip, spin_friction, coupling, point_feet, no_impact, single_mass, decoupled_planes, formula"#,
    );
    refused(
        &effect("kind = 3\n"),
        r#"error: `kind` in [[effect]]: expected a text in quotes, found the number 3
  --> biped.toml:8:8
help: write a text in quotes"#,
    );
}

#[test]
fn effects_keys() {
    refused(
        &effect("kind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorqe = 0.4\n"),
        r#"error: [[effect]] `coulomb_friction` has no `torque`
  --> biped.toml:7:1
help: add `torque = …`: friction torque, N m

error: unknown key `torqe` in [[effect]]
  --> biped.toml:10:1
help: did you mean `torque`?"#,
    );
    refused(
        &effect("kind = \"coulomb_friction\"\nlink = \"torso\"\ntorque = 0.4\n"),
        r#"error: [[effect]] `coulomb_friction` has no `joint`
  --> biped.toml:7:1
help: `coulomb_friction` acts at a joint: write joint = "…"

error: `link` in [[effect]] has no meaning for `coulomb_friction`
  --> biped.toml:9:1
help: `coulomb_friction` acts at a joint: write joint = "…""#,
    );
    refused(
        &effect("kind = \"payload\"\njoint = \"left_knee_pitch\"\nmass = 1.0\nx = 0\ny = 0\nz = 0\n"),
        r#"error: [[effect]] `payload` has no `link`
  --> biped.toml:7:1
help: `payload` belongs to a link: write link = "…"

error: `joint` in [[effect]] has no meaning for `payload`
  --> biped.toml:9:1
help: `payload` belongs to a link: write link = "…""#,
    );
    refused(
        &effect("kind = \"gravity_tilt\"\njoint = \"left_knee_pitch\"\nroll = 0.01\npitch = 0.0\n"),
        r#"error: `joint` in [[effect]] has no meaning for `gravity_tilt`
  --> biped.toml:9:1
help: `gravity_tilt` belongs to the whole robot and has no place: remove the key"#,
    );
    refused(
        &effect("kind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\nother_joint = \"left_hip_pitch\"\ndamping = 1\n"),
        r#"error: `other_joint` in [[effect]] has no meaning for `viscous_friction`
  --> biped.toml:10:1
help: `viscous_friction` acts at a joint: write joint = "…""#,
    );
}

#[test]
fn effects_places() {
    refused(
        &effect("kind = \"viscous_friction\"\ndamping = 1\n"),
        r#"error: [[effect]] `viscous_friction` has no `joint`
  --> biped.toml:7:1
help: `viscous_friction` acts at a joint: write joint = "…""#,
    );
    refused(
        &effect("kind = \"viscous_friction\"\njoint = \"left_kne_pitch\"\ndamping = 1\n"),
        r#"error: [[effect]]: the URDF has no joint `left_kne_pitch`
  --> biped.toml:9:9
help: did you mean `left_knee_pitch`?"#,
    );
    refused(
        &effect("kind = \"coupling\"\njoint = \"left_knee_pitch\"\nother_joint = \"left_knee_pitch\"\ninertia = 0\ndamping = 1\ncoulomb = 0\nstiffness = 0\n"),
        r#"error: [[effect]]: `joint` and `other_joint` are the same
  --> biped.toml:10:15
help: name the joint whose motion causes the torque"#,
    );
    refused(
        &effect("kind = \"com_offset\"\nlink = \"tors\"\nx = 0\ny = 0\nz = 0\n"),
        r#"error: [[effect]]: the URDF has no link `tors`
  --> biped.toml:9:8
help: did you mean `torso`?"#,
    );
    refused(
        &effect("kind = \"force_sensor_gain\"\nsensor = \"left_fot\"\ngain = 1.1\n"),
        r#"error: `sensor` in [[effect]]: there is no foot `left_fot`
  --> biped.toml:9:10
help: did you mean `left_foot`?"#,
    );
    refused(
        &effect("kind = \"force_sensor_gain\"\nsensor = \"left_foot/tow\"\ngain = 1.1\n"),
        r#"error: `sensor` in [[effect]]: foot `left_foot` has no corner `tow`
  --> biped.toml:9:10
help: did you mean `toe`?"#,
    );
}

#[test]
fn effects_numbers() {
    refused(
        &effect("kind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = -1\n"),
        r#"error: `damping` in [[effect]]: -1 is not possible, expected 0 N m s/rad or more
  --> biped.toml:10:11
help: it is the damping coefficient"#,
    );
    refused(
        &effect("kind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = \"1\"\n"),
        r#"error: `damping` in [[effect]]: expected a number, found the text "1"
  --> biped.toml:10:11
help: write a number"#,
    );
    refused(
        &effect("kind = \"load_dependent_friction\"\njoint = \"left_knee_pitch\"\ncoefficient = 1.2\n"),
        r#"error: `coefficient` in [[effect]]: 1.2 is not possible, expected 0 to 0.95
  --> biped.toml:10:15
help: it is the friction per load torque"#,
    );
    refused(
        &effect("kind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 0.4\nsmoothing = 0\n"),
        r#"error: `smoothing` in [[effect]]: 0 is not possible, expected 0.000001 rad/s or more
  --> biped.toml:11:13
help: it is the speed over which friction changes its sign"#,
    );
}

#[test]
fn effects_twins() {
    refused(
        &effect("kind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 1\n[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 2\n"),
        r#"error: [[effect]]: `viscous_friction` at `left_knee_pitch` stands there twice
  --> biped.toml:11:1
help: remove one, or merge the two"#,
    );
    refused(
        &effect("kind = \"formula\"\nname = \"a\"\njoint = \"left_knee_pitch\"\ntorque = \"position\"\n[[effect]]\nkind = \"formula\"\nname = \"a\"\njoint = \"right_knee_pitch\"\ntorque = \"position\"\n"),
        r#"error: `name` in [[effect]]: `a` is used twice
  --> biped.toml:14:8
help: rename one of the two effects"#,
    );
}

#[test]
fn effects_formulas() {
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\n"),
        r#"error: [[effect]] `formula` has no `torque`
  --> biped.toml:7:1
help: add torque = "k * sin(3 * position) * velocity", a formula in N m"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = 0.4\n"),
        r#"error: `torque` in [[effect]]: expected a text in quotes, found the number 0.4
  --> biped.toml:10:10
help: write a text in quotes"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"2 * sin(velocity\"\n"),
        r#"error: `torque` in [[effect]]: `)` expected
  --> biped.toml:10:27
help: is the parenthesis not closed, or are there too many arguments?"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"2 * velocty\"\n"),
        r#"error: `torque` in [[effect]]: `velocty` is neither a variable nor a parameter
  --> biped.toml:10:15
help: did you mean `velocity`?"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"k * velocity\"\n"),
        r#"error: `torque` in [[effect]]: `k` is neither a variable nor a parameter
  --> biped.toml:10:11
help: add `parameters.k = 1.0`; variables are: position, velocity, acceleration, load, other_position, other_velocity, other_acceleration"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"\"\"\nposition \\\n    * k\"\"\"\n"),
        r#"error: `torque` in [[effect]]: `k` is neither a variable nor a parameter
  --> biped.toml:12:7
help: add `parameters.k = 1.0`; variables are: position, velocity, acceleration, load, other_position, other_velocity, other_acceleration"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"position \\u002A k\"\n"),
        r#"error: `torque` in [[effect]]: `k` is neither a variable nor a parameter
  --> biped.toml:10:27
help: add `parameters.k = 1.0`; variables are: position, velocity, acceleration, load, other_position, other_velocity, other_acceleration"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"other_position\"\n"),
        r#"error: `torque` in [[effect]]: `other_position` needs another joint
  --> biped.toml:10:11
help: add other_joint = "…""#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\nname = \"my cable\"\ntorque = \"position\"\n"),
        r#"error: the effect name `my cable` is not an identifier
  --> biped.toml:10:8
help: use letters, digits and `_`, beginning with a letter"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorqe = \"position\"\n"),
        r#"error: [[effect]] `formula` has no `torque`
  --> biped.toml:7:1
help: add torque = "k * sin(3 * position) * velocity", a formula in N m

error: unknown key `torqe` in [[effect]]
  --> biped.toml:10:1
help: did you mean `torque`?"#,
    );
}

#[test]
fn effects_formula_parameters() {
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"velocity\"\nparameters.velocity = 3\n"),
        r#"error: the parameter name `velocity` has a meaning already
  --> biped.toml:11:12
help: rename it; taken are: position, velocity, acceleration, load, other_position, other_velocity, other_acceleration, smoothing, sin, cos, tan, tanh, exp, sqrt, abs, sign, min, max, clip, pi"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"velocity\"\nparameters.k = 3\n"),
        r#"error: `torque` in [[effect]]: the parameter `k` does not stand in it
  --> biped.toml:10:10
help: remove the parameter, or use it: it cannot be estimated"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"k * velocity\"\nparameters.k = { value = 3, units = \"1\" }\n"),
        r#"error: unknown key `units` in the formula's parameter `k`
  --> biped.toml:11:29
help: did you mean `unit`?"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"k * velocity\"\nparameters.k = { min = 3 }\n"),
        r#"error: the formula's parameter `k` has no `value`
  --> biped.toml:11:16
help: add value = …, at least a first guess"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"k * velocity\"\nparameters.k = { value = 3, unit = \"N m\", min = 4, max = 5 }\n"),
        r#"error: `k` in [parameters]: 3 is out of its bounds, 4 to 5 N m
  --> biped.toml:11:16
help: change the value, or `min` and `max`"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"k * velocity\"\nparameters.k = { value = 3, min = 5, max = 4 }\n"),
        r#"error: `k` in [parameters]: `min` 5 is not below `max` 4
  --> biped.toml:11:16
help: exchange or remove them"#,
    );
    refused(
        &effect("kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"k * velocity\"\nparameters.k = \"3\"\n"),
        r#"error: `k` in [parameters]: expected a number, found the text "3"
  --> biped.toml:11:16
help: write a number"#,
    );
}

#[test]
fn formulas_without_a_value() {
    refused(
        &effect(
            "kind = \"formula\"\njoint = \"left_knee_pitch\"\ntorque = \"velocity / (k - 1)\"\nparameters.k = 1\n",
        ),
        r#"error: `torque` in [[effect]]: it divides by zero, whatever the state is
  --> biped.toml:10:10
help: change the formula or its parameters"#,
    );
}

#[test]
fn unusual_numbers_are_warned_of() {
    warned(
        &effect("kind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 43.0\n"),
        r#"warning: `torque` in [[effect]]: 43 is unusual, usual is 0 to 30 N m
  --> biped.toml:10:10
help: is it in N m? It is the friction torque"#,
    );
}

#[test]
fn effects_are_read() {
    let toml = effect(
        "kind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 0.43\n
[[effect]]\nkind = \"formula\"\nname = \"cable\"\njoint = \"left_knee_pitch\"\nother_joint = \"left_hip_pitch\"
torque = \"k * sin(3 * position) * sign(other_velocity) + c\"
parameters.k = { value = 0.1, unit = \"N m s/rad\", min = 0.0, max = 2.0 }\nparameters.c = 1
[[effect]]\nkind = \"payload\"\nlink = \"torso\"\nmass = 1\nx = 0\ny = 0\nz = 0.1
[[effect]]\nkind = \"force_sensor_gain\"\nsensor = \"left_foot/toe\"\ngain = 1.1
[[effect]]\nkind = \"no_impact\"\n",
    );
    let (robot, warnings) = read(URDF, &toml).unwrap();
    assert_eq!(warnings, "");
    let kinds: Vec<&str> = robot.effects.iter().map(|effect| effect.kind.name).collect();
    assert_eq!(kinds, ["coulomb_friction", "formula", "payload", "force_sensor_gain", "no_impact"]);
    assert_eq!(robot.effects[0].value("torque"), 0.43);
    assert_eq!(robot.effects[0].value("smoothing"), 0.02);
    let cable = &robot.effects[1];
    assert_eq!((cable.name.as_deref(), cable.value("k"), cable.value("c")), (Some("cable"), 0.1, 1.0));
    assert_eq!((cable.unit("k"), cable.bounds("k")), ("N m s/rad", (0.0, 2.0)));
    assert_eq!((cable.unit("c"), cable.bounds("c").1), ("1", f64::INFINITY));
    assert_eq!(cable.value("smoothing"), 0.02);
    assert_eq!(cable.location.to_string(), "left_knee_pitch from left_hip_pitch");
    assert_eq!(robot.effects[3].location.sensor.as_deref(), Some("left_foot/toe"));
    assert!(robot.without_effects().effects.is_empty());
}

#[test]
fn every_kind_and_parameter_stands_in_the_documentation() {
    let text = include_str!("../../../../robots/README.md");
    let text = text.split_once("### `[[effect]]`").unwrap().1;
    for kind in bipedc_effects::effect::KINDS {
        let row = format!("| `{}` |", kind.name);
        let line = text.lines().find(|line| line.starts_with(&row));
        let line = line.unwrap_or_else(|| panic!("robots/README.md has no row `{row}`"));
        for parameter in kind.parameters {
            let words = format!("`{}` ({})", parameter.name, parameter.unit);
            assert!(line.contains(&words), "{}: no {words} in robots/README.md", kind.name);
        }
    }
}
