//! Any text given as a scenario of a robot that is fine.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/analysis/support/fuzz_scenario.rs"]
mod fuzz_scenario;

fuzz_target!(|data: &[u8]| fuzz_scenario::run(data));
