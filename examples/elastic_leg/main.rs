//! Tables 8.1 and 8.2 of the thesis on series elastic legs whose truth is known.
//!
//! The thesis identified the real leg of TUlip, whose data are not public. Here are its printed estimates beside those of
//! `bipedc identify --method elastic` on two simulated legs: the example of `tests/data` (another simulator) and one that
//! this program simulates. Their drives differ from the description by factors between 0.8 and 1.25.
#[path = "../real_data/run.rs"]
#[allow(dead_code)]
mod run;
mod simulation;
mod tables;
mod thesis;

use clap::Parser;
use run::{Failure, Scratch, failure, text};
use serde_json::Value;
use simulation::{Drive, JOINTS, Leg, Random};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use tables::{Case, Truth};

const HELP: &str = "\
Examples:
  cargo build --release && cargo run --release --example elastic_leg
  cargo run --release --example elastic_leg -- --seed 7 --steps one
  cargo run --release --example elastic_leg -- --write docs/reproductions/elastic_leg.md";

/// Identify simulated series elastic legs and print the tables of the thesis beside
#[derive(Parser)]
#[command(name = "elastic_leg", after_help = HELP)]
struct Arguments {
    /// Draw other drives, motions and noise for the leg that is simulated here
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// As in `bipedc identify`: two or one
    #[arg(long, value_name = "STEPS", default_value = "two")]
    steps: String,
    /// Write the tables as a Markdown page
    #[arg(long, value_name = "FILE.md")]
    write: Option<PathBuf>,
    /// The program to be asked; default: `bipedc` of the same build
    #[arg(long, value_name = "PROGRAM")]
    program: Option<PathBuf>,
}

fn main() -> ExitCode {
    match work(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn work(arguments: &Arguments) -> Result<(), Failure> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = arguments.program.clone().map_or_else(sibling, Ok)?;
    let scratch = Scratch::new("bipedc-elastic-leg")?;
    let robot = project.join("robots/tulip_v1_leg");
    let ask = |train: &Path, judge: &Path| ask(&program, &robot, [train, judge], &arguments.steps);

    let data = project.join("tests/data/examples/elastic_leg");
    let other = Case {
        name: "Example of another simulator",
        truth: Truth::read(&text(&data.join("truth.json"))?)?,
        answer: ask(&data.join("train.csv.gz"), &data.join("validation.csv.gz"))?,
    };
    let folder = scratch.folder("own")?;
    let (drives, [train, judge]) = simulate(&robot, arguments.seed, &folder)?;
    let own =
        Case { name: "Simulated here", truth: Truth::of(&JOINTS, &drives), answer: ask(&train, &judge)? };

    let page = tables::page(&[other, own], &arguments.steps)?;
    println!("{page}");
    if let Some(file) = &arguments.write {
        let new = file.with_extension("md.new");
        std::fs::write(&new, page)
            .and_then(|()| std::fs::rename(&new, file))
            .map_err(|e| failure(format!("{}: {e}", file.display())))?;
    }
    Ok(())
}

/// Two motions of a leg whose drives differ from the description.
fn simulate(robot: &Path, seed: u64, folder: &Path) -> Result<([Drive; 5], [PathBuf; 2]), Failure> {
    let mut random = Random(0x1e9 + seed);
    let mut drives = Vec::new();
    for joint in &JOINTS[..5] {
        drives.push(drive(robot, joint, &mut random)?);
    }
    let drives: [Drive; 5] = drives.try_into().map_err(|_| failure("five drives are described"))?;
    let mut logs = Vec::new();
    for (name, seconds) in [("train.csv", 12.0), ("validation.csv", 8.0)] {
        let file = folder.join(name);
        let leg = Leg::new(drives, &mut random);
        leg.log(seconds, &mut random, &file).map_err(|e| failure(format!("{}: {e}", file.display())))?;
        logs.push(file);
    }
    let [train, judge] = logs.try_into().map_err(|_| failure("two logs are simulated"))?;
    Ok((drives, [train, judge]))
}

/// A described drive with friction and stiffness off by up to a fifth down or a quarter up.
fn drive(robot: &Path, joint: &str, random: &mut Random) -> Result<Drive, Failure> {
    let robot = bipedc_compiler::Robot::read(robot).map_err(|e| failure(e.to_string()))?;
    let described = robot.description.drive(joint);
    let described = described.ok_or_else(|| failure(format!("no drive of {joint} is described")))?;
    let mut off = || 0.8 * (1.25f64 / 0.8).powf(random.even());
    Ok(Drive {
        gear: described.gear_ratio,
        rotor: described.rotor_inertia,
        torque_constant: described.torque_constant.unwrap_or(0.0),
        viscous: described.viscous_friction * off(),
        coulomb: described.coulomb_friction * off(),
        spring: match described.transmission {
            bipedc_effects::drive::Transmission::SeriesElastic {
                motor_pulley_radius,
                load_pulley_radius,
                spring_stiffness,
            } => Some([motor_pulley_radius, load_pulley_radius, spring_stiffness * off()]),
            _ => None,
        },
    })
}

fn ask(program: &Path, robot: &Path, [train, judge]: [&Path; 2], steps: &str) -> Result<Value, Failure> {
    let output = Command::new(program)
        .arg("identify")
        .args([robot, train])
        .args(["--method", "elastic", "--json", "--steps", steps, "--validate"])
        .arg(judge)
        .output()
        .map_err(|e| failure(format!("{}: {e}", program.display())))?;
    if !output.status.success() {
        return Err(failure(String::from_utf8_lossy(&output.stderr).into_owned()));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| failure(e.to_string()))
}

/// `bipedc` beside the folder of this example.
fn sibling() -> Result<PathBuf, Failure> {
    let own = std::env::current_exe().map_err(|e| failure(e.to_string()))?;
    let folder = own.parent().and_then(|examples| examples.parent());
    let program = folder.map(|folder| folder.join(format!("bipedc{}", std::env::consts::EXE_SUFFIX)));
    program.filter(|program| program.exists()).ok_or_else(|| {
        failure("there is no `bipedc` beside this build: run `cargo build --release` first, or use --program")
    })
}
