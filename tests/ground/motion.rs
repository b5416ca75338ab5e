//! A robot in motion on one foot: its mass and moments from encoders, vertical force and centre of pressure.
use crate::ground::cli::{bipedc, scratch, text};
use crate::ground::stood::{Noise, model, other, rooted, tulip};
use bipedc::identification::standing::Root;
use bipedc_compiler::exact::Model;
use bipedc_runtime::{Argument, State};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A log of TUlip on its right foot; `columns` says which of cop, wrench or corners is logged.
fn log(folder: &Path, name: &str, seed: u64, columns: &str) -> PathBuf {
    let rooted = rooted(&other(&tulip()), Root::Sole);
    let model = model(&rooted, &["inverse_dynamics"]);
    let model: &dyn bipedc_runtime::Model<f64> = &model;
    let mut noise = Noise(seed);
    let joints: Vec<&str> = rooted.tree.joints.iter().map(|j| j.name.as_str()).collect();
    let waves: Vec<Vec<[f64; 3]>> = joints
        .iter()
        .map(|name| {
            let size = if name.starts_with("right") { 0.04 } else { 0.12 };
            (0..3)
                .map(|k| {
                    [
                        size * (0.7 + 0.3 * noise.even()),
                        TAU * (0.15 + 0.25 * f64::from(k) + 0.1 * noise.even()),
                        3.0 * noise.even(),
                    ]
                })
                .collect()
        })
        .collect();
    let mut out = String::from("time");
    joints.iter().for_each(|j| _ = write!(out, ",{j}/position"));
    out.push_str(match columns {
        "cop" => ",right_foot/force/z,right_foot/cop/x,right_foot/cop/y",
        "wrench" => ",right_foot/force/x,right_foot/force/y,right_foot/force/z,right_foot/torque/x,right_foot/torque/y,right_foot/torque/z",
        _ => "",
    });
    for i in 0..2000 {
        let t = 0.01 * f64::from(i);
        let at = |order: usize| -> Vec<f64> {
            let wave = |[a, w, p]: &[f64; 3]| {
                a * [(w * t + p).sin(), w * (w * t + p).cos(), -w * w * (w * t + p).sin()][order]
            };
            waves.iter().map(|own| own.iter().map(wave).sum::<f64>()).collect()
        };
        let rest = [0.0; 6];
        let q = [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &at(0)].concat();
        let (v, a) = ([&rest[..], &at(1)].concat(), [&rest[..], &at(2)].concat());
        let mut tau = vec![0.0; 18];
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
        model.evaluate(model.function("inverse_dynamics").unwrap(), &state, &mut tau).unwrap();
        let _ = write!(out, "\n{t}");
        q[7..].iter().for_each(|q| _ = write!(out, ",{q}"));
        // The root is the sole's corner at (0.15, 0.06).
        let [fx, fy, fz, mx, my, mz] = [0, 1, 2, 3, 4, 5].map(|k: usize| tau[k]);
        match columns {
            "cop" => _ = write!(out, ",{fz},{},{}", 0.15 - my / fz, 0.06 + mx / fz),
            "wrench" => {
                let about = [mx + 0.06 * fz, my - 0.15 * fz, mz + 0.15 * fy - 0.06 * fx];
                let _ = write!(out, ",{fx},{fy},{fz},{},{},{}", about[0], about[1], about[2]);
            }
            _ => {}
        }
    }
    let path = folder.join(name);
    std::fs::write(&path, out + "\n").unwrap();
    path
}

#[test]
#[ignore = "takes long"]
fn a_log_on_one_foot_tells_mass_and_moments() {
    let folder = scratch("zmp");
    let (train, judge) = (log(&folder, "train.csv", 3, "cop"), log(&folder, "judge.csv", 5, "cop"));
    let run = bipedc(&[
        "identify",
        "robots/tulip",
        text(&train),
        "--method",
        "zmp",
        "--validate",
        text(&judge),
        "--json",
    ]);
    let answer = run.ok().json();
    let base = rooted(&tulip(), Root::Sole).base(Model::ZeroMomentPoint, &["Fz", "Mx", "My"], false).unwrap();
    assert_eq!(base.sums.len(), 85);
    let seen = answer["parameters"].as_array().unwrap().len() + answer["unseen"].as_array().unwrap().len();
    assert_eq!(seen, 85);
    let truth: f64 = rooted(&other(&tulip()), Root::Sole).link_inertias.parameters().iter().step_by(10).sum();
    let mass = answer["ground"]["mass"]["value"].as_f64().unwrap();
    println!("mass {mass} instead of {truth}; {}", answer["validation"]["total"]);
    assert!((mass - truth).abs() < 1e-3);
    assert!((answer["ground"]["mass"]["described"].as_f64().unwrap() - truth).abs() > 0.1);
    let total = |model: &str| answer["validation"]["total"][model].as_f64().unwrap();
    assert!(total("least_squares") < 0.05 * total("description"), "{}", answer["validation"]["total"]);
    let assumed = answer["assumptions"].to_string();
    assert!(assumed.contains("right_foot") && assumed.contains("stays level"), "{assumed}");
}

#[test]
#[ignore = "takes long"]
fn six_components_of_the_wrench() {
    let folder = scratch("zmp_wrench");
    let train = log(&folder, "train.csv", 3, "wrench");
    let answer = bipedc(&["identify", "robots/tulip", text(&train), "--method", "zmp", "--json"]).ok().json();
    let channels = answer["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 6);
    for channel in channels {
        let [described, fitted] = ["description", "least_squares"].map(|k| channel[k].as_f64().unwrap());
        assert!(fitted < 0.2 * described, "{channel}");
    }
}

#[test]
fn logs_that_do_not_tell() {
    let folder = scratch("zmp_misuse");
    let none = log(&folder, "none.csv", 3, "");
    let zmp = |path: &Path, more: &[&str]| {
        bipedc(&[&["identify", "robots/tulip", text(path), "--method", "zmp"][..], more].concat())
    };
    zmp(&none, &[]).fails_with(&["no foot has forces", "<foot>/force/z"]);
    let train = log(&folder, "train.csv", 3, "cop");
    zmp(&train, &["--stance", "left_foot"]).fails_with(&["left_foot", "no forces"]);
    let table = std::fs::read_to_string(&train).unwrap();
    let flipped = folder.join("flipped.csv");
    std::fs::write(&flipped, table.replace("right_foot/force/z", "right_foot/force/w")).unwrap();
    zmp(&flipped, &[]).fails_with(&["no foot has forces"]);
}
