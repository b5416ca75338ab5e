//! A humanoid that walks, with wrenches below its feet and no joint torques.
use crate::run::{Failure, Part, Program, failure, robot, text};
use std::fmt::Write as _;
use std::path::Path;

const WORDS: &str = "\
iCubGenova04, 33 kg, 89 s of walking with motion capture and foot wrenches (source: ami-iit/kindyn-vio, BSD-3-Clause), 3 Hz;
blocks of the log judge. Known: +0.84 kg or a vertical gain of 2.5 % explain the vertical force equally well, a tilt of 5.6°
and 2.1° or a bias of -31.6 and 11.9 N the horizontal one; none explains the 22 N of lateral force. Only the force
rows count here, as in the known result: the moments hang on where the robot's own estimator puts the wrenches.";

/// Asks what is missing.
///
/// # Errors
/// Files that cannot be read or written; a refusal of the program.
pub fn run(data: &Path, folder: &Path, program: &Program) -> Result<Vec<Part>, Failure> {
    let data = data.join("icub_walking");
    let mut description = "[base]\nkind = \"floating\"\nroot = \"root_link\"\n".to_owned();
    let mut mapping = String::new();
    for foot in ["l_sole", "r_sole"] {
        // Writing into strings cannot fail.
        let _ = writeln!(description, "[feet.{foot}]\nlink = \"{foot}\"");
        for (end, x) in [("front", 0.12), ("rear", -0.07)] {
            for (side, y) in [("left", 0.045), ("right", -0.045)] {
                let _ = writeln!(description, "points.{end}_{side} = [{x}, {y}, 0.0]");
            }
        }
        for what in ["force", "torque"] {
            let _ = writeln!(mapping, "\"{foot}/{what}\" = {{ frame = \"sole\" }}");
        }
    }
    let humanoid = robot(folder, &text(&data.join("iCubGenova04.urdf"))?, &description)?;
    let file = folder.join("icub.toml");
    std::fs::write(&file, mapping).map_err(|e| failure(format!("{}: {e}", file.display())))?;
    let log = data.join("icub_walking.csv");
    let named = [(&*humanoid, "icub"), (&*log, "icub_walking.csv")];
    let mapping = file.to_string_lossy();
    let options = ["--mapping", &mapping, "--cutoff", "3", "--most", "4", "--channels", "base_force"];
    let (command, answer) = program.diagnose(&named, &options)?;
    let measured = program.measure(&named, &options, &answer)?;
    Ok(vec![Part { title: "iCub, walking", words: WORDS.to_owned(), command, answer, measured }])
}
