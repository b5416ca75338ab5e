//! Any bytes given as a measurement file.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/analysis/support/fuzz_log.rs"]
mod fuzz_log;

fuzz_target!(|data: &[u8]| fuzz_log::run(data));
