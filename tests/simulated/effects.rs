//! Every kind of the library, simulated: the log differs from that of the nominal robot as the effect's definition says.
//!
//! Kinds that act at joints are held against the amended robot's derived `inverse_dynamics`: with exact sensors it gives
//! the logged effort. The others are held against their definition in words (`bipedc effects`).
use super::{JOINT, SETTLED, STAND, SWING, Torques, robot, scenario, simulate, tulip};
use bipedc::simulation::{plant, true_model};
use bipedc_analysis::simulate::{Mechanics, Simulation};
use bipedc_effects::effect::{KINDS, Law};

/// Effects at joints.
fn at_joints(kind: &str) -> String {
    let own = |kind: &str, rest: &str| format!("[[effect]]\nkind = \"{kind}\"\n{rest}\n");
    let joint = |rest: &str| own(kind, &format!("joint = \"{JOINT}\"\n{rest}"));
    let link = |rest: &str| own(kind, &format!("link = \"left_tibia\"\n{rest}"));
    match kind {
        "viscous_friction" => joint("damping = 1.5"),
        "coulomb_friction" => joint("torque = 0.8"),
        "asymmetric_coulomb_friction" => joint("positive = 0.8\nnegative = 1.7"),
        "stribeck_friction" => joint("coulomb = 0.8\nstatic = 1.6\nstribeck_velocity = 0.5"),
        "load_dependent_friction" => joint("coefficient = 0.2"),
        "rotor_inertia" => joint("inertia = 0.08"),
        "quadratic_drag" => joint("drag = 0.6"),
        "parallel_spring" => joint("stiffness = 40.0\nrest_angle = 0.2"),
        "torque_gain" => joint("gain = 0.85"),
        "torque_bias" => joint("bias = 0.9"),
        "torque_saturation" => joint("limit = 10.0"),
        "torque_ripple" => joint("amplitude = 0.7\nperiods_per_turn = 20.0\nphase = 0.4"),
        "encoder_offset" => joint("offset = 0.05"),
        "payload" => link("mass = 1.2\nx = 0.05\ny = 0.0\nz = -0.1"),
        "com_offset" => link("x = 0.03\ny = 0.0\nz = -0.05"),
        "inertia_error" => link("ixx = 0.02\nixy = 0.0\nixz = 0.0\niyy = 0.08\niyz = 0.0\nizz = 0.07"),
        "inertial_correction" => {
            link("mass = 0.8\nx = 0.02\ny = 0.0\nz = -0.03\nixx = 0.01\niyy = 0.03\nizz = 0.03")
        }
        "gravity_tilt" => own(kind, "roll = 0.0\npitch = 0.1"),
        "coupling" => {
            let pair = |a: &str, b: &str, rest: &str| {
                own(kind, &format!("joint = \"{a}\"\nother_joint = \"{b}\"\ninertia = 0.06\n{rest}"))
            };
            pair(JOINT, "left_hip_pitch", "damping = 0.4\ncoulomb = 0.5\nstiffness = 3.0")
                + &pair("left_hip_pitch", JOINT, "damping = 0.0\ncoulomb = 0.0\nstiffness = 0.0")
        }
        "formula" => joint(
            "torque = \"k * sin(3 * position) * velocity + c * sign(velocity) + m * acceleration\"\nparameters = { k = 0.9, c = 0.4, m = { value = 0.05 } }",
        ),
        _ => unreachable!("{kind}"),
    }
}

#[test]
fn efforts_are_those_of_the_amended_robot() {
    let five = robot("five_link", Some("fixed"));
    let nominal = Torques::of(&five, "");
    let log = simulate(&five, SWING);
    let plain = nominal.worst(&log, f64::INFINITY);
    println!("nominal: {plain:.2e} N m");
    assert!(plain < 1e-4);
    for kind in KINDS {
        let clip = if kind.name == "torque_saturation" { 10.0 } else { f64::INFINITY };
        match kind.law {
            Law::Torque(_) | Law::Reading(_) | Law::TrueTorque(_) | Law::Formula => {}
            Law::EncoderOffset
            | Law::Payload
            | Law::CenterOfMassOffset
            | Law::InertiaError
            | Law::InertialCorrection => {}
            Law::GravityTilt => {}
            _ => continue,
        }
        let effects = at_joints(kind.name);
        let log = simulate(&five, &format!("{SWING}{effects}"));
        let (with, without) =
            (Torques::of(&five, &effects).worst(&log, clip), nominal.worst(&log, f64::INFINITY));
        println!("{}: {with:.2e} N m with the effect, {without:.2e} without", kind.name);
        // Friction that follows the load follows that of the last step.
        let late = if kind.name == "load_dependent_friction" { 3e-2 } else { 1e-3 };
        assert!(with < late, "{}: {with}", kind.name);
        assert!(without > 0.1, "{}: {without}", kind.name);
    }
}

