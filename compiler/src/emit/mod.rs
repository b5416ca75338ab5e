//! From compiled models to Rust tokens: used alike by the command line, the derive macro and build scripts.
mod files;
mod function;
mod model;
mod package;
mod program;
mod split;

pub use files::Difference;
pub(crate) use function::ident;
pub use model::{Model, Options, items, model};
pub use package::{Origin, Package, package, type_name};
