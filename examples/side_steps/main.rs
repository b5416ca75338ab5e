//! The two side-stepping experiments of the thesis' section 4.2, simulated.
//!
//! `cargo run --release --example side_steps` prints a Markdown page; `-- docs/reproductions/side_steps` also draws the figures
//! into that folder.
mod findings;
#[path = "../trials/mod.rs"]
mod trials;

use findings::{Released, Swung};
use std::path::Path;
use trials::figure::{Panel, draw};
use trials::{Failure, Trial};

const CORNERS: [&str; 4] = ["front_left", "front_right", "rear_left", "rear_right"];

fn main() -> Result<(), Failure> {
    let released = Trial::of_tulip("release", |_| ())?;
    // Every second step: forces are means over two, so that no impact is missed.
    let fine = Released::of(&Trial::of_tulip("release", |s| s.log_every = 2)?);
    let swung = Trial::of_tulip("leg_swing", |_| ())?;
    release(&fine);
    swing(&Swung::of(&swung));
    balance()?;
    if let Some(folder) = std::env::args().nth(1) {
        let folder = Path::new(&folder);
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("release.svg"), motion("Released on the right foot", &released))?;
        std::fs::write(
            folder.join("release_forces.svg"),
            forces("Released: forces on the corners", &released),
        )?;
        std::fs::write(folder.join("leg_swing.svg"), leg("Left leg swung at 1.0 s", &swung))?;
    }
    Ok(())
}

fn row(what: &str, thesis: &str, here: &str) {
    println!("| {what} | {thesis} | {here} |");
}

fn release(found: &Released) {
    println!(
        "## Released on one straight leg (figures 4.1 and 4.2)\n\n| what | thesis | here |\n|---|---|---|"
    );
    row("the left foot lands", "–", &format!("{:.3} s", found.landing));
    row(
        "pressure under the right foot until then",
        "almost constant: the foot stays flat, the ankle turns",
        &format!(
            "its centre travels by {:.1} mm of 120 mm across, while the ankle turns by {:.3} rad; all but {:.1} mm are the horizontal \
             force, which acts 55 mm below the axis",
            1e3 * found.pressure_travel,
            found.ankle_travel,
            1e3 * found.pressure_unexplained
        ),
    );
    let list =
        |f: &dyn Fn(&findings::Swing) -> String| found.swings.iter().map(f).collect::<Vec<_>>().join(", ");
    row(
        "extremes of the torso's roll after it",
        "a damped oscillation",
        &format!("{} rad", list(&|s| format!("{:+.3}", s.roll))),
    );
    row("seconds between changes of foot", "–", &{
        let begins: Vec<f64> = found.swings.iter().map(|s| s.begin).collect();
        begins.windows(2).map(|p| format!("{:.2}", p[1] - p[0])).collect::<Vec<_>>().join(", ")
    });
    row(
        "impacts of the standing foot in each swing",
        "several in one stance",
        &list(&|s| s.strikes.to_string()),
    );
    let furthest = found.swings.iter().map(|s| s.roll).fold(0.0, f64::min);
    row(
        "upright on the left leg",
        "not reached: energy is lost in impacts",
        &format!(
            "roll {furthest:+.3} of {:+.3} rad; the left ankle stays {:.3} rad or more from zero",
            found.upright, found.left_ankle
        ),
    );
    let pitch: Vec<String> =
        found.pitch.iter().take(6).map(|(t, p)| format!("{:+.1} ({t:.2} s)", 1e3 * p)).collect();
    row("pitch of the torso, mrad about its rest", "a damped harmonic oscillation", &pitch.join(", "));
    row(
        "both feet stand from 3 s on",
        "yes, and exchange pressure",
        &format!(
            "{:.0} % of the time; the front corners of the right foot carry {:.0} to {:.0} N from 3 s on",
            100.0 * found.both_stand,
            found.exchanged[0],
            found.exchanged[1]
        ),
    );
    row("largest reading of a corner", "120 N (saturated)", &format!("{:.0} N", found.largest));
}

fn swing(found: &Swung) {
    println!("\n## A leg swung quickly (figure 4.3)\n\n| what | thesis | here |\n|---|---|---|");
    row(
        "torso while the leg speeds up",
        "turns towards the swing leg about the right hip",
        &format!(
            "{:+.1} mrad (the leg turns the other way, by +300 mrad in all); right hip {:+.1} mrad",
            1e3 * found.torso[0],
            1e3 * found.right_hip
        ),
    );
    row(
        "roll velocity of the torso",
        "opposite while the leg slows down",
        &format!(
            "{:+.3} rad/s at most while it speeds up, {:+.3} while it slows down",
            found.torso_rate[0], found.torso_rate[1]
        ),
    );
    row(
        "right ankle roll",
        "the robot turns about it to its right",
        &format!("{:+.2} mrad", 1e3 * found.right_ankle),
    );
    row("outer corners of the right foot", "pushed harder for an instant, then less", &newtons(&found.outer));
    row("inner corners", "the opposite", &newtons(&found.inner));
    let pressure = found.pressure.map(|p| format!("{:+.1}", 1e3 * p));
    row(
        "centre of pressure across the foot, mm to the left of the ankle",
        "to the outer side, then back",
        &pressure.join(" → "),
    );
}

