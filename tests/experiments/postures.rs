//! Static postures as an experiment: known figures of the example, and every effect against an independent computation.
use crate::experiments::support::measured::{Subjects, example, inertial_error, rms};
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::log::{Log, Mapping, Reader};
use bipedc_effects::effect::{Effect, Location, kinds};
use bipedc_runtime::nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};
use bipedc_runtime::{Argument, Model, State};
use std::io::Cursor;
use std::path::Path;
use tulip::Tulip;

fn read<'a>(subjects: &'a Subjects, file: &str, effects: &'a [Effect]) -> PostureExperiment<'a> {
    let log = Log::open(example("postures").join(file)).unwrap();
    PostureExperiment::read(subjects.robot(&Tulip, effects), &log, None).unwrap()
}

fn shift(x: f64, y: f64, z: f64) -> Effect {
    Effect::new(&kinds::COM_OFFSET, Location::link("torso"), &[("x", x), ("y", y), ("z", z)])
}

#[test]
fn the_example_has_its_known_figures() {
    let subjects = Subjects::named("tulip");
    for (file, nominal, oracle) in [
        ("validation.csv.gz", 0.007564695466710348, 0.0003098288217326317),
        ("train.csv.gz", 0.007619020137309717, 0.0002615346907356095),
    ] {
        let experiment = read(&subjects, file, &[]);
        let truth = [shift(-0.018, 0.009, 0.0)];
        let found = [rms(&experiment, &[0, 1], &[]), rms(&experiment, &[0, 1], &truth)];
        println!("{file}: nominal {} m, oracle {} m", found[0], found[1]);
        for row in experiment.rows() {
            println!("  {}: noise {:e} {}", row.name, row.noise, row.unit);
        }
        println!("  {}", experiment.assumptions.join("\n  "));
        assert!((found[0] / nominal - 1.0).abs() < 0.005, "{found:?}");
        assert!((found[1] / oracle - 1.0).abs() < 0.03, "{found:?}");
        let noise = experiment.rows()[0].noise;
        assert!(noise > 0.5 * oracle && noise < 1.5 * oracle, "{noise}");
        assert_eq!(experiment.rows()[2].channel, Channel::BaseForce);
    }
}

#[test]
fn an_effect_of_the_description_is_part_of_the_prediction() {
    let subjects = Subjects::named("tulip");
    let truth = [shift(-0.018, 0.009, 0.0)];
    let (with, without) = (read(&subjects, "train.csv.gz", &truth), read(&subjects, "train.csv.gz", &[]));
    let expected = rms(&without, &[0, 1], &truth);
    assert!((rms(&with, &[0, 1], &[]) - expected).abs() < 1e-12);
    assert!(with.response(&[]).is_empty(), "nothing changes nothing");
}

#[test]
fn derivatives_by_inertial_parameters_are_those_of_the_response() {
    let subjects = Subjects::named("tulip");
    let experiment = read(&subjects, "validation.csv.gz", &[]);
    // The centre of mass is linear in first moments, so a shift is exact; a mass changes the denominator.
    assert!(inertial_error(&experiment, &shift(0.01, -0.02, 0.03)) < 1e-9);
    let payload = |mass: f64| {
        Effect::new(
            &kinds::PAYLOAD,
            Location::link("left_foot"),
            &[("mass", mass), ("x", 0.1), ("y", 0.2), ("z", 0.3)],
        )
    };
    assert!(inertial_error(&experiment, &payload(1e-6)) < 1e-6);
    assert!(inertial_error(&experiment, &payload(1.0)) < 0.1);
}

/// A table of postures, made from the model's centre of mass by plain statics.
struct Made<'a> {
    /// Added to every logged joint angle of this joint.
    offset: (usize, f64),
    /// Axes of the right sole in the world, from the corner forces on it.
    sole: &'a dyn Fn(&[f64]) -> Matrix3<f64>,
    /// What a corner (foot, corner) reports.
    report: &'a dyn Fn(usize, usize, f64) -> f64,
}

