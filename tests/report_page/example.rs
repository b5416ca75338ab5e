//! TUlip with Coulomb friction in its left knee: the example log against the model, and a diagnosis written by hand.
use bipedc::report::drawing::drawing;
use bipedc_analysis::diagnose::{Diagnosis, ErrorFall, FoundEffect, Rejected, Seen, Step, Unexplained};
use bipedc_analysis::experiments::Channel;
use bipedc_analysis::log::{Mapping, Reader, Table};
use bipedc_analysis::measure::DataSource;
use bipedc_analysis::number::worst_first;
use bipedc_analysis::report::{Fact, HistoryStep, NextStep, Report, Row, Series};
use bipedc_analysis::signal::{Butterworth, Spline};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_effects::effect::{Effect, Location, kinds};
use bipedc_runtime::{Argument, Model, State};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Samples left out at both ends: half a second.
const TRIM: usize = 125;

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// The report of the example `coulomb`, made once.
pub fn report() -> Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(made).clone()
}

fn made() -> Report {
    let robot = Robot::read(&root().join("robots/tulip")).unwrap().with_base("fixed", Some("torso")).unwrap();
    let tree = robot.tree().unwrap();
    let names: Vec<String> = tree.joints.iter().map(|joint| joint.name.clone()).collect();
    let log = root().join("tests/data/examples/coulomb/validation.csv.gz");
    let columns: Vec<String> =
        names.iter().flat_map(|n| [format!("{n}/position"), format!("{n}/effort")]).collect();
    let table = Table::read(Reader::open(&log, &Mapping::default()).unwrap(), &columns).unwrap();
    let motion: Vec<[Vec<f64>; 3]> =
        names.iter().map(|n| derivatives(table.column(&format!("{n}/position")).unwrap())).collect();
    let request = FunctionRequest::of_robot("inverse_dynamics");
    let nominal = torques(&ProgramModel::new(robot.compile_only(&[request]).unwrap()), &motion);
    let time = table.columns[0][TRIM..table.rows() - TRIM].to_vec();
    let rows = names.iter().enumerate().map(|(j, name)| {
        let measured = table.column(&format!("{name}/effort")).unwrap();
        row(name, &time, &measured[TRIM..measured.len() - TRIM], &nominal[j], &motion[j])
    });
    let mut rows: Vec<Row> = rows.collect();
    worst_first(&mut rows, |row| row.unit.clone(), |row| row.rms_before);
    let posture: Vec<f64> = motion.iter().map(|m| m[0].iter().sum::<f64>() / m[0].len() as f64).collect();
    Report {
        title: "tulip: diagnosis of train.csv.gz".to_owned(),
        robot: "tulip".to_owned(),
        log: "validation.csv.gz".to_owned(),
        next: vec![NextStep {
            why: "Write what was found into the description:".to_owned(),
            command: "bipedc amend robots/tulip --from diagnosis.json".to_owned(),
        }],
        drawing: Some(drawing(&robot.description, &tree, &posture)),
        diagnosis: Some(diagnosis(&rows)),
        history: history(),
        facts: vec![
            Fact::new("filter", "zero-phase 4th-order Butterworth; efforts are not filtered"),
            Fact::new("cut-off", "16 Hz"),
            Fact::new("samples", time.len().to_string()),
        ],
        rows,
        ..Report::default()
    }
}

/// Filtered position, velocity, acceleration without the ends.
fn derivatives(position: &[f64]) -> [Vec<f64>; 3] {
    let spline = Spline::new(&Butterworth::new(16.0, 250.0).unwrap().zero_phase(position), 0.004).unwrap();
    let samples = TRIM..position.len() - TRIM;
    [0, 1, 2].map(|order| samples.clone().map(|i| spline.at_sample(i)[order]).collect())
}

/// Nominal torques per joint.
fn torques(model: &dyn Model<f64>, motion: &[[Vec<f64>; 3]]) -> Vec<Vec<f64>> {
    let function = model.function("inverse_dynamics").unwrap();
    let count = motion[0][0].len();
    let mut nominal = vec![Vec::with_capacity(count); motion.len()];
    let mut tau = vec![0.0; motion.len()];
    for i in 0..count {
        let [q, v, a] = [0, 1, 2].map(|order| motion.iter().map(|m| m[order][i]).collect::<Vec<f64>>());
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
        model.evaluate(function, &state, &mut tau).unwrap();
        nominal.iter_mut().zip(&tau).for_each(|(joint, u)| joint.push(*u));
    }
    nominal
}

fn row(name: &str, time: &[f64], measured: &[f64], nominal: &[f64], motion: &[Vec<f64>; 3]) -> Row {
    let friction =
        |(u, v): (&f64, &f64)| if name == "left_knee_pitch" { u + 0.402 * (v / 0.02).tanh() } else { *u };
    let series = Series {
        time: time.to_vec(),
        measured: measured.to_vec(),
        nominal: nominal.to_vec(),
        amended: Some(nominal.iter().zip(&motion[1]).map(friction).collect()),
        ..Series::default()
    };
    let series = series
        .with("velocity", "rad/s", motion[1].clone())
        .with("position", "rad", motion[0].clone())
        .with("acceleration", "rad/s²", motion[2].clone())
        .with("load", "N m", nominal.to_vec());
    // As stated in the example's truth.json.
    let noise = match name {
        n if n.contains("ankle") => 0.02,
        n if n.contains("yaw") => 0.03,
        _ => 0.05,
    };
    let speed = motion[1].clone();
    let mut row = Row::new(name, Channel::Effort, "N m", noise, series).at_joint(name);
    if row.unexplained_before > 0.1 {
        row.note = "The residual follows the sign of velocity and jumps where the joint reverses.".to_owned();
    }
    row.with_part("moving up", |i| speed[i] > 0.05)
        .with_part("moving down", |i| speed[i] < -0.05)
        .with_part("reversing or standing", |i| speed[i].abs() <= 0.05)
}

