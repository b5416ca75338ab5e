//! All tests of the analysis but those of single loops, in one binary.
#![allow(missing_docs)]

mod ground_forces;
#[path = "logs/main.rs"]
mod logs;
mod matrix_product;
mod scenario_corpus;
#[path = "simulate/main.rs"]
mod simulate;
