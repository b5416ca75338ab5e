//! The in-process evaluator against Pinocchio's numbers.
#![allow(missing_docs)]
mod support;

use bipedc_compiler::Robot;
use bipedc_compiler::program::ProgramModel;
use support::oracle::check_oracle;
use support::{ROBOTS, check_reference, project};

/// The planar robots' references are for a free floating base.
fn floating(name: &str) -> ProgramModel {
    let robot = read(name);
    let kind = if name == "tulip_v1_leg" { "fixed" } else { "floating" };
    ProgramModel::new(robot.with_base(kind, None).unwrap().compile().unwrap())
}

#[test]
fn reference_values_of_all_robots() {
    for name in ROBOTS {
        check_reference(&floating(name), name);
    }
}

/// Contact points as the oracle names them: `link/point`, in the order of the description.
fn contact_points(robot: &Robot) -> Vec<String> {
    let feet = &robot.description.feet;
    feet.iter().flat_map(|f| f.points.iter().map(move |p| format!("{}/{}", f.link, p.name))).collect()
}

fn read(name: &str) -> Robot {
    Robot::read(&project().join("robots").join(name)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn oracle_values_of_all_robots_on_a_free_or_fixed_base() {
    for name in ROBOTS {
        let checked = check_oracle(&floating(name), name, &contact_points(&read(name)));
        assert!(checked >= 8 * 25, "{name}: only {checked} comparisons");
    }
}

#[test]
fn oracle_values_of_the_planar_robots() {
    for name in ["three_link", "five_link", "seven_link"] {
        let robot = read(name);
        let model = ProgramModel::new(robot.compile().unwrap());
        let checked = check_oracle(&model, &format!("{name}_planar"), &contact_points(&robot));
        assert!(checked >= 8 * 25, "{name}: only {checked} comparisons");
    }
}
