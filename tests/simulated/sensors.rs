//! Motors, torque sensors, currents and inertial measurement units.
use super::{JOINT, JOINTS, Log, SETTLED, STEP, SWING, Torques, ran, robot, simulate, tulip};

#[test]
fn a_torque_sensor_at_the_joint_knows_nothing_of_rotor_and_friction() {
    let five = robot("five_link", Some("fixed"));
    let hidden = format!(
        "[[effect]]\nkind = \"rotor_inertia\"\njoint = \"{JOINT}\"\ninertia = 0.08\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"{JOINT}\"\ntorque = 0.8\n"
    );
    let nominal = Torques::of(&five, "");
    for spring in
        ["", "[[effect]]\nkind = \"series_elasticity\"\njoint = \"left_knee_pitch\"\nstiffness = 400.0\n"]
    {
        let sensor = format!("{SWING}[sensors]\neffort = \"joint\"\n{hidden}{spring}");
        let worst = nominal.worst(&simulate(&five, &sensor), f64::INFINITY);
        println!("torque sensor: {worst:.2e} N m");
        assert!(worst < 1e-3, "{worst}");
    }
    let gain = "[[effect]]\nkind = \"torque_gain\"\njoint = \"left_knee_pitch\"\ngain = 0.8\n";
    let log = simulate(&five, &format!("{SWING}[sensors]\neffort = \"joint\"\n{gain}"));
    let worst = Torques::of(&five, gain).worst(&log, f64::INFINITY);
    assert!(worst < 1e-3, "{worst}");
}

/// A motor of 2 N m/A and 2 V s/rad at the joint.
const MOTOR: &str = "[motor.left_knee_pitch]
gear_ratio = -100.0
torque_constant = 0.02
resistance = 0.4
rotor_inertia = 5e-6
viscous_friction = 2e-5
coulomb_friction = 0.004
";

#[test]
fn motors_have_currents_and_their_friction_is_at_the_shaft() {
    let five = robot("five_link", Some("fixed"));
    let as_effects = "[[effect]]\nkind = \"rotor_inertia\"\njoint = \"left_knee_pitch\"\ninertia = 0.05\n[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 0.2\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"left_knee_pitch\"\ntorque = 0.4\n";
    let derived = Torques::of(&five, as_effects);
    for command in ["current", "voltage"] {
        let log = simulate(&five, &format!("{SWING}{MOTOR}command = \"{command}\"\n"));
        let worst = derived.worst(&log, f64::INFINITY);
        println!("{command}: {worst:.2e} N m");
        assert!(worst < 1e-3, "{worst}");
        let [effort, current] = ["effort", "motor_current"].map(|name| log.all(&format!("{JOINT}/{name}")));
        assert!(effort.iter().zip(&current).all(|(effort, current)| (effort + 2.0 * current).abs() < 1e-9));
    }
}

#[test]
fn voltage_and_current_end_where_the_supply_ends() {
    let five = robot("five_link", Some("fixed"));
    for servo in ["drive", "held"] {
        for command in ["current", "voltage"] {
            let limits = "voltage_limit = 3.0\ncurrent_limit = 5.5\n";
            let swing = SWING.replace("\"drive\"", &format!("\"{servo}\""));
            let log = simulate(&five, &format!("{swing}{MOTOR}command = \"{command}\"\n{limits}"));
            let [current, speed] =
                ["motor_current", "velocity"].map(|name| log.all(&format!("{JOINT}/{name}")));
            let (mut most, mut amperes) = (0.0_f64, 0.0_f64);
            for (current, speed) in current.iter().zip(&speed).skip(SETTLED) {
                most = most.max((0.4 * current - 2.0 * speed).abs());
                amperes = amperes.max(current.abs());
            }
            println!("{servo}, {command}: {most:.4} V, {amperes:.4} A");
            assert!(amperes < 5.5 * 1.01 && most < 3.0 * 1.03, "{most} V {amperes} A");
            assert!(amperes > 4.0, "the motor works at its limits");
        }
    }
}

