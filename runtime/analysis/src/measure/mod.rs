//! What was measured: columns of a log as states of the robot, recorded motions, their noise, motions that repeat themselves.
pub(crate) mod acceleration_noise;
mod base;
pub(crate) mod coloured;
pub(crate) mod columns;
mod content;
pub(crate) mod directions;
pub(crate) mod filtered;
pub(crate) mod jolts;
pub(crate) mod noise;
mod options;
pub(crate) mod recording;
pub(crate) mod repetition;
mod source;
pub(crate) mod stops;
mod thinning;
pub(crate) mod trajectory;

pub use columns::Missing;
pub use content::Content;
pub use directions::{Direction, Directions};
pub use filtered::CUTOFF_HZ;
pub use jolts::Jolts;
pub use options::{CANDIDATES, FIRST, Options, VelocitySource};
pub use recording::Recording;
pub use repetition::{JointPositions, repeats, shared};
pub use source::DataSource;
pub use stops::Stops;
pub use thinning::{HELD, Held};
