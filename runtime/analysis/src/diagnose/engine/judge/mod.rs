//! What survives the estimate, what is left, what the data cannot tell apart: the answer.
pub(super) mod alike;
pub(super) mod alternatives;
pub(super) mod conclusion;
pub(super) mod errors;
pub(super) mod exact_rivals;
pub(super) mod own_blocks;
pub(super) mod significance;
pub(super) mod unexplained;