#[test]
fn an_imu_at_rest_shows_gravity_and_in_motion_what_its_place_does() {
    let imu = "[imu]\nposition = [0.05, -0.02, 0.2]\nrotation = [0.0, 0.0, 1.5707963267948966]\n";
    let log = tulip(imu);
    let rest: Vec<f64> =
        ["x", "y", "z"].map(|axis| log.last(&format!("imu/linear_acceleration/{axis}"))).to_vec();
    println!("at rest {rest:.3?} m/s²");
    assert!(rest[0].abs() < 0.3 && rest[1].abs() < 0.3 && (rest[2] - 9.81).abs() < 0.1, "{rest:?}");
    // Tumbling: place and velocity of the unit from the columns of the base, differenced twice over five steps.
    let log = tulip(&format!("{imu}[initial]\nclearance = 1.0\nbase_angular_velocity = [0.8, -1.1, 0.6]\n"));
    let row = 300;
    let place = |row: usize| -> [f64; 3] {
        let at = |name: &str| log.at(row, name);
        let q = ["x", "y", "z", "w"].map(|axis| at(&format!("base/orientation/{axis}")));
        let p = ["x", "y", "z"].map(|axis| at(&format!("base/position/{axis}")));
        let turned = turn(q, [0.05, -0.02, 0.2]);
        std::array::from_fn(|i| p[i] + turned[i])
    };
    let h = 5.0 * 1e-3;
    let (a, b, c) = (place(row - 5), place(row), place(row + 5));
    let mut specific: [f64; 3] = std::array::from_fn(|i| (a[i] - 2.0 * b[i] + c[i]) / (h * h));
    specific[2] += 9.81;
    let [x, y, z, w] = ["x", "y", "z", "w"].map(|axis| log.at(row, &format!("base/orientation/{axis}")));
    let own = turn([-x, -y, -z, w], specific);
    // The unit's x axis is the base's y axis.
    let expected = [own[1], -own[0], own[2]];
    let found = ["x", "y", "z"].map(|axis| log.at(row, &format!("imu/linear_acceleration/{axis}")));
    println!("tumbling {found:.4?} for {expected:.4?} m/s²");
    assert!(
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.02),
        "{found:?} {expected:?}"
    );
    let gyroscope = ["x", "y"].map(|axis| log.at(row, &format!("imu/angular_velocity/{axis}")));
    let base = ["x", "y"].map(|axis| log.at(row, &format!("base/angular_velocity/{axis}")));
    assert!((gyroscope[0] - base[1]).abs() < 1e-9 && (gyroscope[1] + base[0]).abs() < 1e-9);
}

/// A vector turned by a quaternion x y z w.
fn turn([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let once = cross([x, y, z], v).map(|t| 2.0 * t);
    let twice = cross([x, y, z], once);
    std::array::from_fn(|i| v[i] + w * once[i] + twice[i])
}

#[test]
fn noise_and_bias_are_as_stated_and_encoders_count() {
    let text = "seed = 4\n[imu]\nacceleration_noise = 0.05\nacceleration_bias = [0.1, 0.0, -0.2]\n";
    let (noisy, clean) = (imu_log(text), imu_log("[imu]\n"));
    let difference = |axis: &str| -> Vec<f64> {
        let name = format!("imu/linear_acceleration/{axis}");
        noisy.all(&name).iter().zip(clean.all(&name)).map(|(a, b)| a - b).collect()
    };
    let moments = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
    };
    let ((x, sx), (z, _)) = (moments(&difference("x")), moments(&difference("z")));
    assert!((x - 0.1).abs() < 0.01 && (z + 0.2).abs() < 0.01 && (sx - 0.05).abs() < 0.006, "{x} {z} {sx}");
    let five = robot("five_link", Some("fixed"));
    let log =
        simulate(&five, &format!("{SWING}{MOTOR}encoder_counts = 500\n[sensors]\ncurrent_step = 0.01\n"));
    let count = std::f64::consts::TAU / 50_000.0;
    for name in [format!("{JOINT}/position"), format!("{JOINT}/motor_current")] {
        let step = if name.ends_with("position") { count } else { 0.01 };
        assert!(log.all(&name).iter().all(|x| (x / step - (x / step).round()).abs() < 1e-6), "{name}");
    }
    assert_eq!(JOINTS[3], JOINT);
    assert!((log.at(2, "time") - 2.0 * STEP).abs() < 1e-12);
}

fn imu_log(text: &str) -> Log {
    let scenario =
        format!("duration = 0.6\n{text}[control]\nstiffness = 600.0\ndamping = 8.0\nservo = \"drive\"\n");
    simulate(&robot("tulip", None), &scenario)
}

#[test]
fn encoders_count_whole_turns_at_least() {
    let tulip = robot("tulip", Some("fixed"));
    let with = |counts: f64| {
        let text = format!("duration = 0.1\nlog_step = 0.1\n[sensors]\nencoder_counts = {counts:?}\n");
        ran(&tulip, &text).err().unwrap_or_default()
    };
    assert!(with(0.5).contains("`encoder_counts` = 0.5 is not possible"), "{}", with(0.5));
    assert!(with(-1.0).contains("at least 1"), "{}", with(-1.0));
    for counts in [0.0, 1.0, 4096.0] {
        assert_eq!(with(counts), "");
    }
}

#[test]
fn held_controllers_that_swing_are_refused() {
    let tulip = robot("tulip", Some("fixed"));
    let refused = |stiffness: f64, damping: f64| {
        let text = format!(
            "duration = 1.0\n[control]\nstiffness = {stiffness:.1}\ndamping = {damping:.2}\n[joint.left_knee_pitch]\nposition = 0.4\nsines = [[0.2, 0.5, 0.0]]\n"
        );
        ran(&tulip, &text).err().unwrap_or_default()
    };
    let damped = refused(300.0, 5.0);
    println!("{damped}");
    assert!(
        damped.contains("ankle") && damped.contains("damping = 5 N m s/rad, held over a step of 0.001 s")
    );
    let sprung = refused(3000.0, 0.1);
    println!("{sprung}");
    assert!(sprung.contains("stiffness = 3000 N m/rad") && sprung.contains("raise the damping"));
    assert_eq!(refused(300.0, 1.0), "");
}
