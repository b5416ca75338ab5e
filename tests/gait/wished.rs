//! The example whose robot misses its wished speeds until the log of its walk amends its model.
// Its table is for people.
#[allow(dead_code)]
#[path = "../../examples/wished_speeds.rs"]
mod example;

use crate::cli::scratch;
use example::Row;

#[test]
#[ignore = "takes long"]
fn wished_speeds_are_met_again_with_the_model_that_their_log_amends() {
    let rows = example::story(&scratch("wished_speeds"), None).unwrap_or_else(|e| panic!("{e}"));
    let [ankles, knees, torso, nothing] = &rows[..] else { panic!("{} rows", rows.len()) };
    for Row { hidden, missed, found } in &rows {
        println!("{hidden}: {missed:?}, {found}");
    }
    for word in ["viscous friction at left_knee_pitch", "viscous friction at right_knee_pitch"] {
        assert!(knees.found.contains(word), "{}", knees.found);
    }
    for word in ["viscous friction at left_ankle_pitch", "viscous friction at right_ankle_pitch"] {
        assert!(ankles.found.contains(word), "{}", ankles.found);
    }
    assert!(torso.found.contains("payload at torso"), "{}", torso.found);
    for row in [ankles, knees, torso] {
        let [before, after] = row.missed;
        assert!(before > 1e-3 && after < 1e-2 * before, "{}: {before} {after}", row.hidden);
    }
    assert!(nothing.found == "nothing" && nothing.missed.iter().all(|missed| *missed < 1e-6));
}
