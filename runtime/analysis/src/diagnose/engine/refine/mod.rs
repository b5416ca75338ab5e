//! Estimates of what a search found by the laws as they are, and how sure they are.
pub(super) mod amended;
#[cfg(test)]
pub(super) mod at_corners;
pub(super) mod behind_motors;
pub(super) mod curved_friction;
pub(super) mod estimates;
pub(super) mod refinement;
pub(super) mod sharp_friction;
pub(super) mod uncertainty;
pub(super) mod unknowns;