#[test]
fn late_torques_act_late() {
    let five = robot("five_link", Some("fixed"));
    let held = SWING.replace("servo = \"drive\"\n", "");
    let late = format!("{held}[[effect]]\nkind = \"actuator_delay\"\njoint = \"{JOINT}\"\ndelay = 0.00775\n");
    let log = simulate(&five, &late);
    let nominal = Torques::of(&five, "");
    let effort = log.all(&format!("{JOINT}/effort"));
    let (mut with, mut without) = (0.0_f64, 0.0_f64);
    for row in 200..log.rows.len() - 1 {
        let missed = nominal.missed(&log, row, f64::INFINITY).0[3];
        let needed = effort[row] - missed;
        // 15.5 steps.
        let earlier = 0.5 * (effort[row - 15] + effort[row - 16]);
        with = with.max((earlier - needed).abs());
        without = without.max(missed.abs());
    }
    println!("actuator_delay: {with:.2e} N m with the effect, {without:.2e} without");
    assert!(with < 5e-3 && without > 0.1);
    let inside = format!("{SWING}{}", &late[held.len()..]);
    let plant = plant(&five.description, &five.tree().unwrap()).unwrap();
    let scenario = scenario(&plant, &inside).unwrap();
    let model = true_model(&five, &[]).unwrap();
    let refused = Simulation::new(Mechanics::new(&model, plant.layout.base).unwrap(), &plant, &scenario);
    assert!(refused.err().is_some_and(|e| e.to_string().contains("not late")));
}

/// Motor minus joint angle is what the transmitted torque makes of it.
#[test]
fn springs_and_play_lie_between_motor_and_joint() {
    let five = robot("five_link", Some("fixed"));
    let nominal = Torques::of(&five, "");
    let rotor = format!("[[effect]]\nkind = \"rotor_inertia\"\njoint = \"{JOINT}\"\ninertia = 0.05\n");
    for (kind, text) in [("series_elasticity", "stiffness = 250.0"), ("backlash", "gap = 0.02")] {
        let log = simulate(
            &five,
            &format!("{SWING}{rotor}[[effect]]\nkind = \"{kind}\"\njoint = \"{JOINT}\"\n{text}\n"),
        );
        let (motor, joint) =
            (log.all(&format!("{JOINT}/motor_position")), log.all(&format!("{JOINT}/position")));
        let effort = log.all(&format!("{JOINT}/effort"));
        let mut errors = Vec::new();
        for row in SETTLED..log.rows.len() - 1 {
            // What the rigid robot needs is what is transmitted.
            let transmitted = effort[row] - nominal.missed(&log, row, f64::INFINITY).0[3];
            let apart = motor[row] - joint[row];
            let law = if kind == "backlash" { 0.01_f64.copysign(transmitted) } else { transmitted / 250.0 };
            if kind == "backlash" {
                assert!(apart.abs() < 0.01 + 1e-9, "{apart}");
            }
            if kind != "backlash" || transmitted.abs() > 3.0 {
                errors.push((apart - law).abs());
            }
        }
        errors.sort_by(f64::total_cmp);
        // But for the instants in which play is crossed.
        let worst = errors[if kind == "backlash" { errors.len() * 98 / 100 } else { errors.len() - 1 }];
        println!("{kind}: {worst:.2e} rad");
        assert!(worst < 1e-5, "{kind}: {worst}");
    }
}

fn effect(kind: &str, parameters: &str) -> String {
    format!("[[effect]]\nkind = \"{kind}\"\n{parameters}\n")
}

#[test]
fn force_sensors_report_what_their_effects_make_of_it() {
    let nominal = tulip("");
    let names = ["left_foot/force/z", "left_foot/front_left/force/z", "right_foot/force/z"];
    let of = |log: &super::Log| names.map(|name| log.all(name));
    let [left, corner, right] = of(&nominal);
    let check = |text: &str, law: &dyn Fn(f64, f64, f64) -> [f64; 3]| {
        let found = of(&tulip(text));
        for i in 0..left.len() {
            let expected = law(left[i], corner[i], right[i]);
            for (k, expected) in expected.iter().enumerate() {
                assert!((found[k][i] - expected).abs() < 1e-6, "{text} {k} {i}: {} {expected}", found[k][i]);
            }
        }
    };
    check(&effect("force_sensor_gain", "gain = 1.2\nsensor = \"left_foot\""), &|l, c, r| {
        [1.2 * l, 1.2 * c, r]
    });
    check(
        &effect("force_sensor_bias", "x = 0.0\ny = 1.0\nz = 5.0\nsensor = \"left_foot/front_left\""),
        &|l, c, r| [l, c + 5.0, r],
    );
    check(&effect("force_sensor_saturation", "limit = 20.0"), &|l, c, r| {
        [l.min(20.0), c.min(20.0), r.min(20.0)]
    });
}

