//! Impacts as an experiment: known figures of the example, and every effect against an independent computation.
use crate::experiments::support::measured::{Subjects, example, inertial_error, rms};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::impacts::ImpactExperiment;
use bipedc_analysis::log::{Log, Mapping, Reader};
use bipedc_effects::effect::{Effect, Location, kinds};
use bipedc_runtime::nalgebra::{DMatrix, DVector};
use bipedc_runtime::{Argument, Model, State};
use five_link::FiveLink;
use std::io::Cursor;
use std::path::Path;

fn read<'a>(subjects: &'a Subjects, file: &str) -> ImpactExperiment<'a> {
    let log = Log::open(example("impacts").join(file)).unwrap();
    ImpactExperiment::read(subjects.robot(&FiveLink, &[]), &log, None).unwrap()
}

fn restitution(coefficient: f64) -> Effect {
    Effect::new(&kinds::IMPACT_RESTITUTION, Location::default(), &[("coefficient", coefficient)])
}

fn slip(friction: f64) -> Effect {
    Effect::new(&kinds::FOOT_SLIP, Location::default(), &[("friction", friction)])
}

fn spin(radius: f64) -> Effect {
    Effect::new(&kinds::SPIN_FRICTION, Location::default(), &[("radius", radius)])
}

fn all(experiment: &dyn Experiment) -> Vec<usize> {
    (0..experiment.rows().len()).collect()
}

#[test]
fn the_example_has_its_known_figures() {
    let subjects = Subjects::named("five_link");
    let experiment = read(&subjects, "validation.csv.gz");
    let rows = all(&experiment);
    assert_eq!(rows.len(), 7);
    let found = [rms(&experiment, &rows, &[]), rms(&experiment, &rows, &[restitution(0.22)])];
    println!("nominal {}, oracle {}; {}", found[0], found[1], experiment.assumptions.join("; "));
    let mut sum = 0.0;
    for row in experiment.rows() {
        println!("  {}: noise {:e} {}", row.name, row.noise, row.unit);
        sum += row.noise * row.noise / 7.0;
    }
    assert!((found[0] / 0.373389 - 1.0).abs() < 1e-5, "{found:?}");
    assert!((found[1] / 0.006966 - 1.0).abs() < 1e-3, "{found:?}");
    let noise = sum.sqrt();
    assert!(
        noise > 0.7 * found[1] && noise < 1.4 * found[1],
        "noise {noise}, error of the true model {}",
        found[1]
    );
    assert!(experiment.response(&[]).is_empty());
    assert!(experiment.response(&[restitution(0.0)]).is_empty(), "neutral");
}

/// Impacts of known laws, computed with the model's own mass matrix, jacobian of the point and plain algebra.
fn made(friction: f64, bounce: f64, rotor: f64) -> String {
    let model = FiveLink;
    let call = |name: &str, q: &[f64], size: usize| {
        let mut out = vec![0.0; size];
        let state = State::new().with(Argument::Q, q);
        model.evaluate(Model::<f64>::function(&model, name).unwrap(), &state, &mut out).unwrap();
        out
    };
    let joints: Vec<String> =
        (0..4).map(|j| Model::<f64>::joint_name(&model, j).unwrap().to_owned()).collect();
    let mut names = vec!["base/position/x".into(), "base/position/z".into(), "base/orientation/pitch".into()];
    names.extend(joints.iter().map(|j| format!("{j}/position")));
    let base =
        ["base/linear_velocity/x", "base/linear_velocity/z", "base/angular_velocity/y"].map(str::to_owned);
    let speeds: Vec<String> =
        base.into_iter().chain(joints.iter().map(|j| format!("{j}/velocity"))).collect();
    names.extend(speeds.iter().map(|s| format!("{s}/before")));
    names.extend(speeds.iter().map(|s| format!("{s}/after")));
    let mut text = format!("impact,{}\n", names.join(","));
    for i in 0..12 {
        let wave = |k: usize, size: f64| size * (1.7 * (i * 7 + k) as f64 + 0.3).sin();
        let q: Vec<f64> = (0..7).map(|k| wave(k, 0.5)).collect();
        let mut before: Vec<f64> = (0..7).map(|k| wave(k + 31, 0.8)).collect();
        before[1] -= 1.5;
        let mut mass = DMatrix::from_vec(7, 7, call("mass_matrix", &q, 49));
        mass[(4, 4)] += rotor;
        let six = DMatrix::from_vec(6, 7, call("jacobian_of_right_foot_point_foot", &q, 42));
        let (tangent, normal) = (six.row(0).transpose(), six.row(2).transpose());
        let inverse = mass.try_inverse().unwrap();
        let v = DVector::from_vec(before.clone());
        let yields = |a: &DVector<f64>, b: &DVector<f64>| (a.transpose() * &inverse * b)[0];
        let (vt, vn) = (tangent.dot(&v), normal.dot(&v));
        let (tt, tn, nn) = (yields(&tangent, &tangent), yields(&tangent, &normal), yields(&normal, &normal));
        let goal = -(1.0 + bounce) * vn;
        let det = tt * nn - tn * tn;
        let (mut lt, mut ln) = ((-vt * nn - goal * tn) / det, (goal * tt + vt * tn) / det);
        if lt.abs() > friction * ln {
            ln = goal / (nn + lt.signum() * friction * tn);
            lt = lt.signum() * friction * ln;
        }
        let after = v + &inverse * (tangent * lt + normal * ln);
        let numbers = q.iter().chain(&before).chain(after.iter()).map(|x| format!("{x:e}"));
        text += &format!("{i},{}\n", numbers.collect::<Vec<_>>().join(","));
    }
    text
}

