//! The text of this crate's core: generated crates that are written far from here carry it with them.

/// Paths below the crate's folder, with their text, but for what [`manifest`] and [`root`] make.
const FILES: [(&str, &str); 62] = [
    ("LICENSE", include_str!("../LICENSE")),
    ("src/control/elimination.rs", include_str!("control/elimination.rs")),
    ("src/control/feedback.rs", include_str!("control/feedback.rs")),
    ("src/control/gait.rs", include_str!("control/gait.rs")),
    ("src/control/gait_controller.rs", include_str!("control/gait_controller.rs")),
    ("src/control/ground_limits.rs", include_str!("control/ground_limits.rs")),
    ("src/control/least_change.rs", include_str!("control/least_change.rs")),
    ("src/control/mod.rs", include_str!("control/mod.rs")),
    ("src/control/phase_surface.rs", include_str!("control/phase_surface.rs")),
    ("src/control/phased.rs", include_str!("control/phased.rs")),
    ("src/control/phased_controller.rs", include_str!("control/phased_controller.rs")),
    ("src/control/phased_torques.rs", include_str!("control/phased_torques.rs")),
    ("src/control/slices.rs", include_str!("control/slices.rs")),
    ("src/control/step_end.rs", include_str!("control/step_end.rs")),
    ("src/control/surface.rs", include_str!("control/surface.rs")),
    ("src/control/zero.rs", include_str!("control/zero.rs")),
    ("src/dispatch.rs", include_str!("dispatch.rs")),
    ("src/dispatch/chosen.rs", include_str!("dispatch/chosen.rs")),
    ("src/format.rs", include_str!("format.rs")),
    ("src/lanes/arrays.rs", include_str!("lanes/arrays.rs")),
    ("src/lanes/fused.rs", include_str!("lanes/fused.rs")),
    ("src/lanes/mod.rs", include_str!("lanes/mod.rs")),
    ("src/lanes/pair.rs", include_str!("lanes/pair.rs")),
    ("src/lanes/scalar.rs", include_str!("lanes/scalar.rs")),
    ("src/lanes/two.rs", include_str!("lanes/two.rs")),
    ("src/lanes/x86.rs", include_str!("lanes/x86.rs")),
    ("src/math/exponential.rs", include_str!("math/exponential.rs")),
    ("src/math/kernel.rs", include_str!("math/kernel.rs")),
    ("src/math/large.rs", include_str!("math/large.rs")),
    ("src/math/logarithm.rs", include_str!("math/logarithm.rs")),
    ("src/math/mod.rs", include_str!("math/mod.rs")),
    ("src/math/scalar.rs", include_str!("math/scalar.rs")),
    ("src/model.rs", include_str!("model.rs")),
    ("src/real.rs", include_str!("real.rs")),
    ("src/sparsity.rs", include_str!("sparsity.rs")),
    ("src/walking/adjustment.rs", include_str!("walking/adjustment.rs")),
    ("src/walking/balance.rs", include_str!("walking/balance.rs")),
    ("src/walking/carrying.rs", include_str!("walking/carrying.rs")),
    ("src/walking/controller.rs", include_str!("walking/controller.rs")),
    ("src/walking/divergent.rs", include_str!("walking/divergent.rs")),
    ("src/walking/elastic.rs", include_str!("walking/elastic.rs")),
    ("src/walking/error_state.rs", include_str!("walking/error_state.rs")),
    ("src/walking/estimator.rs", include_str!("walking/estimator.rs")),
    ("src/walking/estimator_feet.rs", include_str!("walking/estimator_feet.rs")),
    ("src/walking/gains.rs", include_str!("walking/gains.rs")),
    ("src/walking/ground_foot.rs", include_str!("walking/ground_foot.rs")),
    ("src/walking/ground_forces.rs", include_str!("walking/ground_forces.rs")),
    ("src/walking/ground_program.rs", include_str!("walking/ground_program.rs")),
    ("src/walking/guard.rs", include_str!("walking/guard.rs")),
    ("src/walking/mod.rs", include_str!("walking/mod.rs")),
    ("src/walking/motion.rs", include_str!("walking/motion.rs")),
    ("src/walking/on_board.rs", include_str!("walking/on_board.rs")),
    ("src/walking/payload.rs", include_str!("walking/payload.rs")),
    ("src/walking/payload_observer.rs", include_str!("walking/payload_observer.rs")),
    ("src/walking/quaternion.rs", include_str!("walking/quaternion.rs")),
    ("src/walking/readings.rs", include_str!("walking/readings.rs")),
    ("src/walking/robot.rs", include_str!("walking/robot.rs")),
    ("src/walking/sensed.rs", include_str!("walking/sensed.rs")),
    ("src/walking/space.rs", include_str!("walking/space.rs")),
    ("src/walking/steps.rs", include_str!("walking/steps.rs")),
    ("src/walking/support.rs", include_str!("walking/support.rs")),
    ("src/walking/swing.rs", include_str!("walking/swing.rs")),
];

