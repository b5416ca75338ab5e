//! Dynamic identification from ground forces: the thesis' figure 8.6b, in simulation.
//!
//! `cargo run --release --example ground_force_identification` prints a Markdown page. TUlip stands on its right foot and
//! moves all joints; its parameters differ from the URDF's. First exact states, then logs through the tool's own filter.
#[path = "reproduction/mod.rs"]
mod reproduction;

use bipedc::ProgramRegressor;
use bipedc::identification::standing::{Root, StandingRobot};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::contact_log::ContactExperiment;
use bipedc_analysis::identify::cop::least_squares;
use bipedc_analysis::identify::{
    BaseSet, BatchRegressor, Feed, Options as IdentifyOptions, RobotAndLogs, Survey, identify,
};
use bipedc_analysis::log::{Mapping, Reader};
use bipedc_analysis::measure::Options;
use bipedc_analysis::robot::Batch;
use bipedc_compiler::compile::FunctionRequest;
use bipedc_compiler::exact::Model;
use bipedc_runtime::nalgebra::{DMatrix, DVector};
use bipedc_runtime::{Argument, State};
use reproduction::{Failure, Noise, Stood, one, other, said, tulip};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Seconds, and samples per second.
const LENGTH: (f64, f64) = (80.0, 100.0);
/// Standard deviations of encoders (rad), centre of pressure (m) and vertical force (N) in the noisy log.
const NOISE: [f64; 3] = [1e-4, 2e-3, 1.0];

/// The motion: per joint a middle and four waves of amplitude (rad), frequency (rad/s) and phase.
struct Motion(Vec<(f64, Vec<[f64; 3]>)>);

impl Motion {
    /// Weight over the right foot; the stance leg sways a little, the swing leg kicks.
    fn new(joints: &[&str], seed: u64, faster: f64) -> Self {
        let mut noise = Noise(seed);
        let joint = |name: &&str| {
            let (middle, size) = match *name {
                "right_ankle_roll" => (-0.17, 0.01),
                "right_hip_roll" => (0.12, 0.02),
                "right_ankle_pitch" => (-0.16, 0.01),
                "right_knee_pitch" => (0.35, 0.02),
                "right_hip_pitch" => (-0.25, 0.02),
                "right_hip_yaw" => (0.0, 0.03),
                "left_knee_pitch" => (0.8, 0.08),
                "left_hip_pitch" => (-0.4, 0.05),
                _ => (0.0, 0.05),
            };
            let wave = |k: usize| {
                [
                    size * (0.6 + 0.4 * noise.even()),
                    faster * TAU * (0.1 + 0.2 * k as f64 + 0.08 * noise.even()),
                    3.1 * noise.even(),
                ]
            };
            (middle, (0..4).map(wave).collect())
        };
        Self(joints.iter().map(joint).collect())
    }

    /// Position, velocity or acceleration of all joints.
    fn at(&self, time: f64, order: usize) -> Vec<f64> {
        let wave = |[a, w, phase]: &[f64; 3]| {
            let x = w * time + phase;
            a * [x.sin(), w * x.cos(), -w * w * x.sin()][order]
        };
        let joint = |(middle, waves): &(f64, Vec<[f64; 3]>)| {
            waves.iter().map(wave).sum::<f64>() + if order == 0 { *middle } else { 0.0 }
        };
        self.0.iter().map(joint).collect()
    }
}

/// States and wrenches of the true robot at the root, a corner of the right sole.
struct Truth {
    time: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// Fx, Fy, Fz, Mx, My, Mz.
    wrench: Vec<[f64; 6]>,
}

