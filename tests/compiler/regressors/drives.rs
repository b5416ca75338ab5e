//! Motor torques of TUlip's first leg are rotor inertia · acceleration plus regressor · parameters (5.10).
use bipedc_compiler::Robot;
use bipedc_compiler::compile::ProgramModel;
use bipedc_effects::drive::Drive;
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

fn parameter(drive: &Drive, column: &str) -> f64 {
    match column {
        "viscous_friction" => drive.viscous_friction,
        "spring_stiffness" => drive.cable_stiffness(),
        other => panic!("what is {other}?"),
    }
}

#[test]
fn regressor_times_parameters_is_the_motor_torque() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip_v1_leg");
    let robot = Robot::read(&path).unwrap();
    let model = ProgramModel::new(robot.compile().unwrap());
    let find = |name: &str| model.compiled().functions.iter().position(|f| f.name == name).unwrap();
    let drive = |joint: &str| robot.description.drive(joint).unwrap();
    let n = Model::<f64>::joints(&model);
    let vector =
        |seed: f64, scale: f64| (0..n).map(|k| scale * (seed + 1.3 * k as f64).sin()).collect::<Vec<_>>();
    let (q, v, a) = (vector(0.1, 0.4), vector(0.5, 0.7), vector(1.9, 3.0));
    let (motor_q, motor_v, motor_a) = (vector(0.2, 60.0), vector(0.9, 90.0), vector(2.1, 400.0));
    let state = State::new()
        .with(Argument::Q, &q)
        .with(Argument::V, &v)
        .with(Argument::A, &a)
        .with(Argument::MotorQ, &motor_q)
        .with(Argument::MotorV, &motor_v)
        .with(Argument::MotorA, &motor_a);
    let call = |index: usize| {
        let f = &model.compiled().functions[index];
        let mut out = vec![0.0; f.rows.len() * f.columns.len()];
        model.evaluate(index, &state, &mut out).unwrap();
        out
    };
    let (torques, regressor) = (find("motor_torques"), find("drive_regressor"));
    let (expected, columns) = (call(torques), call(regressor));
    let (rows, f) = (&model.compiled().functions[torques].rows, &model.compiled().functions[regressor]);
    let mut compared = 0;
    for (row, joint) in f.rows.iter().enumerate() {
        let drive = drive(joint);
        // A stiff drive's motor carries the load directly, which is no part of this regressor.
        if !drive.is_elastic() {
            continue;
        }
        let place = (0..n).find(|&k| Model::<f64>::joint_name(&model, k) == Some(joint)).unwrap();
        let mut torque = drive.rotor_inertia * motor_a[place];
        for (column, name) in f.columns.iter().enumerate() {
            let (of, parameter_name) = name.rsplit_once('.').unwrap();
            if of == joint {
                torque += columns[column * f.rows.len() + row] * parameter(drive, parameter_name);
            }
        }
        let known = expected[rows.iter().position(|r| r == joint).unwrap()];
        assert!(
            (torque - known).abs() < 1e-12 * known.abs().max(1.0),
            "{joint}: {torque} instead of {known}"
        );
        compared += 1;
    }
    assert_eq!(compared, 3, "hip pitch, knee and ankle pitch are elastic");
}
