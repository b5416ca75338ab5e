//! Static postures: identities, noise-free recovery, and the example whose truth is stated.
use crate::ground::cli::{bipedc, scratch, text};
use crate::ground::stood::{Noise, call, model, other, rooted, standing, tulip, write_postures};
use crate::ground::support::measured::{Subjects, example};
use bipedc::identification::standing::Root;
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::identify::cop::{PostureTable, least_squares, simplified};
use bipedc_analysis::log::Log;
use bipedc_compiler::exact::Model;
use bipedc_runtime::nalgebra::DVector;
use serde_json::Value;
use tulip::Tulip;

/// The regression times the base parameters is the moment of the weight, computed from centres of mass alone.
#[test]
fn base_regressor_times_parameters_is_the_moment() {
    let (rooted, hidden) = (rooted(&tulip(), Root::Link), rooted(&other(&tulip()), Root::Link));
    let base = rooted.base(Model::CenterOfMass, &["x", "y"], false).unwrap();
    assert_eq!(base.sums.len(), 26);
    let (own, truth) = (model(&rooted, &["center_of_mass_regressor"]), model(&hidden, &["center_of_mass"]));
    let standing = standing(&rooted, &own, &base);
    let parameters = hidden.link_inertias.parameters();
    let (beta, mass) = (base.values(&parameters), parameters.iter().step_by(10).sum::<f64>());
    let mut noise = Noise(3);
    for _ in 0..20 {
        let q: Vec<f64> = (0..12).map(|_| 0.8 * noise.even()).collect();
        let bodies = standing.bodies(&q);
        let center = call(&truth, "center_of_mass", &q);
        for (axis, center) in center.iter().enumerate().take(2) {
            let sum: f64 = standing
                .parts
                .columns
                .iter()
                .zip(&beta)
                .map(|(k, b)| standing.column(&bodies, *k)[axis] * b)
                .sum();
            assert!((sum - mass * center).abs() < 1e-12 * mass, "{sum} {}", mass * center);
        }
        let (own, _) = standing.center(&bodies, &parameters);
        // The world of `StanceModel` begins at the sole, that of the model at the foot's frame.
        assert!((own.x - center[0]).abs() < 1e-13 && (own.z - 0.055 - center[2]).abs() < 1e-13);
    }
}

/// Derivatives of everything that the design of postures uses, against differences.
#[test]
fn derivatives_of_a_standing_robot() {
    let rooted = rooted(&tulip(), Root::Link);
    let base = rooted.base(Model::CenterOfMass, &["x", "y"], true).unwrap();
    assert_eq!(base.sums.len(), 25);
    let model = model(&rooted, &["center_of_mass_regressor"]);
    let standing = standing(&rooted, &model, &base);
    let mut noise = Noise(9);
    let q: Vec<f64> = (0..12).map(|_| 0.6 * noise.even()).collect();
    let bodies = standing.bodies(&q);
    let (_, rates) = standing.center(&bodies, &standing.parts.parameters);
    let jacobian = standing.jacobian(&bodies, &standing.parts.soles[1].place);
    for joint in 0..12 {
        let at = |step: f64| {
            let mut q = q.clone();
            q[joint] += step;
            standing.bodies(&q)
        };
        let (up, down) = (at(1e-6), at(-1e-6));
        let center = |b| standing.center(b, &standing.parts.parameters).0;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-8, "joint {joint}: {a} {b}");
        let numeric = (center(&up) - center(&down)) / 2e-6;
        (0..3).for_each(|k| close(numeric[k], rates[joint][k]));
        for k in &standing.parts.columns {
            let numeric = (standing.column(&up, *k) - standing.column(&down, *k)) / 2e-6;
            let rate = standing.column_rate(&bodies, *k, joint);
            (0..3).for_each(|axis| close(numeric[axis], rate[axis]));
        }
        let frame =
            |b: &bipedc_analysis::identify::excite::postures::Bodies| b.frame(&standing.parts.soles[1].place);
        let ((p, r), (p_up, r_up), (p_down, r_down)) = (frame(&bodies), frame(&up), frame(&down));
        let _ = p;
        let numeric = (p_up - p_down) / 2e-6;
        (0..3).for_each(|k| close(numeric[k], jacobian[(k, joint)]));
        let spin = (r_up - r_down) / 2e-6 * r.transpose();
        let spin = [spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]];
        (0..3).for_each(|k| close(spin[k], jacobian[(3 + k, joint)]));
    }
}

