//! Descriptions of robots: every mistake has its message, hostile text does no harm.
#![allow(missing_docs)]
mod files;
mod robots;
mod toml;
mod urdf;
