//! What looks like a sign or a zero that is mixed up and is none, or may be either: loads, centres of mass, springs.
use super::data_gate::{coulomb, experiment, judge};
use crate::cli::{bipedc, text};
use crate::experiments::support::measured::Subjects;
use crate::hidden_effects::drawn;
use bipedc_analysis::experiments::data_checks::inspect;
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::log::Log;
use bipedc_analysis::measure::{Options, Recording};
use bipedc_effects::diagnostic::Severity;
use bipedc_effects::effect::{Effect, Location, kinds};

/// It turns the load of a last joint about as an angle does that counts from elsewhere, and its mass stays what it is: where it came out a
/// little less than nothing, the log was refused.
#[test]
fn a_foot_whose_mass_sits_elsewhere_is_no_angle_that_counts_from_elsewhere() {
    for (side, y, z) in [("left", 0.07, 0.0), ("left", -0.07, 0.0), ("right", -0.045, 0.078)] {
        let offset = Effect::new(
            &kinds::COM_OFFSET,
            Location::link(format!("{side}_foot")),
            &[("x", 0.0), ("y", y), ("z", z)],
        );
        let mut log = coulomb();
        let plain = experiment(log.clone());
        for (row, added) in plain.response(std::slice::from_ref(&offset)) {
            let joint = plain.joints().iter().position(|name| plain.rows()[row].name.starts_with(*name));
            let effort = log.effort[joint.unwrap()].as_mut().unwrap();
            effort.iter_mut().zip(added).for_each(|(u, more)| *u += more);
        }
        let found = judge(log);
        assert!(found.iter().all(|finding| finding.severity != Severity::Error), "{offset}: {found:?}");
    }
}

/// A knee's spring carries all but gravity, and other angles of the thigh would turn its load as much: what a hip that is wrong by a quarter of a
/// turn leaves, the spring explains. The log was refused.
#[test]
fn a_strong_spring_is_no_angle_that_counts_from_elsewhere() {
    let (_, folder) = drawn("parallel_spring-2", 4711, "data_gate");
    let robot = Subjects::named("five_link");
    let options = Options { cutoff_hz: Some(16.0), ..Options::default() };
    let log = Log::open(folder.join("validation.csv")).unwrap();
    let mut recording = Recording::read(&log, &robot.layout, &options).unwrap();
    recording.thin(4000);
    let experiment =
        MotionExperiment::new(&five_link::FiveLink, &robot.layout, &robot.link_inertias, recording, &[])
            .unwrap();
    let found = inspect(&experiment, None).training;
    assert!(found.iter().all(|finding| finding.severity != Severity::Error), "{found:?}");
}

/// A load on the last link of an arm, at a right angle to that link's own: the log was refused, though both explain it as well.
#[test]
fn what_may_be_a_load_or_a_zero_is_said_and_not_refused() {
    let (_, folder) = drawn("arm_payload-1", 90210, "data_gate");
    let [train, judge] = ["train.csv", "validation.csv"].map(|file| folder.join(file));
    let run = [
        "diagnose",
        "examples/hidden_effects/robots/arm",
        text(&train),
        "--validate",
        text(&judge),
        "--json",
    ];
    let found = bipedc(&run).ok().json();
    let [effect] = &found["effects"].as_array().unwrap()[..] else { panic!("{}", found["effects"]) };
    assert_eq!([&effect["kind"], &effect["link"]], ["payload", "tool"]);
    let warned = found["warnings"].to_string();
    assert!(
        warned.contains(
            "`wrist_roll/position` counts from elsewhere, about -90 degrees off, or a body carries"
        ),
        "{warned}"
    );
}

/// A load 10 cm beside a quadruped's shin makes as much of the thigh's torque as an encoder that counts twice would: the log was refused.
#[test]
fn a_load_far_out_is_no_encoder_that_counts_twice() {
    let (_, folder) = drawn("quadruped_payload-1", 5_550_123, "data_gate");
    let [train, judge] = ["train.csv", "validation.csv"].map(|file| folder.join(file));
    let robot = "examples/hidden_effects/robots/quadruped";
    let found = bipedc(&["diagnose", robot, text(&train), "--validate", text(&judge), "--json"]).ok().json();
    let [effect] = &found["effects"].as_array().unwrap()[..] else { panic!("{}", found["effects"]) };
    assert_eq!([&effect["kind"], &effect["link"]], ["payload", "rear_left_lower"]);
}
