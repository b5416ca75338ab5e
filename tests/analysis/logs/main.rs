//! Logs: read or refused, filtered, compared with models.
#![allow(missing_docs)]
mod base;
mod blocks;
mod corpus;
mod errors;
mod examples;
#[path = "../support/fuzz_log.rs"]
mod fuzz_log;
mod log;
mod mapping;
mod order;
mod signal;
mod sparse;
#[path = "../support/mod.rs"]
mod support;
