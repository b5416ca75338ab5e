//! Verdicts about feet with an extent, in the plane and in space; servos hold postures and move single joints.
use super::verdicts::{said, verdict};
use super::walked;
use std::fmt::Write;
use std::path::Path;

const SEVEN: &str = "robots/seven_link";
const SPACE: &str = "robots/biped_3d";

/// Angles of hip, knee and ankle of a leg, and how far each rises from there within half a period of a sine, rad.
pub struct Leg {
    pub side: &'static str,
    pub angles: [f64; 3],
    pub moves: [f64; 3],
    /// Hz
    pub frequency: f64,
}

impl Leg {
    pub const fn still(side: &'static str, angles: [f64; 3]) -> Self {
        Self { side, angles, moves: [0.0; 3], frequency: 1.0 }
    }
}

/// A scenario with stiff servos; `head` stands before [control].
pub fn scenario(head: &str, legs: &[Leg], more: &str) -> String {
    let mut text = format!(
        "method = \"event_driven\"\nduration = 1.0\n{head}\n[control]\nstiffness = 400.0\ndamping = 10.0\neffort_limits = false\njoint_stops = false\n[joint]\n"
    );
    for leg in legs {
        for (k, joint) in ["hip", "knee", "ankle"].iter().enumerate() {
            let _ = write!(text, "{}_{joint}_pitch = {{ position = {}", leg.side, leg.angles[k]);
            if leg.moves[k] != 0.0 {
                let _ =
                    write!(text, ", sines = [[{}, {}, -1.5707963267948966]]", leg.moves[k], leg.frequency);
            }
            text.push_str(" }\n");
        }
    }
    text + more
}

pub const LIFTED: Leg = Leg::still("left", [-0.4, 0.8, -0.4]);
pub const STRAIGHT: Leg = Leg::still("right", [0.0; 3]);
const CROUCHED: Leg = Leg::still("right", [-0.4, 0.8, -0.4]);
/// Heel down, ahead of the body.
const AHEAD: Leg = Leg { side: "left", angles: [-0.6, 0.1, 0.1], moves: [0.15, 0.0, 0.0], frequency: 2.0 };

#[test]
fn a_planar_foot_tips_about_its_heel() {
    let ankle = Leg { moves: [0.0, 0.0, -0.2], frequency: 1.5, ..STRAIGHT };
    let distance = verdict(SEVEN, &scenario("", &[ankle, LIFTED], ""));
    said(&distance, "single_support", "centre of pressure from the edge of right_foot", "m", "tips");
    assert!(distance.time > 0.01 && distance.value < 0.0 && distance.value > -1e-6);
}

#[test]
fn a_planar_foot_slips() {
    let ankle = Leg { moves: [0.0, 0.0, -0.2], frequency: 1.5, ..STRAIGHT };
    let force = verdict(SEVEN, &scenario("[assumptions]\nfriction = 0.03", &[ankle, LIFTED], ""));
    said(&force, "single_support", "tangential force on right_foot", "N", "slips");
}

#[test]
fn a_planar_swing_foot_scuffs() {
    let bent = Leg::still("right", [-0.1, 0.2, -0.1]);
    let stretching = Leg { moves: [0.2, -0.4, 0.2], frequency: 4.0, ..LIFTED };
    let height = verdict(SEVEN, &scenario("", &[bent, stretching], ""));
    said(&height, "single_support", "height of left_foot/", "m", "scuffs");
    assert_eq!(height.limit, -1e-6);
}

/// From the right toe to the left heel, which lands.
fn landing(head: &str, turn: &str, more: &str) -> String {
    let head = format!(
        "[assumptions]\nfriction = false\n{head}\n[initial]\nphase = \"toe_support\"\nbase_angular_velocity = {turn}"
    );
    scenario(&head, &[CROUCHED, AHEAD], more)
}