const CORNERS: [(&str, f64, f64); 4] = [
    ("front_left", 0.15, 0.06),
    ("front_right", 0.15, -0.06),
    ("rear_left", -0.09, 0.06),
    ("rear_right", -0.09, -0.06),
];

fn call(name: &str, q: &[f64], size: usize) -> Vec<f64> {
    let mut out = vec![0.0; size];
    Tulip
        .evaluate(Model::<f64>::function(&Tulip, name).unwrap(), &State::new().with(Argument::Q, q), &mut out)
        .unwrap();
    out
}

impl Made<'_> {
    fn text(&self) -> String {
        let joints: Vec<&str> = (0..12).map(|j| Model::<f64>::joint_name(&Tulip, j).unwrap()).collect();
        let mut names: Vec<String> = vec!["posture".into()];
        names.extend(joints.iter().map(|j| format!("{j}/position")));
        names.extend(["cop/x".into(), "cop/y".into()]);
        for foot in ["right_foot", "left_foot"] {
            names.extend(CORNERS.map(|(corner, ..)| format!("{foot}/{corner}/force/z")));
        }
        let mut text = names.join(",") + "\n";
        for i in 0..20 {
            let mut q = vec![0.0; 19];
            q[6] = 1.0;
            (0..12).for_each(|j| q[7 + j] = 0.15 * (1.3 * (12 * i + j) as f64 + 0.7).sin());
            let (forces, places) = self.stand(&q);
            let reported: Vec<f64> =
                forces.iter().enumerate().map(|(k, f)| (self.report)(k / 4, k % 4, *f)).collect();
            let total: f64 = reported.iter().sum();
            let center: Vector3<f64> =
                reported.iter().zip(&places).map(|(f, p)| p * *f).sum::<Vector3<f64>>() / total;
            let mut logged = q[7..].to_vec();
            logged[self.offset.0] += self.offset.1;
            let numbers = logged.iter().chain([&center.x, &center.y]).chain(&reported);
            text += &format!("{i},{}\n", numbers.map(|x| format!("{x:e}")).collect::<Vec<_>>().join(","));
        }
        text
    }

    /// Corner forces of both feet, and where they act in the right sole's frame.
    fn stand(&self, q: &[f64]) -> (Vec<f64>, Vec<Vector3<f64>>) {
        let pose = |foot: &str| {
            let rotation = Matrix3::from_column_slice(&call(&format!("rotation_of_{foot}"), q, 9));
            (rotation, Vector3::from_vec(call(&format!("position_of_{foot}"), q, 3)))
        };
        let (right, at) = pose("right_foot");
        let into = |x: Vector3<f64>| right.transpose() * (x - at) + Vector3::new(0.0, 0.0, 0.055);
        let mut places = Vec::new();
        for foot in ["right_foot", "left_foot"] {
            let (rotation, origin) = pose(foot);
            places.extend(CORNERS.map(|(_, x, y)| into(origin + rotation * Vector3::new(x, y, -0.055))));
        }
        let center = into(Vector3::from_vec(call("center_of_mass", q, 3)));
        let mut forces = vec![19.0 * 9.81 / 8.0; 8];
        // The sole's axes may depend on the forces: repeated until both agree.
        for _ in 0..200 {
            let down = (self.sole)(&forces).transpose() * Vector3::new(0.0, 0.0, -9.81);
            let foot = center - down * (center.z / down.z);
            let weight = -19.0 * down.z;
            // Smallest forces with this sum and these moments.
            let grasp = SMatrix::<f64, 3, 8>::from_fn(|r, c| if r == 2 { 1.0 } else { places[c][r] });
            let wanted = Vector3::new(foot.x, foot.y, 1.0) * weight;
            let inverse = (grasp * grasp.transpose()).try_inverse().unwrap();
            forces = (grasp.transpose() * inverse * wanted).as_slice().to_vec();
        }
        (forces, places)
    }
}

fn level(_: &[f64]) -> Matrix3<f64> {
    Matrix3::identity()
}

fn plain<'a>() -> Made<'a> {
    Made { offset: (0, 0.0), sole: &level, report: &|_, _, f| f }
}