impl Truth {
    fn new(stood: &Stood, seed: u64, faster: f64) -> Result<Self, Failure> {
        let joints: Vec<&str> = stood.layout.joints.iter().map(|j| j.name.as_str()).collect();
        let motion = Motion::new(&joints, seed, faster);
        let model: &dyn bipedc_runtime::Model<f64> = &stood.model;
        let function = model.function("inverse_dynamics").ok_or("no inverse dynamics")?;
        let count = (LENGTH.0 * LENGTH.1) as usize;
        let mut truth =
            Self { time: Vec::new(), q: Vec::new(), v: Vec::new(), a: Vec::new(), wrench: Vec::new() };
        for i in 0..count {
            let time = i as f64 / LENGTH.1;
            let rest = [0.0; 6];
            let q = [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &motion.at(time, 0)].concat();
            let (v, a) =
                ([&rest[..], &motion.at(time, 1)].concat(), [&rest[..], &motion.at(time, 2)].concat());
            let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
            let mut tau = vec![0.0; v.len()];
            model.evaluate(function, &state, &mut tau).map_err(|e| format!("{e:?}"))?;
            truth.wrench.push(std::array::from_fn(|k| tau[k]));
            truth.time.push(time);
            truth.q.extend(q);
            truth.v.extend(v);
            truth.a.extend(a);
        }
        Ok(truth)
    }
}

fn main() -> Result<(), Failure> {
    let stood = Stood::new(StandingRobot::new(&tulip()?, Some("right_foot"), Root::Sole).map_err(said)?)?;
    let hidden =
        Stood::new(StandingRobot::new(&other(&tulip()?, 86), Some("right_foot"), Root::Sole).map_err(said)?)?;
    let base = stood.rooted.base(Model::ZeroMomentPoint, &["Fz", "Mx", "My"], false).map_err(one)?;
    let actual = base.values(&hidden.rooted.link_inertias.parameters());
    let nominal = base.values(&stood.rooted.link_inertias.parameters());
    let truth = Truth::new(&hidden, 1, 1.0)?;
    let corner = stood
        .feet
        .iter()
        .find(|foot| foot.name == "right_foot")
        .map(|foot| foot.corner(0))
        .ok_or("no right foot")?;
    let pressure = |w: &[f64; 6]| [corner.x - w[4] / w[2], corner.y + w[3] / w[2]];
    let inside = |w: &&[f64; 6]| {
        let [x, y] = pressure(w);
        (-0.09..=0.15).contains(&x) && y.abs() <= 0.06
    };
    let stable = truth.wrench.iter().filter(inside).count();
    println!(
        "TUlip on its right foot moves all twelve joints for {:.0} s; masses differ from the URDF's by up to 15 %, centres of mass by up to 12 mm, inertias by up to 30 %. The centre of pressure is inside the sole in {:.0} % of the samples. {} base parameters (rows Mx, My about the ground, Fz).\n",
        LENGTH.0,
        100.0 * stable as f64 / truth.time.len() as f64,
        base.sums.len()
    );
    println!(
        "| data | relative error below 1e-9 | largest of one | of all | rms error of the zero moment point, other motion, mm |\n|---|---|---|---|---|"
    );
    let judge = Truth::new(&hidden, 2, 1.0)?;
    let regressor = regressor(&stood, &base)?;
    let row = |name: &str, theta: &[f64]| {
        let error = 1e3 * missed(&regressor, &judge, theta);
        let error = if error < 1e-3 { format!("{error:.1e}") } else { format!("{error:.3}") };
        println!(
            "| {name} | {} of {} | {:.1e} | {:.1e} | {error} |",
            precise(theta, &actual),
            theta.len(),
            worst(theta, &actual).0,
            relative(theta, &actual)
        );
    };
    row("URDF", &nominal);
    let mut words = String::new();
    for (name, faster) in [
        ("exact positions, velocities, accelerations", 1.0),
        ("the same, joints five times as fast, foot held to the ground", 5.0),
    ] {
        let states = Truth::new(&hidden, 1, faster)?;
        let (w, y) = exact(&regressor, &states);
        // Refined by solving again for what is left: rounding of the first solution is larger than that of the data.
        let refine = |theta: DVector<f64>| least_squares(&w, &y, theta.as_slice());
        let found = (0..4).fold(DVector::zeros(base.sums.len()), |theta, _| refine(theta));
        row(name, found.as_slice());
        let (error, k) = worst(found.as_slice(), &actual);
        let _ = writeln!(
            words,
            "- {name}: condition number {:.0} (columns of length 1); the largest relative error, {error:.1e}, is that of `{}`, {:.1e} {}.",
            condition(&w),
            base.names[k],
            actual[k],
            base.units[k]
        );
    }
    for (name, noise) in
        [("log at 100 Hz without noise, filter of 8 Hz", [0.0; 3]), ("the same with noise", NOISE)]
    {
        let text = log(&stood, &truth, &pressure, noise);
        let reader = Reader::from_source(
            Path::new("kicks.csv"),
            Box::new(Cursor::new(text.into_bytes())),
            &Mapping::default(),
        )
        .map_err(said)?;
        let options = Options { cutoff_hz: Some(8.0), trim_s: 1.0, ..Options::default() };
        let experiment = ContactExperiment::from_reader(stood.robot(), reader, &options).map_err(said)?;
        let (free, possible) = identified(&stood, &base, &experiment, &nominal)?;
        row(&format!("{name}: least squares"), &free);
        row(&format!("{name}: physically possible"), &possible);
    }
    println!("\n{words}");
    println!(
        "Noise: encoders {:.0e} rad, centre of pressure {:.0} mm, vertical force {:.0} N. Exact states are the waves' derivatives with the inverse dynamics of the true robot. Logs hold positions, vertical force and centre of pressure alone: velocities and accelerations are the tool's own, and the rest is `bipedc identify --method zmp`.",
        NOISE[0],
        1e3 * NOISE[1],
        NOISE[2]
    );
    println!(
        "\nThesis: 'all parameters are estimated within machine accuracy', from simulated forces without noise."
    );
    Ok(())
}

