//! From compiled models to Rust tokens: used alike by the command line, the derive macro and build scripts.
mod function;
mod model;
mod package;

pub use model::{Options, model};
pub use package::{Origin, Package, package, type_name};
