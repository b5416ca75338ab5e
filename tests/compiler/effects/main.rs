//! Effects in the derived functions: against plain numbers, against other rigid bodies, and forwards against
//! backwards.
#![allow(missing_docs)]
mod bodies;
mod slopes;
pub mod support;
mod torques;
