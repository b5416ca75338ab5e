//! The committed crate of TUlip's controller, called with what its sensors told in a simulated walk, whole and corrupted.
#![allow(missing_docs)]
mod corrupted;
mod corruption;
mod recorded;
mod same;
