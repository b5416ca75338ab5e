//! The four changes of Table 4.1 on a robot with feet, each ended by its own event.
use super::verdicts_feet::{LIFTED, Leg, STRAIGHT, scenario};
use super::walked;
use bipedc_analysis::simulate::phases::PhaseChange;

const SEVEN: &str = "robots/seven_link";

fn names(changes: &[PhaseChange]) -> Vec<(&str, &str)> {
    changes.iter().map(|change| (change.from.as_str(), change.to.as_str())).collect()
}

#[test]
fn a_foot_begins_to_tip_about_its_toe() {
    let ankle = Leg { moves: [0.0, 0.0, 0.2], frequency: 1.5, ..STRAIGHT };
    let (summary, samples) = walked(SEVEN, &scenario("log_step = 0.0005", &[ankle, LIFTED], "")).unwrap();
    let change = &summary.changes[0];
    assert_eq!(names(&summary.changes)[0], ("single_support", "toe_support"));
    assert!(change.impulse.is_empty(), "velocities do not jump: {change:?}");
    // Points: right heel, right toe. The heel's force has fallen to nothing by then, and stays there.
    let heel = |time: f64| samples.iter().rfind(|sample| sample.time <= time).unwrap().forces[0][2];
    println!("tips at {:.6} s; the heel carries {:.4} N just before", change.time, heel(change.time));
    assert!(heel(0.0) > 10.0 && heel(change.time) > 0.0 && heel(change.time) < 0.05 * heel(0.0));
    assert_eq!(heel(change.time + 0.001), 0.0);
}

#[test]
fn heel_and_toe_land_one_after_the_other() {
    let ahead = Leg { side: "left", angles: [-0.6, 0.1, 0.1], moves: [0.15, 0.0, 0.0], frequency: 2.0 };
    let head = "[assumptions]\nfriction = false\npushing = false\n[initial]\nphase = \"toe_support\"\nbase_angular_velocity = [2.0]";
    let (summary, samples) =
        walked(SEVEN, &scenario(head, &[Leg::still("right", [-0.4, 0.8, -0.4]), ahead], "")).unwrap();
    assert_eq!(names(&summary.changes)[..2], [("toe_support", "touch_down"), ("touch_down", "push_off")]);
    let [heel, toe] = [&summary.changes[0], &summary.changes[1]];
    assert!(heel.time < toe.time && summary.steps == 1);
    for change in [heel, toe] {
        let front = change.impulse.iter().find(|impulse| impulse.foot == "left_foot").unwrap();
        assert!(front.z > 0.1, "{change:?}");
    }
    // Afterwards the left foot, by its own name, carries on both of its points.
    let after = samples.iter().find(|sample| sample.time > toe.time).unwrap();
    assert!(after.forces[2][2] != 0.0 && after.forces[3][2] != 0.0 && after.forces[0][2] == 0.0);
}

#[test]
fn a_rear_foot_is_let_go_when_nothing_pushes_it() {
    // The left toe stands 0.1 m behind the hip; the leg is drawn forward.
    let rear = Leg {
        side: "left",
        angles: [0.2, 0.5, -0.529925723813773],
        moves: [-0.25, 0.3, 0.0],
        frequency: 1.5,
    };
    let head = "log_step = 0.0001\n[assumptions]\nfriction = false\n[initial]\nphase = \"push_off\"";
    let text = scenario(head, &[Leg::still("right", [-0.4, 0.8, -0.4]), rear], "");
    let (summary, samples) = walked(SEVEN, &text).unwrap();
    assert_eq!(names(&summary.changes)[0], ("push_off", "single_support"));
    let change = &summary.changes[0];
    let toe = |time: f64| samples.iter().rfind(|sample| sample.time <= time).unwrap().forces[3][2];
    println!("let go at {:.6} s; the toe carries {:.5} N just before", change.time, toe(change.time));
    assert!(toe(0.0) > 0.5 && toe(change.time) >= 0.0 && toe(change.time) < 0.05 * toe(0.0));
    assert!(change.impulse.is_empty() && toe(change.time + 0.001) == 0.0);
}
