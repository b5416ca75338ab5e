//! Regressor × parameters = the quantity itself.
use super::generator::Random;
use super::subject::*;
use bipedc_compiler::compile::identifier;
use bipedc_runtime::Argument::Parameters;

#[test]
fn regressors_times_parameters_are_the_quantities() {
    let robots = subjects(&[
        "inertial_parameters",
        "inverse_dynamics_regressor",
        "inverse_dynamics",
        "energy_regressor",
        "kinetic_energy",
        "potential_energy",
        "center_of_mass_regressor",
        "center_of_mass",
        "ground_wrench_regressor",
        "ground_wrench",
    ]);
    in_random_states(&robots, |robot, values| {
        let parameters = robot.call("inertial_parameters", values);
        let product = |regressor: &str| times(&robot.call(regressor, values), &parameters);
        let quantity = |name: &str| robot.call(name, values);
        let check = |regressor: &str, expected: &[f64]| {
            robot.close(regressor, &product(regressor), expected, 1e-11);
        };
        check("inverse_dynamics_regressor", &quantity("inverse_dynamics"));
        check("energy_regressor", &[quantity("kinetic_energy"), quantity("potential_energy")].concat());
        let mass = robot.tree().total_mass();
        let moment: Vec<f64> = quantity("center_of_mass").iter().map(|x| mass * x).collect();
        check("center_of_mass_regressor", &moment);
        check("ground_wrench_regressor", &quantity("ground_wrench"));
    });
}

/// Mass and first moment, placed where the link of that name is, give the centre of mass.
#[test]
fn parameters_are_stated_in_the_frames_of_the_links() {
    let robots = subjects(&["inertial_parameters", "position", "rotation", "center_of_mass"]);
    in_random_states(&robots, |robot, values| {
        let parameters = robot.call("inertial_parameters", values);
        assert_eq!(parameters.len(), 10 * robot.tree().bodies.len(), "{}", robot.name);
        let mut moment = vec![0.0; 3];
        for (body, ten) in robot.tree().bodies.iter().zip(parameters.chunks(10)) {
            if !body.is_virtual {
                let name = identifier(&body.name);
                let position = robot.call(&format!("position_of_{name}"), values);
                let turned = times(&robot.call(&format!("rotation_of_{name}"), values), &ten[1..4]);
                moment = (0..3).map(|k| moment[k] + ten[0] * position[k] + turned[k]).collect();
            }
        }
        let com: Vec<f64> = moment.iter().map(|x| x / robot.tree().total_mass()).collect();
        robot.close("centre of mass", &com, &robot.call("center_of_mass", values), 1e-12);
    });
}

#[test]
#[ignore = "takes long"]
fn base_regressor_times_base_parameters_is_inverse_dynamics() {
    let families = ["inverse_dynamics_base_regressor", "base_parameters", "inverse_dynamics"];
    // The exact analysis takes its time; `tests/compiler/exact_*` test it on the large robots.
    let mut robots = random_trees(&[]);
    robots.truncate(8);
    robots.extend(six_robots(&[]).into_iter().take(3));
    let robots: Vec<Subject> =
        robots.into_iter().map(|r| Subject::new(r.name.clone(), r.robot, &families)).collect();
    in_random_states(&robots, |robot, values| {
        let parameters = robot.call("base_parameters", values);
        let tau = times(&robot.call("inverse_dynamics_base_regressor", values), &parameters);
        robot.close("base regressor", &tau, &robot.call("inverse_dynamics", values), 1e-10);
    });
}

/// Base parameters at run time instead of folded constants: with the robot's own values the same results, with
/// other values those of the base regressor.
#[test]
#[ignore = "takes long"]
fn run_time_parameters_are_the_base_parameters() {
    let families = ["inverse_dynamics_base_regressor", "base_parameters", "inverse_dynamics", "mass_matrix"];
    let mut random = Random(SEED);
    let mut robots = random_trees(&[]);
    robots.truncate(4);
    robots.extend(six_robots(&[]).into_iter().take(3));
    for plain in robots {
        let folded = Subject::new(plain.name.clone(), plain.robot.clone(), &families[1..]);
        let mut robot = plain.robot;
        robot.description.generate.runtime_parameters = true;
        let free = Subject::new(format!("{}, parameters at run time", plain.name), robot, &families);
        let values = free.state(&mut random);
        let own = values.with(Parameters, folded.call("base_parameters", &values));
        for function in &families[2..] {
            free.close(function, &free.call(function, &own), &folded.call(function, &values), 1e-10);
        }
        let regressor = free.call("inverse_dynamics_base_regressor", &values);
        let tau = times(&regressor, values.of(Parameters));
        free.close("other parameters", &free.call("inverse_dynamics", &values), &tau, 1e-10);
    }
}
