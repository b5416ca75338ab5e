//! Parameters from data whose parameters are known, and from real machines.
use crate::{cli, support};
mod command;
mod dry_friction;
mod identity;
mod physical;
mod real;
mod simulated;
mod statistics;