/// The core's dependency, as the workspace has it.
const NALGEBRA: &str = r#"{ version = "0.35", default-features = false, features = ["libm"] }"#;

/// The `no_std` core as a crate of its own: paths and texts of its files.
///
/// Sources are marked with their licence; the first line of `Cargo.toml` says where they come from.
pub fn core_crate() -> Vec<(&'static str, String)> {
    let files = FILES.into_iter().map(|(path, text)| (path, text.to_owned()));
    let made = [("Cargo.toml", manifest()), ("src/lib.rs", root())];
    let marked = |(path, text): (&'static str, String)| match path.ends_with(".rs") {
        true => (path, format!("// SPDX-License-Identifier: {}\n{text}", env!("CARGO_PKG_LICENSE"))),
        false => (path, text),
    };
    files.chain(made).map(marked).collect()
}

fn manifest() -> String {
    let (version, license) = (env!("CARGO_PKG_VERSION"), env!("CARGO_PKG_LICENSE"));
    let rust = env!("CARGO_PKG_RUST_VERSION");
    format!(
        "# @generated by bipedc {version}: the core of its runtime. Do not edit.\n\
         [package]\nname = \"bipedc-runtime\"\nversion = \"{version}\"\nedition = \"2024\"\n\
         rust-version = \"{rust}\"\nlicense = \"{license}\"\n\n\
         [features]\nstd = [\"nalgebra/std\"]\ndispatch = []\n\n\
         [dependencies]\nnalgebra = {NALGEBRA}\n"
    )
}

/// `lib.rs` without the desk's part, which stands under one attribute.
fn root() -> String {
    let mut lines = include_str!("lib.rs").lines();
    let mut kept = String::new();
    while let Some(line) = lines.next() {
        if line == "#[cfg(feature = \"source\")]" {
            lines.next();
            continue;
        }
        kept.push_str(line);
        kept.push('\n');
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Text of a file of the repository.
    fn file(path: &str) -> String {
        std::fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
    }

    #[test]
    fn dependency_and_licence_are_those_of_the_project() {
        assert!(file("../../Cargo.toml").contains(&format!("\nnalgebra = {NALGEBRA}\n")));
        assert_eq!(file("LICENSE"), file("../../LICENSE"));
    }

    /// Modules of the crate's root that need no feature, and nothing else.
    #[test]
    fn the_root_has_the_core_alone() {
        let root = root();
        let modules: Vec<&str> = root.lines().filter_map(|line| line.strip_prefix("pub mod ")).collect();
        assert_eq!(
            modules,
            [
                "control;",
                "dispatch;",
                "format;",
                "lanes;",
                "math;",
                "model;",
                "real;",
                "sparsity;",
                "walking;"
            ]
        );
        assert!(root.starts_with("//!") && root.contains("no_std"));
    }

    /// A module without its file would be seen only where a crate is built far from here.
    #[test]
    fn every_module_has_its_file() {
        let all = core_crate();
        let there = |path: String| all.iter().any(|(known, _)| *known == path);
        for (path, text) in all.iter().filter(|(path, _)| path.ends_with(".rs")) {
            let folder = ["/mod.rs", "/lib.rs", ".rs"].iter().find_map(|end| path.strip_suffix(end)).unwrap();
            let declared = text.lines().filter_map(|line| {
                line.strip_prefix("pub ").unwrap_or(line).strip_prefix("mod ")?.strip_suffix(';')
            });
            for name in declared {
                let files = [format!("{folder}/{name}.rs"), format!("{folder}/{name}/mod.rs")];
                assert!(files.into_iter().any(there), "{path} declares {name}");
            }
        }
    }
}
