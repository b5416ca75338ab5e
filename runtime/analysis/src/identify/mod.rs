//! Parameters from measurements: what a robot's inertial parameters are, how sure that is, and a set of them that bodies
//! can have (thesis chapter 5 and 8.3).
//!
//! The way of the data: [`survey`] looks at the motions of the logs and finds repetitions, [`Design`] says which
//! unknowns act in which measured row, [`accumulate`] folds all samples into small triangular factors, one per channel
//! and stretch of motion ([`Triangle`]), and everything after that (ordinary and weighted least squares, folds, error
//! bars, essential parameters, physical consistency) works on these factors alone. Memory does not grow with the number
//! of samples (`Feed::Tables`, of experiments in memory, apart).
mod accumulate;
pub mod cop;
mod design;
mod dry_friction;
pub mod elastic;
mod essential;
mod estimate;
pub mod excite;
mod held_out;
mod motions;
pub mod physical;
mod picture;
mod reading;
mod regressor_noise;
mod result;
mod row_cutoff;
mod row_filter;
mod run;
mod summary;
mod survey;
mod triangle;
mod unknowns;

pub use accumulate::{Settings, Sums, Weighting, accumulate, fold, fold_table};
pub use design::{BatchRegressor, Channel, Design, Work};
pub use essential::{Essential, essential};
pub use estimate::{Estimate, Fit, HeldOutError, Method, by_channel, errors, joined};
pub use motions::{Motions, Repetition};
pub use reading::Reading;
pub use result::*;
pub use row_cutoff::{AccelerationSpectrum, LOOKING, signal_cutoff};
pub use run::{Feed, IdentificationResult, Judge, Options, RobotAndLogs, identify, judged};
pub use survey::{Survey, survey};
pub use triangle::Triangle;
pub use unknowns::{
    BaseSet, ColumnSource, Extra, ExtraChoice, ExtraTorque, Law, Summand, Unknown, joint, offered,
};
