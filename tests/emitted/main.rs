//! Emitted code, compiled through the derive macro: the same bits as the evaluator in process, no allocation,
//! no warnings, other scalars.
#![deny(warnings)]
#![forbid(unsafe_op_in_unsafe_fn)]

mod agreement;
mod allocation;
mod effects;
mod gait;
mod models;
mod phased_gait;
mod scalars;
mod states;
