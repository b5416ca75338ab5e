//! Contact points, phases and impacts.
use super::subject::*;
use bipedc_compiler::derive::constraint::Constraints;
use bipedc_compiler::derive::{InertiaMode, RobotModel};
use bipedc_compiler::description::model::{Contact, Phase};
use bipedc_compiler::expression::{Expr, Graph};
use bipedc_compiler::program::{Evaluator, Order, lower};
use bipedc_compiler::tree::BaseKind;
use bipedc_runtime::Argument::{A, Tau, V};

#[test]
fn contact_directions_and_rates_are_derivatives_of_distances_and_positions() {
    let robots = subjects(&[
        "contact_distances",
        "contact_positions",
        "contact_normal_directions",
        "contact_tangential_directions",
        "contact_normal_rate",
        "contact_tangential_rate",
    ]);
    let kinds = [("distances", "normal"), ("positions", "tangential")];
    in_random_states(&robots, |robot, values| {
        for (position, kind) in kinds {
            let directions = format!("contact_{kind}_directions");
            let velocity = transposed_times(&robot.call(&directions, values), values.of(V));
            let expected = robot.time_derivative(&format!("contact_{position}"), values, &[]);
            robot.close(kind, &velocity, &expected, 1e-12);
            let rate = transposed_times(&robot.time_derivative(&directions, values, &[]), values.of(V));
            robot.close(kind, &robot.call(&format!("contact_{kind}_rate"), values), &rate, 1e-12);
        }
    });
}

/// J v = 0 of some contacts.
struct Rows {
    names: Vec<String>,
    jacobian: Evaluator,
    rate: Evaluator,
}

fn evaluated(evaluator: &Evaluator, values: &Values<f64>) -> Vec<f64> {
    let mut out = vec![0.0; evaluator.outputs()];
    evaluator.run(&values.state(), &mut evaluator.workspace(), &mut out);
    out
}

impl Rows {
    fn new(robot: &Subject, contacts: &[Contact]) -> Self {
        let graph = Graph::new();
        let model = RobotModel::new(&graph, robot.tree(), InertiaMode::Folded);
        let rows = Constraints::new(&model, &robot.robot.description.feet, contacts).unwrap();
        let evaluator = |outputs: Vec<Expr>| Evaluator::new(&lower(&graph, &outputs, Order::DepthFirst));
        Self {
            jacobian: evaluator(rows.jacobian.iter().flatten().map(|x| x.expr).collect()),
            rate: evaluator(rows.rate.iter().map(|x| x.expr).collect()),
            names: rows.names,
        }
    }

    /// J, row after row: as columns, its transpose.
    fn transposed(&self, values: &Values<f64>) -> Vec<f64> {
        evaluated(&self.jacobian, values)
    }
}

/// Robots whose base is free, with their phases.
fn free_robots(families: &[&str]) -> Vec<Subject> {
    let free = |robot: &Subject| matches!(robot.tree().base, BaseKind::Floating | BaseKind::Planar);
    // Fixed robots cannot fulfil the phases of random trees: they have too few joints.
    let mut out: Vec<Subject> = subjects(&[]).into_iter().filter(free).collect();
    for robot in &mut out {
        *robot = Subject::new(robot.name.clone(), robot.robot.clone(), families);
    }
    out
}

fn phases(robot: &Subject, impacts: bool) -> Vec<Phase> {
    let all = robot.robot.description.phases.iter();
    all.filter(|p| !if impacts { &p.impact } else { &p.contacts }.is_empty()).cloned().collect()
}

#[test]
fn constrained_dynamics_obeys_both_of_its_equations() {
    let robots = free_robots(&["constrained_dynamics", "inverse_dynamics"]);
    let mut checked = 0;
    in_random_states(&robots, |robot, values| {
        for phase in phases(robot, false) {
            let rows = Rows::new(robot, &phase.contacts);
            let answer = robot.call(&format!("constrained_dynamics_of_{}", phase.name), values);
            let (a, lambda) = answer.split_at(robot.nv());
            let transposed = rows.transposed(values);
            let acting = plus(values.of(Tau), &times(&transposed, lambda));
            let needed = robot.call("inverse_dynamics", &values.with(A, a.to_vec()));
            let scale = times_absolute(&transposed, lambda);
            within(robot, "D a + H = τ + W λ", &minus(&needed, &acting), scale, 1e-10);
            let acceleration = transposed_times(&transposed, a);
            let rest = plus(&acceleration, &evaluated(&rows.rate, values));
            within(robot, "Wᵀ a + w = 0", &rest, times_absolute(a, &[1.0]), 1e-9);
            checked += 1;
        }
    });
    assert!(checked > 50);
}

