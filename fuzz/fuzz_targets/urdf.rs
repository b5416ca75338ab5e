//! Any text as a URDF: read, and if it is a robot, guess its description, read that, and report on it.
#![no_main]
use bipedc_compiler::description::{check_report, init_text, parse};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    let (urdf, toml) = (Path::new("robot.urdf"), Path::new("biped.toml"));
    let Ok((robot, _)) = parse(text, urdf, "", toml) else { return };
    let _ = check_report(&robot).to_string();
    let guess = init_text(text, urdf).expect("a robot that loads has a first description");
    if let Err(errors) = parse(text, urdf, &guess, toml) {
        panic!("the guessed description is refused:\n{guess}\n{errors}");
    }
});
