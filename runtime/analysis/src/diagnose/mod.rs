//! Which physical effect is missing: candidates are tried against the residual of an [`Experiment`](crate::experiments::Experiment), ranked by
//! their error on held-out data, and reported as a [`Diagnosis`].
//!
//! # Signs and frames of what is measured at the ground
//! - A residual is measured minus predicted, so rows of a moving base are the foot wrenches mapped to the base (`Jᵀ w`)
//!   minus the unactuated rows of inverse dynamics: forces in the log's world axes (N), moments about the origin of
//!   the root in its own axes (N m).
//! - `gravity_tilt`: the true orientation of the base is `R` times the logged one, `R = R_y(pitch) R_x(roll)`; gravity
//!   in the log's world axes is `Rᵀ g`.
//! - `ground_slope`: the ground's axes in the world are `R`. It turns the robot where the sole tells how the base is
//!   oriented (postures without `base/…` columns), where it acts exactly as a tilt does. Where the base's orientation
//!   is logged, it changes none of these rows.
//! - `encoder_offset`: true position = logged − offset.
//! - `force_sensor_gain`, `_bias`: true = reported / gain, true = reported − bias. A logged torque has the gain, but no
//!   bias; a logged centre of pressure is a measurement of its own and has neither.
//! - Ground reaction acts *on* the foot.
pub(crate) mod breakdown;
mod closer;
mod engine;
mod error_fall;
mod result;
mod selected;
mod signature;
pub mod support;

pub use breakdown::{AT_NOISE, Breakdown, BreakdownPart, WINDOWS, Window, breakdowns};
pub use closer::Closer;
pub use engine::{
    Errors, Options, Stated, diagnose, errors, estimate, left_alike, left_by_kind, root_mean_squares, summary,
};
pub use error_fall::{ErrorFall, StepErrors, rises};
pub use result::{Diagnosis, FoundEffect, Rejected, Scope, Seen, Step, Unexplained, intervals};
pub use selected::Selected;
pub use signature::Feature;
