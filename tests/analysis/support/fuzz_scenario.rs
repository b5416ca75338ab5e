//! The body of the fuzz target `scenario`.
use bipedc_analysis::robot::{BaseKind, ContactPoint, Foot, Joint, JointLayout, Side};
use bipedc_analysis::simulate::{Plant, Scenario};
use bipedc_effects::drive::Drive;
use std::path::Path;

/// A small robot on this base.
fn plant(base: BaseKind) -> Plant {
    let corner = |name: &str, x: f64| ContactPoint { name: name.to_owned(), position: [x, 0.0, -0.1] };
    let foot = |name: &str| Foot {
        name: name.to_owned(),
        frame: name.to_owned(),
        side: Some(if name.starts_with("left") { Side::Left } else { Side::Right }),
        corners: vec![corner("heel", -0.1), corner("toe", 0.15)],
    };
    Plant {
        layout: JointLayout { joints: vec![Joint::revolute("knee"), Joint::revolute("ankle")], base },
        feet: vec![foot("right_foot"), foot("left_foot")],
        shapes: Vec::new(),
        links: vec!["torso".to_owned(), "right_foot".to_owned()],
        position_limits: vec![Some([-1.0, 1.0]), None],
        velocity_limits: vec![Some(8.0), None],
        effort_limits: vec![Some(20.0), None],
        effects: Vec::new(),
        phases: vec!["stand".to_owned(), "swing".to_owned()],
        actuated: vec![0],
        drives: vec![Some(Drive { gear_ratio: 100.0, ..Drive::default() }), None],
        gravity: [0.0, 0.0, -9.81],
    }
}

/// Reads the bytes as a scenario; whatever is accepted has finite numbers of the right count.
pub fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    // Other files are the business of the target `log`.
    if text.contains("trajectory") {
        return;
    }
    for (base, nq) in [(BaseKind::Floating, 9), (BaseKind::Planar, 5), (BaseKind::Fixed, 2)] {
        match Scenario::parse(Path::new("scenario.toml"), text, &plant(base)) {
            Ok(scenario) => {
                assert_eq!(scenario.initial.q.len(), nq);
                assert!(scenario.initial.q.iter().chain(&scenario.initial.v).all(|x| x.is_finite()));
                assert!(scenario.duration > 0.0 && scenario.step > 0.0 && scenario.log_every > 0);
                assert!(scenario.ground.check().is_ok());
                for motor in scenario.actuators.iter().flatten() {
                    assert!(motor.drive.turns() != 0.0 && motor.series_stiffness() > 0.0 && motor.gap >= 0.0);
                }
                for servo in &scenario.servos {
                    for time in [-1.0, 0.0, 0.5, 1e9] {
                        assert!(!servo.reference.at(time)[0].is_nan());
                    }
                }
            }
            Err(errors) => {
                assert!(!errors.0.is_empty());
                assert!(errors.0.iter().all(|error| error.file.is_some() && error.position.is_some()));
            }
        }
    }
}
