//! Parameters from the forces of the ground alone (thesis 5.4): static postures on force plates.
//!
//! At rest the centre of pressure lies below the centre of mass, so every posture gives two equations that are linear in
//! the first moments of the bodies (5.19 to 5.23). Here they are written as moments about the stance sole, N m: the same
//! rows as those of a moving robot (5.26 to 5.29), and a regression whose noise does not depend on the total mass.
//!
//! [`PostureTable`] is the regression, [`check_postures`] what may be wrong with the table, [`simplified`] the thesis'
//! smaller model, [`PressureErrors`] how far centres of pressure are missed, and [`confounded`] which physical causes
//! ground forces cannot tell apart.
mod check;
mod confounded;
mod errors;
mod simplified;
mod table;

pub use check::{TILTED, check_postures, swing_tilt};
pub use confounded::{Cause, Confounded, Pair as ConfoundedPair, confounded};
pub use errors::{PressureErrors, held_out, least_squares, of_parameters, pressure_errors};
pub use simplified::simplified;
pub use table::PostureTable;
