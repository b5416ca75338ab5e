//! The answer in sentences.
mod left;
pub(super) mod sentence;
pub(super) mod text;
pub(super) mod told_apart;
