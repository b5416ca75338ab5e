//! Static identification with centres of pressure: the thesis' table 8.3 and figure 8.6a, in simulation.
//!
//! `cargo run --release --example posture_identification` prints a Markdown page. 108 designed postures of a TUlip whose
//! parameters differ from the URDF's; 4 mm of noise (standard deviation of each coordinate of the centre of pressure).
#[path = "reproduction/mod.rs"]
mod reproduction;

use bipedc::identification::standing::{Root, StandingRobot};
use bipedc_analysis::experiments::postures::PostureExperiment;
use bipedc_analysis::identify::BaseSet;
use bipedc_analysis::identify::cop::{
    PostureTable, PressureErrors, held_out, least_squares, pressure_errors, simplified,
};
use bipedc_analysis::identify::excite::postures::{PostureRequest, StanceModel, Tolerance, design_postures};
use bipedc_analysis::identify::excite::{Criterion, Scaling};
use bipedc_analysis::log::{Log, Mapping, Reader};
use bipedc_compiler::exact::Model;
use reproduction::{Failure, Noise, Stood, one, other, said, tulip};
use std::fmt::Write as _;
use std::io::Cursor;
use std::path::Path;

/// Standard deviation of each coordinate, m.
const NOISE: f64 = 4e-3;

fn main() -> Result<(), Failure> {
    let rooted = StandingRobot::new(&tulip()?, Some("right_foot"), Root::Link).map_err(said)?;
    let truth =
        Stood::new(StandingRobot::new(&other(&tulip()?, 83), Some("right_foot"), Root::Link).map_err(said)?)?;
    let stood = Stood::new(rooted)?;
    let full = stood.rooted.base(Model::CenterOfMass, &["x", "y"], true).map_err(one)?;
    let zeros = stood.rooted.zeros().map_err(one)?;
    let smaller = simplified(&full, &names(&stood), &|k| zeros.contains(&k));
    let standing = StanceModel::new(stood.rooted.parts(&stood.model, &full, &mut Vec::new()).map_err(one)?)
        .map_err(one)?;
    let actual = truth.rooted.link_inertias.parameters();
    let mass: f64 = actual.iter().step_by(10).sum();
    let set = |postures, placements, seed, evaluations| {
        let request = PostureRequest {
            postures,
            placements,
            criterion: Criterion::Condition,
            scaling: Scaling::Own,
            margin: 0.05,
            stability: 0.02,
            gap: 0.01,
            tolerance: Tolerance { mass: 0.1, center: 0.01, draws: 4 },
            seed,
            starts: 1,
            evaluations,
            time_limit: None,
        };
        let found = design_postures(&standing, &request, &|_| (), &|| false).map_err(one)?;
        Ok::<_, Failure>(found.postures.into_iter().map(|p| p.joints).collect::<Vec<_>>())
    };
    let (teaching, judging) = (set(108, 27, 1, 1500)?, set(54, 14, 2, 0)?);
    let mut noise = Noise(4);
    let measured = |postures: &[Vec<f64>], noise: &mut dyn FnMut() -> f64| -> Result<PostureTable, Failure> {
        let mut text = format!(
            "posture,{},cop/x,cop/y\n",
            standing.parts.names.iter().map(|n| format!("{n}/position")).collect::<Vec<_>>().join(",")
        );
        for (number, q) in postures.iter().enumerate() {
            let (center, _) = standing.center(&standing.bodies(q), &actual);
            let joints: Vec<String> = q.iter().map(f64::to_string).collect();
            let _ =
                writeln!(text, "{number},{},{},{}", joints.join(","), center.x + noise(), center.y + noise());
        }
        let reader = Reader::from_source(
            Path::new("postures.csv"),
            Box::new(Cursor::new(text.into_bytes())),
            &Mapping::default(),
        )
        .map_err(said)?;
        let read = PostureExperiment::from_reader(stood.robot(), reader, Some("right_foot")).map_err(said)?;
        Ok(PostureTable::new(&read, mass))
    };
    let train = measured(&teaching, &mut || NOISE * noise.normal())?;
    let judge = measured(&judging, &mut || NOISE * noise.normal())?;
    let exact = measured(&judging, &mut || 0.0)?;

    println!(
        "108 postures on 27 placements (optimised), 54 others on 14 placements (feasible, random) that judge; {:.0} mm of noise per coordinate of the centre of pressure; mass {mass:.2} kg known.\n",
        1e3 * NOISE
    );
    println!("Error of the centre of pressure, mm: mean / standard deviation / maximum\n");
    println!(
        "| model | parameters | 108 postures | left out in turn | 54 others, measured | 54 others, true | thesis (real robot, 108 postures) |\n|---|---|---|---|---|---|---|"
    );
    let nominal = stood.rooted.link_inertias.parameters();
    let row = |name: &str, base: &BaseSet, values: &[f64], left_out: Option<PressureErrors>, thesis: &str| {
        let cells = [
            Some(pressure_errors(&train, base, values)),
            left_out,
            Some(pressure_errors(&judge, base, values)),
            Some(pressure_errors(&exact, base, values)),
        ];
        println!(
            "| {name} | {} | {} | {thesis} |",
            base.sums.len(),
            cells.map(|c| c.as_ref().map_or_else(String::new, figures)).join(" | ")
        );
    };
    row("URDF", &full, &full.values(&nominal), None, "");
    let fitted = |base: &BaseSet| -> Vec<f64> {
        let (w, y) = train.regression(base);
        least_squares(&w, &y, &base.values(&nominal)).as_slice().to_vec()
    };
    let (large, small) = (fitted(&full), fitted(&smaller));
    row("full", &full, &large, Some(held_out(&train, &full, &full.values(&nominal))), "4.2 / 3.6 / 10.7");
    row(
        "simplified",
        &smaller,
        &small,
        Some(held_out(&train, &smaller, &smaller.values(&nominal))),
        "4.5 / 3.7 / 12.9",
    );
    row("truth", &full, &full.values(&actual), None, "");
    parameters(&train, &full, &large, &full.values(&actual), mass)?;
    example(&stood, &full, &smaller)
}