fn regressor(stood: &Stood, base: &BaseSet) -> Result<ProgramRegressor, Failure> {
    let request = FunctionRequest::of_robot("inverse_dynamics_regressor");
    let compiled = stood.rooted.robot.clone().without_effects().compile_only(&[request]).map_err(one)?;
    let leading: Vec<usize> = (0..base.sums.len()).filter_map(|k| base.leading(k)).collect();
    Ok(ProgramRegressor::new(
        &compiled.functions[0].program,
        (stood.rooted.tree.nq, stood.rooted.tree.nv),
        &leading,
    ))
}

/// Rows Fz, Mx, My of all samples, and what was exerted.
fn exact(regressor: &ProgramRegressor, truth: &Truth) -> (DMatrix<f64>, DVector<f64>) {
    let count = truth.time.len();
    let pattern = regressor.pattern();
    let mut entries = vec![0.0; pattern.iter().map(Vec::len).sum::<usize>() * count];
    regressor.evaluate(&Batch::new(count, [&truth.q, &truth.v, &truth.a]), &mut entries);
    let columns = pattern.iter().flatten().max().map_or(0, |k| k + 1);
    let (mut w, mut y) = (DMatrix::zeros(3 * count, columns), DVector::zeros(3 * count));
    let mut first = 0;
    for (row, own) in pattern.iter().enumerate() {
        if let Some(place) = [2, 3, 4].iter().position(|r| *r == row) {
            for (k, column) in own.iter().enumerate() {
                (0..count).for_each(|i| w[(3 * i + place, *column)] = entries[(first + k) * count + i]);
            }
            (0..count).for_each(|i| y[3 * i + place] = truth.wrench[i][row]);
        }
        first += own.len();
    }
    (w, y)
}

/// What `bipedc identify --method zmp` makes of a log: least squares and physically possible base parameters.
fn identified(
    stood: &Stood,
    base: &BaseSet,
    experiment: &dyn Experiment,
    nominal: &[f64],
) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let surveys = [Survey::of_table(experiment, stood.layout.joints.len(), 8.0)];
    let parts = RobotAndLogs {
        layout: &stood.layout,
        link_inertias: &stood.rooted.link_inertias,
        base,
        regressor: &Nothing,
        rows: &[],
        files: &[PathBuf::from("kicks.csv")],
        surveys: &surveys,
    };
    let answer = identify(&parts, &Feed::Tables(&[experiment]), None, &IdentifyOptions::default(), &|_| ())
        .map_err(said)?;
    let estimate = |(name, nominal): (&String, &f64)| {
        answer.identification.parameters.iter().find(|p| p.name == *name).map_or(*nominal, |p| p.value)
    };
    let free = base.names.iter().zip(nominal).map(estimate).collect();
    let mut link_inertias = stood.rooted.link_inertias.clone();
    for link in &mut link_inertias.links {
        if let Some((_, inertia)) = answer.links.iter().find(|(name, _)| *name == link.name) {
            (link.mass, link.center) = (inertia.mass, inertia.center.into());
            link.inertia = std::array::from_fn(|i| std::array::from_fn(|j| inertia.inertia[(i, j)]));
        }
    }
    Ok((free, base.values(&link_inertias.parameters())))
}

