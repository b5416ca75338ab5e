//! Kinematics, momentum and the wrench of the ground.
use super::subject::*;
use bipedc_compiler::compile::identifier;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_runtime::Argument::{A, Forces, Q, Tau, V};

/// Six components: a force and its moment about the world's origin.
fn wrench_at(point: [f64; 3], force: [f64; 3]) -> Vec<f64> {
    [force, cross(point, force)].concat()
}

fn weight(tree: &Tree) -> [f64; 3] {
    tree.gravity.map(|g| tree.total_mass() * g)
}

#[test]
fn jacobians_are_rates_of_positions_and_rotations() {
    let families = ["position", "rotation", "jacobian", "jacobian_rate_times_velocity", "body_jacobian"];
    in_random_states(&subjects(&families), |robot, values| {
        let still = vec![0.0; robot.nv()];
        for link in &robot.tree().links {
            let [position, rotation, jacobian, rate, own] =
                families.map(|family| format!("{family}_of_{}", identifier(&link.name)));
            let twist = times(&robot.call(&jacobian, values), values.of(V));
            let along = robot.time_derivative(&position, values, &still);
            robot.close(&position, &twist[..3], &along, 1e-12);
            let axes = robot.call(&rotation, values);
            let along = |x: &[f64]| -> Vec<f64> {
                axes.chunks(3).map(|axis| axis.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
            };
            let in_own_axes: Vec<f64> = robot.call(&jacobian, values).chunks(3).flat_map(along).collect();
            robot.close(&own, &robot.call(&own, values), &in_own_axes, 1e-12);
            let turned: Vec<f64> =
                axes.chunks(3).flat_map(|axis| cross(three(&twist[3..]), three(axis))).collect();
            robot.close(&rotation, &turned, &robot.time_derivative(&rotation, values, &still), 1e-12);
            let moving = robot.time_derivative(&jacobian, values, &still);
            robot.close(&rate, &robot.call(&rate, values), &times(&moving, values.of(V)), 1e-12);
        }
    });
}

#[test]
fn centre_of_mass_velocity_and_acceleration_are_its_rates() {
    let robots = subjects(&[
        "center_of_mass",
        "center_of_mass_jacobian",
        "center_of_mass_with_jacobian",
        "center_of_mass_velocity",
        "center_of_mass_acceleration",
        "center_of_mass_motion",
    ]);
    in_random_states(&robots, |robot, values| {
        let velocity = robot.call("center_of_mass_velocity", values);
        let rate = robot.time_derivative("center_of_mass", values, &[]);
        robot.close("velocity", &velocity, &rate, 1e-12);
        let jacobian = robot.call("center_of_mass_jacobian", values);
        robot.close("J v", &times(&jacobian, values.of(V)), &velocity, 1e-12);
        let acceleration = robot.time_derivative("center_of_mass_velocity", values, values.of(A));
        robot.close("acceleration", &robot.call("center_of_mass_acceleration", values), &acceleration, 1e-12);
        let motion = ["center_of_mass", "center_of_mass_velocity", "center_of_mass_acceleration"];
        let motion = motion.map(|name| robot.call(name, values)).concat();
        robot.close("motion", &robot.call("center_of_mass_motion", values), &motion, 1e-12);
        let both = [robot.call("center_of_mass", values), jacobian].concat();
        robot.close("with Jacobian", &robot.call("center_of_mass_with_jacobian", values), &both, 1e-12);
    });
}

#[test]
fn centroidal_momentum_is_its_matrix_times_the_velocity() {
    let robots =
        subjects(&["centroidal_momentum", "centroidal_momentum_matrix", "centroidal_momentum_with_matrix"]);
    in_random_states(&robots, |robot, values| {
        let (momentum, matrix) =
            (robot.call("centroidal_momentum", values), robot.call("centroidal_momentum_matrix", values));
        robot.close("matrix", &times(&matrix, values.of(V)), &momentum, 1e-12);
        let both = robot.call("centroidal_momentum_with_matrix", values);
        robot.close("with matrix", &both, &[momentum, matrix].concat(), 1e-12);
    });
}

#[test]
fn momentum_rates_are_the_rates_of_momentum() {
    let robots = subjects(&[
        "momentum",
        "momentum_rate",
        "centroidal_momentum",
        "centroidal_momentum_rate",
        "center_of_mass",
    ]);
    in_random_states(&robots, |robot, values| {
        for momentum in ["momentum", "centroidal_momentum"] {
            let expected = robot.time_derivative(momentum, values, values.of(A));
            robot.close(momentum, &robot.call(&format!("{momentum}_rate"), values), &expected, 1e-12);
        }
        let about_com = robot.call("centroidal_momentum", values);
        let shift = wrench_at(three(&robot.call("center_of_mass", values)), three(&about_com));
        let shifted = [&about_com[..3], &plus(&about_com[3..], &shift[3..])].concat();
        robot.close("about the origin", &robot.call("momentum", values), &shifted, 1e-12);
    });
}

/// A free robot under forces at its contact points and torques at its joints: ρ̇ and σ̇ are gravity's wrench
/// and that of the forces, whatever the joints do.
#[test]
fn momentum_rate_is_the_external_wrench() {
    let robots =
        subjects(&["forward_dynamics_with_forces", "momentum", "center_of_mass", "position", "rotation"]);
    let free: Vec<Subject> =
        robots.into_iter().filter(|robot| robot.tree().base == BaseKind::Floating).collect();
    in_random_states(&free, |robot, values| {
        let mut tau = values.of(Tau).to_vec();
        tau[..6].fill(0.0);
        let a = robot.call("forward_dynamics_with_forces", &values.with(Tau, tau));
        let mut wrench = wrench_at(three(&robot.call("center_of_mass", values)), weight(robot.tree()));
        for (foot, force) in contact_positions(robot, values).into_iter().zip(values.of(Forces).chunks(3)) {
            wrench = plus(&wrench, &wrench_at(foot, three(force)));
        }
        robot.close("ρ̇ and σ̇", &robot.time_derivative("momentum", values, &a), &wrench, 1e-9);
    });
}

/// Of all contact points, from position and rotation of their links.
fn contact_positions(robot: &Subject, values: &Values<f64>) -> Vec<[f64; 3]> {
    let feet = &robot.robot.description.feet;
    feet.iter()
        .flat_map(|foot| {
            let origin = robot.call(&format!("position_of_{}", identifier(&foot.link)), values);
            let axes = robot.call(&format!("rotation_of_{}", identifier(&foot.link)), values);
            foot.points.iter().map(move |p| three(&plus(&origin, &times(&axes, &p.position))))
        })
        .collect()
}

/// The wrench of the ground: what the base rows of the inverse dynamics say, and momentum without gravity.
#[test]
fn ground_wrench_balances_momentum_and_base() {
    let robots = subjects(&[
        "ground_wrench",
        "momentum_rate",
        "center_of_mass",
        "inverse_dynamics",
        "zero_moment_point",
    ]);
    in_random_states(&robots, |robot, values| {
        let wrench = robot.call("ground_wrench", values);
        let gravity = wrench_at(three(&robot.call("center_of_mass", values)), weight(robot.tree()));
        let expected = minus(&robot.call("momentum_rate", values), &gravity);
        robot.close("ρ̇ − M g", &wrench, &expected, 1e-12);
        let zmp = [-wrench[4] / wrench[2], wrench[3] / wrench[2]];
        robot.close("ZMP", &robot.call("zero_moment_point", values), &zmp, 1e-9);
        let tau = robot.call("inverse_dynamics", values);
        let q = values.of(Q);
        match robot.tree().base {
            BaseKind::Planar => {
                let in_plane = [tau[0], tau[1], tau[2] + q[1] * tau[0] - q[0] * tau[1]];
                robot.close("base rows", &in_plane, &[wrench[0], wrench[2], wrench[4]], 1e-12);
            }
            BaseKind::Floating => {
                let turned = |x: &[f64]| three(&robot.rate(values, &pad(x, robot.nv())));
                let (force, moment) = (turned(&tau[..3]), turned(&tau[3..6]));
                let about = plus(&moment, &cross(three(q), force));
                robot.close("base rows", &[force.to_vec(), about].concat(), &wrench, 1e-12);
            }
            BaseKind::Fixed | BaseKind::Pivot => {}
        }
    });
}

/// A velocity of the base alone: its image in the world are the base's axes.
fn pad(x: &[f64], n: usize) -> Vec<f64> {
    (0..n).map(|k| if k < 3 { x[k] } else { 0.0 }).collect()
}