#[test]
fn responses_are_those_of_an_independent_impact() {
    let subjects = Subjects::named("five_link");
    let knee = Effect::new(&kinds::ROTOR_INERTIA, Location::joint("right_knee_pitch"), &[("inertia", 0.3)]);
    assert_eq!(Model::<f64>::joint_name(&FiveLink, 1), Some("right_knee_pitch"));
    for (law, effects) in [
        ((f64::INFINITY, 0.0, 0.0), vec![]),
        ((f64::INFINITY, 0.4, 0.0), vec![restitution(0.4)]),
        ((0.2, 0.0, 0.0), vec![slip(0.2)]),
        ((0.3, 0.25, 0.0), vec![slip(0.3), restitution(0.25)]),
        ((f64::INFINITY, 0.0, 0.3), vec![knee]),
    ] {
        let source = Box::new(Cursor::new(made(law.0, law.1, law.2).into_bytes()));
        let reader = Reader::from_source(Path::new("made.csv"), source, &Mapping::default()).unwrap();
        let experiment = ImpactExperiment::from_reader(subjects.robot(&FiveLink, &[]), reader, None).unwrap();
        let rows = all(&experiment);
        let left = rms(&experiment, &rows, &effects);
        let before = rms(&experiment, &rows, &[]);
        println!("{effects:?}: {before} to {left}");
        assert!(left < 1e-12, "{effects:?}: {left}");
        assert!(effects.is_empty() || before > 1e-3);
    }
}

#[test]
fn derivatives_by_inertial_parameters_are_those_of_the_response() {
    let subjects = Subjects::named("five_link");
    let experiment = read(&subjects, "validation.csv.gz");
    for effect in [
        Effect::new(&kinds::COM_OFFSET, Location::link("torso"), &[("x", 1e-6), ("z", 2e-6)]),
        Effect::new(
            &kinds::PAYLOAD,
            Location::link("left_tibia"),
            &[("mass", 1e-6), ("x", 0.1), ("z", -0.2)],
        ),
        Effect::new(&kinds::INERTIA_ERROR, Location::link("right_femur"), &[("iyy", 1e-6)]),
    ] {
        let error = inertial_error(&experiment, &effect);
        assert!(error < 1e-5, "{effect:?}: {error}");
    }
}

#[test]
fn no_impact_leaves_the_whole_jump() {
    let subjects = Subjects::named("five_link");
    let experiment = read(&subjects, "validation.csv.gz");
    let rows = all(&experiment);
    let without = rms(&experiment, &rows, &[Effect::new(&kinds::NO_IMPACT, Location::default(), &[])]);
    println!("without impacts {without}");
    assert!(without > rms(&experiment, &rows, &[]));
}

