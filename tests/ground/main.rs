//! Parameters from the forces of the ground: static postures and motions on one foot, and postures designed for it.
#![allow(missing_docs)]
#[path = "../support/cli.rs"]
#[allow(dead_code)]
mod cli;
mod design;
mod misuse;
mod motion;
mod postures;
mod real;
mod stood;
#[path = "../support/mod.rs"]
mod support;
