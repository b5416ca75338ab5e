//! Logs with feet on the ground as experiments: known figures of the example, and effects against independent
//! computations.
use crate::experiments::support::measured::{Subjects, example, rms};
use bipedc_analysis::experiments::contact_log::{ContactExperiment, ContactRecording, WalkingExperiment};
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::log::Log;
use bipedc_analysis::measure::{Options, Recording};
use bipedc_effects::effect::{Effect, Location, kinds};
use bipedc_runtime::{Argument, Model, State};
use tulip::Tulip;

fn read<'a>(subjects: &'a Subjects, file: &str) -> ContactExperiment<'a> {
    let log = Log::open(example("swaying").join(file)).unwrap();
    ContactExperiment::read(subjects.robot(&Tulip, &[]), &log, &Options::default()).unwrap()
}

/// Errors of the metric of the example: all components together per sample.
fn errors(experiment: &dyn Experiment, effects: &[Effect]) -> [f64; 2] {
    [Channel::BaseForce, Channel::BaseMoment].map(|channel| {
        let rows: Vec<usize> =
            (0..experiment.rows().len()).filter(|r| experiment.rows()[*r].channel == channel).collect();
        rms(experiment, &rows, effects)
    })
}

fn truth() -> Effect {
    Effect::new(
        &kinds::PAYLOAD,
        Location::link("torso"),
        &[("mass", 0.9), ("x", 0.07), ("y", -0.03), ("z", 0.3)],
    )
}

#[test]
#[ignore = "takes long"]
fn the_example_has_its_known_figures() {
    let subjects = Subjects::named("tulip");
    for (file, nominal, oracle, sole) in [
        ("validation.csv.gz", [5.29581, 0.54569], [1.24085, 0.26651], 0.000412),
        ("train.csv.gz", [5.31093, 0.49744], [1.30048, 0.2549], 0.000381),
    ] {
        let experiment = read(&subjects, file);
        let found = [errors(&experiment, &[]), errors(&experiment, &[truth()])];
        println!("{file}: nominal {:?}, oracle {:?} of {:?}", found[0], found[1], [nominal, oracle]);
        for (r, row) in experiment.rows().iter().enumerate() {
            println!(
                "  {}: noise {:.4} {}, true model {:.4}",
                row.name,
                row.noise,
                row.unit,
                rms(&experiment, &[r], &[truth()])
            );
        }
        for q in experiment.quantities(&[]) {
            println!("  {}: {:.6} {} ({})", q.name, q.rms(), q.unit, q.meaning);
        }
        println!("  {}", experiment.recording().assumptions.join("\n  "));
        // The known figure is of the two angles, the angle here is of both together.
        let tilt =
            experiment.quantities(&[]).iter().find(|q| q.name == "right_foot/sole/tilt").unwrap().rms();
        assert!((tilt / 2f64.sqrt() / sole - 1.0).abs() < 0.05, "{tilt}");
        for (found, expected) in found.iter().flatten().zip(nominal.iter().chain(&oracle)) {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} for {expected}");
        }
    }
}

#[test]
fn efforts_are_inverse_dynamics_without_the_feet() {
    let subjects = Subjects::named("tulip");
    let log = Log::open(example("swaying").join("validation.csv.gz")).unwrap();
    let options = Options { cutoff_hz: Some(10.0), ..Options::default() };
    let robot = subjects.robot(&Tulip, &[]);
    let motion = Recording::read(&log, &subjects.layout, &options).unwrap();
    let feet = ContactRecording::read(&robot, &log, &options, Some(1)).unwrap();
    let ground = feet.generalised_forces(&robot, &motion.time, &motion.trajectory.q).unwrap();
    let function = Model::<f64>::function(&Tulip, "inverse_dynamics").unwrap();
    for (j, joint) in subjects.layout.joints.iter().enumerate() {
        let logged = motion.effort[j].as_ref().unwrap();
        let (mut with, mut without) = (0.0, 0.0);
        for (i, logged) in logged.iter().enumerate() {
            let (q, v, a) = (
                &motion.trajectory.q[19 * i..][..19],
                &motion.trajectory.v[18 * i..][..18],
                &motion.trajectory.a[18 * i..][..18],
            );
            let mut tau = [0.0; 18];
            let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
            Tulip.evaluate(function, &state, &mut tau).unwrap();
            let needed = tau[6 + j];
            without += (logged - needed).powi(2);
            with += (logged - needed + ground[18 * i + 6 + j]).powi(2);
        }
        let rms = |sum: f64| (sum / logged.len() as f64).sqrt();
        println!("{}: {:.4} N m without the feet's forces, {:.4} with", joint.name, rms(without), rms(with));
        assert!(rms(with) < 0.5, "{}: {}", joint.name, rms(with));
        // The moment about the vertical is not logged, so the yaw joints gain nothing.
        assert!(joint.name.contains("yaw") || rms(with) < 0.3 * rms(without), "{}", joint.name);
    }
}

