//! Parameters from data whose parameters are known, and from real machines.
#[path = "../support/cli.rs"]
#[allow(dead_code)]
mod cli;
mod command;
mod identity;
mod physical;
mod real;
mod statistics;
mod subject;
#[path = "../support/mod.rs"]
mod support;
