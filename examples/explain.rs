//! What a robot's model lacks, by the library: how well it fits a log, what is missing, how well it fits with that.
//!
//!   cargo run --release --example explain [ROBOT TRAIN.csv JUDGE.csv]
//!
//! says what `bipedc compare ROBOT JUDGE.csv`, `bipedc diagnose ROBOT TRAIN.csv --validate JUDGE.csv` and, once `bipedc amend --from`
//! has written the diagnosis into `biped.toml`, again `bipedc compare ROBOT JUDGE.csv` say; but no file changes here.
use bipedc::{Diagnostic, Diagnostics, Workbench};

/// A robot, the log in which effects are found, and another one, which judges.
const COULOMB: [&str; 3] = [
    "robots/tulip",
    "tests/data/examples/coulomb/train.csv.gz",
    "tests/data/examples/coulomb/validation.csv.gz",
];

/// Comparison, diagnosis, and the comparison with what was found.
pub fn explain([robot, train, judge]: [&str; 3]) -> Result<String, Diagnostics> {
    let robot = Workbench::open(robot)?;
    let (train, judge) = (robot.log(train)?, robot.log(judge)?);
    let before = robot.compare(&judge)?;
    let diagnosis = robot.diagnose(&train, Some(&judge))?;
    let after = robot.amended(&diagnosis)?.compare(&judge)?;
    Ok(format!("{before}\n{diagnosis}\n{after}"))
}

fn main() {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let explained = match &given[..] {
        [] => explain(COULOMB),
        [robot, train, judge] => explain([robot, train, judge]),
        _ => Err(Diagnostic::error("three arguments are needed")
            .help("explain ROBOT TRAIN.csv JUDGE.csv")
            .into()),
    };
    match explained {
        Ok(text) => print!("{text}"),
        Err(errors) => eprintln!("{errors}"),
    }
}
