//! A log and how it is read.
use crate::log::Log;
use crate::measure::Options;

/// A log and how it is read.
#[derive(Debug, Clone)]
pub struct Reading<'a> {
    /// The file.
    pub log: &'a Log,
    /// Cut-off, from, to, trim.
    pub options: Options,
}
