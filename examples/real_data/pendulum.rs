//! A double pendulum with quasi-direct drives: friction, and swings that cannot support an estimate.
use crate::run::{Failure, Part, Program, robot, text};
use std::path::Path;

const SWING_UP: &str = "\
Two quasi-direct drives (source: dfki-ric-underactuated-lab/double_pendulum, design C.1, BSD-3-Clause), their URDF's rigid
bodies only, inertias free, filter of 10 Hz. Trained on the fast swing-up 154220; blocks of the same log judge, because the
second swing-up is not at hand. Known: dry and viscous friction, 0.134 and 0.120 N m held out on that second run with
them, 0.230 and 0.205 without.";

const FREE: &str = "\
The same question to free swings: torques are next to nothing, and least squares fit the noise of the motion (known:
trained on free swings, the same models leave 92 and 74 % of the torque on the swing-up). The answer must come with a warning.";

/// Asks both.
///
/// # Errors
/// Files that cannot be read or written; a refusal of the program.
pub fn run(data: &Path, folder: &Path, program: &Program) -> Result<Vec<Part>, Failure> {
    let data = data.join("dfki_double_pendulum");
    let urdf = text(&data.join("acrobot_model_1.0.urdf"))?;
    let pendulum = robot(folder, &urdf, "[base]\nkind = \"fixed\"\n")?;
    let options = ["--cutoff", "10", "--inertial", "free"];
    let mut parts = Vec::new();
    for (title, words, run) in [
        ("Double pendulum, trained on the swing-up", SWING_UP, "154220"),
        ("Double pendulum, trained on free swings (143339)", FREE, "143339"),
        ("Double pendulum, trained on free swings (143524)", "As before.", "143524"),
        ("Double pendulum, trained on free swings (143704)", "As before.", "143704"),
    ] {
        let name = format!("si_{run}.csv");
        let log = data.join(&name);
        let named = [(&*pendulum, "acrobot"), (&*log, &*name)];
        let (command, answer) = program.diagnose(&named, &options)?;
        let measured = program.measure(&named, &options, &answer)?;
        parts.push(Part { title, words: words.to_owned(), command, answer, measured });
    }
    Ok(parts)
}
