//! A real humanoid that walks (`../shared/data/icub_walking`; source and licence in its README): known figures.
//!
//! The data are read in place; without them the test says so and passes.
use crate::experiments::support::measured::Subjects;
use crate::experiments::support::project;
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::experiments::contact_log::{ContactExperiment, ContactRecording, Quantity};
use bipedc_analysis::log::{Log, Mapping};
use bipedc_analysis::measure::Options;
use bipedc_compiler::Robot as Described;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_effects::effect::{self, Effect, Location, kinds};
use std::path::{Path, PathBuf};

fn data() -> Option<PathBuf> {
    let folder = project().join("../shared/data/icub_walking");
    if folder.join("icub_walking.csv").exists() {
        return Some(folder);
    }
    println!("skipped: {} is not there", folder.display());
    None
}

fn described(folder: &Path) -> Described {
    let own = std::env::temp_dir().join(format!("bipedc-icub-{}", std::process::id()));
    std::fs::create_dir_all(&own).unwrap();
    std::fs::copy(folder.join("iCubGenova04.urdf"), own.join("robot.urdf")).unwrap();
    let foot = |side: &str| {
        format!(
            "[feet.{side}_sole]\nlink = \"{side}_sole\"\npoints.front_left = [0.12, 0.045, 0.0]\npoints.front_right = [0.12, -0.045, 0.0]\npoints.rear_left = [-0.07, 0.045, 0.0]\npoints.rear_right = [-0.07, -0.045, 0.0]\n"
        )
    };
    let text = format!("[base]\nkind = \"floating\"\nroot = \"root_link\"\n{}{}", foot("l"), foot("r"));
    std::fs::write(own.join("biped.toml"), text).unwrap();
    let described = Described::read(&own).unwrap();
    std::fs::remove_dir_all(&own).unwrap();
    described
}

fn model(described: &Described) -> ProgramModel {
    let mut requests: Vec<FunctionRequest> = [
        "inverse_dynamics",
        "inverse_dynamics_regressor",
        "center_of_mass",
        "center_of_mass_jacobian",
        "center_of_mass_regressor",
    ]
    .map(FunctionRequest::of_robot)
    .to_vec();
    for family in ["position", "rotation", "jacobian"] {
        let of = |link: &str| FunctionRequest { family: family.to_owned(), subject: Some(link.to_owned()) };
        requests.extend(["l_sole", "r_sole"].map(of));
    }
    ProgramModel::new(described.compile_only(&requests).unwrap())
}

/// Root mean square of a row over the second half, minus what effects explain.
fn held_out(experiment: &dyn Experiment, row: &str, effects: &[Effect]) -> f64 {
    let row = experiment.rows().iter().position(|r| r.name == row).unwrap();
    let response = experiment.response(effects);
    let explained = response.iter().find(|(r, _)| *r == row).map(|(_, values)| values);
    let residual = experiment.residual(row);
    let half = residual.len() / 2;
    let square = |i: usize| (residual[i] - explained.map_or(0.0, |values| values[i])).powi(2);
    ((half..residual.len()).map(square).sum::<f64>() / (residual.len() - half) as f64).sqrt()
}

/// Least squares on the first half of some rows: parameters of an effect, by Gauss-Newton steps.
fn fitted(experiment: &dyn Experiment, rows: &[&str], start: &Effect, free: &[&str]) -> Effect {
    let rows: Vec<usize> =
        rows.iter().map(|row| experiment.rows().iter().position(|r| r.name == *row).unwrap()).collect();
    let half = experiment.time().len() / 2;
    let values = |effect: &Effect| -> Vec<f64> {
        let response = experiment.response(std::slice::from_ref(effect));
        let of = |row: &usize| response.iter().find(|(r, _)| r == row).map(|(_, v)| v[..half].to_vec());
        rows.iter().flat_map(|row| of(row).unwrap_or_else(|| vec![0.0; half])).collect()
    };
    let residual: Vec<f64> = rows.iter().flat_map(|row| experiment.residual(*row)[..half].to_vec()).collect();
    let mut effect = start.clone();
    for _ in 0..6 {
        let here = values(&effect);
        let columns: Vec<Vec<f64>> = free
            .iter()
            .map(|name| {
                let mut moved = effect.clone();
                *moved.parameters.get_mut(*name).unwrap() += 1e-4;
                values(&moved).iter().zip(&here).map(|(a, b)| (a - b) / 1e-4).collect()
            })
            .collect();
        let matrix = bipedc_runtime::nalgebra::DMatrix::from_fn(here.len(), free.len(), |r, c| columns[c][r]);
        let left = bipedc_runtime::nalgebra::DVector::from_iterator(
            here.len(),
            residual.iter().zip(&here).map(|(r, h)| r - h),
        );
        let step = (matrix.transpose() * &matrix).lu().solve(&(matrix.transpose() * left)).unwrap();
        for (name, step) in free.iter().zip(step.iter()) {
            *effect.parameters.get_mut(*name).unwrap() += step;
        }
    }
    effect
}

