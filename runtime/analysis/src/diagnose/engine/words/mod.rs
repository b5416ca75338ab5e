//! The answer in sentences.
pub(super) mod sentence;
pub(super) mod text;
pub(super) mod told_apart;
