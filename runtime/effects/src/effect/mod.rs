//! Physical effects that a rigid-body model may miss, each defined once.
//!
//! From the one definition ([`Kind`]) come the torque in inverse dynamics (the compiler turns the law into
//! expressions), the part in simulation, the columns of the estimator, and the words of reports. An [`Effect`] is a
//! kind at a place with numbers, as `biped.toml` states it under `[[effect]]`. No tool knows a kind by its name: a new
//! one is a statement in the library and a line in its list.
//!
//! # Signs
//! With `u` the torque that a log reports and `ID` the rigid-body model's inverse dynamics, a law of
//! [`Law::Torque`] is *added*: `u = ID + law`. A law of [`Law::Reading`] maps the true torque to the reported one.
mod bound_law;
pub mod formula;
mod instance;
mod kind;
mod library;
mod relations;
mod search;
mod simulation;
mod sliding;
mod unit_torque;

pub use bound_law::BoundLaw;
pub use instance::{Effect, Location, OwnParameter};
pub use kind::{Acts, Confounder, Identified, Kind, Law, Parameter, Place, Role, Size};
pub use library::{KINDS, VARIABLES, kind, kinds, sought};
pub use relations::Relations;
pub use search::{Columns, Evidence, Parameters, Probe, Search, Starts};
pub use simulation::{Dry, Simulation};
pub use unit_torque::UnitTorque;