#[test]
#[ignore = "takes long"]
fn walking_icub_has_its_known_figures() {
    let Some(folder) = data() else { return };
    let described = described(&folder);
    let subjects = Subjects::of(&described);
    let model = model(&described);
    let mapping = ["l", "r"].map(|s| {
        format!("\"{s}_sole/force\" = {{ frame = \"sole\" }}\n\"{s}_sole/torque\" = {{ frame = \"sole\" }}\n")
    });
    let mapping = Mapping::parse(Path::new("icub.toml"), &mapping.concat()).unwrap();
    let options = Options { cutoff_hz: Some(3.0), ..Options::default() };
    let robot = subjects.robot(&model, &[]);
    let log = Log::with_mapping(folder.join("icub_walking.csv"), mapping).unwrap();
    let mut recording = ContactRecording::read(&robot, &log, &options, None).unwrap();
    // The known figures were made with one pass of a filter, signal by signal.
    recording.filter_rows = false;
    recording.leave_out_products();
    let experiment = ContactExperiment::new(robot, recording).unwrap();
    println!("{}", experiment.recording().assumptions.join("\n"));
    let forces = ["base/force/x", "base/force/y", "base/force/z"];
    let rms = |effects: &[Effect]| forces.map(|row| held_out(&experiment, row, effects));
    let nominal = rms(&[]);
    println!("nominal {nominal:.2?} N");
    for row in experiment.rows() {
        println!(
            "  {}: {:.3}, noise {:.3} {}",
            row.name,
            held_out(&experiment, &row.name, &[]),
            row.noise,
            row.unit
        );
    }
    let near = |found: f64, expected: f64, part: f64| {
        assert!((found / expected - 1.0).abs() < part, "{found}, expected {expected}");
    };
    for (found, expected) in nominal.into_iter().zip([30.5, 21.8, 8.96]) {
        near(found, expected, 0.04);
    }
    let cop = experiment.quantities(&[]);
    for (name, expected) in [("cop_static/x", 0.0143), ("cop/x", 0.0115)] {
        let quantity = cop.iter().find(|q| q.name == name).unwrap();
        let later =
            Quantity { values: quantity.values[quantity.values.len() / 2..].to_vec(), ..quantity.clone() };
        near(later.rms(), expected, 0.15);
    }
    for q in cop {
        let half = q.values.len() / 2;
        let later = Quantity { values: q.values[half..].to_vec(), ..q.clone() };
        println!("  {}: {:.5} {} ({})", q.name, later.rms(), q.unit, q.meaning);
    }
    let mass = Effect::new(
        &kinds::PAYLOAD,
        Location::link("root_link"),
        &[("mass", 0.5), ("x", 0.0), ("y", 0.0), ("z", 0.0)],
    );
    let mass = fitted(&experiment, &forces[2..], &mass, &["mass"]);
    let gain = Effect::new(&kinds::FORCE_SENSOR_GAIN, Location::default(), &[("gain", 1.0)]);
    let gain = fitted(&experiment, &forces[2..], &gain, &["gain"]);
    let tilt = Effect::new(&kinds::GRAVITY_TILT, Location::default(), &[("roll", 0.0), ("pitch", 0.0)]);
    let tilt = fitted(&experiment, &forces[..2], &tilt, &["roll", "pitch"]);
    let bias =
        Effect::new(&kinds::FORCE_SENSOR_BIAS, Location::default(), &[("x", 0.0), ("y", 0.0), ("z", 0.0)]);
    let bias = fitted(&experiment, &forces[..2], &bias, &["x", "y"]);
    for effect in [&mass, &gain, &tilt, &bias] {
        println!("{} {:?}: {:.2?} N", effect.kind, effect.parameters, rms(std::slice::from_ref(effect)));
    }
    near(mass.value("mass"), 0.839, 0.03);
    near(rms(&[mass])[2], 3.19, 0.04);
    near(1.0 / gain.value("gain"), 0.975, 0.002);
    near(rms(&[gain])[2], 3.12, 0.04);
    let tilted = rms(std::slice::from_ref(&tilt));
    near(tilted[0], 5.2, 0.05);
    near(tilted[1], 22.1, 0.05);
    near(tilt.value("pitch").to_degrees().abs(), 5.6, 0.03);
    near(tilt.value("roll").to_degrees().abs(), 2.1, 0.1);
    let biased = rms(std::slice::from_ref(&bias));
    near(biased[0], 5.2, 0.05);
    near(biased[1], 22.1, 0.05);
    near(2.0 * bias.value("x"), -31.6, 0.03);
    near(2.0 * bias.value("y"), 11.9, 0.1);
    let assumptions = ["point_feet", "no_impact", "single_mass", "decoupled_planes"];
    for kind in assumptions.map(|name| effect::kind(name).unwrap()) {
        let effect = [Effect::new(kind, Location::default(), &[])];
        let all: Vec<String> = experiment
            .rows()
            .iter()
            .map(|row| format!("{} {:.2} {}", row.name, held_out(&experiment, &row.name, &effect), row.unit))
            .collect();
        println!("{kind}: {}", all.join(", "));
    }
}
