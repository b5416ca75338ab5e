//! The in-process evaluator against Pinocchio's numbers.
use crate::compiled::support::oracle::check_oracle;
use crate::compiled::support::{ROBOTS, check_reference, contact_points, read_robot};
use bipedc_compiler::compile::ProgramModel;

/// The planar robots' references are for a free floating base.
fn floating(name: &str) -> ProgramModel {
    let robot = read_robot(name);
    let kind = if name == "tulip_v1_leg" { "fixed" } else { "floating" };
    ProgramModel::new(robot.with_base(kind, None).unwrap().compile().unwrap())
}

#[test]
fn reference_values_of_all_robots() {
    for name in ROBOTS {
        check_reference(&floating(name), name);
    }
}

#[test]
fn oracle_values_of_all_robots_on_a_free_or_fixed_base() {
    for name in ROBOTS {
        let checked = check_oracle(&floating(name), name, &contact_points(name));
        assert!(checked >= 8 * 25, "{name}: only {checked} comparisons");
    }
}

#[test]
fn oracle_values_of_the_planar_robots() {
    for name in ["three_link", "five_link", "seven_link"] {
        let robot = read_robot(name);
        let model = ProgramModel::new(robot.compile().unwrap());
        let checked = check_oracle(&model, &format!("{name}_planar"), &contact_points(name));
        assert!(checked >= 8 * 25, "{name}: only {checked} comparisons");
    }
}
