//! Statically stable walking of the thesis' section 8.4.1: forward, sideways and turning, in simulation.
//!
//! `cargo run --release --example static_walking` prints a Markdown page; `-- FOLDER` also draws the figures into that folder;
//! `-- FOLDER write` writes the trajectories beside the scenarios before.
mod findings;
mod gait;
#[path = "../trials/mod.rs"]
mod trials;

use bipedc_runtime::Model;
use findings::{JOINTS, Walked};
use gait::Step;
use std::path::Path;
use trials::figure::{Panel, draw};
use trials::{Failure, Trial, tulip_file};

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let angle = 15.0_f64.to_radians();
    let gaits: [(&str, Vec<Step>, f64); 3] = [
        ("forward", gait::forward(6, 0.08), 0.0),
        ("sideways", gait::sideways(6, 0.06), 0.0),
        ("turning", gait::turning(6, angle), 3.0 * angle),
    ];
    for (name, steps, turned) in &gaits {
        let trajectory = gait::trajectory(steps)?;
        let file = tulip_file(&format!("scenarios/{name}.csv"));
        if arguments.get(1).is_some_and(|word| word == "write") {
            std::fs::write(file, &trajectory.text)?;
        }
        let trial = Trial::of_tulip(name, |_| ())?;
        page(name, &Walked::of(&trial, &trajectory.wished), &trial, *turned);
        if let Some(folder) = arguments.first() {
            std::fs::create_dir_all(folder)?;
            std::fs::write(
                Path::new(folder).join(format!("{name}.svg")),
                figure(name, &trial, &trajectory.wished),
            )?;
        }
    }
    Ok(())
}

fn page(name: &str, found: &Walked, trial: &Trial, turned: f64) {
    let mrad = |x: f64| 1e3 * x;
    println!(
        "## {name}\n\n| joint | range of the wished angle, mrad | right: rms error, mrad | largest | left: rms error, mrad | largest |\n|---|---|---|---|---|---|"
    );
    for (k, joint) in JOINTS.iter().enumerate() {
        debug_assert!(found.joints[k].joint.ends_with(joint));
        let (right, left) = (&found.joints[k], &found.joints[k + JOINTS.len()]);
        println!(
            "| {} | {:.0} | {:.1} | {:.1} | {:.1} | {:.1} |",
            joint.replace('_', " "),
            mrad(right.range.max(left.range)),
            mrad(right.rms),
            mrad(right.largest),
            mrad(left.rms),
            mrad(left.largest)
        );
    }
    let span = |[low, high]: [f64; 2]| format!("{:+.1} to {:+.1} mrad", mrad(low), mrad(high));
    println!(
        "\nTorso: roll {}, pitch {}; yaw at the end {:+.1} mrad, commanded {:+.1}.",
        span(found.roll),
        span(found.pitch),
        mrad(found.yaw),
        mrad(turned)
    );
    println!(
        "Steps: {} right, {} left; moved by {:+.3} m forward, {:+.3} m to the left. Largest force on a foot: {:.2} of the weight. Clipped torques: {}.\n",
        found.steps[0],
        found.steps[1],
        found.moved[0],
        found.moved[1],
        found.load,
        if trial.summary.clipped.is_empty() {
            "none".to_owned()
        } else {
            format!("{:?}", trial.summary.clipped)
        }
    );
}

fn figure(name: &str, trial: &Trial, wished: &[Vec<f64>]) -> String {
    let ([roll, pitch, yaw], time) = (trial.torso(), trial.time());
    let titles = ["Hip yaw", "Hip roll", "Hip pitch", "Knee pitch", "Ankle pitch", "Ankle roll"];
    let curves = |joint: &str| {
        let position = |side: &str| trial.joint(&format!("{side}_{joint}"));
        // Wished angles have rows of 0.1 s.
        let desired = |side: &str| -> Vec<f64> {
            let name = format!("{side}_{joint}");
            let of = |j: &usize| Model::<f64>::joint_name(&tulip::Tulip, *j) == Some(name.as_str());
            let column = (0..12).find(of).unwrap_or(0);
            let at = |row: usize| wished[row.min(wished.len() - 1)][column];
            let between = |t: &f64| {
                let row = (10.0 * t).floor();
                at(row as usize) + (10.0 * t - row) * (at(row as usize + 1) - at(row as usize))
            };
            time.iter().map(between).collect()
        };
        vec![
            ("right", position("right")),
            ("right, desired", desired("right")),
            ("left", position("left")),
            ("left, desired", desired("left")),
        ]
    };
    let mut panels: Vec<Panel<'_>> = JOINTS
        .iter()
        .zip(titles)
        .map(|(joint, title)| Panel { title, unit: "rad", curves: curves(joint) })
        .collect();
    panels.push(Panel {
        title: "Torso",
        unit: "rad",
        curves: vec![("roll", roll), ("pitch", pitch), ("yaw", yaw)],
    });
    let force = |foot: &str| trial.column(&format!("{foot}/force/z"));
    panels.push(Panel {
        title: "Vertical forces on the feet",
        unit: "N",
        curves: vec![("right", force("right_foot")), ("left", force("left_foot"))],
    });
    draw(&format!("Statically stable walking: {name}"), &trial.time(), &panels)
}
