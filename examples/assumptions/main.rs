//! What the four assumptions of the thesis' section 4.2 cost on TUlip: point feet, no impact, a single mass, decoupled planes.
//!
//! `cargo run --release --example assumptions` prints a Markdown page.
#[path = "../side_steps/findings.rs"]
#[allow(dead_code)]
mod findings;
mod levels;
mod rocker;
#[path = "../trials/mod.rs"]
mod trials;

use levels::{Answer, frontal_plane, point_feet, pressure_of_a_leg_swing, rockers, simulated};
use trials::{Failure, Trial, tulip};

/// s
const STEP: f64 = 1e-4;

fn main() -> Result<(), Failure> {
    let robot = tulip()?;
    let ankles: Vec<usize> = {
        let tree = robot.tree().map_err(|error| error.to_string())?;
        (0..tree.joints.len()).filter(|&j| tree.joints[j].name.ends_with("ankle_roll")).collect()
    };
    let full = simulated("full model (three dimensions, feet, impacts, all bodies)", &robot, STEP, |_| ())?;
    let points = simulated(
        "point feet: lines below the ankles, which are held",
        &point_feet(robot.clone()),
        STEP,
        |s| {
            for &j in &ankles {
                (s.servos[j].stiffness, s.servos[j].damping) = (800.0, 4.0);
            }
        },
    )?;
    // Lines have no inner edge.
    let points = Answer { pressure: None, ..points };
    let plane = simulated("decoupled planes: the frontal one alone", &frontal_plane(robot), STEP, |_| ())?;
    let mut answers = vec![full, points, plane];
    answers.extend(rockers()?);
    println!("## Released on one straight leg\n");
    println!(
        "| model | other foot lands, s | roll velocity then, rad/s | lost until the next extreme of roll, J | that extreme, rad | first foot stands again after, s | impacts meanwhile | pitch, span in 2 s, mrad | inner edge's part of the load before, span |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    answers.iter().for_each(row);
    println!(
        "\n## What each assumption costs\n\n| assumption | compared | landing, % | loss, % | extreme of roll, % | time on the other foot, % |\n|---|---|---|---|---|---|"
    );
    cost("point feet", &answers[1], &answers[0], "full model");
    cost("decoupled planes", &answers[2], &answers[0], "full model");
    cost("everything but impacts and inertia", &answers[3], &answers[0], "full model");
    cost("no impact", &answers[4], &answers[3], "rigid body with impact");
    cost("single mass", &answers[5], &answers[3], "rigid body with impact");
    let leg = Trial::of_tulip("leg_swing", |s| s.duration = 1.8)?;
    let [full, single] = pressure_of_a_leg_swing(&leg)?;
    println!(
        "\n## A leg swung quickly\n\n| model | pressure's centre moves to the outer side, mm | then to the inner side, mm |\n|---|---|---|"
    );
    println!("| full model | {:.1} | {:+.1} |", 1e3 * full[0], 1e3 * full[1]);
    println!(
        "| single mass that moves like the centre of mass | {:.1} | {:+.1} |",
        1e3 * single[0],
        1e3 * single[1]
    );
    println!("| point feet | none: a point has no edges | |");
    Ok(())
}

fn row(a: &Answer) {
    let number =
        |x: Option<f64>, digits: usize| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.digits$}"));
    println!(
        "| {} | {} | {} | {} | {} | {} | {} | {:.1} | {} |",
        a.name,
        number(a.landing, 3),
        number(a.rate, 3),
        number(a.lost, 2),
        number(a.roll, 3),
        number(a.swing, 2),
        a.strikes.map_or_else(|| "–".to_owned(), |n| n.to_string()),
        1e3 * a.pitch,
        number(a.pressure, 2)
    );
}

fn cost(name: &str, a: &Answer, b: &Answer, with: &str) {
    let part = |x: Option<f64>, y: Option<f64>| match (x, y) {
        (Some(x), Some(y)) if y.abs() > 1e-9 => format!("{:+.0}", 100.0 * (x / y - 1.0)),
        _ => "–".to_owned(),
    };
    println!(
        "| {name} | {with} | {} | {} | {} | {} |",
        part(a.landing, b.landing),
        part(a.lost, b.lost),
        part(a.roll, b.roll),
        part(a.swing, b.swing)
    );
}
