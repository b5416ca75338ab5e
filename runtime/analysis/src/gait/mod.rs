//! Steps of a gait on its zero dynamics (thesis 6.2.1): which speed a robot on its virtual constraints has at mid-stance of the
//! next step.
//!
//! [`GaitModel`] wraps a model that has the functions of a gait; [`GaitModel::step`] is what a command asks. Everything that can
//! go wrong with a step is a [`Refusal`] among its numbers, no error.
mod alike;
mod choose;
mod course;
mod cycle;
mod functions;
mod hop;
mod integral;
mod kept;
mod landing;
mod map;
mod margins;
mod pair;
mod plan;
mod reach;
mod reason;
mod search;
mod sparing;
mod step;
mod surface;
mod wide;
mod workers;

pub use alike::Alike;
pub use choose::{Choice, ChoiceKind, ChoiceSettings, Chooser};
pub use course::Course;
pub use cycle::{Cycle, NoCycle};
pub use functions::{GaitModel, GaitSettings, spare_joint, spare_velocity};
pub use integral::{Integral, Places};
pub use kept::Kept;
pub use landing::Landing;
pub use map::{Cell, MapRequest};
pub use margins::Margins;
pub use pair::StepPair;
pub use plan::{Plan, PlannedStep};
pub use reach::{Choices, Reach, Unreached};
pub use reason::{Assumptions, Reason};
pub use search::zero;
pub use sparing::{Interpolation, Sparing};
pub use step::{Refusal, Step, ThisStep};
pub use surface::{SurfaceFailure, SurfacePoint};
pub use workers::{Watch, in_parallel};