/// Largest product that enters `columns · x`.
fn times_absolute(columns: &[f64], x: &[f64]) -> f64 {
    let largest = |list: &[f64]| list.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    largest(columns) * largest(x)
}

/// `residual` vanishes against `scale`.
fn within(robot: &Subject, what: &str, residual: &[f64], scale: f64, tolerance: f64) {
    for x in residual {
        let error = x.abs() / scale.max(1.0);
        // Not the other way round: NaN must fail.
        assert!(error <= tolerance, "{}: {what}: {error:.1e}", robot.name);
    }
}

#[test]
fn impacts_stop_the_foot_conserve_momentum_and_add_no_energy() {
    let robots = free_robots(&["impact_map", "mass_matrix", "kinetic_energy", "momentum"]);
    let mut checked = 0;
    in_random_states(&robots, |robot, values| {
        for phase in phases(robot, true) {
            let rows = Rows::new(robot, &phase.impact);
            let answer = robot.call(&format!("impact_map_of_{}", phase.name), values);
            let (after, impulse) = answer.split_at(robot.nv());
            let jump = minus(after, values.of(V));
            let transposed = rows.transposed(values);
            let still = transposed_times(&transposed, after);
            within(robot, "J v⁺ = 0", &still, times_absolute(&transposed, after), 1e-11);
            let given = times(&transposed, impulse);
            let gained = times(&robot.call("mass_matrix", values), &jump);
            robot.close("D (v⁺ − v⁻) = Jᵀ F", &gained, &given, 1e-10);
            let moved = values.with(V, after.to_vec());
            let energy = |values| robot.call("kinetic_energy", values)[0];
            let (before, now) = (energy(values), energy(&moved));
            assert!(now <= before * (1.0 + 1e-12), "{}: {now} J after {before} J", robot.name);
            // The loss is the energy of the jump: ½ Δvᵀ D Δv.
            robot.close("loss", &[0.5 * dot(&jump, &gained)], &[before - now], 1e-9);
            let gain = minus(&robot.call("momentum", &moved), &robot.call("momentum", values));
            robot.close("Δρ", &sum_of_forces(&rows.names, impulse, &gain), &gain[..3], 1e-10);
            checked += 1;
        }
    });
    assert!(checked > 40);
}

/// Linear impulse of all rows; across the plane of a planar robot whatever is needed.
fn sum_of_forces(names: &[String], impulse: &[f64], needed: &[f64]) -> Vec<f64> {
    let along = |axis: &str| {
        let name = format!("force/{axis}");
        let rows = names.iter().zip(impulse).filter(|(row, _)| row.ends_with(&name));
        rows.map(|(_, x)| *x).sum::<f64>()
    };
    let in_space = names.iter().any(|name| name.ends_with("force/y"));
    vec![along("x"), if in_space { along("y") } else { needed[1] }, along("z")]
}

/// The points themselves, not the rows: after an impact none of those that touch the ground moves.
#[test]
fn points_that_land_stand_still() {
    let robots = free_robots(&["impact_map", "contact_normal_directions", "contact_tangential_directions"]);
    in_random_states(&robots, |robot, values| {
        for phase in phases(robot, true) {
            let touching = touching_points(robot, &phase.impact);
            let answer = robot.call(&format!("impact_map_of_{}", phase.name), values);
            let after = &answer[..robot.nv()];
            for kind in ["normal", "tangential"] {
                let directions = robot.call(&format!("contact_{kind}_directions"), values);
                let velocity = transposed_times(&directions, after);
                let per_point = velocity.len() / robot.tree().points.len();
                for point in &touching {
                    let own = &velocity[point * per_point..(point + 1) * per_point];
                    within(robot, kind, own, times_absolute(&directions, after), 1e-11);
                }
            }
        }
    });
}

/// Indices of the points of whole feet and of single points; edges are left out.
fn touching_points(robot: &Subject, contacts: &[Contact]) -> Vec<usize> {
    use bipedc_compiler::description::model::ContactPart::{Edge, Flat, Point};
    let points = robot.tree().points.iter().enumerate();
    let touches = |name: &str| {
        contacts.iter().any(|contact| match &contact.part {
            Flat => name.starts_with(&format!("{}/", contact.foot)),
            Point(point) => name == format!("{}/{point}", contact.foot),
            Edge(_) => false,
        })
    };
    points.filter(|(_, point)| touches(&point.name)).map(|(k, _)| k).collect()
}
