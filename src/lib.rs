//! Robots ready to be compared, diagnosed, amended, identified, simulated and filmed: compiler and analysis together.
//!
//! [`Workbench`] is where to begin: it opens a robot and its logs, and does with them what the commands of `bipedc` do, whose
//! output its results print as text and as JSON. The rooms behind it work on any [`Robot`]; nothing here prints, every error is a
//! [`Diagnostics`] with file, line and column.
pub mod amendment;
pub mod comparison;
pub mod crate_paths;
pub mod diagnosis;
pub mod excitation;
pub mod export;
pub mod film;
pub mod gait;
pub mod identification;
pub mod inventory;
pub mod kinds;
pub mod measurements;
pub mod progress;
pub mod report;
pub mod robot;
pub mod simulation;
pub mod table;
pub mod walking;
pub mod workbench;

pub use bipedc_compiler::Robot;
pub use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
pub use measurements::Log;
pub use robot::{ProgramRegressor, ProgramTorques, feet, link_inertias};
pub use workbench::Workbench;