/// Positions of the example with centres of pressure of another robot: its base parameters come back.
#[test]
fn noise_free_postures_give_the_parameters_back() {
    let subjects = Subjects::named("tulip");
    let log = Log::open(example("postures").join("train.csv.gz")).unwrap();
    let read = |robot| PostureExperiment::read(robot, &log, None).unwrap();
    let experiment = read(subjects.robot(&Tulip, &[]));
    let rooted = rooted(&tulip(), Root::Link);
    let base = rooted.base(Model::CenterOfMass, &["x", "y"], false).unwrap();
    // The bodies of TUlip rooted at its torso, by name.
    let hidden = {
        let mut subjects = Subjects::of(&other(&tulip()));
        subjects.feet = Subjects::named("tulip").feet;
        subjects.link_inertias.parameters()
    };
    let mass: f64 = hidden.iter().step_by(10).sum();
    let mut moments = experiment.moments(mass);
    let width = hidden.len();
    for axis in 0..2 {
        let exact = |row: &[f64]| row.iter().zip(&hidden).map(|(a, b)| a * b).sum();
        moments.measured[axis] = moments.columns[axis].chunks_exact(width).map(exact).collect();
    }
    let table = PostureTable::of_moments(moments, experiment.inertial_parameters(), experiment.bodies());
    // Sums over bodies of the standing robot, as sums over those of the robot that hangs from its torso.
    let order = |k: usize| {
        let name = &rooted.link_inertias.bodies[k / 10];
        10 * experiment.bodies().iter().position(|body| body == name).unwrap() + k % 10
    };
    let mut own = base.clone();
    own.sums.iter_mut().flatten().for_each(|(k, _)| *k = order(*k));
    let (w, y) = table.regression(&own);
    let truth = own.values(&hidden);
    let found = least_squares(&w, &y, &vec![0.0; own.sums.len()]);
    let left = &y - &w * DVector::from_column_slice(&truth);
    assert!(left.amax() < 1e-9 * y.amax(), "base parameters explain all moments: {}", left.amax());
    for (k, name) in own.names.iter().enumerate() {
        // Encoders count in steps: the swing foot tilts by 1e-4 rad, which tells its height badly.
        if !name.starts_with("left_foot.m*cz") {
            assert!((found[k] - truth[k]).abs() < 1e-9, "{name}: {} {}", found[k], truth[k]);
        }
    }
}

fn number(value: &Value, path: &[&str]) -> f64 {
    let found = path.iter().fold(value, |value, key| match key.parse::<usize>() {
        Ok(index) => &value[index],
        Err(_) => &value[*key],
    });
    found.as_f64().unwrap_or_else(|| panic!("{path:?} is {found}"))
}

/// `truth.json` of the example: the torso's centre lies 18 mm further back and 9 mm further left; 10.2 kg.
#[test]
#[ignore = "takes long"]
fn the_example_gives_its_truth_back() {
    let folder = example("postures");
    let (train, judge) = (folder.join("train.csv.gz"), folder.join("validation.csv.gz"));
    let urdf = scratch("cop").join("new.urdf");
    let run = bipedc(&[
        "identify",
        "robots/tulip",
        text(&train),
        "--method",
        "cop",
        "--validate",
        text(&judge),
        "--json",
        "--write-urdf",
        text(&urdf),
    ]);
    let answer = run.ok().json();
    assert_eq!(answer["parameters"].as_array().unwrap().len(), 25);
    assert_eq!(answer["ground"]["stance"], "right_foot");
    for (first, change) in [("torso.m*cx", -0.018 * 10.2), ("torso.m*cy", 0.009 * 10.2)] {
        let all = answer["parameters"].as_array().unwrap();
        let found: Vec<&Value> = all.iter().filter(|p| p["name"].as_str().unwrap().contains(first)).collect();
        assert_eq!(found.len(), 1, "{first}");
        let [value, nominal, error] =
            ["value", "nominal", "standard_error"].map(|key| number(found[0], &[key]));
        println!("{first}: {:.4} ± {error:.4} instead of {change:.4} kg m", value - nominal);
        assert!(
            (value - nominal - change).abs() < 3.0 * error && error < 0.02,
            "{first}: {}",
            value - nominal
        );
    }
    let mass = number(&answer, &["ground", "mass", "value"]);
    assert!((mass - 19.0).abs() < 0.01, "{mass}");
    let models = answer["ground"]["models"].as_array().unwrap();
    let rms = |model: &str, data: &str| {
        let model = models.iter().find(|m| m["model"] == model).unwrap();
        number(model, &[data, "rms"])
    };
    // 0.31 mm is what noise leaves of the true model on these postures.
    println!(
        "validation, m: {:?}",
        ["description", "full", "simplified", "physical"].map(|m| rms(m, "validation"))
    );
    assert!((rms("description", "validation") / 0.0075647 - 1.0).abs() < 0.01);
    assert!(rms("full", "validation") < 1.3 * 0.0003098 && rms("physical", "validation") < 1.3 * 0.0003098);
    assert!(rms("full", "training") <= rms("full", "held_out"));
    assert!(rms("simplified", "validation") < 0.0005);
    assert_eq!(answer["physical"]["consistent"], true);
    assert!(urdf.exists());
}

