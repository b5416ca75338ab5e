//! Curves of outputs by powers are those by Bezier coefficients; files with very many names are read in time.
use super::robot;
use bipedc::gait::{GaitBench, PhasedBench, StepOptions, Stepped};
use bipedc::progress::Silent;
use std::path::Path;
use std::time::Instant;

/// Coefficients of 1, s, s² … of the polynomial with these Bezier coefficients: C(n, k) Σᵢ (−1)^(k−i) C(k, i) bᵢ.
fn powers(bezier: &[f64]) -> Vec<f64> {
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let power = |k: usize| {
        let sum: f64 = (0..=k).map(|i| sign(k - i) * choose(k, i) * bezier[i]).sum();
        choose(bezier.len() - 1, k) * sum
    };
    (0..bezier.len()).map(power).collect()
}

/// A shipped gait file with every `wanted.bezier` as `wanted.polynomial`.
fn by_powers(path: &str) -> String {
    const KEY: &str = "wanted.bezier = [";
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let mut parts = text.split(KEY);
    let mut found = parts.next().unwrap().to_owned();
    for part in parts {
        let (numbers, rest) = part.split_once(']').unwrap();
        let bezier: Vec<f64> =
            numbers.split(',').map(str::trim).filter(|x| !x.is_empty()).map(|x| x.parse().unwrap()).collect();
        found += &format!("wanted.polynomial = {:?}{rest}", powers(&bezier));
    }
    assert!(!found.contains("bezier =") && found.contains("wanted.polynomial"));
    found
}

#[test]
fn polynomials_by_powers_make_the_same_step() {
    let (folder, path) = ("robots/five_link", "robots/five_link/gaits/collocated.toml");
    let options = StepOptions { speed: 0.69, ..StepOptions::default() };
    let step = |bench: GaitBench| {
        let Stepped { step, .. } = bench.step(&options).unwrap_or_else(|e| panic!("{e}"));
        let told = [step.next_speed, step.delta, step.p_minus, step.p_max, step.phi_m];
        assert!(step.feasible);
        told.map(Option::unwrap)
    };
    let known = step(super::gait(folder, "collocated"));
    let file = Path::new("powers.toml");
    let found = step(
        GaitBench::parse(&robot(folder), file, &by_powers(path), &Silent).unwrap_or_else(|e| panic!("{e}")),
    );
    println!("{known:?}\n{found:?}");
    for (known, found) in known.iter().zip(&found) {
        assert!((known - found).abs() < 1e-9 * known.abs().max(1e-3), "{known} {found}");
    }
}

/// In several phases, with what is added to the curves and what stands for φ in them.
#[test]
fn polynomials_by_powers_are_read_in_every_phase() {
    let file = Path::new("powers.toml");
    let text = by_powers("robots/seven_link_v1/gaits/adjustable.toml");
    let found =
        PhasedBench::parse(&robot(super::WALKER), file, &text, &Silent).unwrap_or_else(|e| panic!("{e}"));
    let phases = bipedc::simulation::walker(&robot(super::WALKER)).unwrap().phases;
    let options = bipedc::gait::ChainOptions { speed: 0.42, ..Default::default() };
    let step = |bench: &PhasedBench| bench.step(&phases, &options).unwrap();
    let (known, found) = (step(&super::phased(super::WALKER, "adjustable")), step(&found));
    let (known, found) = (known.next_speed.unwrap(), found.next_speed.unwrap());
    println!("{known} {found}");
    // Torques of this gait go from limit to limit, where steps are known to some 1e-7.
    assert!((found / known - 1.0).abs() < 1e-6, "{known} {found}");
}

/// Twenty thousand parameters that no formula names took half a minute: each message was compared with all before it.
#[test]
fn very_many_parameters_are_read_in_time() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/three_link/gaits/thesis.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let (head, rest) = text.split_once("[quantities]").unwrap();
    let many: String = (0..20_000)
        .map(|k| {
            format!("[parameters.p{k}]\nunit = \"m\"\nmeaning = \"m\"\ndefault = 0.5\nbounds = [0.2, 1.0]\n")
        })
        .collect();
    let begin = Instant::now();
    let bench = super::files::open("many", &format!("{head}{many}[quantities]{rest}")).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    println!("{seconds:.2} s");
    assert_eq!(bench.warnings.len(), 20_000);
    assert!(bench.warnings[7].to_string().contains("no formula names the parameter `p7`"));
    assert!(seconds < 10.0, "{seconds} s");
}