fn newtons(values: &[f64; 3]) -> String {
    values.map(|f| format!("{f:.0}")).join(" → ") + " N"
}

/// Losses at several steps.
fn balance() -> Result<(), Failure> {
    println!(
        "\n## Energy\n\nUntil 0.9 s after the release, with the rubber's restitution and without any: what was lost, and what independently summed"
    );
    println!(
        "work and losses leave unexplained. The leg swing loses next to nothing, damping of the controllers is work of the drives.\n"
    );
    println!(
        "| step, s | released: lost, J | unexplained, part | without restitution: lost, J | unexplained, part | leg: work, J | unexplained, J |\n|---|---|---|---|---|---|---|"
    );
    for step in [4e-4, 2e-4, 1e-4, 5e-5] {
        let run = |name: &str, duration: f64, restitution: f64| {
            Trial::of_tulip(name, |s| {
                (s.step, s.duration, s.log_every) = (step, duration, 1000);
                s.ground.normal_restitution = restitution;
            })
        };
        let (a, b, leg) = (run("release", 0.9, 0.4)?, run("release", 0.9, 0.0)?, run("leg_swing", 1.5, 0.4)?);
        let energy = leg.summary.energy.ok_or("no energy")?;
        println!(
            "| {step:.1e} | {:.4} | {:.1e} | {:.4} | {:.1e} | {:.4} | {:.1e} |",
            a.lost(),
            a.unexplained(),
            b.lost(),
            b.unexplained(),
            energy.drives,
            energy.remainder
        );
    }
    let whole = Trial::of_tulip("release", |_| ())?.summary.energy.ok_or("no energy")?;
    println!(
        "\nOver all 8 s the drives give {:.3} J (their controllers brake), {:.3} J are lost in impacts, {:.3} J in sliding, {:.3} J in the stops of the\nfree ankles, {:.3} J in their friction; potential energy falls by {:.3} J; unexplained: {:.1e} of the loss.",
        whole.drives,
        whole.impacts,
        whole.sliding,
        whole.stops,
        whole.viscous_friction,
        whole.potential[0] - whole.potential[1],
        (whole.remainder / whole.lost).abs()
    );
    Ok(())
}

fn joints<'a>(trial: &Trial, names: &[&'a str]) -> Vec<(&'a str, Vec<f64>)> {
    names.iter().map(|name| (*name, trial.joint(name))).collect()
}

fn motion(title: &str, trial: &Trial) -> String {
    let [roll, pitch, yaw] = trial.torso();
    let plain = ["right_hip_yaw", "right_hip_pitch", "right_knee_pitch"];
    let panels = [
        Panel { title: "Torso", unit: "rad", curves: vec![("roll", roll), ("yaw", yaw)] },
        Panel { title: "Torso", unit: "rad", curves: vec![("pitch", pitch)] },
        Panel {
            title: "Ankle rolls (free)",
            unit: "rad",
            curves: joints(trial, &["right_ankle_roll", "left_ankle_roll"]),
        },
        Panel {
            title: "Ankle pitches",
            unit: "rad",
            curves: joints(trial, &["right_ankle_pitch", "left_ankle_pitch"]),
        },
        Panel {
            title: "Hip rolls",
            unit: "rad",
            curves: joints(trial, &["right_hip_roll", "left_hip_roll"]),
        },
        Panel { title: "Held joints of the right leg", unit: "rad", curves: joints(trial, &plain) },
    ];
    draw(title, &trial.time(), &panels)
}

fn forces(title: &str, trial: &Trial) -> String {
    let of = |foot: &str| CORNERS.iter().map(|corner| (*corner, trial.corner(foot, corner))).collect();
    let panels = [
        Panel { title: "Right foot, vertical forces", unit: "N", curves: of("right_foot") },
        Panel { title: "Left foot, vertical forces", unit: "N", curves: of("left_foot") },
    ];
    draw(title, &trial.time(), &panels)
}

fn leg(title: &str, trial: &Trial) -> String {
    let [roll, ..] = trial.torso();
    let of = |foot: &str| CORNERS.iter().map(|corner| (*corner, trial.corner(foot, corner))).collect();
    let panels = [
        Panel { title: "Left hip roll", unit: "rad", curves: joints(trial, &["left_hip_roll"]) },
        Panel { title: "Right hip roll", unit: "rad", curves: joints(trial, &["right_hip_roll"]) },
        Panel { title: "Right ankle roll", unit: "rad", curves: joints(trial, &["right_ankle_roll"]) },
        Panel { title: "Torso's roll", unit: "rad", curves: vec![("roll", roll)] },
        Panel { title: "Right foot, vertical forces", unit: "N", curves: of("right_foot") },
    ];
    draw(title, &trial.time(), &panels)
}