#[test]
fn a_sloping_ground_turns_the_robot_that_stands_on_it() {
    // It begins with its soles on the slope, and stays so: the joints give a little.
    let turned = "[initial]\nbase_rotation = [0.02, -0.03, 0.0]\n";
    let log = tulip(&format!("{turned}{}", effect("ground_slope", "roll = 0.02\npitch = -0.03")));
    let [x, y] = ["x", "y"].map(|axis| 2.0 * log.last(&format!("base/orientation/{axis}")));
    println!("ground_slope: roll {x:.4} rad, pitch {y:.4} rad");
    assert!((x - 0.02).abs() < 0.008 && (y + 0.03).abs() < 0.008, "{x} {y}");
    // The ground carries the weight, along the vertical of the world.
    let total = |axis: &str| {
        ["left_foot", "right_foot"].map(|foot| log.last(&format!("{foot}/force/{axis}"))).iter().sum::<f64>()
    };
    let [side, front, up] = ["x", "y", "z"].map(total);
    println!("forces {side:.2}, {front:.2}, {up:.2} N");
    assert!(side.abs() < 0.02 * up && front.abs() < 0.02 * up && up > 150.0);
    // In the plane.
    let seven = robot("seven_link", None);
    let text = format!(
        "{STAND}[initial]\nbase_rotation = [-0.03]\n{}",
        effect("ground_slope", "roll = 0.0\npitch = -0.03")
    );
    let log = simulate(&seven, &text);
    let (pitch, [front, up]) = (
        log.last("base/orientation/pitch"),
        ["x", "z"].map(|axis| {
            ["left_foot", "right_foot"]
                .map(|foot| log.last(&format!("{foot}/force/{axis}")))
                .iter()
                .sum::<f64>()
        }),
    );
    println!("in the plane: pitch {pitch:.4} rad, forces {front:.2}, {up:.2} N");
    assert!((pitch + 0.03).abs() < 0.01 && front.abs() < 0.03 * up && up > 150.0);
    let refused = plant(&seven.description, &seven.tree().unwrap()).unwrap();
    let rolled = format!("duration = 1.0\n{}", effect("ground_slope", "roll = 0.1\npitch = 0.1"));
    assert!(scenario(&refused, &rolled).unwrap_err().contains("`roll` of a robot in the plane"));
}

#[test]
fn a_tilted_log_is_the_same_motion_in_other_axes() {
    let push = "[initial]\nbase_velocity = [0.1, 0.05, 0.0]\n";
    let tilted = tulip(&format!("{push}{}", effect("gravity_tilt", "roll = 0.05\npitch = 0.1")));
    let plain = tulip(push);
    let (roll, pitch) = (0.05_f64, 0.1_f64);
    // R_y(pitch) R_x(roll), from the log's axes to the world's.
    let turn = |[x, y, z]: [f64; 3]| {
        let (y, z) = (y * roll.cos() - z * roll.sin(), y * roll.sin() + z * roll.cos());
        [x * pitch.cos() + z * pitch.sin(), y, -x * pitch.sin() + z * pitch.cos()]
    };
    for row in [0, 50, 300, 599] {
        for quantity in ["base/position", "base/linear_velocity", "left_foot/force"] {
            let of =
                |log: &super::Log| ["x", "y", "z"].map(|axis| log.at(row, &format!("{quantity}/{axis}")));
            let (found, expected) = (turn(of(&tilted)), of(&plain));
            for i in 0..3 {
                assert!(
                    (found[i] - expected[i]).abs() < 1e-6 * (1.0 + expected[i].abs()),
                    "{quantity} {found:?} {expected:?}"
                );
            }
        }
        for name in ["left_knee_pitch/position", "left_knee_pitch/effort", "base/angular_velocity/y"] {
            assert!((tilted.at(row, name) - plain.at(row, name)).abs() < 1e-9, "{name}");
        }
    }
    // At the start the base is upright, and the log says the inverse turn.
    let quaternion = ["x", "y", "z", "w"].map(|axis| tilted.at(0, &format!("base/orientation/{axis}")));
    let (sr, cr, sp, cp) = ((0.5 * roll).sin(), (0.5 * roll).cos(), (0.5 * pitch).sin(), (0.5 * pitch).cos());
    let expected = [-sr * cp, -cr * sp, sr * sp, cr * cp];
    let same = quaternion.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9);
    assert!(same, "{quaternion:?} {expected:?}");
}

