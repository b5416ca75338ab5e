//! Any text as `biped.toml` of a robot that is fine.
#![no_main]
use bipedc_compiler::description::{check_report, parse};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

const URDF: &str = include_str!("../../robots/seven_link/robot.urdf");

fuzz_target!(|text: &str| {
    if let Ok((robot, _)) = parse(URDF, Path::new("robot.urdf"), text, Path::new("biped.toml")) {
        let _ = check_report(&robot).to_string();
    }
});
