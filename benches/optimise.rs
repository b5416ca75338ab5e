//! Gaits found from nothing, and libraries of speeds: `cargo bench --bench optimise`. All processors; programs evaluated in process.
#[path = "harness/processor.rs"]
mod processor;

use bipedc::Workbench;
use bipedc::gait::optimise::Wishes;
use bipedc::workbench::OptimiseOptions;
use processor::processor;
use std::path::Path;
use std::time::Instant;

/// Speeds of a library.
const SPEEDS: usize = 20;
/// Of each output, as by default of the command.
const COEFFICIENTS: usize = 7;

fn options(form: &str, speeds: Vec<f64>) -> OptimiseOptions {
    OptimiseOptions {
        form: form.to_owned(),
        start: None,
        speeds,
        coefficients: COEFFICIENTS,
        beginnings: None,
        wishes: Wishes::default(),
        command: "benches/optimise.rs".to_owned(),
        library: None,
    }
}

fn main() {
    println!("{}", processor());
    println!("{:<34} {:>10} {:>10} {:>8} {:>12}", "", "search, s", "with walk", "walks", "wish, s");
    for (robot, form, between, wish, repetitions, library) in [
        ("five_link", "optimised", [0.5, 0.95], 0.5, 3, true),
        ("seven_link_v1", "collocated", [0.3, 0.3], 5.0, 1, false),
        ("seven_link_v1", "collocated", [0.4, 0.4], 5.0, 1, false),
        ("seven_link_v1", "collocated", [0.5, 0.5], 5.0, 1, false),
        ("seven_link_v1", "collocated", [0.3, 0.68], 5.0, 1, true),
    ] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
        let bench = Workbench::open(&folder).unwrap_or_else(|e| panic!("{e}"));
        let run = |speeds: Vec<f64>| {
            let clock = Instant::now();
            let options = options(form, speeds);
            let found = bench
                .optimise_gaits(&options, &mut |_| (), &mut |_| Ok(()))
                .unwrap_or_else(|e| panic!("{e}"));
            let walks = found.gaits.iter().filter(|gait| gait.walks()).count();
            let search: f64 = found.gaits.iter().map(|gait| gait.search_seconds).sum();
            (search, clock.elapsed().as_secs_f64(), walks)
        };
        let one = 0.5 * (between[0] + between[1]);
        let best = (0..repetitions).map(|_| run(vec![one])).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((search, whole, walks)) = best else { continue };
        println!(
            "{:<34} {search:10.2} {whole:10.2} {walks:>6}/1 {wish:12.1}",
            format!("{robot} from nothing, {one:.3} m/s")
        );
        if !library {
            continue;
        }
        let part = |k: usize| k as f64 / (SPEEDS - 1) as f64;
        let speeds = (0..SPEEDS).map(|k| between[0] + part(k) * (between[1] - between[0])).collect();
        let (search, whole, walks) = run(speeds);
        println!(
            "{:<34} {search:10.2} {whole:10.2} {walks:>5}/{SPEEDS} {:12.1}",
            format!("{robot}, {SPEEDS} speeds"),
            10.0
        );
    }
}
