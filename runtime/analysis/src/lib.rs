//! The desk: logs, comparison, diagnosis, identification and simulation of any [`Model`](bipedc_runtime::Model).
pub mod compare;
pub mod diagnose;
pub mod experiments;
pub mod gait;
pub mod identify;
pub mod log;
pub mod measure;
pub mod nonlinear;
pub mod number;
pub mod parallel;
pub mod physical;
pub mod polygon;
pub mod report;
pub mod robot;
pub mod signal;
pub mod simulate;
pub mod walking;
