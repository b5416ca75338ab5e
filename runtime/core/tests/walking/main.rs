//! The estimator on a body whose motion is known; how long sharing of forces takes.
#![allow(missing_docs)]
mod estimator;
mod ground_forces;