fn left_by(made: &Made<'_>, effects: &[Effect]) -> [f64; 2] {
    let subjects = Subjects::named("tulip");
    let source = Box::new(Cursor::new(made.text().into_bytes()));
    let reader = Reader::from_source(Path::new("made.csv"), source, &Mapping::default()).unwrap();
    let experiment = PostureExperiment::from_reader(subjects.robot(&Tulip, &[]), reader, None).unwrap();
    // In parts of 1 N and 1 mm.
    let error =
        |effects: &[Effect]| rms(&experiment, &[0, 1], effects).max(1e-3 * rms(&experiment, &[2], effects));
    let found = [error(&[]), error(effects)];
    println!(
        "{}: {:e} to {:e} m",
        effects.iter().map(|e| e.to_string()).collect::<Vec<_>>().join(", "),
        found[0],
        found[1]
    );
    found
}

#[test]
fn responses_are_those_of_plain_statics() {
    let check = |made: Made<'_>, effect: Effect| {
        let [before, after] = left_by(&made, &[effect]);
        assert!(after < 1e-10 && before > 1e-4, "{before} to {after}");
    };
    assert!(left_by(&plain(), &[])[0] < 1e-12);
    let turn = |roll: f64, pitch: f64| {
        (Rotation3::new(Vector3::y() * pitch) * Rotation3::new(Vector3::x() * roll)).into_inner()
    };
    for kind in [&kinds::GROUND_SLOPE, &kinds::GRAVITY_TILT] {
        let slope = Effect::new(kind, Location::default(), &[("roll", 0.05), ("pitch", -0.08)]);
        check(Made { sole: &|_| turn(0.05, -0.08), ..plain() }, slope);
    }
    let ankle = (0..12).find(|j| Model::<f64>::joint_name(&Tulip, *j) == Some("right_ankle_pitch")).unwrap();
    let offset =
        Effect::new(&kinds::ENCODER_OFFSET, Location::joint("right_ankle_pitch"), &[("offset", 0.02)]);
    check(Made { offset: (ankle, 0.02), ..plain() }, offset);
    let corner = || Location::sensor("left_foot/front_right");
    let gain = Effect::new(&kinds::FORCE_SENSOR_GAIN, corner(), &[("gain", 1.2)]);
    check(Made { report: &|foot, k, f| if (foot, k) == (1, 1) { 1.2 * f } else { f }, ..plain() }, gain);
    let bias = Effect::new(&kinds::FORCE_SENSOR_BIAS, corner(), &[("z", 4.0)]);
    check(Made { report: &|foot, k, f| if (foot, k) == (1, 1) { f + 4.0 } else { f }, ..plain() }, bias);
    let clip = Effect::new(&kinds::FORCE_SENSOR_SATURATION, corner(), &[("limit", 22.0)]);
    check(Made { report: &|foot, k, f| if (foot, k) == (1, 1) { f.min(22.0) } else { f }, ..plain() }, clip);
}

#[test]
fn corners_that_sink() {
    let stiffness = 2000.0;
    let sunk = |forces: &[f64]| {
        // Mean sinking of the corners in front minus that of those behind, and left minus right.
        let sink = |ks: [usize; 2]| ks.iter().map(|k| -forces[*k] / stiffness).sum::<f64>() / 2.0;
        let (ahead, aside) = ((sink([0, 1]) - sink([2, 3])) / 0.24, (sink([0, 2]) - sink([1, 3])) / 0.12);
        let normal = Vector3::new(-ahead, -aside, 1.0).normalize();
        let x = Vector3::new(1.0, 0.0, ahead).normalize();
        Matrix3::from_columns(&[x, normal.cross(&x), normal])
    };
    let effect = Effect::new(
        &kinds::GROUND_COMPLIANCE,
        Location::default(),
        &[("stiffness", stiffness), ("damping", 0.0)],
    );
    let [before, after] = left_by(&Made { sole: &sunk, ..plain() }, &[effect]);
    assert!(after < 1e-9 && before > 1e-4, "{before} to {after}");
}
