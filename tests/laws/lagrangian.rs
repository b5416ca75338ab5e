//! The expanded Lagrangian, derived apart from the compiler, against the recursive derivation.
use super::generator::Random;
use super::subject::*;
use crate::laws::support::lagrange::Lagrangian;
use bipedc_compiler::tree::BaseKind;
use bipedc_runtime::Argument::{A, Q, V};

const FAMILIES: [&str; 4] = ["inverse_dynamics", "mass_matrix", "kinetic_energy", "potential_energy"];

fn compare(robot: &Subject, states: usize) {
    let planar = robot.tree().base == BaseKind::Planar;
    assert_eq!(robot.tree().gravity, [0.0, 0.0, -9.81]);
    let plain = Lagrangian::read(&robot.robot.sources.urdf_text, planar);
    let mut random = Random(SEED);
    for _ in 0..states {
        let values = robot.state(&mut random);
        let (q, v) = (values.of(Q), values.of(V));
        let (kinetic, potential) = plain.energies(q, v);
        robot.close("K", &robot.call("kinetic_energy", &values), &[kinetic], 1e-12);
        if planar {
            // On a fixed base the compiler leaves out the potential of what does not move.
            robot.close("P", &robot.call("potential_energy", &values), &[potential], 1e-12);
        }
        robot.close("D", &robot.call("mass_matrix", &values), &plain.mass_matrix(q), 1e-12);
        let tau = plain.inverse_dynamics(q, v, values.of(A));
        robot.close("Euler–Lagrange", &robot.call("inverse_dynamics", &values), &tau, 1e-11);
    }
}

#[test]
fn planar_robots_obey_euler_and_lagrange() {
    for robot in six_robots(&FAMILIES).iter().filter(|r| r.tree().base == BaseKind::Planar) {
        compare(robot, 5);
    }
}

#[test]
fn robots_without_a_quaternion_obey_euler_and_lagrange() {
    let all = subjects(&FAMILIES);
    let (mut planar, mut fixed) = (0, 0);
    for robot in &all {
        match robot.tree().base {
            BaseKind::Planar => planar += 1,
            BaseKind::Fixed => fixed += 1,
            // A pivot's tree hangs on its foot; re-rooting is tested against floating models.
            BaseKind::Floating | BaseKind::Pivot => continue,
        }
        compare(robot, 1);
    }
    assert!(planar >= 5 && fixed >= 5);
}
