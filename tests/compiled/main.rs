//! What the compiler makes of the robots: the same by every way, as committed, as cheap, with Pinocchio's numbers.
#![allow(missing_docs)]
use crate::support;
mod front_ends;
mod generated;
mod levels;
mod machine_code;
mod operation_counts;
mod optimisation;
mod oracle_generated;
mod oracle_in_process;
