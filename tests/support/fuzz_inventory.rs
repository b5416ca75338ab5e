//! The body of the fuzz target `inventory`: any bytes as a log with any names, examined for a robot and written again. What is
//! proposed must read as a mapping file, and what is written must be a log.
use bipedc::inventory::{Robot, examine, rewrite};
use bipedc_analysis::log::{Log, Mapping};
use bipedc_compiler::description::SourceFiles;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Two legs of one joint each.
const URDF: &str = include_str!("fuzz_robot.urdf");
const TOML: &str = include_str!("fuzz_robot.toml");

fn robot() -> &'static Robot {
    static ROBOT: OnceLock<Robot> = OnceLock::new();
    ROBOT.get_or_init(|| {
        let sources = SourceFiles {
            urdf_path: PathBuf::from("robot.urdf"),
            urdf_text: URDF.to_owned(),
            toml_path: PathBuf::from("biped.toml"),
            toml_text: TOML.to_owned(),
        };
        let (description, warnings) = sources.parse().expect("a robot");
        Robot::of(&bipedc::Robot { description, warnings, sources }).expect("a robot with a tree")
    })
}

/// Examines, prints, proposes, writes, in files of this folder.
pub fn run(data: &[u8], folder: &Path) {
    let (log, out) = (folder.join("log.csv"), folder.join("out.csv"));
    std::fs::write(&log, data).expect("a scratch file");
    let Ok(found) = examine(&log, &Mapping::default(), Some(robot())) else { return };
    drop((found.to_string(), serde_json::to_string(&found).expect("JSON")));
    let mapping = Mapping::parse(Path::new("map.toml"), &found.mapping()).expect("a mapping file");
    if found.has_header && !mapping.columns.is_empty() {
        examine(&log, &mapping, Some(robot())).expect("a mapping of what is there");
    }
    if rewrite(&found, &out).is_ok() {
        Log::open(&out).expect("a log");
    }
}
