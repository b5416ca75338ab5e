//! Generated crates compiled for every x86-64, that take the better instructions where the processor has them.
use std::path::{Path, PathBuf};
use std::process::Command;

/// Prints the bits of results, a line for each function and state.
const PROGRAM: &str = r#"
use bipedc_runtime::{Argument, Model, State};

/// Numbers that look random, from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn print(name: &str, values: &[f64]) {
    let bits: Vec<String> = values.iter().map(|x| format!("{:016x}", x.to_bits())).collect();
    println!("{name} {}", bits.join(" "));
}

fn main() {
    let mut numbers = Numbers(1);
    for k in 0..6 {
        // Also angles that need a long reduction; not places, which momenta about the centre of mass would be differences of.
        let long = if k == 5 { 3e6 } else { 1.5 };
        let mut some = |size: f64, n: usize| -> Vec<f64> { (0..n).map(|_| size * numbers.next()).collect() };
        let robot: &dyn Model<f64> = &five_link::FiveLink;
        let mut arguments: Vec<(Argument, Vec<f64>)> =
            [Argument::Q, Argument::V, Argument::A, Argument::Tau, Argument::Forces]
                .into_iter()
                .map(|a| (a, some(if a == Argument::Q { long } else { 1.5 }, robot.argument_length(a))))
                .collect();
        arguments[0].1[..2].fill(0.3);
        let state = arguments.iter().fold(State::new(), |state, (a, x)| state.with(*a, x));
        let mut function = 0;
        while let Some(signature) = robot.signature(function) {
            let mut out = vec![0.0; signature.rows * signature.columns];
            if robot.evaluate(function, &state, &mut out).is_ok() {
                print(signature.name, &out);
            }
            function += 1;
        }
        #[cfg(feature = "humanoid")]
        humanoid(&mut some, long);
    }
}

#[cfg(feature = "humanoid")]
fn humanoid(some: &mut impl FnMut(f64, usize) -> Vec<f64>, long: f64) {
    use nalgebra::SVector;
    let mut q = SVector::<f64, 19>::from_column_slice(&some(long, 19));
    let length = (3..7).map(|k| q[k] * q[k]).sum::<f64>().sqrt();
    (3..7).for_each(|k| q[k] /= length);
    let (v, a) = (SVector::<f64, 18>::from_column_slice(&some(1.5, 18)), SVector::<f64, 18>::from_column_slice(&some(1.5, 18)));
    print("regressor", tulip::inverse_dynamics_regressor_nonzeros(&q, &v, &a).as_slice());
    print("derivatives", tulip::inverse_dynamics_derivatives(&q, &v, &a).as_slice());
    print("single precision", &tulip::inverse_dynamics(&q.cast::<f32>(), &v.cast(), &a.cast()).cast::<f64>().as_slice());
}
"#;

/// A crate around one or two of the committed ones.
struct Program {
    folder: PathBuf,
    /// Of all builds.
    features: &'static str,
}

impl Program {
    fn new(name: &str, features: &'static str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::create_dir_all(folder.join("src")).unwrap();
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let generated = |name: &str| here.join("generated").join(name).display().to_string();
        let manifest = format!(
            "[package]\nname = \"levels\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[features]\n\
             dispatch = [\"five-link/dispatch\", \"tulip?/dispatch\"]\nstd = [\"bipedc-runtime/std\"]\nhumanoid = [\"dep:tulip\"]\n\n[dependencies]\n\
             five-link = {{ path = {:?}, default-features = false }}\ntulip = {{ path = {:?}, default-features = false, optional = true }}\n\
             bipedc-runtime = {{ path = {:?} }}\nnalgebra = {{ version = \"0.35\", default-features = false }}\n\n[workspace]\n",
            generated("five_link"),
            generated("tulip"),
            here.join("runtime/core").display().to_string(),
        );
        std::fs::write(folder.join("Cargo.toml"), manifest).unwrap();
        std::fs::write(folder.join("src/main.rs"), PROGRAM).unwrap();
        // The versions of our lock file are those that are here without a network.
        std::fs::copy(here.join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
        Self { folder, features }
    }

    /// Name and results by line.
    fn results(&self, features: &str, flags: &str) -> Vec<(String, Vec<f64>)> {
        let mut run = Command::new(env!("CARGO"));
        let features = format!("{} {features}", self.features);
        run.args(["run", "--quiet", "--offline", "--release", "--features", features.trim(), "--target-dir"]);
        run.arg(self.folder.join(if flags.is_empty() { "plain" } else { "wide" })).current_dir(&self.folder);
        let output =
            run.env("RUSTFLAGS", flags).env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1").output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().map(line).collect()
    }
}

fn line(text: &str) -> (String, Vec<f64>) {
    let (name, numbers): (Vec<&str>, Vec<&str>) =
        text.split(' ').partition(|word| u64::from_str_radix(word, 16).is_err());
    let number = |bits: &str| f64::from_bits(u64::from_str_radix(bits, 16).unwrap_or(0));
    (name.join(" "), numbers.into_iter().map(number).collect())
}

fn bits(results: &[(String, Vec<f64>)]) -> Vec<(String, Vec<u64>)> {
    results.iter().map(|(name, x)| (name.clone(), x.iter().map(|x| x.to_bits()).collect())).collect()
}

/// Results do not depend on how a level was reached, with the standard library or without, and differ between levels by rounding.
#[test]
#[ignore = "builds crates"]
#[cfg(target_arch = "x86_64")]
fn functions_choose_the_level_of_the_processor() {
    levels_are_chosen(&Program::new("levels", ""));
}

/// The same with those of a robot in space as well.
#[test]
#[ignore = "builds crates, takes long"]
#[cfg(target_arch = "x86_64")]
fn functions_of_a_humanoid_choose_the_level_of_the_processor() {
    levels_are_chosen(&Program::new("levels_of_a_humanoid", "humanoid"));
}

#[cfg(target_arch = "x86_64")]
fn levels_are_chosen(program: &Program) {
    if !std::arch::is_x86_feature_detected!("avx2") || !std::arch::is_x86_feature_detected!("fma") {
        println!("this processor has only one level: skipped");
        return;
    }
    let plain = program.results("", "");
    let chosen = program.results("dispatch", "");
    assert!(bits(&chosen) == bits(&program.results("dispatch std", "")));
    let wide = program.results("", "-C target-feature=+avx2,+fma");
    let differ = bits(&chosen).iter().zip(bits(&wide)).filter(|(a, b)| *a != b).count();
    assert_eq!(differ, 0, "of {} lines", chosen.len());
    let mut worst = 0.0_f64;
    let mut apart = 0;
    for ((name, x), (other, y)) in plain.iter().zip(&chosen) {
        assert_eq!((name, x.len()), (other, y.len()));
        apart += usize::from(x != y);
        let largest = x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let unit = if name == "single precision" { f64::from(f32::EPSILON) / f64::EPSILON } else { 1.0 };
        let off = x.iter().zip(y).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
        let off = off / largest.max(f64::MIN_POSITIVE) / unit;
        worst = worst.max(off);
    }
    println!(
        "{apart} of {} lines differ between the levels, by {worst:.1e} of the largest entry",
        plain.len()
    );
    // Not the same thing twice, and the same but for rounding.
    assert!(apart > plain.len() / 4 && worst < 1e-13, "{apart}, {worst:e}");
}