#[test]
fn a_planar_foot_would_have_to_pull_after_the_other_has_landed() {
    let text = landing("", "[2.0]", "");
    let force = verdict(SEVEN, &text);
    said(&force, "touch_down", "normal force on right_foot", "N", "pull");
    let (summary, _) = walked(SEVEN, &text).unwrap();
    let change = &summary.changes[0];
    assert_eq!((change.from.as_str(), change.to.as_str()), ("toe_support", "touch_down"));
    // The impact holds the toe and stops the heel: impulses on both.
    let feet: Vec<&str> = change.impulse.iter().map(|impulse| impulse.foot.as_str()).collect();
    assert_eq!(feet, ["right_foot", "left_foot"]);
    assert!(change.impulse.iter().all(|impulse| impulse.z > 0.0));
}

#[test]
fn a_foot_in_space_tips_over_its_side() {
    // The body's weight is beside the foot.
    let distance = verdict(SPACE, &scenario("", &[STRAIGHT, LIFTED], ""));
    said(&distance, "single_support", "centre of pressure from the edge of right_foot", "m", "tips");
}

#[test]
fn a_foot_in_space_slips() {
    let force = verdict(SPACE, &scenario("[assumptions]\nfriction = 0.03", &[STRAIGHT, LIFTED], ""));
    said(&force, "single_support", "tangential force on right_foot", "N", "slips");
}

#[test]
fn a_swing_foot_in_space_scuffs() {
    let bent = Leg::still("right", [-0.1, 0.2, -0.1]);
    let stretching = Leg { moves: [0.2, -0.4, 0.2], frequency: 4.0, ..LIFTED };
    let height = verdict(SPACE, &scenario("", &[bent, stretching], ""));
    said(&height, "single_support", "height of left_foot/", "m", "scuffs");
}

#[test]
fn a_foot_in_space_that_lands_rolled_does_not_land_on_its_edge() {
    let height = verdict(SPACE, &landing("", "[0.0, 2.0, 0.0]", "left_ankle_roll = { position = 0.1 }\n"));
    said(&height, "toe_support", "height of left_foot/rear_", "m", "not on the ground");
    assert!(height.value > 0.005 && height.limit == 0.001);
}

#[test]
fn an_edge_in_space_has_two_ends() {
    // The body's weight is beside the edge too.
    let text = landing("second_impact = false", "[0.0, 2.0, 0.0]", "");
    let distance = verdict(SPACE, &text);
    said(&distance, "touch_down", "", "m", "tips");
    assert!(distance.quantity.contains("edge"), "{distance:?}");
}

/// The seven-link robot with feet that land flat.
fn flat_footed() -> String {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/seven_link");
    let text = std::fs::read_to_string(robots.join("biped.toml")).unwrap();
    let own = text.find("# 1: fully actuated").unwrap();
    let phase =
        "[[phase]]\nname = \"step\"\ncontacts = [\"right_foot\"]\nimpact = [\"left_foot\"]\nrelabel = true\n";
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("flat_footed");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("biped.toml"), format!("{}{phase}", &text[..own])).unwrap();
    std::fs::copy(robots.join("robot.urdf"), folder.join("robot.urdf")).unwrap();
    folder.to_str().unwrap().to_owned()
}

#[test]
fn a_flat_foot_that_turns_while_it_lands_rocks() {
    let robot = flat_footed();
    let text = "method = \"event_driven\"\nduration = 1.0\nsteps = 1\n[assumptions]\nfriction = false\n[joint]\n\
        right_hip_pitch = { position = -0.4 }\nright_knee_pitch = { position = 0.8 }\n\
        right_ankle_pitch = { position = -0.4 }\nleft_hip_pitch = { position = -0.4 }\n\
        left_knee_pitch = { position = 0.8019, velocity = -2.0 }\n\
        left_ankle_pitch = { position = -0.4019, velocity = 5.0 }\n";
    let distance = verdict(&robot, text);
    said(&distance, "step", "impulse's centre of pressure from the edge of left_foot", "m", "second impact");
}
