//! Any text as states of robots that are fine: every function there.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/fuzz_evaluate.rs"]
mod fuzz_evaluate;

fuzz_target!(|text: &str| fuzz_evaluate::run(text));
