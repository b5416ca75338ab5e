//! Measurement files: logs (`time`), static postures (`posture`) and impacts (`impact`), as CSV or gzip CSV.
//!
//! A [`Log`] is a file that was opened: what its columns are is known. Its [`Reader`]s give one row at a time, so memory
//! does not grow with the file; [`Blocks`] cuts a log into overlapping pieces for filtering; [`Table`] holds a small file
//! as a whole; [`RawRows`] gives what stands in a file that nobody understands yet. A [`Mapping`] gives other column names, factors and signs. Units are SI, names those of the URDF; see [`names`] for the columns.
mod beginning;
mod blocks;
mod fields;
mod file;
mod hash;
mod header;
mod in_time;
mod kept;
mod lines;
mod mapping;
pub mod names;
mod pattern;
mod raw;
mod reader;
mod sparse;
mod spikes;
mod table;
mod value;
mod wraps;

pub use blocks::{Block, Blocks, MOST_GAPS, Sampling, SamplingReport, usual_step};
pub use file::Log;
pub use header::{Column, Kind};
pub use in_time::{REACH, Repairs};
pub use lines::{LONGEST_LINE, MOST_BLANK};
pub use mapping::{ForceFrame, MappedColumn, Mapping};
pub use pattern::Pattern;
pub use raw::{Field, RawRow, RawRows};
pub use reader::{Absent, MOST_ERRORS, Reader, Row};
pub use sparse::Sparse;
pub use table::{LARGEST_TABLE, Table};
pub use wraps::Unwrapped;
