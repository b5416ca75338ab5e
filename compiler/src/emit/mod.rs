//! From compiled models to Rust tokens: used alike by the command line, the derive macro and build scripts.
mod files;
mod function;
mod model;
mod package;
mod program;
mod split;

pub use files::{Difference, is_generated};
pub(crate) use function::ident;
pub use model::{Model, Options, items, model};
pub use package::{CARRIED, Origin, Package, Runtime, package, type_name};
