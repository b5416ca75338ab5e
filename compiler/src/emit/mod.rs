//! From compiled models to Rust text: used alike by the command line, the derive macro and build scripts.
mod files;
mod function;
mod gait;
mod layout;
mod model;
mod names;
mod package;
mod packed;
mod program;
mod sizes;
mod split;
mod statements;
mod text;
mod twins;

pub use files::{Difference, is_generated};
pub(crate) use function::ident;
pub use function::pairs_at_once;
pub use gait::{GaitCode, PhasedWalk, WalkedPhase, gait_code, phases_code};
pub(crate) use layout::documentation;
pub use model::{Model, Options, items, model};
pub(crate) use package::robot_type;
pub use package::{CARRIED, Origin, Package, Runtime, package, type_name};
pub(crate) use text::Text;
