//! Series elastic drives: known truth found again, wrong logs refused.
use crate::cli;
mod instruments;
mod leg;
mod recovery;
mod refusals;