/// A log with a time line is no table of postures, whatever rows it has; and a robot that keeps its feet on the ground has no impacts that its filter
/// would be wrong beside.
#[test]
fn joints_of_a_standing_robot_move_in_time_and_beside_no_impacts() {
    let subjects = Subjects::named("tulip");
    let log = Log::open(example("swaying").join("validation.csv.gz")).unwrap();
    let robot = subjects.robot(&Tulip, &[]);
    let walking = WalkingExperiment::read(robot, &log, &Options::default()).unwrap();
    let (motion, base) =
        (walking.motion(), ContactExperiment::read(robot, &log, &Options::default()).unwrap());
    assert_eq!(motion, base.motion());
    assert_eq!(
        (motion.time.as_slice(), motion.positions.len()),
        (walking.time(), subjects.layout.joints.len())
    );
    assert_eq!([walking.beside_impacts(), base.beside_impacts()], [0.0; 2]);
}

/// The example with motors' angles for those of joints, and one joint that carries nothing.
fn by_motors() -> std::path::PathBuf {
    let packed = std::fs::File::open(example("swaying").join("train.csv.gz")).unwrap();
    let table = std::io::read_to_string(flate2::read::GzDecoder::new(packed)).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let idle = header.iter().position(|name| *name == "right_hip_yaw/effort").unwrap();
    let line = |(number, line): (usize, &str)| {
        let cell = |(k, cell): (usize, &str)| match number {
            0 if cell.ends_with("/position") => cell.replace("/position", "/motor_position"),
            0 => cell.to_owned(),
            _ if k == idle => "0".to_owned(),
            _ => cell.to_owned(),
        };
        line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",") + "\n"
    };
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("swaying_by_motors.csv");
    std::fs::write(&file, table.lines().enumerate().map(line).collect::<String>()).unwrap();
    file
}

/// Springs of no stiffness were tried there, and what they leave was no number.
#[test]
fn behind_a_motor_that_carries_nothing_no_spring_is_sought() {
    let subjects = Subjects::named("tulip");
    let log = Log::open(by_motors()).unwrap();
    let walk = WalkingExperiment::read(subjects.robot(&Tulip, &[]), &log, &Options::default()).unwrap();
    let seeds = |joint: &str| {
        let spring: &'static _ = &kinds::SERIES_ELASTICITY;
        assert!(walk.candidates().contains(&(spring, Location::joint(joint))), "{joint}");
        walk.seeds(spring, &Location::joint(joint)).unwrap()
    };
    assert_eq!(seeds("right_hip_yaw"), Vec::<f64>::new());
    let found = seeds("left_knee_pitch");
    assert!(!found.is_empty() && found.iter().all(|stiffness| *stiffness > 0.0), "{found:?}");
    // A shank that lies elsewhere shows in the base and in the joints above it.
    let play = Effect::new(&kinds::BACKLASH, Location::joint("left_knee_pitch"), &[("gap", 0.01)]);
    let changed = walk.response(&[play]);
    let names: Vec<&str> = changed.iter().map(|(row, _)| walk.rows()[*row].name.as_str()).collect();
    assert!(
        ["base/moment/y", "left_hip_pitch", "left_knee_pitch"].iter().all(|row| names.contains(row)),
        "{names:?}"
    );
    assert!(changed.iter().flat_map(|(_, values)| values).all(|x| x.is_finite()));
}
