//! From a log to a better model and back, on an example by another simulator and on our own.
#![allow(missing_docs)]
#[path = "../support/cli.rs"]
#[allow(dead_code)]
mod cli;
mod measured;
mod simulated;
#[path = "../support/mod.rs"]
mod support;
