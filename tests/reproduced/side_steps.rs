//! Section 4.2: released on one leg, and a leg swung quickly.
use super::findings::{Released, Swung};
use super::run;

#[test]
#[ignore = "takes long"]
fn released_on_one_leg_it_rocks_from_foot_to_foot_and_comes_to_rest() {
    let found = Released::of(&run("release", 1e-4, 5.0));
    println!("{found:#?}");
    // A free ankle is nearly a point foot: the sole stays flat, its pressure hardly moves.
    assert!(found.pressure_travel < 0.04 && found.pressure_unexplained < 5e-3, "{found:?}");
    assert!(found.ankle_travel > 0.25, "{found:?}");
    // Impacts take energy: it never stands upright on the other leg, and every swing is smaller than the last.
    assert!(found.swings.len() >= 3, "{found:?}");
    assert!(found.swings[0].roll < 0.0 && found.swings[0].roll > 0.6 * found.upright, "{found:?}");
    assert!(found.left_ankle > 0.1, "{found:?}");
    for pair in found.swings.windows(2) {
        assert!(pair[1].roll * pair[0].roll < 0.0 && pair[1].roll.abs() < pair[0].roll.abs(), "{found:?}");
    }
    // Rubber knobs: several impacts in one stance.
    assert!(found.swings.iter().take(2).all(|swing| swing.strikes > 1), "{found:?}");
    // Sideways and forward motion are coupled: the torso pitches, less and less.
    let pitch: Vec<f64> = found.pitch.iter().map(|(_, p)| p.abs()).take(6).collect();
    assert!(pitch.len() == 6 && pitch[0] > 5e-4 && pitch[5] < 0.7 * pitch[0], "{found:?}");
    // At the end both feet stay on the ground and exchange pressure.
    assert!(found.both_stand > 0.95 && found.exchanged[1] > found.exchanged[0] + 3.0, "{found:?}");
    assert_eq!(found.largest, 120.0);
}

#[test]
#[ignore = "takes long"]
fn a_leg_swung_quickly_turns_the_torso_the_other_way() {
    let found = Swung::of(&run("leg_swing", 2e-4, 1.9));
    println!("{found:#?}");
    assert!(found.torso[0] < -2e-3 && found.torso_rate[0] < -0.02 && found.torso_rate[1] > 0.01, "{found:?}");
    assert!(found.right_hip > 1e-3 && found.right_ankle < -5e-4, "{found:?}");
    let [before, most, least] = found.outer;
    assert!(most > before + 10.0 && least < before - 10.0, "{found:?}");
    let [before, least, most] = found.inner;
    assert!(least < before - 5.0 && most > before + 10.0, "{found:?}");
    let [before, outermost, back] = found.pressure;
    assert!(outermost < before - 5e-3 && back > before, "{found:?}");
}

#[test]
fn the_energy_of_the_release_is_accounted_for() {
    // Until after the first impacts.
    let found = [4e-4, 1e-4].map(|step| run("release", step, 0.7));
    let parts = found.each_ref().map(super::Trial::unexplained);
    println!("lost {:.4} J, unexplained {parts:?} of it", found[1].lost());
    assert!(parts[1] < 1e-3 && parts[1] < 0.7 * parts[0], "{parts:?}");
    assert!(found[1].lost() > 0.5);
}
