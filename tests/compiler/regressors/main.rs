//! Regressors and base parameters: exact ranks, groups, the states that they are for, parameters at run time.
#![allow(missing_docs)]
mod drives;
mod groups;
mod ranks;
mod run_time_parameters;
mod states;
mod support;
