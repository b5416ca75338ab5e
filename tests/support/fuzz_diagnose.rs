//! The body of the fuzz target `diagnose`: any bytes as a log of robots that are fine, then what `bipedc diagnose`,
//! `compare` and `compare --free-run` do with it.
use bipedc::{ProgramTorques, feet, link_inertias};
use bipedc_analysis::compare::{self};
use bipedc_analysis::diagnose::{Options, diagnose};
use bipedc_analysis::experiments::contact_log::ContactExperiment;
use bipedc_analysis::experiments::data_checks::inspect;
use bipedc_analysis::experiments::impacts::ImpactExperiment;
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::experiments::{Experiment, MotionExperiment};
use bipedc_analysis::log::{Log, Mapping};
use bipedc_analysis::measure;
use bipedc_analysis::measure::{Content, Recording};
use bipedc_analysis::robot::link_inertias::LinkInertias;
use bipedc_analysis::robot::{BaseKind, Foot, Joint, JointLayout};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::SourceFiles;
use bipedc_effects::diagnostic::Diagnostics;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Longer logs take their time, as they should.
const MOST_BYTES: usize = 30_000;
const MOST_SAMPLES: usize = 300;
/// Two legs of one joint each, on soles.
const URDF: &str = include_str!("fuzz_robot.urdf");
const TOML: &str = include_str!("fuzz_robot.toml");

struct Subjected {
    model: ProgramModel,
    torques: ProgramTorques,
    layout: JointLayout,
    link_inertias: LinkInertias,
    feet: Vec<Foot>,
}

fn robot() -> Result<Subjected, Diagnostics> {
    let sources = SourceFiles {
        urdf_path: PathBuf::from("robot.urdf"),
        urdf_text: URDF.to_owned(),
        toml_path: PathBuf::from("biped.toml"),
        toml_text: TOML.to_owned(),
    };
    let (description, warnings) = sources.parse()?;
    let robot = Robot { description, warnings, sources };
    let one = |error| Diagnostics(vec![error]);
    let tree = robot.tree().map_err(one)?;
    let request = |family: &str, subject: Option<&String>| FunctionRequest {
        family: family.to_owned(),
        subject: subject.cloned(),
    };
    let mut requests: Vec<FunctionRequest> = [
        "inverse_dynamics",
        "inverse_dynamics_regressor",
        "center_of_mass",
        "center_of_mass_regressor",
        "center_of_mass_jacobian",
    ]
    .map(|family| request(family, None))
    .to_vec();
    for foot in &robot.description.feet {
        requests.extend(["position", "rotation", "jacobian"].map(|family| request(family, Some(&foot.link))));
    }
    let compiled = robot.compile_only(&requests).map_err(one)?;
    let joints = tree.joints.iter().map(|joint| Joint::revolute(&joint.name)).collect();
    Ok(Subjected {
        torques: ProgramTorques::new(&compiled).map_err(one)?,
        model: ProgramModel::new(compiled),
        layout: JointLayout { joints, base: BaseKind::Floating },
        link_inertias: link_inertias(&robot.description, &tree),
        feet: feet(&robot.description),
    })
}

/// Up to a zero byte the input is a mapping file, what follows is the table; without one it is all table.
pub fn run(data: &[u8]) {
    static ROBOT: Mutex<Option<Subjected>> = Mutex::new(None);
    if data.len() > MOST_BYTES {
        return;
    }
    let (mapping, table) = match data.iter().position(|b| *b == 0) {
        Some(end) => (std::str::from_utf8(&data[..end]).unwrap_or(""), &data[end + 1..]),
        None => ("", data),
    };
    let Ok(mapping) = Mapping::parse(Path::new("map.toml"), mapping) else { return };
    // The experiments open their files themselves.
    let file = std::env::temp_dir().join(format!("bipedc-fuzz-{}.csv", std::process::id()));
    let mut robot = ROBOT.lock().unwrap_or_else(|broken| broken.into_inner());
    let robot = robot.get_or_insert_with(robot_or_why);
    std::fs::write(&file, table).expect("a temporary file");
    let told = found(robot, &file, &mapping);
    std::fs::remove_file(&file).expect("our own file");
    if let Err(errors) = told {
        assert!(!errors.0.is_empty());
        drop(errors.to_string());
    }
}

fn robot_or_why() -> Subjected {
    robot().unwrap_or_else(|errors| panic!("the robot is fine: {errors}"))
}

/// What the file holds, as `bipedc diagnose` sees it.
fn found(own: &mut Subjected, file: &Path, mapping: &Mapping) -> Result<(), Diagnostics> {
    let log = Log::with_mapping(file, mapping.clone())?;
    let content = log.content(&own.layout);
    // Short logs of a fuzzer must reach the filter, too.
    let mut options = measure::Options { trim_s: 0.0, ..measure::Options::default() };
    if content == Content::Efforts {
        let compared = compare::compare_file(&mut own.torques, &own.layout, &log, &options)?;
        drop(compared.to_string());
        options.cutoff_hz = Some(compared.cutoff_hz);
    } else {
        options.cutoff_hz = Some(5.0);
    }
    let robot = bipedc_analysis::robot::Robot {
        model: &own.model,
        layout: &own.layout,
        link_inertias: &own.link_inertias,
        feet: &own.feet,
        effects: &[],
    };
    let experiment: Box<dyn Experiment + '_> = match content {
        Content::Postures => Box::new(PostureExperiment::read(robot, &log, None)?),
        Content::Impacts => Box::new(ImpactExperiment::read(robot, &log, None)?),
        Content::Contacts => Box::new(ContactExperiment::read(robot, &log, &options)?),
        Content::Efforts => {
            let mut recording = Recording::read(&log, &own.layout, &options)?;
            recording.thin(MOST_SAMPLES);
            let motion = MotionExperiment::new(&own.model, &own.layout, &own.link_inertias, recording, &[]);
            Box::new(motion.map_err(|error| Diagnostics(vec![error]))?)
        }
    };
    drop(inspect(&*experiment, None));
    let answer = diagnose(&*experiment, None, &Options { most: Some(1), ..Options::default() }, &|_| ());
    drop(serde_json::to_string(&answer).map(|text| text + &answer.summary));
    Ok(())
}
