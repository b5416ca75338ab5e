//! Which effects stand: one after the other, exchanged for others, simpler ones instead, or beside inertial corrections.
pub(super) mod companions;
pub(super) mod corrected;
pub(super) mod corrections;
pub(super) mod entry;
pub(super) mod exchange;
pub(super) mod forward;
pub(super) mod friction_first;
pub(super) mod impossible;
pub(super) mod in_parts;
pub(super) mod late;
pub(super) mod own_friction;
pub(super) mod parsimony;
pub(super) mod rival;
pub(super) mod weak_friction;
