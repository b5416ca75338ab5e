//! Mass matrix, energy, inverse and forward dynamics, and their derivatives.
use super::subject::*;
use bipedc_runtime::Argument::{A, Forces, Q, Tau, V};

/// Lower factor of a symmetric matrix, if it is positive definite.
fn cholesky(d: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut l = d.to_vec();
    for c in 0..n {
        for r in c..n {
            let sum: f64 = (0..c).map(|k| l[k * n + r] * l[k * n + c]).sum();
            let rest = d[c * n + r] - sum;
            if r == c && rest <= 0.0 {
                return None;
            }
            l[c * n + r] = if r == c { rest.sqrt() } else { rest / l[c * n + c] };
        }
    }
    Some(l)
}

#[test]
fn mass_matrix_is_symmetric_and_positive_definite() {
    let robots = subjects(&["mass_matrix", "mass_matrix_upper", "kinetic_energy"]);
    in_random_states(&robots, |robot, values| {
        let n = robot.nv();
        let d = robot.call("mass_matrix", values);
        let upper = robot.call("mass_matrix_upper", values);
        for (r, c) in (0..n).flat_map(|r| (0..n).map(move |c| (r, c))) {
            assert_eq!(d[c * n + r].to_bits(), d[r * n + c].to_bits(), "{}: element {r} {c}", robot.name);
            let expected = if r <= c { d[c * n + r] } else { 0.0 };
            // Lowered apart, the two may round differently.
            assert!((upper[c * n + r] - expected).abs() <= 1e-13 * d[c * n + c].max(d[r * n + r]));
        }
        assert!(cholesky(&d, n).is_some(), "{}: not positive definite", robot.name);
        let v = values.of(V);
        let energy = 0.5 * dot(v, &times(&d, v));
        robot.close("½ vᵀ D v", &[energy], &robot.call("kinetic_energy", values), 1e-12);
    });
}

#[test]
fn inverse_dynamics_is_mass_times_acceleration_plus_bias() {
    let robots = subjects(&["inverse_dynamics", "mass_matrix", "coriolis_matrix", "bias", "gravity"]);
    in_random_states(&robots, |robot, values| {
        let bias = robot.call("bias", values);
        let expected = plus(&times(&robot.call("mass_matrix", values), values.of(A)), &bias);
        robot.close("D a + H", &robot.call("inverse_dynamics", values), &expected, 1e-12);
        let coriolis = times(&robot.call("coriolis_matrix", values), values.of(V));
        robot.close("C v + G", &plus(&coriolis, &robot.call("gravity", values)), &bias, 1e-12);
    });
}

#[test]
fn gravity_is_the_gradient_of_the_potential() {
    let robots = subjects(&["gravity", "potential_energy"]);
    in_random_states(&robots, |robot, values| {
        let power = dot(&robot.call("gravity", values), values.of(V));
        let rate = robot.time_derivative("potential_energy", values, &[]);
        robot.close("Gᵀ v", &[power], &rate, 1e-12);
    });
}

#[test]
fn energy_rate_is_power() {
    let robots = subjects(&["forward_dynamics", "kinetic_energy", "potential_energy"]);
    in_random_states(&robots, |robot, values| {
        let a = robot.call("forward_dynamics", values);
        let kinetic = robot.time_derivative("kinetic_energy", values, &a)[0];
        let potential = robot.time_derivative("potential_energy", values, &[])[0];
        let power = dot(values.of(Tau), values.of(V));
        let scale = kinetic.abs().max(potential.abs()).max(power.abs()).max(1.0);
        let error = (kinetic + potential - power).abs() / scale;
        assert!(error < 1e-10, "{}: {error:.1e}", robot.name);
    });
}

#[test]
fn forward_dynamics_undoes_inverse_dynamics() {
    let families = [
        "inverse_dynamics",
        "forward_dynamics",
        "inverse_dynamics_with_forces",
        "forward_dynamics_with_forces",
    ];
    in_random_states(&subjects(&families), |robot, values| {
        for (inverse, forward) in [(families[0], families[1]), (families[2], families[3])] {
            let tau = robot.call(inverse, values);
            robot.close(forward, &robot.call(forward, &values.with(Tau, tau)), values.of(A), 1e-9);
        }
    });
}

#[test]
fn external_forces_act_through_the_jacobians() {
    let robots = subjects(&[
        "inverse_dynamics",
        "inverse_dynamics_with_forces",
        "contact_normal_directions",
        "contact_tangential_directions",
    ]);
    in_random_states(&robots, |robot, values| {
        let normal = robot.call("contact_normal_directions", values);
        let tangential = robot.call("contact_tangential_directions", values);
        let forces = values.of(Forces);
        // A planar robot has one tangential direction per point, and no use for the force across its plane.
        let directions = tangential.len() / normal.len();
        let tangential_forces: Vec<f64> =
            forces.chunks(3).flat_map(|force| force[..directions].to_vec()).collect();
        let normal_forces: Vec<f64> = forces.chunks(3).map(|force| force[2]).collect();
        let acting = plus(&times(&normal, &normal_forces), &times(&tangential, &tangential_forces));
        let with = robot.call("inverse_dynamics_with_forces", values);
        let without = robot.call("inverse_dynamics", values);
        robot.close("inverse dynamics − Jᵀ f", &minus(&without, &acting), &with, 1e-12);
    });
}

/// Columns along `argument` of a function's derivative, from dual numbers.
fn dual_columns(
    robot: &Subject,
    function: &str,
    values: &Values<f64>,
    argument: bipedc_runtime::Argument,
) -> Vec<f64> {
    let unit = |k: usize| (0..robot.nv()).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
    let column = |k| {
        let rate = if argument == Q { robot.rate(values, &unit(k)) } else { unit(k) };
        robot.call(function, &values.moving(&[(argument, rate)]))
    };
    (0..robot.nv()).flat_map(column).map(|x| x.1).collect()
}

#[test]
#[ignore = "takes long"]
fn derivatives_are_those_of_dual_numbers() {
    let cases = [("inverse_dynamics", A, 1e-12), ("forward_dynamics", Tau, 1e-9)];
    let robots = subjects(&[
        "inverse_dynamics",
        "forward_dynamics",
        "inverse_dynamics_derivatives",
        "forward_dynamics_derivatives",
    ]);
    in_random_states(&robots, |robot, values| {
        for (function, last, tolerance) in cases {
            let name = format!("{function}_derivatives");
            let all = robot.call(&name, values);
            for (block, argument) in all.chunks(all.len() / 3).zip([Q, V, last]) {
                let expected = dual_columns(robot, function, values, argument);
                robot.close(&format!("{name} by {argument:?}"), block, &expected, tolerance);
            }
        }
    });
}

#[test]
fn mass_matrix_rate_less_twice_coriolis_is_skew_for_the_six_robots() {
    let robots = six_robots(&["mass_matrix", "coriolis_matrix"]);
    in_random_states(&robots, |robot, values| {
        let n = robot.nv();
        let c = robot.call("coriolis_matrix", values);
        let sum: Vec<f64> = (0..n * n).map(|k| c[k] + c[k % n * n + k / n]).collect();
        robot.close("C + Cᵀ", &sum, &robot.time_derivative("mass_matrix", values, &[]), 1e-12);
    });
}