/// Rows come from the log: no regressor is evaluated.
struct Nothing;

impl BatchRegressor for Nothing {
    fn nq(&self) -> usize {
        0
    }
    fn nv(&self) -> usize {
        0
    }
    fn pattern(&self) -> &[Vec<usize>] {
        &[]
    }
    fn evaluate(&self, _batch: &Batch<'_>, _out: &mut [f64]) {}
}

/// A log of positions, vertical force and centre of pressure of the standing foot.
fn log(stood: &Stood, truth: &Truth, pressure: &dyn Fn(&[f64; 6]) -> [f64; 2], sigma: [f64; 3]) -> String {
    let joints = stood.layout.joints.len();
    let nq = truth.q.len() / truth.time.len();
    let mut noise = Noise(5);
    let mut text = String::from("time");
    for joint in &stood.layout.joints {
        let _ = write!(text, ",{}/position", joint.name);
    }
    text.push_str(",right_foot/force/z,right_foot/cop/x,right_foot/cop/y\n");
    for (i, wrench) in truth.wrench.iter().enumerate() {
        let _ = write!(text, "{}", truth.time[i]);
        for q in &truth.q[(i + 1) * nq - joints..(i + 1) * nq] {
            let _ = write!(text, ",{}", q + sigma[0] * noise.normal());
        }
        let [x, y] = pressure(wrench).map(|c| c + sigma[1] * noise.normal());
        let _ = writeln!(text, ",{},{x},{y}", wrench[2] + sigma[2] * noise.normal());
    }
    text
}

/// Root mean square error of the zero moment point of a motion, m.
fn missed(regressor: &ProgramRegressor, truth: &Truth, theta: &[f64]) -> f64 {
    let (w, y) = exact(regressor, truth);
    let model = w * DVector::from_column_slice(theta);
    let point = |v: &DVector<f64>, i: usize| [-v[3 * i + 2] / v[3 * i], v[3 * i + 1] / v[3 * i]];
    let square = |i: usize| {
        let (a, b) = (point(&model, i), point(&y, i));
        (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
    };
    ((0..truth.time.len()).map(square).sum::<f64>() / (2 * truth.time.len()) as f64).sqrt()
}

/// The largest relative error of one parameter, and whose it is.
fn worst(found: &[f64], actual: &[f64]) -> (f64, usize) {
    let errors = found.iter().zip(actual).map(|(a, b)| (a - b).abs() / b.abs()).enumerate();
    errors.map(|(k, e)| (e, k)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
}

fn precise(found: &[f64], actual: &[f64]) -> usize {
    found.iter().zip(actual).filter(|(a, b)| (*a - *b).abs() < 1e-9 * b.abs()).count()
}

fn relative(found: &[f64], actual: &[f64]) -> f64 {
    let square = |pairs: &mut dyn Iterator<Item = f64>| pairs.map(|x| x * x).sum::<f64>().sqrt();
    square(&mut found.iter().zip(actual).map(|(a, b)| a - b)) / square(&mut actual.iter().copied())
}

fn condition(w: &DMatrix<f64>) -> f64 {
    let mut scaled = w.clone();
    scaled.column_iter_mut().for_each(|mut column| _ = column.normalize_mut());
    let singular = scaled.tr_mul(&scaled).symmetric_eigenvalues();
    (singular.max() / singular.min().max(f64::MIN_POSITIVE)).sqrt()
}
