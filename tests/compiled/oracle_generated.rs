//! The committed crates of `generated/` against Pinocchio's numbers (but the crate of `biped_3d`, whose functions are tested in
//! process: to compile it takes longer than all the others).
use crate::compiled::support::oracle::check_oracle;
use crate::compiled::support::{check_reference, contact_points};
use bipedc_runtime::Model;

/// Planar robots are generated on a planar base: the reference is for a free one, the oracle has both.
fn planar<M: Model<f64>>(model: &M, robot: &str) {
    let checked = check_oracle(model, &format!("{robot}_planar"), &contact_points(robot));
    assert!(checked >= 8 * 25, "{robot}: only {checked} comparisons");
}

fn free_or_fixed<M: Model<f64>>(model: &M, robot: &str) {
    check_reference(model, robot);
    let checked = check_oracle(model, robot, &contact_points(robot));
    assert!(checked >= 8 * 25, "{robot}: only {checked} comparisons");
}

#[test]
fn three_link() {
    planar(&three_link::ThreeLink, "three_link");
}

#[test]
fn five_link() {
    planar(&five_link::FiveLink, "five_link");
}

#[test]
fn seven_link() {
    planar(&seven_link::SevenLink, "seven_link");
}

#[test]
fn tulip() {
    free_or_fixed(&tulip::Tulip, "tulip");
}

#[test]
fn tulip_v1_leg() {
    free_or_fixed(&tulip_v1_leg::TulipV1Leg, "tulip_v1_leg");
}
