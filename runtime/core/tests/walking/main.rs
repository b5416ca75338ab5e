//! How long walking takes.
#![allow(missing_docs)]
mod ground_forces;
