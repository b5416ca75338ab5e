//! Any text given as a gait of a robot that is fine.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/fuzz_gait.rs"]
mod fuzz_gait;

fuzz_target!(|text: &str| fuzz_gait::run(text));
