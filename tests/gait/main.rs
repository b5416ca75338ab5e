//! Gaits: zero dynamics against an independent derivation, against whole simulations, against identities; the file format, the
//! command.
mod choices;
mod command;
mod curves;
mod cycles;
mod files;
mod grounded;
mod guards;
mod identities;
mod libraries;
mod lie;
mod limits;
mod maps;
mod names;
mod optimised;
mod oracle;
mod page;
mod phase_surface;
mod phased_chain;
mod phased_choices;
mod phased_contacts;
mod phased_files;
mod phased_lie;
mod phased_plans;
mod phased_speeds;
mod phased_walks;
mod planar;
mod plans;
mod scenarios;
mod simulated;
mod sparing_maps;
mod status;
mod walked;
mod wished;

use bipedc::Robot;
use bipedc::gait::{GaitBench, PhasedBench};
use bipedc::progress::Silent;
use std::path::Path;

/// A robot below the repository's root.
fn robot(folder: &str) -> Robot {
    Robot::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap_or_else(|e| panic!("{e}"))
}

/// A robot's gait of this name.
fn gait(folder: &str, name: &str) -> GaitBench {
    GaitBench::open(&robot(folder), name, &Silent).unwrap_or_else(|e| panic!("{e}"))
}

/// The robot with feet whose gait has four phases.
const WALKER: &str = "robots/seven_link_v1";

/// A gait of several phases.
fn phased(folder: &str, name: &str) -> PhasedBench {
    PhasedBench::open(&robot(folder), name, &Silent).unwrap_or_else(|e| panic!("{e}"))
}

/// The three-link gait with outputs that are no sums of joint angles.
fn bent() -> GaitBench {
    let text = files::changed(
        "robots/three_link",
        "controlled = \"base_pitch\"",
        "controlled = \"tan(base_pitch)\"",
    )
    .replace("wanted = \"-torso_lean\"", "wanted = \"-tan(torso_lean)\"")
    .replace("controlled = \"swing\"", "controlled = \"sin(swing)\"")
    .replace("wanted = \"-phase\"", "wanted = \"-sin(phase)\"");
    files::open("bent", &text).unwrap_or_else(|e| panic!("{e}"))
}

/// |a − b| relative to b.
fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}
