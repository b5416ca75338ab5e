//! Series elastic drives: known truth found again, wrong logs refused.
#[path = "../support/cli.rs"]
#[allow(dead_code)]
mod cli;
mod instruments;
mod leg;
mod recovery;
mod refusals;
