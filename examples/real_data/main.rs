//! The diagnosis on other people's measurements of real machines, whose answers are known.
//!
//! The data are read in place (`../shared/data`, each with its source, licence and known results) and never copied;
//! what is written into a temporary folder is removed afterwards.
mod humanoid;
mod page;
mod pendulum;
mod run;
mod servo;
mod table;
mod wrist;

use clap::Parser;
use run::{Failure, Program, Scratch, failure};
use std::path::PathBuf;
use std::process::ExitCode;

const HELP: &str = "\
Examples:
  cargo run --release --example real_data                          # all four machines
  cargo run --release --example real_data -- --only servo
  cargo run --release --example real_data -- --write /tmp/real-data.md";

/// Diagnose real machines whose answers are known
#[derive(Parser)]
#[command(name = "real_data", after_help = HELP)]
struct Arguments {
    /// The folder with the measurements
    #[arg(long, value_name = "FOLDER", default_value = "../shared/data")]
    data: PathBuf,
    /// Only this machine: wrist, pendulum, servo, humanoid
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Write the figures as a Markdown page
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
    if !arguments.data.is_dir() {
        println!("skipped: {} is not there", arguments.data.display());
        return Ok(());
    }
    let program = match &arguments.program {
        Some(program) => Program(program.clone()),
        None => Program(sibling()?),
    };
    let scratch = Scratch::new("bipedc-real-data")?;
    let mut text = String::from(page::HEAD);
    let machines: [(&str, run::Machine); 4] = [
        ("wrist", wrist::run),
        ("pendulum", pendulum::run),
        ("servo", servo::run),
        ("humanoid", humanoid::run),
    ];
    for (name, machine) in machines.iter().filter(|(name, _)| name.contains(&arguments.only)) {
        let folder = scratch.folder(name)?;
        for part in machine(&arguments.data, &folder, &program)? {
            let part = page::part(&part);
            println!("{part}");
            text.push_str(&part);
        }
    }
    if let Some(file) = &arguments.write {
        let new = file.with_extension("md.new");
        std::fs::write(&new, text)
            .and_then(|()| std::fs::rename(&new, file))
            .map_err(|e| failure(format!("{}: {e}", file.display())))?;
    }
    Ok(())
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
