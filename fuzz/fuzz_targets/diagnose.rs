//! Any bytes as a log of a robot that is fine: compared, checked and diagnosed.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/fuzz_diagnose.rs"]
mod fuzz_diagnose;

fuzz_target!(|data: &[u8]| fuzz_diagnose::run(data));