fn figures(e: &PressureErrors) -> String {
    format!("{:.2} / {:.2} / {:.2}", 1e3 * e.mean, 1e3 * e.standard_deviation, 1e3 * e.max)
}

fn names(stood: &Stood) -> Vec<String> {
    let ten = ["m", "m*cx", "m*cy", "m*cz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];
    stood.rooted.link_inertias.bodies.iter().flat_map(|body| ten.map(|p| format!("{body}.{p}"))).collect()
}

/// As table 8.3: first moments over the mass, relative standard errors by (8.2) and (8.3).
fn parameters(
    train: &PostureTable,
    base: &BaseSet,
    values: &[f64],
    actual: &[f64],
    mass: f64,
) -> Result<(), Failure> {
    let (w, y) = train.regression(base);
    let left = &y - &w * bipedc_runtime::nalgebra::DVector::from_column_slice(values);
    let variance = left.norm_squared() / (w.nrows() - w.ncols()) as f64;
    let inverse = w.tr_mul(&w).try_inverse().ok_or("the postures do not tell all parameters")?;
    println!(
        "\n## Full model, as table 8.3\n\n| sum, over the mass | estimate, mm | standard error, % | truth, mm | standard errors off |\n|---|---|---|---|---|"
    );
    let (mut within, mut well) = (0, 0);
    for k in 0..values.len() {
        let error = (variance * inverse[(k, k)]).sqrt();
        let off = (values[k] - actual[k]) / error;
        (within, well) =
            (within + usize::from(off.abs() < 2.0), well + usize::from(error < 0.15 * values[k].abs()));
        println!(
            "| `{}` | {:.2} | {:.1} | {:.2} | {off:+.1} |",
            base.names[k],
            1e3 * values[k] / mass,
            100.0 * error / values[k].abs(),
            1e3 * actual[k] / mass
        );
    }
    println!(
        "\n{well} of {} have a standard error below 15 % (table 8.3: 6 of 25; its text: 'approximately one third'); {within} lie within two standard errors of the truth.",
        values.len()
    );
    Ok(())
}

/// The synthetic example with a torso whose centre of mass is 18 mm and 9 mm off.
fn example(stood: &Stood, full: &BaseSet, smaller: &BaseSet) -> Result<(), Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/examples/postures");
    let read = |name: &str| -> Result<PostureTable, Failure> {
        let log = Log::open(folder.join(name)).map_err(said)?;
        let read = PostureExperiment::read(stood.robot(), &log, Some("right_foot")).map_err(said)?;
        let carried = read.carried().ok_or("no corner forces")?;
        Ok(PostureTable::new(&read, carried.iter().sum::<f64>() / carried.len() as f64))
    };
    let (train, judge) = (read("train.csv.gz")?, read("validation.csv.gz")?);
    let nominal = stood.rooted.link_inertias.parameters();
    println!(
        "\n## The example `tests/data/examples/postures`\n\n90 postures teach, 45 others judge (simulated by an independent simulator; the torso's centre is 18 and 9 mm off).\n"
    );
    println!("| model | 90 postures | left out in turn | 45 others |\n|---|---|---|---|");
    println!(
        "| URDF | {} | | {} |",
        figures(&pressure_errors(&train, full, &full.values(&nominal))),
        figures(&pressure_errors(&judge, full, &full.values(&nominal)))
    );
    for (name, base) in [("full", full), ("simplified", smaller)] {
        let (w, y) = train.regression(base);
        let values = least_squares(&w, &y, &base.values(&nominal));
        println!(
            "| {name} | {} | {} | {} |",
            figures(&pressure_errors(&train, base, values.as_slice())),
            figures(&held_out(&train, base, &base.values(&nominal))),
            figures(&pressure_errors(&judge, base, values.as_slice()))
        );
    }
    Ok(())
}
