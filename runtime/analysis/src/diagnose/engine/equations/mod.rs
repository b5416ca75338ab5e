//! What a search works on: products of everything that may explain a residual, how errors weigh, and what a set of effects costs.
pub(super) mod block_equations;
pub(super) mod candidates;
pub(super) mod fit;
pub(super) mod linearised;
pub(super) mod noise_floor;
pub(super) mod regression;
pub(super) mod resolution;
pub(super) mod smoother;
pub(super) mod weights;
