//! Static postures with a small condition number: the thesis' table 5.1 for our TUlip.
//!
//! `cargo run --release --example posture_design` prints a Markdown page (some minutes). Six random sets of 50 feasible
//! postures on 10 foot placements, each optimised; 25 first-moment columns in metres, rows x and y of the centre of mass.
#[path = "reproduction/mod.rs"]
mod reproduction;

use bipedc::identification::standing::{Root, StandingRobot};
use bipedc_analysis::identify::excite::postures::{PostureRequest, StanceModel, Tolerance, design_postures};
use bipedc_analysis::identify::excite::{Criterion, Scaling};
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::exact::Model;
use reproduction::{Failure, one, said, tulip};

/// Initial and optimised condition numbers of the thesis, run by run; of another robot's joint limits.
const THESIS: [[f64; 2]; 6] =
    [[647.4, 337.5], [732.1, 405.1], [925.8, 352.6], [714.1, 314.7], [733.6, 406.9], [689.1, 394.4]];

fn main() -> Result<(), Failure> {
    let evaluations = std::env::args().nth(1).map_or(Ok(6000), |text| text.parse())?;
    let rooted = StandingRobot::new(&tulip()?, Some("right_foot"), Root::Link).map_err(said)?;
    let request = FunctionRequest::of_robot("center_of_mass_regressor");
    let model = ProgramModel::new(rooted.robot.compile_only(&[request]).map_err(one)?);
    // Masses are eliminated: every sum is led by a first moment. The swing foot's height is seen only when it tilts.
    let mut base = rooted.base(Model::CenterOfMass, &["x", "y"], false).map_err(one)?;
    let seen: Vec<usize> =
        (0..base.names.len()).filter(|&k| !base.names[k].starts_with("left_foot.m*cz")).collect();
    base.sums = seen.iter().map(|&k| base.sums[k].clone()).collect();
    base.names = seen.iter().map(|&k| base.names[k].clone()).collect();
    let parts = rooted.parts(&model, &base, &mut Vec::new()).map_err(one)?;
    let standing = StanceModel::new(parts).map_err(one)?;
    let request = PostureRequest {
        postures: 50,
        placements: 10,
        criterion: Criterion::Condition,
        scaling: Scaling::Own,
        margin: 0.0,
        stability: 0.02,
        gap: 0.01,
        tolerance: Tolerance { mass: 0.0, center: 0.0, draws: 0 },
        seed: 1,
        starts: THESIS.len(),
        evaluations,
        time_limit: None,
    };
    let begun = std::time::Instant::now();
    let found = design_postures(&standing, &request, &|_| (), &|| false).map_err(one)?;
    println!(
        "{} columns, 50 postures on 10 placements, margin 20 mm; joint limits of `robots/tulip`; seed 1.\n",
        base.sums.len()
    );
    println!(
        "| run | initial | optimised | of initial | thesis: initial | thesis: optimised |\n|---|---|---|---|---|---|"
    );
    for (k, (run, thesis)) in found.runs.iter().zip(THESIS).enumerate() {
        let (before, after) = (run.before.condition_number, run.after.condition_number);
        println!(
            "| {} | {before:.1} | {after:.1} | {:.2} | {} | {} |",
            k + 1,
            after / before,
            thesis[0],
            thesis[1]
        );
    }
    let best = &found.runs[found.best];
    println!(
        "\nBest: {:.1}, {:.2} of its own initial value (thesis: 314.7, 0.44; joint limits of another robot). At most {} evaluations per run, {:.0} s in all.",
        best.after.condition_number,
        best.after.condition_number / best.before.condition_number,
        request.evaluations,
        begun.elapsed().as_secs_f64()
    );
    let least = found.postures.iter().map(|p| p.stability).fold(f64::INFINITY, f64::min);
    println!(
        "Centre of pressure at least {:.1} mm inside the support, soles at least {:.1} mm apart.",
        1e3 * least,
        1e3 * found.gap
    );
    Ok(())
}
