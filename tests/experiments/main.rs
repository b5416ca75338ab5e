//! Logs, postures and impacts as experiments: what effects would change in them, against independent computations.
#![allow(missing_docs)]
mod contact_effects;
mod contact_log;
mod data_gate;
mod icub_walking;
mod impacts;
mod postures;
#[path = "../support/mod.rs"]
mod support;