/// Impacts of a foot with a sole in three dimensions: what any law of contact must obey.
#[test]
fn a_flat_foot_in_space_obeys_the_laws_of_contact() {
    use bipedc_runtime::nalgebra::{Matrix3, UnitQuaternion, Vector3};
    let subjects = Subjects::named("tulip");
    let joints: Vec<String> = subjects.layout.joints.iter().map(|j| j.name.clone()).collect();
    let mut names: Vec<String> =
        ["position/x", "position/y", "position/z"].map(|n| format!("base/{n}")).to_vec();
    names.extend(["x", "y", "z", "w"].map(|a| format!("base/orientation/{a}")));
    names.extend(joints.iter().map(|j| format!("{j}/position")));
    let mut speeds: Vec<String> = Vec::new();
    for kind in ["linear", "angular"] {
        speeds.extend(["x", "y", "z"].map(|a| format!("base/{kind}_velocity/{a}")));
    }
    speeds.extend(joints.iter().map(|j| format!("{j}/velocity")));
    names.extend(
        ["before", "after"].iter().flat_map(|when| speeds.iter().map(move |s| format!("{s}/{when}"))),
    );
    let mut text = format!("impact,{}\n", names.join(","));
    let mut states = Vec::new();
    for i in 0..6 {
        let wave = |k: usize, size: f64| size * (1.7 * (i * 41 + k) as f64 + 0.3).sin();
        let turn = UnitQuaternion::from_euler_angles(wave(1, 0.2), wave(2, 0.2), wave(3, 1.0));
        let mut q = vec![0.1, 0.2, 0.7];
        q.extend(turn.coords.iter());
        q.extend((0..12).map(|j| wave(j + 4, 0.3)));
        let mut logged: Vec<f64> = (0..18).map(|k| wave(k + 20, 0.2)).collect();
        logged[0] += 1.0;
        logged[2] -= 1.5;
        // Velocities after are logged as zero: the residual is minus the prediction.
        let numbers = q.iter().chain(&logged).chain(&[0.0; 18]).map(|x| format!("{x:e}"));
        text += &format!("{i},{}\n", numbers.collect::<Vec<_>>().join(","));
        states.push((q, logged, turn));
    }
    let call = |name: &str, q: &[f64], size: usize| {
        let mut out = vec![0.0; size];
        let state = State::new().with(Argument::Q, q);
        tulip::Tulip
            .evaluate(Model::<f64>::function(&tulip::Tulip, name).unwrap(), &state, &mut out)
            .unwrap();
        out
    };
    let source = Box::new(Cursor::new(text.into_bytes()));
    let reader = Reader::from_source(Path::new("made.csv"), source, &Mapping::default()).unwrap();
    let experiment = ImpactExperiment::from_reader(subjects.robot(&tulip::Tulip, &[]), reader, None).unwrap();
    let (mut slid, mut turned) = (0, 0);
    for effects in [
        vec![],
        vec![restitution(0.3)],
        vec![slip(0.3)],
        vec![slip(0.25), restitution(0.2)],
        vec![spin(0.004)],
        vec![spin(0.02), slip(0.3), restitution(0.1)],
    ] {
        let value =
            |kind: &str, name: &str| effects.iter().find(|e| e.kind.name == kind).map(|e| e.value(name));
        let bounce = value("impact_restitution", "coefficient").unwrap_or(0.0);
        let friction = value("foot_slip", "friction").unwrap_or(0.0);
        let radius =
            value("spin_friction", "radius").map(|r| r * if friction > 0.0 { friction } else { 1.0 });
        let response = experiment.response(&effects);
        for (i, (q, logged, turn)) in states.iter().enumerate() {
            let explained = |row: usize| response.iter().find(|(r, _)| *r == row).map_or(0.0, |(_, v)| v[i]);
            let after: Vec<f64> = (0..18).map(|row| explained(row) - experiment.residual(row)[i]).collect();
            let model = |v: &[f64]| {
                let body = turn.inverse() * Vector3::new(v[0], v[1], v[2]);
                DVector::from_iterator(18, body.iter().copied().chain(v[3..].iter().copied()))
            };
            let (before, after) = (model(logged), model(&after));
            let six = DMatrix::from_vec(6, 18, call("jacobian_of_right_foot", q, 108));
            let rotation = Matrix3::from_column_slice(&call("rotation_of_right_foot", q, 9));
            let below = rotation * Vector3::new(0.03, 0.0, -0.055);
            // Twist of the middle of the sole: v + ω × r.
            let twist = |v: &DVector<f64>| {
                let t = &six * v;
                let omega = Vector3::new(t[3], t[4], t[5]);
                (Vector3::new(t[0], t[1], t[2]) + omega.cross(&below), omega)
            };
            let ((v0, w0), (v1, w1)) = (twist(&before), twist(&after));
            assert!((v1.z + bounce * v0.z).abs() < 1e-9, "the sole bounces: {} after {}", v1.z, v0.z);
            assert!((w1.xy() + w0.xy() * bounce).norm() < 1e-9, "{w1} after {w0}");
            // The impulse is a wrench on the foot and nothing else.
            let mass = DMatrix::from_vec(18, 18, call("mass_matrix", q, 324));
            let push = mass * (&after - &before);
            let wrench = six.transpose().svd(true, true).solve(&push, 1e-10).unwrap();
            assert!((six.transpose() * &wrench - &push).norm() < 1e-8 * push.norm());
            let (tangential, normal) = (wrench.rows(0, 2).norm(), wrench[2]);
            let (force, moment) = (Vector3::new(wrench[0], wrench[1], normal), wrench.fixed_rows::<3>(3));
            let about = moment[2] - below.cross(&force).z;
            if w1.z.abs() > 1e-9 {
                turned += 1;
                let limit = radius.expect("only with this effect") * normal;
                assert!((about.abs() - limit).abs() < 1e-8 * normal, "turning: {about} {limit}");
                assert!(about * w1.z < 0.0, "against the turning");
            } else {
                assert!(radius.is_none_or(|radius| about.abs() <= radius * normal * (1.0 + 1e-9)));
            }
            let slide = v1.xy();
            if slide.norm() > 1e-9 {
                slid += 1;
                assert!(
                    (tangential - friction * normal).abs() < 1e-8 * normal,
                    "Coulomb: {tangential} {normal}"
                );
                let against = wrench[0] * slide.x + wrench[1] * slide.y;
                assert!((against + tangential * slide.norm()).abs() < 1e-7 * normal, "against the sliding");
            } else {
                assert!(friction == 0.0 || tangential <= friction * normal * (1.0 + 1e-9));
            }
        }
    }
    assert!(slid >= 3 && turned >= 3, "only {slid} of them slide, {turned} turn");
}