/// The thesis' simplified model has 13 parameters (table 8.3), and zero first moments where it says so.
#[test]
fn the_simplified_model_of_the_thesis() {
    let rooted = rooted(&tulip(), Root::Link);
    let full = rooted.base(Model::CenterOfMass, &["x", "y"], true).unwrap();
    let names: Vec<String> = (0..10 * rooted.link_inertias.bodies.len()).map(|k| k.to_string()).collect();
    let zeros = rooted.zeros().unwrap();
    let smaller = simplified(&full, &names, &|k| zeros.contains(&k));
    println!("{} parameters: {:?}", smaller.sums.len(), smaller.names);
    assert_eq!(smaller.sums.len(), 13, "as many as in table 8.3");
    let train = example("postures").join("train.csv.gz");
    let run = bipedc(&["identify", "robots/tulip", text(&train), "--method", "cop", "--symmetric", "--json"]);
    let answer = run.ok().json();
    assert_eq!(answer["parameters"].as_array().unwrap().len(), smaller.sums.len());
    // What the physical estimate leaves of the zeros: bodies whose sideways centre is next to nothing.
    for link in answer["physical"]["links"].as_array().unwrap() {
        if link["name"].as_str().unwrap().ends_with("upper_leg") {
            assert!(number(link, &["center", "0", "value"]).abs() < 2e-3, "{link}");
        }
    }
}

/// What `excite --postures` writes becomes a table by adding measured columns.
#[test]
#[ignore = "takes long"]
fn designed_postures_are_read_back() {
    let folder = scratch("read_back");
    let plan = folder.join("plan.csv");
    bipedc(&[
        "excite",
        "robots/tulip",
        "--postures",
        "20",
        "--placements",
        "4",
        "--starts",
        "1",
        "--evaluations",
        "5",
        "--out",
        text(&plan),
    ])
    .ok();
    let identify = |path| bipedc(&["identify", "robots/tulip", text(path), "--method", "cop", "--json"]);
    identify(&plan).fails_with(&["cop/x"]);
    let table = std::fs::read_to_string(&plan).unwrap();
    let mut lines = table.lines();
    let head: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let joints: Vec<String> =
        head[2..14].iter().map(|h| h.strip_suffix("/position").unwrap().to_owned()).collect();
    let (rooted, hidden) = (rooted(&tulip(), Root::Link), rooted(&other(&tulip()), Root::Link));
    let base = rooted.base(Model::CenterOfMass, &["x", "y"], true).unwrap();
    let model = model(&rooted, &["center_of_mass_regressor"]);
    let standing = standing(&rooted, &model, &base);
    let parameters = hidden.link_inertias.parameters();
    let rows: Vec<(Vec<f64>, [f64; 2])> = lines
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            let q = values[2..14].to_vec();
            let (center, _) = standing.center(&standing.bodies(&q), &parameters);
            // Tables have so many digits.
            (q, [center.x, center.y].map(|c| (c * 1e7).round() / 1e7))
        })
        .collect();
    let path = write_postures(&folder, "measured.csv", &joints, &rows);
    let mass: f64 = parameters.iter().step_by(10).sum();
    let run = bipedc(&[
        "identify",
        "robots/tulip",
        text(&path),
        "--method",
        "cop",
        "--json",
        "--total-mass",
        &mass.to_string(),
    ]);
    let answer = run.ok().json();
    let truth = base.values(&parameters);
    for (name, truth) in base.names.iter().zip(truth) {
        let all = answer["parameters"].as_array().unwrap();
        let found = all.iter().find(|p| p["name"] == name.as_str()).unwrap_or_else(|| panic!("{name}"));
        assert!((number(found, &["value"]) - truth).abs() < 1e-3, "{name}: {} {truth}", found["value"]);
    }
}
