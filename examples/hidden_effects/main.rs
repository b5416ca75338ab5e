//! The scoreboard of hidden effects.
//!
//! Simulates robots that differ from their URDF in ways that are drawn from a seed, gives URDF and logs (nothing else)
//! to `bipedc diagnose`, and compares its answers with what was hidden.
mod generator;
mod score;

use clap::Parser;
use generator::{Failure, failure};
use score::{Context, Scored};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
Examples:
  cargo run --release --example hidden_effects                     # all cases, a table
  cargo run --release --example hidden_effects -- --only coulomb   # those with this word in their name
  cargo run --release --example hidden_effects -- --examples       # the eight experiments of tests/data/examples
  cargo run --release --example hidden_effects -- --write docs/scoreboard.md

A case is right if every hidden effect is found by kind and place with all parameters within 15 %. Payload: mass
within 15 %, position within 15 % of its distance or 10 mm. Vectors (offsets, tilts, inertias, the two directions of
asymmetric friction): the error's norm by the vector's. Gains: of the deviation from 1. Rest angles: by the angle or the
range of motion. Phases: of half a turn, at the middle of the motion. Couplings: every term weighted by the torque
that it makes. Compliance: the stiffness. Effects that are the same by algebra count as right and are named in truth.json.";

/// Score the diagnosis on robots with hidden effects
#[derive(Parser)]
#[command(name = "hidden_effects", after_help = HELP)]
struct Arguments {
    /// Only cases with this text in their name
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Cases at the same time
    #[arg(long, value_name = "N", default_value_t = 1)]
    jobs: usize,
    /// Draw other numbers: magnitudes, motions and noise; 0 is the committed scoreboard
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Score the experiments of tests/data/examples instead
    #[arg(long)]
    examples: bool,
    /// Names of the cases, nothing else
    #[arg(long)]
    list: bool,
    /// Write logs and truths of the cases into this folder and stop
    #[arg(long, value_name = "FOLDER")]
    generate: Option<PathBuf>,
    /// Print the scores as JSON
    #[arg(long)]
    json: bool,
    /// Write the scores as a Markdown page as well
    #[arg(long, value_name = "FILE.md")]
    write: Option<PathBuf>,
    /// Scores of other seeds, as --json prints them: their intervals count in the table of intervals; can be repeated
    #[arg(long, value_name = "FILE.json")]
    scores: Vec<PathBuf>,
    /// Scores that --json printed, for the table and the page: nothing is scored again
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["examples", "generate"])]
    from: Option<PathBuf>,
    /// The program to be scored; default: `bipedc` of the same build
    #[arg(long, value_name = "PROGRAM")]
    program: Option<PathBuf>,
    /// Further arguments for `bipedc diagnose`
    #[arg(long, value_name = "ARGUMENT", allow_hyphen_values = true)]
    with: Vec<String>,
    /// A diagnosis that takes longer has failed, s
    #[arg(long, value_name = "S", default_value_t = 300)]
    patience: u64,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let others = arguments.scores.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?.concat();
    let mut plans: Vec<_> =
        generator::all().into_iter().filter(|plan| plan.name.contains(&arguments.only)).collect();
    if arguments.seed != 0 {
        plans.iter_mut().for_each(|plan| plan.seed = format!("{} {}", plan.name, arguments.seed));
    }
    if arguments.list {
        plans.iter().for_each(|plan| println!("{}", plan.name));
        return Ok(());
    }
    if let Some(path) = &arguments.from {
        return tell(arguments, &read(path)?, &others);
    }
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    if let Some(folder) = &arguments.generate {
        for plan in &plans {
            let (_, truth) = generator::drawn(plan, &root, &folder.join(&plan.name))?;
            println!("{:40} nominal {:.5}, true model {:.5}", plan.name, truth.nominal, truth.oracle);
        }
        return Ok(());
    }
    let context = Context {
        program: arguments.program.clone().map_or_else(sibling, Ok)?,
        root,
        folder: std::env::temp_dir().join(format!("hidden_effects-{}", std::process::id())),
        with: arguments.with.clone(),
        patience: std::time::Duration::from_secs(arguments.patience),
    };
    let scores: Vec<Scored> = if arguments.examples {
        score::examples(&context, &arguments.only)
    } else {
        score::cases(&context, &plans, arguments.jobs)
    }?;
    // What is left there are logs that can be made again.
    let _ = std::fs::remove_dir_all(&context.folder);
    tell(arguments, &scores, &others)
}

/// Prints and writes scores; intervals also of others.
fn tell(arguments: &Arguments, scores: &[Scored], others: &[Scored]) -> Result<(), Failure> {
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(scores).map_err(|e| failure(e.to_string()))?);
    } else {
        println!("{}", score::table(scores, others));
    }
    match &arguments.write {
        Some(path) => generator::write_text(path, &score::page(scores, others)),
        None => Ok(()),
    }
}

/// Scores that were printed as JSON.
fn read(path: &Path) -> Result<Vec<Scored>, Failure> {
    let error = |what: String| failure(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| error(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| error(format!("no scores of this program: {e}")))
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
