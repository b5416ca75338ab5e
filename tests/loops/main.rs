//! From a log to a better model and back, on an example by another simulator and on our own.
#![allow(missing_docs)]
use crate::{cli, support};
mod measured;
mod simulated;