fn found(effect: Effect, ci95: &[(&str, [f64; 2])], share: f64) -> FoundEffect {
    let ci95 = ci95.iter().map(|(name, interval)| ((*name).to_owned(), *interval)).collect();
    FoundEffect { effect, ci95, share, doubts: Vec::new() }
}

/// What a diagnosis of this log says, with one of everything that the page can show.
fn diagnosis(rows: &[Row]) -> Diagnosis {
    let knee = || Location::joint("left_knee_pitch");
    let coulomb = || Effect::new(&kinds::COULOMB_FRICTION, knee(), &[("torque", 0.402), ("smoothing", 0.02)]);
    let viscous =
        Effect::new(&kinds::VISCOUS_FRICTION, Location::joint("left_hip_roll"), &[("damping", 0.0131)]);
    let stribeck = Effect::new(
        &kinds::STRIBECK_FRICTION,
        knee(),
        &[("coulomb", 0.399), ("static", 0.43), ("stribeck_velocity", 0.08)],
    );
    let total =
        |of: fn(&Row) -> f64| (rows.iter().map(|r| of(r).powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
    let (before, after) = (total(|r| r.rms_before), total(|r| r.rms_after.unwrap()));
    let noise = total(|r| r.noise);
    let fall = ErrorFall { unit: "N m".to_owned(), before, after, noise, ..ErrorFall::default() };
    let first = || found(coulomb(), &[("torque", [0.397, 0.408])], 0.905);
    let mut doubtful = found(viscous.clone(), &[("damping", [0.0042, 0.022])], 0.004);
    doubtful.doubts.push("its share is near the noise".to_owned());
    let com = Effect::new(
        &kinds::COM_OFFSET,
        Location::link("left_lower_leg"),
        &[("x", 0.0011), ("y", -0.0003), ("z", 0.0006)],
    );
    let ci = [("x", [0.0004, 0.0018]), ("y", [-0.0011, 0.0005]), ("z", [-0.0002, 0.0014])];
    let source = |file: &str, hash: &str, samples| DataSource {
        file: file.to_owned(),
        hash: hash.to_owned(),
        samples,
    };
    Diagnosis {
        effects: vec![first(), doubtful],
        inertial_corrections: vec![found(com, &ci, 0.002)],
        indistinguishable: vec![vec![vec![first()], vec![found(stribeck, &[], 0.905)]]],
        unexplained: true,
        suspects: vec!["right_ankle_roll".to_owned()],
        unexplained_parts: vec![Unexplained {
            seen: Seen::Motion,
            joint: "right_ankle_roll".to_owned(),
            share: 0.062,
            signals: vec!["position".to_owned(), "load".to_owned()],
            late_s: None,
        }],
        rejected: vec![Rejected {
            kind: &kinds::ROTOR_INERTIA,
            place: knee(),
            why: "held-out error falls by 0.1 % only".to_owned(),
        }],
        rms: [("effort".to_owned(), fall)].into(),
        rms_before: before,
        rms_after: after,
        steps: vec![
            Step { effect: coulomb(), before, after: 1.003 * after },
            Step { effect: viscous, before: 1.003 * after, after },
        ],
        training: source("train.csv.gz", "9f3c51b7a0e4d218", 3501),
        validation: Some(source("validation.csv.gz", "1b02c77d5a9e6f30", 2251)),
        warnings: vec!["right_hip_yaw hardly moves: friction cannot be told from bias there".to_owned()],
        assumptions: vec!["the log has no base/... columns: the root link is taken as fixed, upright and at rest".to_owned()],
        cutoff_hz: 16.0,
        summary: "left_knee_pitch: 99 % of its residual is Coulomb friction of 0.402 N m (95 %: 0.397 to 0.408). The held-out \
                  error falls to the noise floor; rotor inertia was tried and rejected."
            .to_owned(),
        ..Diagnosis::default()
    }
}

/// A made-up history with dates and both errors.
fn history() -> Vec<HistoryStep> {
    let fall = |before, after| {
        Some(ErrorFall { unit: "N m".to_owned(), before, after, noise: 0.0381, ..ErrorFall::default() })
    };
    let step = |label: &str, date: &str, training, held_out| HistoryStep {
        label: label.to_owned(),
        date: date.to_owned(),
        training,
        held_out,
    };
    vec![
        step("inertial corrections", "2026-11-19", fall(0.1304, 0.1262), fall(0.1292, 0.1210)),
        step("Coulomb friction at left_knee_pitch", "2026-11-20", fall(0.1262, 0.0391), fall(0.1210, 0.0397)),
        step("Viscous friction at left_hip_roll", "2026-11-21", fall(0.0391, 0.0382), fall(0.0397, 0.0384)),
    ]
}