#[test]
#[ignore = "takes long"]
fn grounds_do_what_their_effects_say() {
    let height = |log: &super::Log| log.last("base/position/z");
    let plain = tulip("");
    // Eight corners of 20 kN/m carry 19 kg.
    let soft = tulip(&effect("ground_compliance", "stiffness = 20000.0\ndamping = 400.0"));
    let sunk = height(&plain) - height(&soft);
    let weight: f64 =
        ["left_foot", "right_foot"].iter().map(|foot| soft.last(&format!("{foot}/force/z"))).sum();
    println!("ground_compliance: {sunk:.6} m for {:.6}", weight / 160_000.0);
    assert!((sunk - weight / 160_000.0).abs() < 0.15 * sunk);
    // A foot that bounces is in the air just after it struck.
    let drop = "[initial]\nclearance = 0.03\n";
    let load = |log: &super::Log, row: usize| -> f64 {
        ["left_foot", "right_foot"].iter().map(|foot| log.at(row, &format!("{foot}/force/z"))).sum()
    };
    let struck = |log: &super::Log| (0..log.rows.len()).find(|row| load(log, *row) > 10.0).unwrap();
    let (dead, alive) =
        (tulip(drop), tulip(&format!("{drop}{}", effect("impact_restitution", "coefficient = 0.5"))));
    let quiet = |log: &super::Log| (2..12).filter(|k| load(log, struck(log) + k) == 0.0).count();
    println!("impact_restitution: {} quiet samples of 10, {} without", quiet(&alive), quiet(&dead));
    assert!(quiet(&alive) > quiet(&dead) + 3);
    // Feet that slip: μ g t less speed.
    let slide = "[initial]\nbase_velocity = [0.6, 0.0, 0.0]\n";
    let moved = |log: &super::Log| log.last("base/position/x");
    let (held, slipped) =
        (tulip(slide), tulip(&format!("{slide}{}", effect("foot_slip", "friction = 0.02"))));
    println!("foot_slip: {:.4} m, {:.4} m without", moved(&slipped), moved(&held));
    assert!(moved(&slipped) > moved(&held) + 0.1);
    // The hips turn the feet outwards with 2 N m: corners with friction hold 7 N m, soles of 2 mm 0.2 N m.
    let hip = |side: &str, to: f64| {
        format!("[joint.{side}_hip_yaw]\nreference = {to}\nstiffness = 20.0\ndamping = 0.5\n")
    };
    let twist = hip("left", 0.1) + &hip("right", -0.1);
    let yaw = |log: &super::Log| log.last("left_hip_yaw/position");
    let free = yaw(&tulip(&format!("{twist}{}", effect("spin_friction", "radius = 0.002"))));
    let held = yaw(&tulip(&twist));
    println!("spin_friction: {free:.4} rad, {held:.4} rad without");
    assert!(free > 0.08 && held.abs() < 0.01);
}

#[test]
fn assumptions_are_refused_with_their_reason() {
    let tulip = robot("tulip", None);
    let plant = plant(&tulip.description, &tulip.tree().unwrap()).unwrap();
    for kind in KINDS {
        if matches!(kind.law, Law::PointFeet | Law::NoImpact | Law::SingleMass | Law::DecoupledPlanes) {
            let text = format!("duration = 1.0\n{}", effect(kind.name, ""));
            let refused = scenario(&plant, &text).unwrap_err();
            assert!(refused.contains("assumption about models"), "{refused}");
        }
    }
    let alone = "duration = 1.0\n[[effect]]\nkind = \"coupling\"\njoint = \"left_ankle_roll\"\nother_joint = \"left_ankle_pitch\"\ninertia = 0.1\ndamping = 0.0\ncoulomb = 0.0\nstiffness = 0.0\n";
    let scenario = scenario(&plant, alone).unwrap();
    let model = true_model(&tulip, &[]).unwrap();
    let refused = Simulation::new(Mechanics::new(&model, plant.layout.base).unwrap(), &plant, &scenario);
    let refused = refused.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(refused.contains("makes energy"), "{refused}");
}
