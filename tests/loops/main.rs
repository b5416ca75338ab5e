//! From a log to a better model and back, on an example by another simulator and on our own.
#![allow(missing_docs)]
use crate::{cli, support};
#[path = "../../examples/controller.rs"]
#[allow(dead_code)]
mod controller;
#[path = "../../examples/explain.rs"]
#[allow(dead_code)]
mod explain;
mod library;
mod measured;
mod one_number;
mod simulated;
