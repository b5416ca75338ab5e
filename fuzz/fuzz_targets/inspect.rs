//! Any text as URDF and description: everything that can be derived from it, and its crate.
#![no_main]
use libfuzzer_sys::fuzz_target;

#[path = "../../tests/support/fuzz_inspect.rs"]
mod fuzz_inspect;

fuzz_target!(|text: &str| fuzz_inspect::run(text));
